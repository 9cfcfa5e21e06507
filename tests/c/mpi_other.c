/* A host that runs another MPI than the library was built for: mpi_other DIRECTORY. */
#include "mpi_common.h"

int main(int argc, char **argv)
{
    icoray_config config;
    icoray_ctx *ctx = NULL;
    World w = world(2, 3);
    begin(&argc, &argv);
    config = plain(argv[1]);
    REFUSED(NULL, UNSUPPORTED, "this library was built for",
            icoray_open(&config, EVERYONE, &ctx));
    CHECK(ctx == NULL);
    /* Alone it draws all the same, and the host's MPI is none the worse. */
    if (rank == 0) {
        OK(icoray_open_serial(&config, &ctx));
        fill(ctx, &w);
        set_scene(ctx, 40, "");
        OK(icoray_execute(ctx, 0, 0.0, NULL));
        OK(icoray_close(&ctx));
    }
    end_world(&w);
    return end("mpi_other");
}
