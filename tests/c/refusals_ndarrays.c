/* Arrays of which just the dimensions are known. */
#include "refusals.h"

typedef struct {
    int rank;
    int64_t extent[ICORAY_MAX_RANK];
    int location;
    icoray_status status;
    const char *part;
} Case;

/* An array over the good values, the first dimension the fastest. */
static icoray_ndarray ndarray(const Case *c)
{
    icoray_ndarray array = {sizeof array};
    int64_t stride = 1;
    array.data = values;
    array.type = ICORAY_F32;
    array.location = c->location;
    array.rank = c->rank;
    for (int d = 0; d < ICORAY_MAX_RANK; d++) {
        array.extent[d] = c->extent[d];
        array.stride[d] = stride;
        if (c->extent[d] > 0 && c->extent[d] < 1000) {
            stride *= c->extent[d];
        }
    }
    return array;
}

static const Case good = {2, {3, 42}, ICORAY_CENTER, ICORAY_OK, ""};

static void extents(icoray_ctx *ctx)
{
    enum { AT = ICORAY_CENTER, OF_CORNER = ICORAY_CORNER };
    static const Case cases[] = {
        {0, {3, 42}, AT, ICORAY_ERR_ARGUMENT, "icoray_ndarray.rank: 0"},
        {8, {3, 42}, AT, ICORAY_ERR_ARGUMENT, "icoray_ndarray.rank: 8"},
        {-1, {3, 42}, AT, ICORAY_ERR_ARGUMENT, "icoray_ndarray.rank: -1"},
        {INT32_MIN, {3, 42}, AT, ICORAY_ERR_ARGUMENT, "icoray_ndarray.rank: -2147483648"},
        {INT32_MAX, {3, 42}, AT, ICORAY_ERR_ARGUMENT, "icoray_ndarray.rank: 2147483647"},
        {2, {-1, 42}, AT, ICORAY_ERR_ARGUMENT, "icoray_ndarray.extent[0]: -1"},
        {2, {3, -42}, AT, ICORAY_ERR_ARGUMENT, "icoray_ndarray.extent[1]: -42"},
        {7, {3, 42, 1, 1, 1, 1, INT64_MIN}, AT, ICORAY_ERR_ARGUMENT, "icoray_ndarray.extent[6]: -9"},
        {2, {3, INT64_MAX}, AT, ICORAY_ERR_ARGUMENT, "icoray_ndarray.extent[1]: 9"},
        {2, {3, (int64_t)1 << 40}, AT, ICORAY_ERR_ARGUMENT, "icoray_ndarray.extent[1]: 1099511627776"},
        {1, {0}, AT, ICORAY_ERR_FIELD, "[0]"},
        {2, {0, 42}, AT, ICORAY_ERR_FIELD, "[0, 42]"},
        {2, {3, 0}, AT, ICORAY_ERR_FIELD, "[3, 0]"},
        {3, {3, 42, 0}, AT, ICORAY_ERR_FIELD, "[3, 42, 0]"},
        {1, {1}, AT, ICORAY_ERR_FIELD, "[1]"},
        {7, {1, 1, 1, 1, 1, 1, 1}, AT, ICORAY_ERR_FIELD, "[1, 1, 1, 1, 1, 1, 1]"},
        {1, {125}, AT, ICORAY_ERR_FIELD, "[125]"},
        {1, {127}, AT, ICORAY_ERR_FIELD, "[127]"},
        {2, {3, 41}, AT, ICORAY_ERR_FIELD, "[3, 41]"},
        {2, {41, 3}, AT, ICORAY_ERR_FIELD, "[41, 3]"},
        {2, {4, 42}, AT, ICORAY_ERR_FIELD, "[4, 42]"},
        {2, {42, 42}, AT, ICORAY_ERR_FIELD, "[42, 42]"},
        {3, {8, 3, 5}, AT, ICORAY_ERR_FIELD, "[8, 3, 5]"},
        {3, {8, 4, 6}, AT, ICORAY_ERR_FIELD, "[8, 4, 6]"},
        {4, {2, 3, 2, 42}, AT, ICORAY_ERR_FIELD, "[2, 3, 2, 42]"},
        {7, {2, 2, 2, 2, 2, 2, 2}, AT, ICORAY_ERR_FIELD, "[2, 2, 2, 2, 2, 2, 2]"},
        {2, {3, 79}, OF_CORNER, ICORAY_ERR_FIELD, "expected one dimension of 3 layers"},
        {2, {3, 79}, OF_CORNER, ICORAY_ERR_FIELD, "80 columns"},
        {2, {3, 42}, OF_CORNER, ICORAY_ERR_FIELD, "42 columns are the grid's cells: set location = ICORAY_CENTER"},
        {2, {3, 80}, AT, ICORAY_ERR_FIELD, "[3, 80]: 80 columns are the grid's corners: set location = ICORAY_CORNER"},
        {2, {81, 3}, AT, ICORAY_ERR_FIELD, "81 columns are the grid's corners"},
        {3, {3, 80, 1}, AT, ICORAY_ERR_FIELD, "80 columns are the grid's corners"},
        {1, {240}, AT, ICORAY_ERR_FIELD, "80 columns are the grid's corners"},
        {2, {2, 120}, AT, ICORAY_ERR_FIELD, "the grid's edges: fields at edges are not drawn; average them to cells"},
        {2, {3, 107}, AT, ICORAY_ERR_FIELD, "107 columns, expected 42 and at most 64 of padding"},
        {2, {3, 42}, 2, ICORAY_ERR_ARGUMENT, "icoray_ndarray.location: 2"},
        {2, {3, 42}, -1, ICORAY_ERR_ARGUMENT, "icoray_ndarray.location: -1"},
        {2, {3, 42}, INT32_MAX, ICORAY_ERR_ARGUMENT, "icoray_ndarray.location"},
    };
    /* Extents that do; the values' memory has room for all of them. */
    static const Case right[] = { /* at centres */
        {1, {126}}, {1, {84}}, {2, {3, 42}}, {2, {42, 3}}, {2, {2, 42}}, {3, {1, 3, 42}}, {4, {1, 3, 1, 42}},
        {3, {7, 3, 6}}, {3, {3, 7, 6}}, {3, {7, 6, 3}}, {2, {3, 43}}, {2, {3, 106}}, {3, {200, 3, 1}},
        {2, {3, 42, -1}}, {7, {3, 1, 1, 42, 1, 1, 1}}, {3, {42, 3, 1}}, {5, {1, 7, 1, 3, 6}},
        {1, {42}}, {1, {43}}, {2, {1, 42}}, {2, {42, 1}}, /* of a 2D field */
    };
    for (size_t i = 0; i < COUNT(cases); i++) {
        icoray_ndarray array = ndarray(&cases[i]);
        trying = cases[i].part;
        REFUSED_AS(ctx, cases[i].status, cases[i].part, icoray_field_set_ndarray(ctx, "f", &array));
        REFUSED_AS(ctx, cases[i].status, "field \"f\"", icoray_field_set_ndarray(ctx, "f", &array));
    }
    OK(icoray_scene_text(ctx, SCENE("n", "4", "ndarray_{step}.png")));
    for (size_t i = 0; i < COUNT(right); i++) {
        icoray_ndarray array = ndarray(&right[i]);
        trying = "extents that do";
        OK(icoray_field_set_ndarray(ctx, "n", &array));
        OK(icoray_execute(ctx, (int64_t)i, 0.0, NULL));
    }
    OK(icoray_wait(ctx));
    OK(icoray_scene_text(ctx, good_scene));
    trying = "";
}

