/*
 * Every call that the ABI refuses, with its status and message: refusals <directory>
 *
 * After each group of refused calls the context still draws what was set before.
 */
#include "refusals.h"

/* In this order. */
static Part *const parts[] = {
    nulls,    struct_sizes, misaligned, grids,  bad_tables, wide_tables, bad_places, layers,   arrays,
    ndarrays, misfits,      names,      scenes, wants,      times,       dates,      error_maps, messages,
    grid_parts, heights,
};

static LonePart *const lone_parts[] = {
    openings, restarts, time_levels, existing, overwritten, in_the_way, blocked, returned_once, dropped,
    switched_off, busy, forked, logged, long_messages, given_and_refused, standard_error,
};

int main(int argc, char **argv)
{
    if (argc != 2) {
        printf("refusals <directory>\n");
        return EXIT_FAILURE;
    }
    CHECK(strcmp(icoray_version(), "") != 0);
    prepare(argv[1]);
    order();
    ndarrays_too_early();
    fields_of_scenes();
    empty_scenes();
    icoray_ctx *ctx = filled();
    still_draws(ctx);
    for (size_t i = 0; i < COUNT(parts); i++) {
        parts[i](ctx);
        still_draws(ctx);
    }
    for (size_t i = 0; i < COUNT(lone_parts); i++) {
        lone_parts[i]();
        trying = "";
    }
    still_draws(ctx);
    OK(icoray_close(&ctx));
    clean_up();
    return verdict("refusals");
}
