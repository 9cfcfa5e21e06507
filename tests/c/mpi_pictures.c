/*
 * Pictures that ranks draw together, and the same ones drawn by one process without MPI: mpi_pictures DIRECTORY [serial].
 * Files of the same names are to be the same.
 */
#include "mpi_common.h"

typedef struct {
    const char *name, *more, *file;
    int width, height;
} Case;

static const Case CASES[] = {
    {"plain", "", "plain_{step}.png", 96, 96},
    {"odd", "", "odd_{step}.exr\"\nerror = \"odd_error_{step}.png", 157, 61},
    {"lit", "[light]\nkind = \"headlight\"\n", "lit_{step}.exr\"\nerror = \"lit_error_{step}.png", 130, 97},
    {"wide", "precision = \"f64\"\nmethod = \"paper\"\n", "wide_{step}.png", 64, 33},
    {"tiny", "", "tiny_{step}.exr", 1, 1},
    {"short", "time_budget_ms = 1\n[light]\nkind = \"headlight\"\n", "short_{step}.png", 700, 500},
};

static void set(icoray_ctx *ctx, const Case *c)
{
    int is_top = strncmp(c->more, "[", 1) != 0;
    const char *rest = text_of("[output]\nfile = \"%s\"\n%s", c->file, is_top ? "" : c->more);
    set_view(ctx, is_top ? c->more : "", c->width, c->height, rest);
}

/* Frames of all cases, thrice: dealt blindly, and by what tiles cost. */
static void draw(icoray_ctx *ctx, int of)
{
    int64_t step = 0;
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        trying = CASES[i].name;
        set(ctx, &CASES[i]);
        for (int k = 0; k < 3; k++, step++) {
            icoray_frame_report report;
            int32_t wants = 0;
            int tiles;
            OK(icoray_wants(ctx, step, 0.0, &wants));
            CHECK(wants == 1);
            OK(icoray_execute(ctx, step, 60.0 * (double)step, NULL));
            report = report_of(ctx);
            CHECK(report.step == step && report.ranks == of && report.rays > 0);
            CHECK(report.balance > 0.0 && report.balance <= 1.0 + 1e-9 && report.gather_s >= 0.0);
            CHECK(report.bytes_copied == 0);
            CHECK((report.pixel_step > 1) == (strcmp(CASES[i].name, "short") == 0));
            tiles = report.tiles;
            if (of > 1) {
                double same[6] = {(double)report.rays, (double)report.frusta, report.error_max,
                                  report.error_mean, report.balance, (double)report.bytes_received};
                double roots[6];
                memcpy(roots, same, sizeof roots);
                MPI_Bcast(roots, 6, MPI_DOUBLE, 0, MPI_COMM_WORLD);
                CHECK(memcmp(roots, same, sizeof roots) == 0);
                MPI_Allreduce(MPI_IN_PLACE, &tiles, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
                CHECK(tiles == 1 || (report.bytes_received > 0 && report.bytes_received < 20000000));
            }
            CHECK(tiles >= 1);
            if (rank == 0 && (k == 2 || report.pixel_step > 1)) {
                printf("note: %s: %d ranks, balance %.2f, %.1f kB received, gathered in %.2f of %.2f ms, one of %d "
                       "pixels\n", trying, of, report.balance, (double)report.bytes_received / 1e3,
                       report.gather_s * 1e3, report.host_s * 1e3, report.pixel_step);
            }
        }
    }
    OK(icoray_wait(ctx));
    if (rank == 0) {
        icoray_frame_report report = report_of(ctx);
        CHECK(report.frames_written == (uint64_t)step && report.frames_failed == 0);
    }
}

int main(int argc, char **argv)
{
    int is_serial = argc > 2 && strcmp(argv[2], "serial") == 0;
    if (!is_serial) {
        begin(&argc, &argv);
    }
    World w = world(5, 6);
    icoray_ctx *ctx = is_serial ? alone(argv[1], &w) : together(MPI_COMM_WORLD, argv[1], &w, (icoray_config){0});
    draw(ctx, is_serial ? 1 : ranks);
    OK(icoray_close(&ctx));
    CHECK(ctx == NULL);
    end_world(&w);
    return is_serial ? verdict("mpi_pictures") : end("mpi_pictures");
}
