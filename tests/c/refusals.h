/* What the parts of the refusals share: things that are good, to spoil one part of, and a context that has them. */
#ifndef REFUSALS_H
#define REFUSALS_H

#include "check.h"

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

#define SCENE(field, distance, file)                                                                \
    "field = \"" field "\"\n"                                                                       \
    "[image]\nwidth = 16\nheight = 16\n"                                                            \
    "[camera]\nlon = 10\nlat = 40\ndistance = " distance "\n"                                       \
    "[transfer]\nmap = \"viridis\"\nrange = [0, 2]\nopacity = [[0, 0.1], [2, 0.9]]\n"               \
    "[output]\nfile = \"" file "\"\n"

extern const char good_scene[];

char *path_of(char *buffer, size_t size, const char *name);
int write_file(const char *path, const char *text);
int file_exists(const char *name);

/* Makes the good things, and frees them. */
void prepare(const char *output_dir);
void clean_up(void);

/* A context without anything, and one that can draw. */
icoray_ctx *opened(void);
icoray_ctx *filled(void);

/* The context draws what it drew before: always the same picture. */
void still_draws(icoray_ctx *ctx);

/* The parts. Each leaves the context as it was. */

/* refusals_calls.c */
void nulls(icoray_ctx *ctx);
void struct_sizes(icoray_ctx *ctx);
void openings(void);
void messages(icoray_ctx *ctx);

/* refusals_grid.c */
void grids(icoray_ctx *ctx);
void bad_tables(icoray_ctx *ctx);

/* refusals_fields.c */
void layers(icoray_ctx *ctx);
void arrays(icoray_ctx *ctx);
void misfits(icoray_ctx *ctx);

/* refusals_scene.c */
void scenes(icoray_ctx *ctx);

/* refusals_execute.c */
void order(void);
void dates(icoray_ctx *ctx);
void error_maps(icoray_ctx *ctx);
void blocked(void);

#endif
