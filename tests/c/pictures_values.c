/* Values that change, that are missing, and that lie at corners or midway between layers. */
#include "pictures.h"

#include <math.h>

/* NICAM's undefined value. As a double it is another number than as a float. */
#define UNDEFINED -9.9999e30

/* A field is read where it lies, when it is drawn: handed over once, it may change. */
void in_place(const char *directory)
{
    icoray_ctx *ctx = context(directory, "in_place", 1);
    Field f = field(ICORAY_F32, ICORAY_CENTER, LAYERS, (size_t)cells * LAYERS, 0, LAYERS, 1);
    float *values = (float *)f.memory;
    icoray_frame_report report;

    picture(ctx, "plain", "none", 0, &f);
    for (int i = 0; i < cells * LAYERS; i++) {
        values[i] = -values[i];
    }
    scene(ctx, "turned", "none");
    frame(ctx, 1);
    scribble(&f, 0.5);
    values[7] = 77.0f;
    scene(ctx, "flat", "none");
    report = frame(ctx, 2);
    CHECK(report.value_min == 0.5 && report.value_max == 77.0);
    memcpy(f.memory, f.before, f.bytes);
    scene(ctx, "plain", "none");
    frame(ctx, 3);

    /* Refused calls in between change neither the grid nor the field. */
    icoray_grid bad = grid;
    icoray_array far = f.array;
    bad.edge_corner = grid.corner_cell;
    REFUSED(ctx, GRID, "edge_corner", icoray_grid_set(ctx, &bad));
    far.column_stride = INT64_MAX;
    REFUSED(ctx, ARGUMENT, "strides", icoray_field_set(ctx, "f", &far));
    frame(ctx, 4);

    OK(icoray_close(&ctx));
    release(&f);
}

/* Time levels that are swapped: the pointers move from step to step, in every layout that the field has. */
void swapped(const char *directory)
{
    icoray_ctx *ctx = context(directory, "swapped", 2);
    Field levels[3] = {
        field(ICORAY_F32, ICORAY_CENTER, LAYERS, (size_t)cells * LAYERS, 0, LAYERS, 1),
        field(ICORAY_F64, ICORAY_CENTER, LAYERS, (size_t)cells * LAYERS, 0, 1, cells),
        blocked(ICORAY_F32, ICORAY_CENTER, LAYERS, 16),
    };
    for (int i = 0; i < cells * LAYERS; i++) {
        ((double *)levels[1].memory)[i] *= -1.0;
    }
    memcpy(levels[1].before, levels[1].memory, levels[1].bytes);
    for (int step = 0; step < 8; step++) {
        int now = step % 4 == 3 ? 1 : step % 4;
        picture(ctx, now == 1 ? "turned" : "plain", "none", step, &levels[now]);
    }
    OK(icoray_close(&ctx));
    release_all(levels, 3);
}

/* Missing values: by NaN, by infinity, and by the mark, which an array of floats holds rounded to a float. */
void missing(const char *directory)
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
            put(&f, i, mark);
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
    scribble(&f, NAN);
    memcpy(f.before, f.memory, f.bytes);
    scene(ctx, "nothing", "headlight");
    icoray_frame_report report = frame_of(ctx, 9, &f);
    CHECK(isnan(report.value_min) && isnan(report.value_max));
    CHECK(report.missing_values == (uint64_t)cells * LAYERS);
    OK(icoray_close(&ctx));
    release(&f);
}

/* Fields at corners are averaged to cells; fields with a layer fewer lie midway. */
void places(const char *directory)
{
    icoray_ctx *ctx = context(directory, "places", 2);
    size_t n = (size_t)corners * LAYERS;
    Field level = field(ICORAY_F32, ICORAY_CORNER, LAYERS, n, 0, LAYERS, 1);
    Field cell = field(ICORAY_F32, ICORAY_CORNER, LAYERS, n, 0, 1, corners);
    Field blocks = blocked(ICORAY_F32, ICORAY_CORNER, LAYERS, 16);
    Field wide = field(ICORAY_F64, ICORAY_CORNER, LAYERS, n, 0, LAYERS, 1);
    Field midway = field(ICORAY_F32, ICORAY_CENTER, LAYERS - 1, (size_t)cells * (LAYERS - 1), 0, LAYERS - 1, 1);
    Field midblocks = blocked(ICORAY_F64, ICORAY_CENTER, LAYERS - 1, 16);
    uint64_t averages = (uint64_t)cells * LAYERS;

    CHECK(picture(ctx, "corner", "none", 0, &level).bytes_derived == averages * sizeof(float));
    CHECK(frame_of(ctx, 1, &cell).bytes_derived == averages * sizeof(float));
    CHECK(frame_of(ctx, 5, &blocks).bytes_derived == averages * sizeof(float));
    CHECK(picture(ctx, "litcorner", "headlight", 2, &level).bytes_derived
          == averages * (sizeof(float) + 8) + (uint64_t)cells);
    scene(ctx, "near corner", "none"); /* the averages are rounded less */
    CHECK(frame_of(ctx, 3, &wide).bytes_derived == averages * sizeof(double));
    CHECK(picture(ctx, "midway", "none", 4, &midway).bytes_derived == 0);
    CHECK(frame_of(ctx, 6, &midblocks).bytes_derived == 0);

    OK(icoray_close(&ctx));
    release(&level);
    release(&cell);
    release(&wide);
    release(&midway);
    release(&midblocks);
    release(&blocks);
}
