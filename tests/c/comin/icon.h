/* Domains such as ICON's, of an icosahedral mesh that is spread over ranks, and fields at their triangles. */
#ifndef ICON_H
#define ICON_H

#include "icoray.h"

enum { NPROMA = 7, LEVELS = 5, VARIABLES = 4, ALL_VARIABLES = 8 };

/* Where values are; the numbers are ComIn's. */
enum { AT_TRIANGLES = 1, AT_EDGES, AT_VERTICES };

/* A domain on one rank. Tables are in blocks of NPROMA; values of halo triangles and of padding are NaN. */
typedef struct {
    int triangles, vertices, blocks, vertex_blocks, all_triangles;
    int *vertex_index, *vertex_block; /* (NPROMA, blocks, 3) */
    int *global_index, *decomposition;
    double *lon_triangle, *lat_triangle, *lon_vertex, *lat_vertex;
    double *heights; /* (NPROMA, LEVELS + 1, blocks) */
} icon_domain;

/* A variable: temp on full levels, w on half levels, ps with one value per column, and qv on full levels. Behind these
 * VARIABLES are vn at edges, omega_z at vertices, few, which has a block less than there are of triangles, and many, which is
 * at edges and has no metadata of that. */
typedef struct {
    const char *name;
    int levels; /* 0: none */
    int place;
    const char *long_name, *units;
} icon_variable;
extern const icon_variable icon_variables[ALL_VARIABLES];

/* Heights of half levels over flat ground, from the top. */
extern const double icon_half_levels[LEVELS + 1];

/* Domain 1 is the sphere; domain 2 is a finer cap around the north pole. */
icon_domain icon_make(int number, int rank, int ranks);
double icon_height(double lon, double lat, int level);
double icon_value(int variable, double lon, double lat, int level, int step);

/* The values of a variable as ICON has them: those of `step` at own triangles or at vertices. */
void icon_fill(const icon_domain *domain, int variable, int step, double *values);
int icon_values(const icon_domain *domain, int variable);
int icon_blocks(const icon_domain *domain, const icon_variable *variable);

/* The date of a step of half an hour since 2026-02-28T12:00. */
void icon_date(int step, char date[48]);

#endif
