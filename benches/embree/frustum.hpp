// A segment of a stem: what lies inside a cone about z between two planes, as `treegen inspect --expand` writes it.
#pragma once
#include "bounds.hpp"

struct Frustum {
    // Inside x² + y² <= (radius + slope z)², z >= lean x, z <= top + rise_x x + rise_y y.
    float radius, slope, lean, top, rise_x, rise_y;
    Vec center;
    // Maps directions, and points from the center, to the segment's own frame.
    std::array<float, 9> own_from_world;
    Box box;

    Frustum(const Json &parameters, const Map &map) {
        std::array<double, 6> numbers;
        for (int k = 0; k < 6; k++) numbers[k] = parameters.list[k].number;
        radius = float(numbers[0]), slope = float(numbers[1]), lean = float(numbers[2]);
        top = float(numbers[3]), rise_x = float(numbers[4]), rise_y = float(numbers[5]);
        center = {float(map[3]), float(map[7]), float(map[11])};
        Map back = inverse(map);
        for (int k = 0; k < 9; k++) own_from_world[k] = float(back[4 * (k / 3) + k % 3]);
        double infinity = std::numeric_limits<double>::infinity();
        box.low.fill(infinity);
        box.high.fill(-infinity);
        cover(numbers, map, 0, numbers[2], 0);
        cover(numbers, map, numbers[3], numbers[4], numbers[5]);
    }

    Vec to_own(Vec v) const {
        const auto &m = own_from_world;
        return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z,
                m[6] * v.x + m[7] * v.y + m[8] * v.z};
    }

    // Where the ray is inside, and by which surfaces it comes and goes: 0 round, 1 below, 2 above. False when it is nowhere.
    bool span(const Ray &ray, Span &span) const {
        Vec p = to_own(ray.origin - center), d = to_own(ray.direction);
        // From its point nearest to the middle of the axis, since far away single precision sees nothing of it.
        Vec from_middle = {p.x, p.y, p.z - top / 2};
        float shift = -dot(from_middle, d) / dot(d, d);
        p = p + d * shift;
        float w = radius + slope * p.z, speed = slope * d.z;
        float a = d.x * d.x + d.y * d.y - speed * speed, b = p.x * d.x + p.y * d.y - w * speed;
        float c = p.x * p.x + p.y * p.y - w * w, root = b * b - a * c;
        if (root < 0 || a <= 0) {
            if (a > 0) return false;
            return steep(p, d, a, b, root, shift, span);
        }
        root = std::sqrt(root);
        return between((-b - root) / a, (-b + root) / a, p, d, shift, span);
    }

    Vec normal(const Ray &ray, float t, int surface) const {
        Vec own = surface == 1 ? Vec{lean, 0, -1} : Vec{-rise_x, -rise_y, 1};
        if (surface == 0) {
            Vec at = to_own(ray.origin + ray.direction * t - center);
            own = {at.x, at.y, -slope * (radius + slope * at.z)};
        }
        const auto &m = own_from_world;
        return {m[0] * own.x + m[3] * own.y + m[6] * own.z, m[1] * own.x + m[4] * own.y + m[7] * own.z,
                m[2] * own.x + m[5] * own.y + m[8] * own.z};
    }

private:
    // Both ends of a segment lie on one nappe, so its lines are those between two closed curves.
    void cover(const std::array<double, 6> &numbers, const Map &map, double height, double x, double y) {
        const int steps = 256;
        for (int k = 0; k < steps; k++) {
            double c = std::cos(2 * M_PI * k / steps), s = std::sin(2 * M_PI * k / steps);
            double out = (numbers[0] + numbers[1] * height) / (1 - numbers[1] * (x * c + y * s));
            // A polygon around the curve.
            double wide = std::max(out, 0.0) / std::cos(M_PI / steps);
            std::array<double, 3> at = apply(map, wide * c, wide * s, height + wide * (x * c + y * s));
            for (int row = 0; row < 3; row++) {
                box.low[row] = std::min(box.low[row], at[row]);
                box.high[row] = std::max(box.high[row], at[row]);
            }
        }
    }

    // A ray steeper than the cone meets each nappe once; the planes leave the right one.
    bool steep(Vec p, Vec d, float a, float b, float root, float shift, Span &span) const {
        float infinity = std::numeric_limits<float>::infinity();
        if (a == 0 || root < 0) return between(-infinity, infinity, p, d, shift, span);
        root = std::sqrt(root);
        float first = (-b + root) / a, second = (-b - root) / a;
        float w = radius + slope * (p.z + d.z * second);
        if (slope * d.z > 0 ? w >= 0 : w < 0) return between(second, infinity, p, d, shift, span);
        return between(-infinity, first, p, d, shift, span);
    }

    bool between(float near, float far, Vec p, Vec d, float shift, Span &span) const {
        int near_surface = 0, far_surface = 0;
        const float distances[2] = {p.z - lean * p.x, top + rise_x * p.x + rise_y * p.y - p.z};
        const float speeds[2] = {lean * d.x - d.z, d.z - rise_x * d.x - rise_y * d.y};
        for (int k = 0; k < 2; k++) {
            float t = distances[k] / speeds[k];
            if (speeds[k] < 0) {
                if (t > near) near = t, near_surface = k + 1;
            } else if (t < far) {
                far = t, far_surface = k + 1;
            }
        }
        span = {near + shift, far + shift, near_surface, far_surface};
        return near < far;
    }
};
