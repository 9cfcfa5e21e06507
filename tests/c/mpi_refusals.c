/* What goes wrong on one rank only is the same status on all, nobody waits for ever, and the next frame is drawn. */
#define _POSIX_C_SOURCE 200809L /* symlink */

#include "mpi_common.h"

#include <math.h>
#include <unistd.h>

static const char *directory;
static World w;
static int64_t step;

static icoray_ctx *fresh(void)
{
    icoray_config config;
    icoray_ctx *ctx;
    memset(&config, 0, sizeof config);
    ctx = together(MPI_COMM_WORLD, directory, &w, config);
    set_scene(ctx, 48, "");
    return ctx;
}

/* A frame that all draw. */
static void good(icoray_ctx *ctx)
{
    step++;
    OK(icoray_execute(ctx, step, 0.0, NULL));
}

/* What is wrong in the call itself or was before, on the rank that is odd. */
static void at_execute(int odd)
{
    icoray_ctx *ctx = fresh();
    char text[64];
    int32_t wants = 0;
    int is_odd = rank == odd;
    icoray_array other = w.array;
    snprintf(text, sizeof text, "rank %d: ", odd);
    good(ctx);

    TOLD(ICORAY_ERR_ARGUMENT, text, icoray_execute(ctx, step + 1, is_odd ? NAN : 0.0, NULL));
    good(ctx);

    /* Not of one mind; where that is rank 0, rank 1 is the first to differ. */
    TOLD(ICORAY_ERR_MPI, odd == 0 ? "rank 1: step" : text, icoray_execute(ctx, step + 1 + is_odd, 0.0, NULL));
    TOLD(ICORAY_ERR_MPI, "time_s", icoray_execute(ctx, step + 1, is_odd ? 60.0 : 0.0, NULL));
    good(ctx);
    TOLD(ICORAY_ERR_MPI, "call", is_odd ? icoray_wait(ctx) : icoray_execute(ctx, step + 1, 0.0, NULL));
    good(ctx);

    /* The scene is rank 0's on all; one that is refused leaves all with the one before. */
    set_scene(ctx, 48 + rank, rank == 0 ? "" : "every = 1000");
    OK(icoray_wants(ctx, step + 1, 0.0, &wants));
    CHECK(wants == 1);
    good(ctx);
    TOLD(ICORAY_ERR_SCENE, "rank 0: ", icoray_scene_text(ctx, rank == 0 ? "field = 1" : ""));
    TOLD(ICORAY_ERR_NULL, text, icoray_scene_text(ctx, is_odd ? NULL : ""));
    TOLD(ICORAY_ERR_NULL, text, icoray_scene_load(ctx, is_odd ? NULL : "/dev/null"));
    TOLD(ICORAY_ERR_IO, "rank 0: nowhere/0: cannot read", icoray_scene_load(ctx, rank == 0 ? "nowhere/0" : ""));
    good(ctx);
    TOLD(ICORAY_ERR_MPI, "call", is_odd ? icoray_scene_text(ctx, "") : icoray_execute(ctx, step + 1, 0.0, NULL));
    good(ctx);

    /* Other data: their shape, and their values. */
    other.columns = is_odd ? other.columns - 1 : other.columns;
    OK(icoray_field_set(ctx, "f", &other));
    TOLD(ICORAY_ERR_FIELD, text, icoray_execute(ctx, step + 1, 0.0, NULL));
    OK(icoray_field_set(ctx, "f", &w.array));
    if (is_odd) {
        w.values[5] += 100.0f;
    }
    TOLD(ICORAY_ERR_MPI, "field of range", icoray_execute(ctx, step + 1, 0.0, NULL));
    if (is_odd) {
        w.values[5] -= 100.0f;
    }
    good(ctx);
    OK(icoray_close(&ctx));
}

