/* Wrong calls of icoray_wants, and steps that are not due. */
#include "refusals.h"

#include <math.h>

/* Steps that are due, by icoray_wants, by icoray_wants_field and in icoray_execute. */
static void due(icoray_ctx *ctx)
{
    static const struct {
        const char *every;
        int64_t step;
        int32_t is_due;
    } cases[] = {
        {"", 0, 1},
        {"", -3, 1},
        {"every = 1\n", 17, 1},
        {"every = 5\n", 0, 1},
        {"every = 5\n", 5, 1},
        {"every = 5\n", -5, 1},
        {"every = 5\n", 4, 0},
        {"every = 5\n", -4, 0},
        {"every = 5\n", 6, 0},
        {"every = 2\n", INT64_MAX, 0},
        {"every = 2\n", INT64_MIN, 1},
        {"every = 1000000000\n", 999999999, 0},
        {"every = 1000000000\n", 3000000000, 1},
    };
    for (size_t i = 0; i < COUNT(cases); i++) {
        int32_t any = 7, f = 7, g = 7;
        uint64_t drawn = report_of(ctx).frames_written;
        trying = text_of("%s" SCENE("f", "4", "due/%d.png"), cases[i].every, (int)i);
        OK(icoray_scene_text(ctx, trying));
        OK(icoray_wants(ctx, cases[i].step, 0.0, &any));
        OK(icoray_wants_field(ctx, "f", cases[i].step, 0.0, &f));
        OK(icoray_wants_field(ctx, "g", cases[i].step, 0.0, &g));
        CHECK(any == cases[i].is_due && f == cases[i].is_due && g == 0);
        DRAW(ctx, cases[i].step, 0.0, NULL);
        CHECK(is_picture(text_of("due/%d.png", (int)i)) == cases[i].is_due);
        CHECK(report_of(ctx).frames_written == drawn + (uint64_t)cases[i].is_due);
    }
    trying = "";
}

void wants(icoray_ctx *ctx)
{
    static const double times[] = {NAN, INFINITY, -INFINITY};
    static const char *const odd[] = {"0", "-1", "1.5", "4294967296"};
    icoray_ctx *early = opened();
    int32_t answer;
    due(ctx);
    OK(icoray_scene_text(ctx, good_scene));

    /* *wants is 0 after a failure. */
#define WRONG(context, status, part, call)          \
    do {                                            \
        answer = 7;                                 \
        REFUSED_AS(context, status, part, call);       \
        CHECK(answer == 0);                         \
    } while (0)
    WRONG(NULL, ICORAY_ERR_NULL, "ctx", icoray_wants(NULL, 0, 0.0, &answer));
    WRONG(NULL, ICORAY_ERR_NULL, "ctx", icoray_wants_field(NULL, "f", 0, 0.0, &answer));
    WRONG(ctx, ICORAY_ERR_NULL, "name", icoray_wants_field(ctx, NULL, 0, 0.0, &answer));
    WRONG(ctx, ICORAY_ERR_ARGUMENT, "name", icoray_wants_field(ctx, NO_UTF8, 0, 0.0, &answer));
#undef WRONG
    /* Without a time the step alone decides, so that icoray_execute has the failure too. */
    for (size_t i = 0; i < COUNT(times); i++) {
        OK(icoray_scene_text(ctx, "every = 5\nat_times = [0, 100]\n" SCENE("f", "4", "x.png")));
        for (int32_t step = 4; step < 6; step++) {
            answer = 7;
            REFUSED(ctx, ARGUMENT, "time_s", icoray_wants(ctx, step, times[i], &answer));
            CHECK(answer == (step == 5));
            REFUSED(ctx, ARGUMENT, "time_s", icoray_wants_field(ctx, "f", step, times[i], &answer));
            CHECK(answer == (step == 5));
        }
    }
    OK(icoray_scene_text(ctx, good_scene));
    REFUSED(ctx, NULL, "wants", icoray_wants(ctx, 0, 0.0, NULL));
    REFUSED(ctx, NULL, "wants", icoray_wants_field(ctx, "f", 0, 0.0, NULL));

    /* Asking is fine before there is anything: nothing would be drawn. */
    answer = 7;
    OK(icoray_wants(early, 0, 0.0, &answer));
    CHECK(answer == 0);
    answer = 7;
    OK(icoray_wants_field(early, "f", 0, 0.0, &answer));
    CHECK(answer == 0);
    OK(icoray_close(&early));

    /* What every may be. */
    for (size_t i = 0; i < COUNT(odd); i++) {
        REFUSED(ctx, SCENE, "every", icoray_scene_text(ctx, text_of("every = %s\n" SCENE("f", "4", "x.png"), odd[i])));
    }
}
