// What `treegen inspect --expand` wrote, as geometries of Embree: tetrahedra and triangles as one mesh, the rest as
// user geometry.
#pragma once
#include <embree3/rtcore.h>

#include <fstream>

#include "frustum.hpp"

struct Camera {
    Vec eye, corner, across, down;
    int size;
    float distance;

    // The way through the middle of a pixel.
    Vec through(int x, int y) const { return corner + across * float(x) + down * float(y); }
};

inline Vec vec_of(const Json &json) {
    return {float(json.list[0].number), float(json.list[1].number), float(json.list[2].number)};
}

inline Map map_of(const Json &json) {
    Map map;
    for (int k = 0; k < 12; k++) map[k] = json.list[k / 4].list[k % 4].number;
    return map;
}

inline Camera camera_of(const Json &json) {
    Camera camera;
    camera.size = int(json["size"].list[0].number);
    if (camera.size != int(json["size"].list[1].number) || !json.has("fov"))
        fail("the camera is to be square and in perspective");
    camera.eye = vec_of(json["eye"]);
    Vec view = vec_of(json["target"]) - camera.eye;
    camera.distance = std::sqrt(dot(view, view));
    Vec forward = unit(view), right = unit(cross(forward, vec_of(json["up"]))), up = cross(right, forward);
    float pixel = 2 * std::tan(float(json["fov"].number) * float(M_PI) / 360) / camera.size;
    camera.across = right * pixel;
    camera.down = up * -pixel;
    float middle = (camera.size - 1) / 2.f;
    camera.corner = forward - camera.across * middle - camera.down * middle;
    return camera;
}

// The box around a primitive: exact for spheres and cylinders, whose matrices map axes to conjugate half axes.
inline Box box_of(const Primitive &it) {
    const Map &m = it.world_from_own;
    Box box;
    for (int row = 0; row < 3; row++) {
        double x = std::abs(m[4 * row]), y = std::abs(m[4 * row + 1]), z = m[4 * row + 2], center = m[4 * row + 3];
        double round = std::sqrt(x * x + y * y);
        if (it.shape->name == "sphere") {
            double reach = std::sqrt(x * x + y * y + z * z);
            box.low[row] = center - reach, box.high[row] = center + reach;
        } else if (it.shape->name == "cylinder") {
            box.low[row] = center + std::min(0.0, z) - round, box.high[row] = center + std::max(0.0, z) + round;
        } else {
            double reach = x + y + std::abs(z);
            box.low[row] = center - reach, box.high[row] = center + reach;
        }
    }
    return box;
}

inline RTCBounds bounds_of(const Box &box) {
    RTCBounds bounds{};
    // More than the error of single precision.
    double more = 1e-5 * std::max({box.high[0] - box.low[0], box.high[1] - box.low[1], box.high[2] - box.low[2]});
    bounds.lower_x = float(box.low[0] - more), bounds.upper_x = float(box.high[0] + more);
    bounds.lower_y = float(box.low[1] - more), bounds.upper_y = float(box.high[1] + more);
    bounds.lower_z = float(box.low[2] - more), bounds.upper_z = float(box.high[2] + more);
    return bounds;
}

template <class Item>
struct Bounded {
    Item item;
    RTCBounds bounds;
};

// A file's primitives.
struct Exported {
    Camera camera;
    Vec toward_sun;
    size_t primitives = 0;
    // Corners of triangles, three numbers each, and the triangles' corners.
    std::vector<float> corners;
    std::vector<unsigned> triangles;
    std::vector<Bounded<Primitive>> plain;
    std::vector<Bounded<Frustum>> frusta;
    std::vector<Bounded<Solid>> solids;
    // The maps of tetrahedra, when they stand for instances of another file.
    std::vector<Map> instances;

