#include "mpi_cut.h"

#include <math.h>

/* Rows that stay, and the local number of each, or the mark that it is missing. */
typedef struct {
    int64_t *row, *number, count;
} Kept;

static void *keep(Cut *c, size_t count, size_t size)
{
    /* A rank without cells has no tables at all. */
    void *memory = count == 0 ? NULL : calloc(count, size);
    c->kept[c->count++] = memory;
    return memory;
}

static Kept numbers(const char *stays, const char *comes_first, int64_t all, int base)
{
    Kept k;
    int64_t mark;
    k.row = calloc((size_t)all + 1, sizeof *k.row);
    k.number = calloc((size_t)all + 1, sizeof *k.number);
    k.count = 0;
    for (int pass = 0; pass < 2; pass++) {
        for (int64_t i = 0; i < all; i++) {
            if (stays[i] && (comes_first == NULL ? pass == 0 : comes_first[i] == (pass == 0))) {
                k.row[k.count++] = i;
            }
        }
    }
    mark = rank % 3 == 0 ? base - 1 : rank % 3 == 1 ? -1 : k.count + base;
    for (int64_t i = 0; i < all; i++) {
        k.number[i] = mark;
    }
    for (int64_t i = 0; i < k.count; i++) {
        k.number[k.row[i]] = i + base;
    }
    return k;
}

static void forget(Kept *k)
{
    free(k->row);
    free(k->number);
}

/* The rows of a table that stay, in the numbers that those of its entries have. */
static const void *table(Cut *c, const void *whole, int width, const Kept *rows, const Kept *entries)
{
    const int32_t *from = whole;
    size_t count = (size_t)rows->count * (size_t)width;
    void *to = keep(c, count, c->grid.index_type == ICORAY_I64 ? 8 : 4);
    for (size_t i = 0; i < count; i++) {
        int64_t number = entries->number[from[rows->row[i / (size_t)width] * width + (int64_t)(i % (size_t)width)]];
        set_index(to, c->grid.index_type, (int64_t)i, number);
    }
    return to;
}

static const void *reals(Cut *c, const void *whole, const Kept *rows)
{
    const double *from = whole;
    double *to = keep(c, (size_t)rows->count, sizeof *to);
    for (int64_t i = 0; i < rows->count; i++) {
        to[i] = from[rows->row[i]];
    }
    return to;
}

/* The columns that stay; what is not `known` here is not a number. */
static icoray_array columns(Cut *c, const World *w, const float *whole, const Kept *rows, const char *known)
{
    icoray_array array = w->array;
    size_t layers = (size_t)w->layers;
    float *to = keep(c, (size_t)rows->count * layers, sizeof *to);
    for (size_t i = 0; i < (size_t)rows->count * layers; i++) {
        size_t row = (size_t)rows->row[i / layers];
        to[i] = known[row] ? whole[row * layers + i % layers] : NAN;
    }
    array.data = to;
    array.columns = rows->count;
    return array;
}

/* The declaration of own cells. */
static void say(Cut *c, const Kept *cells, const char *is_own, int is_first)
{
    int32_t *marks = keep(c, (size_t)cells->count, sizeof *marks);
    void *global = keep(c, (size_t)cells->count, 8);
    c->part.struct_size = sizeof c->part;
    c->part.cells = cells->count;
    c->part.index_type = c->grid.index_type;
    c->part.cell_global = global;
    for (int64_t i = 0; i < cells->count; i++) {
        int64_t number = 7 * cells->row[i] + 3 + c->grid.index_base; /* with gaps */
        set_index(global, c->grid.index_type, i, number);
        marks[i] = is_own[cells->row[i]] ? -7 : 0;
        c->part.owned_cells += is_first && is_own[cells->row[i]];
    }
    if (!is_first) {
        c->part.is_owned = marks;
        c->part.owned_cells = -5; /* not read */
    }
}

