#include "icon.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

const icon_variable icon_variables[ALL_VARIABLES] = {
    {"temp", LEVELS, AT_TRIANGLES, "temperature", "K"},
    {"w", LEVELS + 1, AT_TRIANGLES, "vertical velocity", "m s-1"},
    {"ps", 0, AT_TRIANGLES, "surface pressure", "Pa"},
    {"qv", LEVELS, AT_TRIANGLES, "specific humidity", "kg kg-1"},
    {"vn", LEVELS, AT_EDGES, "velocity", "m s-1"},
    {"omega_z", LEVELS, AT_VERTICES, "", "s-1  "},
    {"few", LEVELS, AT_TRIANGLES, "few", "1"},
    {"many", LEVELS, AT_EDGES, "many", "1"}};
const double icon_half_levels[LEVELS + 1] = {24e3, 16e3, 10e3, 5e3, 2e3, 0.0};

double icon_height(double lon, double lat, int level)
{
    /* 0 on average, so that the mean heights are those over flat ground. */
    double ground = 900.0 * sin(3.0 * lon) * cos(lat) * sin(2.0 * lat), z = icon_half_levels[level];
    return z + ground * (1.0 - z / icon_half_levels[0]);
}

double icon_value(int variable, double lon, double lat, int level, int step)
{
    double x = cos(lat) * cos(lon), y = cos(lat) * sin(lon), z = sin(lat);
    return sin(3.0 * x + 0.4 * step) * cos((2.0 + variable) * y) + 0.5 * z + 0.15 * level;
}

/* In strips, with some single triangles of other ranks among them: these own none of their vertices. */
static int owner_of(int triangle, double lon, double lat, int ranks)
{
    int strip = (int)((lon + 7.0) * 1.7) + (lat > 0.3);
    return (strip + (triangle % 11 == 3 ? 1 : 0)) % ranks;
}

/* Numbers the triangles of the mesh that are in the domain, from 0; others are -1. */
static int choose(const icoray_grid *mesh, int number, int *global)
{
    const double *lat = mesh->lat_corner_rad;
    int count = 0;
    for (int64_t triangle = 0; triangle < mesh->corners; triangle++) {
        global[triangle] = number == 1 || lat[triangle] > 0.9 ? count++ : -1;
    }
    return count;
}

static void *zeros(size_t count, size_t size)
{
    void *memory = calloc(count + 1, size);
    if (memory == NULL) {
        abort();
    }
    return memory;
}

