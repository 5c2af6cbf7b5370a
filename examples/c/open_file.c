/* A scene out of a file, and what lies in the middle of it: open_file bunny.ply */

#include <phalanx_files.h>
#include <stdio.h>
#include <stdlib.h>

static void check(phx_status status) {
    if (status != PHX_OK) {
        fprintf(stderr, "%s\n", phx_error_message());
        exit(1);
    }
}

int main(int argument_count, char **arguments) {
    phx_scene *scene;
    phx_tree *tree;
    check(phx_scene_open(argument_count > 1 ? arguments[1] : "standard:teapot", &scene));
    check(phx_tree_build(scene, NULL, &tree));

    /* From outside its box, to the middle and beyond. */
    float box[6];
    phx_ray ray = {{0, 0, 0}, {0, 0, 0}, INFINITY};
    check(phx_scene_get_bounds(scene, box));
    for (int axis = 0; axis < 3; ++axis) {
        ray.origin[axis] = 2 * box[axis + 3] - box[axis];
        ray.direction[axis] = (box[axis] + box[axis + 3]) / 2 - ray.origin[axis];
    }
    phx_hit hit;
    char name[64];
    check(phx_intersect(tree, &ray, NULL, &hit));
    check(phx_scene_get_name(scene, hit.prim_id, name, sizeof name, NULL));
    if (hit.prim_id == PHX_NONE) {
        puts("there is nothing on the way to the middle");
    } else {
        printf("primitive %u%s%s, %.4f of the way\n", (unsigned)hit.prim_id, name[0] ? " of " : "", name, hit.t);
    }
    check(phx_tree_destroy(tree));
    check(phx_scene_destroy(scene));
}