Cut cut(const World *w, const int *owner, int mine, int has_halo)
{
    const icoray_grid *g = &w->grid;
    const int32_t *corner_cell = g->corner_cell, *edge_corner = g->edge_corner;
    size_t cells = (size_t)g->cells, corners = (size_t)g->corners, edges = (size_t)g->edges;
    char *is_own = calloc(cells, 1), *stays = calloc(cells, 1);
    char *is_near = calloc(corners, 1), *is_first_own = calloc(corners, 1), *corner_stays = calloc(corners, 1), *edge_stays = calloc(edges, 1);
    float *at_corners = corner_values(w);
    int is_first = rank % 2 == 0;
    Kept cell, corner, edge;
    for (size_t i = 0; i < cells; i++) {
        is_own[i] = stays[i] = owner[i] == mine;
    }
    for (size_t i = 0; i < 3 * corners; i++) {
        is_near[i / 3] |= is_own[corner_cell[i]];
        is_first_own[i / 3] |= i % 3 == 0 && is_own[corner_cell[i]];
    }
    for (size_t i = 0; i < 3 * corners && has_halo; i++) {
        stays[corner_cell[i]] |= is_near[i / 3];
    }
    for (size_t i = 0; i < 3 * corners; i++) {
        corner_stays[i / 3] |= stays[corner_cell[i]];
    }
    /* Of a cell that stays: one of the two that both ends of the edge touch. */
    for (size_t i = 0; i < edges; i++) {
        const int32_t *a = corner_cell + 3 * edge_corner[2 * i], *b = corner_cell + 3 * edge_corner[2 * i + 1];
        for (int k = 0; k < 9; k++) {
            edge_stays[i] |= a[k / 3] == b[k % 3] && stays[a[k / 3]];
        }
    }
    Cut c = {.grid = *g};
    c.grid.index_base = rank % 4 == 1 ? 0 : 1;
    c.grid.index_type = rank % 4 < 2 ? ICORAY_I32 : ICORAY_I64;
    cell = numbers(stays, is_first ? is_own : NULL, g->cells, c.grid.index_base);
    corner = numbers(corner_stays, NULL, g->corners, c.grid.index_base);
    edge = numbers(edge_stays, NULL, g->edges, c.grid.index_base);
    c.grid.cells = cell.count;
    c.grid.corners = corner.count;
    c.grid.edges = edge.count;
    c.grid.lon_center_rad = reals(&c, g->lon_center_rad, &cell);
    c.grid.lat_center_rad = reals(&c, g->lat_center_rad, &cell);
    c.grid.lon_corner_rad = reals(&c, g->lon_corner_rad, &corner);
    c.grid.lat_corner_rad = reals(&c, g->lat_corner_rad, &corner);
    c.grid.cell_corner = table(&c, g->cell_corner, (int)g->cell_corner_row, &cell, &corner);
    c.grid.corner_cell = table(&c, g->corner_cell, 3, &corner, &cell);
    c.grid.corner_edge = table(&c, g->corner_edge, 3, &corner, &edge);
    c.grid.edge_corner = table(&c, g->edge_corner, 2, &edge, &corner);
    say(&c, &cell, is_own, is_first);
    c.center = columns(&c, w, w->values, &cell, is_own);
    c.corner = columns(&c, w, at_corners, &corner, is_first_own);
    c.corner.location = ICORAY_CORNER;
    forget(&cell);
    forget(&corner);
    forget(&edge);
    free(is_own);
    free(stays);
    free(is_near);
    free(is_first_own);
    free(corner_stays);
    free(edge_stays);
    free(at_corners);
    return c;
}

void end_cut(Cut *c)
{
    while (c->count > 0) {
        free(c->kept[--c->count]);
    }
}

void fill_cut(icoray_ctx *ctx, const Cut *c, int layers)
{
    OK(icoray_grid_set(ctx, &c->grid));
    set_layers(ctx, layers);
    OK(icoray_field_set(ctx, "f", &c->center));
    OK(icoray_field_set(ctx, "v", &c->corner));
}

float *corner_values(const World *w)
{
    const double *lon = w->grid.lon_corner_rad, *lat = w->grid.lat_corner_rad;
    float *values = calloc((size_t)w->grid.corners * (size_t)w->layers, sizeof *values);
    for (int64_t i = 0; i < w->grid.corners * w->layers; i++) {
        int64_t at = i / w->layers;
        values[i] = (float)(cos(2.0 * lon[at] - (double)(i % w->layers) / w->layers) * sin(2.0 * lat[at]));
    }
    return values;
}

int *partition(const World *w, int kind, int of)
{
    int64_t cells = w->grid.cells, others = of - 1;
    int *owner = NULL;
    if (of == 1 && kind != CONTIGUOUS) {
        return NULL;
    }
    owner = calloc((size_t)cells, sizeof *owner);
    for (int64_t i = 0; i < cells; i++) {
        uint64_t z = (uint64_t)(i + 1) * 0x9e3779b97f4a7c15u;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        switch (kind) {
        case CONTIGUOUS:
            owner[i] = (int)(i * of / cells);
            break;
        case RANDOM:
            owner[i] = (int)((z >> 33) % (uint64_t)of);
            break;
        default: /* the first rank, where it is not the only one, has the one cell or none, and the others the rest */
            owner[i] = kind == SINGLE_CELL && i == 77 ? 0 : (int)(1 + i * others / cells);
        }
    }
    return owner;
}
