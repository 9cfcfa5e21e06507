/* Several fields in one scene, and native heights: drawn in the call and from copies. */
#include "pictures.h"

#include <math.h>

/* A scene of the fields "f" and "v", at the heights of columns or at the mean ones. */
static void scene_of_two(icoray_ctx *ctx, const char *group, const char *heights)
{
    OK(icoray_scene_text(ctx, text_of(
        "backend = \"cpu\"\nexaggeration = 40\nheights = \"%s\"\n"
        "[image]\nwidth = %d\nheight = %d\n"
        CAMERA
        "[[volumes]]\nfield = \"f\"\n[volumes.transfer]\n" VIRIDIS
        "[[volumes]]\nfield = \"v\"\n[volumes.transfer]\nmap = \"magma\"\nrange = [-1, 1]\n"
        "opacity = [[-1, 0.0], [0, 0.0], [1, 0.9]]\n"
        "[output]\nfile = \"%s_{step}.png\"\n",
        heights, pixels, pixels, group)));
}

/* Hills, exact in a float. */
static double height(int column, int layer)
{
    return radius[layer] - PLANET + 1000.0 * floor(4.0 * (1.0 + center_value(column, 0)));
}

static void raise_hills(Field *f)
{
    for (int c = 0; c < cells; c++) {
        for (int l = 0; l < LAYERS; l++) {
            int64_t at = c * f->array.column_stride + l * f->array.layer_stride;
            put(f, at, height(c, l));
        }
    }
    memcpy(f->before, f->memory, f->bytes);
}

/* Hills at corners, exact in a float. */
static double corner_height(int corner, int layer)
{
    return radius[layer] - PLANET + 1000.0 * (corner * 7919 % 5) * (LAYERS - layer);
}

static void raise_corners(Field *f)
{
    const icoray_array *a = &f->array;
    for (int c = 0; c < corners; c++) {
        int64_t first = a->block == 0 ? c * a->column_stride
                                      : c % a->block * a->column_stride + c / a->block * a->block_stride;
        for (int l = 0; l < LAYERS; l++) {
            put(f, first + l * a->layer_stride, corner_height(c, l));
        }
    }
    memcpy(f->before, f->memory, f->bytes);
}

/* The means of these over the corners of each cell, of which pentagons repeat one. */
static void average_corners(Field *f)
{
    const int32_t *cell_corner = grid.cell_corner;
    for (int c = 0; c < cells; c++) {
        const int32_t *around = cell_corner + 6 * c;
        for (int l = 0; l < LAYERS; l++) {
            double sum = 0.0;
            int count = 0;
            for (int k = 0; k < 6; k++) {
                int is_new = 1;
                for (int j = 0; j < k; j++) {
                    is_new &= around[j] != around[k];
                }
                sum += is_new ? corner_height(around[k], l) : 0.0;
                count += is_new;
            }
            put(f, c * f->array.column_stride + l * f->array.layer_stride, sum / count);
        }
    }
    memcpy(f->before, f->memory, f->bytes);
}

static icoray_ctx *opened(const char *directory, const char *name, int in_background)
{
    icoray_config config = {.threads = 2, .async_render = in_background};
    return context_with(directory, name, config);
}

/* Errors name the missing field and all fields that the scene needs; nothing is drawn. */
static void refused_fields(const char *directory, const Field *f, const Field *v)
{
    icoray_ctx *ctx = opened(directory, "fields/refused", 0);
    icoray_array other = v->array;
    OK(icoray_field_set(ctx, "f", &f->array));
    scene_of_two(ctx, "two", "mean");
    REFUSED(ctx, FIELD,
            "the scene's field \"v\" was not given by icoray_field_set; the scene needs [\"f\", \"v\"], given: [\"f\"]",
            icoray_execute(ctx, 0, 0.0, NULL));
    other.grid_name = "other";
    OK(icoray_field_set(ctx, "v", &other));
    REFUSED(ctx, FIELD, "field \"v\": grid \"other\", expected \"\" as of field \"f\"",
            icoray_execute(ctx, 0, 0.0, NULL));
    OK(icoray_field_set(ctx, "v", &v->array));
    scene_of_two(ctx, "hills", "native");
    REFUSED(ctx, FIELD, "none were given by icoray_heights_set", icoray_execute(ctx, 0, 0.0, NULL));
    OK(icoray_close(&ctx));
}

