/* Frames that fail when they are written, after the call that drew them has returned; and frames that are dropped. */
#define _POSIX_C_SOURCE 200809L /* symlink, nanosleep */

#include "refusals.h"

#include <time.h>
#include <unistd.h>

#define LATE SCENE("f", "4", "late/pictures/f_{step}.png")

/*
 * A directory that looks as if it could be made until it is: its parent is a link to nothing. Removing the link heals it.
 */
static void broken(int is_broken)
{
    char path[1024];
    path_of(path, sizeof path, "late");
    if (is_broken) {
        CHECK(symlink("nowhere/at/all", path) == 0);
    } else {
        CHECK(unlink(path) == 0);
    }
}

/* Loads a scene into that directory, which is looked at then and must not be broken yet. */
static void load_late(icoray_ctx *ctx, const char *text)
{
    broken(0);
    OK(icoray_scene_text(ctx, text));
    broken(1);
}

/* Waits, without a call that tells, until that many frames have failed. */
static void fails(icoray_ctx *ctx, uint64_t count)
{
    struct timespec wait = {0, 2000000};
    for (int i = 0; i < 5000 && report_of(ctx).frames_failed < count; i++) {
        nanosleep(&wait, NULL);
    }
    CHECK(report_of(ctx).frames_failed == count);
}

static void told_by_each_call(int is_async)
{
    icoray_config config = good_config;
    icoray_frame_report report;
    icoray_ctx *ctx;
    char name[64];
    int64_t first = is_async ? 100 : 1;
    config.async_render = is_async;
    ctx = filled_with(&config);
    broken(1);

    /* By icoray_wait, once. */
    load_late(ctx, LATE);
    OK(icoray_execute(ctx, first, 0.0, NULL));
    snprintf(name, sizeof name, "step %d: ", (int)first);
    REFUSED(ctx, ICORAY_ERR_IO, name, icoray_wait(ctx));
    OK(icoray_wait(ctx));
    report = report_of(ctx);
    CHECK(report.frames_failed == 1 && report.frames_written == 0 && report.step == first);

    /* By the next icoray_execute, which has drawn its own frame all the same. */
    OK(icoray_execute(ctx, first + 1, 0.0, NULL));
    fails(ctx, 2);
    OK(icoray_scene_text(ctx, SCENE("f", "4", "after_{step}.png")));
    snprintf(name, sizeof name, "step %d: ", (int)first + 1);
    REFUSED(ctx, ICORAY_ERR_IO, name, icoray_execute(ctx, first + 2, 0.0, NULL));
    OK(icoray_wait(ctx));
    snprintf(name, sizeof name, "after_%d.png", (int)first + 2);
    CHECK(is_picture(name));
    report = report_of(ctx);
    CHECK(report.frames_failed == 2 && report.frames_written == 1 && report.step == first + 2);

    /* By an icoray_execute that draws nothing. */
    load_late(ctx, LATE);
    OK(icoray_execute(ctx, first + 3, 0.0, NULL));
    fails(ctx, 3);
    load_late(ctx, "every = 7\n" LATE);
    REFUSED(ctx, ICORAY_ERR_IO, "late/pictures", icoray_execute(ctx, 8, 0.0, NULL));
    OK(icoray_execute(ctx, 9, 0.0, NULL));
    OK(icoray_execute(ctx, 14 + 7 * first, 0.0, NULL));
    fails(ctx, 4);
    OK(icoray_scene_text(ctx, "# nothing\n"));
    REFUSED(ctx, ICORAY_ERR_IO, "late/pictures", icoray_execute(ctx, 10, 0.0, NULL));
    OK(icoray_execute(ctx, 11, 0.0, NULL));

    /* Not in place of what the call itself has to say, but after it. */
    load_late(ctx, LATE);
    OK(icoray_execute(ctx, first + 4, 0.0, NULL));
    fails(ctx, 5);
    OK(icoray_scene_text(ctx, SCENE("q", "4", "q.png")));
    REFUSED(ctx, ICORAY_ERR_FIELD, "\"q\"", icoray_execute(ctx, 12, 0.0, NULL));
    snprintf(name, sizeof name, "step %d: ", (int)first + 4);
    REFUSED(ctx, ICORAY_ERR_IO, name, icoray_wait(ctx));

    /* Of several, the first. */
    load_late(ctx, LATE);
    OK(icoray_execute(ctx, first + 5, 0.0, NULL));
    icoray_execute(ctx, first + 6, 0.0, NULL); /* may tell of the one before, or not yet */
    icoray_wait(ctx);
    OK(icoray_wait(ctx));
    CHECK(report_of(ctx).frames_failed == 8);

    /* Healed. */
    broken(0);
    OK(icoray_execute(ctx, first + 5, 0.0, NULL));
    OK(icoray_wait(ctx));
    snprintf(name, sizeof name, "late/pictures/f_%d.png", (int)first + 5);
    CHECK(is_picture(name) && report_of(ctx).frames_written == 2);
    OK(icoray_close(&ctx));
}

