/*
 * Pictures through the ABI: pictures <directory> <level> <pixels>
 *
 * A picture's name is its group and its step. abi.rs compares the pixels: those of a group are equal, whatever the
 * layout, the context, the directory or the thread; those of different groups are not.
 */
#define _POSIX_C_SOURCE 200809L /* nanosleep, opendir */

#include "check.h"

#include <dirent.h>
#include <math.h>
#include <pthread.h>
#include <time.h>

#define LAYERS 4
#define PLANET 6371220.0
/* What NICAM calls undefined. As a double it is another number than as a float. */
#define UNDEFINED -9.9999e30

static icoray_mesh *mesh;
static icoray_grid grid;
static int cells, corners, pixels;
static const double radius[LAYERS] = {PLANET, PLANET + 4e3, PLANET + 9e3, PLANET + 20e3};
static const double falling[LAYERS] = {PLANET + 20e3, PLANET + 9e3, PLANET + 4e3, PLANET};

static void *allocate(size_t count, size_t size)
{
    void *memory = calloc(count, size);
    if (memory == NULL) {
        printf("out of memory\n");
        exit(EXIT_FAILURE);
    }
    return memory;
}

/* Threads of this process, or -1 where that is not to be known. */
static int threads(void)
{
    int count = 0;
    DIR *tasks = opendir("/proc/self/task");
    if (tasks == NULL) {
        return -1;
    }
    for (struct dirent *task; (task = readdir(tasks)) != NULL;) {
        count += task->d_name[0] != '.';
    }
    closedir(tasks);
    return count;
}

/* Whether there are that many threads, at the latest after a while: threads that are told to end do so later. */
static int settles_at(int expected)
{
    struct timespec wait = {0, 5000000};
    for (int i = 0; i < 1000; i++) {
        int now = threads();
        if (now == -1 || now == expected) {
            return 1;
        }
        nanosleep(&wait, NULL);
    }
    return 0;
}

/* The tests' field, exact in a float. */
static float value_at(const double *lon, const double *lat, int column, int layer)
{
    double wave = sin(3.0 * lon[column] + 0.4 * layer) * cos(lat[column]) + 0.3 * sin(5.0 * lat[column]);
    return (float)(wave * (1.0 + 0.2 * layer));
}

static float center_value(int column, int layer)
{
    return value_at((const double *)grid.lon_center_rad, (const double *)grid.lat_center_rad, column, layer);
}

static float corner_value(int column, int layer)
{
    return value_at((const double *)grid.lon_corner_rad, (const double *)grid.lat_corner_rad, column, layer);
}

/* An array of the tests, in the middle of other values that must not be seen. */
typedef struct {
    void *memory, *before;
    size_t bytes;
    icoray_array array;
} Field;

