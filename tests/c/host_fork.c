/*
 * Processes that were forked: host_fork <directory>
 *
 * In the child of a process with an open context and running threads, each call returns at once; the child can
 * close that context and open its own. The parent's frames are not affected.
 */
#define _GNU_SOURCE

#include "host.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

/* Large enough for the frame to be in progress when the child runs. */
#define BIG 300
#define WIDE 1600

/* Counts failed checks of the child, which the parent's count does not include. */
static int bad;

static void in_child(int good, const char *what, Place at)
{
    bad += !good;
    check(good, what, at);
}

#undef CHECK
#undef OK
#define CHECK(condition) in_child((condition), #condition, HERE)
#define OK(call) in_child((call) == ICORAY_OK, #call, HERE)

/* The child's calls; returns the number of its failed checks. */
static int child(icoray_ctx *ctx, const World *w, const char *directory, int busy)
{
    char message[512] = "";
    int32_t wants = 1;
    icoray_layers layers = {sizeof layers};
    icoray_ndarray array = {sizeof array};
    icoray_frame_report report = {sizeof report};
    /* It was at work when it was forked. */
    CHECK(!busy || !is_file(path_of(directory, "frame_1.png")));
    alarm(PATIENCE_S);
    CHECK(icoray_wants(ctx, 1, 0.0, &wants) == ICORAY_ERR_FORKED && wants == 0);
    CHECK(icoray_wants_field(ctx, "f", 1, 0.0, &wants) == ICORAY_ERR_FORKED);
    CHECK(icoray_execute(ctx, 1, 0.0, NULL) == ICORAY_ERR_FORKED);
    CHECK(icoray_wait(ctx) == ICORAY_ERR_FORKED);
    CHECK(icoray_report(ctx, &report) == ICORAY_ERR_FORKED);
    CHECK(icoray_grid_set(ctx, &w->grid) == ICORAY_ERR_FORKED);
    CHECK(icoray_layers_set(ctx, &layers) == ICORAY_ERR_FORKED);
    CHECK(icoray_field_set(ctx, "f", &w->array) == ICORAY_ERR_FORKED);
    CHECK(icoray_field_set_ndarray(ctx, "f", &array) == ICORAY_ERR_FORKED);
    CHECK(icoray_scene_load(ctx, "scene.toml") == ICORAY_ERR_FORKED);
    CHECK(icoray_scene_text(ctx, "") == ICORAY_ERR_FORKED);
    OK(icoray_last_error(ctx, message, sizeof message));
    CHECK(strstr(message, "forked") != NULL);
    OK(icoray_close(&ctx));
    CHECK(ctx == NULL);

    icoray_config config = CONFIG(.output_dir = path_of(directory, "child"), .existing = ICORAY_OVERWRITE);
    for (int async = 0; async < 2; async++) {
        config.async_render = async;
        ctx = opened(&config, w, 24);
        DRAW(ctx, async, 0.0, NULL);
        OK(icoray_close(&ctx));
    }
    CHECK(same_files(path_of(config.output_dir, "frame_0.png"), path_of(directory, "frame_0.png")));
    CHECK(is_whole_png(path_of(directory, "child/frame_1.png")));
    /* The mesh came along; it is memory, not threads. */
    icoray_mesh *mesh = w->mesh;
    OK(icoray_mesh_free(&mesh));
    return bad;
}

typedef struct {
    const char *name;
    int async, pixels;
    const char *more;
    int busy, exits;
} Case;

static const Case cases[] = {
    {"idle", 0, 24, "", 0, 0},
    {"idle async", 1, 24, "", 0, 0},
    {"written", 0, WIDE, "time_budget_ms = 1", 1, 0},
    {"rendered async", 1, BIG, "tolerance = 1e-6", 1, 0},
    {"written async", 1, WIDE, "time_budget_ms = 1", 1, 0},
    {"exits", 1, BIG, "", 0, 1},
};

static void fork_in(const char *directory, const Case *c, const World *w)
{
    const char *name = path_of(directory, c->name);
    icoray_config config = CONFIG(.output_dir = name, .async_render = c->async, .threads = 2);
    icoray_ctx *ctx = opened(&config, w, 24);
    DRAW(ctx, 0, 0.0, NULL);
    if (c->pixels != 24) {
        set_scene(ctx, c->pixels, c->more);
    }
    OK(icoray_execute(ctx, 1, 0.0, NULL));
    if (!c->busy) {
        OK(icoray_wait(ctx));
    }
    fflush(stdout);
    pid_t pid = fork();
    if (pid == 0) {
        int status = child(ctx, w, name, c->busy) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
        fflush(stdout);
        if (c->exits) {
            exit(status); /* as models end, with all that is run at exit */
        }
        _exit(status);
    }
    int status = -1;
    CHECK(pid > 0 && waitpid(pid, &status, 0) == pid);
    CHECK(WIFEXITED(status) && WEXITSTATUS(status) == EXIT_SUCCESS);
    OK(icoray_wait(ctx));
    OK(icoray_execute(ctx, 2, 0.0, NULL));
    OK(icoray_close(&ctx));
    CHECK(is_whole_png(path_of(name, "frame_1.png")));
    CHECK(is_whole_png(path_of(name, "frame_2.png")));
    CHECK(entries(name, ".tmp") == 0);
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        return EXIT_FAILURE;
    }
    World w = world(4, HOST_LAYERS);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        trying = cases[i].name;
        fork_in(argv[1], &cases[i], &w);
    }
    end_world(&w);
    return verdict("host_fork");
}
