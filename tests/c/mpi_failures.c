/*
 * One call fails on one rank, in a model that draws as the documentation says (`if (wants) icoray_execute`): all ranks come
 * to the end, with the same answers and statuses. mpi_failures DIRECTORY CALL; CALL is a name of the table below.
 */
#define _POSIX_C_SOURCE 200809L

#include "mpi_cut.h"

#include <math.h>
#include <pthread.h>

#define STEPS 6
#define AT 3 /* the step at which calls of the time loop fail */

#define SCENE(every)                                                                                  \
    "field = \"f\"\nexaggeration = 40\nevery = " every "\n"                               \
    "[image]\nwidth = 20\nheight = 20\n"                                                             \
    "[camera]\nlon = 20\nlat = 35\ndistance = 3\n"                                                  \
    "[transfer]\nmap = \"viridis\"\nrange = [-1.5, 1.5]\nopacity = [[-1.5, 0.8], [1.5, 0.9]]\n"

/* The failure of a call. */
enum { NO_POINTER, BAD_STRUCT, BAD_VALUE, NO_FILE, BAD_TEXT, SPOILT, BUSY };

static const struct {
    const char *call;
    int how;
    int only_root;   /* where only rank 0 can fail so */
    int is_fatal;    /* no later execute goes well */
    int is_harmless; /* every execute goes well */
} failures[] = {
    {"none", NO_POINTER, 0, 0, 1},
    {"open", NO_POINTER, 0, 1, 0},
    {"open", BAD_STRUCT, 0, 1, 0},
    {"open", BAD_VALUE, 0, 1, 0},
    {"grid_set", NO_POINTER, 0, 1, 0},
    {"grid_set", BAD_VALUE, 0, 1, 0},
    {"layers_set", NO_POINTER, 0, 1, 0},
    {"layers_set", BAD_VALUE, 0, 1, 0},
    {"field_set", NO_POINTER, 0, 0, 1},
    {"field_set", BAD_VALUE, 0, 0, 0},
    {"part_set", NO_POINTER, 0, 1, 0},
    {"part_set", BAD_VALUE, 0, 1, 0},
    {"part_set", BUSY, 0, 0, 1},
    {"scene_load", NO_POINTER, 0, 0, 1}, /* the text comes after it */
    {"scene_load", NO_FILE, 1, 0, 1},
    {"scene_load", BAD_TEXT, 1, 0, 1},
    {"scene_load", BUSY, 0, 0, 1},
    {"scene_text", NO_POINTER, 0, 0, 1},
    {"scene_text", BAD_TEXT, 1, 0, 1},
    {"scene_text", BUSY, 0, 0, 1},
    {"describe", NO_POINTER, 0, 0, 1},
    {"wants", BAD_VALUE, 0, 0, 1},
    {"wants", BUSY, 0, 0, 1},
    {"wants_field", NO_POINTER, 0, 0, 1},
    {"execute", BAD_VALUE, 0, 0, 0},
    {"execute", BAD_TEXT, 0, 0, 0},
    {"execute", SPOILT, 0, 1, 0},
    {"execute", BUSY, 0, 0, 1},
    {"wait", BUSY, 0, 0, 1},
    {"close", BUSY, 0, 0, 1},
};

static const char *directory;
static World w, spoilable;
static Cut mine;
static int failing, odd, has_parts;

/* Whether the call is to fail here so. */
static int fails(const char *call, int how)
{
    return rank == odd && failures[failing].how == how && strcmp(failures[failing].call, call) == 0;
}

/* Whether the call is to fail on all ranks: another thread's call is in its way for a while only. */
static int fails_on_all(const char *call)
{
    return strcmp(failures[failing].call, call) == 0 && failures[failing].how != BUSY;
}

/* The status of a call that all ranks make: it is the same on all. */
static icoray_status same(icoray_status status, const char *what)
{
    int is_same = is_same_on_all((int)status);
    CHECK(is_same);
    if (!is_same) {
        printf("  %s, rank %d: %d\n", what, rank, (int)status);
    }
    return status;
}

/* Another thread that is in a call for a while: its failure goes to the log, which takes its time. */
static pthread_t other;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t changed = PTHREAD_COND_INITIALIZER;
static int is_inside, is_slow;

static void slow_log(void *user, int32_t level, const char *message)
{
    (void)user, (void)level, (void)message;
    if (!is_slow) {
        return;
    }
    pthread_mutex_lock(&lock);
    is_inside = 1;
    pthread_cond_signal(&changed);
    pthread_mutex_unlock(&lock);
    rest_ms(50);
    is_slow = 0;
}

