/*
 * Threads of the host's, and its log: host_threads <directory>
 *
 * If two threads use one context, one call at a time is served and the other returns ICORAY_ERR_BUSY; contexts are
 * independent; the log callback runs on the calling thread, and may not call back.
 */
#define _GNU_SOURCE

#include "host.h"

#include <pthread.h>
#include <unistd.h>

#define FRAMES 60

typedef struct {
    icoray_ctx *ctx;
    const World *w;
    int first, well, busy, other;
    const char *directory;
} Work;

/* Sets fields and executes in a context that another thread uses too, until it has its frames. */
static void *contend(void *data)
{
    Work *work = data;
    while (work->well < FRAMES) {
        icoray_status statuses[3];
        icoray_frame_report report = {sizeof report};
        statuses[0] = icoray_field_set(work->ctx, "f", &work->w->array);
        statuses[1] = icoray_execute(work->ctx, work->first + work->well, 0.0, NULL);
        statuses[2] = icoray_report(work->ctx, &report);
        for (int i = 0; i < 3; i++) {
            int no_frame_yet = i == 2 && statuses[i] == ICORAY_ERR_ORDER;
            work->busy += statuses[i] == ICORAY_ERR_BUSY;
            work->other += statuses[i] != ICORAY_OK && statuses[i] != ICORAY_ERR_BUSY && !no_frame_yet;
        }
        work->well += statuses[1] == ICORAY_OK;
        if (statuses[1] == ICORAY_ERR_BUSY) {
            rest_ms(1);
        }
    }
    return NULL;
}

static void one_context(const char *directory, const World *w, int async)
{
    const char *name = path_of(directory, async ? "async" : "sync");
    icoray_config config = CONFIG(.output_dir = name, .async_render = async, .threads = 2);
    icoray_ctx *ctx = opened(&config, w, 96);
    Work work[2] = {{.ctx = ctx, .w = w}, {.ctx = ctx, .w = w, .first = 1000}};
    pthread_t thread;
    CHECK(pthread_create(&thread, NULL, contend, &work[1]) == 0);
    contend(&work[0]);
    pthread_join(thread, NULL);
    CHECK(work[0].other == 0 && work[1].other == 0);
    CHECK(work[0].well == FRAMES && work[1].well == FRAMES);
    CHECK(work[0].busy + work[1].busy > 0);
    OK(icoray_wait(ctx));
    CHECK(report_of(ctx).frames_written == (uint64_t)(work[0].well + work[1].well));
    OK(icoray_close(&ctx));
    CHECK(entries(name, ".png") == work[0].well + work[1].well);
    note("%s: %d and %d frames of %d each, busy %d and %d times", async ? "async" : "sync", work[0].well, work[1].well,
         FRAMES, work[0].busy, work[1].busy);
}

/* One thread of several, with a context of its own. */
static void *alone(void *data)
{
    Work *work = data;
    for (int i = 0; i < 10; i++) {
        work->other += icoray_execute(work->ctx, i, 0.0, NULL) != ICORAY_OK;
    }
    work->other += icoray_wait(work->ctx) != ICORAY_OK;
    work->other += icoray_close(&work->ctx) != ICORAY_OK || work->ctx != NULL;
    return NULL;
}

static void own_contexts(const char *directory, const World *w)
{
    Work work[5];
    pthread_t threads[5];
    memset(work, 0, sizeof work);
    for (int i = 0; i < 5; i++) {
        const char *name = text_of("%s/own%d", directory, i);
        icoray_config config = CONFIG(.output_dir = name, .threads = 1 + i % 2, .async_render = i % 3 == 1);
        work[i].ctx = opened(&config, w, 64);
    }
    alone(&work[4]);
    for (int i = 0; i < 4; i++) {
        CHECK(pthread_create(&threads[i], NULL, alone, &work[i]) == 0);
    }
    for (int i = 0; i < 4; i++) {
        pthread_join(threads[i], NULL);
        CHECK(work[i].other == 0);
        for (int step = 0; step < 10; step++) {
            CHECK(same_files(text_of("%s/own%d/frame_%d.png", directory, i, step),
                             text_of("%s/own4/frame_%d.png", directory, step)));
        }
    }
}

typedef struct {
    pthread_t caller;
    icoray_ctx *ctx;
    const World *w;
    int lines[5], elsewhere, outside, odd, refused, asked;
    volatile int is_inside;
} Heard;

