#define _GNU_SOURCE

#include "host.h"

#include <math.h>
#include <stdarg.h>
#include <sys/stat.h>
#include <time.h>

#define PLANET 6371220.0

World world(int level, int layers)
{
    World w = {.layers = layers};
    OK(icoray_mesh_create(level, &w.mesh));
    w.grid.struct_size = sizeof w.grid;
    OK(icoray_mesh_grid(w.mesh, &w.grid));
    w.values = calloc((size_t)w.grid.cells * (size_t)layers, sizeof *w.values);
    const double *lon = w.grid.lon_center_rad, *lat = w.grid.lat_center_rad;
    for (int64_t c = 0; c < w.grid.cells; c++) {
        for (int l = 0; l < layers; l++) {
            w.values[c * layers + l] = (float)(sin(3.0 * lon[c] + 2.0 * l / layers) * cos(lat[c]));
        }
    }
    w.array.struct_size = sizeof w.array;
    w.array.data = w.values;
    w.array.type = ICORAY_F32;
    w.array.location = ICORAY_CENTER;
    w.array.columns = w.grid.cells;
    w.array.layers = layers;
    w.array.column_stride = layers;
    w.array.layer_stride = 1;
    return w;
}

void end_world(World *w)
{
    OK(icoray_mesh_free(&w->mesh));
    free(w->values);
    w->values = NULL;
}

icoray_config plain(const char *directory)
{
    icoray_config config = {.struct_size = sizeof config, .output_dir = directory};
    return config;
}

void set_layers(icoray_ctx *ctx, int layers)
{
    double *radius = calloc((size_t)layers, sizeof *radius);
    for (int l = 0; l < layers; l++) {
        radius[l] = PLANET + 20e3 * l / (layers - 1);
    }
    icoray_layers given = {.struct_size = sizeof given, .count = layers, .radius_m = radius, .planet_radius_m = PLANET};
    OK(icoray_layers_set(ctx, &given));
    free(radius);
}

void set_view(icoray_ctx *ctx, const char *keys, int width, int height, const char *rest)
{
    OK(icoray_scene_text(ctx, text_of("field = \"f\"\nexaggeration = 40\n%s\n[image]\nwidth = %d\nheight = %d\n"
                                      VIEW "%s", keys, width, height, rest)));
}

void set_scene(icoray_ctx *ctx, int pixels, const char *keys)
{
    set_view(ctx, keys, pixels, pixels, "[output]\nfile = \"frame_{step}.png\"\n");
}

icoray_ctx *opened(const icoray_config *config, const World *w, int pixels)
{
    icoray_ctx *ctx = NULL;
    OK(icoray_open_serial(config, &ctx));
    if (ctx == NULL) {
        exit(verdict("no context"));
    }
    OK(icoray_grid_set(ctx, &w->grid));
    set_layers(ctx, w->layers);
    OK(icoray_field_set(ctx, "f", &w->array));
    set_scene(ctx, pixels, "");
    return ctx;
}

int open_files(void)
{
    return entries("/proc/self/fd", "");
}

double now_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

int is_file(const char *path)
{
    struct stat found;
    return stat(path, &found) == 0 && S_ISREG(found.st_mode);
}

int is_whole_png(const char *path)
{
    static const unsigned char first[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    static const unsigned char last[8] = {'I', 'E', 'N', 'D', 0xae, 0x42, 0x60, 0x82};
    unsigned char head[8] = {0}, tail[8] = {0};
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        return 0;
    }
    int read = fread(head, 8, 1, file) == 1 && fseek(file, -8, SEEK_END) == 0 && fread(tail, 8, 1, file) == 1;
    fclose(file);
    return read && memcmp(head, first, 8) == 0 && memcmp(tail, last, 8) == 0;
}

int same_files(const char *a, const char *b)
{
    FILE *one = fopen(a, "rb"), *other = fopen(b, "rb");
    int same = one != NULL && other != NULL, size = 0;
    while (same) {
        int c = getc(one);
        same = c == getc(other);
        if (c == EOF) {
            break;
        }
        size++;
    }
    if (one != NULL) {
        fclose(one);
    }
    if (other != NULL) {
        fclose(other);
    }
    return same && size > 0;
}

void note(const char *format, ...)
{
    va_list values;
    printf("note: ");
    va_start(values, format);
    vprintf(format, values);
    va_end(values);
    printf("\n");
}
