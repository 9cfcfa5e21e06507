/* What the recipes draw, from plain arrays: plain [ocean] STEPS, with scene.toml in the directory of the run. */
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
    int is_ocean = argc > 2, levels = is_ocean ? LAYERS + 1 : LAYERS;
    check(NULL, icoray_mesh_create(3, &mesh));
    check(NULL, icoray_mesh_grid(mesh, &grid));
    const double *lon = grid.lon_center_rad, *lat = grid.lat_center_rad;
    double radius[LAYERS + 1], *q = malloc((size_t)grid.cells * LAYERS * sizeof *q);
    double *heights = malloc((size_t)grid.cells * (LAYERS + 1) * sizeof *heights);
    for (int k = 0; k < levels; k++) {
        /* From below. */
        radius[k] = 6371e3 + 5e3 * (is_ocean ? k - LAYERS : k);
    }
    icoray_layers layers = {sizeof layers};
    layers.count = levels;
    layers.radius_m = radius;
    layers.planet_radius_m = 6371e3;
    icoray_array array = {sizeof array}, of_heights;
    array.data = q;
    array.type = ICORAY_F64;
    array.columns = grid.cells;
    array.layers = array.column_stride = LAYERS;
    array.layer_stride = 1;
    of_heights = array;
    of_heights.data = heights;
    of_heights.layers = of_heights.column_stride = LAYERS + 1;
    icoray_config config = {sizeof config};
    config.output_dir = "pictures";
    check(NULL, icoray_open_serial(&config, &ctx));
    check(ctx, icoray_grid_set(ctx, &grid));
    check(ctx, icoray_layers_set(ctx, &layers));
    check(ctx, icoray_scene_load(ctx, "scene.toml"));
    for (int step = 0; step < atoi(argv[1]); step++) {
        for (int64_t i = 0; i < grid.cells; i++) {
            int wet = is_ocean ? 3 + (int)((i + 1) % 4) : LAYERS;
            for (int k = 0; k < LAYERS; k++) {
                int at = is_ocean ? LAYERS - 1 - k : k;
                double value = sin(3.0 * lon[i] + 0.3 * k + 0.5 * step) * cos(lat[i]);
                q[i * LAYERS + at] = k < wet ? value : NAN;
            }
            for (int k = 0; k <= LAYERS; k++) {
                int above = k < wet ? k : wet;
                heights[i * (LAYERS + 1) + LAYERS - k] = 300.0 * sin(2.0 * lon[i]) * cos(lat[i]) - 5e3 * above;
            }
        }
        check(ctx, icoray_field_set(ctx, "q", &array));
        if (is_ocean) {
            check(ctx, icoray_heights_set(ctx, &of_heights));
        }
        check(ctx, icoray_execute(ctx, step, step, NULL));
    }
    check(ctx, icoray_close(&ctx));
    return 0;
}
