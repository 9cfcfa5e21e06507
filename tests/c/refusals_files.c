/* Existing files, and other obstacles to writing a picture. */
#define _POSIX_C_SOURCE 200809L /* symlink, mkdir */

#include "refusals.h"

#include <sys/stat.h>
#include <unistd.h>

#define THERE "somebody's picture\n"
#define LONG                                                                                                           \
    "xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx"

static int made(const char *name, const char *text)
{
    return write_file(in_output(name), text);
}

static int made_directory(const char *name)
{
    return mkdir(in_output(name), 0777) == 0;
}

/* By default nothing that is there is modified, and that is known before anything is rendered. */
static void never_modified(int is_async)
{
    icoray_ctx *ctx;
    CHECK(made_directory("never") && made("never/f_1.png", THERE) && made("never/m_2.png", THERE));
    CHECK(symlink("nowhere", in_output("never/f_3.png")) == 0);
    ctx = filled_async(is_async);

    OK(icoray_scene_text(ctx, SCENE("f", "4", "never/f_{step}.png")));
    REFUSED(ctx, EXISTS, "never/f_1.png", icoray_execute(ctx, 1, 0.0, NULL));
    REFUSED(ctx, EXISTS, "step 1", icoray_execute(ctx, 1, 0.0, NULL));
    CHECK(file_is("never/f_1.png", THERE) && !file_exists("never/report.csv"));
    REFUSED(ctx, EXISTS, "never/f_3.png", icoray_execute(ctx, 3, 0.0, NULL));
    CHECK(!file_exists("never/nowhere")); /* a link is a file, wherever it leads to */

    /* The map of errors: neither of the two pictures is written where one cannot be. */
    OK(icoray_scene_text(ctx, SCENE("f", "4", "never/f_{step}.png") "error = \"never/m_{step}.png\"\n"));
    REFUSED(ctx, EXISTS, "never/m_2.png", icoray_execute(ctx, 2, 0.0, NULL));
    CHECK(!file_exists("never/f_2.png") && file_is("never/m_2.png", THERE));
    REFUSED(ctx, EXISTS, "never/f_1.png", icoray_execute(ctx, 1, 0.0, NULL));
    CHECK(!file_exists("never/m_1.png") && file_is("never/f_1.png", THERE));

    /* A picture of its own is as much there as somebody else's, also while it waits to be written. */
    OK(icoray_execute(ctx, 4, 0.0, NULL));
    REFUSED(ctx, EXISTS, "never/f_4.png", icoray_execute(ctx, 4, 0.0, NULL));
    OK(icoray_wait(ctx));
    REFUSED(ctx, EXISTS, "never/f_4.png", icoray_execute(ctx, 4, 0.0, NULL));
    CHECK(is_picture("never/f_4.png") && is_picture("never/m_4.png"));
    CHECK(report_of(ctx).frames_written == 1 && report_of(ctx).step == 4);
    OK(icoray_close(&ctx));

    /* The next run finds them; once moved away they are drawn again. */
    ctx = filled_async(is_async);
    OK(icoray_scene_text(ctx, SCENE("f", "4", "never/f_{step}.png")));
    REFUSED(ctx, EXISTS, "never/f_4.png", icoray_execute(ctx, 4, 0.0, NULL));
    CHECK(rename(in_output("never/f_4.png"), in_output("never/old.png")) == 0);
    DRAW(ctx, 4, 0.0, NULL);
    CHECK(is_picture("never/f_4.png"));
    OK(icoray_close(&ctx));
    CHECK(rename(in_output("never"), in_output(is_async ? "never_1" : "never_0")) == 0);
}

void existing(void)
{
    never_modified(0);
    never_modified(1);
}

void overwritten(void)
{
    icoray_config config = good_config;
    icoray_ctx *ctx;
    config.existing = ICORAY_OVERWRITE;
    CHECK(made_directory("over") && made("over/f_1.png", THERE) && made("over/m_1.png", THERE));
    CHECK(made("over/kept", THERE) && symlink("kept", in_output("over/f_2.png")) == 0);
    ctx = filled_with(&config);
    OK(icoray_scene_text(ctx, SCENE("f", "4", "over/f_{step}.png") "error = \"over/m_{step}.png\"\n"));
    OK(icoray_execute(ctx, 1, 0.0, NULL));
    OK(icoray_execute(ctx, 2, 0.0, NULL));
    OK(icoray_execute(ctx, 2, 0.0, NULL));
    DRAW(ctx, 1, 0.0, NULL);
    CHECK(is_picture("over/f_1.png") && is_picture("over/m_1.png") && is_picture("over/f_2.png"));
    CHECK(file_is("over/kept", THERE)); /* a link is replaced and not followed */
    CHECK(report_of(ctx).frames_written == 4 && report_of(ctx).frames_failed == 0);
    OK(icoray_close(&ctx));
}

