/* Tables with one wrong entry, in either width. */
#include "refusals.h"

#include <math.h>

enum { CELL_CORNER, CELL_CORNER_COUNT, CORNER_CELL, CORNER_EDGE, EDGE_CORNER, TABLES };

static int64_t entries_of(int table)
{
    switch (table) {
    case CELL_CORNER: return 6 * good_grid.cells;
    case CELL_CORNER_COUNT: return good_grid.cells;
    case EDGE_CORNER: return 2 * good_grid.edges;
    default: return 3 * good_grid.corners;
    }
}

/* Entry of a good table; each cell says that it has six corners, of which a pentagon repeats one. */
static int64_t entry(int table, int64_t at)
{
    switch (table) {
    case CELL_CORNER: return ((const int32_t *)good_grid.cell_corner)[at];
    case CELL_CORNER_COUNT: return 6;
    case CORNER_CELL: return ((const int32_t *)good_grid.corner_cell)[at];
    case CORNER_EDGE: return ((const int32_t *)good_grid.corner_edge)[at];
    default: return ((const int32_t *)good_grid.edge_corner)[at];
    }
}

/* The good grid with tables of its own, which can be written to. */
typedef struct {
    icoray_grid grid;
    void *table[TABLES];
} Copy;

static void set_entry(Copy *copy, int table, int64_t at, int64_t value)
{
    set_index(copy->table[table], copy->grid.index_type, at, value);
}

static Copy copied(int32_t index_type)
{
    Copy copy;
    copy.grid = good_grid;
    copy.grid.index_type = index_type;
    for (int table = 0; table < TABLES; table++) {
        int64_t entries = entries_of(table);
        copy.table[table] = allocate((size_t)entries, index_type == ICORAY_I32 ? 4 : 8);
        for (int64_t i = 0; i < entries; i++) {
            set_entry(&copy, table, i, entry(table, i));
        }
    }
    copy.grid.cell_corner = copy.table[CELL_CORNER];
    copy.grid.cell_corner_count = copy.table[CELL_CORNER_COUNT];
    copy.grid.corner_cell = copy.table[CORNER_CELL];
    copy.grid.corner_edge = copy.table[CORNER_EDGE];
    copy.grid.edge_corner = copy.table[EDGE_CORNER];
    return copy;
}

static void freed(Copy *copy)
{
    for (int table = 0; table < TABLES; table++) {
        free(copy->table[table]);
    }
}

/* In either width. */
void bad_tables(icoray_ctx *ctx)
{
    static const int32_t widths[] = {ICORAY_I32, ICORAY_I64};
    int64_t cells = good_grid.cells, corners = good_grid.corners, edges = good_grid.edges;
    const struct {
        int table;
        int64_t entry, value;
        const char *part;
    } cases[] = {
        {CORNER_CELL, 10, -1, "and corner_cell[3] (MPAS cellsOnVertex, ICON vertex_of_cell): ["},
        {CORNER_CELL, 10, cells, ", 42, "},
        {CORNER_CELL, 10, -2, "corner_cell[3][1] (MPAS cellsOnVertex, ICON vertex_of_cell): -2"},
        {CORNER_CELL, 10, cells + 1, "corner_cell[3][1] (MPAS cellsOnVertex, ICON vertex_of_cell): 43"},
        {CORNER_CELL, 10, INT32_MAX, "corner_cell[3][1] (MPAS cellsOnVertex, ICON vertex_of_cell): 2147483647"},
        {CORNER_CELL, 10, INT32_MIN, "corner_cell[3][1] (MPAS cellsOnVertex, ICON vertex_of_cell): -2147483648"},
        {CORNER_CELL, 1, entry(CORNER_CELL, 0), "three different cells"},
        {CORNER_CELL, 10, (entry(CORNER_CELL, 10) + 20) % cells, "corner_cell["},
        {CORNER_EDGE, 7, edges, "corner_edge[2][1] (MPAS edgesOnVertex, ICON edge_of_cell): 120"},
        {CORNER_EDGE, 7, -1, "corner_edge[2][1] (MPAS edgesOnVertex, ICON edge_of_cell): -1"},
        {CORNER_EDGE, 7, entry(CORNER_EDGE, 6), "corner_edge[2]"},
        {CORNER_EDGE, 7, (entry(CORNER_EDGE, 7) + 60) % edges, "corner_edge[2]"},
        {EDGE_CORNER, 5, corners, "edge_corner[2] (MPAS verticesOnEdge, ICON adjacent_cell_of_edge): ["},
        {EDGE_CORNER, 5, corners + 1, "edge_corner[2][1] (MPAS verticesOnEdge, ICON adjacent_cell_of_edge): 81"},
        {EDGE_CORNER, 5, INT32_MIN, "edge_corner[2][1]"},
        {EDGE_CORNER, 5, entry(EDGE_CORNER, 4), "edge_corner[2]"},
        {CELL_CORNER, 122, corners, "cell_corner[20][2] (MPAS verticesOnCell, ICON cells_of_vertex): 80"},
        {CELL_CORNER, 122, INT32_MIN, "cell_corner[20][2]"},
        {CELL_CORNER_COUNT, 3, 7, "cell_corner_count[3] (MPAS nEdgesOnCell): 7"},
        {CELL_CORNER_COUNT, 3, 2, "cell_corner_count[3] (MPAS nEdgesOnCell): 2"},
        {CELL_CORNER_COUNT, 3, INT32_MIN, "cell_corner_count[3]"},
    };
    for (size_t width = 0; width < COUNT(widths); width++) {
        Copy copy = copied(widths[width]);
        for (size_t i = 0; i < COUNT(cases); i++) {
            trying = cases[i].part;
            set_entry(&copy, cases[i].table, cases[i].entry, cases[i].value);
            REFUSED(ctx, GRID, cases[i].part, icoray_grid_set(ctx, &copy.grid));
            set_entry(&copy, cases[i].table, cases[i].entry, entry(cases[i].table, cases[i].entry));
        }
        /* The tables were right but for those entries. */
        trying = "";
        OK(icoray_grid_set(ctx, &copy.grid));
        OK(icoray_grid_set(ctx, &good_grid));
        freed(&copy);
    }
}

