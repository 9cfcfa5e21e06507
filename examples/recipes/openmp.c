/* A host with OpenMP: it computes in parallel regions and calls icoray between them.
 *
 *   cc -fopenmp openmp.c -o openmp $(pkg-config --cflags --libs icoray) -lm
 *   OMP_NUM_THREADS=4 ./openmp      # with scene.toml in the directory of the run
 */
#include <icoray.h>
#include <math.h>
#include <omp.h>
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
    double radius[LAYERS], *q = malloc((size_t)grid.cells * LAYERS * sizeof *q);
    for (int k = 0; k < LAYERS; k++) {
        radius[k] = 6371e3 + 5e3 * k;
    }
    icoray_layers layers = {.struct_size = sizeof layers, .count = LAYERS, .radius_m = radius, .planet_radius_m = 6371e3};
    icoray_array array = {.struct_size = sizeof array, .data = q, .type = ICORAY_F64, .location = ICORAY_CENTER,
                          .columns = grid.cells, .layers = LAYERS, .column_stride = LAYERS, .layer_stride = 1};
    /* The threads of icoray inherit the processors of the thread that opens the context. With OMP_PROC_BIND that is one
     * processor: so many threads as the host has would share it. */
    icoray_config config = {.struct_size = sizeof config, .output_dir = "pictures", .existing = ICORAY_OVERWRITE};
    config.threads = omp_get_proc_bind() == omp_proc_bind_false ? omp_get_max_threads() : 0;
    int is_off = failed(NULL, icoray_open_serial(&config, &ctx)) || failed(ctx, icoray_grid_set(ctx, &grid)) ||
                 failed(ctx, icoray_layers_set(ctx, &layers)) || failed(ctx, icoray_scene_load(ctx, "scene.toml"));
    for (int step = 0; step < 2; step++) {
#pragma omp parallel for schedule(static) /* as the loop that writes first, so that pages are where they are used */
        for (int64_t i = 0; i < grid.cells; i++) {
            for (int k = 0; k < LAYERS; k++) {
                q[i * LAYERS + k] = sin(3.0 * lon[i] + 0.3 * k + 0.5 * step) * cos(lat[i]);
            }
        }
        /* Between parallel regions: one thread calls. */
        is_off = is_off || failed(ctx, icoray_field_set(ctx, "q", &array)) || failed(ctx, icoray_execute(ctx, step, step, NULL));
    }
    icoray_close(&ctx);
    icoray_mesh_free(&mesh);
    free(q);
    return EXIT_SUCCESS;
}
