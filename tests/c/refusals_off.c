/* A context that switches itself off after failed frames in a row. */
#define _POSIX_C_SOURCE 200809L /* symlink */

#include "refusals.h"

#include <unistd.h>

#define BAD SCENE("q", "4", "q_{step}.png") /* of a field that is not there */

static icoray_ctx *limited(int32_t on_error, int32_t after)
{
    icoray_config config = good_config;
    config.on_error = on_error;
    config.disable_after = after;
    return filled_with(&config);
}

/* That many frames fail, and the context is still on. */
static void failing(icoray_ctx *ctx, int count)
{
    OK(icoray_scene_text(ctx, BAD));
    for (int i = 0; i < count; i++) {
        REFUSED(ctx, FIELD, "\"q\"", icoray_execute(ctx, i, 0.0, NULL));
    }
}

/* Number of failed frames, 0 where there is no report. */
static uint64_t frames_failed(icoray_ctx *ctx)
{
    icoray_frame_report report = {sizeof report};
    return icoray_report(ctx, &report) == ICORAY_OK ? report.frames_failed : 0;
}

/* Off, and with all other calls as before. */
static void is_off(icoray_ctx *ctx, int after)
{
    const char *words = text_of("off after %d failures in a row", after);
    int32_t wants = 7, wants_field = 7;
    uint64_t failed;
    OK(icoray_scene_text(ctx, good_scene));
    REFUSED(ctx, DISABLED, words, icoray_execute(ctx, 600, 0.0, NULL));
    failed = frames_failed(ctx);
    REFUSED(ctx, DISABLED, "the last was: step", icoray_execute(ctx, 601, 0.0, NULL));
    CHECK(frames_failed(ctx) == failed);
    OK(icoray_wants(ctx, 600, 0.0, &wants));
    OK(icoray_wants_field(ctx, "f", 600, 0.0, &wants_field));
    CHECK(wants == 0 && wants_field == 0);
    OK(icoray_grid_set(ctx, &good_grid));
    OK(icoray_layers_set(ctx, &good_layers));
    OK(icoray_field_set(ctx, "f", &good_array));
    REFUSED(ctx, NULL, "icoray_grid", icoray_grid_set(ctx, NULL));
    REFUSED(ctx, SCENE, "line 1", icoray_scene_text(ctx, "nonsense"));
    REFUSED(ctx, ARGUMENT, "iso_datetime", icoray_execute(ctx, 602, 0.0, NO_UTF8));
    OK(icoray_scene_text(ctx, "every = 7\n" SCENE("f", "4", "off.png")));
    REFUSED(ctx, DISABLED, words, icoray_execute(ctx, 6, 0.0, NULL));
    OK(icoray_scene_text(ctx, "# nothing\n"));
    REFUSED(ctx, DISABLED, words, icoray_execute(ctx, 603, 0.0, NULL));
    OK(icoray_wait(ctx));
    CHECK(!file_exists("f_600.png") && !file_exists("off.png"));
}

/* In a row: a picture that is written in between begins a new one, one that is there already does not count. */
static void in_a_row(int32_t limit)
{
    int after = limit == 0 ? 3 : (int)limit;
    icoray_ctx *ctx = limited(ICORAY_DISABLE, limit);
    for (int round = 0; round < 3; round++) {
        failing(ctx, after - 1);
        OK(icoray_scene_text(ctx, good_scene));
        still_draws(ctx);
    }
    OK(icoray_scene_text(ctx, SCENE("f", "4", "off_there.png")));
    for (int i = 0; i < after + 2; i++) {
        REFUSED(ctx, EXISTS, "off_there.png", icoray_execute(ctx, i, 0.0, NULL));
    }
    failing(ctx, after - 1);
    OK(icoray_scene_text(ctx, SCENE("f", "4", "off_there.png")));
    NOT_DRAWN(ctx, EXISTS, "off_there.png");
    failing(ctx, 1);
    CHECK(report_of(ctx).frames_written == 3);
    CHECK(report_of(ctx).frames_failed == (uint64_t)(3 * (after - 1) + after - 1 + 1));
    is_off(ctx, after);
    OK(icoray_close(&ctx));
}

/* Frames that fail when they are written count as well, and are reported. */
static void late(int is_async)
{
    icoray_config config = good_config;
    icoray_ctx *ctx;
    config.on_error = ICORAY_DISABLE;
    config.disable_after = 2;
    config.async_render = is_async;
    ctx = filled_with(&config);
    OK(icoray_scene_text(ctx, SCENE("f", "4", "off_late/pictures/{step}.png")));
    CHECK(symlink("nowhere/at/all", in_output("off_late")) == 0);
    OK(icoray_execute(ctx, 1, 0.0, NULL));
    REFUSED(ctx, IO, "step 1: ", icoray_wait(ctx));
    OK(icoray_execute(ctx, 2, 0.0, NULL));
    REFUSED(ctx, IO, "step 2: ", icoray_wait(ctx));
    is_off(ctx, 2);
    CHECK(report_of(ctx).frames_failed == 2);
    CHECK(unlink(in_output("off_late")) == 0);
    OK(icoray_close(&ctx));
}

void switched_off(void)
{
    static const int32_t limits[] = {0, 1, 2, 5};
    static const int32_t never[] = {ICORAY_WARN, ICORAY_IGNORE};
    icoray_ctx *ctx = filled();
    OK(icoray_scene_text(ctx, SCENE("f", "4", "off_there.png")));
    OK(icoray_execute(ctx, 0, 0.0, NULL));
    OK(icoray_close(&ctx));
    for (size_t i = 0; i < COUNT(limits); i++) {
        in_a_row(limits[i]);
    }
    late(0);
    late(1);
    /* Calls that are refused for their arguments are no frames. */
    ctx = limited(ICORAY_DISABLE, 1);
    for (int i = 0; i < 3; i++) {
        REFUSED(ctx, ARGUMENT, "iso_datetime", icoray_execute(ctx, i, 0.0, NO_UTF8));
        REFUSED(ctx, NULL, "icoray_array", icoray_field_set(ctx, "f", NULL));
        REFUSED(ctx, SCENE, "line 1", icoray_scene_text(ctx, "nonsense"));
    }
    still_draws(ctx);
    OK(icoray_close(&ctx));
    for (size_t i = 0; i < COUNT(never); i++) {
        ctx = limited(never[i], 1);
        failing(ctx, 8);
        OK(icoray_scene_text(ctx, good_scene));
        still_draws(ctx);
        OK(icoray_close(&ctx));
    }
}
