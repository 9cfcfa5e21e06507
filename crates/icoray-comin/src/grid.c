/* ICON's tables of vertices, in blocks of nproma, as icoray's tables of cells, corners and edges. Edges are found from
 * the triangles: so no table of edges is asked of ICON. */
#include "grid.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define MISSING (-1)
#define TWO_PI 6.283185307179586476925
/* Steps per radian of longitude and latitude that number a vertex: 24 mm on the Earth, 61 bits for both. */
#define STEPS 268435456.0

/* As calloc, of one element at least, so that NULL means that there is no memory. */
static void *zeros(int64_t count, size_t size)
{
    return calloc(count > 0 ? (size_t)count : 1, size);
}

/* The place of vertex k of a triangle in ICON's tables, from 0, or MISSING. */
static int32_t vertex_of(const host_domain *domain, int32_t triangle, int k)
{
    int64_t at = triangle + (int64_t)k * domain->nproma * domain->cell_blocks;
    int64_t place = ((int64_t)domain->vertex_block[at] - 1) * domain->nproma + domain->vertex_index[at] - 1;
    int is_there = domain->vertex_index[at] > 0 && domain->vertex_block[at] > 0 && place < domain->vertices;
    return is_there ? (int32_t)place : MISSING;
}

/* The same number on all ranks, as ICON reads positions of vertices from one file, and a different one for each. */
static int64_t number_of(double lon, double lat)
{
    double east = lon < 0.0 ? lon + TWO_PI : lon;
    return (int64_t)floor(east * STEPS + 0.5) * 1073741824 + (int64_t)floor((lat + 2.0) * STEPS + 0.5);
}

/* Numbers the vertices that triangles have, and copies their positions. */
static int take_vertices(grid_tables *grid)
{
    const host_domain *domain = &grid->domain;
    int32_t *row = zeros(domain->vertices, sizeof *row);
    if (row == NULL) {
        return 0;
    }
    for (int32_t triangle = 0; triangle < domain->cells; triangle++) {
        for (int k = 0; k < 3; k++) {
            int32_t vertex = vertex_of(domain, triangle, k);
            if (vertex != MISSING) {
                row[vertex] = 1;
            }
        }
    }
    for (int32_t vertex = 0; vertex < domain->vertices; vertex++) {
        if (row[vertex] == 0) {
            row[vertex] = MISSING;
            continue;
        }
        double lon = domain->lon_vertex[vertex], lat = domain->lat_vertex[vertex];
        grid->lon_cell[grid->cells] = lon;
        grid->lat_cell[grid->cells] = lat;
        grid->cell_number[grid->cells] = number_of(lon, lat);
        row[vertex] = (int32_t)grid->cells++;
    }
    for (int32_t triangle = 0; triangle < domain->cells; triangle++) {
        for (int k = 0; k < 3; k++) {
            int32_t vertex = vertex_of(domain, triangle, k);
            grid->corner_cell[3 * (int64_t)triangle + k] = vertex == MISSING ? MISSING : row[vertex];
        }
        grid->corner_number[triangle] = (int64_t)domain->global_index[triangle] - 1;
        grid->owns_corner[triangle] = domain->decomposition[triangle] == 0;
        grid->own_corners += grid->owns_corner[triangle];
    }
    free(row);
    return 1;
}

static int is_whole(const int32_t *cells)
{
    return cells[0] != MISSING && cells[1] != MISSING && cells[2] != MISSING;
}

/* Numbers the edges: each is found in the list of its vertex of the lower number. */
static int find_edges(grid_tables *grid)
{
    int64_t sides = 3 * (int64_t)grid->domain.cells;
    int32_t *first = zeros(grid->cells, sizeof *first); /* edge + 1 */
    int32_t *next = zeros(sides, sizeof *next), *end = zeros(sides, sizeof *end);
    int has_memory = first != NULL && next != NULL && end != NULL;
    for (int64_t side = 0; has_memory && side < sides; side++) {
        const int32_t *cells = grid->corner_cell + side / 3 * 3;
        int32_t a = cells[side % 3], b = cells[(side + 1) % 3], edge;
        grid->corner_edge[side] = MISSING;
        if (!is_whole(cells)) {
            continue;
        }
        if (a > b) {
            int32_t c = a;
            a = b;
            b = c;
        }
        for (edge = first[a] - 1; edge != MISSING && end[edge] != b;) {
            edge = next[edge] - 1;
        }
        if (edge == MISSING) {
            edge = (int32_t)grid->edges++;
            end[edge] = b;
            next[edge] = first[a];
            first[a] = edge + 1;
            grid->edge_corner[2 * (int64_t)edge] = grid->edge_corner[2 * (int64_t)edge + 1] = MISSING;
        }
        grid->corner_edge[side] = edge;
        int is_second = grid->edge_corner[2 * (int64_t)edge] != MISSING;
        grid->edge_corner[2 * (int64_t)edge + is_second] = (int32_t)(side / 3);
    }
    free(first);
    free(next);
    free(end);
    return has_memory;
}

/* Lists the triangles around each vertex by their global numbers, an order that does not depend on the ranks. The rank
 * that owns the first one owns the vertex: ranks with an own triangle there have all of them. */