/* What was never given, or was refused. */
static void before_execute(int odd)
{
    icoray_config config;
    icoray_ctx *ctx = NULL;
    icoray_grid bad = w.grid;
    char text[64];
    int is_odd = rank == odd;
    snprintf(text, sizeof text, "rank %d: ", odd);
    config = plain(directory);
    OK(icoray_open(&config, (int32_t)MPI_Comm_c2f(MPI_COMM_WORLD), &ctx));
    /* What is to be drawn is asked first, before what it is drawn of. */
    TOLD(ICORAY_ERR_ORDER, "rank 0: ", icoray_execute(ctx, step + 1, 0.0, NULL));
    set_scene(ctx, 48, "");
    set_layers(ctx, w.layers);
    OK(icoray_field_set(ctx, "f", &w.array));
    bad.edges = is_odd ? bad.edges - 1 : bad.edges;
    CHECK(icoray_grid_set(ctx, &bad) == (is_odd ? ICORAY_ERR_GRID : ICORAY_OK));
    TOLD(ICORAY_ERR_ORDER, text, icoray_execute(ctx, step + 1, 0.0, NULL));
    OK(icoray_grid_set(ctx, &w.grid));
    good(ctx);
    OK(icoray_close(&ctx));

    /* A field that one rank does not have. */
    OK(icoray_open(&config, (int32_t)MPI_Comm_c2f(MPI_COMM_WORLD), &ctx));
    OK(icoray_grid_set(ctx, &w.grid));
    set_layers(ctx, w.layers);
    set_scene(ctx, 48, "");
    OK(icoray_field_set(ctx, is_odd ? "g" : "f", &w.array));
    TOLD(ICORAY_ERR_FIELD, text, icoray_execute(ctx, step + 1, 0.0, NULL));
    OK(icoray_field_set(ctx, "f", &w.array));
    good(ctx);
    OK(icoray_close(&ctx));
}

/* Contexts that cannot be opened. */
static void at_open(int odd)
{
    icoray_config config = plain(directory);
    icoray_ctx *ctx = NULL;
    int32_t comm = (int32_t)MPI_Comm_c2f(MPI_COMM_WORLD);
    char text[64];
    int is_odd = rank == odd;
    snprintf(text, sizeof text, "rank %d: ", odd);
    TOLD(ICORAY_ERR_NULL, text, icoray_open(is_odd ? NULL : &config, comm, &ctx));
    TOLD(ICORAY_ERR_NULL, text, icoray_open(&config, comm, is_odd ? NULL : &ctx));
    CHECK(ctx == NULL);
    config.struct_size -= (size_t)is_odd;
    TOLD(ICORAY_ERR_STRUCT_SIZE, text, icoray_open(&config, comm, &ctx));
    config.struct_size = sizeof config;
    config.threads = is_odd ? -1 : 1;
    TOLD(ICORAY_ERR_ARGUMENT, text, icoray_open(&config, comm, &ctx));
    config.threads = 1;
    config.async_render = is_odd;
    TOLD(ICORAY_ERR_MPI, "async_render", icoray_open(&config, comm, &ctx));
    CHECK(ctx == NULL);
}

/* A table that a rank's model has spoilt behind icoray's back: a panic on that rank, which breaks the context of all. */
static void inside(int odd)
{
    icoray_ctx *ctx = fresh();
    int32_t *table = (int32_t *)(uintptr_t)w.grid.corner_cell;
    size_t count = 3 * (size_t)w.grid.corners;
    int32_t *kept = malloc(count * sizeof *kept);
    int32_t wants = 1;
    char text[64];
    snprintf(text, sizeof text, "rank %d: ", odd);
    memcpy(kept, table, count * sizeof *kept);
    good(ctx);
    for (size_t i = 0; rank == odd && i < count; i++) {
        table[i] = 1 << 30;
    }
    TOLD(ICORAY_ERR_INTERNAL, text, icoray_execute(ctx, step + 1, 0.0, NULL));
    memcpy(table, kept, count * sizeof *kept);
    free(kept);
    TOLD(ICORAY_ERR_INTERNAL, "accepts no more calls", icoray_execute(ctx, step + 1, 0.0, NULL));
    CHECK(icoray_wants(ctx, step + 1, 0.0, &wants) == ICORAY_ERR_INTERNAL && wants == 0);
    TOLD(ICORAY_ERR_INTERNAL, "accepts no more calls", icoray_wait(ctx));
    OK(icoray_close(&ctx));
    ctx = fresh();
    good(ctx);
    OK(icoray_close(&ctx));
}

