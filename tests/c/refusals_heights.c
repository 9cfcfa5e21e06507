/* Heights that are refused, taken back, and not read by scenes without native heights. */
#define _POSIX_C_SOURCE 200809L /* mmap */

#include "refusals.h"

#include <fcntl.h>
#include <math.h>
#include <sys/mman.h>
#include <unistd.h>

static icoray_ndarray over(const float *data)
{
    icoray_ndarray array = {sizeof array};
    array.data = data;
    array.type = ICORAY_F32;
    array.rank = 2;
    array.extent[0] = LAYERS, array.stride[0] = 1;
    array.extent[1] = 42, array.stride[1] = LAYERS;
    return array;
}

static void arrays_of_heights(icoray_ctx *ctx)
{
#define IN(name) MEMBER(icoray_array, name)
    static const struct {
        size_t offset, size;
        int64_t value;
        icoray_status status;
        const char *part;
    } cases[] = {
        {IN(struct_size), 8, ICORAY_ERR_STRUCT_SIZE, "icoray_array.struct_size: 8"},
        {IN(data), 0, ICORAY_ERR_NULL, "heights: icoray_array.data is NULL"},
        {IN(type), ICORAY_I32, ICORAY_ERR_ARGUMENT, "heights: icoray_array.type: 3"},
        {IN(location), 7, ICORAY_ERR_ARGUMENT, "heights: icoray_array.location: 7"},
        {IN(columns), 0, ICORAY_ERR_FIELD, "heights: 0 columns"},
        {IN(columns), -1, ICORAY_ERR_ARGUMENT, "heights: icoray_array.columns: -1"},
        {IN(layers), 0, ICORAY_ERR_FIELD, "heights: 42 columns of 0 layers"},
        {IN(column_stride), 0, ICORAY_ERR_ARGUMENT, "heights: icoray_array.column_stride: 0"},
        {IN(column_stride), INT64_MAX, ICORAY_ERR_ARGUMENT, "heights: icoray_array: the strides"},
        {IN(block), -1, ICORAY_ERR_ARGUMENT, "heights: icoray_array.block: -1"},
    };
#undef IN
    icoray_array array;
    for (size_t i = 0; i < COUNT(cases); i++) {
        trying = cases[i].part;
        array = good_array;
        put(&array, cases[i].offset, cases[i].size, cases[i].value);
        REFUSED_AS(ctx, cases[i].status, cases[i].part, icoray_heights_set(ctx, &array));
    }
    trying = "names of heights";
    REFUSED_WITH(array, grid_name, NO_UTF8, ARGUMENT, "heights: grid_name", icoray_heights_set(ctx, &array));
    REFUSED_WITH(array, layers_name, NO_UTF8, ARGUMENT, "heights: layers_name", icoray_heights_set(ctx, &array));
    REFUSED(NULL, NULL, "ctx", icoray_heights_set(NULL, &good_array));
    REFUSED(NULL, NULL, "ctx", icoray_heights_set(NULL, NULL));
    trying = "";
}

static void ndarrays_of_heights(icoray_ctx *ctx)
{
    icoray_ctx *early = opened();
    icoray_ndarray array = over(values);
    trying = "heights of which the dimensions are known";
    REFUSED(early, ORDER, "icoray_heights_set_ndarray was called before a grid",
            icoray_heights_set_ndarray(early, &array));
    OK(icoray_heights_set_ndarray(early, NULL));
    OK(icoray_close(&early));
    REFUSED(NULL, NULL, "ctx", icoray_heights_set_ndarray(NULL, &array));
    OK(icoray_heights_set_ndarray(ctx, &array));
    array.location = ICORAY_CORNER;
    REFUSED(ctx, FIELD, "42 columns are the grid's cells: set location = ICORAY_CENTER",
            icoray_heights_set_ndarray(ctx, &array));
    array.extent[1] = 80;
    OK(icoray_heights_set_ndarray(ctx, &array));
    array.location = ICORAY_CENTER;
    REFUSED(ctx, FIELD, "80 columns are the grid's corners: set location = ICORAY_CORNER",
            icoray_heights_set_ndarray(ctx, &array));
    array = over(values);
    array.extent[1] = 41;
    REFUSED(ctx, FIELD, "heights: ", icoray_heights_set_ndarray(ctx, &array));
    array = over(NULL);
    REFUSED(ctx, NULL, "heights: icoray_ndarray.data", icoray_heights_set_ndarray(ctx, &array));
    array = over(values);
    array.grid_name = "no such grid";
    REFUSED(ctx, ARGUMENT, "heights: no grid named \"no such grid\"", icoray_heights_set_ndarray(ctx, &array));
    OK(icoray_heights_set_ndarray(ctx, NULL));
    OK(icoray_heights_set_ndarray(ctx, NULL)); /* there is nothing more to take back */
    trying = "";
}

