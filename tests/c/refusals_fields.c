/* Layers and fields that are refused, by themselves or because they do not fit. */
#include "refusals.h"

#include <math.h>

void layers(icoray_ctx *ctx)
{
    static const struct {
        double radius[3], planet;
        int64_t count;
        icoray_status status;
        const char *part;
    } cases[] = {
        {{1, 2, 3}, 1, 0, ICORAY_ERR_LAYERS, "0 layers"},
        {{1, 2, 3}, 1, 1, ICORAY_ERR_LAYERS, "1 layers"},
        {{1, 2, 3}, 1, -1, ICORAY_ERR_ARGUMENT, "icoray_layers.count: -1"},
        {{1, 2, 3}, 1, INT64_MIN, ICORAY_ERR_ARGUMENT, "icoray_layers.count"},
        {{1, 2, 3}, 1, INT64_MAX, ICORAY_ERR_ARGUMENT, "icoray_layers.count"},
        {{1, 2, 2}, 1, 3, ICORAY_ERR_LAYERS, "layers 2 and 3 of 3"},
        {{1, 1, 2}, 1, 3, ICORAY_ERR_LAYERS, "layers 1 and 2 of 3"},
        {{1, 3, 2}, 1, 3, ICORAY_ERR_LAYERS, "strictly rising"},
        {{3, 1, 2}, 1, 3, ICORAY_ERR_LAYERS, "strictly falling"},
        {{1, NAN, 3}, 1, 3, ICORAY_ERR_LAYERS, "layer 2 of 3"},
        {{1, 2, INFINITY}, 1, 3, ICORAY_ERR_LAYERS, "layer 3 of 3"},
        {{-INFINITY, 2, 3}, 1, 3, ICORAY_ERR_LAYERS, "layer 1 of 3"},
        {{0, 2, 3}, 1, 3, ICORAY_ERR_LAYERS, "layer 1 of 3: radius 0, expected a positive number: radii are from the planet's centre"},
        {{-3, -2, -1}, 1, 3, ICORAY_ERR_LAYERS, "layer 1 of 3: radius -3"},
        {{10, 500, 30000}, 6371229, 3, ICORAY_ERR_LAYERS, "radii 10 to 30000, expected radii from the planet's centre"},
        {{30000, 500, 10}, 6371229, 3, ICORAY_ERR_LAYERS, "is at 6371229: add that to heights"},
        {{1, 2, 3}, 0, 3, ICORAY_ERR_LAYERS, "planet radius 0"},
        {{1, 2, 3}, -1, 3, ICORAY_ERR_LAYERS, "planet radius -1"},
        {{1, 2, 3}, NAN, 3, ICORAY_ERR_LAYERS, "planet radius NaN"},
        {{1, 2, 3}, INFINITY, 3, ICORAY_ERR_LAYERS, "planet radius inf"},
    };
    icoray_layers layers;
    for (size_t i = 0; i < COUNT(cases); i++) {
        trying = cases[i].part;
        layers = good_layers;
        layers.count = cases[i].count;
        layers.radius_m = cases[i].radius;
        layers.planet_radius_m = cases[i].planet;
        REFUSED_AS(ctx, cases[i].status, cases[i].part, icoray_layers_set(ctx, &layers));
    }
    trying = "";
    layers = good_layers;
    layers.radius_m = NULL;
    REFUSED(ctx, NULL, "icoray_layers.radius_m", icoray_layers_set(ctx, &layers));
    layers.radius_m = (const double *)((const char *)radius + 1);
    REFUSED(ctx, ARGUMENT, "icoray_layers.radius_m", icoray_layers_set(ctx, &layers));
    REFUSED_WITH(layers, name, NO_UTF8, ARGUMENT, "icoray_layers.name", icoray_layers_set(ctx, &layers));
}