/* Fills an array of `elements` in which value (0, 0) is element `first`. */
static Field field(int type, int location, int layers, size_t elements, size_t first, int64_t column_stride,
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

/* The library has not written to the array. */
static void release(Field *f)
{
    CHECK(memcmp(f->memory, f->before, f->bytes) == 0);
    free(f->memory);
    free(f->before);
}

static icoray_ctx *context(const char *directory, const char *name, int with_threads)
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

static void scene(icoray_ctx *ctx, const char *group, const char *light)
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

static icoray_frame_report frame(icoray_ctx *ctx, int step)
{
    icoray_frame_report report;
    memset(&report, 0, sizeof report);
    report.struct_size = sizeof report;
    OK(icoray_execute(ctx, step, 60.0 * step, NULL));
    OK(icoray_report(ctx, &report));
    CHECK(report.struct_size == sizeof report);
    CHECK(report.step == step && report.time_s == 60.0 * step);
    CHECK(report.rays > 0 && report.columns >= report.rays && report.frusta >= report.columns);
    CHECK(report.prepare_s >= 0.0 && report.render_s > 0.0 && report.write_s > 0.0);
    CHECK(report.copied_bytes == 0);
    return report;
}

static icoray_frame_report frame_of(icoray_ctx *ctx, int step, const Field *f)
{
    OK(icoray_field_set(ctx, "f", &f->array));
    return frame(ctx, step);
}

/* The same values in every layout are the same picture. */
static void layouts(const char *directory)
{
    enum { F32 = ICORAY_F32, F64 = ICORAY_F64, AT = ICORAY_CENTER, L = LAYERS };
    size_t n = (size_t)cells * LAYERS;
    int64_t wide = L + 3;
    Field fields[] = {
        field(F32, AT, L, n, 0, L, 1),                               /* level-fastest */
        field(F32, AT, L, n, 0, 1, cells),                           /* cell-fastest */
        field(F32, AT, L, (size_t)(cells * wide), 2, wide, 1),       /* padded rows */
        field(F32, AT, L, 3 * n, 1, 3 * L, 3),                       /* one of three interleaved fields */
        field(F32, AT, L, n, n - 1, -L, -1),                         /* backwards */
        field(F32, AT, L, n, (size_t)cells * (L - 1), 1, -cells),    /* top layer first in memory */
        field(F64, AT, L, n, 0, L, 1),
        field(F64, AT, L, n, 0, 1, cells),
        field(F64, AT, L, (size_t)(cells * wide), 2, wide, 1),
        field(F64, AT, L, n, n - 1, -L, -1),
        field(F64, AT, L, (size_t)((cells + 7) * L), 5, 1, cells + 7), /* padded layers */
    };
    int count = (int)(sizeof fields / sizeof fields[0]);
    icoray_ctx *ctx = context(directory, "layouts", 2);
    float low = 1e30f, high = -1e30f;
    for (int c = 0; c < cells; c++) {
        for (int l = 0; l < LAYERS; l++) {
            low = fminf(low, center_value(c, l));
            high = fmaxf(high, center_value(c, l));
        }
    }
    for (int i = 0; i < count; i++) {
        icoray_frame_report report;
        scene(ctx, "plain", "none");
        report = frame_of(ctx, i, &fields[i]);
        CHECK(report.value_min == low && report.value_max == high);
        CHECK(report.missing_values == 0 && report.void_frusta == 0);
        CHECK(report.derived_bytes == 0);
        scene(ctx, "lit", "headlight");
        report = frame_of(ctx, i, &fields[i]);
        CHECK(report.derived_bytes == n * 3 * sizeof(float)); /* gradients */
    }

    /* Layers handed over top first, with the field as it must then be: level 0 is the top. */
    icoray_layers layers;
    memset(&layers, 0, sizeof layers);
    layers.struct_size = sizeof layers;
    layers.count = LAYERS;
    layers.radius_m = falling;
    layers.planet_radius_m = PLANET;
    OK(icoray_layers_set(ctx, &layers));
    Field *first = &fields[0];
    first->array.data = (float *)first->memory + LAYERS - 1;
    first->array.layer_stride = -1;
    scene(ctx, "plain", "none");
    frame_of(ctx, count, first);
    scene(ctx, "lit", "headlight");
    frame_of(ctx, count, first);

    OK(icoray_close(&ctx));
    for (int i = 0; i < count; i++) {
        release(&fields[i]);
    }
}

/* A field is read where it lies, when it is drawn: handed over once, it may change. */
static void in_place(const char *directory)
{
    icoray_ctx *ctx = context(directory, "in_place", 1);
    Field f = field(ICORAY_F32, ICORAY_CENTER, LAYERS, (size_t)cells * LAYERS, 0, LAYERS, 1);
    float *values = f.memory;
    icoray_frame_report report;

    scene(ctx, "plain", "none");
    frame_of(ctx, 0, &f);
    for (int i = 0; i < cells * LAYERS; i++) {
        values[i] = -values[i];
    }
    scene(ctx, "turned", "none");
    frame(ctx, 1);
    for (int i = 0; i < cells * LAYERS; i++) {
        values[i] = 0.5f;
    }
    values[7] = 77.0f;
    scene(ctx, "flat", "none");
    report = frame(ctx, 2);
    CHECK(report.value_min == 0.5 && report.value_max == 77.0);
    memcpy(f.memory, f.before, f.bytes);
    scene(ctx, "plain", "none");
    frame(ctx, 3);

    /* What is refused in between changes nothing: neither the grid nor the field. */
    icoray_grid bad = grid;
    icoray_array far = f.array;
    bad.edge_corner = grid.corner_cell;
    REFUSED(ctx, ICORAY_ERR_GRID, "edge_corner", icoray_grid_set(ctx, &bad));
    far.column_stride = INT64_MAX;
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "strides", icoray_field_set(ctx, "f", &far));
    frame(ctx, 4);

    OK(icoray_close(&ctx));
    release(&f);
}