void ndarrays(icoray_ctx *ctx)
{
    static const int32_t types[] = {0, 3, 4, -1, INT32_MAX, INT32_MIN};
    static const int64_t strides[] = {INT64_MAX, INT64_MIN, INT64_MAX / 8, INT64_MIN / 8, (int64_t)1 << 60};
    icoray_ndarray array = ndarray(&good);
    extents(ctx);
    REFUSED(ctx, NULL, "name", icoray_field_set_ndarray(ctx, NULL, &array));
    REFUSED(ctx, NULL, "icoray_ndarray is NULL", icoray_field_set_ndarray(ctx, "f", NULL));
    REFUSED(NULL, NULL, "ctx", icoray_field_set_ndarray(NULL, "f", &array));
    REFUSED(ctx, ARGUMENT, "name", icoray_field_set_ndarray(ctx, NO_UTF8, &array));
    for (size_t i = 0; i < COUNT(types); i++) {
        trying = text_of("icoray_ndarray.type: %d", (int)types[i]);
        array = ndarray(&good);
        array.type = types[i];
        REFUSED(ctx, ARGUMENT, trying, icoray_field_set_ndarray(ctx, "f", &array));
    }
    trying = "strides";
    for (size_t i = 0; i < COUNT(strides); i++) {
        for (int d = 0; d < 2; d++) {
            array = ndarray(&good);
            array.stride[d] = strides[i];
            REFUSED(ctx, ARGUMENT, "icoray_ndarray: the strides reach", icoray_field_set_ndarray(ctx, "f", &array));
        }
    }
    trying = "";
    array = ndarray(&good);
    array.data = NULL;
    REFUSED(ctx, NULL, "icoray_ndarray.data", icoray_field_set_ndarray(ctx, "f", &array));
    array.data = (const char *)values + 1;
    REFUSED(ctx, ARGUMENT, "icoray_ndarray.data", icoray_field_set_ndarray(ctx, "f", &array));
    array = ndarray(&good);
    array.grid_name = NO_UTF8;
    REFUSED(ctx, ARGUMENT, "grid_name", icoray_field_set_ndarray(ctx, "f", &array));
    array = ndarray(&good);
    array.layers_name = NO_UTF8;
    REFUSED(ctx, ARGUMENT, "layers_name", icoray_field_set_ndarray(ctx, "f", &array));
}