static void *stay(void *ctx)
{
    icoray_layers_set((icoray_ctx *)ctx, NULL);
    return NULL;
}

/* Starts the other thread's call if `call` is to find the context busy. */
static int meets(icoray_ctx *ctx, const char *call)
{
    if (!fails(call, BUSY)) {
        return 0;
    }
    is_slow = 1;
    is_inside = 0;
    CHECK(pthread_create(&other, NULL, stay, ctx) == 0);
    pthread_mutex_lock(&lock);
    while (!is_inside) {
        pthread_cond_wait(&changed, &lock);
    }
    pthread_mutex_unlock(&lock);
    return 1;
}

static void leave(int has_met)
{
    if (has_met) {
        CHECK(pthread_join(other, NULL) == 0);
    }
}

/* A call that all ranks make, and that another thread's may be in the way of. */
#define TOGETHER(status, ctx, call, made)       \
    do {                                        \
        int has_met_ = meets((ctx), (call));    \
        (status) = same((made), (call));        \
        leave(has_met_);                        \
    } while (0)

static icoray_ctx *open_all(void)
{
    icoray_ctx *ctx = NULL;
    icoray_status status;
    icoray_config config = CONFIG(.output_dir = directory, .threads = fails("open", BAD_VALUE) ? -1 : 1);
    config.struct_size -= (size_t)fails("open", BAD_STRUCT);
    config.existing = ICORAY_OVERWRITE;
    config.log = slow_log;
    config.log_level = ICORAY_LOG_WARN;
    status = icoray_open(&config, EVERYONE, fails("open", NO_POINTER) ? NULL : &ctx);
    same(status, "open");
    CHECK((status == ICORAY_OK) == (ctx != NULL));
    CHECK((status == ICORAY_OK) == !fails_on_all("open"));
    return ctx;
}

static void set_grid(icoray_ctx *ctx)
{
    icoray_grid grid = has_parts ? mine.grid : spoilable.grid;
    icoray_layers layers = {sizeof layers};
    grid.edges -= fails("grid_set", BAD_VALUE);
    CHECK((icoray_grid_set(ctx, fails("grid_set", NO_POINTER) ? NULL : &grid) == ICORAY_OK) ==
          !(fails("grid_set", BAD_VALUE) || fails("grid_set", NO_POINTER)));
    if (fails("layers_set", NO_POINTER)) {
        CHECK(icoray_layers_set(ctx, NULL) == ICORAY_ERR_NULL);
    } else if (fails("layers_set", BAD_VALUE)) {
        CHECK(icoray_layers_set(ctx, &layers) != ICORAY_OK);
    } else {
        set_layers(ctx, w.layers);
    }
}

static void set_part(icoray_ctx *ctx)
{
    icoray_part part = mine.part;
    icoray_status status;
    part.cells = fails("part_set", BAD_VALUE) ? -1 : part.cells;
    TOGETHER(status, ctx, "part_set", icoray_part_set(ctx, fails("part_set", NO_POINTER) ? NULL : &part));
    CHECK(!fails_on_all("part_set") || status != ICORAY_OK);
}

/* Every other step; by the file of rank 0, the only one that there is. */
static void load(icoray_ctx *ctx)
{
    const char *path = path_of(directory, fails("scene_load", BAD_TEXT) ? "bad.toml" : "scene.toml");
    icoray_status status;
    if (rank != 0 || fails("scene_load", NO_FILE)) {
        path = text_of("nowhere/of/rank_%d.toml", rank);
    }
    TOGETHER(status, ctx, "scene_load", icoray_scene_load(ctx, fails("scene_load", NO_POINTER) ? NULL : path));
    CHECK((status == ICORAY_OK) == !fails_on_all("scene_load"));
}

/* The scene for every step, in place of that of the file; it stays where this fails. */
static void change_scene(icoray_ctx *ctx)
{
    const char *text = fails("scene_text", BAD_TEXT) ? "field = 1" : rank == 0 ? SCENE("1") : "";
    icoray_status status;
    TOGETHER(status, ctx, "scene_text", icoray_scene_text(ctx, fails("scene_text", NO_POINTER) ? NULL : text));
    CHECK((status == ICORAY_OK) == !fails_on_all("scene_text"));
}

