/* Draws what a host shows over Catalyst, from whole arrays in one process: direct SCENE
 * wedges|prisms|hexes|points flat|hills STEPS. */
#include "ball.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void check(icoray_ctx *ctx, icoray_status status)
{
    char message[401];
    if (status != ICORAY_OK) {
        icoray_last_error(ctx, message, sizeof message);
        fprintf(stderr, "%s\n", message);
        exit(1);
    }
}

static icoray_array array(double *values, int location, int columns, int layers)
{
    icoray_array to = {sizeof to};
    to.data = values;
    to.type = ICORAY_F64;
    to.location = location;
    to.columns = columns;
    to.layers = to.column_stride = layers;
    to.layer_stride = 1;
    return to;
}

/* Sets the mesh of an icosahedral ball, whose cells' middles are the centroids of their corners: hosts give these. */
static void set_grid(icoray_ctx *ctx, const ball *of, const double *lon, const double *lat)
{
    static icoray_mesh *mesh; /* until the process ends, as the context reads it */
    icoray_grid grid = {sizeof grid};
    check(NULL, icoray_mesh_create(3, &mesh));
    check(NULL, icoray_mesh_grid(mesh, &grid));
    if (of->shape == PRISMS) {
        grid.lon_center_rad = lon;
        grid.lat_center_rad = lat;
    }
    check(ctx, icoray_grid_set(ctx, &grid));
}

static void angles(const double x[3], double *lon, double *lat)
{
    *lon = atan2(x[1], x[0]);
    *lat = asin(x[2]);
}

/* Sets heights of columns of points, or means of them of columns of elements. */
static double *heights(const ball *of, int is_at_points, int has_hills)
{
    int columns = is_at_points ? of->columns : of->polygons;
    double *to = calloc((size_t)columns * LEVELS, sizeof *to);
    for (int i = 0; i < columns * LEVELS; i++) {
        int sides = is_at_points ? 1 : of->sides[i / LEVELS];
        for (int k = 0; k < sides; k++) {
            int column = is_at_points ? i / LEVELS : of->polygon[6 * (i / LEVELS) + k];
            to[i] += (ball_radius(of, column, i % LEVELS, has_hills) - 6.371229e6) / sides;
        }
    }
    return to;
}

int main(int argc, char **argv)
{
    if (argc != 5) {
        return 2;
    }
    int has_hills = strncmp(argv[3], "hills", 5) == 0;
    ball of = ball_make(argv[2]);
    icoray_config config = {sizeof config};
    icoray_layers layers = {sizeof layers};
    icoray_ctx *ctx = NULL;
    /* A single layer has a thin shell above it. */
    double radii[LEVELS + 1] = {0};
    size_t points = (size_t)of.columns * LEVELS, elements = (size_t)of.polygons * (size_t)of.layers;
    double *at_points = malloc(points * sizeof(double)), *at_elements = malloc(elements * sizeof(double));
    size_t most = (size_t)(of.columns > of.polygons ? of.columns : of.polygons);
    double *lon = malloc(most * sizeof(double)), *lat = malloc(most * sizeof(double));
    config.output_dir = "pictures";
    check(NULL, icoray_open_serial(&config, &ctx));
    for (int i = 0; i < of.columns; i++) {
        angles(of.x + 3 * i, lon + i, lat + i);
    }
    if (of.shape == HEXES || of.shape == POINTS) {
        check(ctx, icoray_points_set(ctx, "points", of.columns, ICORAY_F64, lon, lat));
    }
    for (int i = 0; i < of.polygons; i++) {
        double x[3];
        ball_middle(&of, i, x);
        angles(x, lon + i, lat + i);
    }
    if (of.shape == HEXES || of.shape == POINTS) {
        check(ctx, icoray_points_set(ctx, "elements", of.polygons, ICORAY_F64, lon, lat));
    } else {
        set_grid(ctx, &of, lon, lat);
    }
    for (int i = 0; i < of.columns * LEVELS; i++) {
        radii[i % LEVELS] += ball_radius(&of, i / LEVELS, i % LEVELS, has_hills) / of.columns;
    }
    radii[LEVELS] = 1.001 * radii[LEVELS - 1];
    layers.count = LEVELS > 1 ? LEVELS : 2;
    layers.radius_m = radii;
    layers.planet_radius_m = 6.371229e6;
    check(ctx, icoray_layers_set(ctx, &layers));
    int is_at_cells[] = {of.shape != PRISMS, of.shape != WEDGES};
    icoray_array of_points = array(at_points, is_at_cells[0] ? ICORAY_CENTER : ICORAY_CORNER, of.columns, LEVELS);
    icoray_array of_elements = array(at_elements, is_at_cells[1] ? ICORAY_CENTER : ICORAY_CORNER, of.polygons, of.layers);
    if (of.shape == HEXES || of.shape == POINTS) {
        of_points.grid_name = "points";
        of_elements.grid_name = of.shape == HEXES ? "elements" : "points";
    }
    /* Hexahedra have heights where their only field is. */
    int is_at_points = strcmp(argv[3], "hills q") != 0;
    icoray_array of_heights = is_at_points ? of_points : of_elements;
    of_heights.data = heights(&of, is_at_points, has_hills);
    of_heights.layers = of_heights.column_stride = LEVELS;
    check(ctx, icoray_heights_set(ctx, &of_heights));
    check(ctx, icoray_field_set(ctx, "theta", &of_points));
    check(ctx, icoray_field_set(ctx, "q", &of_elements));
    check(ctx, icoray_scene_load(ctx, argv[1]));
    for (int step = 0; step < atoi(argv[4]); step++) {
        for (int i = 0; i < of.columns * LEVELS; i++) {
            at_points[i] = ball_at_point(&of, i / LEVELS, i % LEVELS, step);
        }
        for (int i = 0; i < of.polygons * of.layers; i++) {
            at_elements[i] = ball_at_element(&of, i / of.layers, i % of.layers, step);
        }
        check(ctx, icoray_execute(ctx, step, 0.5 * step, NULL));
    }
    check(ctx, icoray_close(&ctx));
    return 0;
}
