/* The part that a rank has of a mesh distributed over ranks, cut out of the whole mesh. */
#ifndef MPI_CUT_H
#define MPI_CUT_H

#include "mpi_common.h"

/* One rank's part: its own cells, a halo, and nothing beyond. */
typedef struct {
    icoray_grid grid;
    icoray_part part;
    icoray_array center, corner; /* fields; not a number but in own cells and in corners whose first cell is own */
    void *kept[16];              /* what the structs point at */
    int count;
} Cut;

/*
 * The part of the rank that owns the cells with the owner `mine`. Ranks declare it in different forms: first cells or
 * marks, 32 or 64 bits, counted from 0 or 1, three marks of missing entries. Without a halo there are own cells only.
 */
Cut cut(const World *w, const int *owner, int mine, int has_halo);
void end_cut(Cut *c);

/* Gives a context the grid, layers and fields "f" (of the centres) and "v" (of the corners) of a part, but not the part. */
void fill_cut(icoray_ctx *ctx, const Cut *c, int layers);

/* A field at all corners of a mesh, to be freed. */
float *corner_values(const World *w);

/* The owner of each cell of a mesh, to be freed; NULL where the kind makes no sense for so few ranks. */
enum { CONTIGUOUS, RANDOM, SINGLE_CELL, NO_CELL, PARTITIONS };
int *partition(const World *w, int kind, int of);

#endif