void arrays(icoray_ctx *ctx)
{
#define IN(name) MEMBER(icoray_array, name)
    static const struct {
        size_t offset, size;
        int64_t value, block; /* block 0 leaves the columns in one piece */
        icoray_status status;
        const char *part;
    } cases[] = {
        {IN(type), 0, 0, ICORAY_ERR_ARGUMENT, "icoray_array.type: 0"},
        {IN(type), ICORAY_I32, 0, ICORAY_ERR_ARGUMENT, "icoray_array.type: 3"},
        {IN(type), ICORAY_I64, 0, ICORAY_ERR_ARGUMENT, "icoray_array.type: 4"},
        {IN(type), -1, 0, ICORAY_ERR_ARGUMENT, "icoray_array.type: -1"},
        {IN(type), INT32_MIN, 0, ICORAY_ERR_ARGUMENT, "icoray_array.type: -2147483648"},
        {IN(location), 2, 0, ICORAY_ERR_ARGUMENT, "icoray_array.location: 2"},
        {IN(location), -1, 0, ICORAY_ERR_ARGUMENT, "icoray_array.location: -1"},
        {IN(location), INT32_MAX, 0, ICORAY_ERR_ARGUMENT, "icoray_array.location: 2147483647"},
        {IN(columns), -1, 0, ICORAY_ERR_ARGUMENT, "icoray_array.columns: -1"},
        {IN(columns), INT64_MIN, 0, ICORAY_ERR_ARGUMENT, "icoray_array.columns"},
        {IN(columns), INT64_MAX, 0, ICORAY_ERR_ARGUMENT, "icoray_array.columns"},
        {IN(columns), 0, 0, ICORAY_ERR_FIELD, "0 columns"},
        {IN(columns), 0, 8, ICORAY_ERR_FIELD, "0 columns"},
        {IN(layers), -1, 0, ICORAY_ERR_ARGUMENT, "icoray_array.layers: -1"},
        {IN(layers), INT64_MIN, 0, ICORAY_ERR_ARGUMENT, "icoray_array.layers"},
        {IN(layers), INT64_MAX, 0, ICORAY_ERR_ARGUMENT, "icoray_array.layers"},
        {IN(layers), 0, 0, ICORAY_ERR_FIELD, "0 layers"},
        {IN(column_stride), 0, 0, ICORAY_ERR_ARGUMENT, "icoray_array.column_stride: 0"},
        {IN(block_stride), 0, 8, ICORAY_ERR_ARGUMENT, "icoray_array.block_stride: 0"},
        {IN(column_stride), INT64_MAX, 0, ICORAY_ERR_ARGUMENT, "icoray_array: the strides"},
        {IN(column_stride), INT64_MIN, 0, ICORAY_ERR_ARGUMENT, "icoray_array: the strides"},
        {IN(column_stride), INT64_MAX / 41, 0, ICORAY_ERR_ARGUMENT, "icoray_array: the strides"},
        {IN(column_stride), INT64_MIN / 41, 0, ICORAY_ERR_ARGUMENT, "icoray_array: the strides"},
        {IN(column_stride), INT64_MAX / 7, 8, ICORAY_ERR_ARGUMENT, "icoray_array: the strides"},
        {IN(column_stride), INT64_MIN / 7, 8, ICORAY_ERR_ARGUMENT, "icoray_array: the strides"},
        {IN(layer_stride), INT64_MAX, 0, ICORAY_ERR_ARGUMENT, "icoray_array: the strides"},
        {IN(layer_stride), INT64_MIN, 0, ICORAY_ERR_ARGUMENT, "icoray_array: the strides"},
        {IN(layer_stride), INT64_MAX / 8, 0, ICORAY_ERR_ARGUMENT, "icoray_array: the strides"},
        {IN(layer_stride), INT64_MAX / 8, 8, ICORAY_ERR_ARGUMENT, "icoray_array: the strides"},
        {IN(block), -1, 0, ICORAY_ERR_ARGUMENT, "icoray_array.block: -1"},
        {IN(block), INT64_MIN, 0, ICORAY_ERR_ARGUMENT, "icoray_array.block: -9"},
        {IN(block), INT64_MAX, 0, ICORAY_ERR_ARGUMENT, "icoray_array.block: 9"},
        {IN(block), (int64_t)1 << 40, 0, ICORAY_ERR_ARGUMENT, "icoray_array.block: 1099511627776"},
        {IN(block_stride), INT64_MAX, 8, ICORAY_ERR_ARGUMENT, "icoray_array: the strides"},
        {IN(block_stride), INT64_MIN, 8, ICORAY_ERR_ARGUMENT, "icoray_array: the strides"},
        {IN(block_stride), INT64_MAX / 5, 8, ICORAY_ERR_ARGUMENT, "icoray_array: the strides"},
        {IN(block_stride), INT64_MIN / 5, 8, ICORAY_ERR_ARGUMENT, "icoray_array: the strides"},
        {IN(block_stride), INT64_MAX / 41, 1, ICORAY_ERR_ARGUMENT, "icoray_array: the strides"},
        {IN(block_stride), INT64_MIN / 41, 1, ICORAY_ERR_ARGUMENT, "icoray_array: the strides"},
        {IN(block_stride), (int64_t)1 << 62, 41, ICORAY_ERR_ARGUMENT, "icoray_array: the strides"},
    };
#undef IN
    /* Blocks that do: of one column, with a last one of 2 columns, full, of all columns, of more than there are. */
    static const int64_t blocks[] = {1, 8, 7, 41, 42, 43, 1000, 4294967296};
    icoray_array array;
    for (size_t i = 0; i < COUNT(cases); i++) {
        trying = cases[i].part;
        array = good_array;
        array.block = cases[i].block;
        array.block_stride = cases[i].block * LAYERS;
        put(&array, cases[i].offset, cases[i].size, cases[i].value);
        REFUSED_AS(ctx, cases[i].status, cases[i].part, icoray_field_set(ctx, "f", &array));
        REFUSED_AS(ctx, cases[i].status, "field \"f\"", icoray_field_set(ctx, "f", &array));
    }
    trying = "blocks that do";
    for (size_t i = 0; i < COUNT(blocks); i++) {
        array = good_array;
        array.block = blocks[i];
        /* Level-fastest inside the block, so that all of these are the same array. */
        array.block_stride = blocks[i] <= array.columns ? blocks[i] * LAYERS : INT64_MAX;
        OK(icoray_field_set(ctx, "f", &array));
        still_draws(ctx);
    }
    array = good_array;
    array.block_stride = INT64_MIN; /* means nothing without blocks */
    OK(icoray_field_set(ctx, "f", &array));
    still_draws(ctx);
    OK(icoray_field_set(ctx, "f", &good_array));
    trying = "";
    array = good_array;
    array.columns = (int64_t)1 << 32;
    array.columns += 1;
    array.column_stride = array.layer_stride = array.block_stride = 1;
    array.block = 8;
    REFUSED(ctx, FIELD, "4294967297 columns in blocks", icoray_field_set(ctx, "f", &array));
    REFUSED_WITH(array, grid_name, NO_UTF8, ARGUMENT, "grid_name", icoray_field_set(ctx, "f", &array));
    REFUSED_WITH(array, layers_name, NO_UTF8, ARGUMENT, "layers_name", icoray_field_set(ctx, "f", &array));
    /* One reaches far down, the other far up: each is within bounds, the whole is not. */
    array = good_array;
    array.columns = array.layers = 2;
    array.column_stride = -((int64_t)1 << 59);
    array.layer_stride = (int64_t)1 << 59;
    array.type = ICORAY_F64;
    REFUSED(ctx, ARGUMENT, "address space", icoray_field_set(ctx, "f", &array));
    array = good_array;
    array.data = NULL;
    REFUSED(ctx, NULL, "icoray_array.data", icoray_field_set(ctx, "f", &array));
    array.data = (const char *)values + 2;
    REFUSED(ctx, ARGUMENT, "not aligned", icoray_field_set(ctx, "f", &array));
    REFUSED(ctx, ARGUMENT, "UTF-8", icoray_field_set(ctx, NO_UTF8, &good_array));
}