    Exported(const std::string &path, bool tetrahedra_are_instances) {
        std::ifstream file(path);
        if (!file) fail("cannot read " + path);
        reserve(file, tetrahedra_are_instances);
        for (std::string line; std::getline(file, line);) {
            Json json = JsonReader(line).value();
            const std::string &kind = json["kind"].text;
            if (kind == "camera") {
                camera = camera_of(json);
            } else if (kind == "sun") {
                toward_sun = unit(vec_of(json["direction"])) * -1;
            } else if (kind != "sky" && kind != "material") {
                add(json, kind, tetrahedra_are_instances);
            }
        }
    }

private:
    // Room for all at once: growing would take twice as much, and the peak of memory is one of the results.
    void reserve(std::ifstream &file, bool tetrahedra_are_instances) {
        size_t tetrahedra = 0, flat = 0;
        for (std::string line; std::getline(file, line);) {
            tetrahedra += line.rfind("{\"kind\":\"tetrahedron\"", 0) == 0;
            flat += line.rfind("{\"kind\":\"triangle\"", 0) == 0;
        }
        if (tetrahedra_are_instances) {
            instances.reserve(tetrahedra);
            tetrahedra = 0;
        }
        // Embree reads 16 bytes where 12 are used.
        corners.reserve(tetrahedra * 12 + flat * 9 + 4);
        triangles.reserve(tetrahedra * 12 + flat * 3);
        file.clear();
        file.seekg(0);
    }

    void add(const Json &json, const std::string &kind, bool tetrahedra_are_instances) {
        if (json.has("operands")) {
            primitives += count(json);
            Solid solid(json);
            solids.push_back({solid, bounds_of(Bounds(solid).box)});
            return;
        }
        primitives++;
        Map map = map_of(json["world_from_primitive"]);
        if (kind == "tetrahedron" && tetrahedra_are_instances) {
            instances.push_back(map);
        } else if (kind == "tetrahedron") {
            add_mesh(map, {{{1, 1, 1}, {-1, -1, 1}, {1, -1, -1}, {-1, 1, -1}}}, 4, {0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2},
                     12);
        } else if (kind == "triangle") {
            add_mesh(map, {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}, 3, {0, 1, 2}, 3);
        } else if (kind == "segment") {
            Frustum frustum(json["parameters"], map);
            frusta.push_back({frustum, bounds_of(frustum.box)});
        } else if (const Shape *shape = shape_of(kind)) {
            Primitive primitive(shape, map);
            plain.push_back({primitive, bounds_of(box_of(primitive))});
        } else {
            fail("`" + kind + "` is more than this program knows");
        }
    }

    void add_mesh(const Map &map, std::array<Vec, 4> points, int point_count, std::array<unsigned, 12> faces,
                  int face_count) {
        unsigned first = unsigned(corners.size() / 3);
        for (int k = 0; k < point_count; k++) {
            for (double part : apply(map, points[k].x, points[k].y, points[k].z)) corners.push_back(float(part));
        }
        for (int k = 0; k < face_count; k++) triangles.push_back(first + faces[k]);
    }

    static size_t count(const Json &json) {
        if (!json.has("operands")) return 1;
        size_t sum = 0;
        for (const Json &operand : json["operands"].list) {
            for (const Json &member : operand.list) sum += count(member);
        }
        return sum;
    }
};

// The first surface of a primitive beyond `near` and before `far`.
inline bool first_surface(const Primitive &it, const Ray &ray, float near, float far, float &t, Vec &normal) {
    Span span;
    if (!it.span(ray, 0, span)) return false;
    bool enters = span.near > near;
    t = enters ? span.near : span.far;
    if (t <= near || t >= far) return false;
    normal = it.normal(ray, t, enters ? span.near_surface : span.far_surface);
    return true;
}

inline bool first_surface(const Frustum &it, const Ray &ray, float near, float far, float &t, Vec &normal) {
    Span span;
    if (!it.span(ray, span)) return false;
    bool enters = span.near > near;
    t = enters ? span.near : span.far;
    if (t <= near || t >= far) return false;
    normal = it.normal(ray, t, enters ? span.near_surface : span.far_surface);
    return true;
}

inline bool first_surface(const Solid &it, const Ray &ray, float near, float far, float &t, Vec &normal) {
    return it.hit(ray, near, far, t, normal);
}

inline Ray ray_of(RTCRayN *rays, unsigned n, unsigned i) {
    return {{RTCRayN_org_x(rays, n, i), RTCRayN_org_y(rays, n, i), RTCRayN_org_z(rays, n, i)},
            {RTCRayN_dir_x(rays, n, i), RTCRayN_dir_y(rays, n, i), RTCRayN_dir_z(rays, n, i)}};
}

