// Times the ray functions that Mitsuba calls, whichever libembree3.so answers them.
//
// Preloaded, it stands before that library and hands each call on; so both libraries are timed by the
// same clock, and neither knows of it. Ticks are the CPU's counter, of constant rate.

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <dlfcn.h>
#include <mutex>
#include <vector>
#if defined(__x86_64__)
#include <x86intrin.h>
#endif

#define EXPORT __attribute__((visibility("default")))

namespace {

uint64_t ticks() {
#if defined(__x86_64__)
    return __rdtsc();
#else
    return static_cast<uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
#endif
}

double seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// The sums of one thread: written by it alone, and read once its work is done.
struct alignas(64) Tally {
    uint64_t calls = 0, rays = 0, ticks = 0;
};

std::mutex tallies_lock;
std::vector<Tally *> tallies;

Tally &tally() {
    // Kept when its thread ends, so that nothing is lost.
    thread_local Tally *const mine = [] {
        auto *tally = new Tally;
        const std::lock_guard<std::mutex> lock(tallies_lock);
        tallies.push_back(tally);
        return tally;
    }();
    return *mine;
}

// Calls are handed on uncounted until ray_timer_start().
bool counting = false;
uint64_t first_tick;
double first_second;

void *next(const char *name) {
    void *library = dlopen("libembree3.so", RTLD_NOW | RTLD_NOLOAD);
    void *function = library ? dlsym(library, name) : nullptr;
    if (!function) {
        std::fprintf(stderr, "ray_timer: libembree3.so has no %s\n", name);
        std::abort();
    }
    return function;
}

template <class Call> void timed(unsigned rays, Call call) {
    if (!counting)
        return call();
    Tally &mine = tally();
    const uint64_t start = ticks();
    call();
    mine.ticks += ticks() - start;
    mine.calls++;
    mine.rays += rays;
}

unsigned count(const int *valid, unsigned n) {
    unsigned rays = 0;
    for (unsigned i = 0; i < n; i++)
        rays += valid[i] != 0;
    return rays;
}

} // namespace

struct RayTimes {
    uint64_t calls, rays;
    double seconds, clock;
};

// Starts counting, from zero. No rays may be on their way.
extern "C" EXPORT void ray_timer_start() {
    const std::lock_guard<std::mutex> lock(tallies_lock);
    for (Tally *tally : tallies)
        *tally = Tally{};
    first_tick = ticks();
    first_second = seconds();
    counting = true;
}

// Sums over threads since then. `clock`: seconds that two readings of the clock take, as for a call.
extern "C" EXPORT void ray_timer_stop(RayTimes *times) {
    counting = false;
    const double tick = (seconds() - first_second) / static_cast<double>(ticks() - first_tick);
    const std::lock_guard<std::mutex> lock(tallies_lock);
    uint64_t sum = 0;
    *times = RayTimes{};
    for (const Tally *tally : tallies) {
        times->calls += tally->calls;
        times->rays += tally->rays;
        sum += tally->ticks;
    }
    times->seconds = static_cast<double>(sum) * tick;
    constexpr int ROUNDS = 1000000;
    volatile uint64_t sink = 0;
    const uint64_t start = ticks();
    for (int i = 0; i < ROUNDS; i++)
        sink = sink + ticks() - ticks();
    times->clock = static_cast<double>(ticks() - start) / ROUNDS * tick;
}

namespace mitsuba {

struct RTCSceneTy;
struct RTCIntersectContext;

#define SINGLE(FUNCTION, RAYS, NAME) \
    struct RAYS; \
    EXPORT void FUNCTION(RTCSceneTy *scene, RTCIntersectContext *context, RAYS *rays) { \
        static const auto call = reinterpret_cast<decltype(&FUNCTION)>(next(NAME)); \
        timed(1, [&] { call(scene, context, rays); }); \
    }
#define PACKET(FUNCTION, RAYS, N, NAME) \
    struct RAYS; \
    EXPORT void FUNCTION(const int *valid, RTCSceneTy *scene, RTCIntersectContext *context, RAYS *rays) { \
        static const auto call = reinterpret_cast<decltype(&FUNCTION)>(next(NAME)); \
        timed(count(valid, N), [&] { call(valid, scene, context, rays); }); \
    }

SINGLE(rtcIntersect1, RTCRayHit,
       "_ZN7mitsuba13rtcIntersect1EPNS_10RTCSceneTyEPNS_19RTCIntersectContextEPNS_9RTCRayHitE")
SINGLE(rtcOccluded1, RTCRay, "_ZN7mitsuba12rtcOccluded1EPNS_10RTCSceneTyEPNS_19RTCIntersectContextEPNS_6RTCRayE")
PACKET(rtcIntersect4, RTCRayHit4, 4,
       "_ZN7mitsuba13rtcIntersect4EPKiPNS_10RTCSceneTyEPNS_19RTCIntersectContextEPNS_10RTCRayHit4E")
PACKET(rtcIntersect8, RTCRayHit8, 8,
       "_ZN7mitsuba13rtcIntersect8EPKiPNS_10RTCSceneTyEPNS_19RTCIntersectContextEPNS_10RTCRayHit8E")
PACKET(rtcIntersect16, RTCRayHit16, 16,
       "_ZN7mitsuba14rtcIntersect16EPKiPNS_10RTCSceneTyEPNS_19RTCIntersectContextEPNS_11RTCRayHit16E")
PACKET(rtcOccluded4, RTCRay4, 4,
       "_ZN7mitsuba12rtcOccluded4EPKiPNS_10RTCSceneTyEPNS_19RTCIntersectContextEPNS_7RTCRay4E")
PACKET(rtcOccluded8, RTCRay8, 8,
       "_ZN7mitsuba12rtcOccluded8EPKiPNS_10RTCSceneTyEPNS_19RTCIntersectContextEPNS_7RTCRay8E")
PACKET(rtcOccluded16, RTCRay16, 16,
       "_ZN7mitsuba13rtcOccluded16EPKiPNS_10RTCSceneTyEPNS_19RTCIntersectContextEPNS_8RTCRay16E")

} // namespace mitsuba
