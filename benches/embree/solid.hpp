// Solids that a ray meets analytically: convex primitives, and Booleans of them.
#pragma once
#include <limits>
#include <string>
#include <vector>

#include "json.hpp"
#include "vector.hpp"

// A ray in single precision.
struct Ray {
    Vec origin, direction;
};

// A convex primitive: one quadric x² + y² + c z² <= 1 at most, and some half-spaces n·p <= d, in its own frame.
struct Shape {
    std::string name;
    bool round;
    float square_z;
    int planes;
    Vec normals[6];
    float distances[6];
};

constexpr float CORNER = 0.57735026919f;
inline const Shape SHAPES[] = {
    {"sphere", true, 1, 0, {}, {}},
    {"cylinder", true, 0, 2, {{0, 0, -1}, {0, 0, 1}}, {0, 1}},
    {"box", false, 0, 6, {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}, {1, 1, 1, 1, 1, 1}},
    {"tetrahedron",
     false,
     0,
     4,
     {{-CORNER, -CORNER, -CORNER}, {CORNER, CORNER, -CORNER}, {-CORNER, CORNER, CORNER}, {CORNER, -CORNER, CORNER}},
     {CORNER, CORNER, CORNER, CORNER}},
};

inline const Shape *shape_of(const std::string &kind) {
    for (const Shape &shape : SHAPES) {
        if (shape.name == kind) return &shape;
    }
    return nullptr;
}

// A stretch of a ray inside a solid, each end with the surface it crosses there: the primitive's number * 8 + 0 for the
// quadric, or 1 + the number of the plane.
struct Span {
    float near, far;
    int near_surface, far_surface;
};

// A primitive in the world.
struct Primitive {
    const Shape *shape;
    Map world_from_own;
    Vec center;
    // Maps directions, and points from the center, to the primitive's own frame.
    std::array<float, 9> own_from_world;

    Primitive(const Shape *shape, const Map &map) : shape(shape), world_from_own(map) {
        center = {float(map[3]), float(map[7]), float(map[11])};
        Map back = inverse(map);
        for (int k = 0; k < 9; k++) own_from_world[k] = float(back[4 * (k / 3) + k % 3]);
    }

    Vec to_own(Vec v) const {
        const auto &m = own_from_world;
        return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z,
                m[6] * v.x + m[7] * v.y + m[8] * v.z};
    }

    // Where the ray is inside; false when it is nowhere.
    bool span(const Ray &ray, int number, Span &span) const {
        Vec p = to_own(ray.origin - center), d = to_own(ray.direction);
        // From its point nearest to the primitive's origin, since far away single precision sees nothing of it.
        float shift = -dot(p, d) / dot(d, d);
        p = p + d * shift;
        float near = -std::numeric_limits<float>::infinity(), far = -near;
        int near_surface = 0, far_surface = 0;
        if (shape->round) {
            float c = shape->square_z;
            float a = d.x * d.x + d.y * d.y + c * d.z * d.z, b = p.x * d.x + p.y * d.y + c * p.z * d.z;
            float root = b * b - a * (p.x * p.x + p.y * p.y + c * p.z * p.z - 1);
            if (root < 0) return false;
            root = std::sqrt(root);
            near = (-b - root) / a;
            far = (-b + root) / a;
        }
        for (int k = 0; k < shape->planes; k++) {
            float speed = dot(shape->normals[k], d);
            float t = (shape->distances[k] - dot(shape->normals[k], p)) / speed;
            if (speed < 0) {
                if (t > near) near = t, near_surface = k + 1;
            } else if (t < far) {
                far = t, far_surface = k + 1;
            }
        }
        span = {near + shift, far + shift, number * 8 + near_surface, number * 8 + far_surface};
        return near < far;
    }

    // The normal in the world, of any length, where the ray crosses a surface.
    Vec normal(const Ray &ray, float t, int surface) const {
        Vec own;
        if (surface > 0) {
            own = shape->normals[surface - 1];
        } else {
            own = to_own(ray.origin + ray.direction * t - center);
            own.z *= shape->square_z;
        }
        const auto &m = own_from_world;
        return {m[0] * own.x + m[3] * own.y + m[6] * own.z, m[1] * own.x + m[4] * own.y + m[7] * own.z,
                m[2] * own.x + m[5] * own.y + m[8] * own.z};
    }
};

// Some spans of a ray, in order.
struct Spans {
    static constexpr int MOST = 16;
    int count = 0;
    Span spans[MOST];

    void add(Span span) {
        if (count == MOST) fail("a ray goes in and out of a solid too often");
        spans[count++] = span;
    }
};