icon_domain icon_make(int number, int rank, int ranks)
{
    icon_domain to = {0};
    icoray_mesh *mesh = NULL;
    icoray_grid of = {sizeof of};
    if (icoray_mesh_create(number + 1, &mesh) || icoray_mesh_grid(mesh, &of)) {
        abort();
    }
    const int32_t *cells = of.corner_cell;
    const double *lon = of.lon_corner_rad, *lat = of.lat_corner_rad;
    const double *lon_cell = of.lon_center_rad, *lat_cell = of.lat_center_rad;
    int *global = zeros((size_t)of.corners, sizeof *global), *vertex = zeros((size_t)of.cells, sizeof *vertex);
    int *touched = zeros((size_t)of.cells, sizeof *touched), *order = zeros((size_t)of.corners, sizeof *order);
    to.all_triangles = choose(&of, number, global);
#define IS_OWN(t) (global[t] >= 0 && owner_of(global[t], lon[t], lat[t], ranks) == rank)
    for (int64_t t = 0; t < of.corners; t++) {
        for (int k = 0; k < 3 && IS_OWN(t); k++) {
            touched[cells[3 * t + k]] = 1;
        }
    }
    /* Own triangles come first, then those that share two vertices with them, or one. */
    int own = 0;
    for (int shared = 3; shared >= 1; shared--) {
        for (int64_t t = 0; t < of.corners; t++) {
            int count = touched[cells[3 * t]] + touched[cells[3 * t + 1]] + touched[cells[3 * t + 2]];
            int is_halo = global[t] >= 0 && !IS_OWN(t) && (shared == 2 ? count >= 2 : count == 1);
            if (shared == 3 ? IS_OWN(t) : is_halo) {
                order[to.triangles++] = (int)t;
            }
        }
        own = shared == 3 ? to.triangles : own;
    }
    to.blocks = (to.triangles + NPROMA - 1) / NPROMA;
    size_t columns = (size_t)to.blocks * NPROMA;
    to.vertex_index = zeros(3 * columns, sizeof(int));
    to.vertex_block = zeros(3 * columns, sizeof(int));
    to.global_index = zeros(columns, sizeof(int));
    to.decomposition = zeros(columns, sizeof(int));
    to.lon_triangle = zeros(columns, sizeof(double));
    to.lat_triangle = zeros(columns, sizeof(double));
    to.lon_vertex = zeros((size_t)of.cells + NPROMA, sizeof(double));
    to.lat_vertex = zeros((size_t)of.cells + NPROMA, sizeof(double));
    to.heights = zeros(columns * (LEVELS + 1), sizeof(double));
    for (size_t i = 0; i < columns; i++) {
        to.decomposition[i] = -1;
        for (int level = 0; level <= LEVELS; level++) {
            to.heights[i % NPROMA + NPROMA * (level + (LEVELS + 1) * (i / NPROMA))] = NAN;
        }
    }
    for (int i = 0; i < to.triangles; i++) {
        int t = order[i];
        to.global_index[i] = global[t] + 1;
        to.decomposition[i] = i < own ? 0 : 1 + (touched[cells[3 * t]] + touched[cells[3 * t + 1]] +
                                                     touched[cells[3 * t + 2]] == 1);
        to.lon_triangle[i] = lon[t];
        to.lat_triangle[i] = lat[t];
        for (int k = 0; k < 3; k++) {
            int cell = cells[3 * t + k];
            if (vertex[cell] == 0) {
                to.lon_vertex[to.vertices] = lon_cell[cell];
                to.lat_vertex[to.vertices] = lat_cell[cell];
                vertex[cell] = ++to.vertices;
            }
            to.vertex_index[i + (size_t)k * columns] = (vertex[cell] - 1) % NPROMA + 1;
            to.vertex_block[i + (size_t)k * columns] = (vertex[cell] - 1) / NPROMA + 1;
        }
        for (int level = 0; level <= LEVELS && i < own; level++) {
            size_t at = (size_t)(i % NPROMA + NPROMA * (level + (LEVELS + 1) * (i / NPROMA)));
            to.heights[at] = icon_height(lon[t], lat[t], level);
        }
    }
    to.vertex_blocks = (to.vertices + NPROMA - 1) / NPROMA;
    free(global);
    free(vertex);
    free(touched);
    free(order);
    icoray_mesh_free(&mesh);
    return to;
}

int icon_blocks(const icon_domain *domain, const icon_variable *variable)
{
    int edges = 3 * domain->triangles / 2, is_few = variable == &icon_variables[ALL_VARIABLES - 2];
    return variable->place == AT_EDGES      ? edges / NPROMA + 1
           : variable->place == AT_VERTICES ? domain->vertex_blocks
                                            : domain->blocks - is_few;
}

int icon_values(const icon_domain *domain, int variable)
{
    int levels = icon_variables[variable].levels;
    return icon_blocks(domain, &icon_variables[variable]) * NPROMA * (levels > 0 ? levels : 1);
}

void icon_fill(const icon_domain *domain, int variable, int step, double *values)
{
    const icon_variable *of = &icon_variables[variable];
    int levels = of->levels > 0 ? of->levels : 1, at_vertices = of->place == AT_VERTICES;
    int count = at_vertices ? domain->vertices : of->place == AT_EDGES ? 0 : domain->triangles;
    const double *lon = at_vertices ? domain->lon_vertex : domain->lon_triangle;
    const double *lat = at_vertices ? domain->lat_vertex : domain->lat_triangle;
    for (int i = 0; i < icon_blocks(domain, of) * NPROMA; i++) {
        for (int level = 0; level < levels; level++) {
            int is_own = i < count && (at_vertices || domain->decomposition[i] == 0);
            double value = is_own ? icon_value(variable, lon[i], lat[i], level, step) : NAN;
            values[i % NPROMA + NPROMA * (level + levels * (i / NPROMA))] = value;
        }
    }
}

void icon_date(int step, char date[48])
{
    int hours = 12 + step / 2;
    int day = 28 + hours / 24;
    snprintf(date, 48, "2026-%02d-%02dT%02d:%02d:00.000", day > 28 ? 3 : 2, day > 28 ? day - 28 : day, hours % 24,
             30 * (step % 2));
}
