/*
 * Pictures through the ABI: pictures <directory> <level> <pixels>
 *
 * A picture's name is its group and its step. abi.rs compares the pixels: those of a group are equal, whatever the
 * layout, the context, the directory or the thread; those of different groups are not.
 */
#define _POSIX_C_SOURCE 200809L /* nanosleep, opendir */

#include "pictures.h"

#include <dirent.h>
#include <time.h>

/* Threads of this process, or -1 where that is not to be known. */
static int threads(void)
{
    int count = 0;
    DIR *tasks = opendir("/proc/self/task");
    if (tasks == NULL) {
        return -1;
    }
    for (struct dirent *task; (task = readdir(tasks)) != NULL;) {
        count += task->d_name[0] != '.';
    }
    closedir(tasks);
    return count;
}

/* Whether there are that many threads, at the latest after a while: threads that are told to end do so later. */
static int settles_at(int expected)
{
    struct timespec wait = {0, 5000000};
    for (int i = 0; i < 1000; i++) {
        int now = threads();
        if (now == -1 || now == expected) {
            return 1;
        }
        nanosleep(&wait, NULL);
    }
    return 0;
}

int main(int argc, char **argv)
{
    if (argc != 4) {
        printf("pictures <directory> <level> <pixels>\n");
        return EXIT_FAILURE;
    }
    int before = threads();
    OK(icoray_mesh_create(atoi(argv[2]), &mesh));
    grid.struct_size = sizeof grid;
    OK(icoray_mesh_grid(mesh, &grid));
    cells = (int)grid.cells;
    corners = (int)grid.corners;
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
    layouts(argv[1]);
    ndarrays(argv[1]);
    swapped(argv[1]);
    missing(argv[1]);
    places(argv[1]);
    tables(argv[1]);
    names(argv[1]);
    by_turns(argv[1]);
    at_once(argv[1]);
    background(argv[1]);
    fields(argv[1]);
    CHECK(settles_at(before)); /* none is left behind */

    OK(icoray_mesh_free(&mesh));
    CHECK(mesh == NULL);
    return verdict("pictures");
}