/* Heights in unreadable memory end a process that reads them. */
static void left_alone(icoray_ctx *ctx)
{
    size_t bytes = (size_t)good_grid.cells * LAYERS * sizeof *values;
    int zero = open("/dev/zero", O_RDONLY);
    void *none = mmap(NULL, bytes, PROT_NONE, MAP_PRIVATE, zero, 0);
    icoray_array array = good_array;
    CHECK(zero >= 0 && none != MAP_FAILED);
    array.data = none;
    OK(icoray_heights_set(ctx, &array));
    still_draws(ctx);
    OK(icoray_heights_set(ctx, NULL));
    CHECK(munmap(none, bytes) == 0 && close(zero) == 0);
}

/* Scenes with heights = "native" read the values at the time of the frame. */
static void native(icoray_ctx *ctx)
{
    static float metres[42 * LAYERS];
    icoray_array array = good_array, fewer;
    icoray_ndarray flat = over(metres);
    for (int i = 0; i < 42 * LAYERS; i++) {
        metres[i] = 1e5f * (float)(i % LAYERS) + (float)(i % 7);
    }
    array.data = metres;
    OK(icoray_scene_text(ctx, "heights = \"native\"\n" SCENE("f", "4", "native_{step}.png")));
    NOT_DRAWN(ctx, FIELD, "heights: the scene has heights = \"native\", and none were given by icoray_heights_set");
    OK(icoray_heights_set(ctx, &array));
    OK(icoray_execute(ctx, 1, 0.0, NULL));
    fewer = array;
    fewer.columns--;
    OK(icoray_heights_set(ctx, &fewer));
    NOT_DRAWN(ctx, LAYERS, "heights: 41 columns of 3 layers, expected 42 of 3, as many as icoray_layers has");
    fewer = array;
    fewer.layers--;
    OK(icoray_heights_set(ctx, &fewer));
    NOT_DRAWN(ctx, LAYERS, "heights: 42 columns of 2 layers");
    OK(icoray_heights_set_ndarray(ctx, &flat));
    OK(icoray_execute(ctx, 3, 0.0, NULL));
    metres[5 * LAYERS + 1] = NAN;
    NOT_DRAWN(ctx, LAYERS, "heights: cell 5 (counted from 0), layer 2 of 3: missing");
    metres[5 * LAYERS] = metres[5 * LAYERS + 2] = NAN; /* a column without heights has the mean ones */
    OK(icoray_execute(ctx, 5, 0.0, NULL));
    metres[9 * LAYERS + 1] = -1e5f;
    NOT_DRAWN(ctx, LAYERS, "heights: cell 9 (counted from 0), layers 2 and 1 of 3");
    OK(icoray_heights_set(ctx, NULL));
    NOT_DRAWN(ctx, FIELD, "none were given");
    OK(icoray_wait(ctx));
    CHECK(is_picture("native_1.png") && is_picture("native_3.png") && is_picture("native_5.png"));
    OK(icoray_scene_text(ctx, good_scene));
}

/* Messages about wrong heights at corners name the corner. */
static void native_at_corners(icoray_ctx *ctx)
{
    static float metres[80 * LAYERS];
    icoray_array array = good_array;
    trying = "heights at corners";
    for (int i = 0; i < 80 * LAYERS; i++) {
        metres[i] = 1e5f * (float)(i % LAYERS) + (float)(i / LAYERS % 7);
    }
    array.data = metres;
    array.columns = 80;
    OK(icoray_scene_text(ctx, "heights = \"native\"\n" SCENE("f", "4", "corners_{step}.png")));
    OK(icoray_heights_set(ctx, &array));
    NOT_DRAWN(ctx, LAYERS, "heights: 80 columns of 3 layers, expected 42 of 3, as many as icoray_layers has (80 columns are "
                           "the grid's corners: set location = ICORAY_CORNER)");
    array.location = ICORAY_CORNER;
    OK(icoray_heights_set(ctx, &array));
    OK(icoray_execute(ctx, 1, 0.0, NULL));
    array.columns = 42;
    OK(icoray_heights_set(ctx, &array));
    NOT_DRAWN(ctx, LAYERS, "heights: 42 columns of 3 layers, expected 80 of 3");
    array.columns = 80;
    OK(icoray_heights_set(ctx, &array));
    metres[5 * LAYERS + 1] = NAN;
    NOT_DRAWN(ctx, LAYERS, "heights: corner 5 (counted from 0), layer 2 of 3: missing, but ");
    metres[5 * LAYERS] = metres[5 * LAYERS + 2] = NAN; /* means are of the other corners */
    OK(icoray_execute(ctx, 3, 0.0, NULL));
    metres[9 * LAYERS + 1] = -1e5f;
    NOT_DRAWN(ctx, LAYERS, "heights: corner 9 (counted from 0), layers 2 and 1 of 3: -100000 m lies below 2 m");
    OK(icoray_heights_set(ctx, NULL));
    OK(icoray_wait(ctx));
    CHECK(is_picture("corners_1.png") && is_picture("corners_3.png"));
    OK(icoray_scene_text(ctx, good_scene));
    trying = "";
}

void heights(icoray_ctx *ctx)
{
    arrays_of_heights(ctx);
    ndarrays_of_heights(ctx);
    left_alone(ctx);
    native(ctx);
    native_at_corners(ctx);
}