/* Missing values: by NaN, by infinity, and by the mark, which an array of floats holds rounded to a float. */
static void missing(const char *directory)
{
    icoray_ctx *ctx = context(directory, "missing", 1);
    scene(ctx, "missing", "none");
    for (int step = 0; step < 4; step++) {
        int type = step == 3 ? ICORAY_F64 : ICORAY_F32;
        Field f = field(type, ICORAY_CENTER, LAYERS, (size_t)cells * LAYERS, 0, LAYERS, 1);
        icoray_frame_report report;
        uint64_t marked = 0;
        for (int i = 0; i < cells * LAYERS; i += 5, marked++) {
            double mark = step == 0 ? NAN : step == 1 ? -INFINITY : UNDEFINED;
            if (type == ICORAY_F32) {
                ((float *)f.memory)[i] = (float)mark;
            } else {
                ((double *)f.memory)[i] = mark;
            }
        }
        memcpy(f.before, f.memory, f.bytes);
        f.array.has_fill = step >= 2;
        f.array.fill_value = UNDEFINED;
        report = frame_of(ctx, step, &f);
        CHECK(report.missing_values == marked);
        CHECK(report.void_frusta > 0 && report.void_frusta <= report.frusta);
        CHECK(report.value_min > -10.0 && report.value_max < 10.0);
        f.array.has_fill = 0;
        OK(icoray_field_set(ctx, "f", &f.array));
        release(&f);
    }
    /* Nothing but missing values. */
    Field f = field(ICORAY_F64, ICORAY_CENTER, LAYERS, (size_t)cells * LAYERS, 0, LAYERS, 1);
    for (int i = 0; i < cells * LAYERS; i++) {
        ((double *)f.memory)[i] = NAN;
    }
    memcpy(f.before, f.memory, f.bytes);
    scene(ctx, "nothing", "headlight");
    icoray_frame_report report = frame_of(ctx, 9, &f);
    CHECK(isnan(report.value_min) && isnan(report.value_max));
    CHECK(report.missing_values == (uint64_t)cells * LAYERS);
    OK(icoray_close(&ctx));
    release(&f);
}

/* Fields at corners are averaged to cells; fields with a layer fewer lie midway. */
static void places(const char *directory)
{
    icoray_ctx *ctx = context(directory, "places", 2);
    size_t n = (size_t)corners * LAYERS;
    Field level = field(ICORAY_F32, ICORAY_CORNER, LAYERS, n, 0, LAYERS, 1);
    Field cell = field(ICORAY_F32, ICORAY_CORNER, LAYERS, n, 0, 1, corners);
    Field wide = field(ICORAY_F64, ICORAY_CORNER, LAYERS, n, 0, LAYERS, 1);
    Field midway = field(ICORAY_F32, ICORAY_CENTER, LAYERS - 1, (size_t)cells * (LAYERS - 1), 0, LAYERS - 1, 1);
    uint64_t averages = (uint64_t)cells * LAYERS;

    scene(ctx, "corner", "none");
    CHECK(frame_of(ctx, 0, &level).derived_bytes == averages * sizeof(float));
    CHECK(frame_of(ctx, 1, &cell).derived_bytes == averages * sizeof(float));
    scene(ctx, "litcorner", "headlight");
    CHECK(frame_of(ctx, 2, &level).derived_bytes == averages * 4 * sizeof(float));
    scene(ctx, "near corner", "none"); /* the averages are rounded less */
    CHECK(frame_of(ctx, 3, &wide).derived_bytes == averages * sizeof(double));
    scene(ctx, "midway", "none");
    CHECK(frame_of(ctx, 4, &midway).derived_bytes == 0);

    OK(icoray_close(&ctx));
    release(&level);
    release(&cell);
    release(&wide);
    release(&midway);
}

