/*
 * Parts of a grid that are wrong on one rank only: the same status on all, no rank hangs, and the next frame is
 * drawn. mpi_parts_refusals DIRECTORY [full]; `full` needs a small file system there.
 */
#include "mpi_cut.h"

#include <stddef.h>

static const char *directory;
static World w;
static int64_t step;
/* The parts of a contiguous partition: this rank's, and the same cells without a halo. */
static Cut mine, narrow;

static icoray_ctx *fresh(void)
{
    icoray_config config = plain(directory);
    icoray_ctx *ctx = opened_by_all(&config);
    fill_cut(ctx, &mine, w.layers);
    set_scene(ctx, 40, "");
    return ctx;
}

static void drawn(icoray_ctx *ctx, int scheme)
{
    step++;
    OK(icoray_execute(ctx, step, 0.0, NULL));
    CHECK(report_of(ctx).scheme == scheme);
    CHECK((report_of(ctx).fragment_bytes > 0) == (scheme == ICORAY_FRAGMENTS));
}

static void good(icoray_ctx *ctx)
{
    int64_t copied, all = 0;
    drawn(ctx, ICORAY_TILES);
    /* A rank without own cells writes nothing. */
    copied = (int64_t)report_of(ctx).bytes_copied;
    MPI_Allreduce(&copied, &all, 1, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
    CHECK(all > 0);
}

/* Members that are wrong, and what is said of them. */
static void members(int odd)
{
    static const int64_t negative = -1, too_many = 1 << 20, huge = INT64_MAX;
    static const int32_t no_type = ICORAY_F64;
    static const char *const unknown = "no such grid", *const no_utf8 = "\xff", *const aside = (const char *)1;
    static const void *const none = NULL;
#define MEMBER(name) offsetof(icoray_part, name), sizeof(mine.part.name)
    static const struct {
        size_t offset, size;
        const void *value;
        icoray_status status;
        const char *part;
    } cases[] = {
        {MEMBER(grid), &unknown, ICORAY_ERR_ARGUMENT, "no grid named \"no such grid\""},
        {MEMBER(grid), &no_utf8, ICORAY_ERR_ARGUMENT, "icoray_part.grid"},
        {MEMBER(cells), &negative, ICORAY_ERR_ARGUMENT, "icoray_part.cells: -1"},
        {MEMBER(cells), &huge, ICORAY_ERR_ARGUMENT, "icoray_part.cells: 9"},
        {MEMBER(index_type), &no_type, ICORAY_ERR_ARGUMENT, "icoray_part.index_type: 2, expected ICORAY_I32"},
        {MEMBER(cell_global), &none, ICORAY_ERR_NULL, "icoray_part.cell_global"},
        {MEMBER(cell_global), &aside, ICORAY_ERR_ARGUMENT, "icoray_part.cell_global"},
        {MEMBER(is_owned), &aside, ICORAY_ERR_ARGUMENT, "icoray_part.is_owned"},
        {MEMBER(owned_cells), &negative, ICORAY_ERR_ARGUMENT, "icoray_part.owned_cells: -1"},
        {MEMBER(owned_cells), &too_many, ICORAY_ERR_GRID, "1048576 own cells, expected at most"},
    };
    icoray_ctx *ctx = fresh();
    const char *text = by_rank(odd);
    OK(icoray_part_set(ctx, &mine.part));
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        icoray_part part = mine.part;
        if (rank == odd) {
            part.is_owned = cases[i].offset == offsetof(icoray_part, owned_cells) ? NULL : part.is_owned;
            memcpy((char *)&part + cases[i].offset, cases[i].value, cases[i].size);
        }
        trying = cases[i].part;
        ALL_REFUSED_AS(cases[i].status, text, icoray_part_set(ctx, &part));
        ALL_REFUSED_AS(cases[i].status, cases[i].part, icoray_part_set(ctx, &part));
    }
#undef MEMBER
    trying = "";
    ALL_REFUSED(NULL, text, icoray_part_set(ctx, rank == odd ? NULL : &mine.part));
    mine.part.struct_size -= rank == odd;
    ALL_REFUSED(STRUCT_SIZE, text, icoray_part_set(ctx, &mine.part));
    mine.part.struct_size = sizeof mine.part;
    /* The part before stays. */
    good(ctx);
    OK(icoray_close(&ctx));
}

