/* Used by the pictures_*.c files: a mesh, fields on it, and contexts that draw them. */
#ifndef PICTURES_H
#define PICTURES_H

#include "check.h"

#define LAYERS 4
#define PLANET 6371220.0

extern icoray_mesh *mesh;
extern icoray_grid grid;
extern int cells, corners, pixels;
extern const double radius[LAYERS];

/* Figures that frame() expects of a report: bytes copied, 0 unless a thread draws, and failures so far. */
extern uint64_t copy_expected, failures_expected;

/* Makes the mesh of this level. */
void make_mesh(int level);

/* The tests' field at a cell's center, exact in a float. */
float center_value(int column, int layer);

/* An array between other values, which must not affect a picture. */
typedef struct {
    void *memory, *before;
    size_t bytes;
    icoray_array array;
} Field;

/* An array's type, location and strides. */
icoray_array shaped(int type, int location, int layers, int64_t column_stride, int64_t layer_stride);

/* Fills an array of `elements`, over a grid, in which value (0, 0) is element `first`; between them lies garbage. */
Field filled(const icoray_grid *on, icoray_array shape, size_t elements, size_t first);

/* The same over the grid of most tests: without blocks, and in blocks of whole layers. */
Field field(int type, int location, int layers, size_t elements, size_t first, int64_t column_stride,
            int64_t layer_stride);
Field blocked(int type, int location, int layers, int64_t block);

/* Gives one element this value, or every one. */
void put(Field *f, int64_t at, double value);
void scribble(Field *f, double value);

/* Frees the arrays of fields, and checks that the library has not written to them. */
void release(Field *f);
void release_all(Field *fields, int count);

/* Bytes of its values. */
uint64_t bytes_of(const Field *f);

/* A context with grid and layers, whose pictures go to directory/name. */
icoray_ctx *context(const char *directory, const char *name, int with_threads);
icoray_ctx *context_with(const char *directory, const char *name, icoray_config config);
icoray_layers layers_of(const double *radius_m, const char *name);

/* The scene of a group, and frames of it, written: of the field that was set, and of another. */
void scene(icoray_ctx *ctx, const char *group, const char *light);
void scene_of(icoray_ctx *ctx, const char *name, const char *group, const char *light);
icoray_frame_report frame(icoray_ctx *ctx, int step);
icoray_frame_report frame_of(icoray_ctx *ctx, int step, const Field *f);
/* A scene and its frame. */
icoray_frame_report picture(icoray_ctx *ctx, const char *group, const char *light, int step, const Field *f);

/* The pictures of the files pictures_*.c. */
typedef void Part(const char *directory);
Part layouts, ndarrays, in_place, swapped, missing, places, tables, names, by_turns, at_once, fields, background;

#endif
