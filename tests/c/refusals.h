/* What the parts of the refusals share: things that are good, to spoil one part of, and a context that has them. */
#ifndef REFUSALS_H
#define REFUSALS_H

#include "check.h"

#include <stddef.h>

#define COUNT(table) (sizeof(table) / sizeof(table)[0])
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

/* Of the CPU, so that the log is the same on all machines. */
#define SCENE(field, distance, file)                                                                \
    "field = \"" field "\"\nbackend = \"cpu\"\n"                                                   \
    "[image]\nwidth = 16\nheight = 16\n"                                                            \
    "[camera]\nlon = 10\nlat = 40\ndistance = " distance "\n"                                       \
    "[transfer]\nmap = \"viridis\"\nrange = [0, 2]\nopacity = [[0, 0.1], [2, 0.9]]\n"               \
    "[output]\nfile = \"" file "\"\n"

extern const char good_scene[];

char *path_of(char *buffer, size_t size, const char *name);
int write_file(const char *path, const char *text);
int file_exists(const char *name);

/* The file has just this text; it is a picture. */
int file_is(const char *name, const char *text);
int is_picture(const char *name);

/* The file has these words somewhere. */
int says(const char *name, const char *words);

/* Offset and size of a member, for put(), which writes a number of that size there. */
#define MEMBER(type, name) offsetof(type, name), sizeof(((type *)0)->name)
void put(void *structure, size_t offset, size_t size, int64_t value);

/* Makes the good things, and frees them. */
void prepare(const char *output_dir);
void clean_up(void);

/* A context without anything, and one that can draw. */
icoray_ctx *opened(void);
icoray_ctx *filled(void);
icoray_ctx *filled_with(const icoray_config *config);

icoray_frame_report report_of(icoray_ctx *ctx);

/* The context draws what it drew before: always the same picture. */
void still_draws(icoray_ctx *ctx);

/* The parts. Each leaves the context as it was. */

/* refusals_calls.c */
void nulls(icoray_ctx *ctx);
void struct_sizes(icoray_ctx *ctx);
void misaligned(icoray_ctx *ctx);
void openings(void);
void messages(icoray_ctx *ctx);

/* refusals_grid.c */
void grids(icoray_ctx *ctx);

/* refusals_tables.c */
void bad_tables(icoray_ctx *ctx);
void wide_tables(icoray_ctx *ctx);
void bad_places(icoray_ctx *ctx);

/* refusals_parts.c */
void grid_parts(icoray_ctx *ctx);

/* refusals_fields.c */
void layers(icoray_ctx *ctx);
void arrays(icoray_ctx *ctx);
void misfits(icoray_ctx *ctx);

/* refusals_ndarrays.c */
void ndarrays(icoray_ctx *ctx);
void ndarrays_too_early(void);

/* refusals_heights.c */
void heights(icoray_ctx *ctx);

/* refusals_long.c */
void long_messages(void);
void given_and_refused(void);

/* refusals_names.c */
void names(icoray_ctx *ctx);

/* refusals_scene.c */
void scenes(icoray_ctx *ctx);
void empty_scenes(void);

/* refusals_wants.c */
void wants(icoray_ctx *ctx);

/* refusals_execute.c */
void order(void);
void times(icoray_ctx *ctx);
void dates(icoray_ctx *ctx);
void restarts(void);
void error_maps(icoray_ctx *ctx);

/* refusals_files.c */
void existing(void);
void overwritten(void);
void in_the_way(void);
void blocked(void);

/* refusals_late.c */
void told_once(void);
void dropped(void);

/* refusals_off.c */
void switched_off(void);

/* refusals_entry.c */
void busy(void);
void forked(void);

/* refusals_levels.c */
void time_levels(void);

/* refusals_log.c */
void logged(void);
void standard_error(void);

#endif
