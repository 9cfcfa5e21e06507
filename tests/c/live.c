/*
 * A model that is watched: live DIRECTORY SCENE [parts|async]
 *
 * Draws a step for each line of its standard input, and says so on its standard output.
 */
#ifdef LIVE_MPI
#include "mpi_cut.h"
#else
#include "host.h"
static const int rank = 0;
#endif

/* Whether rank 0 is told to go on. */
static int goes_on(void)
{
    char line[16];
    int is_more = rank == 0 && fgets(line, sizeof line, stdin) != NULL;
#ifdef LIVE_MPI
    MPI_Bcast(&is_more, 1, MPI_INT, 0, MPI_COMM_WORLD);
#endif
    return is_more;
}

static void run(icoray_ctx *ctx, const char *scene)
{
    OK(icoray_field_describe(ctx, "f", "a field", "K"));
    OK(icoray_scene_load(ctx, scene));
    for (int step = 0; goes_on(); step++) {
        OK(icoray_execute(ctx, step, 60.0 * step, NULL));
        OK(icoray_wait(ctx));
        if (rank == 0) {
            printf("step %d\n", step);
            fflush(stdout);
        }
    }
    OK(icoray_close(&ctx));
}

int main(int argc, char **argv)
{
    icoray_config config = CONFIG(.threads = 1, .log = icoray_log_stderr, .log_level = ICORAY_LOG_INFO);
    World w;
    const char *way = argc > 3 ? argv[3] : "";
    config.async_render = strcmp(way, "async") == 0;
#ifdef LIVE_MPI
    begin(&argc, &argv);
    w = world(3, HOST_LAYERS);
    if (strcmp(way, "parts") == 0) {
        int *owner = partition(&w, RANDOM, ranks);
        Cut mine = cut(&w, owner, rank, 1);
        config.output_dir = argv[1];
        icoray_ctx *ctx = opened_by_all(&config);
        fill_cut(ctx, &mine, w.layers);
        OK(icoray_part_set(ctx, &mine.part));
        run(ctx, argv[2]);
        end_cut(&mine);
        free(owner);
    } else {
        run(together(MPI_COMM_WORLD, argv[1], &w, config), argv[2]);
    }
    end_world(&w);
    return end("mpi_live");
#else
    config.output_dir = argv[1];
    w = world(3, HOST_LAYERS);
    run(opened(&config, &w, 16), argv[2]);
    end_world(&w);
    return verdict("live");
#endif
}
