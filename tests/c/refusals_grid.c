/* Grids that are refused. */
#include "refusals.h"

#include <math.h>
#include <stddef.h>

void grids(icoray_ctx *ctx)
{
#define MEMBER(name) {"icoray_grid." #name, offsetof(icoray_grid, name)}
    static const struct {
        const char *name;
        size_t offset;
    } tables[] = {MEMBER(lon_center_rad), MEMBER(lat_center_rad), MEMBER(lon_corner_rad), MEMBER(lat_corner_rad),
                  MEMBER(cell_corner),    MEMBER(corner_cell),    MEMBER(corner_edge),    MEMBER(edge_corner)},
      counts[] = {MEMBER(cells), MEMBER(corners), MEMBER(edges), MEMBER(cell_corner_row)};
#undef MEMBER
    static const int64_t impossible[] = {-1, INT64_MIN, INT64_MAX, (int64_t)1 << 40};
    static const int64_t zero = 0;
    static const int32_t kinds[] = {0, 3, -1, INT32_MAX};
    static const int32_t bases[] = {-1, 2, INT32_MIN, INT32_MAX};
    const char *const no_table = NULL;
    icoray_grid grid;
    for (size_t i = 0; i < COUNT(tables); i++) {
        const char *aside;
        trying = tables[i].name;
        grid = good_grid;
        memcpy((char *)&grid + tables[i].offset, &no_table, sizeof no_table);
        REFUSED(ctx, ICORAY_ERR_NULL, tables[i].name, icoray_grid_set(ctx, &grid));
        memcpy(&aside, (const char *)&good_grid + tables[i].offset, sizeof aside);
        aside += 1;
        memcpy((char *)&grid + tables[i].offset, &aside, sizeof aside);
        REFUSED(ctx, ICORAY_ERR_ARGUMENT, tables[i].name, icoray_grid_set(ctx, &grid));
    }
    for (size_t i = 0; i < COUNT(counts); i++) {
        trying = counts[i].name;
        grid = good_grid;
        for (size_t k = 0; k < COUNT(impossible); k++) {
            memcpy((char *)&grid + counts[i].offset, &impossible[k], sizeof impossible[k]);
            REFUSED(ctx, ICORAY_ERR_ARGUMENT, counts[i].name, icoray_grid_set(ctx, &grid));
        }
        memcpy((char *)&grid + counts[i].offset, &zero, sizeof zero);
        REFUSED(ctx, ICORAY_ERR_GRID, "expected", icoray_grid_set(ctx, &grid));
    }
    trying = "";
    for (size_t i = 0; i < COUNT(kinds); i++) {
        grid = good_grid;
        grid.real_type = kinds[i];
        REFUSED(ctx, ICORAY_ERR_ARGUMENT, "ICORAY_F32", icoray_grid_set(ctx, &grid));
        grid = good_grid;
        grid.index_base = bases[i];
        REFUSED(ctx, ICORAY_ERR_ARGUMENT, "index_base", icoray_grid_set(ctx, &grid));
    }
    memset(&grid, 0, sizeof grid);
    grid.struct_size = sizeof grid;
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "icoray_grid", icoray_grid_set(ctx, &grid));
    /* Numbered from 0 and said to be from 1: cell 0 looks like a hole's mark. */
    grid = good_grid;
    grid.index_base = 1;
    REFUSED(ctx, ICORAY_ERR_UNSUPPORTED, "hole", icoray_grid_set(ctx, &grid));
}

static int32_t *copied(const int32_t *table, int64_t entries)
{
    int32_t *copy = malloc((size_t)entries * sizeof *copy);
    if (copy == NULL) {
        printf("out of memory\n");
        exit(EXIT_FAILURE);
    }
    if (table != NULL) {
        memcpy(copy, table, (size_t)entries * sizeof *copy);
    }
    return copy;
}

