#define _GNU_SOURCE

#include "host.h"

#include <dirent.h>
#include <math.h>
#include <stdarg.h>
#include <sys/stat.h>
#include <time.h>

#define PLANET 6371220.0

World world(int level, int layers)
{
    World w;
    memset(&w, 0, sizeof w);
    w.layers = layers;
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
    icoray_config config;
    memset(&config, 0, sizeof config);
    config.struct_size = sizeof config;
    config.output_dir = directory;
    return config;
}

void set_layers(icoray_ctx *ctx, int layers)
{
    icoray_layers given;
    double *radius = calloc((size_t)layers, sizeof *radius);
    for (int l = 0; l < layers; l++) {
        radius[l] = PLANET + 20e3 * l / (layers - 1);
    }
    memset(&given, 0, sizeof given);
    given.struct_size = sizeof given;
    given.count = layers;
    given.radius_m = radius;
    given.planet_radius_m = PLANET;
    OK(icoray_layers_set(ctx, &given));
    free(radius);
}

void set_scene(icoray_ctx *ctx, int pixels, const char *more)
{
    char text[1024];
    snprintf(text, sizeof text,
             "field = \"f\"\nexaggeration = 40\n%s\n[image]\nwidth = %d\nheight = %d\n"
             "[camera]\nlon = 20\nlat = 35\ndistance = 3.2\nfov = 45\n"
             "[transfer]\nmap = \"viridis\"\nrange = [-1.5, 1.5]\nopacity = [[-1.5, 0.8], [0, 0.1], [1.5, 0.9]]\n"
             "[output]\nfile = \"frame_{step}.png\"\n",
             more, pixels, pixels);
    OK(icoray_scene_text(ctx, text));
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

icoray_frame_report report_of(icoray_ctx *ctx)
{
    icoray_frame_report report;
    memset(&report, 0, sizeof report);
    report.struct_size = sizeof report;
    OK(icoray_report(ctx, &report));
    return report;
}

int entries(const char *directory, const char *part)
{
    int count = 0;
    DIR *open = opendir(directory);
    if (open == NULL) {
        return -1;
    }
    for (struct dirent *entry; (entry = readdir(open)) != NULL;) {
        int is_self = strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0;
        count += !is_self && strstr(entry->d_name, part) != NULL;
    }
    closedir(open);
    return count;
}

int threads_now(void)
{
    return entries("/proc/self/task", "");
}

int open_files(void)
{
    return entries("/proc/self/fd", "");
}

void rest_ms(int ms)
{
    struct timespec rest;
    rest.tv_sec = ms / 1000;
    rest.tv_nsec = ms % 1000 * 1000000L;
    nanosleep(&rest, NULL);
}

double now_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

int settles_at(int threads)
{
    for (int i = 0; i < 1000 && threads_now() != threads; i++) {
        rest_ms(1);
    }
    return threads_now() == threads;
}

const char *path_of(const char *directory, const char *name)
{
    static char paths[4][1024];
    static int next;
    next = (next + 1) % 4;
    snprintf(paths[next], sizeof paths[next], "%s/%s", directory, name);
    return paths[next];
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
