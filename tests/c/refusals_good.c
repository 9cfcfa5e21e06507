/* The valid structs, of which the refusals make one member invalid, and contents of files. */
#include "refusals.h"

icoray_mesh *mesh;
icoray_grid good_grid;
icoray_layers good_layers;
icoray_array good_array;
icoray_config good_config;
const double radius[LAYERS] = {6.4e6, 6.5e6, 6.7e6};
float *values;
const char *directory;
uint64_t expected_copy;
const char good_scene[] = SCENE("f", "4", "{field}_{step}.png");

const char *in_output(const char *name)
{
    return path_of(directory, name);
}

int write_file(const char *path, const char *text)
{
    FILE *file = fopen(path, "wb");
    if (file == NULL) {
        return 0;
    }
    fputs(text, file);
    return fclose(file) == 0;
}

/* Number of bytes read from a file, at most `room`, or -1 if there is no file. */
static int read_file(const char *name, char *there, size_t room)
{
    FILE *file = fopen(in_output(name), "rb");
    int read = file == NULL ? -1 : (int)fread(there, 1, room, file);
    if (file != NULL) {
        fclose(file);
    }
    return read;
}

int file_exists(const char *name)
{
    char any;
    return read_file(name, &any, 1) >= 0;
}

int file_is(const char *name, const char *text)
{
    char there[256];
    return read_file(name, there, sizeof there) == (int)strlen(text) && memcmp(there, text, strlen(text)) == 0;
}

int is_picture(const char *name)
{
    char there[8];
    return read_file(name, there, sizeof there) == 8 && memcmp(there, "\x89PNG\r\n\x1a\n", 8) == 0;
}

int says(const char *name, const char *words)
{
    static char there[1 << 16];
    int read = read_file(name, there, sizeof there), size = (int)strlen(words);
    for (int at = 0; at + size <= read; at++) {
        if (memcmp(there + at, words, strlen(words)) == 0) {
            return 1;
        }
    }
    return 0;
}

void prepare(const char *output_dir)
{
    directory = output_dir;
    OK(icoray_mesh_create(LEVEL, &mesh));
    good_grid.struct_size = sizeof good_grid;
    OK(icoray_mesh_grid(mesh, &good_grid));
    good_layers.struct_size = sizeof good_layers;
    good_layers.count = LAYERS;
    good_layers.radius_m = radius;
    good_layers.planet_radius_m = 6.4e6;
    /* More than the good field has: arrays with padding reach farther. */
    values = (float *)allocate(200 * LAYERS, sizeof *values);
    for (int i = 0; i < 200 * LAYERS; i++) {
        values[i] = 0.5f * (float)(i % 5);
    }
    good_array.struct_size = sizeof good_array;
    good_array.data = values;
    good_array.type = ICORAY_F32;
    good_array.location = ICORAY_CENTER;
    good_array.columns = good_grid.cells;
    good_array.layers = LAYERS;
    good_array.column_stride = LAYERS;
    good_array.layer_stride = 1;
    good_config.struct_size = sizeof good_config;
    good_config.output_dir = directory;
    good_config.threads = 1;
}

void clean_up(void)
{
    OK(icoray_mesh_free(&mesh));
    free(values);
}

void put(void *structure, size_t offset, size_t size, int64_t value)
{
    int32_t small = (int32_t)value;
    memcpy((char *)structure + offset, size == sizeof small ? (const void *)&small : (const void *)&value, size);
}

icoray_ctx *opened(void)
{
    icoray_ctx *ctx = NULL;
    OK(icoray_open_serial(&good_config, &ctx));
    return ctx;
}

icoray_ctx *filled(void)
{
    return filled_with(&good_config);
}

icoray_ctx *filled_with(const icoray_config *config)
{
    icoray_ctx *ctx = NULL;
    OK(icoray_open_serial(config, &ctx));
    OK(icoray_grid_set(ctx, &good_grid));
    OK(icoray_layers_set(ctx, &good_layers));
    OK(icoray_field_set(ctx, "f", &good_array));
    OK(icoray_scene_text(ctx, good_scene));
    return ctx;
}

icoray_ctx *filled_async(int is_async)
{
    icoray_config config = good_config;
    config.async_render = is_async;
    return filled_with(&config);
}

icoray_ctx *filled_logging(icoray_config config, icoray_log_fn log, void *user, int32_t level)
{
    config.log = log;
    config.log_user = user;
    config.log_level = level;
    return filled_with(&config);
}

void still_draws(icoray_ctx *ctx)
{
    static uint64_t frusta;
    static int step = 1000; /* pictures are not replaced */
    icoray_frame_report report;
    trying = "drawing after what was refused";
    step++;
    DRAW(ctx, step, 0.0, NULL);
    report = report_of(ctx);
    CHECK(report.step == step && report.bytes_copied == expected_copy);
    CHECK(report.frusta > 0 && report.value_min == 0.0 && report.value_max == 2.0);
    CHECK(frusta == 0 || report.frusta == frusta);
    frusta = report.frusta;
    trying = "";
}