/* Grid and layers say which dimension is which, so they come first, by the name that is asked for. */
void ndarrays_too_early(void)
{
    icoray_ndarray array = ndarray(&good);
    icoray_grid grid = good_grid;
    icoray_layers layers = good_layers;
    icoray_ctx *ctx = opened();
    REFUSED(ctx, ORDER, "icoray_grid_set", icoray_field_set_ndarray(ctx, "f", &array));
    OK(icoray_layers_set(ctx, &good_layers));
    REFUSED(ctx, ORDER, "icoray_grid_set", icoray_field_set_ndarray(ctx, "f", &array));
    OK(icoray_close(&ctx));
    ctx = opened();
    grid.name = "a";
    layers.name = "b";
    OK(icoray_grid_set(ctx, &grid));
    REFUSED(ctx, ARGUMENT, "no grid without a name", icoray_field_set_ndarray(ctx, "f", &array));
    array.grid_name = "A";
    REFUSED(ctx, ARGUMENT, "no grid named \"A\"", icoray_field_set_ndarray(ctx, "f", &array));
    array.grid_name = "a";
    REFUSED(ctx, ORDER, "icoray_layers_set", icoray_field_set_ndarray(ctx, "f", &array));
    OK(icoray_layers_set(ctx, &layers));
    REFUSED(ctx, ARGUMENT, "no set of layers without a name", icoray_field_set_ndarray(ctx, "f", &array));
    array.layers_name = "a";
    REFUSED(ctx, ARGUMENT, "no set of layers named \"a\"", icoray_field_set_ndarray(ctx, "f", &array));
    array.layers_name = "b";
    OK(icoray_field_set_ndarray(ctx, "f", &array));
    OK(icoray_scene_text(ctx, good_scene));
    still_draws(ctx);
    OK(icoray_close(&ctx));
}
