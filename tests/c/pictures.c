/*
 * Pictures through the ABI: pictures <directory> <level> <pixels>
 *
 * A picture's name is its group and its step. abi.rs compares the pixels: those of a group are equal, for any
 * layout, context, directory and thread; those of different groups are not.
 */
#include "pictures.h"

static Part *const parts[] = {
    layouts, ndarrays, swapped, missing, places, tables, names, by_turns, at_once, background, fields,
};

int main(int argc, char **argv)
{
    if (argc != 4) {
        printf("pictures <directory> <level> <pixels>\n");
        return EXIT_FAILURE;
    }
    int before = threads_now();
    make_mesh(atoi(argv[2]));
    pixels = atoi(argv[3]);
    CHECK(corners == 2 * cells - 4 && grid.edges == 3 * (int64_t)cells - 6);
    CHECK(grid.index_base == 0 && grid.index_type == ICORAY_I32 && grid.real_type == ICORAY_F64);
    CHECK(grid.cell_corner_row == 6 && grid.cell_corner_count == NULL && grid.name == NULL);
    CHECK(settles_at(before));

    in_place(argv[1]);
    CHECK(settles_at(before));
    icoray_ctx *ctx = context(argv[1], "unused", 3);
    CHECK(settles_at(before + 3 + 1)); /* as many as were asked for, and one that writes */
    OK(icoray_close(&ctx));
    for (size_t i = 0; i < COUNT(parts); i++) {
        parts[i](argv[1]);
    }
    CHECK(settles_at(before)); /* none is left behind */

    OK(icoray_mesh_free(&mesh));
    CHECK(mesh == NULL);
    return verdict("pictures");
}