static int surround(grid_tables *grid)
{
    int64_t sides = 3 * (int64_t)grid->domain.cells;
    int32_t *count = grid->cell_corner_count;
    grid->cell_corner_row = 6;
    for (int64_t side = 0; side < sides; side++) {
        int32_t cell = grid->corner_cell[side];
        if (cell != MISSING && ++count[cell] > grid->cell_corner_row) {
            grid->cell_corner_row = count[cell];
        }
    }
    int64_t row = grid->cell_corner_row;
    grid->cell_corner = zeros(grid->cells * row, sizeof *grid->cell_corner);
    if (grid->cell_corner == NULL) {
        return 0;
    }
    for (int64_t at = 0; at < grid->cells * row; at++) {
        grid->cell_corner[at] = MISSING;
    }
    for (int64_t cell = 0; cell < grid->cells; cell++) {
        count[cell] = 0;
    }
    for (int64_t side = 0; side < sides; side++) {
        int32_t cell = grid->corner_cell[side], triangle = (int32_t)(side / 3);
        if (cell != MISSING) {
            int32_t *around = grid->cell_corner + cell * row, at = count[cell]++;
            for (; at > 0 && grid->corner_number[around[at - 1]] > grid->corner_number[triangle]; at--) {
                around[at] = around[at - 1];
            }
            around[at] = triangle;
        }
    }
    for (int64_t cell = 0; cell < grid->cells; cell++) {
        grid->owns_cell[cell] = grid->owns_corner[grid->cell_corner[cell * row]];
        /* At a rim a row has fewer; missing ones follow. */
        count[cell] = count[cell] < 3 ? 3 : count[cell];
    }
    return 1;
}

int grid_make(grid_tables *grid, int domain)
{
    *grid = (grid_tables){.cells = 0};
    host_read_domain(domain, &grid->domain);
    if (domain > 1) {
        snprintf(grid->name, sizeof grid->name, "DOM%02d", domain % 100);
    }
    int64_t triangles = grid->domain.cells, vertices = grid->domain.vertices;
    grid->lon_cell = zeros(vertices, sizeof *grid->lon_cell);
    grid->lat_cell = zeros(vertices, sizeof *grid->lat_cell);
    grid->cell_number = zeros(vertices, sizeof *grid->cell_number);
    grid->owns_cell = zeros(vertices, sizeof *grid->owns_cell);
    grid->cell_corner_count = zeros(vertices, sizeof *grid->cell_corner_count);
    grid->corner_cell = zeros(3 * triangles, sizeof *grid->corner_cell);
    grid->corner_edge = zeros(3 * triangles, sizeof *grid->corner_edge);
    grid->edge_corner = zeros(6 * triangles, sizeof *grid->edge_corner);
    grid->corner_number = zeros(triangles, sizeof *grid->corner_number);
    grid->owns_corner = zeros(triangles, sizeof *grid->owns_corner);
    int has_memory = grid->lon_cell && grid->lat_cell && grid->cell_number && grid->owns_cell &&
                     grid->cell_corner_count && grid->corner_cell && grid->corner_edge && grid->edge_corner &&
                     grid->corner_number && grid->owns_corner;
    return has_memory && take_vertices(grid) && find_edges(grid) && surround(grid);
}

void grid_free(grid_tables *grid)
{
    free(grid->lon_cell);
    free(grid->lat_cell);
    free(grid->corner_cell);
    free(grid->corner_edge);
    free(grid->edge_corner);
    free(grid->cell_corner);
    free(grid->cell_corner_count);
    free(grid->cell_number);
    free(grid->corner_number);
    free(grid->owns_cell);
    free(grid->owns_corner);
    *grid = (grid_tables){.cells = 0};
}

void grid_describe(const grid_tables *grid, icoray_grid *to)
{
    *to = (icoray_grid){.struct_size = sizeof *to};
    to->cells = grid->cells;
    to->corners = grid->domain.cells;
    to->edges = grid->edges;
    to->real_type = ICORAY_F64;
    to->index_type = ICORAY_I32;
    to->lon_center_rad = grid->lon_cell;
    to->lat_center_rad = grid->lat_cell;
    to->lon_corner_rad = grid->domain.lon_triangle;
    to->lat_corner_rad = grid->domain.lat_triangle;
    to->cell_corner = grid->cell_corner;
    to->cell_corner_row = grid->cell_corner_row;
    to->cell_corner_count = grid->cell_corner_count;
    to->corner_cell = grid->corner_cell;
    to->corner_edge = grid->corner_edge;
    to->edge_corner = grid->edge_corner;
    to->name = grid->name;
}

void grid_describe_part(const grid_tables *grid, icoray_part *to)
{
    *to = (icoray_part){.struct_size = sizeof *to};
    to->grid = grid->name;
    to->cells = grid->cells;
    to->index_type = ICORAY_I64;
    to->cell_global = grid->cell_number;
    to->is_owned = grid->owns_cell;
    /* A rank that owns all triangles has them in its own order. */
    if (grid->own_corners < grid->domain.cells_of_all_ranks) {
        to->corners = grid->domain.cells;
        to->corner_global = to->corners > 0 ? grid->corner_number : NULL;
        to->is_corner_owned = grid->owns_corner;
    }
}
