/* A mesh, a sphere, one ray, and one shadow ray: what examples/cast_one_ray.rs does, and prints. */

#include <phalanx.h>
#include <stdio.h>
#include <stdlib.h>

/* Ends the program where a call has failed. */
static void check(phx_status status) {
    if (status != PHX_OK) {
        fprintf(stderr, "%s\n", phx_error_message());
        exit(1);
    }
}

int main(void) {
    const float vertices[4][3] = {{-4, 0, -4}, {4, 0, -4}, {4, 0, 4}, {-4, 0, 4}};
    const uint32_t triangles[2][3] = {{0, 2, 1}, {0, 3, 2}};
    const float centers[1][3] = {{1, 2, 0}};
    const float radii[1] = {1};
    const phx_mesh mesh = PHX_MESH(vertices, 4, triangles, 2);
    phx_scene *scene;
    phx_tree *tree;
    uint32_t floor, ball;
    check(phx_scene_create(&scene));
    check(phx_scene_add_mesh(scene, &mesh, &floor));
    check(phx_scene_add_spheres(scene, PHX_ROWS(centers), PHX_ROWS(radii), 1, &ball));
    check(phx_tree_build(scene, NULL, &tree));

    const phx_ray ray = {{0, 4, 6}, {0.1f, -0.7f, -1}, INFINITY};
    phx_hit hit;
    check(phx_intersect(tree, &ray, NULL, &hit));
    if (hit.prim_id == PHX_NONE) {
        puts("the ray hits nothing");
        return 0;
    }
    const char *name = hit.geom_id == floor ? "floor" : hit.geom_id == ball ? "ball" : "something else";
    float point[3];
    for (int axis = 0; axis < 3; ++axis) {
        const float along = hit.t * ray.direction[axis];
        point[axis] = ray.origin[axis] + along;
    }
    printf("hit the %s at t = %.3f: (%.3f, %.3f, %.3f)\n", name, hit.t, point[0], point[1], point[2]);
    printf("primitive %u, u = %.3f, v = %.3f\n", (unsigned)hit.prim_id, hit.u, hit.v);

    /* Slightly above the floor, so that the ray does not hit the floor it starts on. */
    const float light[3] = {3, 8, 0};
    const float above = point[1] + 1e-3f;
    const phx_ray shadow = {{point[0], above, point[2]}, {light[0] - point[0], light[1] - above, light[2] - point[2]}, 1};
    int hidden;
    check(phx_occluded(tree, &shadow, NULL, &hidden));
    printf("the light at [%.1f, %.1f, %.1f] is %s\n", light[0], light[1], light[2], hidden ? "hidden" : "visible");
    check(phx_tree_destroy(tree));
    check(phx_scene_destroy(scene));
}
