/*
 * Used by all parts of the refusals: a valid grid, layers, array and config, of which a test makes one member invalid,
 * and contexts that have them. Compiles as C99 and as C++11.
 */
#ifndef REFUSALS_H
#define REFUSALS_H

#include "check.h"

#include <stddef.h>

#define NO_UTF8 "caf\xe9"
#define LEVEL 1
#define LAYERS 3

extern icoray_mesh *mesh;
extern icoray_grid good_grid;
extern icoray_layers good_layers;
extern icoray_array good_array;
extern icoray_config good_config;
extern const double radius[LAYERS];
extern float *values;
extern const char *directory;
extern uint64_t expected_copy; /* bytes of each frame: 0 but where the background draws */

/* A scene for the CPU, so that the log is the same on all machines. */
#define NAMELESS_SCENE(field, distance)                                                                                \
    "field = \"" field "\"\nbackend = \"cpu\"\n"                                                                       \
    "[image]\nwidth = 16\nheight = 16\n"                                                                               \
    "[camera]\nlon = 10\nlat = 40\ndistance = " distance "\n"                                                          \
    "[transfer]\nmap = \"viridis\"\nrange = [0, 2]\nopacity = [[0, 0.1], [2, 0.9]]\n"
#define SCENE(field, distance, file) NAMELESS_SCENE(field, distance) "[output]\nfile = \"" file "\"\n"

extern const char good_scene[];

/* The path of a file in the output directory: see path_of(). */
const char *in_output(const char *name);
int write_file(const char *path, const char *text);
int file_exists(const char *name);

/* Whether a file has exactly this text; whether it is a PNG. */
int file_is(const char *name, const char *text);
int is_picture(const char *name);

/* Whether a file contains these words. */
int says(const char *name, const char *words);

/* Offset and size of a member, for put(), which writes a number of that size there. */
#define MEMBER(type, name) offsetof(type, name), sizeof(((type *)0)->name)
void put(void *structure, size_t offset, size_t size, int64_t value);

/* Checks that a call is refused where a copy of good_`kind`, named `kind`, has this value in a member. */
#define REFUSED_WITH(kind, member, value, error, part, call)                                                           \
    do {                                                                                                               \
        icoray_##kind kind = good_##kind;                                                                              \
        kind.member = (value);                                                                                         \
        provoke(ctx);                                                                                                  \
        refused((call), ICORAY_ERR_##error, ctx, (part), #call, HERE);                                                 \
    } while (0)

/* Checks that no frame is drawn, at a step of which no part has a picture. */
#define NOT_DRAWN(ctx, error, part) \
    (provoke(ctx), refused(icoray_execute(ctx, 4321, 0.0, NULL), ICORAY_ERR_##error, ctx, part, "icoray_execute", HERE))

/* Makes the valid structs, and frees what they point to. */
void prepare(const char *output_dir);
void clean_up(void);

/* A context in which nothing is set, and contexts that can draw. */
icoray_ctx *opened(void);
icoray_ctx *filled(void);
icoray_ctx *filled_with(const icoray_config *config);
icoray_ctx *filled_async(int is_async);
/* One that logs to `log`, at this level and below. */
icoray_ctx *filled_logging(icoray_config config, icoray_log_fn log, void *user, int32_t level);

/* Checks that a context draws a frame, with the same counts in each call. */
void still_draws(icoray_ctx *ctx);

/* The parts that share a context, and leave it able to draw: see the files refusals_*.c. */
typedef void Part(icoray_ctx *ctx);
Part nulls, struct_sizes, misaligned, messages, grids, bad_tables, wide_tables, bad_places, grid_parts, layers, arrays,
    misfits, ndarrays, heights, names, scenes, wants, times, dates, error_maps;

/* The parts that open contexts of their own. */
typedef void LonePart(void);
LonePart openings, ndarrays_too_early, long_messages, given_and_refused, fields_of_scenes, empty_scenes, order, restarts,
    existing, overwritten, in_the_way, blocked, returned_once, dropped, switched_off, busy, forked, time_levels, logged,
    standard_error;

#endif
