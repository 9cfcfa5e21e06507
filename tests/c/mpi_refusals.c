/* A failure on one rank is the same status on all ranks, no rank hangs, and the next frame is drawn. */
#define _POSIX_C_SOURCE 200809L /* symlink */

#include "mpi_common.h"

#include <math.h>
#include <unistd.h>

static const char *directory;
static World w;
static int64_t step;

static icoray_ctx *fresh(void)
{
    icoray_ctx *ctx = together(MPI_COMM_WORLD, directory, &w, (icoray_config){0});
    set_scene(ctx, 48, "");
    return ctx;
}

/* A frame that all draw. */
static void good(icoray_ctx *ctx)
{
    step++;
    OK(icoray_execute(ctx, step, 0.0, NULL));
}

/* Wrong arguments of a call, or earlier failures, on the odd rank. */
static void at_execute(int odd)
{
    icoray_ctx *ctx = fresh();
    const char *text = by_rank(odd);
    int32_t wants = 0;
    int is_odd = rank == odd;
    float kept;
    icoray_array other = w.array;
    good(ctx);

    ALL_REFUSED(ARGUMENT, text, icoray_execute(ctx, step + 1, is_odd ? NAN : 0.0, NULL));
    good(ctx);

    /* Arguments that differ between ranks; if rank 0 is the odd one, rank 1 is the first that differs from it. */
    ALL_REFUSED(MPI, odd == 0 ? "rank 1: step" : text, icoray_execute(ctx, step + 1 + is_odd, 0.0, NULL));
    ALL_REFUSED(MPI, "time_s", icoray_execute(ctx, step + 1, is_odd ? 60.0 : 0.0, NULL));
    good(ctx);
    ALL_REFUSED(MPI, "call", is_odd ? icoray_wait(ctx) : icoray_execute(ctx, step + 1, 0.0, NULL));
    good(ctx);

    /* The scene is rank 0's on all; one that is refused leaves all with the one before. */
    set_scene(ctx, 48 + rank, rank == 0 ? "" : "every = 1000");
    OK(icoray_wants(ctx, step + 1, 0.0, &wants));
    CHECK(wants == 1);
    good(ctx);
    ALL_REFUSED(SCENE, "rank 0: ", icoray_scene_text(ctx, rank == 0 ? "field = 1" : ""));
    ALL_REFUSED(NULL, text, icoray_scene_text(ctx, is_odd ? NULL : ""));
    ALL_REFUSED(NULL, text, icoray_scene_load(ctx, is_odd ? NULL : "/dev/null"));
    ALL_REFUSED(IO, "rank 0: nowhere/0: cannot read", icoray_scene_load(ctx, rank == 0 ? "nowhere/0" : ""));
    good(ctx);
    ALL_REFUSED(MPI, "call", is_odd ? icoray_scene_text(ctx, "") : icoray_execute(ctx, step + 1, 0.0, NULL));
    good(ctx);

    /* Other data: their shape, and their values. */
    other.columns = is_odd ? other.columns - 1 : other.columns;
    OK(icoray_field_set(ctx, "f", &other));
    ALL_REFUSED(FIELD, text, icoray_execute(ctx, step + 1, 0.0, NULL));
    OK(icoray_field_set(ctx, "f", &w.array));
    kept = w.values[5];
    w.values[5] += is_odd ? 100.0f : 0.0f;
    ALL_REFUSED(MPI, "\"f\" with values of hash", icoray_execute(ctx, step + 1, 0.0, NULL));
    w.values[5] = kept;
    good(ctx);
    OK(icoray_close(&ctx));
}

/* Inputs that were never given, or were refused. */
static void before_execute(int odd)
{
    icoray_config config = plain(directory);
    icoray_grid bad = w.grid;
    const char *text = by_rank(odd);
    int is_odd = rank == odd;
    icoray_ctx *ctx = opened_by_all(&config);
    /* The scene is checked first, before its inputs. */
    ALL_REFUSED(ORDER, "rank 0: ", icoray_execute(ctx, step + 1, 0.0, NULL));
    set_scene(ctx, 48, "");
    set_layers(ctx, w.layers);
    OK(icoray_field_set(ctx, "f", &w.array));
    bad.edges = is_odd ? bad.edges - 1 : bad.edges;
    CHECK(icoray_grid_set(ctx, &bad) == (is_odd ? ICORAY_ERR_GRID : ICORAY_OK));
    ALL_REFUSED(ORDER, text, icoray_execute(ctx, step + 1, 0.0, NULL));
    OK(icoray_grid_set(ctx, &w.grid));
    good(ctx);
    OK(icoray_close(&ctx));

    /* A field that one rank does not have. */
    ctx = opened_by_all(&config);
    OK(icoray_grid_set(ctx, &w.grid));
    set_layers(ctx, w.layers);
    set_scene(ctx, 48, "");
    OK(icoray_field_set(ctx, is_odd ? "g" : "f", &w.array));
    ALL_REFUSED(FIELD, text, icoray_execute(ctx, step + 1, 0.0, NULL));
    OK(icoray_field_set(ctx, "f", &w.array));
    good(ctx);
    OK(icoray_close(&ctx));
}

