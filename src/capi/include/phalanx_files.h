/**
 * @file phalanx_files.h
 * @brief Scenes out of files, for programs that link libphalanx_files: it has all that libphalanx has, and readers of scene files.
 * Link one of the two: their objects are not each other's.
 */
#ifndef PHALANX_FILES_H
#define PHALANX_FILES_H

#include <phalanx.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Use phx_scene_open(), which says the version of the header. */
phx_status phx_scene_open_for(uint32_t version, const char *name, phx_scene **scene);

/**
 * Opens a scene: a file of a known format (OBJ, PLY, STL, glTF, .test, ...), a scene cache (.phx), or a standard scene
 * ("standard:dragon:100k"). What it holds has geometry numbers only where phalanx has added it; names are those of the file.
 * @param name in UTF-8
 * @param[out] scene to be destroyed by the caller
 */
static inline phx_status phx_scene_open(const char *name, phx_scene **scene) {
    return phx_scene_open_for(PHX_VERSION, name, scene);
}

#ifdef __cplusplus
}
#endif

#endif
