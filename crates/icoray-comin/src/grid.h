/* A domain of ICON as icoray's tables. ICON's vertices are icoray's cells, and its triangles are the corners. */
#ifndef ICORAY_COMIN_GRID_H
#define ICORAY_COMIN_GRID_H

#include "host.h"
#include "icoray.h"

/* The tables of a domain; the context borrows them until it is closed. */
typedef struct {
    host_domain domain;
    char name[8]; /* of grid and layers: empty for domain 1, else such as "DOM02" */
    int64_t cells, edges;
    double *lon_cell, *lat_cell;
    int32_t *corner_cell, *corner_edge, *edge_corner, *cell_corner, *cell_corner_count;
    int64_t cell_corner_row;
    int64_t *cell_number, *corner_number;
    int32_t *owns_cell, *owns_corner;
    int64_t own_corners;
} grid_tables;

/* Makes the tables of a domain. Returns 0 if there is no memory. */
int grid_make(grid_tables *grid, int domain);
void grid_free(grid_tables *grid);

/* Fill the arguments of icoray_grid_set and icoray_part_set. */
void grid_describe(const grid_tables *grid, icoray_grid *to);
void grid_describe_part(const grid_tables *grid, icoray_part *to);

#endif