/* Numbers and marks that do not fit the grid, or each other. */
static void cells(int odd)
{
    icoray_ctx *ctx = fresh();
    icoray_part part = mine.part;
    int32_t *marks = calloc((size_t)part.cells, sizeof *marks);
    int64_t *numbers = calloc((size_t)part.cells, sizeof *numbers);
    int64_t own = 0, halo = 0;
    int is_odd = rank == odd;
    const char *text = by_rank(odd);
    for (int64_t i = 0; i < part.cells; i++) {
        const void *global = mine.part.cell_global;
        int is_wide = part.index_type == ICORAY_I64;
        numbers[i] = is_wide ? ((const int64_t *)global)[i] : ((const int32_t *)global)[i];
        marks[i] = mine.part.is_owned != NULL ? mine.part.is_owned[i] : i < mine.part.owned_cells;
        *(marks[i] ? &own : &halo) = i;
    }
    part.index_type = ICORAY_I64;
    part.cell_global = numbers;
    part.is_owned = marks;

    part.cells -= is_odd;
    ALL_REFUSED(GRID, text, icoray_part_set(ctx, &part));
    ALL_REFUSED(GRID, "one per cell", icoray_part_set(ctx, &part));
    part.cells += is_odd;
    marks[halo] = is_odd;
    ALL_REFUSED(GRID, "is owned by ranks", icoray_part_set(ctx, &part));
    marks[halo] = 0;
    /* No other rank owns a lone rank's halo; this one gives up a cell that others have in their halo, or an own one. */
    marks[own] = !is_odd;
    ALL_REFUSED(GRID, "but owned by no rank", icoray_part_set(ctx, &part));
    marks[own] = 1;
    if (is_odd) {
        memset(marks, 0, (size_t)part.cells * sizeof *marks);
    }
    ALL_REFUSED(GRID, "but owned by no rank", icoray_part_set(ctx, &part));
    for (int64_t i = 0; is_odd && i < part.cells; i++) {
        marks[i] = mine.part.is_owned != NULL ? mine.part.is_owned[i] : i < mine.part.owned_cells;
    }
    numbers[own] -= is_odd ? numbers[own] + 9 : 0;
    ALL_REFUSED(GRID, text, icoray_part_set(ctx, &part));
    ALL_REFUSED(GRID, ": -9, expected", icoray_part_set(ctx, &part));
    numbers[own] = numbers[is_odd ? halo : own];
    ALL_REFUSED(GRID, "expected different numbers", icoray_part_set(ctx, is_odd ? &part : &mine.part));
    OK(icoray_part_set(ctx, &mine.part));
    good(ctx);

    /* Own cells only: no triangle that has cells of two ranks is whole anywhere. */
    OK(icoray_grid_set(ctx, is_odd ? &narrow.grid : &mine.grid));
    ALL_REFUSED(GRID, "halo", icoray_part_set(ctx, is_odd ? &narrow.part : &mine.part));
    OK(icoray_grid_set(ctx, &mine.grid));
    OK(icoray_part_set(ctx, &mine.part));
    good(ctx);
    OK(icoray_close(&ctx));
    free(marks);
    free(numbers);
}

/* A rank that has cells, all of them others': its neighbours' halo is its whole grid. */
static void owns_nothing(int odd)
{
    icoray_ctx *ctx = fresh();
    int next = odd == 0 ? 1 : 0;
    int *owner = partition(&w, CONTIGUOUS, ranks);
    int32_t *marks;
    Cut shifted;
    for (int64_t i = 0; i < w.grid.cells; i++) {
        owner[i] = owner[i] == odd ? next : owner[i];
    }
    shifted = cut(&w, owner, rank == odd ? next : rank, 1);
    marks = calloc((size_t)shifted.part.cells, sizeof *marks);
    if (rank == odd) {
        shifted.part.is_owned = marks;
    }
    fill_cut(ctx, &shifted, w.layers);
    OK(icoray_part_set(ctx, &shifted.part));
    good(ctx);
    OK(icoray_close(&ctx));
    end_cut(&shifted);
    free(marks);
    free(owner);
}

