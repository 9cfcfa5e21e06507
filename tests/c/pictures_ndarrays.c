/* Fields of which just the dimensions are known: arrays of one to seven, in every order of them. */
#include "pictures.h"

/* The array of a field, with these dimensions. */
static icoray_ndarray ndarray(const Field *f, int rank, const int64_t *extent, const int64_t *stride)
{
    icoray_ndarray array = {sizeof array};
    array.data = f->array.data;
    array.type = f->array.type;
    array.location = f->array.location;
    array.rank = rank;
    for (int d = 0; d < rank; d++) {
        array.extent[d] = extent[d];
        array.stride[d] = stride[d];
    }
    return array;
}

/* Draws a field as an array of `rank` dimensions, which are `dimension` with extent and stride by turns. */
static void drawn(icoray_ctx *ctx, int step, Field f, int rank, const int64_t *dimension)
{
    int64_t extent[ICORAY_MAX_RANK], stride[ICORAY_MAX_RANK];
    icoray_ndarray array;
    for (int d = 0; d < rank; d++) {
        extent[d] = dimension[2 * d];
        stride[d] = dimension[2 * d + 1];
    }
    array = ndarray(&f, rank, extent, stride);
    OK(icoray_field_set_ndarray(ctx, "f", &array));
    memset(&array, 0, sizeof array); /* was copied */
    frame(ctx, step);
    release(&f);
}

void ndarrays(const char *directory)
{
    enum { F32 = ICORAY_F32, F64 = ICORAY_F64, AT = ICORAY_CENTER, L = LAYERS, P = 8, GROUPS = 3 };
    static const char *const groups[GROUPS] = {"plain", "corner", "midway"};
    icoray_ctx *ctx = context(directory, "ndarrays", 2);
    for (int group = 0; group < GROUPS; group++) {
        int at = group == 1 ? ICORAY_CORNER : AT, l = group == 2 ? L - 1 : L, step = 0;
        int64_t n = group == 1 ? corners : cells, blocks = (n + P - 1) / P;
        size_t all = (size_t)(n * l), padded = (size_t)(blocks * P * l);
        icoray_array shape = shaped(F32, at, l, l, 1);
        scene(ctx, groups[group], "none");
#define DRAWN(field, rank, ...)                                     \
    do {                                                            \
        const int64_t dimension[] = {__VA_ARGS__};                  \
        drawn(ctx, step++, field, rank, dimension);                 \
    } while (0)
        for (int type = F32; type <= (group == 1 ? F32 : F64); type++) { /* averages of doubles are others */
            /* One: rows of layers. */
            DRAWN(field(type, at, l, all, 0, l, 1), 1, n * l, 1);
            DRAWN(field(type, at, l, all, all - 1, -l, -1), 1, n * l, -1);
            DRAWN(field(type, at, l, 2 * all, 0, 2 * l, 2), 1, n * l, 2);
            /* Two, in either order, padded, and turned round. */
            DRAWN(field(type, at, l, all, 0, l, 1), 2, l, 1, n, l);
            DRAWN(field(type, at, l, all, 0, l, 1), 2, n, l, l, 1);
            DRAWN(field(type, at, l, all, 0, 1, n), 2, n, 1, l, n);
            DRAWN(field(type, at, l, all + (size_t)l + 1, 0, l, 1), 2, l, 1, n + 1, l);
            DRAWN(field(type, at, l, (size_t)((n + 1) * l + 1), 0, 1, n + 1), 2, n + 1, 1, l, n + 1);
            DRAWN(field(type, at, l, (size_t)(n * (l + 3)), 2, l + 3, 1), 2, l, 1, n, l + 3);
            DRAWN(field(type, at, l, all, all - 1, -l, -1), 2, l, -1, n, -l);
            DRAWN(field(type, at, l, all, all - (size_t)l, -l, 1), 2, n, -l, l, 1);
            /* Three: blocks of columns, with the layers in the middle, first and last. */
            DRAWN(blocked(type, at, l, P), 3, P, 1, l, P, blocks, P * l);
            DRAWN(blocked(type, at, l, P), 3, l, P, P, 1, blocks, P * l);
            DRAWN(blocked(type, at, l, P), 3, P, 1, blocks, P * l, l, P);
            shape.type = type, shape.block = P, shape.block_stride = P * l;
            DRAWN(filled(&grid, shape, padded, 0), 3, l, 1, P, l, blocks, P * l);
            /* Four and more: those of extent 1 do not count. */
            DRAWN(field(type, at, l, all, 0, l, 1), 3, 1, 77, l, 1, n, l);
            DRAWN(field(type, at, l, all, 0, l, 1), 4, l, 1, 1, 0, n, l, 1, -5);
            DRAWN(blocked(type, at, l, P), 4, P, 1, l, P, 1, 0, blocks, P * l);
            DRAWN(blocked(type, at, l, P), 4, P, 1, l, P, blocks, P * l, 1, 3);
            DRAWN(field(type, at, l, all, 0, l, 1), 4, 1, 0, n * l, 1, 1, 0, 1, 0);
            DRAWN(blocked(type, at, l, P), 7, 1, 1, P, 1, 1, 9, l, P, 1, 1, blocks, P * l, 1, 4);
        }
#undef DRAWN
    }
    OK(icoray_close(&ctx));
}
