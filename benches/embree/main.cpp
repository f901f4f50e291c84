// Renders what `treegen inspect --expand` wrote with Embree 3, on one thread: one ray through the middle of each pixel,
// and one to the sun from what faces it. Prints what it took as a line of JSON.
//
//     embree SCENE.json WIDTH FRAMES                  all in one scene
//     embree SCENE.json WIDTH FRAMES INSTANCES.json   a copy of the scene in the place of each tetrahedron of INSTANCES
//
// WIDTH is how many rays go together: 1, 8 or 16. The structure is built before; of the frames, after one that does not
// count, it tells the median.
#include <pmmintrin.h>
#include <time.h>
#include <xmmintrin.h>

#include "scene.hpp"

struct Counts {
    size_t hits = 0, shadow = 0, blocked = 0;
};

static double cpu_seconds() {
    timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

// The most memory that this process has held at once. What getrusage says begins with the process that started this
// one.
static double peak_rss_mb() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);) {
        if (line.rfind("VmHWM:", 0) == 0) return std::strtod(line.c_str() + 6, nullptr) / 1024;
    }
    return 0;
}

template <int K>
struct Packet;

template <>
struct Packet<16> {
    using RayHit = RTCRayHit16;
    using Shadow = RTCRay16;
    static constexpr int width = 4, height = 4;
    static void intersect(const int *valid, RTCScene scene, RTCIntersectContext *context, RayHit *rays) {
        rtcIntersect16(valid, scene, context, rays);
    }
    static void occluded(const int *valid, RTCScene scene, RTCIntersectContext *context, Shadow *rays) {
        rtcOccluded16(valid, scene, context, rays);
    }
};

template <>
struct Packet<8> {
    using RayHit = RTCRayHit8;
    using Shadow = RTCRay8;
    static constexpr int width = 4, height = 2;
    static void intersect(const int *valid, RTCScene scene, RTCIntersectContext *context, RayHit *rays) {
        rtcIntersect8(valid, scene, context, rays);
    }
    static void occluded(const int *valid, RTCScene scene, RTCIntersectContext *context, Shadow *rays) {
        rtcOccluded8(valid, scene, context, rays);
    }
};

// A packet of one, in the layout of the others.
struct RayHit1 {
    struct {
        float org_x[1], org_y[1], org_z[1], tnear[1], dir_x[1], dir_y[1], dir_z[1], time[1], tfar[1];
        unsigned mask[1], id[1], flags[1];
    } ray;
    struct {
        float Ng_x[1], Ng_y[1], Ng_z[1], u[1], v[1];
        unsigned primID[1], geomID[1], instID[RTC_MAX_INSTANCE_LEVEL_COUNT][1];
    } hit;
};

struct alignas(16) Shadow1 {
    float org_x[1], org_y[1], org_z[1], tnear[1], dir_x[1], dir_y[1], dir_z[1], time[1], tfar[1];
    unsigned mask[1], id[1], flags[1];
};

static_assert(sizeof(RTCRay) == sizeof(Shadow1), "a ray of Embree has another layout");

template <>
struct Packet<1> {
    using RayHit = RayHit1;
    using Shadow = Shadow1;
    static constexpr int width = 1, height = 1;

    static void intersect(const int *, RTCScene scene, RTCIntersectContext *context, RayHit *rays) {
        RTCRayHit one;
        std::copy_n(reinterpret_cast<const char *>(&rays->ray), sizeof(RTCRay), reinterpret_cast<char *>(&one.ray));
        one.hit.geomID = one.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene, context, &one);
        rays->ray.tfar[0] = one.ray.tfar;
        rays->hit.Ng_x[0] = one.hit.Ng_x;
        rays->hit.Ng_y[0] = one.hit.Ng_y;
        rays->hit.Ng_z[0] = one.hit.Ng_z;
        rays->hit.geomID[0] = one.hit.geomID;
    }

    static void occluded(const int *valid, RTCScene scene, RTCIntersectContext *context, Shadow *rays) {
        if (valid[0] != 0) rtcOccluded1(scene, context, reinterpret_cast<RTCRay *>(rays));
    }
};

template <class Rays>
static void set(Rays &rays, int lane, Vec origin, Vec direction, float near) {
    rays.org_x[lane] = origin.x, rays.org_y[lane] = origin.y, rays.org_z[lane] = origin.z;
    rays.dir_x[lane] = direction.x, rays.dir_y[lane] = direction.y, rays.dir_z[lane] = direction.z;
    rays.tnear[lane] = near, rays.tfar[lane] = std::numeric_limits<float>::infinity();
    rays.mask[lane] = ~0u, rays.flags[lane] = 0, rays.time[lane] = 0;
}