/* Contexts that cannot be opened. */
static void at_open(int odd)
{
    icoray_config config = plain(directory);
    icoray_ctx *ctx = NULL;
    int32_t comm = EVERYONE;
    const char *text = by_rank(odd);
    int is_odd = rank == odd;
    ALL_REFUSED(NULL, text, icoray_open(is_odd ? NULL : &config, comm, &ctx));
    ALL_REFUSED(NULL, text, icoray_open(&config, comm, is_odd ? NULL : &ctx));
    CHECK(ctx == NULL);
    config.struct_size -= (size_t)is_odd;
    ALL_REFUSED(STRUCT_SIZE, text, icoray_open(&config, comm, &ctx));
    config.struct_size = sizeof config;
    config.threads = is_odd ? -1 : 1;
    ALL_REFUSED(ARGUMENT, text, icoray_open(&config, comm, &ctx));
    config.threads = 1;
    config.async_render = is_odd;
    ALL_REFUSED(MPI, "async_render", icoray_open(&config, comm, &ctx));
    CHECK(ctx == NULL);
}

/* A panic on one rank breaks the context of all. */
static void inside(int odd)
{
    World other = at_corners(&w);
    icoray_ctx *ctx = together(MPI_COMM_WORLD, directory, &other, (icoray_config){0});
    int32_t wants = 1;
    set_scene(ctx, 48, "");
    good(ctx);
    ALL_REFUSED(INTERNAL, by_rank(odd), execute_spoilt(ctx, &other.grid, step + 1, rank == odd));
    ALL_REFUSED(INTERNAL, "accepts no more calls", icoray_execute(ctx, step + 1, 0.0, NULL));
    CHECK(icoray_wants(ctx, step + 1, 0.0, &wants) == ICORAY_ERR_INTERNAL && wants == 0);
    ALL_REFUSED(INTERNAL, "accepts no more calls", icoray_wait(ctx));
    OK(icoray_close(&ctx));
    free(other.values);
    ctx = fresh();
    good(ctx);
    OK(icoray_close(&ctx));
}

/* A model that closes on the failed rank and continues on the others: no rank waits for the closed one. */
static void leaves(int odd)
{
    icoray_ctx *ctx = fresh();
    good(ctx);
    if (rank == odd) {
        CHECK(icoray_layers_set(ctx, NULL) == ICORAY_ERR_NULL);
    }
    ALL_REFUSED(MPI, "call", rank == odd ? icoray_close(&ctx) : icoray_execute(ctx, step + 1, 0.0, NULL));
    if (rank != odd) {
        REFUSED(NULL, MPI, "has closed its context", icoray_execute(ctx, step + 1, 0.0, NULL));
        REFUSED(NULL, MPI, "has closed its context", icoray_wait(ctx));
        OK(icoray_close(&ctx));
    }
    CHECK(ctx == NULL);
    ctx = fresh();
    good(ctx);
    OK(icoray_close(&ctx));
}

/* Waits until so many frames have failed at rank 0, which writes them. Only rank 0 knows of them by itself. */
static void await_failures(icoray_ctx *ctx, uint64_t count)
{
    for (int i = 0; rank == 0 && i < 1000 * PATIENCE_S && report_of(ctx).frames_failed < count; i++) {
        rest_ms(1);
    }
    CHECK(report_of(ctx).frames_failed == (rank == 0 ? count : 0));
    MPI_Barrier(MPI_COMM_WORLD);
}

#define SCENE(file)                                                                                  \
    "field = \"f\"\n[camera]\nlon = 20\nlat = 35\ndistance = 3\n[transfer]\nmap = \"viridis\"\n"       \
    "range = [-1.5, 1.5]\nopacity = [[-1.5, 0.8], [1.5, 0.9]]\n[output]\nfile = \"" file "\"\n"

/* Where rank 0 cannot write, no rank opens a context; where another could not, it does not matter. */
static void refused_at_once(const char *late, const char *link)
{
    icoray_config config = plain(rank == 0 ? late : directory);
    icoray_ctx *ctx = NULL;
    int32_t comm = EVERYONE;
    ALL_REFUSED(IO, "rank 0: ", icoray_open(&config, comm, &ctx));
    CHECK(ctx == NULL);
    config = plain(rank == 0 ? directory : link);
    OK(icoray_open(&config, comm, &ctx));
    OK(icoray_close(&ctx));
}