inline void intersect(const Spans &a, const Spans &b, Spans &both) {
    for (int i = 0, j = 0; i < a.count && j < b.count;) {
        const Span &one = a.spans[i], &other = b.spans[j];
        Span span = one;
        if (other.near > span.near) span.near = other.near, span.near_surface = other.near_surface;
        if (other.far < span.far) span.far = other.far, span.far_surface = other.far_surface;
        if (span.near < span.far) both.add(span);
        (one.far < other.far ? i : j)++;
    }
}

inline void subtract(const Spans &a, const Spans &b, Spans &rest) {
    for (int i = 0; i < a.count; i++) {
        Span left = a.spans[i];
        for (int j = 0; j < b.count && left.near < left.far; j++) {
            const Span &cut = b.spans[j];
            if (cut.far <= left.near || cut.near >= left.far) continue;
            if (cut.near > left.near) rest.add({left.near, cut.near, left.near_surface, cut.near_surface});
            left.near = cut.far;
            left.near_surface = cut.far_surface;
        }
        if (left.near < left.far) rest.add(left);
    }
}

inline void unite(const Spans &a, const Spans &b, Spans &all) {
    for (int i = 0, j = 0; i < a.count || j < b.count;) {
        bool first = j == b.count || (i < a.count && a.spans[i].near <= b.spans[j].near);
        const Span &next = first ? a.spans[i++] : b.spans[j++];
        Span *last = all.count > 0 ? &all.spans[all.count - 1] : nullptr;
        if (last == nullptr || next.near > last->far) {
            all.add(next);
        } else if (next.far > last->far) {
            last->far = next.far;
            last->far_surface = next.far_surface;
        }
    }
}

// A Boolean of primitives. Its nodes lie in one list, the operands before what combines them.
struct Solid {
    enum class Kind { Primitive, Union, Intersection, Difference };
    struct Node {
        Kind kind;
        // The number of the primitive, or of two other nodes.
        int first, second;
    };
    std::vector<Primitive> primitives;
    std::vector<Node> nodes;

    explicit Solid(const Json &json) { add(json); }

    // The first surface beyond `near` and before `far`.
    bool hit(const Ray &ray, float near, float far, float &t, Vec &normal) const {
        Spans spans;
        find(int(nodes.size()) - 1, ray, spans);
        for (int k = 0; k < spans.count; k++) {
            const Span &span = spans.spans[k];
            bool enters = span.near > near;
            t = enters ? span.near : span.far;
            if (t <= near) continue;
            if (t >= far) return false;
            int surface = enters ? span.near_surface : span.far_surface;
            normal = primitives[surface / 8].normal(ray, t, surface % 8);
            return true;
        }
        return false;
    }

private:
    int add(const Json &json) {
        const std::string &kind = json["kind"].text;
        if (json.has("operands")) {
            Kind combine = kind == "intersection" ? Kind::Intersection : Kind::Difference;
            int all = -1;
            for (const Json &operand : json["operands"].list) {
                int one = add_union(operand.list);
                all = all < 0 ? one : add({combine, all, one});
            }
            return all;
        }
        const Shape *shape = shape_of(kind);
        if (shape == nullptr) fail("`" + kind + "` in a Boolean is more than this program knows");
        Map map;
        for (int k = 0; k < 12; k++) map[k] = json["world_from_primitive"].list[k / 4].list[k % 4].number;
        primitives.emplace_back(shape, map);
        return add({Kind::Primitive, int(primitives.size()) - 1, 0});
    }

    int add_union(const std::vector<Json> &members) {
        if (members.empty()) fail("an empty operand is more than this program knows");
        int all = -1;
        for (const Json &member : members) {
            int one = add(member);
            all = all < 0 ? one : add({Kind::Union, all, one});
        }
        return all;
    }

    int add(Node node) {
        nodes.push_back(node);
        return int(nodes.size()) - 1;
    }

    void find(int number, const Ray &ray, Spans &spans) const {
        const Node &node = nodes[number];
        if (node.kind == Kind::Primitive) {
            Span span;
            if (primitives[node.first].span(ray, node.first, span)) spans.add(span);
            return;
        }
        Spans first, second;
        find(node.first, ray, first);
        if (first.count == 0 && node.kind != Kind::Union) return;
        find(node.second, ray, second);
        switch (node.kind) {
            case Kind::Union:
                return unite(first, second, spans);
            case Kind::Intersection:
                return intersect(first, second, spans);
            default:
                return subtract(first, second, spans);
        }
    }
};