// The pixels of one packet, shaded into the picture.
template <int K>
static void packet(RTCScene scene, RTCIntersectContext &context, const Camera &camera, Vec sun, int left, int top,
                   float *picture, Counts &counts) {
    using P = Packet<K>;
    // Far less than a pixel, and more than the error of a hit.
    float aside = 3e-6f * camera.distance;
    alignas(64) typename P::RayHit rays;
    alignas(64) typename P::Shadow shadows;
    alignas(64) int all[K], lit[K];
    float shades[K];
    for (int i = 0; i < K; i++) {
        all[i] = -1;
        set(rays.ray, i, camera.eye, camera.through(left + i % P::width, top + i / P::width), 0);
        rays.hit.geomID[i] = rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    P::intersect(all, scene, &context, &rays);
    bool any = false;
    for (int i = 0; i < K; i++) {
        bool hit = rays.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
        counts.hits += hit;
        Vec direction{rays.ray.dir_x[i], rays.ray.dir_y[i], rays.ray.dir_z[i]};
        Vec normal = unit({rays.hit.Ng_x[i], rays.hit.Ng_y[i], rays.hit.Ng_z[i]});
        if (dot(normal, direction) > 0) normal = normal * -1;
        float cosine = hit ? dot(normal, sun) : 0;
        bool faces = hit && cosine > 0;
        lit[i] = faces ? -1 : 0;
        shades[i] = faces ? cosine : 0;
        any = any || faces;
        counts.shadow += faces;
        // Embree looks at rays that do not ask, too, where it takes sixteen as twice eight.
        Vec start = faces ? camera.eye + direction * rays.ray.tfar[i] + normal * aside : camera.eye;
        set(shadows, i, start, sun, aside);
    }
    if (any) P::occluded(lit, scene, &context, &shadows);
    for (int i = 0; i < K; i++) {
        bool blocked = lit[i] != 0 && shadows.tfar[i] < 0;
        counts.blocked += blocked;
        picture[(top + i / P::width) * camera.size + left + i % P::width] = blocked ? 0 : shades[i];
    }
}

template <int K>
static Counts frame(RTCScene scene, const Camera &camera, Vec sun, float *picture) {
    constexpr int TILE = 16;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    Counts counts;
    for (int y = 0; y < camera.size; y += TILE) {
        for (int x = 0; x < camera.size; x += TILE) {
            for (int top = y; top < y + TILE; top += Packet<K>::height) {
                for (int left = x; left < x + TILE; left += Packet<K>::width)
                    packet<K>(scene, context, camera, sun, left, top, picture, counts);
            }
        }
    }
    return counts;
}

int main(int count, char **arguments) {
    if (count != 4 && count != 5) fail("embree SCENE.json WIDTH FRAMES [INSTANCES.json]");
    int width = std::atoi(arguments[2]), frames = std::atoi(arguments[3]);
    bool instanced = count == 5;
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
    Exported exported(arguments[1], false);
    std::vector<Map> copies;
    if (instanced) copies = Exported(arguments[4], true).instances;
    if (exported.camera.size % 16 != 0) fail("the size of the picture is to be a multiple of 16");

    RTCDevice device = rtcNewDevice("threads=1");
    double start = cpu_seconds();
    RTCScene scene = scene_of(device, exported);
    if (instanced) scene = scene_of_instances(device, scene, copies);
    double build = cpu_seconds() - start;
    if (rtcGetDeviceError(device) != RTC_ERROR_NONE) fail("Embree cannot build the scene");

    auto render = width == 16 ? frame<16> : width == 8 ? frame<8> : frame<1>;
    std::vector<float> picture(size_t(exported.camera.size) * exported.camera.size);
    Counts counts = render(scene, exported.camera, exported.toward_sun, picture.data());
    std::vector<double> times;
    for (int k = 0; k < frames; k++) {
        double before = cpu_seconds();
        render(scene, exported.camera, exported.toward_sun, picture.data());
        times.push_back(cpu_seconds() - before);
    }
    std::sort(times.begin(), times.end());
    double seconds = times[times.size() / 2];
    size_t rays = picture.size() + counts.shadow;
    size_t primitives = exported.primitives * (instanced ? copies.size() : 1);
    std::printf(
        "{\"primitives\":%zu,\"camera\":%zu,\"shadow\":%zu,\"hits\":%zu,\"blocked\":%zu,\"build_cpu_s\":%.4f,\"later_"
        "cpu_s\":%.5f,\"later_mrays_s_core\":%.3f,\"peak_rss_mb\":%.1f}\n",
        primitives, picture.size(), counts.shadow, counts.hits, counts.blocked, build, seconds,
        double(rays) / seconds / 1e6, peak_rss_mb());
}