/* Calls in another order, or for another grid, than on the other ranks. */
static void order(int odd)
{
    icoray_config config = plain(directory);
    icoray_grid named = mine.grid;
    icoray_part part = mine.part;
    const char *text = by_rank(odd);
    int is_odd = rank == odd;
    icoray_ctx *ctx = opened_by_all(&config);
    if (!is_odd) {
        fill_cut(ctx, &mine, w.layers);
    }
    ALL_REFUSED(ORDER, text, icoray_part_set(ctx, &mine.part));
    fill_cut(ctx, &mine, w.layers);
    set_scene(ctx, 40, "");
    /* Without parts each rank says that it has the whole grid, which they do not. */
    ALL_REFUSED(MPI, "the first at ", icoray_execute(ctx, step + 1, 0.0, NULL));
    OK(icoray_part_set(ctx, &mine.part));
    good(ctx);

    named.name = "other";
    OK(icoray_grid_set(ctx, &named));
    part.grid = is_odd ? "other" : NULL;
    ALL_REFUSED(MPI, "grid", icoray_part_set(ctx, &part));
    part.grid = "other";
    OK(icoray_part_set(ctx, &part));
    good(ctx);

    ALL_REFUSED(MPI, "call", is_odd ? icoray_part_set(ctx, &mine.part) : icoray_execute(ctx, step + 1, 0.0, NULL));
    good(ctx);

    /* A grid that is set anew has no part. */
    if (is_odd) {
        OK(icoray_grid_set(ctx, &mine.grid));
    }
    ALL_REFUSED(MPI, "without icoray_part_set", icoray_execute(ctx, step + 1, 0.0, NULL));
    /* One that is refused leaves the grid before, and its part. */
    OK(icoray_part_set(ctx, &mine.part));
    if (is_odd) {
        named = mine.grid;
        named.edges--;
        CHECK(icoray_grid_set(ctx, &named) == ICORAY_ERR_GRID);
    }
    good(ctx);

    set_scene(ctx, 40, "ranks = \"tiles\"");
    good(ctx);
    set_scene(ctx, 40, "ranks = \"fragments\"");
    drawn(ctx, ICORAY_FRAGMENTS);
    OK(icoray_close(&ctx));
}

/* Every rank has the whole grid, or one has none. */
static void whole(int odd)
{
    icoray_grid none = {.struct_size = sizeof none, .real_type = ICORAY_F64, .index_type = ICORAY_I32,
                        .cell_corner_row = 6};
    icoray_ctx *ctx = together(MPI_COMM_WORLD, directory, &w, (icoray_config){0});
    set_scene(ctx, 40, "ranks = \"fragments\"");
    drawn(ctx, ICORAY_FRAGMENTS);
    set_scene(ctx, 40, "ranks = \"tiles\"");
    OK(icoray_execute(ctx, ++step, 0.0, NULL));
    CHECK(report_of(ctx).scheme == ICORAY_TILES && report_of(ctx).fragments == 0);
    if (rank == odd) {
        OK(icoray_grid_set(ctx, &none));
    }
    ALL_REFUSED(GRID, "0 cells, expected at least 1, or icoray_part_set", icoray_execute(ctx, step + 1, 0.0, NULL));
    OK(icoray_close(&ctx));
}

/* A panic on one rank breaks the context of all. */
static void inside(int odd)
{
    World other = at_corners(&w);
    icoray_ctx *ctx = together(MPI_COMM_WORLD, directory, &other, (icoray_config){0});
    set_scene(ctx, 40, "");
    drawn(ctx, ICORAY_TILES);
    ALL_REFUSED(INTERNAL, by_rank(odd), execute_spoilt(ctx, &other.grid, step + 1, rank == odd));
    ALL_REFUSED(INTERNAL, "accepts no more calls", icoray_part_set(ctx, &mine.part));
    OK(icoray_close(&ctx));
    free(other.values);
}

/* A full file system at rank 0 is an error on all ranks, and the next frame is tried. */
static void full(void)
{
    static char nothing[4096];
    icoray_ctx *ctx = fresh();
    FILE *filler = NULL;
    OK(icoray_part_set(ctx, &mine.part));
    good(ctx);
    OK(icoray_wait(ctx));
    if (rank == 0) {
        filler = fopen(path_of(directory, "filler"), "wb");
        setvbuf(filler, NULL, _IONBF, 0);
        for (int i = 0; i < 4096 && fwrite(nothing, sizeof nothing, 1, filler) == 1; i++) {
        }
        CHECK(fwrite(nothing, 1, 1, filler) == 0);
    }
    good(ctx);
    ALL_REFUSED(IO, "No space left", icoray_wait(ctx));
    if (rank == 0) {
        CHECK(entries(directory, ".png") == 1 && entries(directory, ".tmp") == 0);
        fclose(filler);
        CHECK(remove(path_of(directory, "filler")) == 0);
    }
    good(ctx);
    OK(icoray_close(&ctx));
    if (rank == 0) {
        CHECK(entries(directory, ".png") == 2 && entries(directory, ".tmp") == 0);
    }
}

int main(int argc, char **argv)
{
    int *owner;
    begin(&argc, &argv);
    directory = argv[1];
    w = world(3, 4);
    owner = partition(&w, CONTIGUOUS, ranks);
    mine = cut(&w, owner, rank, 1);
    narrow = cut(&w, owner, rank, 0);
    if (argc > 2 && strcmp(argv[2], "full") == 0) {
        full();
    } else {
        for (int odd = 0; odd < ranks; odd += ranks - 1) {
            members(odd);
            cells(odd);
            owns_nothing(odd);
            order(odd);
            whole(odd);
            inside(odd);
        }
    }
    end_cut(&mine);
    end_cut(&narrow);
    free(owner);
    end_world(&w);
    return end("mpi_parts_refusals");
}
