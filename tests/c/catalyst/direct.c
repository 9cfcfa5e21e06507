/* Draws what a host shows over Catalyst, from whole arrays in one process: direct SCENE wedges|prisms flat|hills STEPS. */
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

int main(int argc, char **argv)
{
    if (argc != 5) {
        return 2;
    }
    int is_wedges = strcmp(argv[2], "wedges") == 0, has_hills = strcmp(argv[3], "hills") == 0;
    ball of = ball_make(is_wedges);
    icoray_mesh *mesh = NULL;
    icoray_grid grid = {sizeof grid};
    icoray_config config = {sizeof config};
    icoray_layers layers = {sizeof layers};
    icoray_ctx *ctx = NULL;
    double radii[LEVELS] = {0};
    size_t points = (size_t)of.columns * LEVELS, elements = (size_t)of.polygons * LAYERS;
    double *at_points = malloc(points * sizeof(double)), *at_elements = malloc(elements * sizeof(double));
    double *heights = malloc(points * sizeof(double)), *lon = malloc((size_t)of.polygons * sizeof(double));
    double *lat = malloc((size_t)of.polygons * sizeof(double));
    config.output_dir = "pictures";
    check(NULL, icoray_mesh_create(3, &mesh));
    check(NULL, icoray_mesh_grid(mesh, &grid));
    check(NULL, icoray_open_serial(&config, &ctx));
    if (!is_wedges) {
        /* Hosts give the cells' corners; their middles are the centroids. */
        for (int i = 0; i < of.polygons; i++) {
            double x[3];
            ball_middle(&of, i, x);
            lon[i] = atan2(x[1], x[0]);
            lat[i] = asin(x[2]);
        }
        grid.lon_center_rad = lon;
        grid.lat_center_rad = lat;
    }
    check(ctx, icoray_grid_set(ctx, &grid));
    for (int level = 0; level < LEVELS; level++) {
        for (int column = 0; column < of.columns; column++) {
            double radius = ball_radius(&of, column, level, has_hills);
            radii[level] += radius / of.columns;
            heights[column * LEVELS + level] = radius - 6.371229e6;
        }
    }
    layers.count = LEVELS;
    layers.radius_m = radii;
    layers.planet_radius_m = 6.371229e6;
    check(ctx, icoray_layers_set(ctx, &layers));
    int location = is_wedges ? ICORAY_CENTER : ICORAY_CORNER;
    icoray_array of_points = array(at_points, location, of.columns, LEVELS), of_heights = of_points;
    icoray_array of_elements = array(at_elements, is_wedges ? ICORAY_CORNER : ICORAY_CENTER, of.polygons, LAYERS);
    of_heights.data = heights;
    check(ctx, icoray_heights_set(ctx, &of_heights));
    check(ctx, icoray_field_set(ctx, "theta", &of_points));
    check(ctx, icoray_field_set(ctx, "q", &of_elements));
    check(ctx, icoray_scene_load(ctx, argv[1]));
    for (int step = 0; step < atoi(argv[4]); step++) {
        for (int i = 0; i < of.columns * LEVELS; i++) {
            at_points[i] = ball_at_point(&of, i / LEVELS, i % LEVELS, step);
        }
        for (int i = 0; i < of.polygons * LAYERS; i++) {
            at_elements[i] = ball_at_element(&of, i / LAYERS, i % LAYERS, step);
        }
        check(ctx, icoray_execute(ctx, step, 0.5 * step, NULL));
    }
    check(ctx, icoray_close(&ctx));
    return 0;
}