/* The tables as other models have them: from 1, longer rows with counts; and with coordinates in floats. */
static void tables(const char *directory)
{
    enum { ROW = 8 };
    icoray_ctx *ctx = context(directory, "tables", 2);
    int32_t *cell_corner = allocate((size_t)cells * ROW, sizeof(int32_t));
    int32_t *count = allocate((size_t)cells, sizeof(int32_t));
    int32_t *corner_cell = allocate((size_t)corners * 3, sizeof(int32_t));
    int32_t *corner_edge = allocate((size_t)corners * 3, sizeof(int32_t));
    int32_t *edge_corner = allocate((size_t)grid.edges * 2, sizeof(int32_t));
    float *position = allocate((size_t)(cells + corners) * 2, sizeof(float));
    const double *from[4];
    float *to[4];
    int rows[4];
    icoray_grid other = grid;
    for (int c = 0; c < cells; c++) {
        const int32_t *row = grid.cell_corner + 6 * c;
        for (int i = 0; i < ROW; i++) {
            cell_corner[ROW * c + i] = -99; /* never read */
        }
        for (int i = 0; i < 6; i++) {
            int seen = 0;
            for (int j = 0; j < i; j++) {
                seen |= row[j] == row[i];
            }
            if (!seen) {
                cell_corner[ROW * c + count[c]++] = row[i] + 1;
            }
        }
        CHECK(count[c] == 5 || count[c] == 6);
    }
    for (int i = 0; i < 3 * corners; i++) {
        corner_cell[i] = grid.corner_cell[i] + 1;
        corner_edge[i] = grid.corner_edge[i] + 1;
    }
    for (int i = 0; i < 2 * (int)grid.edges; i++) {
        edge_corner[i] = grid.edge_corner[i] + 1;
    }
    other.index_base = 1;
    other.cell_corner = cell_corner;
    other.cell_corner_row = ROW;
    other.cell_corner_count = count;
    other.corner_cell = corner_cell;
    other.corner_edge = corner_edge;
    other.edge_corner = edge_corner;
    OK(icoray_grid_set(ctx, &other));
    Field f = field(ICORAY_F32, ICORAY_CENTER, LAYERS, (size_t)cells * LAYERS, 0, LAYERS, 1);
    Field corner = field(ICORAY_F32, ICORAY_CORNER, LAYERS, (size_t)corners * LAYERS, 0, LAYERS, 1);
    scene(ctx, "plain", "none");
    frame_of(ctx, 1, &f);
    scene(ctx, "lit", "headlight");
    frame_of(ctx, 2, &f);
    scene(ctx, "corner", "none");
    frame_of(ctx, 3, &corner);

    from[0] = grid.lon_center_rad, from[1] = grid.lat_center_rad, rows[0] = rows[1] = cells;
    from[2] = grid.lon_corner_rad, from[3] = grid.lat_corner_rad, rows[2] = rows[3] = corners;
    to[0] = position, to[1] = to[0] + cells, to[2] = to[1] + cells, to[3] = to[2] + corners;
    for (int k = 0; k < 4; k++) {
        for (int i = 0; i < rows[k]; i++) {
            to[k][i] = (float)from[k][i];
        }
    }
    other = grid;
    other.real_type = ICORAY_F32;
    other.lon_center_rad = to[0], other.lat_center_rad = to[1];
    other.lon_corner_rad = to[2], other.lat_corner_rad = to[3];
    OK(icoray_grid_set(ctx, &other));
    scene(ctx, "near plain", "none");
    frame_of(ctx, 4, &f);

    OK(icoray_close(&ctx));
    free(cell_corner);
    free(count);
    free(corner_cell);
    free(corner_edge);
    free(edge_corner);
    free(position);
    release(&f);
    release(&corner);
}

