/* Used by mpi_columns.c: the columns that a rank has over the tables of the whole grid, at cells and at corners. */
#ifndef MPI_COLUMNS_H
#define MPI_COLUMNS_H

#include "mpi_cut.h"

#include <math.h>

/* Arrays with columns on ranks: two fields and heights; only the last scene shows the second field and the heights. */
enum { F, G, HEIGHTS, KINDS_OF_VALUES };

/* The columns of one rank, in any order. */
typedef struct {
    icoray_part part;
    icoray_array array; /* of the first field; the others lie alike */
    int64_t *cell;
    int32_t *global, *is_owned;
    float *values, *all[KINDS_OF_VALUES];
    icoray_array corner_array; /* of a field at corners; the heights there lie alike */
    int64_t *corner;
    int32_t *corner_global, *is_corner_owned;
    float *at_corners[2];
} Mine;

/*
 * Columns at corners: numbered ones from the last to the first, whose owners have nothing to do with those of cells, on odd
 * ranks with some others; or all corners, of which those are own whose first cell is.
 */
static void add_corners(Mine *m, const World *w, const int *owner, int is_numbered)
{
    const int32_t *corner_cell = w->grid.corner_cell;
    size_t corners = (size_t)w->grid.corners;
    int64_t count = 0;
    m->corner = calloc(corners, sizeof *m->corner);
    m->corner_global = calloc(corners, sizeof *m->corner_global);
    m->is_corner_owned = calloc(corners, sizeof *m->is_corner_owned);
    for (int64_t i = 0; i < (int64_t)corners; i++) {
        int64_t c = is_numbered ? (int64_t)corners - 1 - i : i;
        int is_own = is_numbered ? 7 * c % ranks == rank : owner[corner_cell[3 * c]] == rank;
        if (is_own || !is_numbered || (rank % 2 == 1 && c % 5 == 0)) {
            m->corner[count] = c;
            m->corner_global[count] = (int32_t)c + w->grid.index_base;
            m->is_corner_owned[count++] = is_own;
        }
    }
    m->corner_array = w->array;
    m->corner_array.location = ICORAY_CORNER;
    m->corner_array.columns = count;
    for (int k = 0; k < 2; k++) {
        m->at_corners[k] = calloc((size_t)(count * w->layers) + 1, sizeof **m->at_corners);
    }
    m->corner_array.data = m->at_corners[0];
    if (is_numbered) {
        m->part.corners = count;
        m->part.corner_global = m->corner_global;
        m->part.is_corner_owned = m->is_corner_owned;
    }
}

/* Own columns from the last to the first; on odd ranks with a halo of all cells that share a corner with them. */
static Mine mine_of(const World *w, const int *owner, int is_numbered)
{
    const int32_t *corner_cell = w->grid.corner_cell;
    size_t cells = (size_t)w->grid.cells;
    char *has = calloc(cells, 1);
    Mine m = {0};
    m.cell = calloc(cells, sizeof *m.cell);
    m.global = calloc(cells, sizeof *m.global);
    m.is_owned = calloc(cells, sizeof *m.is_owned);
    for (int k = 0; k < KINDS_OF_VALUES; k++) {
        m.all[k] = calloc(cells * (size_t)w->layers, sizeof *m.values);
    }
    m.values = m.all[F];
    for (int64_t i = 0; i < w->grid.corners; i++) {
        const int32_t *c = corner_cell + 3 * i;
        int is_near = owner[c[0]] == rank || owner[c[1]] == rank || owner[c[2]] == rank;
        for (int k = 0; k < 3; k++) {
            has[c[k]] |= owner[c[k]] == rank || (is_near && rank % 2 == 1);
        }
    }
    m.part.struct_size = sizeof m.part;
    m.part.index_type = ICORAY_I32;
    for (int64_t c = (int64_t)cells - 1; c >= 0; c--) {
        if (has[c]) {
            int64_t at = m.part.cells++;
            m.cell[at] = c;
            m.global[at] = (int32_t)c + w->grid.index_base;
            m.is_owned[at] = owner[c] == rank;
        }
    }
    m.part.cell_global = m.global;
    m.part.is_owned = m.is_owned;
    m.array = w->array;
    m.array.columns = m.part.cells;
    m.array.data = m.values;
    if (rank % 3 == 2) { /* whole layers */
        m.array.column_stride = 1;
        m.array.layer_stride = m.part.cells;
    }
    free(has);
    add_corners(&m, w, owner, is_numbered);
    return m;
}

static void end_mine(Mine *m)
{
    free(m->cell);
    free(m->global);
    free(m->is_owned);
    free(m->corner);
    free(m->corner_global);
    free(m->is_corner_owned);
    free(m->at_corners[0]);
    free(m->at_corners[1]);
    for (int k = 0; k < KINDS_OF_VALUES; k++) {
        free(m->all[k]);
    }
}

/* Fields and heights as they are at a step; what is in a halo is not read. */
static float value(const World *w, int kind, int64_t cell, int layer, int step)
{
    const float *column = w->values + cell * w->layers;
    switch (kind) {
    case F:
        return column[layer] * (1.0f - 0.25f * (float)step);
    case G:
        return -column[w->layers - 1 - layer];
    default:
        return 4e3f * (float)layer + 2e3f * (1.0f + column[0]);
    }
}

/* Sets the second field and the heights, beside the first field, whose array is alike. */
static void set_more(icoray_ctx *ctx, icoray_array array, float *const all[KINDS_OF_VALUES])
{
    array.data = all[G];
    OK(icoray_field_set(ctx, "g", &array));
    array.data = all[HEIGHTS];
    OK(icoray_heights_set(ctx, &array));
}

/* The field and the heights at a corner; all values at corners are `base`. */
static float corner_value(const float *base, const World *w, int kind, int64_t corner, int layer)
{
    const float *column = base + corner * w->layers;
    return kind == 0 ? column[layer] : 4e3f * (float)layer + 2e3f * (1.0f + column[0]);
}

static void compute_corners(const Mine *m, const World *w)
{
    float *base = corner_values(w);
    for (int64_t i = 0; i < m->corner_array.columns * w->layers; i++) {
        int64_t at = i / w->layers;
        for (int k = 0; k < 2; k++) {
            float value = corner_value(base, w, k, m->corner[at], (int)(i % w->layers));
            m->at_corners[k][i] = m->is_corner_owned[at] ? value : NAN;
        }
    }
    free(base);
}

/* Sets the field and the heights at corners, in place of those at cells. */
static void set_corners(icoray_ctx *ctx, icoray_array array, float *const at_corners[2])
{
    array.data = at_corners[0];
    OK(icoray_field_set(ctx, "c", &array));
    array.data = at_corners[1];
    OK(icoray_heights_set(ctx, &array));
}

static void compute(const Mine *m, const World *w, int step)
{
    for (int64_t c = 0; c < m->part.cells; c++) {
        for (int l = 0; l < w->layers; l++) {
            int64_t at = c * m->array.column_stride + l * m->array.layer_stride;
            for (int k = 0; k < KINDS_OF_VALUES; k++) {
                m->all[k][at] = m->is_owned[c] ? value(w, k, m->cell[c], l, step) : NAN;
            }
        }
    }
}

#endif