/* By icoray_close, which closes all the same. */
static void told_by_close(int is_async)
{
    icoray_config config = good_config;
    icoray_ctx *ctx;
    char path[1024];
    config.async_render = is_async;
    ctx = filled_with(&config);
    path_of(path, sizeof path, "closed");
    OK(icoray_scene_text(ctx, SCENE("f", "4", "closed/pictures/{step}.png")));
    CHECK(symlink("nowhere/at/all", path) == 0);
    OK(icoray_execute(ctx, 77, 0.0, NULL));
    REFUSED(NULL, ICORAY_ERR_IO, "step 77: ", icoray_close(&ctx));
    CHECK(ctx == NULL);
    OK(icoray_close(&ctx));
    ctx = filled_with(&config);
    CHECK(unlink(path) == 0);
    OK(icoray_scene_text(ctx, SCENE("f", "4", "closed/pictures/{step}.png")));
    CHECK(symlink("nowhere/at/all", path) == 0);
    OK(icoray_execute(ctx, 78, 0.0, NULL));
    REFUSED(ctx, ICORAY_ERR_IO, "step 78: ", icoray_wait(ctx));
    OK(icoray_close(&ctx)); /* it was told */
    CHECK(unlink(path) == 0);
}

void told_once(void)
{
    char path[1024], moved[1024];
    for (int is_async = 0; is_async < 2; is_async++) {
        told_by_each_call(is_async);
        told_by_close(is_async);
        path_of(path, sizeof path, "late");
        path_of(moved, sizeof moved, is_async ? "late_1" : "late_0");
        CHECK(rename(path, moved) == 0);
    }
}

/* Lines of the log that tell of a dropped frame. */
static void counts_drops(void *user, int32_t level, const char *message)
{
    *(uint64_t *)user += level == ICORAY_LOG_WARN && strstr(message, "dropped") != NULL;
}

/*
 * Every frame is written or dropped, whatever the queue; by default none is dropped. The planet is far away, so that
 * drawing takes less time than writing.
 */
void dropped(void)
{
    static const int32_t queues[] = {0, 1, 3};
    static const char far_scene[] =
        "field = \"f\"\nbackend = \"cpu\"\n[image]\nwidth = 256\nheight = 256\n"
        "[camera]\nlon = 10\nlat = 40\ndistance = 400\n"
        "[transfer]\nmap = \"viridis\"\nrange = [0, 2]\nopacity = [[0, 0.1], [2, 0.9]]\n";
    enum { FRAMES = 12 };
    for (int k = 0; k < 8; k++) {
        icoray_config config = good_config;
        icoray_ctx *ctx;
        icoray_frame_report report;
        uint64_t there = 0, lines = 0;
        char text[1024], name[64];
        config.writer_queue = queues[k % 3];
        config.when_full = k % 2 == 0 ? ICORAY_BLOCK : ICORAY_DROP_OLDEST;
        config.async_render = k >= 4;
        config.log = counts_drops;
        config.log_user = &lines;
        config.log_level = ICORAY_LOG_WARN;
        ctx = filled_with(&config);
        snprintf(text, sizeof text, "%s[output]\nfile = \"queue_%d/{step}.png\"\n", far_scene, k);
        OK(icoray_scene_text(ctx, text));
        for (int step = 0; step < FRAMES; step++) {
            OK(icoray_execute(ctx, step, 0.0, NULL));
        }
        OK(icoray_wait(ctx));
        report = report_of(ctx);
        for (int step = 0; step < FRAMES; step++) {
            snprintf(name, sizeof name, "queue_%d/%d.png", k, step);
            there += (uint64_t)is_picture(name);
        }
        trying = text;
        CHECK(report.step == FRAMES - 1 && report.frames_failed == 0);
        CHECK(report.frames_written == there && report.frames_written + report.frames_dropped == FRAMES);
        CHECK(report.frames_dropped == lines);
        CHECK(config.when_full == ICORAY_DROP_OLDEST || report.frames_dropped == 0);
        snprintf(name, sizeof name, "queue_%d/%d.png", k, FRAMES - 1);
        CHECK(is_picture(name)); /* the latest is never the oldest */
        CHECK(report.host_total_s >= report.host_s && report.write_total_s >= report.write_s);
        OK(icoray_close(&ctx));
        trying = "";
    }
}
