/*
 * A model with viewers: live DIRECTORY SCENE [parts|async|wants|large]
 *
 * Draws a step for each line of its standard input, and prints a line for it. With `wants` it has a field "g"
 * too, and computes in each step the fields that are wanted.
 */
#ifdef LIVE_MPI
#include "mpi_cut.h"
#else
#include "host.h"
static const int rank = 0;
#endif

/* Whether rank 0 reads another line, the request to go on. */
static int goes_on(void)
{
    char line[16];
    int is_more = rank == 0 && fgets(line, sizeof line, stdin) != NULL;
#ifdef LIVE_MPI
    MPI_Bcast(&is_more, 1, MPI_INT, 0, MPI_COMM_WORLD);
#endif
    return is_more;
}

/* Values of a field at a step, or the contents of an array that no scene needs. */
static void compute(float *values, size_t count, int step, float factor, int is_wanted)
{
    for (size_t i = 0; i < count; i++) {
        values[i] = is_wanted ? factor * ((float)((i * 7 + (size_t)step) % 31) / 10.0f - 1.5f) : 1e30f;
    }
}

/* Draws a step in the pattern of models with costly diagnostics, and sees that the fields stay as they are. */
static void execute_wanted(icoray_ctx *ctx, const World *w, float *fields[2], int step)
{
    static const char *const names[2] = {"f", "g"};
    size_t count = (size_t)w->grid.cells * (size_t)w->layers;
    float *before = allocate(2 * count, sizeof *before);
    int wants = 0;
    OK(icoray_wants(ctx, step, 60.0 * step, &wants));
    CHECK(wants);
    for (int k = 0; k < 2; k++) {
        OK(icoray_wants_field(ctx, names[k], step, 60.0 * step, &wants));
        compute(fields[k], count, step, k == 0 ? 1.0f : -0.5f, wants);
        memcpy(before + (size_t)k * count, fields[k], count * sizeof *before);
        icoray_array array = w->array;
        array.data = fields[k];
        OK(icoray_field_set(ctx, names[k], &array));
    }
    OK(icoray_execute(ctx, step, 60.0 * step, NULL));
    for (size_t k = 0; k < 2; k++) {
        CHECK(memcmp(before + k * count, fields[k], count * sizeof *before) == 0);
    }
    free(before);
}

static void run(icoray_ctx *ctx, const char *scene, const World *w, int is_wanted)
{
    float *fields[2];
    fields[0] = w->values;
    fields[1] = allocate((size_t)w->grid.cells * (size_t)w->layers, sizeof *fields[1]);
    OK(icoray_field_describe(ctx, "f", "a field", "K"));
    OK(icoray_scene_load(ctx, scene));
    for (int step = 0; goes_on(); step++) {
        if (is_wanted) {
            execute_wanted(ctx, w, fields, step);
        } else {
            OK(icoray_execute(ctx, step, 60.0 * step, NULL));
        }
        OK(icoray_wait(ctx));
        if (rank == 0) {
            printf("step %d\n", step);
            fflush(stdout);
        }
    }
    OK(icoray_close(&ctx));
    free(fields[1]);
}

int main(int argc, char **argv)
{
    icoray_config config = CONFIG(.threads = 1, .log = icoray_log_stderr, .log_level = ICORAY_LOG_WARN);
    World w;
    const char *way = argc > 3 ? argv[3] : "";
    int is_wanted = strcmp(way, "wants") == 0;
    config.async_render = strcmp(way, "async") == 0;
#ifdef LIVE_MPI
    begin(&argc, &argv);
    w = world(3, HOST_LAYERS);
    if (strcmp(way, "parts") == 0) {
        int *owner = partition(&w, ranks == 1 ? CONTIGUOUS : RANDOM, ranks);
        Cut mine = cut(&w, owner, rank, 1);
        config.output_dir = argv[1];
        icoray_ctx *ctx = opened_by_all(&config);
        fill_cut(ctx, &mine, w.layers);
        OK(icoray_part_set(ctx, &mine.part));
        run(ctx, argv[2], &w, 0);
        end_cut(&mine);
        free(owner);
    } else {
        run(together(MPI_COMM_WORLD, argv[1], &w, config), argv[2], &w, is_wanted);
    }
    end_world(&w);
    return end("mpi_live");
#else
    config.output_dir = argv[1];
    w = strcmp(way, "large") == 0 ? world(6, 32) : world(3, HOST_LAYERS);
    run(opened(&config, &w, 16), argv[2], &w, is_wanted);
    end_world(&w);
    return verdict("live");
#endif
}