/* A directory at rank 0 that cannot be made: the next call of each kind returns the error on all ranks, once. */
static void at_the_disk(void)
{
    icoray_ctx *ctx;
    const char *path = path_of(directory, "late"), *late = path_of(path, "pictures");
    int32_t wants = 0;
    icoray_config config = {.on_error = ICORAY_DISABLE, .disable_after = 4};
    ctx = together(MPI_COMM_WORLD, late, &w, config);
    set_scene(ctx, 48, "every = 10\n");
    if (rank == 0) {
        CHECK(symlink("nowhere/at/all", path) == 0);
    }
    MPI_Barrier(MPI_COMM_WORLD);
    /* Looked at when a context is opened or a scene is loaded, at rank 0 alone. */
    refused_at_once(late, path);
    ALL_REFUSED(IO, "rank 0: ", icoray_scene_text(ctx, SCENE("never.png")));
    OK(icoray_execute(ctx, 10, 0.0, NULL));
    ALL_REFUSED(IO, "step 10: ", icoray_wait(ctx));
    OK(icoray_wait(ctx));

    /* By a call that draws another frame, or none. */
    OK(icoray_execute(ctx, 20, 0.0, NULL));
    await_failures(ctx, 2);
    ALL_REFUSED(IO, "step 20: ", icoray_execute(ctx, 30, 0.0, NULL));
    await_failures(ctx, 3);
    ALL_REFUSED(IO, "step 30: ", icoray_execute(ctx, 31, 0.0, NULL));
    OK(icoray_execute(ctx, 32, 0.0, NULL));

    /* The fourth in a row switches all off. */
    OK(icoray_wants(ctx, 40, 0.0, &wants));
    CHECK(wants == 1);
    OK(icoray_execute(ctx, 40, 0.0, NULL));
    await_failures(ctx, 4);
    OK(icoray_wants(ctx, 50, 0.0, &wants));
    CHECK(wants == 1); /* the same on all until they have talked */
    ALL_REFUSED(DISABLED, "4 failures in a row", icoray_execute(ctx, 50, 0.0, NULL));
    OK(icoray_wants(ctx, 60, 0.0, &wants));
    CHECK(wants == 0);
    ALL_REFUSED(DISABLED, "4 failures in a row", icoray_execute(ctx, 60, 0.0, NULL));
    ALL_REFUSED(IO, "step 40: ", icoray_close(&ctx));
    CHECK(ctx == NULL);
    if (rank == 0) {
        CHECK(unlink(path) == 0);
    }

    /* A picture that is there. */
    ctx = fresh();
    DRAW(ctx, step + 1, 0.0, NULL);
    ALL_REFUSED(EXISTS, "rank 0: ", icoray_execute(ctx, step + 1, 0.0, NULL));
    step++;
    good(ctx);
    OK(icoray_close(&ctx));
}

/* Each half of the ranks draws its own pictures, in two contexts that are open beside one of all. */
static void apart(void)
{
    MPI_Comm half;
    icoray_ctx *all = fresh(), *one, *other;
    const char *path = text_of("%s/half_%d", directory, rank % 2);
    int size;
    MPI_Comm_split(MPI_COMM_WORLD, rank % 2, -rank, &half);
    MPI_Comm_size(half, &size);
    one = together(half, path, &w, (icoray_config){0});
    other = together(half, path, &w, (icoray_config){0});
    MPI_Comm_free(&half); /* was duplicated */
    set_scene(one, 31 + rank % 2, "");
    set_scene(other, 33, "");
    good(all);
    OK(icoray_execute(one, 1, 0.0, NULL));
    OK(icoray_execute(other, 2, 0.0, NULL));
    good(all);
    CHECK(report_of(one).ranks == size && report_of(all).ranks == ranks);
    OK(icoray_close(&other));
    OK(icoray_close(&all));
    OK(icoray_close(&one));
}

int main(int argc, char **argv)
{
    begin(&argc, &argv);
    directory = argv[1];
    w = world(3, 4);
    for (int odd = 0; odd < ranks; odd += ranks - 1) {
        trying = odd == 0 ? "rank 0" : "the last rank";
        at_open(odd);
        before_execute(odd);
        at_execute(odd);
        inside(odd);
        leaves(odd);
    }
    trying = "the disk";
    at_the_disk();
    trying = "halves";
    apart();
    end_world(&w);
    return end("mpi_refusals");
}
