/* The mesh, the fields and the contexts of the pictures. */
#include "pictures.h"

#include <math.h>

icoray_mesh *mesh;
icoray_grid grid;
int cells, corners, pixels;
uint64_t copy_expected, failures_expected;
const double radius[LAYERS] = {PLANET, PLANET + 4e3, PLANET + 9e3, PLANET + 20e3};

void make_mesh(int level)
{
    OK(icoray_mesh_create(level, &mesh));
    grid.struct_size = sizeof grid;
    OK(icoray_mesh_grid(mesh, &grid));
    cells = (int)grid.cells;
    corners = (int)grid.corners;
}

/* The tests' field, exact in a float. */
static float value_at(const icoray_grid *on, int location, int column, int layer)
{
    const double *lon = (const double *)(location == ICORAY_CORNER ? on->lon_corner_rad : on->lon_center_rad);
    const double *lat = (const double *)(location == ICORAY_CORNER ? on->lat_corner_rad : on->lat_center_rad);
    double wave = sin(3.0 * lon[column] + 0.4 * layer) * cos(lat[column]) + 0.3 * sin(5.0 * lat[column]);
    return (float)(wave * (1.0 + 0.2 * layer));
}

float center_value(int column, int layer)
{
    return value_at(&grid, ICORAY_CENTER, column, layer);
}

void put(Field *f, int64_t at, double value)
{
    set_real(f->memory, f->array.type, at, value);
}

void scribble(Field *f, double value)
{
    size_t elements = f->bytes / (f->array.type == ICORAY_F32 ? sizeof(float) : sizeof(double));
    for (size_t i = 0; i < elements; i++) {
        put(f, (int64_t)i, value);
    }
}

Field filled(const icoray_grid *on, icoray_array shape, size_t elements, size_t first)
{
    size_t size = shape.type == ICORAY_F32 ? sizeof(float) : sizeof(double);
    Field f = {.bytes = elements * size, .memory = allocate(elements, size), .before = allocate(elements, size),
               .array = shape};
    f.array.struct_size = sizeof f.array;
    f.array.data = (char *)f.memory + first * size;
    f.array.columns = shape.location == ICORAY_CORNER ? on->corners : on->cells;
    scribble(&f, elements % 2 == 0 ? 1e30 : NAN);
    for (int c = 0; c < (int)f.array.columns; c++) {
        for (int l = 0; l < (int)shape.layers; l++) {
            int64_t at = (int64_t)first + l * shape.layer_stride;
            at += shape.block == 0 ? c * shape.column_stride
                                   : c % shape.block * shape.column_stride + c / shape.block * shape.block_stride;
            put(&f, at, value_at(on, shape.location, c, l));
        }
    }
    memcpy(f.before, f.memory, f.bytes);
    return f;
}

icoray_array shaped(int type, int location, int layers, int64_t column_stride, int64_t layer_stride)
{
    icoray_array shape = {.type = type, .location = location, .layers = layers, .column_stride = column_stride,
                          .layer_stride = layer_stride};
    return shape;
}

Field field(int type, int location, int layers, size_t elements, size_t first, int64_t column_stride,
            int64_t layer_stride)
{
    return filled(&grid, shaped(type, location, layers, column_stride, layer_stride), elements, first);
}

Field blocked(int type, int location, int layers, int64_t block)
{
    int64_t columns = location == ICORAY_CORNER ? corners : cells;
    icoray_array shape = shaped(type, location, layers, 1, block);
    shape.block = block;
    shape.block_stride = block * layers;
    return filled(&grid, shape, (size_t)((columns + block - 1) / block * block * layers), 0);
}

void release(Field *f)
{
    CHECK(memcmp(f->memory, f->before, f->bytes) == 0);
    free(f->memory);
    free(f->before);
}

void release_all(Field *fields, int count)
{
    for (int i = 0; i < count; i++) {
        release(&fields[i]);
    }
}