/* Numbers that would be right if only 32 bits of them were looked at, and others that take 64. */
void wide_tables(icoray_ctx *ctx)
{
    static const int64_t beyond[] = {(int64_t)1 << 32, -((int64_t)1 << 32), (int64_t)1 << 33, (int64_t)1 << 62};
    static const int64_t ends[] = {INT64_MAX, INT64_MIN, (int64_t)INT32_MAX + 1, (int64_t)INT32_MIN - 1, 4294967295};
    static const struct {
        int table;
        const char *name, *models;
        int64_t row_length;
    } tables[TABLES] = {
        {CELL_CORNER, "cell_corner", "MPAS verticesOnCell, ICON cells_of_vertex", 6},
        {CELL_CORNER_COUNT, "cell_corner_count", "MPAS nEdgesOnCell", 1},
        {CORNER_CELL, "corner_cell", "MPAS cellsOnVertex, ICON vertex_of_cell", 3},
        {CORNER_EDGE, "corner_edge", "MPAS edgesOnVertex, ICON edge_of_cell", 3},
        {EDGE_CORNER, "edge_corner", "MPAS verticesOnEdge, ICON adjacent_cell_of_edge", 2},
    };
    Copy copy = copied(ICORAY_I64);
    for (size_t t = 0; t < COUNT(tables); t++) {
        int64_t last = entries_of(tables[t].table) - 1;
        for (size_t i = 0; i < COUNT(beyond) + COUNT(ends); i++) {
            int64_t at = i % 2 == 0 ? last : last / 2;
            int64_t value = i < COUNT(beyond) ? entry(tables[t].table, at) + beyond[i] : ends[i - COUNT(beyond)];
            long long row = at / tables[t].row_length, column = at % tables[t].row_length;
            const char *which = tables[t].row_length == 1 ? "" : text_of("[%lld]", column);
            trying = text_of("%s[%lld]%s (%s): %lld, expected", tables[t].name, row, which, tables[t].models,
                             (long long)value);
            set_entry(&copy, tables[t].table, at, value);
            REFUSED(ctx, GRID, trying, icoray_grid_set(ctx, &copy.grid));
            set_entry(&copy, tables[t].table, at, entry(tables[t].table, at));
        }
    }
    trying = "";
    OK(icoray_grid_set(ctx, &copy.grid));
    still_draws(ctx);
    OK(icoray_grid_set(ctx, &good_grid));
    freed(&copy);
}

/* One place that is nowhere on the sphere. */
void bad_places(icoray_ctx *ctx)
{
    static const struct {
        int array, row;
        double value;
        const char *part;
    } places[] = {
        {0, 7, NAN, "center[7] (MPAS"},       {0, 7, INFINITY, "center[7] (MPAS"}, {1, 7, 2.0, "center[7] (MPAS"},
        {1, 7, -INFINITY, "center[7] (MPAS"}, {2, 5, NAN, "corner[5] (MPAS"},      {2, 5, 360.0, "corner[5] (MPAS"},
        {3, 5, NAN, "corner[5] (MPAS"},       {3, 5, -90.0, "corner[5] (MPAS"},
    };
    for (size_t i = 0; i < COUNT(places); i++) {
        const void **arrays[4];
        icoray_grid other = good_grid;
        size_t rows = (size_t)(places[i].array < 2 ? good_grid.cells : good_grid.corners);
        double *copy = (double *)allocate(rows, sizeof *copy);
        arrays[0] = &other.lon_center_rad, arrays[1] = &other.lat_center_rad;
        arrays[2] = &other.lon_corner_rad, arrays[3] = &other.lat_corner_rad;
        trying = places[i].part;
        memcpy(copy, *arrays[places[i].array], rows * sizeof *copy);
        copy[places[i].row] = places[i].value;
        *arrays[places[i].array] = copy;
        REFUSED(ctx, GRID, places[i].part, icoray_grid_set(ctx, &other));
        free(copy);
    }
}
