// tinybvh's fastest tree for CPUs, as its speed test builds it, behind three functions in C.
//
//     c++ -std=c++20 -Ofast -march=native -shared -fPIC -I TINYBVH perf/calls/tinybvh.cpp -o libtinybvh.so
#define TINYBVH_IMPLEMENTATION
#define INST_IDX_BITS 10
#include "tiny_bvh.h"

using tinybvh::bvhvec3;
using tinybvh::bvhvec4;

extern "C" void *tiny_build(const bvhvec4 *corners, uint32_t triangle_count) {
    auto *bvh = new tinybvh::BVH8_CPU();
    bvh->BuildHQ(corners, triangle_count);
    return bvh;
}

extern "C" int tiny_intersect(const void *bvh, const float *origin, const float *direction, float tmax, float *t, uint32_t *prim) {
    tinybvh::Ray ray(bvhvec3(origin[0], origin[1], origin[2]), bvhvec3(direction[0], direction[1], direction[2]), tmax);
    static_cast<const tinybvh::BVH8_CPU *>(bvh)->Intersect(ray);
    *t = ray.hit.t;
    *prim = ray.hit.prim;
    return ray.hit.t < tmax;
}

extern "C" int tiny_occluded(const void *bvh, const float *origin, const float *direction, float tmax) {
    const tinybvh::Ray ray(bvhvec3(origin[0], origin[1], origin[2]), bvhvec3(direction[0], direction[1], direction[2]), tmax);
    return static_cast<const tinybvh::BVH8_CPU *>(bvh)->IsOccluded(ray);
}
