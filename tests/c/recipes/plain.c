/* Draws the pictures of the recipes from plain arrays: plain STEPS, with scene.toml in the directory of the run. */
#include <icoray.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LAYERS = 6 };

static void check(icoray_ctx *ctx, icoray_status status)
{
    char message[401];
    if (status != ICORAY_OK) {
        icoray_last_error(ctx, message, sizeof message);
        fprintf(stderr, "%s\n", message);
        exit(1);
    }
}

int main(int argc, char **argv)
{
    icoray_ctx *ctx = NULL;
    icoray_mesh *mesh = NULL;
    icoray_grid grid = {sizeof grid};
    int steps = argc > 1 ? atoi(argv[1]) : 1;
    check(NULL, icoray_mesh_create(3, &mesh));
    check(NULL, icoray_mesh_grid(mesh, &grid));
    const double *lon = grid.lon_center_rad, *lat = grid.lat_center_rad;
    double radius[LAYERS], *q = malloc((size_t)grid.cells * LAYERS * sizeof *q);
    for (int k = 0; k < LAYERS; k++) {
        radius[k] = 6371e3 + 5e3 * k;
    }
    icoray_layers layers = {sizeof layers};
    layers.count = LAYERS;
    layers.radius_m = radius;
    layers.planet_radius_m = 6371e3;
    icoray_array array = {sizeof array};
    array.data = q;
    array.type = ICORAY_F64;
    array.columns = grid.cells;
    array.layers = array.column_stride = LAYERS;
    array.layer_stride = 1;
    icoray_config config = {sizeof config};
    config.output_dir = "pictures";
    check(NULL, icoray_open_serial(&config, &ctx));
    check(ctx, icoray_grid_set(ctx, &grid));
    check(ctx, icoray_layers_set(ctx, &layers));
    check(ctx, icoray_scene_load(ctx, "scene.toml"));
    for (int step = 0; step < steps; step++) {
        for (int64_t i = 0; i < grid.cells; i++) {
            for (int k = 0; k < LAYERS; k++) {
                q[i * LAYERS + k] = sin(3.0 * lon[i] + 0.3 * k + 0.5 * step) * cos(lat[i]);
            }
        }
        check(ctx, icoray_field_set(ctx, "q", &array));
        check(ctx, icoray_execute(ctx, step, step, NULL));
    }
    check(ctx, icoray_close(&ctx));
    return 0;
}