/* One wrong entry in one table. */
void bad_tables(icoray_ctx *ctx)
{
    enum { CELL_CORNER, CELL_CORNER_COUNT, CORNER_CELL, CORNER_EDGE, EDGE_CORNER };
    icoray_grid grid = good_grid;
    int32_t cells = (int32_t)grid.cells, corners = (int32_t)grid.corners, edges = (int32_t)grid.edges;
    int32_t *table[5];
    struct {
        int table, entry;
        int32_t value;
        icoray_status status;
        const char *part;
    } cases[] = {
        {CORNER_CELL, 10, -1, ICORAY_ERR_UNSUPPORTED, "corner_cell row 3"},
        {CORNER_CELL, 10, cells, ICORAY_ERR_UNSUPPORTED, "hole"},
        {CORNER_CELL, 10, -2, ICORAY_ERR_GRID, "corner_cell row 3, column 1: -2"},
        {CORNER_CELL, 10, cells + 1, ICORAY_ERR_GRID, "corner_cell row 3, column 1: 43"},
        {CORNER_CELL, 10, INT32_MAX, ICORAY_ERR_GRID, "corner_cell row 3, column 1: 2147483647"},
        {CORNER_CELL, 10, INT32_MIN, ICORAY_ERR_GRID, "corner_cell row 3, column 1: -2147483648"},
        {CORNER_CELL, 1, good_grid.corner_cell[0], ICORAY_ERR_GRID, "three different cells"},
        {CORNER_CELL, 10, (good_grid.corner_cell[10] + 20) % cells, ICORAY_ERR_GRID, "corner_cell row"},
        {CORNER_EDGE, 7, edges, ICORAY_ERR_GRID, "corner_edge row 2, column 1: 120"},
        {CORNER_EDGE, 7, -1, ICORAY_ERR_GRID, "corner_edge row 2, column 1: -1"},
        {CORNER_EDGE, 7, good_grid.corner_edge[6], ICORAY_ERR_GRID, "corner_edge row 2"},
        {CORNER_EDGE, 7, (good_grid.corner_edge[7] + 60) % edges, ICORAY_ERR_GRID, "corner_edge row 2"},
        {EDGE_CORNER, 5, corners, ICORAY_ERR_GRID, "edge_corner row 2, column 1: 80"},
        {EDGE_CORNER, 5, INT32_MIN, ICORAY_ERR_GRID, "edge_corner row 2, column 1"},
        {EDGE_CORNER, 5, good_grid.edge_corner[4], ICORAY_ERR_GRID, "edge_corner row 2"},
        {CELL_CORNER, 122, corners, ICORAY_ERR_GRID, "cell_corner row 20, column 2: 80"},
        {CELL_CORNER, 122, INT32_MIN, ICORAY_ERR_GRID, "cell_corner row 20, column 2"},
        {CELL_CORNER_COUNT, 3, 7, ICORAY_ERR_GRID, "cell_corner_count row 3: 7"},
        {CELL_CORNER_COUNT, 3, 2, ICORAY_ERR_GRID, "cell_corner_count row 3: 2"},
        {CELL_CORNER_COUNT, 3, INT32_MIN, ICORAY_ERR_GRID, "cell_corner_count row 3"},
    };
    struct {
        int array, row;
        double value;
        const char *part;
    } places[] = {
        {0, 7, NAN, "center row 7"},       {0, 7, INFINITY, "center row 7"}, {1, 7, 2.0, "center row 7"},
        {1, 7, -INFINITY, "center row 7"}, {2, 5, NAN, "corner row 5"},      {2, 5, 360.0, "corner row 5"},
        {3, 5, NAN, "corner row 5"},       {3, 5, -90.0, "corner row 5"},
    };
    table[CELL_CORNER] = copied(good_grid.cell_corner, 6 * good_grid.cells);
    table[CELL_CORNER_COUNT] = copied(NULL, good_grid.cells);
    table[CORNER_CELL] = copied(good_grid.corner_cell, 3 * good_grid.corners);
    table[CORNER_EDGE] = copied(good_grid.corner_edge, 3 * good_grid.corners);
    table[EDGE_CORNER] = copied(good_grid.edge_corner, 2 * good_grid.edges);
    for (int i = 0; i < cells; i++) {
        table[CELL_CORNER_COUNT][i] = 6;
    }
    grid.cell_corner = table[CELL_CORNER];
    grid.cell_corner_count = table[CELL_CORNER_COUNT];
    grid.corner_cell = table[CORNER_CELL];
    grid.corner_edge = table[CORNER_EDGE];
    grid.edge_corner = table[EDGE_CORNER];
    for (size_t i = 0; i < COUNT(cases); i++) {
        int32_t *entry = &table[cases[i].table][cases[i].entry], was = *entry;
        trying = cases[i].part;
        *entry = cases[i].value;
        REFUSED(ctx, cases[i].status, cases[i].part, icoray_grid_set(ctx, &grid));
        *entry = was;
    }
    for (size_t i = 0; i < COUNT(places); i++) {
        const void **arrays[4];
        icoray_grid other = good_grid;
        size_t rows = (size_t)(places[i].array < 2 ? cells : corners);
        double *copy = malloc(rows * sizeof *copy);
        arrays[0] = &other.lon_center_rad, arrays[1] = &other.lat_center_rad;
        arrays[2] = &other.lon_corner_rad, arrays[3] = &other.lat_corner_rad;
        trying = places[i].part;
        if (copy != NULL) {
            memcpy(copy, *arrays[places[i].array], rows * sizeof *copy);
            copy[places[i].row] = places[i].value;
            *arrays[places[i].array] = copy;
            REFUSED(ctx, ICORAY_ERR_GRID, places[i].part, icoray_grid_set(ctx, &other));
            free(copy);
        }
    }
    /* The tables were right but for those entries. */
    trying = "";
    OK(icoray_grid_set(ctx, &grid));
    OK(icoray_grid_set(ctx, &good_grid));
    for (int i = 0; i < 5; i++) {
        free(table[i]);
    }
}
