/* Frames that a thread draws from a copy of the field while the model continues. */
#include "pictures.h"

static icoray_ctx *opened(const char *directory, const char *name, int with_threads)
{
    icoray_config config = {.threads = with_threads, .async_render = 1};
    return context_with(directory, name, config);
}

/* Executes, and has the model write over the field as soon as that has returned. */
static void overtaken(icoray_ctx *ctx, int step, const char *group, const char *light, Field *f)
{
    memcpy(f->memory, f->before, f->bytes);
    scene(ctx, group, light);
    OK(icoray_field_set(ctx, "f", &f->array));
    OK(icoray_execute(ctx, step, 60.0 * step, NULL));
    scribble(f, 0.25);
    OK(icoray_wait(ctx));
    icoray_frame_report report = report_of(ctx);
    CHECK(report.step == step && report.bytes_copied == bytes_of(f) && report.copy_s > 0.0);
    CHECK(report.value_min < -0.5 && report.value_max > 0.5); /* as they were */
    memcpy(f->memory, f->before, f->bytes);
}

void background(const char *directory)
{
    enum { F32 = ICORAY_F32, F64 = ICORAY_F64, AT = ICORAY_CENTER, L = LAYERS };
    size_t n = (size_t)cells * L, m = (size_t)corners * L;
    Field fields[] = {
        field(F32, AT, L, n, 0, L, 1),
        field(F64, AT, L, n, 0, L, 1),
        field(F32, AT, L, n, 0, 1, cells),
        field(F32, AT, L, n + L + 1, 0, L, 1),
        field(F64, AT, L, (size_t)cells * (L + 3), 2, L + 3, 1),
        field(F32, AT, L, n, n - 1, -L, -1),
        field(F64, AT, L, n, (size_t)cells * (L - 1), 1, -cells),
        blocked(F32, AT, L, 16), blocked(F64, AT, L, 16), blocked(F32, AT, L, cells + 5),
    };
    int count = (int)COUNT(fields), step = 0;
    Field corner = field(F32, ICORAY_CORNER, L, m, 0, 1, corners);
    Field corner_blocks = blocked(F32, ICORAY_CORNER, L, 16);
    Field midway = field(F32, AT, L - 1, (size_t)cells * (L - 1), 0, L - 1, 1);

    /* In every layout, and from one to the other. */
    icoray_ctx *ctx = opened(directory, "background", 2);
    for (int i = 0; i < count; i++, step++) {
        overtaken(ctx, step, "plain", "none", &fields[i]);
        overtaken(ctx, step, "lit", "headlight", &fields[i]);
    }
    overtaken(ctx, step++, "corner", "none", &corner);
    overtaken(ctx, step++, "corner", "none", &corner_blocks);
    overtaken(ctx, step++, "litcorner", "headlight", &corner);
    overtaken(ctx, step++, "midway", "none", &midway);

    /* With the scene and the grid changed as soon as the call has returned, too. */
    scene(ctx, "plain", "none");
    OK(icoray_field_set(ctx, "f", &fields[0].array));
    OK(icoray_execute(ctx, step++, 0.0, NULL));
    scene(ctx, "corner", "none");
    OK(icoray_field_set(ctx, "f", &corner.array));
    OK(icoray_execute(ctx, step++, 0.0, NULL));
    OK(icoray_grid_set(ctx, &grid));
    OK(icoray_execute(ctx, step++, 0.0, NULL));
    OK(icoray_close(&ctx)); /* finishes what was begun */

    /* One frame after the other without a wait, with time levels that are swapped meanwhile. */
    ctx = opened(directory, "background/run", 2);
    for (int i = 0; i < 12; i++) {
        Field *now = &fields[i % count];
        memcpy(now->memory, now->before, now->bytes);
        scene(ctx, "plain", "none");
        OK(icoray_field_set(ctx, "f", &now->array));
        OK(icoray_execute(ctx, i, 0.0, NULL));
        scribble(now, -0.75);
    }
    OK(icoray_wait(ctx));
    icoray_frame_report report = report_of(ctx);
    CHECK(report.frames_written == 12 && report.frames_failed == 0 && report.step == 11);
    CHECK(report.bytes_copied == bytes_of(&fields[11 % count]));
    OK(icoray_close(&ctx));
    for (int i = 0; i < count; i++) {
        memcpy(fields[i].memory, fields[i].before, fields[i].bytes);
    }

    /* As without: frame() looks at the whole report. */
    ctx = opened(directory, "background/report", 1);
    copy_expected = bytes_of(&fields[0]);
    picture(ctx, "plain", "none", 0, &fields[0]);
    copy_expected = bytes_of(&fields[1]);
    CHECK(picture(ctx, "lit", "headlight", 1, &fields[1]).bytes_derived == n * 8 + (uint64_t)cells);
    copy_expected = 0;
    OK(icoray_close(&ctx));

    release_all(fields, count);
    release(&corner);
    release(&corner_blocks);
    release(&midway);
}