icoray_ctx *context(const char *directory, const char *name, int with_threads)
{
    icoray_config config = {.threads = with_threads};
    return context_with(directory, name, config);
}

icoray_ctx *context_with(const char *directory, const char *name, icoray_config config)
{
    icoray_ctx *ctx = NULL;
    icoray_layers layers = layers_of(radius, NULL);
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", directory, name);
    config.struct_size = sizeof config;
    config.output_dir = path;
    OK(icoray_open_serial(&config, &ctx));
    memset(path, 'x', sizeof path - 1); /* was copied */
    OK(icoray_grid_set(ctx, &grid));
    OK(icoray_layers_set(ctx, &layers));
    return ctx;
}

icoray_layers layers_of(const double *radius_m, const char *name)
{
    icoray_layers layers = {.struct_size = sizeof layers, .count = LAYERS, .radius_m = radius_m,
                            .planet_radius_m = PLANET, .name = name};
    return layers;
}

void scene(icoray_ctx *ctx, const char *group, const char *light)
{
    scene_of(ctx, "f", group, light);
}

void scene_of(icoray_ctx *ctx, const char *name, const char *group, const char *light)
{
    OK(icoray_scene_text(ctx, text_of("field = \"%s\"\nbackend = \"cpu\"\nexaggeration = 40\n"
                                      "[image]\nwidth = %d\nheight = %d\n"
                                      VIEW "[light]\nkind = \"%s\"\n[output]\nfile = \"%s_{step}.png\"\n",
                                      name, pixels, pixels, light, group)));
}

uint64_t bytes_of(const Field *f)
{
    return (uint64_t)(f->array.columns * f->array.layers) *
           (f->array.type == ICORAY_F32 ? sizeof(float) : sizeof(double));
}

icoray_frame_report frame(icoray_ctx *ctx, int step)
{
    DRAW(ctx, step, 60.0 * step, NULL);
    icoray_frame_report report = report_of(ctx);
    CHECK(report.struct_size == sizeof report);
    CHECK(report.step == step && report.time_s == 60.0 * step);
    CHECK(report.rays > 0 && report.columns >= report.rays && report.frusta >= report.columns);
    CHECK(report.error_mean > 0.0 && report.error_mean <= report.error_max && report.error_max <= 1e-3);
    CHECK(report.error_p999 > 0.0 && report.error_p999 <= report.error_max && report.tolerance == 1e-3);
    CHECK(report.pixels_over_tolerance == 0);
    CHECK(report.rays_per_pixel == 1.0 && isnan(report.sampling_error_max) && isnan(report.sampling_error_mean));
    CHECK(report.cells_per_pixel_mean > 0.0 && report.cells_per_pixel_max >= report.cells_per_pixel_mean);
    CHECK(report.error_is_bound == 0 || report.error_is_bound == 1);
    CHECK(report.pixel_step == 1 && (report.lights == 0 || report.lights == 2));
    CHECK(report.prepare_s >= 0.0 && report.render_s > 0.0 && report.write_s > 0.0);
    CHECK(report.host_s > 0.0 && report.host_total_s >= report.host_s && report.write_total_s >= report.write_s);
    CHECK(report.frames_written > 0 && report.frames_failed == failures_expected && report.frames_dropped == 0);
    CHECK(report.bytes_copied == copy_expected && (report.copy_s > 0.0) == (copy_expected > 0));
    CHECK(report.bytes_peak > 0 && report.threads > 0 && report.waited_s >= 0.0);
    return report;
}

icoray_frame_report frame_of(icoray_ctx *ctx, int step, const Field *f)
{
    OK(icoray_field_set(ctx, "f", &f->array));
    return frame(ctx, step);
}

icoray_frame_report picture(icoray_ctx *ctx, const char *group, const char *light, int step, const Field *f)
{
    scene(ctx, group, light);
    return frame_of(ctx, step, f);
}