/* Fields that are right by themselves and do not fit grid, layers or scene. */
void misfits(icoray_ctx *ctx)
{
    static const struct {
        int location;
        int64_t columns, layers;
        const char *part;
    } cases[] = {
        {ICORAY_CENTER, 41, LAYERS, "41 columns, expected 42"},
        {ICORAY_CENTER, 1, LAYERS, "1 columns, expected 42"},
        {ICORAY_CORNER, 42, LAYERS, "42 columns, expected 80, one per corner (42 columns are the grid's cells: set"},
        {ICORAY_CENTER, 80, LAYERS, "80 columns are the grid's corners: set location = ICORAY_CORNER"},
        {ICORAY_CENTER, 81, LAYERS, "81 columns are the grid's corners"},
        {ICORAY_CENTER, 120, LAYERS, "120 columns are the grid's edges: fields at edges are not drawn"},
        {ICORAY_CENTER, 42, 4, "4 layers, expected 3"},
        {ICORAY_CENTER, 31, 4, "31 columns, expected 42"},
        {ICORAY_CENTER, 43, LAYERS - 1, "43 columns, expected 42"},
    };
    icoray_array array;
    icoray_layers two = good_layers;
    for (size_t i = 0; i < COUNT(cases); i++) {
        trying = cases[i].part;
        array = good_array;
        array.location = cases[i].location;
        array.columns = cases[i].columns;
        array.layers = cases[i].layers;
        array.column_stride = cases[i].layers;
        OK(icoray_field_set(ctx, "f", &array));
        NOT_DRAWN(ctx, FIELD, cases[i].part);
    }
    trying = "";
    OK(icoray_field_set(ctx, "f", &good_array));
    /* More layers than the field, handed over after it. */
    two.count = 2;
    OK(icoray_layers_set(ctx, &two));
    NOT_DRAWN(ctx, FIELD, "3 layers, expected 2");
    OK(icoray_layers_set(ctx, &good_layers));
}
