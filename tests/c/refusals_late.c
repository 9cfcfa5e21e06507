/* Frames that fail when they are written, after the call that drew them has returned; and frames that are dropped. */
#define _POSIX_C_SOURCE 200809L /* symlink */

#include "refusals.h"

#include <unistd.h>

#define LATE SCENE("f", "4", "late/pictures/f_{step}.png")

/*
 * A directory that passes the check but cannot be made: its parent is a link to nothing. Removing the link repairs it.
 */
static void broken(int is_broken)
{
    CHECK((is_broken ? symlink("nowhere/at/all", in_output("late")) : unlink(in_output("late"))) == 0);
}

/* Loads a scene into that directory, which is looked at then and must not be broken yet. */
static void load_late(icoray_ctx *ctx, const char *text)
{
    broken(0);
    OK(icoray_scene_text(ctx, text));
    broken(1);
}

/* Waits, without a call that returns a failure, until that many frames have failed. */
static void fails(icoray_ctx *ctx, uint64_t count)
{
    for (int i = 0; i < 1000 * PATIENCE_S && report_of(ctx).frames_failed < count; i++) {
        rest_ms(2);
    }
    CHECK(report_of(ctx).frames_failed == count);
}

static void returned_by_each_call(int is_async)
{
    icoray_frame_report report;
    icoray_ctx *ctx = filled_async(is_async);
    int64_t first = is_async ? 100 : 1;
    broken(1);

    /* By icoray_wait, once. */
    load_late(ctx, LATE);
    OK(icoray_execute(ctx, first, 0.0, NULL));
    REFUSED(ctx, IO, text_of("step %d: ", (int)first), icoray_wait(ctx));
    OK(icoray_wait(ctx));
    report = report_of(ctx);
    CHECK(report.frames_failed == 1 && report.frames_written == 0 && report.step == first);

    /* By the next icoray_execute, which has drawn its own frame all the same. */
    OK(icoray_execute(ctx, first + 1, 0.0, NULL));
    fails(ctx, 2);
    OK(icoray_scene_text(ctx, SCENE("f", "4", "after_{step}.png")));
    REFUSED(ctx, IO, text_of("step %d: ", (int)first + 1), icoray_execute(ctx, first + 2, 0.0, NULL));
    OK(icoray_wait(ctx));
    CHECK(is_picture(text_of("after_%d.png", (int)first + 2)));
    report = report_of(ctx);
    CHECK(report.frames_failed == 2 && report.frames_written == 1 && report.step == first + 2);

    /* By an icoray_execute that draws nothing. */
    load_late(ctx, LATE);
    OK(icoray_execute(ctx, first + 3, 0.0, NULL));
    fails(ctx, 3);
    load_late(ctx, "every = 7\n" LATE);
    REFUSED(ctx, IO, "late/pictures", icoray_execute(ctx, 8, 0.0, NULL));
    OK(icoray_execute(ctx, 9, 0.0, NULL));
    OK(icoray_execute(ctx, 14 + 7 * first, 0.0, NULL));
    fails(ctx, 4);
    OK(icoray_scene_text(ctx, "# nothing\n"));
    REFUSED(ctx, IO, "late/pictures", icoray_execute(ctx, 10, 0.0, NULL));
    OK(icoray_execute(ctx, 11, 0.0, NULL));

    /* Not in place of what the call itself has to say, but after it. */
    load_late(ctx, LATE);
    OK(icoray_execute(ctx, first + 4, 0.0, NULL));
    fails(ctx, 5);
    OK(icoray_scene_text(ctx, SCENE("q", "4", "q.png")));
    REFUSED(ctx, FIELD, "\"q\"", icoray_execute(ctx, 12, 0.0, NULL));
    REFUSED(ctx, IO, text_of("step %d: ", (int)first + 4), icoray_wait(ctx));

    /* Of several, the first. */
    load_late(ctx, LATE);
    OK(icoray_execute(ctx, first + 5, 0.0, NULL));
    icoray_execute(ctx, first + 6, 0.0, NULL); /* may return the failure of the one before */
    icoray_wait(ctx);
    OK(icoray_wait(ctx));
    CHECK(report_of(ctx).frames_failed == 8);

    /* Healed. */
    broken(0);
    DRAW(ctx, first + 5, 0.0, NULL);
    CHECK(is_picture(text_of("late/pictures/f_%d.png", (int)first + 5)) && report_of(ctx).frames_written == 2);
    OK(icoray_close(&ctx));
}

