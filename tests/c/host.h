/* What the programs about the host share: a small world to draw, contexts that draw it, and a look at the process. */
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

/* All zero but the directory, for the caller to change. */
icoray_config plain(const char *directory);

/* A context with grid, layers, field "f" and the scene below. */
icoray_ctx *opened(const icoray_config *config, const World *w, int pixels);
void set_layers(icoray_ctx *ctx, int layers);

/* Draws "f" into frame_{step}.png; `more` are lines at the head of the scene. */
void set_scene(icoray_ctx *ctx, int pixels, const char *more);

icoray_frame_report report_of(icoray_ctx *ctx);

/* Entries of a directory, or of them those that hold `part`. */
int entries(const char *directory, const char *part);
/* Threads of this process, at the latest after a second: the system takes a moment to forget one that was joined. */
int settles_at(int threads);
int threads_now(void);
int open_files(void);
void rest_ms(int ms);
double now_s(void);

/* directory/name, in one of four places that are used in turn. */
const char *path_of(const char *directory, const char *name);
int is_file(const char *path);
/* Whether a file is a PNG from its first byte to its last. */
int is_whole_png(const char *path);
int same_files(const char *a, const char *b);

/* A line that the test shows. */
void note(const char *format, ...);

#endif
