// How fast Embree answers the rays that `raymini bench --write FOLDER` has written, for docs/speed.md.
//
//   embree FOLDER high|medium robust|default REPEATS
//
// prints one line of JSON: seconds to build on all threads, bytes, and for each ray file the rays per microsecond of one thread's processor
// time, one ray at a time and sixteen together (coherent), the median and the ends of the repeats. Hits are counted, to be compared with those
// that `raymini bench` counts.

#include <embree3/rtcore.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <time.h>
#include <vector>

namespace {

[[noreturn]] void fail(const std::string &what) {
    std::fprintf(stderr, "%s\n", what.c_str());
    std::exit(1);
}

std::vector<char> read(const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) fail(path + ": cannot be read");
    return {std::istreambuf_iterator<char>(file), {}};
}

struct Mesh {
    std::vector<float> positions;
    std::vector<uint32_t> corners;
};

// Binary little-endian PLY of float x y z and triangles of int, as `--write` writes it.
Mesh read_mesh(const std::string &path) {
    const std::vector<char> bytes = read(path);
    const std::string text(bytes.begin(), bytes.end());
    const auto count = [&](const char *element) {
        const std::size_t at = text.find(element);
        if (at == std::string::npos) fail(path + ": no " + element);
        return static_cast<std::size_t>(std::atoll(text.c_str() + at + std::strlen(element)));
    };
    const std::size_t vertices = count("element vertex "), faces = count("element face ");
    const char *from = bytes.data() + text.find("end_header\n") + 11;
    if (from + 12 * vertices + 13 * faces != bytes.data() + bytes.size()) fail(path + ": not as --write writes it");
    Mesh mesh{std::vector<float>(3 * vertices), std::vector<uint32_t>(3 * faces)};
    std::memcpy(mesh.positions.data(), from, 12 * vertices);
    from += 12 * vertices;
    for (std::size_t face = 0; face < faces; ++face, from += 13) std::memcpy(&mesh.corners[3 * face], from + 1, 12);
    return mesh;
}

struct Ray {
    float origin[3], direction[3], end;
};

// NPY of float32, shape (n, 7).
std::vector<Ray> read_rays(const std::string &path) {
    const std::vector<char> bytes = read(path);
    uint16_t header;
    std::memcpy(&header, bytes.data() + 8, 2);
    std::vector<Ray> rays((bytes.size() - 10 - header) / sizeof(Ray));
    std::memcpy(rays.data(), bytes.data() + 10 + header, rays.size() * sizeof(Ray));
    return rays;
}

double thread_seconds() {
    timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void put(RTCRay &to, const Ray &ray) {
    to = {};
    to.org_x = ray.origin[0], to.org_y = ray.origin[1], to.org_z = ray.origin[2];
    to.dir_x = ray.direction[0], to.dir_y = ray.direction[1], to.dir_z = ray.direction[2];
    to.tfar = ray.end;
    to.mask = ~0u;
}

std::size_t one_by_one(RTCScene scene, const std::vector<Ray> &rays, bool any) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    std::size_t hits = 0;
    for (const Ray &ray : rays) {
        RTCRayHit query;
        put(query.ray, ray);
        if (any) {
            rtcOccluded1(scene, &context, &query.ray);
            hits += query.ray.tfar < 0;
        } else {
            query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
            rtcIntersect1(scene, &context, &query);
            hits += query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        }
    }
    return hits;
}

std::size_t sixteen_together(RTCScene scene, const std::vector<Ray> &rays) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    std::size_t hits = 0;
    for (std::size_t first = 0; first < rays.size(); first += 16) {
        alignas(64) RTCRayHit16 query;
        alignas(64) int valid[16];
        for (std::size_t lane = 0; lane < 16; ++lane) {
            const bool is_there = first + lane < rays.size();
            valid[lane] = is_there ? -1 : 0;
            const Ray &ray = rays[is_there ? first + lane : first];
            query.ray.org_x[lane] = ray.origin[0];
            query.ray.org_y[lane] = ray.origin[1];
            query.ray.org_z[lane] = ray.origin[2];
            query.ray.dir_x[lane] = ray.direction[0];
            query.ray.dir_y[lane] = ray.direction[1];
            query.ray.dir_z[lane] = ray.direction[2];
            query.ray.tnear[lane] = 0;
            query.ray.tfar[lane] = ray.end;
            query.ray.time[lane] = 0;
            query.ray.mask[lane] = ~0u;
            query.ray.flags[lane] = 0;
            query.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
        }
        rtcIntersect16(valid, scene, &context, &query);
        for (std::size_t lane = 0; lane < 16; ++lane) hits += valid[lane] && query.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID;
    }
    return hits;
}

template <typename Trace>
void print_rate(const char *name, std::size_t rays, int repeats, Trace trace) {
    std::vector<double> rates;
    std::size_t hits = 0;
    for (int turn = 0; turn < repeats; ++turn) {
        const double start = thread_seconds();
        hits = trace();
        rates.push_back(1e-6 * static_cast<double>(rays) / (thread_seconds() - start));
    }
    std::sort(rates.begin(), rates.end());
    std::printf("\"%s\": {\"hits\": %zu, \"mrays\": %.4f, \"least\": %.4f, \"most\": %.4f}", name, hits, rates[rates.size() / 2], rates.front(),
                rates.back());
}

}  // namespace

int main(int count, char **words) {
    if (count != 5) fail("usage: embree FOLDER high|medium robust|default REPEATS");
    const std::string folder = words[1], quality = words[2], mode = words[3];
    const int repeats = std::max(1, std::atoi(words[4]));
    const Mesh mesh = read_mesh(folder + "/mesh.ply");

    RTCDevice device = rtcNewDevice(nullptr);
    std::size_t bytes = 0;
    rtcSetDeviceMemoryMonitorFunction(
        device,
        [](void *sum, ssize_t more, bool) {
            *static_cast<std::size_t *>(sum) += static_cast<std::size_t>(more);
            return true;
        },
        &bytes);
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneBuildQuality(scene, quality == "high" ? RTC_BUILD_QUALITY_HIGH : RTC_BUILD_QUALITY_MEDIUM);
    rtcSetSceneFlags(scene, mode == "robust" ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    const std::size_t vertices = mesh.positions.size() / 3, faces = mesh.corners.size() / 3;
    void *buffer = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, vertices);
    std::memcpy(buffer, mesh.positions.data(), 12 * vertices);
    buffer = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, faces);
    std::memcpy(buffer, mesh.corners.data(), 12 * faces);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    const std::size_t given = bytes;
    const auto start = std::chrono::steady_clock::now();
    rtcCommitScene(scene);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    std::printf("{\"quality\": \"%s\", \"mode\": \"%s\", \"triangles\": %zu, \"build_seconds\": %.4f, \"bytes\": %zu", quality.c_str(),
                mode.c_str(), faces, seconds.count(), bytes - given);

    for (const char *name : {"camera", "bounce", "occlusion_shadow", "lights_shadow"}) {
        const std::vector<Ray> rays = read_rays(folder + "/" + name + ".npy");
        const bool any = std::strstr(name, "_shadow") != nullptr;
        std::printf(", ");
        print_rate(name, rays.size(), repeats, [&] { return one_by_one(scene, rays, any); });
        if (std::strcmp(name, "camera") == 0) {
            std::printf(", ");
            print_rate("camera_packets", rays.size(), repeats, [&] { return sixteen_together(scene, rays); });
        }
    }
    std::printf("}\n");
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
}
