/*
 * Everything that the ABI refuses, with the status and the words it has for it: refusals <directory>
 *
 * After each group of refused calls the context draws: what was set before is still there.
 */
#include "refusals.h"

/* The numbers are part of the ABI: a program that was compiled before must understand them. */
#define FIXED(name, number) typedef char fixed_##name[(name) == (number) ? 1 : -1]
FIXED(ICORAY_OK, 0);
FIXED(ICORAY_ERR_NULL, 1);
FIXED(ICORAY_ERR_STRUCT_SIZE, 2);
FIXED(ICORAY_ERR_ARGUMENT, 3);
FIXED(ICORAY_ERR_GRID, 4);
FIXED(ICORAY_ERR_UNSUPPORTED, 5);
FIXED(ICORAY_ERR_LAYERS, 6);
FIXED(ICORAY_ERR_FIELD, 7);
FIXED(ICORAY_ERR_SCENE, 8);
FIXED(ICORAY_ERR_ORDER, 9);
FIXED(ICORAY_ERR_IO, 10);
FIXED(ICORAY_ERR_INTERNAL, 11);
FIXED(ICORAY_ERR_EXISTS, 12);
FIXED(ICORAY_ERR_DISABLED, 13);
FIXED(ICORAY_ERR_BUSY, 14);
FIXED(ICORAY_ERR_FORKED, 15);
FIXED(ICORAY_ERR_MPI, 16);
FIXED(ICORAY_F32, 1);
FIXED(ICORAY_F64, 2);
FIXED(ICORAY_I32, 3);
FIXED(ICORAY_I64, 4);
FIXED(ICORAY_CENTER, 0);
FIXED(ICORAY_CORNER, 1);
FIXED(ICORAY_ALONE, 0);
FIXED(ICORAY_TILES, 1);
FIXED(ICORAY_FRAGMENTS, 2);
FIXED(ICORAY_CPU, 0);
FIXED(ICORAY_GPU, 1);
FIXED(ICORAY_GPU_AND_CPU, 2);
FIXED(ICORAY_NEVER_MODIFY, 0);
FIXED(ICORAY_OVERWRITE, 1);
FIXED(ICORAY_WARN, 0);
FIXED(ICORAY_IGNORE, 1);
FIXED(ICORAY_DISABLE, 2);
FIXED(ICORAY_BLOCK, 0);
FIXED(ICORAY_DROP_OLDEST, 1);
FIXED(ICORAY_LOG_OFF, 0);
FIXED(ICORAY_LOG_ERROR, 1);
FIXED(ICORAY_LOG_WARN, 2);
FIXED(ICORAY_LOG_INFO, 3);
FIXED(ICORAY_LOG_DEBUG, 4);
FIXED(ICORAY_MAX_RANK, 7);

/* The parts that share a context. */
static void (*const parts[])(icoray_ctx *) = {
    nulls,    struct_sizes, misaligned, grids,  bad_tables, wide_tables, bad_places, layers,   arrays,
    ndarrays, misfits,      names,      scenes, wants,      times,       dates,      error_maps, messages,
    grid_parts, heights,
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
    empty_scenes();
    icoray_ctx *ctx = filled();
    still_draws(ctx);
    for (size_t i = 0; i < COUNT(parts); i++) {
        parts[i](ctx);
        still_draws(ctx);
    }
    openings();
    restarts();
    time_levels();
    existing();
    overwritten();
    in_the_way();
    blocked();
    told_once();
    dropped();
    switched_off();
    busy();
    forked();
    logged();
    long_messages();
    given_and_refused();
    standard_error();
    still_draws(ctx);
    OK(icoray_close(&ctx));
    clean_up();
    return verdict("refusals");
}
