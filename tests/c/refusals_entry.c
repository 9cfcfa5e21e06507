/* Callers that a context refuses: its own log callback, another thread during a call, and a forked process. */
#define _POSIX_C_SOURCE 200809L /* kill */

#include "refusals.h"

#include <pthread.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

/* Every call on a context returns this status, with this part in its message. */
static void all_say(icoray_ctx *ctx, icoray_status status, const char *part)
{
    icoray_ndarray ndarray = {0};
    icoray_frame_report report = {0};
    int32_t any = 7, f = 7;
    ndarray.struct_size = sizeof ndarray;
    report.struct_size = sizeof report;
    /* Messages are the thread's: the context, whose own are kept, was not entered. */
#define SAYS(call) REFUSED_AS(NULL, status, part, call)
    SAYS(icoray_grid_set(ctx, &good_grid));
    SAYS(icoray_layers_set(ctx, &good_layers));
    SAYS(icoray_field_set(ctx, "f", &good_array));
    SAYS(icoray_field_set_ndarray(ctx, "f", &ndarray));
    SAYS(icoray_scene_text(ctx, good_scene));
    SAYS(icoray_scene_load(ctx, "scene.toml"));
    SAYS(icoray_wants(ctx, 0, 0.0, &any));
    SAYS(icoray_wants_field(ctx, "f", 0, 0.0, &f));
    SAYS(icoray_execute(ctx, 0, 0.0, NULL));
    SAYS(icoray_wait(ctx));
    SAYS(icoray_report(ctx, &report));
#undef SAYS
    CHECK(any == 0 && f == 0 && report.step == 0);
}

typedef struct {
    icoray_ctx *ctx, *other;
    int lines;
} Caller;

static void *from_a_thread(void *data)
{
    all_say(((Caller *)data)->ctx, ICORAY_ERR_BUSY, "has not returned");
    return NULL;
}

/* Against the rules, calls the context that it is the log of; by the rules, another one. */
static void calls_back(void *user, int32_t level, const char *message)
{
    Caller *caller = (Caller *)user;
    icoray_ctx *still = caller->ctx;
    pthread_t thread;
    if (++caller->lines > 1) {
        return;
    }
    CHECK(level == ICORAY_LOG_WARN && strstr(message, "icoray_grid is NULL") != NULL);
    all_say(caller->ctx, ICORAY_ERR_BUSY, "has not returned");
    REFUSED(NULL, BUSY, "has not returned", icoray_close(&caller->ctx));
    CHECK(caller->ctx == still);
    CHECK(pthread_create(&thread, NULL, from_a_thread, caller) == 0 && pthread_join(thread, NULL) == 0);
    still_draws(caller->other);
}

void busy(void)
{
    icoray_config config = good_config;
    Caller caller;
    caller.lines = 0;
    caller.other = filled();
    caller.ctx = filled_logging(config, calls_back, &caller, ICORAY_LOG_WARN);
    CHECK(icoray_grid_set(caller.ctx, NULL) == ICORAY_ERR_NULL);
    CHECK(caller.lines == 1);
    still_draws(caller.ctx);
    OK(icoray_close(&caller.ctx));
    OK(icoray_close(&caller.other));
}

/* Number of failed checks in the child; the parent does not count them. */
static int child_of_a_fork(icoray_ctx *inherited)
{
    icoray_ctx *ctx;
    int before = failed_checks();
    all_say(inherited, ICORAY_ERR_FORKED, "was forked; open one here");
    OK(icoray_close(&inherited));
    CHECK(inherited == NULL);
    OK(icoray_close(&inherited));
    ctx = filled();
    OK(icoray_scene_text(ctx, SCENE("f", "4", "forked.png")));
    OK(icoray_execute(ctx, 0, 0.0, NULL));
    OK(icoray_close(&ctx));
    CHECK(is_picture("forked.png"));
    fflush(stdout);
    return failed_checks() - before;
}

void forked(void)
{
    for (int is_async = 0; is_async < 2; is_async++) {
        icoray_ctx *ctx;
        pid_t child;
        int ends[2], failed = -1;
        expected_copy = is_async ? (uint64_t)good_grid.cells * LAYERS * sizeof *values : 0;
        ctx = filled_async(is_async);
        still_draws(ctx);
        fflush(stdout);
        CHECK(pipe(ends) == 0);
        child = fork();
        if (child == 0) {
            failed = child_of_a_fork(ctx);
            /* Not by an exit, at which valgrind would miss the stacks of threads that are in the parent alone. */
            while (write(ends[1], &failed, sizeof failed) == sizeof failed) {
                pause();
            }
            _exit(EXIT_FAILURE);
        }
        CHECK(child > 0 && close(ends[1]) == 0);
        CHECK(read(ends[0], &failed, sizeof failed) == sizeof failed && failed == 0);
        CHECK(child > 0 && kill(child, SIGKILL) == 0 && waitpid(child, NULL, 0) == child);
        CHECK(close(ends[0]) == 0);
        CHECK(is_picture("forked.png") && remove(in_output("forked.png")) == 0);
        still_draws(ctx);
        OK(icoray_close(&ctx));
    }
    expected_copy = 0;
}
