/* Log lines and their levels, and the callback that writes to stderr. */
#define _POSIX_C_SOURCE 200809L /* dup, dup2, symlink */

#include "refusals.h"

#include <math.h>
#include <unistd.h>

/* Lines of each level. */
typedef struct {
    int lines[5], others;
    char last[5][512];
} Lines;

static void counts(void *user, int32_t level, const char *message)
{
    Lines *lines = (Lines *)user;
    if (level < ICORAY_LOG_ERROR || level > ICORAY_LOG_DEBUG || message == NULL || strchr(message, '\n') != NULL ||
        strlen(message) > 400) {
        lines->others++;
        return;
    }
    lines->lines[level]++;
    snprintf(lines->last[level], sizeof lines->last[level], "%s", message);
}

/* One frame drawn, one drawn and not written, one refused argument, and two frames that fail: then it is off. */
static void story(int32_t on_error, int32_t level)
{
    icoray_config config = good_config;
    icoray_ctx *ctx;
    Lines lines = {0};
    int off = on_error == ICORAY_DISABLE;
    int logs = level >= ICORAY_LOG_WARN, warns = logs && on_error != ICORAY_IGNORE;
    config.on_error = on_error;
    config.disable_after = 2;
    ctx = filled_logging(config, counts, &lines, level);
    CHECK(icoray_grid_set(ctx, NULL) == ICORAY_ERR_NULL);
    still_draws(ctx);
    OK(icoray_scene_text(ctx, SCENE("q", "4", "q.png")));
    for (int step = 1; step <= 4; step++) {
        CHECK(icoray_execute(ctx, step, 0.0, NULL) == (off && step > 2 ? ICORAY_ERR_DISABLED : ICORAY_ERR_FIELD));
    }
    OK(icoray_close(&ctx));
    CHECK(lines.others == 0 && lines.lines[0] == 0);
    CHECK(lines.lines[ICORAY_LOG_ERROR] == (off && level >= ICORAY_LOG_ERROR));
    CHECK(!off || level < ICORAY_LOG_ERROR || strstr(lines.last[ICORAY_LOG_ERROR], "2 failures in a row") != NULL);
    /* The argument, the scene whose field is not set, and two frames; what is off is not logged again and again. */
    CHECK(lines.lines[ICORAY_LOG_WARN] == logs + (off ? 3 : 5) * warns);
    CHECK(warns == 0 || strstr(lines.last[ICORAY_LOG_WARN], "\"q\"") != NULL);
    CHECK(lines.lines[ICORAY_LOG_INFO] == (level >= ICORAY_LOG_INFO));
    CHECK(level < ICORAY_LOG_INFO || strstr(lines.last[ICORAY_LOG_INFO], ".png") != NULL);
    CHECK(lines.lines[ICORAY_LOG_DEBUG] == (level >= ICORAY_LOG_DEBUG));
    CHECK(level < ICORAY_LOG_DEBUG || strstr(lines.last[ICORAY_LOG_DEBUG], "left out") != NULL);
}

/* A frame that fails when it is written is logged once, by the call that returns its failure. */
static void late(int by_close, int32_t on_error)
{
    icoray_config config = good_config;
    icoray_ctx *ctx;
    Lines lines = {0};
    config.on_error = on_error;
    ctx = filled_logging(config, counts, &lines, ICORAY_LOG_DEBUG);
    OK(icoray_scene_text(ctx, SCENE("f", "4", "log_late/pictures/{step}.png")));
    CHECK(symlink("nowhere/at/all", in_output("log_late")) == 0);
    OK(icoray_execute(ctx, 1, 0.0, NULL));
    CHECK(by_close || icoray_wait(ctx) == ICORAY_ERR_IO);
    CHECK(icoray_close(&ctx) == (by_close ? ICORAY_ERR_IO : ICORAY_OK));
    CHECK(lines.lines[ICORAY_LOG_WARN] == (on_error != ICORAY_IGNORE) && lines.lines[ICORAY_LOG_INFO] == 0);
    CHECK(on_error == ICORAY_IGNORE || strstr(lines.last[ICORAY_LOG_WARN], "log_late/pictures") != NULL);
    CHECK(unlink(in_output("log_late")) == 0);
}

