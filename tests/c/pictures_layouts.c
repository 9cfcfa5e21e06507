/* Fields as models have them in memory. */
#include "pictures.h"

#include <math.h>

static const double falling[LAYERS] = {PLANET + 20e3, PLANET + 9e3, PLANET + 4e3, PLANET};

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