static void set_field(icoray_ctx *ctx, int step)
{
    icoray_array array = has_parts ? mine.center : spoilable.array;
    int is_here = step == AT;
    array.layers -= is_here && fails("field_set", BAD_VALUE);
    array.columns = is_here && fails("field_set", BAD_VALUE) ? 3 : array.columns;
    icoray_field_set(ctx, "f", is_here && fails("field_set", NO_POINTER) ? NULL : &array);
}

/* One step: the pictures that have gone well, and whether any was wanted. */
static int one_step(icoray_ctx *ctx, int step, int *wanted)
{
    int is_here = step == AT, has_met;
    double time = 60.0 * step;
    int32_t wants = 0, field = 0;
    icoray_status status;
    set_field(ctx, step);
    icoray_wants_field(ctx, is_here && fails("wants_field", NO_POINTER) ? NULL : "f", step, time, &field);
    has_met = is_here && meets(ctx, "wants");
    icoray_wants(ctx, step, is_here && fails("wants", BAD_VALUE) ? NAN : time, &wants);
    leave(has_met);
    CHECK(is_same_on_all((int)wants));
    if (!wants) {
        return 0;
    }
    ++*wanted;
    if (is_here && fails("execute", SPOILT) && !has_parts) {
        return same(execute_spoilt(ctx, &spoilable.grid, step, 1), "execute") == ICORAY_OK;
    }
    has_met = is_here && meets(ctx, "execute");
    status = icoray_execute(ctx, step, is_here && fails("execute", BAD_VALUE) ? NAN : time,
                            is_here && fails("execute", BAD_TEXT) ? "\xff" : NULL);
    leave(has_met);
    return same(status, "execute") == ICORAY_OK;
}

static void run_model(void)
{
    int drawn = 0, wanted = 0;
    /* The tables of parts are not read any more once the ranks of a node have put them together. */
    const int is_harmless = failures[failing].is_harmless || (has_parts && failures[failing].how == SPOILT);
    icoray_status status;
    icoray_ctx *ctx = open_all();
    if (ctx == NULL) {
        return;
    }
    set_grid(ctx);
    if (has_parts) {
        set_part(ctx);
    }
    CHECK((icoray_field_describe(ctx, fails("describe", NO_POINTER) ? NULL : "f", "a field", "m") == ICORAY_OK) ==
          !fails("describe", NO_POINTER));
    load(ctx);
    for (int step = 1; step <= STEPS; step++) {
        if (step == 2) {
            change_scene(ctx);
        }
        drawn += one_step(ctx, step, &wanted);
        MPI_Barrier(MPI_COMM_WORLD); /* as models do at each step */
    }
    TOGETHER(status, ctx, "wait", icoray_wait(ctx));
    TOGETHER(status, ctx, "close", icoray_close(&ctx));
    CHECK(ctx == NULL);
    if (is_harmless) {
        CHECK(drawn == wanted && drawn > 0);
    } else if (failures[failing].is_fatal) {
        CHECK(drawn < AT);
    } else {
        CHECK(drawn == wanted - 1 && drawn > 0);
    }
    (void)status;
}

/* Files for rank 0, in its own directory. */
static void write_scenes(void)
{
    static const char *const texts[][2] = {{"scene.toml", SCENE("2")}, {"bad.toml", "field = 1\n"}};
    for (int i = 0; rank == 0 && i < 2; i++) {
        FILE *file = fopen(path_of(directory, texts[i][0]), "w");
        CHECK(file != NULL && fputs(texts[i][1], file) >= 0 && fclose(file) == 0);
    }
    MPI_Barrier(MPI_COMM_WORLD);
}

int main(int argc, char **argv)
{
    int *owner, tried = 0;
    begin(&argc, &argv);
    directory = argv[1];
    write_scenes();
    w = world(3, 4);
    owner = partition(&w, CONTIGUOUS, ranks);
    mine = cut(&w, owner, rank, 1);
    spoilable = at_corners(&w);
    for (failing = 0; failing < (int)COUNT(failures); failing++) {
        if (strcmp(failures[failing].call, argv[2]) != 0) {
            continue;
        }
        for (odd = 0; odd < (failures[failing].only_root ? 1 : ranks); odd++) {
            for (has_parts = strcmp(argv[2], "part_set") == 0; has_parts < 2; has_parts++) {
                trying = text_of("%s fails (%d) on rank %d, %s", argv[2], failures[failing].how, odd,
                                 has_parts ? "parts" : "whole");
                run_model();
                tried++;
            }
        }
    }
    CHECK(tried > 0);
    end_cut(&mine);
    free(owner);
    free(spoilable.values);
    end_world(&w);
    return end("mpi_failures");
}