/* By icoray_close, which closes all the same. */
static void returned_by_close(int is_async)
{
    for (int by_wait = 0; by_wait < 2; by_wait++) {
        icoray_ctx *ctx = filled_async(is_async);
        OK(icoray_scene_text(ctx, SCENE("f", "4", "closed/pictures/{step}.png")));
        CHECK(symlink("nowhere/at/all", in_output("closed")) == 0);
        OK(icoray_execute(ctx, 77 + by_wait, 0.0, NULL));
        if (by_wait) {
            REFUSED(ctx, IO, "step 78: ", icoray_wait(ctx));
            OK(icoray_close(&ctx)); /* icoray_wait returned it */
        } else {
            REFUSED(NULL, IO, "step 77: ", icoray_close(&ctx));
        }
        CHECK(ctx == NULL);
        OK(icoray_close(&ctx));
        CHECK(unlink(in_output("closed")) == 0);
    }
}

void returned_once(void)
{
    for (int is_async = 0; is_async < 2; is_async++) {
        returned_by_each_call(is_async);
        returned_by_close(is_async);
        CHECK(rename(in_output("late"), in_output(is_async ? "late_1" : "late_0")) == 0);
    }
}

/* Lines of the log about a dropped frame. */
static void counts_drops(void *user, int32_t level, const char *message)
{
    *(uint64_t *)user += level == ICORAY_LOG_WARN && strstr(message, "dropped") != NULL;
}

/*
 * Every frame is written or dropped, for any queue; by default none is dropped. The planet is far away, so that
 * drawing takes less time than writing.
 */
void dropped(void)
{
    static const int32_t queues[] = {0, 1, 3};
    static const char far_scene[] =
        "field = \"f\"\nbackend = \"cpu\"\n[image]\nwidth = 64\nheight = 64\n"
        "[camera]\nlon = 10\nlat = 40\ndistance = 400\n"
        "[transfer]\nmap = \"viridis\"\nrange = [0, 2]\nopacity = [[0, 0.1], [2, 0.9]]\n";
    enum { FRAMES = 12 };
    for (int k = 0; k < 8; k++) {
        icoray_config config = good_config;
        icoray_ctx *ctx;
        icoray_frame_report report;
        uint64_t there = 0, lines = 0;
        config.writer_queue = queues[k % 3];
        config.when_full = k % 2 == 0 ? ICORAY_BLOCK : ICORAY_DROP_OLDEST;
        config.async_render = k >= 4;
        ctx = filled_logging(config, counts_drops, &lines, ICORAY_LOG_WARN);
        OK(icoray_scene_text(ctx, text_of("%s[output]\nfile = \"queue_%d/{step}.png\"\n", far_scene, k)));
        for (int step = 0; step < FRAMES; step++) {
            OK(icoray_execute(ctx, step, 0.0, NULL));
        }
        OK(icoray_wait(ctx));
        report = report_of(ctx);
        for (int step = 0; step < FRAMES; step++) {
            there += (uint64_t)is_picture(text_of("queue_%d/%d.png", k, step));
        }
        trying = text_of("queue_%d", k);
        CHECK(report.step == FRAMES - 1 && report.frames_failed == 0);
        CHECK(report.frames_written == there && report.frames_written + report.frames_dropped == FRAMES);
        CHECK(report.frames_dropped == lines);
        CHECK(config.when_full == ICORAY_DROP_OLDEST || report.frames_dropped == 0);
        CHECK(is_picture(text_of("queue_%d/%d.png", k, FRAMES - 1))); /* the latest is never the oldest */
        CHECK(report.host_total_s >= report.host_s && report.write_total_s >= report.write_s);
        OK(icoray_close(&ctx));
        trying = "";
    }
}
