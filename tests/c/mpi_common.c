#include "mpi_common.h"

#include <math.h>

int rank, ranks;

void begin(int *argc, char ***argv)
{
    MPI_Init(argc, argv);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
}

int end(const char *program)
{
    int failed = failed_checks(), all = 0;
    MPI_Allreduce(&failed, &all, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
    MPI_Finalize();
    if (rank == 0) {
        verdict(program);
    }
    return all == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

icoray_ctx *together(MPI_Comm comm, const char *directory, const World *w, icoray_config config)
{
    icoray_ctx *ctx = NULL;
    config.struct_size = sizeof config;
    config.output_dir = directory;
    config.threads = 1 + rank % 2;
    OK(icoray_open(&config, (int32_t)MPI_Comm_c2f(comm), &ctx));
    fill(ctx, w);
    return ctx;
}

icoray_ctx *alone(const char *directory, const World *w)
{
    icoray_config config = plain(directory);
    icoray_ctx *ctx = NULL;
    OK(icoray_open_serial(&config, &ctx));
    fill(ctx, w);
    return ctx;
}

icoray_ctx *opened_by_all(const icoray_config *config)
{
    icoray_ctx *ctx = NULL;
    OK(icoray_open(config, EVERYONE, &ctx));
    return ctx;
}

int is_same_on_all(int value)
{
    int least = value, most = value;
    MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
    return least == most;
}

void fill(icoray_ctx *ctx, const World *w)
{
    OK(icoray_grid_set(ctx, &w->grid));
    set_layers(ctx, w->layers);
    OK(icoray_field_set(ctx, "f", &w->array));
}

void said_before(void)
{
    icoray_mesh *none;
    icoray_mesh_create(-76543, &none);
}

void refused_by_all(icoray_status status, icoray_status expected, const char *part, const char *what, Place at)
{
    char mine[512] = "", roots[512];
    icoray_last_error(NULL, mine, sizeof mine);
    memcpy(roots, mine, sizeof roots);
    MPI_Bcast(roots, sizeof roots, MPI_CHAR, 0, MPI_COMM_WORLD);
    int has_message = strstr(mine, part) != NULL && strcmp(mine, roots) == 0;
    check(is_same_on_all((int)status) && status == expected, what, at);
    check(has_message, "the message", at);
    if (status != expected || !has_message) {
        printf("  rank %d: %d, expected %d with '%s': %s\n", rank, (int)status, (int)expected, part, mine);
    }
}

const char *by_rank(int odd)
{
    return text_of("rank %d: ", odd);
}

World at_corners(const World *w)
{
    World other = *w;
    size_t numbers = (size_t)(w->grid.corners * w->layers);
    int32_t *counts;
    other.values = allocate(numbers + (size_t)w->grid.cells, sizeof *other.values);
    counts = (int32_t *)(void *)(other.values + numbers);
    for (size_t i = 0; i < numbers; i++) {
        other.values[i] = (float)sin(0.1 * (double)i);
    }
    for (int64_t cell = 0; cell < w->grid.cells; cell++) {
        counts[cell] = (int32_t)w->grid.cell_corner_row;
    }
    other.array.data = other.values;
    other.array.location = ICORAY_CORNER;
    other.array.columns = w->grid.corners;
    other.grid.cell_corner_count = counts;
    return other;
}

icoray_status execute_spoilt(icoray_ctx *ctx, const icoray_grid *grid, int64_t step, int is_here)
{
    size_t bytes = (size_t)grid->cells * sizeof(int32_t);
    void *table = (void *)(uintptr_t)grid->cell_corner_count, *kept = allocate(bytes + 1, 1);
    icoray_status status;
    memcpy(kept, table, bytes);
    if (is_here) {
        memset(table, 0x3f, bytes);
    }
    status = icoray_execute(ctx, step, 60.0 * (double)step, NULL);
    memcpy(table, kept, bytes);
    free(kept);
    return status;
}

void take_all(void)
{
    static const char zeros[65536];
    if (rank == 0) {
        FILE *file = fopen("/dev/shm/icoray_test", "wb");
        CHECK(file != NULL);
        while (file != NULL && fwrite(zeros, sizeof zeros, 1, file) == 1 && fflush(file) == 0) {
        }
        if (file != NULL) {
            fclose(file);
        }
    }
    MPI_Barrier(MPI_COMM_WORLD);
}
