/*
 * A frame whose instructions instructions.sh counts: frusta span|dense|thin unlit|lit mean|native FRAMES
 *
 * Draws that many frames of 2562 cells with 31 layers on one thread, and prints how many frusta they read. The field
 * and the transfer functions are those of `icoray-study speed`; "span" has two knots. Writes to the current directory.
 */
#include "../c/check.h"

#include <math.h>

enum { LAYERS = 31, PIXELS = 192, KNOTS = 16 };
static const double RADIUS = 6371e3; /* metres */
static const double WAVES[4][2] = {{3, 0.5}, {7, 0.25}, {17, 0.15}, {41, 0.1}};

/* The field at a direction and a radius in planet radii. */
static double value_at(const double d[3], double r)
{
    double sum = 0, phase = 20 * (r - 1);
    for (int k = 0; k < 4; k++) {
        double wave = WAVES[k][0];
        sum += WAVES[k][1] * sin(wave * d[0] + phase) * cos(wave * d[1] - 0.7 * phase) * sin(wave * d[2] + 0.3 * wave);
    }
    return fmin(fmax(2 * sum, -1), 1);
}

/* The opacity of a transfer function at a value. */
static double opacity_at(const char *transfer, double value)
{
    int is_within = value >= 0.45 && value < 0.62;
    return strcmp(transfer, "thin") != 0 ? 0.5 : is_within ? 0.98 : 0;
}

static void set_scene(icoray_ctx *ctx, const char *transfer, const char *light, const char *heights)
{
    char scene[8192];
    int length = sprintf(scene,
                         "field = 'q'\nantialias = false\nprecision = 'f32'\ntolerance = 1e-3\nheights = '%s'\n%s"
                         "image = { width = %d, height = %d }\n"
                         "camera = { lon = 30, lat = 25, distance = 3.2, fov = 45 }\n[transfer]\nknots = [\n",
                         heights, strcmp(light, "lit") == 0 ? "light = { kind = 'headlight' }\n" : "", PIXELS, PIXELS);
    int step = strcmp(transfer, "span") == 0 ? KNOTS - 1 : 1;
    for (int i = 0; i < KNOTS; i += step) {
        double value = -1 + 2.0 * i / (KNOTS - 1);
        length += sprintf(scene + length, "{ value = %.17g, color = 'rgb(%d %d %d)', opacity = %.17g },\n", value,
                          128 + 8 * i, 90 + 6 * (i % 5), 255 - 12 * i, opacity_at(transfer, value));
    }
    sprintf(scene + length, "]\n");
    OK(icoray_scene_text(ctx, scene));
}

int main(int argc, char **argv)
{
    icoray_ctx *ctx = NULL;
    icoray_mesh *mesh = NULL;
    icoray_grid grid = {.struct_size = sizeof grid};
    if (argc != 5) {
        fprintf(stderr, "frusta span|dense|thin unlit|lit mean|native FRAMES\n");
        return EXIT_FAILURE;
    }
    OK(icoray_mesh_create(4, &mesh));
    OK(icoray_mesh_grid(mesh, &grid));

    double radius[LAYERS], top = 0.15 * RADIUS;
    float *q = calloc((size_t)grid.cells * LAYERS, sizeof *q);
    double *height = calloc((size_t)grid.cells * LAYERS, sizeof *height);
    for (int k = 0; k < LAYERS; k++) {
        radius[k] = RADIUS + top * k / (LAYERS - 1);
    }
    const double *lon = grid.lon_center_rad, *lat = grid.lat_center_rad;
    for (int64_t i = 0; i < grid.cells; i++) {
        double d[3] = {cos(lat[i]) * cos(lon[i]), cos(lat[i]) * sin(lon[i]), sin(lat[i])};
        double wave = sin(9 * d[0] + 2 * d[2]) * cos(7 * d[1] - 3 * d[0]) * cos(8 * d[2]);
        double mountain = 0.4 * top * wave * wave;
        for (int k = 0; k < LAYERS; k++) {
            q[i * LAYERS + k] = (float)value_at(d, radius[k] / RADIUS);
            height[i * LAYERS + k] = mountain + (radius[k] - RADIUS) * (1 - mountain / top);
        }
    }
    icoray_config config = {.struct_size = sizeof config, .output_dir = ".", .threads = 1,
                            .existing = ICORAY_OVERWRITE};
    icoray_layers layers = {
        .struct_size = sizeof layers, .count = LAYERS, .radius_m = radius, .planet_radius_m = RADIUS};
    icoray_array array = {.struct_size = sizeof array, .data = q, .type = ICORAY_F32, .location = ICORAY_CENTER,
                          .columns = grid.cells, .layers = LAYERS, .column_stride = LAYERS, .layer_stride = 1};
    OK(icoray_open_serial(&config, &ctx));
    OK(icoray_grid_set(ctx, &grid));
    OK(icoray_layers_set(ctx, &layers));
    OK(icoray_field_set(ctx, "q", &array));
    array.data = height;
    array.type = ICORAY_F64;
    OK(icoray_heights_set(ctx, &array));
    set_scene(ctx, argv[1], argv[2], argv[3]);

    uint64_t frusta = 0;
    for (int step = 0; step < atoi(argv[4]); step++) {
        OK(icoray_execute(ctx, step, step, NULL));
        frusta += report_of(ctx).frusta;
    }
    OK(icoray_close(&ctx));
    OK(icoray_mesh_free(&mesh));
    free(q);
    free(height);
    printf("frusta %llu\n", (unsigned long long)frusta);
    return verdict("frames");
}
