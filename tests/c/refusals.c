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
FIXED(ICORAY_F32, 1);
FIXED(ICORAY_F64, 2);
FIXED(ICORAY_CENTER, 0);
FIXED(ICORAY_CORNER, 1);

int main(int argc, char **argv)
{
    if (argc != 2) {
        printf("refusals <directory>\n");
        return EXIT_FAILURE;
    }
    CHECK(strcmp(icoray_version(), "") != 0);
    prepare(argv[1]);
    order();
    icoray_ctx *ctx = filled();
    still_draws(ctx);
    nulls(ctx);
    still_draws(ctx);
    struct_sizes(ctx);
    still_draws(ctx);
    openings();
    grids(ctx);
    still_draws(ctx);
    bad_tables(ctx);
    still_draws(ctx);
    layers(ctx);
    still_draws(ctx);
    arrays(ctx);
    still_draws(ctx);
    misfits(ctx);
    still_draws(ctx);
    scenes(ctx);
    still_draws(ctx);
    dates(ctx);
    error_maps(ctx);
    still_draws(ctx);
    messages(ctx);
    still_draws(ctx);
    blocked();
    still_draws(ctx);
    OK(icoray_close(&ctx));
    clean_up();
    return verdict("refusals");
}