static void hear(void *user, int32_t level, const char *message)
{
    Heard *heard = user;
    char text[256] = "";
    int32_t wants;
    icoray_ctx *ctx = heard->ctx;
    heard->elsewhere += !pthread_equal(pthread_self(), heard->caller);
    heard->outside += !heard->is_inside;
    heard->odd += level < ICORAY_LOG_ERROR || level > ICORAY_LOG_DEBUG || message == NULL || message[0] == '\0' ||
                  strchr(message, '\n') != NULL;
    heard->lines[level >= 0 && level < 5 ? level : 0]++;
    if (ctx == NULL) {
        return;
    }
    heard->asked += 7;
    heard->refused += icoray_execute(ctx, 999, 0.0, NULL) == ICORAY_ERR_BUSY;
    heard->refused += icoray_wait(ctx) == ICORAY_ERR_BUSY;
    heard->refused += icoray_scene_text(ctx, "") == ICORAY_ERR_BUSY;
    heard->refused += icoray_grid_set(ctx, &heard->w->grid) == ICORAY_ERR_BUSY;
    heard->refused += icoray_wants(ctx, 1, 0.0, &wants) == ICORAY_ERR_BUSY;
    heard->refused += icoray_close(&ctx) == ICORAY_ERR_BUSY && ctx == heard->ctx;
    heard->refused += icoray_last_error(ctx, text, sizeof text) == ICORAY_OK && strstr(text, "callback") != NULL;
}

#define INSIDE(heard, call) ((heard).is_inside = 1, OK(call), (heard).is_inside = 0)
#define FAILS(heard, call) ((heard).is_inside = 1, CHECK((call) != ICORAY_OK), (heard).is_inside = 0)

/* Frames, failures of all kinds, and what the log hears of them. */
static Heard logged(const char *directory, const World *w, int async, int on_error, int level)
{
    const char *name = text_of("%s/log%d%d%d", directory, async, on_error, level);
    Heard heard = {.caller = pthread_self(), .w = w};
    icoray_config config = CONFIG(.output_dir = name, .async_render = async, .on_error = on_error, .log = hear,
                                  .log_user = &heard, .log_level = level);
    heard.is_inside = 1;
    icoray_ctx *ctx = opened(&config, w, 24);
    set_scene(ctx, 24, "backend = \"cpu\"");
    heard.is_inside = 0;
    heard.ctx = ctx;
    for (int step = 0; step < 3; step++) {
        INSIDE(heard, icoray_execute(ctx, step, 0.0, NULL));
    }
    INSIDE(heard, icoray_wait(ctx));
    FAILS(heard, icoray_scene_text(ctx, "nothing"));
    FAILS(heard, icoray_execute(ctx, 1, 0.0, NULL));
    CHECK(remove(path_of(name, "report.csv")) == 0);
    CHECK(remove(path_of(name, "frame_0.png")) == 0 && remove(path_of(name, "frame_1.png")) == 0 &&
          remove(path_of(name, "frame_2.png")) == 0 && rmdir(name) == 0);
    /* A link to nothing in the directory's place: looks as if it could be made, and cannot. */
    CHECK(symlink("nowhere", name) == 0);
    INSIDE(heard, icoray_execute(ctx, 3, 0.0, NULL));
    FAILS(heard, icoray_wait(ctx));
    int warnings = heard.lines[ICORAY_LOG_WARN];
    /* icoray_close alone returns the last frame's failure. */
    INSIDE(heard, icoray_execute(ctx, 4, 0.0, NULL));
    FAILS(heard, icoray_close(&ctx));
    CHECK(ctx == NULL);
    CHECK(heard.lines[ICORAY_LOG_WARN] == warnings + (on_error == ICORAY_WARN && level >= ICORAY_LOG_WARN));
    CHECK(heard.elsewhere == 0 && heard.outside == 0 && heard.odd == 0 && heard.refused == heard.asked);
    CHECK(heard.lines[0] == 0);
    return heard;
}

static void logs(const char *directory, const World *w)
{
    for (int async = 0; async < 2; async++) {
        for (int level = ICORAY_LOG_OFF; level <= ICORAY_LOG_DEBUG; level++) {
            Heard warned = logged(directory, w, async, ICORAY_WARN, level);
            CHECK(warned.lines[ICORAY_LOG_WARN] == (level >= ICORAY_LOG_WARN ? 4 : 0));
            CHECK(warned.lines[ICORAY_LOG_INFO] == (level >= ICORAY_LOG_INFO ? 3 : 0));
            CHECK(warned.lines[ICORAY_LOG_DEBUG] == (level >= ICORAY_LOG_DEBUG ? 5 : 0));
            CHECK((warned.asked > 0) == (level >= ICORAY_LOG_WARN));
            Heard ignored = logged(directory, w, async, ICORAY_IGNORE, level);
            CHECK(ignored.lines[ICORAY_LOG_WARN] == 0 && ignored.lines[ICORAY_LOG_ERROR] == 0);
            CHECK(ignored.lines[ICORAY_LOG_INFO] == warned.lines[ICORAY_LOG_INFO]);
        }
    }
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        return EXIT_FAILURE;
    }
    World w = world(3, HOST_LAYERS);
    one_context(argv[1], &w, 0);
    one_context(argv[1], &w, 1);
    own_contexts(argv[1], &w);
    logs(argv[1], &w);
    end_world(&w);
    return verdict("host_threads");
}
