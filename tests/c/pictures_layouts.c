/* Fields as models have them in memory. */
#include "pictures.h"

#include <math.h>

static const double falling[LAYERS] = {PLANET + 20e3, PLANET + 9e3, PLANET + 4e3, PLANET};

/* (nlev, nproma, nblks) */
static icoray_array level_fastest_blocks(int type)
{
    icoray_array shape = shaped(type, ICORAY_CENTER, LAYERS, LAYERS, 1);
    shape.block = 16;
    shape.block_stride = 16 * LAYERS;
    return shape;
}

/* Every other element, the last block first, in each of them the columns and the layers from the last to the first. */
static icoray_array backward_blocks(int type)
{
    icoray_array shape = shaped(type, ICORAY_CENTER, LAYERS, -2, -32);
    shape.block = 16;
    shape.block_stride = -32 * LAYERS;
    return shape;
}

/* The same values in every layout are the same picture. */
void layouts(const char *directory)
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
        field(F32, AT, L, n + L + 1, 0, L, 1),                          /* MPAS: a column of NaN behind the last */
        field(F64, AT, L, (size_t)(cells + 1) * L + 1, 0, 1, cells + 1),
        blocked(F32, AT, L, 16), /* with a last block that is filled in part */
        blocked(F64, AT, L, 16),
        blocked(F32, AT, L, 1),
        blocked(F32, AT, L, cells - 1),
        blocked(F64, AT, L, cells),
        blocked(F32, AT, L, cells + 5), /* more than there are */
        filled(&grid, level_fastest_blocks(F32), (size_t)(cells + 16) * L, 0),
        filled(&grid, backward_blocks(F32), (size_t)(cells + 32) * L * 2 + 1, (size_t)(cells + 16) * L * 2),
        filled(&grid, backward_blocks(F64), (size_t)(cells + 32) * L * 2 + 1, (size_t)(cells + 16) * L * 2),
    };
    int count = (int)COUNT(fields);
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
        report = picture(ctx, "plain", "none", i, &fields[i]);
        CHECK(report.value_min == low && report.value_max == high);
        CHECK(report.missing_values == 0 && report.void_frusta == 0);
        CHECK(report.bytes_derived == 0);
        report = picture(ctx, "lit", "headlight", i, &fields[i]);
        CHECK(report.bytes_derived == n * 8 + (uint64_t)cells); /* gradients, packed, and whether they are known */
    }

    /* Layers handed over top first, with the field as it must then be: level 0 is the top. */
    icoray_layers layers = layers_of(falling, NULL);
    OK(icoray_layers_set(ctx, &layers));
    Field *first = &fields[0];
    first->array.data = (float *)first->memory + LAYERS - 1;
    first->array.layer_stride = -1;
    picture(ctx, "plain", "none", count, first);
    picture(ctx, "lit", "headlight", count, first);

    OK(icoray_close(&ctx));
    release_all(fields, count);
}
