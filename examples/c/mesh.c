#include "mesh.h"

#include "planet.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void *allocate(int rows, int row, size_t size)
{
    void *memory = calloc((size_t)rows * (size_t)row, size);
    if (memory == NULL) {
        fprintf(stderr, "tracer: out of memory\n");
        exit(EXIT_FAILURE);
    }
    return memory;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

double angle(const double a[3], const double b[3])
{
    double normal[3];
    cross(a, b, normal);
    return atan2(sqrt(dot(normal, normal)), dot(a, b));
}

/* Area of a triangle on the unit sphere (van Oosterom and Strackee 1983). */
static double triangle_area(const double a[3], const double b[3], const double c[3])
{
    double normal[3];
    cross(a, b, normal);
    return 2.0 * atan2(fabs(dot(normal, c)), 1.0 + dot(a, b) + dot(b, c) + dot(c, a));
}

Place place_at(double lon, double lat)
{
    Place p = {{cos(lat) * cos(lon), cos(lat) * sin(lon), sin(lat)}, sin(lon), cos(lon), sin(lat), cos(lat)};
    return p;
}

/* The place in the direction of a vector of any length. */
static Place place_along(const double v[3])
{
    return place_at(atan2(v[1], v[0]), atan2(v[2], hypot(v[0], v[1])));
}

/* The offset from one place to another in the tangent plane of the first, east and north, m. */
static void offset_between(const Place *from, const Place *to, double out[2])
{
    double east[3] = {-from->sin_lon, from->cos_lon, 0.0}, north[3];
    cross(from->xyz, east, north);
    out[0] = RADIUS * dot(to->xyz, east);
    out[1] = RADIUS * dot(to->xyz, north);
}

/* The two cells on the sides of an edge are those that its two corners share, whatever the order of the tables. */
static void shared_cells(const icoray_grid *grid, const int corner[2], int out[2])
{
    const int32_t *corner_cell = grid->corner_cell;
    int found = 0;
    for (int i = 0; i < 9; i++) {
        int cell = corner_cell[3 * corner[0] + i / 3];
        if (cell == corner_cell[3 * corner[1] + i % 3] && found < 2) {
            out[found++] = cell - grid->index_base;
        }
    }
    if (found != 2) {
        fprintf(stderr, "tracer: an edge without two cells\n");
        exit(EXIT_FAILURE);
    }
}

/* Joins the tables into sides; adds up the area and centroid of each cell, triangle by triangle. */
static void build_sides(Mesh *mesh, const icoray_grid *grid)
{
    const double *lon = grid->lon_center_rad, *lat = grid->lat_center_rad;
    const int32_t *edge_corner = grid->edge_corner;
    double *moment = allocate(mesh->cells, 3, sizeof *moment);
    for (int e = 0; e < mesh->sides; e++) {
        Side *side = &mesh->side[e];
        double sum[3], along[3], normal[3], ahead = 0.0;
        side->corner[0] = edge_corner[2 * e] - grid->index_base;
        side->corner[1] = edge_corner[2 * e + 1] - grid->index_base;
        shared_cells(grid, side->corner, side->cell);
        const double *a = mesh->corner[side->corner[0]].xyz, *b = mesh->corner[side->corner[1]].xyz;
        for (int i = 0; i < 3; i++) {
            sum[i] = a[i] + b[i];
            along[i] = b[i] - a[i];
        }
        side->middle = place_along(sum);
        cross(along, side->middle.xyz, normal);
        for (int s = 0; s < 2; s++) {
            int c = side->cell[s];
            Place centre = place_at(lon[c], lat[c]);
            double area = triangle_area(centre.xyz, a, b);
            mesh->cell[c].area += area * RADIUS * RADIUS;
            for (int i = 0; i < 3; i++) {
                moment[3 * c + i] += area * (centre.xyz[i] + sum[i]) / 3.0;
            }
            ahead += (s == 0 ? -1.0 : 1.0) * dot(normal, centre.xyz);
        }
        double east = normal[1] * side->middle.cos_lon - normal[0] * side->middle.sin_lon;
        side->length_east = RADIUS * angle(a, b) * east / sqrt(dot(along, along));
        if (ahead < 0.0) { /* the normal must point from cell[0] to cell[1] */
            int swap = side->cell[0];
            side->cell[0] = side->cell[1];
            side->cell[1] = swap;
        }
    }
    for (int c = 0; c < mesh->cells; c++) {
        mesh->cell[c].centroid = place_along(moment + 3 * c);
    }
    free(moment);
}

/* Lists the neighbours of each cell, with the weights of its least-squares gradient. */
static void build_cells(Mesh *mesh)
{
    for (int i = 0; i < 2 * mesh->sides; i++) {
        Side *side = &mesh->side[i / 2];
        Cell *cell = &mesh->cell[side->cell[i % 2]];
        int j = cell->count++;
        if (j == SIDES) {
            fprintf(stderr, "tracer: a cell with more than %d sides\n", SIDES);
            exit(EXIT_FAILURE);
        }
        cell->neighbour[j] = side->cell[1 - i % 2];
        offset_between(&cell->centroid, &side->middle, cell->offset[j]);
        offset_between(&cell->centroid, &mesh->cell[cell->neighbour[j]].centroid, cell->weight[j]);
        memcpy(side->offset[i % 2], cell->offset[j], sizeof cell->offset[j]);
    }
    mesh->shortest = RADIUS;
    for (int c = 0; c < mesh->cells; c++) {
        Cell *cell = &mesh->cell[c];
        double xx = 0.0, xy = 0.0, yy = 0.0;
        for (int j = 0; j < cell->count; j++) {
            double x = cell->weight[j][0], y = cell->weight[j][1];
            xx += x * x, xy += x * y, yy += y * y;
            mesh->shortest = fmin(mesh->shortest, hypot(x, y));
        }
        for (int j = 0; j < cell->count; j++) {
            double x = cell->weight[j][0], y = cell->weight[j][1], determinant = xx * yy - xy * xy;
            cell->weight[j][0] = (yy * x - xy * y) / determinant;
            cell->weight[j][1] = (xx * y - xy * x) / determinant;
        }
        for (int j = cell->count; j < SIDES; j++) {
            cell->neighbour[j] = c;
        }
    }
}

Mesh mesh_new(const icoray_grid *grid, int layers)
{
    Mesh mesh = {(int)grid->cells, (int)grid->corners, (int)grid->edges, layers, NULL, NULL, NULL, 0.0, NULL};
    const double *lon = grid->lon_corner_rad, *lat = grid->lat_corner_rad;
    mesh.cell = allocate(mesh.cells, 1, sizeof *mesh.cell);
    mesh.corner = allocate(mesh.corners, 1, sizeof *mesh.corner);
    mesh.side = allocate(mesh.sides, 1, sizeof *mesh.side);
    mesh.radius = allocate(layers, 1, sizeof *mesh.radius);
    for (int v = 0; v < mesh.corners; v++) {
        mesh.corner[v] = place_at(lon[v], lat[v]);
    }
    build_sides(&mesh, grid);
    build_cells(&mesh);
    for (int k = 0; k < layers; k++) {
        mesh.radius[k] = RADIUS + (k + 0.5) * MODEL_TOP / layers;
    }
    return mesh;
}

void mesh_free(Mesh *mesh)
{
    free(mesh->cell);
    free(mesh->corner);
    free(mesh->side);
    free(mesh->radius);
}
