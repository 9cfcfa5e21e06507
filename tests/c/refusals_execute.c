/* Frames that are refused: too early, without a date, or without a place to go. */
#include "refusals.h"

#include <math.h>

void order(void)
{
    icoray_ctx *ctx = opened();
    icoray_frame_report report = {sizeof report};
    char message[64] = "not empty";

    OK(icoray_last_error(ctx, message, sizeof message));
    CHECK(message[0] == '\0'); /* nothing has failed yet */
    REFUSED(ctx, ORDER, "no frame", icoray_report(ctx, &report));
    OK(icoray_wait(ctx)); /* for nothing */
    NOT_DRAWN(ctx, ORDER, "icoray_scene_load");
    OK(icoray_scene_text(ctx, good_scene));
    NOT_DRAWN(ctx, ORDER, "icoray_grid_set");
    OK(icoray_grid_set(ctx, &good_grid));
    NOT_DRAWN(ctx, ORDER, "icoray_layers_set");
    OK(icoray_layers_set(ctx, &good_layers));
    NOT_DRAWN(ctx, FIELD, "icoray_field_set");
    REFUSED(ctx, ORDER, "no frame", icoray_report(ctx, &report));
    OK(icoray_field_set(ctx, "f", &good_array));
    still_draws(ctx);
    OK(icoray_close(&ctx));

    /* Otherwise any order will do: the last three before the first two. */
    ctx = opened();
    OK(icoray_scene_text(ctx, good_scene));
    OK(icoray_field_set(ctx, "f", &good_array));
    OK(icoray_layers_set(ctx, &good_layers));
    OK(icoray_grid_set(ctx, &good_grid));
    still_draws(ctx);
    OK(icoray_close(&ctx));

    /* Closed with a failure as its last call. */
    ctx = opened();
    REFUSED(ctx, NULL, "toml", icoray_scene_text(ctx, NULL));
    OK(icoray_close(&ctx));
    CHECK(ctx == NULL);
}

/* A time that is not finite is no time of a step; neither is the frame counted. */
void times(icoray_ctx *ctx)
{
    static const double wrong[] = {NAN, -NAN, INFINITY, -INFINITY};
    static const double right[] = {0.0, -0.0, -1.5, 1e308, -1e308, 5e-324};
    uint64_t failed = report_of(ctx).frames_failed;
    for (size_t i = 0; i < COUNT(wrong); i++) {
        REFUSED(ctx, ARGUMENT, "time_s", icoray_execute(ctx, 700, wrong[i], NULL));
    }
    CHECK(report_of(ctx).frames_failed == failed && !file_exists("f_700.png"));
    for (size_t i = 0; i < COUNT(right); i++) {
        OK(icoray_execute(ctx, 710 + (int64_t)i, right[i], NULL));
        CHECK(report_of(ctx).time_s == right[i] && report_of(ctx).step == 710 + (int64_t)i);
    }
    OK(icoray_execute(ctx, INT64_MAX, 0.0, NULL));
    DRAW(ctx, INT64_MIN, 0.0, NULL);
    CHECK(is_picture("f_9223372036854775807.png") && is_picture("f_-9223372036854775808.png"));
}