/* A model that closes where something failed, and goes on elsewhere: nobody waits for the one that has left. */
static void leaves(int odd)
{
    icoray_ctx *ctx = fresh();
    good(ctx);
    if (rank == odd) {
        CHECK(icoray_layers_set(ctx, NULL) == ICORAY_ERR_NULL);
    }
    TOLD(ICORAY_ERR_MPI, "call", rank == odd ? icoray_close(&ctx) : icoray_execute(ctx, step + 1, 0.0, NULL));
    if (rank != odd) {
        REFUSED(NULL, ICORAY_ERR_MPI, "has closed its context", icoray_execute(ctx, step + 1, 0.0, NULL));
        REFUSED(NULL, ICORAY_ERR_MPI, "has closed its context", icoray_wait(ctx));
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
    for (int i = 0; rank == 0 && i < 30000 && report_of(ctx).frames_failed < count; i++) {
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
    int32_t comm = (int32_t)MPI_Comm_c2f(MPI_COMM_WORLD);
    TOLD(ICORAY_ERR_IO, "rank 0: ", icoray_open(&config, comm, &ctx));
    CHECK(ctx == NULL);
    config = plain(rank == 0 ? directory : link);
    OK(icoray_open(&config, comm, &ctx));
    OK(icoray_close(&ctx));
}

/* A directory at rank 0 that cannot be made: told on all ranks by the next call of each kind, once. */
static void at_the_disk(void)
{
    icoray_config config;
    icoray_ctx *ctx;
    char path[1024], late[1100];
    int32_t wants = 0;
    snprintf(path, sizeof path, "%s/late", directory);
    snprintf(late, sizeof late, "%s/pictures", path);
    memset(&config, 0, sizeof config);
    config.on_error = ICORAY_DISABLE;
    config.disable_after = 4;
    ctx = together(MPI_COMM_WORLD, late, &w, config);
    set_scene(ctx, 48, "every = 10\n");
    if (rank == 0) {
        CHECK(symlink("nowhere/at/all", path) == 0);
    }
    MPI_Barrier(MPI_COMM_WORLD);
    /* Looked at when a context is opened or a scene is loaded, at rank 0 alone. */
    refused_at_once(late, path);
    TOLD(ICORAY_ERR_IO, "rank 0: ", icoray_scene_text(ctx, SCENE("never.png")));
    OK(icoray_execute(ctx, 10, 0.0, NULL));
    TOLD(ICORAY_ERR_IO, "step 10: ", icoray_wait(ctx));
    OK(icoray_wait(ctx));

    /* By a call that draws another frame, or none. */
    OK(icoray_execute(ctx, 20, 0.0, NULL));
    await_failures(ctx, 2);
    TOLD(ICORAY_ERR_IO, "step 20: ", icoray_execute(ctx, 30, 0.0, NULL));
    await_failures(ctx, 3);
    TOLD(ICORAY_ERR_IO, "step 30: ", icoray_execute(ctx, 31, 0.0, NULL));
    OK(icoray_execute(ctx, 32, 0.0, NULL));

    /* The fourth in a row switches all off. */
    OK(icoray_wants(ctx, 40, 0.0, &wants));
    CHECK(wants == 1);
    OK(icoray_execute(ctx, 40, 0.0, NULL));
    await_failures(ctx, 4);
    OK(icoray_wants(ctx, 50, 0.0, &wants));
    CHECK(wants == 1); /* the same on all until they have talked */
    TOLD(ICORAY_ERR_DISABLED, "4 failures in a row", icoray_execute(ctx, 50, 0.0, NULL));
    OK(icoray_wants(ctx, 60, 0.0, &wants));
    CHECK(wants == 0);
    TOLD(ICORAY_ERR_DISABLED, "4 failures in a row", icoray_execute(ctx, 60, 0.0, NULL));
    TOLD(ICORAY_ERR_IO, "step 40: ", icoray_close(&ctx));
    CHECK(ctx == NULL);
    if (rank == 0) {
        CHECK(unlink(path) == 0);
    }

    /* A picture that is there. */
    ctx = fresh();
    OK(icoray_execute(ctx, step + 1, 0.0, NULL));
    OK(icoray_wait(ctx));
    TOLD(ICORAY_ERR_EXISTS, "rank 0: ", icoray_execute(ctx, step + 1, 0.0, NULL));
    step++;
    good(ctx);
    OK(icoray_close(&ctx));
}

/* Each half of the ranks draws its own pictures, in two contexts that are open beside one of all. */
static void apart(void)
{
    MPI_Comm half;
    icoray_config config;
    icoray_ctx *all = fresh(), *one, *other;
    char path[1024];
    int size;
    memset(&config, 0, sizeof config);
    MPI_Comm_split(MPI_COMM_WORLD, rank % 2, -rank, &half);
    MPI_Comm_size(half, &size);
    snprintf(path, sizeof path, "%s/half_%d", directory, rank % 2);
    one = together(half, path, &w, config);
    other = together(half, path, &w, config);
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
