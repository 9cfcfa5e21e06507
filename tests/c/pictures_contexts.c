/* Several contexts, on one thread and on several. */
#include "pictures.h"

#include <pthread.h>

/* Two contexts, drawing by turns. */
void by_turns(const char *directory)
{
    icoray_ctx *a = context(directory, "turns/a", 1), *b = context(directory, "turns/b", 3);
    Field f = field(ICORAY_F32, ICORAY_CENTER, LAYERS, (size_t)cells * LAYERS, 0, LAYERS, 1);
    Field g = field(ICORAY_F32, ICORAY_CORNER, LAYERS, (size_t)corners * LAYERS, 0, 1, corners);
    icoray_frame_report report;
    memset(&report, 0, sizeof report);
    report.struct_size = sizeof report;
    scene(a, "plain", "none");
    scene(b, "corner", "none");
    frame_of(a, 0, &f);
    frame_of(b, 10, &g);
    frame(a, 1);
    frame(b, 11);
    OK(icoray_report(a, &report));
    CHECK(report.step == 1 && report.derived_bytes == 0);
    OK(icoray_close(&a));
    frame(b, 12);
    OK(icoray_close(&b));
    release(&f);
    release(&g);
}

/* What a thread of the test draws. check.c counts without locks, so the thread keeps its own statuses. */
typedef struct {
    icoray_ctx *ctx;
    const char *wrong;
    int failed;
} Work;

static void *work(void *data)
{
    Work *w = data;
    char message[256] = "";
    for (int step = 0; step < 3; step++) {
        w->failed += icoray_execute(w->ctx, step, 0.0, NULL) != ICORAY_OK;
        w->failed += icoray_scene_load(w->ctx, w->wrong) != ICORAY_ERR_IO;
        w->failed += icoray_last_error(NULL, message, sizeof message) != ICORAY_OK;
        w->failed += strstr(message, w->wrong) == NULL;
    }
    return NULL;
}

/* Two contexts on two threads; each thread has its own last message. */
void at_once(const char *directory)
{
    Work works[2] = {{NULL, "no such file, one", 0}, {NULL, "no such file, two", 0}};
    pthread_t thread[2];
    Field f = field(ICORAY_F32, ICORAY_CENTER, LAYERS, (size_t)cells * LAYERS, 0, LAYERS, 1);
    Field g = field(ICORAY_F32, ICORAY_CORNER, LAYERS, (size_t)corners * LAYERS, 0, LAYERS, 1);
    works[0].ctx = context(directory, "at_once/a", 1);
    works[1].ctx = context(directory, "at_once/b", 1);
    scene(works[0].ctx, "plain", "none");
    scene(works[1].ctx, "corner", "none");
    OK(icoray_field_set(works[0].ctx, "f", &f.array));
    OK(icoray_field_set(works[1].ctx, "f", &g.array));
    for (int i = 0; i < 2; i++) {
        CHECK(pthread_create(&thread[i], NULL, work, &works[i]) == 0);
    }
    for (int i = 0; i < 2; i++) {
        CHECK(pthread_join(thread[i], NULL) == 0);
        CHECK(works[i].failed == 0);
        OK(icoray_close(&works[i].ctx));
    }
    release(&f);
    release(&g);
}
