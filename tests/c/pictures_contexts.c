/* Several contexts, on one thread and on several. */
#include "pictures.h"

#include <pthread.h>

/* Two contexts, drawing by turns. */
void by_turns(const char *directory)
{
    icoray_ctx *a = context(directory, "turns/a", 1), *b = context(directory, "turns/b", 3);
    Field f = field(ICORAY_F32, ICORAY_CENTER, LAYERS, (size_t)cells * LAYERS, 0, LAYERS, 1);
    Field g = field(ICORAY_F32, ICORAY_CORNER, LAYERS, (size_t)corners * LAYERS, 0, 1, corners);
    scene(a, "plain", "none");
    scene(b, "corner", "none");
    frame_of(a, 0, &f);
    frame_of(b, 10, &g);
    frame(a, 1);
    frame(b, 11);
    icoray_frame_report report = report_of(a);
    CHECK(report.step == 1 && report.bytes_derived == 0);
    OK(icoray_close(&a));
    frame(b, 12);
    OK(icoray_close(&b));
    release(&f);
    release(&g);
}

/* The pictures of a thread of the test. check.c counts without locks, so the thread keeps its own statuses. */
typedef struct {
    icoray_ctx *ctx;
    const char *wrong;
    int failed;
} Work;

static void *work(void *data)
{
    Work *w = (Work *)data;
    char message[256] = "";
    for (int step = 0; step < 3; step++) {
        w->failed += icoray_execute(w->ctx, step, 0.0, NULL) != ICORAY_OK;
        w->failed += icoray_scene_load(w->ctx, w->wrong) != ICORAY_ERR_IO;
        w->failed += icoray_last_error(NULL, message, sizeof message) != ICORAY_OK;
        w->failed += strstr(message, w->wrong) == NULL;
    }
    return NULL;
}

/* Several contexts on as many threads, some of which draw in the background, two into one directory. */
void at_once(const char *directory)
{
    enum { CONTEXTS = 4 };
    static const char *const places[CONTEXTS] = {"at_once/a", "at_once/b", "at_once/both", "at_once/both"};
    static const char *const wrong[CONTEXTS] = {"no such file, one", "no such file, two", "no, three", "no, four"};
    Work works[CONTEXTS];
    pthread_t thread[CONTEXTS];
    Field f = field(ICORAY_F32, ICORAY_CENTER, LAYERS, (size_t)cells * LAYERS, 0, LAYERS, 1);
    Field g = field(ICORAY_F32, ICORAY_CORNER, LAYERS, (size_t)corners * LAYERS, 0, LAYERS, 1);
    for (int i = 0; i < CONTEXTS; i++) {
        icoray_config config = {.threads = 1};
        config.async_render = i % 3; /* the middle ones */
        works[i].ctx = context_with(directory, places[i], config);
        works[i].wrong = wrong[i];
        works[i].failed = 0;
        scene(works[i].ctx, i % 2 == 0 ? "plain" : "corner", "none");
        OK(icoray_field_set(works[i].ctx, "f", i % 2 == 0 ? &f.array : &g.array)); /* arrays may be shared */
    }
    for (int i = 0; i < CONTEXTS; i++) {
        CHECK(pthread_create(&thread[i], NULL, work, &works[i]) == 0);
    }
    for (int i = 0; i < CONTEXTS; i++) {
        CHECK(pthread_join(thread[i], NULL) == 0);
        CHECK(works[i].failed == 0);
        OK(icoray_close(&works[i].ctx));
    }
    release(&f);
    release(&g);
}
