// A thousand instances that turn, a tree that follows, and rays on several threads while it does.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <phalanx.h>
#include <thread>
#include <vector>

static void check(phx_status status) {
    if (status != PHX_OK) {
        std::fprintf(stderr, "%s\n", phx_error_message());
        std::exit(1);
    }
}

int main() {
    const float corners[3][3] = {{-0.4f, -0.4f, 0}, {0.4f, -0.4f, 0}, {0, 0.4f, 0}};
    const uint32_t triangles[1][3] = {{0, 1, 2}};
    const phx_mesh blade = PHX_MESH(corners, 3, triangles, 1);
    phx_scene *scene;
    phx_tree *shown, *next;
    uint32_t prototype;
    check(phx_scene_create(&scene));
    check(phx_scene_add_prototype(scene, &blade, &prototype));
    std::vector<uint32_t> blades(1000);
    const auto place = [](int k, double turn) {
        // Turned about the vertical axis, in a grid of forty by twenty-five.
        const double c = std::cos(turn), s = std::sin(turn), x = k % 40, y = k / 40;
        return std::vector<double>{c, 0, s, x, 0, 1, 0, y, -s, 0, c, 0};
    };
    for (int k = 0; k < 1000; ++k) {
        check(phx_scene_add_instance(scene, prototype, place(k, 0).data(), &blades[k]));
    }
    check(phx_tree_build(scene, nullptr, &shown));
    check(phx_tree_clone(shown, &next));

    for (int frame = 1; frame <= 4; ++frame) {
        // One tree is queried while the other follows the scene.
        size_t met = 0;
        std::thread query([&] {
            for (int k = 0; k < 4000; ++k) {
                const phx_ray ray = {{k % 200 * 0.2f, k / 200 * 1.25f, 9}, {0, 0, -1}, INFINITY};
                phx_hit hit;
                check(phx_intersect(shown, &ray, nullptr, &hit));
                met += hit.prim_id != PHX_NONE;
            }
        });
        for (int k = 0; k < 1000; ++k) {
            check(phx_scene_set_transform(scene, blades[k], place(k, frame * 0.3 + k).data()));
        }
        // The third time it is built anew, while the other one answers.
        phx_update_settings settings = {sizeof settings, frame == 3 ? PHX_UPDATE_REBUILD : PHX_UPDATE_AUTO};
        phx_update_result result = {};
        result.size = sizeof result;
        check(phx_tree_update(next, scene, &settings, &result));
        query.join();
        const char *work[] = {"nothing done", "refitted", "built anew"};
        std::printf("frame %d: %zu of 4000 rays hit, next %s\n", frame, met, work[result.work]);
        std::swap(shown, next);
    }
    check(phx_tree_destroy(shown));
    check(phx_tree_destroy(next));
    check(phx_scene_destroy(scene));
}