/* Obstacles for either policy: a directory of the picture's name, and another program's report. */
void in_the_way(void)
{
    static const struct {
        const char *file, *part;
        icoray_status status;
    } cases[] = {
        {"way/f.png", "way/f.png: cannot write the file: a directory has its name", ICORAY_ERR_IO},
        {"way/g.png\"\nerror = \"way/f.png", "way/f.png: cannot write the file", ICORAY_ERR_IO},
        {"way/other/f.png", "way/other/report.csv: its first line", ICORAY_ERR_EXISTS},
        {"way/taken/f.png", "way/taken/report.csv: cannot write the report", ICORAY_ERR_IO},
    };
    /* Known when the scene is loaded: what no step could be drawn to. */
    static const struct {
        const char *file, *part;
    } never[] = {
        {"way/file/f.png", "way/file/f.png: cannot write"},
        {"way/file/{step}/f.png", "way/file/0/f.png: cannot write the file"},
        {"way/f.png\"\nerror = \"way/link/m.png", "way/link/m.png: cannot write to the folder"},
        {"way/" LONG LONG LONG "{step}.png", "too long"},
    };
    static const int32_t policies[] = {ICORAY_NEVER_MODIFY, ICORAY_OVERWRITE};
    CHECK(made_directory("way") && made_directory("way/f.png") && made_directory("way/other"));
    CHECK(made("way/other/report.csv", THERE) && made_directory("way/taken"));
    CHECK(made_directory("way/taken/report.csv") && made("way/file", THERE));
    CHECK(symlink("nowhere", in_output("way/link")) == 0);
    for (size_t p = 0; p < COUNT(policies); p++) {
        icoray_config config = good_config;
        icoray_ctx *ctx;
        config.existing = policies[p];
        ctx = filled_with(&config);
        uint64_t failed = 0; /* beside those that were not drawn because a file is there */
        for (size_t i = 0; i < COUNT(cases); i++) {
            trying = cases[i].part;
            OK(icoray_scene_text(ctx, text_of(SCENE("f", "4", "%s"), cases[i].file)));
            REFUSED_AS(ctx, cases[i].status, cases[i].part, icoray_execute(ctx, 5, 0.0, NULL));
            OK(icoray_wait(ctx)); /* icoray_execute returned it */
            failed += cases[i].status != ICORAY_ERR_EXISTS;
        }
        for (size_t i = 0; i < COUNT(never); i++) {
            trying = never[i].part;
            OK(icoray_scene_text(ctx, good_scene));
            REFUSED(ctx, IO, trying, icoray_scene_text(ctx, text_of(SCENE("f", "4", "%s"), never[i].file)));
        }
        trying = "";
        CHECK(!file_exists("way/g.png") && !file_exists("way/other/f.png") && !file_exists("way/taken/f.png"));
        CHECK(file_is("way/other/report.csv", THERE) && file_is("way/file", THERE));
        OK(icoray_scene_text(ctx, good_scene));
        still_draws(ctx);
        CHECK(report_of(ctx).frames_failed == failed && report_of(ctx).frames_written == 1);
        OK(icoray_close(&ctx));
    }
}

/* An output directory that cannot be made: a file is in its place, when the context is opened or later. */
void blocked(void)
{
    const char *path = in_output("blocked");
    icoray_config config = good_config;
    icoray_ctx *ctx = NULL;
    CHECK(write_file(path, THERE));
    config.output_dir = path;
    REFUSED(NULL, IO, "blocked: cannot make pictures", icoray_open_serial(&config, &ctx));
    CHECK(ctx == NULL && file_is("blocked", THERE) && remove(path) == 0);
    ctx = filled_with(&config);
    CHECK(!file_exists("blocked")); /* nothing is made before the first picture */
    CHECK(write_file(path, THERE));
    REFUSED(ctx, IO, path, icoray_execute(ctx, 1, 0.0, NULL));
    REFUSED(ctx, IO, path, icoray_execute(ctx, 2, 0.0, NULL));
    REFUSED(ctx, NULL, "icoray_grid", icoray_grid_set(ctx, NULL));
    OK(icoray_grid_set(ctx, &good_grid));
    CHECK(file_is("blocked", THERE) && remove(path) == 0);
    DRAW(ctx, 1, 0.0, NULL);
    CHECK(is_picture("blocked/f_1.png") && file_exists("blocked/report.csv"));
    OK(icoray_close(&ctx));
}