#define VOLUME(field)                                                                                                  \
    "[[volumes]]\nfield = \"" field "\"\n"                                                                             \
    "transfer = { map = \"viridis\", range = [0, 2], opacity = [[0, 0.1], [2, 0.9]] }\n"

/* Holes of a grid, and fields without values, are logged once. */
static void oddities(void)
{
    static const char scene[] = "backend = \"cpu\"\n[image]\nwidth = 16\nheight = 16\n"
                                "[camera]\nlon = 10\nlat = 40\ndistance = 4\n[output]\nfile = \"odd_{step}.png\"\n"
        VOLUME("f") VOLUME("g");
    size_t count = (size_t)good_array.columns * LAYERS;
    float *missing = (float *)allocate(count, sizeof *missing);
    icoray_grid grid = good_grid;
    icoray_array array = good_array, empty;
    icoray_ctx *ctx;
    Lines lines = {0};
    for (size_t i = 0; i < count; i++) {
        missing[i] = NAN;
    }
    grid.cells = array.columns = good_grid.cells - 1;
    empty = array;
    empty.data = missing;
    ctx = filled_logging(good_config, counts, &lines, ICORAY_LOG_WARN);
    OK(icoray_grid_set(ctx, &grid));
    OK(icoray_scene_text(ctx, scene));
    for (int step = 1; step <= 6; step++) {
        OK(icoray_field_set(ctx, "f", step < 5 ? &array : &empty));
        OK(icoray_field_set(ctx, "g", step < 3 ? &array : &empty));
        OK(icoray_execute(ctx, step, 0.0, NULL));
        /* Also that the scene was loaded before g was set, and that g stays what it is while f changes. */
        CHECK(lines.lines[ICORAY_LOG_WARN] == 1 + (step + 1) / 2 + (step > 4));
        CHECK(strstr(lines.last[ICORAY_LOG_WARN], step < 3   ? "the grid has 1 hole, closed by"
                                                  : step < 5 ? "field \"g\" has no values"
                                                             : "field \"f\" has no values") != NULL);
    }
    OK(icoray_close(&ctx));
    free(missing);
}

void logged(void)
{
    oddities();
    for (int32_t on_error = ICORAY_WARN; on_error <= ICORAY_DISABLE; on_error++) {
        late(0, on_error);
        late(1, on_error);
        for (int32_t level = ICORAY_LOG_OFF; level <= ICORAY_LOG_DEBUG; level++) {
            trying = text_of("on_error %d, level %d", (int)on_error, (int)level);
            story(on_error, level);
            trying = "";
        }
    }
}

/* In place of stderr, a file. */
void standard_error(void)
{
    icoray_config config = good_config;
    icoray_ctx *ctx = NULL;
    FILE *file = fopen(in_output("stderr.txt"), "wb");
    int kept = dup(2);
    CHECK(file != NULL && kept >= 0 && dup2(fileno(file), 2) == 2);
    icoray_log_stderr(NULL, ICORAY_LOG_ERROR, "an error");
    icoray_log_stderr(&ctx, ICORAY_LOG_WARN, "a warning");
    icoray_log_stderr(NULL, ICORAY_LOG_INFO, "a word");
    icoray_log_stderr(NULL, ICORAY_LOG_DEBUG, "more");
    icoray_log_stderr(NULL, 99, "most");
    icoray_log_stderr(NULL, ICORAY_LOG_ERROR, NULL);
    config.log = icoray_log_stderr;
    config.log_level = ICORAY_LOG_WARN;
    OK(icoray_open_serial(&config, &ctx));
    CHECK(icoray_layers_set(ctx, NULL) == ICORAY_ERR_NULL);
    OK(icoray_close(&ctx));
    CHECK(dup2(kept, 2) == 2 && close(kept) == 0 && fclose(file) == 0);
    CHECK(file_is("stderr.txt", "icoray: error: an error\nicoray: warning: a warning\nicoray: a word\nicoray: more\n"
                                "icoray: most\nicoray: warning: icoray_layers is NULL\n"));
}
