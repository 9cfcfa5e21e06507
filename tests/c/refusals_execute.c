/* Frames that are refused: too early, without a date, or without a place to go. */
#include "refusals.h"

void order(void)
{
    icoray_ctx *ctx = opened();
    icoray_frame_report report;
    char message[64] = "not empty";
    memset(&report, 0, sizeof report);
    report.struct_size = sizeof report;

    OK(icoray_last_error(ctx, message, sizeof message));
    CHECK(message[0] == '\0'); /* nothing has failed yet */
    REFUSED(ctx, ICORAY_ERR_ORDER, "no frame", icoray_report(ctx, &report));
    REFUSED(ctx, ICORAY_ERR_ORDER, "icoray_grid_set", icoray_execute(ctx, 0, 0.0, NULL));
    OK(icoray_grid_set(ctx, &good_grid));
    REFUSED(ctx, ICORAY_ERR_ORDER, "icoray_layers_set", icoray_execute(ctx, 0, 0.0, NULL));
    OK(icoray_layers_set(ctx, &good_layers));
    REFUSED(ctx, ICORAY_ERR_ORDER, "icoray_scene_load", icoray_execute(ctx, 0, 0.0, NULL));
    OK(icoray_scene_text(ctx, good_scene));
    REFUSED(ctx, ICORAY_ERR_FIELD, "icoray_field_set", icoray_execute(ctx, 0, 0.0, NULL));
    REFUSED(ctx, ICORAY_ERR_ORDER, "no frame", icoray_report(ctx, &report));
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
    REFUSED(ctx, ICORAY_ERR_NULL, "toml", icoray_scene_text(ctx, NULL));
    OK(icoray_close(&ctx));
    CHECK(ctx == NULL);
}

void dates(icoray_ctx *ctx)
{
    static const char *const wrong[] = {"", "yesterday", "2026-01-01", "a-b-c_d:e:f", "2026-01-01_00:00:00:00"};
    OK(icoray_scene_text(ctx, SCENE("f", "4", "d_$Y-$M-$D_$h.$m.$s.png")));
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "date is absent", icoray_execute(ctx, 0, 0.0, NULL));
    for (size_t i = 0; i < COUNT(wrong); i++) {
        char words[64];
        snprintf(words, sizeof words, "date \"%s\"", wrong[i]);
        trying = words;
        REFUSED(ctx, ICORAY_ERR_ARGUMENT, words, icoray_execute(ctx, 0, 0.0, wrong[i]));
        trying = "";
    }
    CHECK(!file_exists("d_2026-11-05_06.07.08.png"));
    OK(icoray_execute(ctx, 0, 0.0, "2026-11-05_06:07:08"));
    CHECK(file_exists("d_2026-11-05_06.07.08.png"));
    OK(icoray_execute(ctx, 0, 0.0, "0001-01-05T06:07:08"));
    CHECK(file_exists("d_0001-01-05_06.07.08.png"));
    OK(icoray_scene_text(ctx, good_scene));
    OK(icoray_execute(ctx, 0, 0.0, "yesterday")); /* not needed, so not looked at */
}

/* A second picture, of the errors: it has a name of its own, which is known to be good before the first ray. */
void error_maps(icoray_ctx *ctx)
{
    icoray_frame_report report;
    memset(&report, 0, sizeof report);
    report.struct_size = sizeof report;
    OK(icoray_scene_text(ctx, "tolerance = 0.02\n" SCENE("f", "4", "m_{step}.png") "error = \"m_{step}_error.png\"\n"));
    OK(icoray_execute(ctx, 5, 0.0, NULL));
    CHECK(file_exists("m_5.png") && file_exists("m_5_error.png"));
    OK(icoray_report(ctx, &report));
    CHECK(report.tolerance == 0.02 && report.error_max >= 0.0);
    OK(icoray_scene_text(ctx, SCENE("f", "4", "m_{step}.png") "error = \"m_6.png\"\n"));
    REFUSED(ctx, ICORAY_ERR_SCENE, "\"m_6.png\": output.file and output.error", icoray_execute(ctx, 6, 0.0, NULL));
    CHECK(!file_exists("m_6.png"));
    OK(icoray_scene_text(ctx, SCENE("f", "4", "m_{step}.png") "error = \"m_$Y.png\"\n"));
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "date is absent", icoray_execute(ctx, 7, 0.0, NULL));
    CHECK(!file_exists("m_7.png"));
    OK(icoray_scene_text(ctx, good_scene));
}

/* An output directory that cannot be made: a file is in its place. */
void blocked(void)
{
    char path[1024], words[1100];
    icoray_config config = good_config;
    icoray_ctx *ctx = NULL;
    path_of(path, sizeof path, "blocked");
    CHECK(write_file(path, "a file\n"));
    config.output_dir = path;
    OK(icoray_open_serial(&config, &ctx));
    OK(icoray_grid_set(ctx, &good_grid));
    OK(icoray_layers_set(ctx, &good_layers));
    OK(icoray_scene_text(ctx, good_scene));
    OK(icoray_field_set(ctx, "f", &good_array));
    REFUSED(ctx, ICORAY_ERR_IO, path, icoray_execute(ctx, 1, 0.0, NULL));
    REFUSED(ctx, ICORAY_ERR_IO, path, icoray_execute(ctx, 2, 0.0, NULL));
    REFUSED(ctx, ICORAY_ERR_NULL, "icoray_grid", icoray_grid_set(ctx, NULL));
    OK(icoray_grid_set(ctx, &good_grid));
    CHECK(remove(path) == 0);
    still_draws(ctx);
    CHECK(file_exists("blocked/f_1.png"));

    /* The report's place is taken by a directory, of another picture. */
    OK(icoray_scene_text(ctx, SCENE("f", "4", "sub/report.csv/x.png")));
    OK(icoray_execute(ctx, 3, 0.0, NULL));
    OK(icoray_scene_text(ctx, SCENE("f", "4", "sub/y.png")));
    snprintf(words, sizeof words, "%s/sub/report.csv: cannot write the report", path);
    REFUSED(ctx, ICORAY_ERR_IO, words, icoray_execute(ctx, 4, 0.0, NULL));
    OK(icoray_scene_text(ctx, good_scene));
    still_draws(ctx);
    OK(icoray_close(&ctx));
}
