/* Calls before MPI is initialised and after its end, and a library without MPI: mpi_ends DIRECTORY [without]. */
#include "mpi_common.h"

int main(int argc, char **argv)
{
    icoray_config config = plain(argv[1]);
    icoray_ctx *ctx = NULL, *left = NULL;
    World w = world(2, 3);
    if (argc > 2 && strcmp(argv[2], "without") == 0) {
        MPI_Init(&argc, &argv);
        REFUSED(NULL, UNSUPPORTED, "built without MPI",
                icoray_open(&config, EVERYONE, &ctx));
        CHECK(ctx == NULL);
        MPI_Finalize();
        end_world(&w);
        return verdict("mpi_ends");
    }
    REFUSED(NULL, MPI, "not initialised", icoray_open(&config, 0, &ctx));
    CHECK(ctx == NULL);
    begin(&argc, &argv);
    REFUSED(NULL, MPI, "no communicator", icoray_open(&config, 987654, &ctx));
    REFUSED(NULL, MPI, "no communicator", icoray_open(&config, -1, &ctx));
    REFUSED(NULL, MPI, "no communicator", icoray_open(&config, (int32_t)MPI_Comm_c2f(MPI_COMM_NULL), &ctx));
    CHECK(ctx == NULL);
    left = together(MPI_COMM_WORLD, argv[1], &w, (icoray_config){0});
    set_scene(left, 40, "");
    OK(icoray_execute(left, 0, 0.0, NULL));
    MPI_Finalize();

    /* Earlier pictures are written, and no call of MPI follows. */
    REFUSED(left, MPI, "finalised", icoray_execute(left, 1, 0.0, NULL));
    OK(icoray_close(&left));
    CHECK(left == NULL);
    config = plain(argv[1]);
    REFUSED(NULL, MPI, "finalised already", icoray_open(&config, 0, &ctx));
    OK(icoray_open_serial(&config, &ctx));
    OK(icoray_close(&ctx));
    end_world(&w);
    if (rank != 0) {
        return failed_checks() == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
    }
    return verdict("mpi_ends");
}
