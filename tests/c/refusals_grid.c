/* Grids that are refused. */
#include "refusals.h"

#include <math.h>

void grids(icoray_ctx *ctx)
{
#define TABLE(name) {"icoray_grid." #name, offsetof(icoray_grid, name)}
    static const struct {
        const char *name;
        size_t offset;
    } tables[] = {TABLE(lon_center_rad), TABLE(lat_center_rad), TABLE(lon_corner_rad), TABLE(lat_corner_rad),
                  TABLE(cell_corner),    TABLE(corner_cell),    TABLE(corner_edge),    TABLE(edge_corner)},
      counts[] = {TABLE(cells), TABLE(corners), TABLE(edges), TABLE(cell_corner_row)};
#undef TABLE
    static const int64_t impossible[] = {-1, INT64_MIN, INT64_MAX, (int64_t)1 << 40};
    static const int64_t zero = 0;
    static const struct {
        const char *words;
        size_t offset, size;
        int32_t wrong[7];
    } codes[] = {
        {"icoray_grid.real_type: %d, expected ICORAY_F32", MEMBER(icoray_grid, real_type),
         {0, ICORAY_I32, ICORAY_I64, -1, INT32_MIN, INT32_MAX, 5}},
        {"icoray_grid.index_type: %d, expected ICORAY_I32", MEMBER(icoray_grid, index_type),
         {0, ICORAY_F32, ICORAY_F64, 5, -1, INT32_MIN, INT32_MAX}},
        {"index_base: %d", MEMBER(icoray_grid, index_base), {-1, 2, INT32_MIN, INT32_MAX, 3, -2, 7}},
    };
    const char *const no_table = NULL;
    icoray_grid grid;
    for (size_t i = 0; i < COUNT(tables); i++) {
        const char *aside;
        trying = tables[i].name;
        grid = good_grid;
        memcpy((char *)&grid + tables[i].offset, &no_table, sizeof no_table);
        REFUSED(ctx, NULL, tables[i].name, icoray_grid_set(ctx, &grid));
        memcpy(&aside, (const char *)&good_grid + tables[i].offset, sizeof aside);
        aside += 1;
        memcpy((char *)&grid + tables[i].offset, &aside, sizeof aside);
        REFUSED(ctx, ARGUMENT, tables[i].name, icoray_grid_set(ctx, &grid));
    }
    for (size_t i = 0; i < COUNT(counts); i++) {
        trying = counts[i].name;
        grid = good_grid;
        for (size_t k = 0; k < COUNT(impossible); k++) {
            memcpy((char *)&grid + counts[i].offset, &impossible[k], sizeof impossible[k]);
            REFUSED(ctx, ARGUMENT, counts[i].name, icoray_grid_set(ctx, &grid));
        }
        memcpy((char *)&grid + counts[i].offset, &zero, sizeof zero);
        REFUSED(ctx, GRID, "expected", icoray_grid_set(ctx, &grid));
    }
    trying = "";
    for (size_t i = 0; i < COUNT(codes); i++) {
        for (size_t k = 0; k < 7; k++) {
            trying = text_of(codes[i].words, (int)codes[i].wrong[k]);
            grid = good_grid;
            put(&grid, codes[i].offset, codes[i].size, codes[i].wrong[k]);
            REFUSED(ctx, ARGUMENT, trying, icoray_grid_set(ctx, &grid));
        }
    }
    trying = "";
    /* Numbers in each other's place: no table is read past its end. */
    grid = good_grid;
    grid.cells = good_grid.corners;
    grid.corners = good_grid.cells;
    REFUSED(ctx, GRID, "80 cells, 42 corners and 120 edges: cells and corners look swapped",
            icoray_grid_set(ctx, &grid));
    grid.edges = good_grid.edges - 1;
    REFUSED(ctx, GRID, "the numbers of cells and corners look swapped", icoray_grid_set(ctx, &grid));
    grid = good_grid;
    grid.corners = good_grid.edges;
    grid.edges = good_grid.corners;
    REFUSED(ctx, GRID, "corners and edges look swapped", icoray_grid_set(ctx, &grid));
    REFUSED_WITH(grid, name, NO_UTF8, ARGUMENT, "icoray_grid.name", icoray_grid_set(ctx, &grid));
    /* 32-bit tables that are said to hold 64 bits are not aligned so, or hold other numbers. */
    grid = good_grid;
    grid.index_type = ICORAY_I64;
    grid.cell_corner = (const char *)good_grid.cell_corner + 4;
    REFUSED(ctx, ARGUMENT, "icoray_grid.cell_corner", icoray_grid_set(ctx, &grid));
    memset(&grid, 0, sizeof grid);
    grid.struct_size = sizeof grid;
    REFUSED(ctx, ARGUMENT, "icoray_grid", icoray_grid_set(ctx, &grid));
    /* Numbered from 0 and said to be from 1: cell 0 looks like a hole's mark. */
    REFUSED_WITH(grid, index_base, 1, GRID, "; numbers begin at 0: set index_base = 0", icoray_grid_set(ctx, &grid));
    {
        const double *lon = (const double *)good_grid.lon_center_rad, *lat = (const double *)good_grid.lat_center_rad;
        const int64_t count = good_grid.cells;
        double *spoilt = (double *)allocate((size_t)count, sizeof(double));
        memcpy(spoilt, lat, (size_t)count * sizeof(double));
        spoilt[7] = NAN;
        REFUSED(ctx, GRID, "center[7]", icoray_points_set(ctx, NULL, count, ICORAY_F64, lon, spoilt));
        free(spoilt);
        REFUSED(ctx, NULL, "lon_rad", icoray_points_set(ctx, NULL, count, ICORAY_F64, NULL, lat));
        REFUSED(ctx, NULL, "lat_rad", icoray_points_set(ctx, NULL, count, ICORAY_F64, lon, NULL));
        REFUSED(ctx, ARGUMENT, "cells: -1", icoray_points_set(ctx, NULL, -1, ICORAY_F64, lon, lat));
        REFUSED(ctx, ARGUMENT, "real_type: 7", icoray_points_set(ctx, NULL, count, 7, lon, lat));
        REFUSED(ctx, ARGUMENT, "name", icoray_points_set(ctx, NO_UTF8, count, ICORAY_F64, lon, lat));
        REFUSED(ctx, GRID, "the 2 points span no area", icoray_points_set(ctx, NULL, 2, ICORAY_F64, lon, lat));
        REFUSED(ctx, GRID, "0 cells", icoray_points_set(ctx, NULL, 0, ICORAY_F64, lon, lat));
    }
}