/* Heights at corners, in all layouts, and what they are at cells: one picture. */
static void at_corners(const char *directory, const Field *f, const Field *v)
{
    enum { F64 = ICORAY_F64, AT = ICORAY_CORNER, L = LAYERS };
    size_t n = (size_t)cells * L, m = (size_t)corners * L;
    Field hills[] = {
        field(F64, ICORAY_CENTER, L, n, 0, 1, cells), field(F64, AT, L, m, 0, L, 1), field(F64, AT, L, m, 0, 1, corners),
        blocked(F64, AT, L, 16),
    };
    average_corners(&hills[0]);
    for (int i = 1; i < 4; i++) {
        raise_corners(&hills[i]);
    }
    for (int in_background = 0; in_background < 2; in_background++) {
        const char *name = in_background ? "fields/corners/background" : "fields/corners/in_the_call";
        icoray_ctx *ctx = opened(directory, name, in_background);
        uint64_t derived = 0;
        OK(icoray_field_set(ctx, "f", &f->array));
        OK(icoray_field_set(ctx, "v", &v->array));
        scene_of_two(ctx, "averaged", "native");
        for (int i = 0; i < 4; i++) {
            OK(icoray_heights_set(ctx, &hills[i].array));
            copy_expected = in_background ? bytes_of(f) + bytes_of(v) + bytes_of(&hills[i]) : 0;
            icoray_frame_report report = frame(ctx, i);
            derived = i == 0 ? report.bytes_derived : derived;
            CHECK(report.bytes_derived == derived + (i > 0 ? bytes_of(&hills[0]) : 0));
        }
        copy_expected = 0;
        OK(icoray_close(&ctx));
    }
    release_all(hills, 4);
}

void fields(const char *directory)
{
    enum { F32 = ICORAY_F32, F64 = ICORAY_F64, AT = ICORAY_CENTER, L = LAYERS };
    size_t n = (size_t)cells * L, m = (size_t)corners * L;
    Field f[] = {field(F32, AT, L, n, 0, L, 1), field(F32, AT, L, n, 0, 1, cells), blocked(F32, AT, L, 16)};
    Field v[] = {
        field(F32, ICORAY_CORNER, L, m, 0, 1, corners),
        blocked(F32, ICORAY_CORNER, L, 16), field(F32, ICORAY_CORNER, L, m, 0, L, 1),
    };
    Field hills[] = {field(F32, AT, L, n, 0, L, 1), field(F64, AT, L, n, 0, 1, cells), field(F64, AT, L, n, 0, L, 1)};
    for (int i = 0; i < 3; i++) {
        raise_hills(&hills[i]);
    }
    for (int in_background = 0; in_background < 2; in_background++) {
        icoray_ctx *ctx = opened(directory, in_background ? "fields/background" : "fields/in_the_call", in_background);
        int step = 100 * in_background, wants = 0;
        for (int i = 0; i < 3; i++, step += 3) {
            uint64_t both = bytes_of(&f[i]) + bytes_of(&v[i]);
            OK(icoray_field_set(ctx, "v", &v[i].array));
            OK(icoray_heights_set(ctx, &hills[i].array));
            scene_of_two(ctx, "two", "mean");
            OK(icoray_wants_field(ctx, "v", step, 0.0, &wants));
            CHECK(wants == 1);
            copy_expected = in_background ? both : 0;
            frame_of(ctx, step, &f[i]);
            scene_of_two(ctx, "hills", "native");
            copy_expected = in_background ? both + bytes_of(&hills[i]) : 0;
            frame(ctx, step + 1);
            /* Written over as soon as the call has returned, where copies are drawn. */
            OK(icoray_execute(ctx, step + 2, 0.0, NULL));
            if (in_background) {
                scribble(&v[i], 0.5);
                scribble(&hills[i], 0.0);
            }
            OK(icoray_wait(ctx));
            memcpy(v[i].memory, v[i].before, v[i].bytes);
            memcpy(hills[i].memory, hills[i].before, hills[i].bytes);
        }
        copy_expected = 0;
        OK(icoray_close(&ctx));
    }
    at_corners(directory, &f[0], &v[0]);
    refused_fields(directory, &f[0], &v[0]);
    release_all(f, 3);
    release_all(v, 3);
    release_all(hills, 3);
}
