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
        {{1, 2, 2}, 1, 3, ICORAY_ERR_LAYERS, "layers 1 and 2"},
        {{1, 1, 2}, 1, 3, ICORAY_ERR_LAYERS, "layers 0 and 1"},
        {{1, 3, 2}, 1, 3, ICORAY_ERR_LAYERS, "strictly rising"},
        {{3, 1, 2}, 1, 3, ICORAY_ERR_LAYERS, "strictly falling"},
        {{1, NAN, 3}, 1, 3, ICORAY_ERR_LAYERS, "layer 1"},
        {{1, 2, INFINITY}, 1, 3, ICORAY_ERR_LAYERS, "layer 2"},
        {{-INFINITY, 2, 3}, 1, 3, ICORAY_ERR_LAYERS, "layer 0"},
        {{0, 2, 3}, 1, 3, ICORAY_ERR_LAYERS, "layer 0: radius 0"},
        {{-3, -2, -1}, 1, 3, ICORAY_ERR_LAYERS, "layer 0: radius -3"},
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
        REFUSED(ctx, cases[i].status, cases[i].part, icoray_layers_set(ctx, &layers));
    }
    trying = "";
    layers = good_layers;
    layers.radius_m = NULL;
    REFUSED(ctx, ICORAY_ERR_NULL, "icoray_layers.radius_m", icoray_layers_set(ctx, &layers));
    layers.radius_m = (const double *)((const char *)radius + 1);
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "icoray_layers.radius_m", icoray_layers_set(ctx, &layers));
}

void arrays(icoray_ctx *ctx)
{
    enum { TYPE, LOCATION, COLUMNS, ROWS, COLUMN_STRIDE, LAYER_STRIDE };
    static const struct {
        int member;
        int64_t value;
        icoray_status status;
        const char *part;
    } cases[] = {
        {TYPE, 0, ICORAY_ERR_ARGUMENT, "type 0"},
        {TYPE, 3, ICORAY_ERR_ARGUMENT, "type 3"},
        {TYPE, -1, ICORAY_ERR_ARGUMENT, "type -1"},
        {LOCATION, 2, ICORAY_ERR_ARGUMENT, "icoray_array.location: 2"},
        {LOCATION, -1, ICORAY_ERR_ARGUMENT, "icoray_array.location: -1"},
        {COLUMNS, -1, ICORAY_ERR_ARGUMENT, "icoray_array.columns: -1"},
        {COLUMNS, INT64_MAX, ICORAY_ERR_ARGUMENT, "icoray_array.columns"},
        {COLUMNS, 0, ICORAY_ERR_FIELD, "0 columns"},
        {ROWS, -1, ICORAY_ERR_ARGUMENT, "icoray_array.layers: -1"},
        {ROWS, INT64_MIN, ICORAY_ERR_ARGUMENT, "icoray_array.layers"},
        {ROWS, INT64_MAX, ICORAY_ERR_ARGUMENT, "icoray_array.layers"},
        {ROWS, 0, ICORAY_ERR_FIELD, "0 layers"},
        {COLUMN_STRIDE, INT64_MAX, ICORAY_ERR_ARGUMENT, "strides"},
        {COLUMN_STRIDE, INT64_MIN, ICORAY_ERR_ARGUMENT, "strides"},
        {COLUMN_STRIDE, INT64_MAX / 41, ICORAY_ERR_ARGUMENT, "strides"},
        {COLUMN_STRIDE, INT64_MIN / 41, ICORAY_ERR_ARGUMENT, "strides"},
        {LAYER_STRIDE, INT64_MAX, ICORAY_ERR_ARGUMENT, "strides"},
        {LAYER_STRIDE, INT64_MIN, ICORAY_ERR_ARGUMENT, "strides"},
        {LAYER_STRIDE, INT64_MAX / 8, ICORAY_ERR_ARGUMENT, "strides"},
    };
    icoray_array array;
    for (size_t i = 0; i < COUNT(cases); i++) {
        int64_t v = cases[i].value;
        trying = cases[i].part;
        array = good_array;
        switch (cases[i].member) {
        case TYPE: array.type = (int32_t)v; break;
        case LOCATION: array.location = (int32_t)v; break;
        case COLUMNS: array.columns = v; break;
        case ROWS: array.layers = v; break;
        case COLUMN_STRIDE: array.column_stride = v; break;
        default: array.layer_stride = v;
        }
        REFUSED(ctx, cases[i].status, cases[i].part, icoray_field_set(ctx, "f", &array));
        REFUSED(ctx, cases[i].status, "field \"f\"", icoray_field_set(ctx, "f", &array));
    }
    trying = "";
    /* One reaches far down, the other far up: each is within bounds, the whole is not. */
    array = good_array;
    array.columns = array.layers = 2;
    array.column_stride = -((int64_t)1 << 59);
    array.layer_stride = (int64_t)1 << 59;
    array.type = ICORAY_F64;
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "address space", icoray_field_set(ctx, "f", &array));
    array = good_array;
    array.data = NULL;
    REFUSED(ctx, ICORAY_ERR_NULL, "icoray_array.data", icoray_field_set(ctx, "f", &array));
    array.data = (const char *)values + 2;
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "not aligned", icoray_field_set(ctx, "f", &array));
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "UTF-8", icoray_field_set(ctx, NO_UTF8, &good_array));
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
        {ICORAY_CORNER, 42, LAYERS, "42 columns, expected 80"},
        {ICORAY_CENTER, 42, 1, "1 layers, expected 3"},
        {ICORAY_CENTER, 31, 4, "31 columns, expected 42"},
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
        REFUSED(ctx, ICORAY_ERR_FIELD, cases[i].part, icoray_execute(ctx, 0, 0.0, NULL));
    }
    trying = "";
    OK(icoray_field_set(ctx, "f", &good_array));
    /* More layers than the field, handed over after it. */
    two.count = 2;
    OK(icoray_layers_set(ctx, &two));
    REFUSED(ctx, ICORAY_ERR_FIELD, "3 layers, expected 2", icoray_execute(ctx, 0, 0.0, NULL));
    OK(icoray_layers_set(ctx, &good_layers));
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "iso_datetime", icoray_execute(ctx, 0, 0.0, NO_UTF8));
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "time_s", icoray_execute(ctx, 0, NAN, NULL));
}