// What Embree asks of a list of solids.
template <class Item>
struct Callbacks {
    static const Bounded<Item> &item(void *items, unsigned number) {
        return (*static_cast<std::vector<Bounded<Item>> *>(items))[number];
    }

    static void bounds(const RTCBoundsFunctionArguments *arguments) {
        *arguments->bounds_o = item(arguments->geometryUserPtr, arguments->primID).bounds;
    }

    static void intersect(const RTCIntersectFunctionNArguments *arguments) {
        const Item &solid = item(arguments->geometryUserPtr, arguments->primID).item;
        RTCRayN *rays = RTCRayHitN_RayN(arguments->rayhit, arguments->N);
        RTCHitN *hits = RTCRayHitN_HitN(arguments->rayhit, arguments->N);
        unsigned n = arguments->N;
        for (unsigned i = 0; i < n; i++) {
            if (!arguments->valid[i]) continue;
            float near = RTCRayN_tnear(rays, n, i), &far = RTCRayN_tfar(rays, n, i), t;
            Vec normal;
            if (!first_surface(solid, ray_of(rays, n, i), near, far, t, normal)) continue;
            far = t;
            RTCHitN_Ng_x(hits, n, i) = normal.x;
            RTCHitN_Ng_y(hits, n, i) = normal.y;
            RTCHitN_Ng_z(hits, n, i) = normal.z;
            RTCHitN_geomID(hits, n, i) = arguments->geomID;
            RTCHitN_primID(hits, n, i) = arguments->primID;
        }
    }

    static void occluded(const RTCOccludedFunctionNArguments *arguments) {
        const Item &solid = item(arguments->geometryUserPtr, arguments->primID).item;
        RTCRayN *rays = arguments->ray;
        unsigned n = arguments->N;
        for (unsigned i = 0; i < n; i++) {
            if (!arguments->valid[i]) continue;
            float near = RTCRayN_tnear(rays, n, i), &far = RTCRayN_tfar(rays, n, i), t;
            Vec normal;
            if (first_surface(solid, ray_of(rays, n, i), near, far, t, normal))
                far = -std::numeric_limits<float>::infinity();
        }
    }

    static void attach(RTCDevice device, RTCScene scene, std::vector<Bounded<Item>> &items) {
        if (items.empty()) return;
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(geometry, unsigned(items.size()));
        rtcSetGeometryUserData(geometry, &items);
        rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
        rtcSetGeometryIntersectFunction(geometry, intersect);
        rtcSetGeometryOccludedFunction(geometry, occluded);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene, geometry);
        rtcReleaseGeometry(geometry);
    }
};

// A committed scene of a file's primitives. It uses the memory of `exported`.
inline RTCScene scene_of(RTCDevice device, Exported &exported) {
    RTCScene scene = rtcNewScene(device);
    if (!exported.triangles.empty()) {
        RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, exported.corners.data(), 0, 12,
                                   exported.corners.size() / 3);
        rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, exported.triangles.data(), 0, 12,
                                   exported.triangles.size() / 3);
        rtcCommitGeometry(mesh);
        rtcAttachGeometry(scene, mesh);
        rtcReleaseGeometry(mesh);
    }
    Callbacks<Primitive>::attach(device, scene, exported.plain);
    Callbacks<Frustum>::attach(device, scene, exported.frusta);
    Callbacks<Solid>::attach(device, scene, exported.solids);
    rtcCommitScene(scene);
    return scene;
}

// A committed scene of instances of another.
inline RTCScene scene_of_instances(RTCDevice device, RTCScene base, const std::vector<Map> &maps) {
    RTCScene scene = rtcNewScene(device);
    for (const Map &map : maps) {
        RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(instance, base);
        float rows[12];
        std::copy(map.begin(), map.end(), rows);
        rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, rows);
        rtcCommitGeometry(instance);
        rtcAttachGeometry(scene, instance);
        rtcReleaseGeometry(instance);
    }
    rtcCommitScene(scene);
    return scene;
}
