/* Grids as models have them in memory. */
#include "pictures.h"

/* A table's numbers, each `more` than in another of 32 bits, in either width. */
static void *renumbered(const void *table, int64_t entries, int width, int more)
{
    void *copy = allocate((size_t)entries, width == ICORAY_I32 ? sizeof(int32_t) : sizeof(int64_t));
    for (int64_t i = 0; i < entries; i++) {
        set_index(copy, width, i, ((const int32_t *)table)[i] + more);
    }
    return copy;
}

/* Rows of `length` with a count of those that are there, each corner once; the others are never read. */
static void counted(int length, int32_t *cell_corner, int32_t *count)
{
    for (int c = 0; c < cells; c++) {
        const int32_t *row = (const int32_t *)grid.cell_corner + 6 * c;
        for (int i = 0; i < length; i++) {
            cell_corner[length * c + i] = -99;
        }
        count[c] = 0;
        for (int i = 0; i < 6; i++) {
            int seen = 0;
            for (int j = 0; j < i; j++) {
                seen |= row[j] == row[i];
            }
            if (!seen) {
                cell_corner[length * c + count[c]++] = row[i];
            }
        }
        CHECK(count[c] == 5 || count[c] == 6);
    }
}

/* Numbered from 0 or from 1, in 32 or 64 bits, in rows of 6, or longer ones with counts. */
static void numbered(const char *directory)
{
    enum { ROW = 8 };
    icoray_ctx *ctx = context(directory, "tables", 2);
    int32_t *rows = (int32_t *)allocate((size_t)cells * ROW, sizeof(int32_t));
    int32_t *count = (int32_t *)allocate((size_t)cells, sizeof(int32_t));
    Field f = field(ICORAY_F32, ICORAY_CENTER, LAYERS, (size_t)cells * LAYERS, 0, LAYERS, 1);
    Field corner = field(ICORAY_F32, ICORAY_CORNER, LAYERS, (size_t)corners * LAYERS, 0, LAYERS, 1);
    counted(ROW, rows, count);
    for (int k = 0; k < 8; k++) {
        int width = k & 1 ? ICORAY_I64 : ICORAY_I32, base = k >> 1 & 1, has_count = k >> 2;
        icoray_grid other = grid;
        void *tables[5];
        other.index_type = width;
        other.index_base = base;
        other.cell_corner_row = has_count ? ROW : 6;
        tables[0] = renumbered(has_count ? rows : grid.cell_corner, cells * other.cell_corner_row, width, base);
        tables[1] = renumbered(count, cells, width, 0);
        tables[2] = renumbered(grid.corner_cell, 3 * grid.corners, width, base);
        tables[3] = renumbered(grid.corner_edge, 3 * grid.corners, width, base);
        tables[4] = renumbered(grid.edge_corner, 2 * grid.edges, width, base);
        other.cell_corner = tables[0];
        other.cell_corner_count = has_count ? tables[1] : NULL;
        other.corner_cell = tables[2];
        other.corner_edge = tables[3];
        other.edge_corner = tables[4];
        OK(icoray_grid_set(ctx, &other));
        picture(ctx, "plain", "none", k, &f);
        picture(ctx, "lit", "headlight", k, &f);
        picture(ctx, "corner", "none", k, &corner);
        OK(icoray_grid_set(ctx, &grid)); /* gives the tables back */
        for (int i = 0; i < 5; i++) {
            free(tables[i]);
        }
    }
    picture(ctx, "plain", "none", 8, &f);
    OK(icoray_close(&ctx));
    free(rows);
    free(count);
    release(&f);
    release(&corner);
}

/* With coordinates in floats. */
static void single(const char *directory)
{
    icoray_ctx *ctx = context(directory, "single", 2);
    float *position = (float *)allocate((size_t)(cells + corners) * 2, sizeof(float));
    const double *from[4];
    float *to[4];
    int rows[4];
    icoray_grid other = grid;
    Field f = field(ICORAY_F32, ICORAY_CENTER, LAYERS, (size_t)cells * LAYERS, 0, LAYERS, 1);
    from[0] = (const double *)grid.lon_center_rad, from[1] = (const double *)grid.lat_center_rad;
    from[2] = (const double *)grid.lon_corner_rad, from[3] = (const double *)grid.lat_corner_rad;
    rows[0] = rows[1] = cells, rows[2] = rows[3] = corners;
    to[0] = position, to[1] = to[0] + cells, to[2] = to[1] + cells, to[3] = to[2] + corners;
    for (int k = 0; k < 4; k++) {
        for (int i = 0; i < rows[k]; i++) {
            to[k][i] = (float)from[k][i];
        }
    }
    other.real_type = ICORAY_F32;
    other.lon_center_rad = to[0], other.lat_center_rad = to[1];
    other.lon_corner_rad = to[2], other.lat_corner_rad = to[3];
    OK(icoray_grid_set(ctx, &other));
    picture(ctx, "near plain", "none", 4, &f);
    OK(icoray_close(&ctx));
    free(position);
    release(&f);
}

/* Points alone, in either precision: the call reads them, and keeps neither array. */
static void points(const char *directory)
{
    icoray_ctx *ctx = context(directory, "points", 2);
    Field f = field(ICORAY_F32, ICORAY_CENTER, LAYERS, (size_t)cells * LAYERS, 0, LAYERS, 1);
    for (int k = 0; k < 2; k++) {
        int type = k ? ICORAY_F64 : ICORAY_F32;
        double *lon = (double *)allocate((size_t)cells, sizeof(double));
        double *lat = (double *)allocate((size_t)cells, sizeof(double));
        for (int i = 0; i < cells; i++) {
            double at[2];
            at[0] = ((const double *)grid.lon_center_rad)[i], at[1] = ((const double *)grid.lat_center_rad)[i];
            if (k) {
                lon[i] = at[0], lat[i] = at[1];
            } else {
                ((float *)lon)[i] = (float)at[0], ((float *)lat)[i] = (float)at[1];
            }
        }
        OK(icoray_points_set(ctx, NULL, cells, type, lon, lat));
        memset(lon, 0x7f, (size_t)cells * sizeof(double));
        memset(lat, 0x7f, (size_t)cells * sizeof(double));
        free(lon);
        free(lat);
        picture(ctx, "near plain", "none", 6 + k, &f);
    }
    OK(icoray_close(&ctx));
    release(&f);
}

void tables(const char *directory)
{
    numbered(directory);
    single(directory);
    points(directory);
}
