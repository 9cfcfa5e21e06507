/* Models that swap time levels or compute a field seldom, and the warnings for those that gave old values. */
#include "refusals.h"

#define STEPS 9

/* The ways in which a model sets the field that has time levels. */
enum { ONCE, ONCE_OF_THREE, AT_EACH_STEP, IN_PLACE, SELDOM, WAYS };

typedef struct {
    int pointed_out, other;
    char last[512];
} Lines;

static void counts(void *user, int32_t level, const char *message)
{
    Lines *lines = (Lines *)user;
    if (strstr(message, "icoray_field_set before each icoray_execute") != NULL ||
        strstr(message, "are those of the picture before") != NULL) {
        lines->pointed_out += level == ICORAY_LOG_WARN;
        snprintf(lines->last, sizeof lines->last, "%s", message);
    } else {
        lines->other++;
    }
}

/* A field of values that differ from step to step. */
static void compute(float *level, int step)
{
    for (int64_t i = 0; i < good_array.columns * LAYERS; i++) {
        level[i] = (float)step + 0.001f * (float)(i % 100);
    }
}

/*
 * Draws "f", which has time levels but where it is computed in place or seldom, and "g": the same at all steps, or another one at
 * each. Returns how often "f" or "g" was pointed out.
 */
static Lines run(int way, int is_static)
{
    size_t bytes = (size_t)good_array.columns * LAYERS * sizeof(float);
    int levels = way == IN_PLACE || way == SELDOM ? 1 : way == ONCE_OF_THREE ? 3 : 2;
    float *level[3], *g = (float *)allocate(1, bytes);
    Lines lines = {0};
    icoray_array array = good_array;
    icoray_ctx *ctx = filled_logging(good_config, counts, &lines, ICORAY_LOG_WARN);
    for (int i = 0; i < levels; i++) {
        level[i] = (float *)allocate(1, bytes);
        compute(level[i], 0);
    }
    compute(g, 0);
    array.data = g;
    OK(icoray_field_set(ctx, "g", &array));
    array.data = level[0];
    OK(icoray_field_set(ctx, "f", &array));
    OK(icoray_scene_text(ctx, text_of(SCENE("f", "4", "levels_{view}_%d_%d_{step}.png") "[[views]]\nname = \"f\"\n"
                                      "[[views]]\nname = \"g\"\nfield = \"g\"\n", way, is_static)));
    for (int step = 1; step <= STEPS; step++) {
        compute(level[step % levels], way == SELDOM ? step / 4 : step);
        if (!is_static) {
            compute(g, 2 * step);
        }
        if (way == AT_EACH_STEP || way == SELDOM) {
            array.data = level[step % levels];
            OK(icoray_field_set(ctx, "f", &array));
        }
        OK(icoray_execute(ctx, step, 60.0 * step, NULL));
    }
    OK(icoray_close(&ctx));
    for (int i = 0; i < levels; i++) {
        free(level[i]);
    }
    free(g);
    CHECK(lines.other == 0);
    return lines;
}

void time_levels(void)
{
    for (int is_static = 0; is_static < 2; is_static++) {
        Lines lines = run(ONCE, is_static);
        trying = is_static ? "beside a static field" : "beside a field that changes";
        CHECK(lines.pointed_out == 1 && strstr(lines.last, "\"f\" change only at every second step") != NULL);
        CHECK(strstr(lines.last, is_static ? "step 6: " : "step 4: ") != NULL);
        CHECK(run(AT_EACH_STEP, is_static).pointed_out == 0);
        CHECK(run(IN_PLACE, is_static).pointed_out == 0);
        lines = run(ONCE_OF_THREE, is_static);
        CHECK(lines.pointed_out == 1 && strstr(lines.last, "every third step") != NULL);
        trying = "";
    }
    Lines lines = run(SELDOM, 0);
    CHECK(lines.pointed_out == 1 && strstr(lines.last, "may compute a field at some steps only") != NULL);
}
