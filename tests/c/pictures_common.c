/* The mesh, the fields and the contexts of the pictures. */
#include "pictures.h"

#include <math.h>

icoray_mesh *mesh;
icoray_grid grid;
int cells, corners, pixels;
static const double radius[LAYERS] = {PLANET, PLANET + 4e3, PLANET + 9e3, PLANET + 20e3};

void *allocate(size_t count, size_t size)
{
    void *memory = calloc(count, size);
    if (memory == NULL) {
        printf("out of memory\n");
        exit(EXIT_FAILURE);
    }
    return memory;
}

/* The tests' field, exact in a float. */
static float value_at(const double *lon, const double *lat, int column, int layer)
{
    double wave = sin(3.0 * lon[column] + 0.4 * layer) * cos(lat[column]) + 0.3 * sin(5.0 * lat[column]);
    return (float)(wave * (1.0 + 0.2 * layer));
}

float center_value(int column, int layer)
{
    return value_at((const double *)grid.lon_center_rad, (const double *)grid.lat_center_rad, column, layer);
}

static float corner_value(int column, int layer)
{
    return value_at((const double *)grid.lon_corner_rad, (const double *)grid.lat_corner_rad, column, layer);
}

Field field(int type, int location, int layers, size_t elements, size_t first, int64_t column_stride,
            int64_t layer_stride)
{
    Field f;
    size_t size = type == ICORAY_F32 ? sizeof(float) : sizeof(double);
    int columns = location == ICORAY_CORNER ? corners : cells;
    memset(&f, 0, sizeof f);
    f.bytes = elements * size;
    f.memory = allocate(elements, size);
    f.before = allocate(elements, size);
    f.array.struct_size = sizeof f.array;
    f.array.data = (char *)f.memory + first * size;
    f.array.type = type;
    f.array.location = location;
    f.array.columns = columns;
    f.array.layers = layers;
    f.array.column_stride = column_stride;
    f.array.layer_stride = layer_stride;
    for (size_t i = 0; i < elements; i++) {
        if (type == ICORAY_F32) {
            ((float *)f.memory)[i] = 1e30f;
        } else {
            ((double *)f.memory)[i] = 1e30;
        }
    }
    for (int c = 0; c < columns; c++) {
        for (int l = 0; l < layers; l++) {
            float v = location == ICORAY_CORNER ? corner_value(c, l) : center_value(c, l);
            int64_t at = (int64_t)first + c * column_stride + l * layer_stride;
            if (type == ICORAY_F32) {
                ((float *)f.memory)[at] = v;
            } else {
                ((double *)f.memory)[at] = v;
            }
        }
    }
    memcpy(f.before, f.memory, f.bytes);
    return f;
}

void release(Field *f)
{
    CHECK(memcmp(f->memory, f->before, f->bytes) == 0);
    free(f->memory);
    free(f->before);
}

icoray_ctx *context(const char *directory, const char *name, int with_threads)
{
    icoray_ctx *ctx = NULL;
    icoray_config config;
    icoray_layers layers;
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", directory, name);
    memset(&config, 0, sizeof config);
    config.struct_size = sizeof config;
    config.output_dir = path;
    config.threads = with_threads;
    OK(icoray_open_serial(&config, &ctx));
    memset(path, 'x', sizeof path - 1); /* was copied */
    OK(icoray_grid_set(ctx, &grid));
    memset(&layers, 0, sizeof layers);
    layers.struct_size = sizeof layers;
    layers.count = LAYERS;
    layers.radius_m = radius;
    layers.planet_radius_m = PLANET;
    OK(icoray_layers_set(ctx, &layers));
    return ctx;
}

void scene(icoray_ctx *ctx, const char *group, const char *light)
{
    char text[1024];
    snprintf(text, sizeof text,
             "field = \"f\"\nexaggeration = 40\n"
             "[image]\nwidth = %d\nheight = %d\n"
             "[camera]\nlon = 20\nlat = 35\ndistance = 3.2\nfov = 45\n"
             "[transfer]\nmap = \"viridis\"\nrange = [-1.5, 1.5]\nopacity = [[-1.5, 0.8], [0, 0.1], [1.5, 0.9]]\n"
             "[light]\nkind = \"%s\"\n[output]\nfile = \"%s_{step}.png\"\n",
             pixels, pixels, light, group);
    OK(icoray_scene_text(ctx, text));
}

icoray_frame_report frame(icoray_ctx *ctx, int step)
{
    icoray_frame_report report;
    memset(&report, 0, sizeof report);
    report.struct_size = sizeof report;
    OK(icoray_execute(ctx, step, 60.0 * step, NULL));
    OK(icoray_report(ctx, &report));
    CHECK(report.struct_size == sizeof report);
    CHECK(report.step == step && report.time_s == 60.0 * step);
    CHECK(report.rays > 0 && report.columns >= report.rays && report.frusta >= report.columns);
    CHECK(report.error_mean > 0.0 && report.error_mean <= report.error_max && report.error_max <= 1e-3);
    CHECK(report.error_p999 > 0.0 && report.error_p999 <= report.error_max && report.tolerance == 1e-3);
    CHECK(report.error_is_bound == 0 || report.error_is_bound == 1);
    CHECK(report.pixel_step == 1 && (report.lights == 0 || report.lights == 2));
    CHECK(report.prepare_s >= 0.0 && report.render_s > 0.0 && report.write_s > 0.0);
    return report;
}

icoray_frame_report frame_of(icoray_ctx *ctx, int step, const Field *f)
{
    OK(icoray_field_set(ctx, "f", &f->array));
    return frame(ctx, step);
}
