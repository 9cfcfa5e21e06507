/* A host with OpenACC, whose field lives on the GPU: it is copied to the host at steps at which a picture reads it.
 *
 *   cc -fopenacc openacc.c -o openacc $(pkg-config --cflags --libs icoray) -lm
 *   ./openacc                       # with scene.toml in the directory of the run
 */
#include <icoray.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { LAYERS = 6 };

static int failed(icoray_ctx *ctx, icoray_status status)
{
    char message[401];
    if (status != ICORAY_OK) {
        icoray_last_error(ctx, message, sizeof message);
        fprintf(stderr, "icoray: status %d: %s\n", (int)status, message);
    }
    return status != ICORAY_OK;
}

int main(void)
{
    icoray_ctx *ctx = NULL;
    icoray_mesh *mesh = NULL;
    icoray_grid grid = {.struct_size = sizeof grid};
    if (icoray_mesh_create(3, &mesh) || icoray_mesh_grid(mesh, &grid)) {
        return EXIT_FAILURE;
    }
    const double *lon = grid.lon_center_rad, *lat = grid.lat_center_rad;
    int64_t cells = grid.cells, updates = 0;
    double radius[LAYERS], *q = malloc((size_t)cells * LAYERS * sizeof *q);
    for (int k = 0; k < LAYERS; k++) {
        radius[k] = 6371e3 + 5e3 * k;
    }
    icoray_layers layers = {.struct_size = sizeof layers, .count = LAYERS, .radius_m = radius, .planet_radius_m = 6371e3};
    icoray_array array = {.struct_size = sizeof array, .data = q, .type = ICORAY_F64, .location = ICORAY_CENTER,
                          .columns = cells, .layers = LAYERS, .column_stride = LAYERS, .layer_stride = 1};
    icoray_config config = {.struct_size = sizeof config, .output_dir = "pictures", .existing = ICORAY_OVERWRITE};
    int is_off = failed(NULL, icoray_open_serial(&config, &ctx)) || failed(ctx, icoray_grid_set(ctx, &grid)) ||
                 failed(ctx, icoray_layers_set(ctx, &layers)) || failed(ctx, icoray_scene_load(ctx, "scene.toml"));
#pragma acc data create(q[0 : cells * LAYERS]) copyin(lon[0 : cells], lat[0 : cells])
    for (int step = 0; step < 4; step++) {
#pragma acc parallel loop present(q, lon, lat)
        for (int64_t i = 0; i < cells; i++) {
            for (int k = 0; k < LAYERS; k++) {
                q[i * LAYERS + k] = sin(3.0 * lon[i] + 0.3 * k + 0.5 * step) * cos(lat[i]);
            }
        }
        int32_t wants = 0, wants_q = 0;
        if (is_off || icoray_wants(ctx, step, step, &wants) || !wants) {
            continue;
        }
        icoray_wants_field(ctx, "q", step, step, &wants_q);
        if (wants_q) {
#pragma acc update self(q[0 : cells * LAYERS])
            updates++;
        }
        /* icoray reads q on the host. */
        is_off = failed(ctx, icoray_field_set(ctx, "q", &array)) || failed(ctx, icoray_execute(ctx, step, step, NULL));
    }
    printf("%d updates of the host\n", (int)updates);
    icoray_close(&ctx);
    icoray_mesh_free(&mesh);
    free(q);
    return EXIT_SUCCESS;
}
