/*
 * The least that a model adds in order to be drawn: a blob that travels eastward, and a picture of it every 4 steps.
 *
 *   cc minimal.c -o minimal $(pkg-config --cflags --libs icoray) -lm
 *   LD_LIBRARY_PATH=$(pkg-config --variable=libdir icoray) ./minimal
 *
 * Leaves pictures/blob_000000.png, ..., pictures/blob_000012.png and pictures/report.csv, a line per picture.
 */
#include <icoray.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { LAYERS = 8, STEPS = 12 };
static const double RADIUS = 6371e3, PI = 3.14159265358979323846; /* metres; half a turn */

/* Content and camera of the picture, as a scene file; lengths in planet radii, angles in degrees. Colours and opacities
 * suit the first values. */
static const char SCENE[] = "field = 'q'\n"
                            "image = { width = 640, height = 512 }\n"
                            "camera = { lon = 0, lat = 20 }\n"
                            "[output]\n"
                            "file = 'blob_{step:06}.png'\n";

/* Every call returns a status. Here a failure ends the program; a model would rather go on without pictures. */
static void check(icoray_ctx *ctx, icoray_status status)
{
    char message[1024] = "";
    if (status != ICORAY_OK) {
        icoray_last_error(ctx, message, sizeof message);
        fprintf(stderr, "minimal: status %d: %s\n", (int)status, message);
        exit(EXIT_FAILURE);
    }
}

int main(void)
{
    icoray_ctx *ctx = NULL;
    icoray_mesh *mesh = NULL;

    /* The model's mesh. One that has its own fills in the six tables of icoray_grid instead. */
    icoray_grid grid = {.struct_size = sizeof grid};
    check(NULL, icoray_mesh_create(4, &mesh)); /* 2562 cells */
    check(NULL, icoray_mesh_grid(mesh, &grid));
    const double *lon = grid.lon_center_rad, *lat = grid.lat_center_rad;

    /* The model's layers and its field: q[cell][layer], in any order that strides can describe. */
    double radius[LAYERS], *q = calloc((size_t)grid.cells * LAYERS, sizeof *q);
    for (int k = 0; k < LAYERS; k++) {
        radius[k] = RADIUS + 1000.0 + 2000.0 * k;
    }

    /* 1 to 3, once: nothing is copied but the radii, so the grid's tables must live until icoray_close. */
    icoray_config config = {
        .struct_size = sizeof config, .output_dir = "pictures", .existing = ICORAY_OVERWRITE};
    icoray_layers layers = {
        .struct_size = sizeof layers, .count = LAYERS, .radius_m = radius, .planet_radius_m = RADIUS};
    icoray_array array = {.struct_size = sizeof array, .data = q, .type = ICORAY_F64, .location = ICORAY_CENTER,
                          .columns = grid.cells, .layers = LAYERS, .column_stride = LAYERS, .layer_stride = 1};
    check(NULL, icoray_open_serial(&config, &ctx));
    check(ctx, icoray_grid_set(ctx, &grid));
    check(ctx, icoray_layers_set(ctx, &layers));
    check(ctx, icoray_scene_text(ctx, SCENE));
    check(ctx, icoray_field_describe(ctx, "q", "a tracer that travels eastward", "kg m-3"));

    for (int step = 0; step <= STEPS; step++) {
        /* The model computes ... */
        double center = PI * (step - STEPS / 2) / (2 * STEPS);
        for (long i = 0; i < grid.cells; i++) {
            double cosine = cos(lat[i]) * cos(lon[i] - center);
            for (int k = 0; k < LAYERS; k++) {
                q[i * LAYERS + k] = exp(20.0 * (cosine - 1.0) - 0.1 * k);
            }
        }
        /* 4 and 5: ... and every now and then the scene is drawn from its arrays as they stand. The field is given in the
         * loop: models swap time levels, and a pointer that is given once shows the step before at every odd step. */
        if (step % 4 == 0) {
            check(ctx, icoray_field_set(ctx, "q", &array));
            check(ctx, icoray_execute(ctx, step, 3600.0 * step, NULL));
        }
    }
    check(ctx, icoray_close(&ctx));
    check(NULL, icoray_mesh_free(&mesh));
    free(q);
    return EXIT_SUCCESS;
}
