/* Draws what the plugin draws of domain 1, from whole arrays in one process: direct SCENE FIRST LAST. */
#include "icon.h"

#include <stdio.h>
#include <stdlib.h>

static void check(icoray_ctx *ctx, icoray_status status)
{
    char message[401];
    if (status != ICORAY_OK) {
        icoray_last_error(ctx, message, sizeof message);
        fprintf(stderr, "%s\n", message);
        exit(1);
    }
}

static double *array(icoray_ctx *ctx, const icoray_grid *grid, const char *name, int levels, int place)
{
    int64_t columns = place == AT_VERTICES ? grid->cells : grid->corners;
    double *values = malloc((size_t)columns * (size_t)levels * sizeof *values);
    icoray_array to = {sizeof to};
    to.data = values;
    to.type = ICORAY_F64;
    to.location = place == AT_VERTICES ? ICORAY_CENTER : ICORAY_CORNER;
    to.columns = columns;
    to.layers = to.column_stride = levels;
    to.layer_stride = 1;
    check(ctx, name != NULL ? icoray_field_set(ctx, name, &to) : icoray_heights_set(ctx, &to));
    return values;
}

int main(int argc, char **argv)
{
    icoray_mesh *mesh = NULL;
    icoray_grid grid = {sizeof grid};
    icoray_config config = {sizeof config};
    icoray_layers layers = {sizeof layers};
    icoray_ctx *ctx = NULL;
    double radii[LEVELS + 1], *values[ALL_VARIABLES];
    config.output_dir = "pictures";
    check(NULL, icoray_mesh_create(2, &mesh));
    check(NULL, icoray_mesh_grid(mesh, &grid));
    check(NULL, icoray_open_serial(&config, &ctx));
    check(ctx, icoray_grid_set(ctx, &grid));
    for (int level = 0; level <= LEVELS; level++) {
        radii[level] = 6.371229e6 + icon_half_levels[level];
    }
    layers.count = LEVELS + 1;
    layers.radius_m = radii;
    layers.planet_radius_m = 6.371229e6;
    check(ctx, icoray_layers_set(ctx, &layers));
    const double *lon = grid.lon_corner_rad, *lat = grid.lat_corner_rad;
    const double *lon_cell = grid.lon_center_rad, *lat_cell = grid.lat_center_rad;
    double *heights = array(ctx, &grid, NULL, LEVELS + 1, AT_TRIANGLES);
    for (int64_t i = 0; i < grid.corners * (LEVELS + 1); i++) {
        heights[i] = icon_height(lon[i / (LEVELS + 1)], lat[i / (LEVELS + 1)], (int)(i % (LEVELS + 1)));
    }
    for (int i = 0; i < ALL_VARIABLES; i++) {
        const icon_variable *of = &icon_variables[i];
        if (of->place != AT_EDGES) {
            values[i] = array(ctx, &grid, of->name, of->levels > 0 ? of->levels : 1, of->place);
            check(ctx, icoray_field_describe(ctx, of->name, of->long_name, of->units));
        }
    }
    check(ctx, icoray_scene_load(ctx, argv[1]));
    for (int step = atoi(argv[2]); argc > 3 && step <= atoi(argv[3]); step++) {
        char date[48];
        for (int v = 0; v < ALL_VARIABLES; v++) {
            int levels = icon_variables[v].levels, rows = levels > 0 ? levels : 1, place = icon_variables[v].place;
            int64_t columns = place == AT_EDGES ? 0 : place == AT_VERTICES ? grid.cells : grid.corners;
            for (int64_t i = 0; i < columns * rows; i++) {
                int64_t at = i / rows;
                int level = levels > 0 ? (int)(i % rows) : 0;
                values[v][i] = place == AT_VERTICES ? icon_value(v, lon_cell[at], lat_cell[at], level, step)
                                                    : icon_value(v, lon[at], lat[at], level, step);
            }
        }
        icon_date(step, date);
        date[19] = 0;
        check(ctx, icoray_execute(ctx, step, 1800.0 * step, date));
    }
    check(ctx, icoray_close(&ctx));
    return 0;
}
