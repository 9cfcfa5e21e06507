/*
 * A long run: host_steps <directory> <frames>
 *
 * Many frames, with fields, scenes and grids given anew, take no more memory at the end than near the start.
 */
#define _GNU_SOURCE

#include "host.h"

#include <unistd.h>

#define WARM 500
#define MOST_KB 1024

/* Summed over the mappings where the system does so; the count in statm lags behind. */
static long resident_kb(void)
{
    char line[256];
    long kb = 0, pages;
    FILE *file = fopen("/proc/self/smaps_rollup", "r");
    while (file != NULL && kb == 0 && fgets(line, sizeof line, file) != NULL) {
        sscanf(line, "Rss: %ld", &kb);
    }
    if (file != NULL) {
        fclose(file);
    }
    if (kb == 0 && (file = fopen("/proc/self/statm", "r")) != NULL) {
        if (fscanf(file, "%*s %ld", &pages) == 1) {
            kb = pages * (sysconf(_SC_PAGESIZE) / 1024);
        }
        fclose(file);
    }
    return kb;
}

static void run(const char *directory, const World *w, int steps, int async)
{
    double start = now_s();
    long before = 0;
    icoray_config config = CONFIG(.output_dir = path_of(directory, async ? "async" : "sync"),
                                  .existing = ICORAY_OVERWRITE, .async_render = async, .threads = 1);
    icoray_ctx *ctx = opened(&config, w, 16);
    for (int step = 0; step < steps; step++) {
        if (step == WARM) {
            OK(icoray_wait(ctx));
            before = resident_kb();
        }
        if (icoray_field_set(ctx, "f", &w->array) != ICORAY_OK ||
            icoray_execute(ctx, step % 4, step, "2000-01-01_00:00:00") != ICORAY_OK) {
            CHECK(0);
            break;
        }
        if (step % 10 == 3) {
            set_scene(ctx, 16, step % 20 == 3 ? "" : "background = \"black\"");
        }
        if (step % 10 == 7) {
            OK(icoray_grid_set(ctx, &w->grid));
        }
        if (step % 100 == 50) { /* failures leave nothing behind either */
            CHECK(icoray_scene_text(ctx, "nothing") == ICORAY_ERR_SCENE);
            CHECK(icoray_execute(ctx, step, 0.0, "no date") != ICORAY_ERR_INTERNAL);
        }
    }
    icoray_wait(ctx);
    long growth = resident_kb() - before;
    CHECK(before > 0 && growth < MOST_KB);
    CHECK(report_of(ctx).frames_written >= (uint64_t)steps);
    icoray_close(&ctx);
    note("%s: %d steps in %.1f s, resident memory grew by %ld KiB from %ld", async ? "async" : "sync", steps,
         now_s() - start, growth, before);
}

int main(int argc, char **argv)
{
    int steps = argc == 3 ? atoi(argv[2]) : 0;
    if (steps <= WARM) {
        return EXIT_FAILURE;
    }
    World w = world(1, HOST_LAYERS);
    run(argv[1], &w, steps, 0);
    run(argv[1], &w, steps, 1);
    /* The look can fail. */
    long before = resident_kb();
    volatile char *lost = malloc(16 << 20);
    for (int i = 0; i < 16 << 20; i += 512) {
        lost[i] = 1;
    }
    CHECK(resident_kb() - before >= MOST_KB);
    free((void *)lost);
    end_world(&w);
    return verdict("host_steps");
}
