/*
 * Pictures that ranks draw together on GPUs: mpi_gpu DIRECTORY BACKEND [serial|mixed]. `mixed` hides all adapters from the
 * last rank.
 */
#define _POSIX_C_SOURCE 200809L /* setenv */

#include "mpi_common.h"

static void set(icoray_ctx *ctx, const char *backend, const char *name, const char *keys)
{
    set_view(ctx, text_of("backend = \"%s\"\n%s", backend, keys), 157, 101,
             text_of("[output]\nfile = \"%s_{step}.exr\"\n", name));
}

/* Thrice: dealt blindly, and by what tiles cost. */
static void draw(icoray_ctx *ctx, const char *backend, int drawn_on)
{
    static const char *const KEYS[] = {"", "core = \"transparent\"\n"};
    int64_t step = 0;
    for (int i = 0; i < 2; i++) {
        set(ctx, backend, i == 0 ? "core" : "hollow", KEYS[i]);
        for (int k = 0; k < 3; k++, step++) {
            icoray_frame_report report;
            OK(icoray_execute(ctx, step, 0.0, NULL));
            report = report_of(ctx);
            CHECK(report.tiles > 0 && report.drawn_on == drawn_on);
        }
    }
    OK(icoray_wait(ctx));
}

int main(int argc, char **argv)
{
    const char *directory = argc > 2 ? argv[1] : "", *backend = argc > 2 ? argv[2] : "cpu";
    const char *way = argc > 3 ? argv[3] : "";
    int drawn_on = strcmp(backend, "gpu") == 0 ? ICORAY_GPU : ICORAY_CPU;
    int is_serial = strcmp(way, "serial") == 0;
    World w = world(5, 6);
    if (!is_serial) {
        begin(&argc, &argv);
    }
    if (strcmp(way, "mixed") == 0 && rank == ranks - 1) {
        setenv("VK_DRIVER_FILES", "/none.json", 1);
        setenv("VK_ICD_FILENAMES", "/none.json", 1);
        drawn_on = ICORAY_CPU;
    }
    icoray_ctx *ctx = is_serial ? alone(directory, &w) : together(MPI_COMM_WORLD, directory, &w, (icoray_config){0});
    draw(ctx, backend, drawn_on);
    OK(icoray_close(&ctx));
    end_world(&w);
    return is_serial ? verdict("mpi_gpu") : end("mpi_gpu");
}