/* Two contexts, drawing by turns. */
static void by_turns(const char *directory)
{
    icoray_ctx *a = context(directory, "turns/a", 1), *b = context(directory, "turns/b", 3);
    Field f = field(ICORAY_F32, ICORAY_CENTER, LAYERS, (size_t)cells * LAYERS, 0, LAYERS, 1);
    Field g = field(ICORAY_F32, ICORAY_CORNER, LAYERS, (size_t)corners * LAYERS, 0, 1, corners);
    icoray_frame_report report;
    memset(&report, 0, sizeof report);
    report.struct_size = sizeof report;
    scene(a, "plain", "none");
    scene(b, "corner", "none");
    frame_of(a, 0, &f);
    frame_of(b, 10, &g);
    frame(a, 1);
    frame(b, 11);
    OK(icoray_report(a, &report));
    CHECK(report.step == 1 && report.derived_bytes == 0);
    OK(icoray_close(&a));
    frame(b, 12);
    OK(icoray_close(&b));
    release(&f);
    release(&g);
}

/* What a thread of the test draws. check.h counts without locks, so the thread keeps its own statuses. */
typedef struct {
    icoray_ctx *ctx;
    const char *wrong;
    int failed;
} Work;

static void *work(void *data)
{
    Work *w = data;
    char message[256] = "";
    for (int step = 0; step < 3; step++) {
        w->failed += icoray_execute(w->ctx, step, 0.0, NULL) != ICORAY_OK;
        w->failed += icoray_scene_load(w->ctx, w->wrong) != ICORAY_ERR_IO;
        w->failed += icoray_last_error(NULL, message, sizeof message) != ICORAY_OK;
        w->failed += strstr(message, w->wrong) == NULL;
    }
    return NULL;
}

/* Two contexts on two threads; each thread has its own last message. */
static void at_once(const char *directory)
{
    Work works[2] = {{NULL, "no such file, one", 0}, {NULL, "no such file, two", 0}};
    pthread_t thread[2];
    Field f = field(ICORAY_F32, ICORAY_CENTER, LAYERS, (size_t)cells * LAYERS, 0, LAYERS, 1);
    Field g = field(ICORAY_F32, ICORAY_CORNER, LAYERS, (size_t)corners * LAYERS, 0, LAYERS, 1);
    works[0].ctx = context(directory, "at_once/a", 1);
    works[1].ctx = context(directory, "at_once/b", 1);
    scene(works[0].ctx, "plain", "none");
    scene(works[1].ctx, "corner", "none");
    OK(icoray_field_set(works[0].ctx, "f", &f.array));
    OK(icoray_field_set(works[1].ctx, "f", &g.array));
    for (int i = 0; i < 2; i++) {
        CHECK(pthread_create(&thread[i], NULL, work, &works[i]) == 0);
    }
    for (int i = 0; i < 2; i++) {
        CHECK(pthread_join(thread[i], NULL) == 0);
        CHECK(works[i].failed == 0);
        OK(icoray_close(&works[i].ctx));
    }
    release(&f);
    release(&g);
}

int main(int argc, char **argv)
{
    if (argc != 4) {
        printf("pictures <directory> <level> <pixels>\n");
        return EXIT_FAILURE;
    }
    int before = threads();
    OK(icoray_mesh_create(atoi(argv[2]), &mesh));
    grid.struct_size = sizeof grid;
    OK(icoray_mesh_grid(mesh, &grid));
    cells = (int)grid.cells;
    corners = (int)grid.corners;
    pixels = atoi(argv[3]);
    CHECK(corners == 2 * cells - 4 && grid.edges == 3 * (int64_t)cells - 6);
    CHECK(grid.index_base == 0 && grid.real_type == ICORAY_F64 && grid.cell_corner_row == 6);
    CHECK(settles_at(before));

    in_place(argv[1]);
    CHECK(settles_at(before));
    icoray_ctx *ctx = context(argv[1], "unused", 3);
    CHECK(settles_at(before + 3)); /* as many as were asked for */
    OK(icoray_close(&ctx));
    layouts(argv[1]);
    missing(argv[1]);
    places(argv[1]);
    tables(argv[1]);
    by_turns(argv[1]);
    at_once(argv[1]);
    CHECK(settles_at(before)); /* none is left behind */

    OK(icoray_mesh_free(&mesh));
    CHECK(mesh == NULL);
    return verdict("pictures");
}
