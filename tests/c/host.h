/* Used by the host_*.c and mpi_*.c programs: a small mesh with a field, contexts that draw it, and process state. */
#ifndef HOST_H
#define HOST_H

#include "check.h"

#define HOST_LAYERS 4

/* A mesh and a field on it. */
typedef struct {
    icoray_mesh *mesh;
    icoray_grid grid;
    icoray_array array;
    float *values;
    int layers;
} World;

World world(int level, int layers);
void end_world(World *w);

/* Initialises an icoray_config with some members. */
#define CONFIG(...) {.struct_size = sizeof(icoray_config), __VA_ARGS__}

/* A config that has a directory and nothing else. */
icoray_config plain(const char *directory);

/* A context with grid, layers, field "f" and the scene below. */
icoray_ctx *opened(const icoray_config *config, const World *w, int pixels);
void set_layers(icoray_ctx *ctx, int layers);

/* The scene of "f" with `keys` at its head, and `rest` behind camera and transfer function. */
void set_view(icoray_ctx *ctx, const char *keys, int width, int height, const char *rest);
/* The scene of "f" whose pictures are frame_{step}.png. */
void set_scene(icoray_ctx *ctx, int pixels, const char *keys);

/* Open files of this process. */
int open_files(void);
double now_s(void);

int is_file(const char *path);
/* Whether a file begins and ends as a complete PNG does. */
int is_whole_png(const char *path);
int same_files(const char *a, const char *b);

/* Prints a line that the Rust test shows. */
void note(const char *format, ...);

#endif