void dates(icoray_ctx *ctx)
{
    static const char *const wrong[] = {
        "0",         "yesterday",  "2026-01-01", "a-b-c_d:e:f", "2026-01-01_00:00:00:00", "2026-01-01_00:00:",
        "-1-1-1_:::", "2026/01/01_00:00:00", "../2026-01-01_00:00:00", "2026-01-01_00:00:0/",
    };
    OK(icoray_scene_text(ctx, SCENE("f", "4", "d_$Y-$M-$D_$h.$m.$s.png")));
    NOT_DRAWN(ctx, ARGUMENT, "date is absent");
    REFUSED(ctx, ARGUMENT, "date is absent", icoray_execute(ctx, 0, 0.0, ""));
    REFUSED(ctx, ARGUMENT, "date is absent", icoray_execute(ctx, 0, 0.0, "  "));
    for (size_t i = 0; i < COUNT(wrong); i++) {
        trying = text_of("date \"%s\"", wrong[i]);
        REFUSED(ctx, ARGUMENT, trying, icoray_execute(ctx, 0, 0.0, wrong[i]));
        trying = "";
    }
    REFUSED(ctx, ARGUMENT, "iso_datetime", icoray_execute(ctx, 0, 0.0, NO_UTF8));
    CHECK(!file_exists("d_2026-11-05_06.07.08.png"));
    OK(icoray_execute(ctx, 0, 0.0, "2026-11-05_06:07:08"));
    OK(icoray_execute(ctx, 0, 0.0, "0001-01-05T06:07:08"));
    DRAW(ctx, 0, 0.0, "10000-01-05 06:07:08Z");
    CHECK(is_picture("d_2026-11-05_06.07.08.png") && is_picture("d_0001-01-05_06.07.08.png"));
    CHECK(is_picture("d_10000-01-05_06.07.08.png"));
    OK(icoray_scene_text(ctx, good_scene));
    REFUSED(ctx, ARGUMENT, "iso_datetime", icoray_execute(ctx, 0, 0.0, NO_UTF8));
    OK(icoray_execute(ctx, 0, 0.0, "yesterday")); /* not needed, so not looked at */
    OK(icoray_wait(ctx));
}

/* Pictures that the scene does not name: those of a run that begins its steps again have another date. */
void restarts(void)
{
    icoray_config config = good_config;
    for (int run = 0; run < 2; run++) {
        config.output_dir = in_output("restarts");
        icoray_ctx *ctx = filled_with(&config);
        OK(icoray_scene_text(ctx, NAMELESS_SCENE("f", "4")));
        OK(icoray_execute(ctx, 3, 0.0, run == 0 ? "2026-11-22_06:00:00" : "2026-11-23T06:00:00"));
        if (run == 0) {
            OK(icoray_execute(ctx, 3, 0.0, "yesterday")); /* no date: the step alone names the picture */
        } else {
            REFUSED(ctx, EXISTS, "f_000003.png", icoray_execute(ctx, 3, 0.0, " "));
            REFUSED(ctx, EXISTS, "f_000003.png", icoray_execute(ctx, 3, 0.0, NULL));
            REFUSED(ctx, EXISTS, "f_2026-11-22_06.00.00_000003.png",
                    icoray_execute(ctx, 3, 0.0, "2026-11-22_06:00:00"));
        }
        OK(icoray_close(&ctx));
    }
    CHECK(is_picture("restarts/f_2026-11-22_06.00.00_000003.png") && is_picture("restarts/f_000003.png"));
    CHECK(is_picture("restarts/f_2026-11-23_06.00.00_000003.png"));
}

/* A second picture, of the errors: it has a name of its own, which is known to be good before the first ray. */
void error_maps(icoray_ctx *ctx)
{
    icoray_frame_report report;
    OK(icoray_scene_text(ctx, "tolerance = 0.02\n" SCENE("f", "4", "m_{step}.png") "error = \"m_{step}_error.png\"\n"));
    DRAW(ctx, 5, 0.0, NULL);
    CHECK(file_exists("m_5.png") && file_exists("m_5_error.png"));
    report = report_of(ctx);
    CHECK(report.tolerance == 0.02 && report.error_max >= 0.0);
    OK(icoray_scene_text(ctx, SCENE("f", "4", "m_{step}.png") "error = \"m_6.png\"\n"));
    REFUSED(ctx, SCENE, "\"m_6.png\": output.file and output.error", icoray_execute(ctx, 6, 0.0, NULL));
    CHECK(!file_exists("m_6.png"));
    OK(icoray_scene_text(ctx, SCENE("f", "4", "m_{step}.png") "error = \"m_$Y.png\"\n"));
    REFUSED(ctx, ARGUMENT, "date is absent", icoray_execute(ctx, 7, 0.0, NULL));
    CHECK(!file_exists("m_7.png"));
    OK(icoray_scene_text(ctx, good_scene));
}
