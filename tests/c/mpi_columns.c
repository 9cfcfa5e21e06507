/*
 * Pictures of columns that are spread over ranks, each of which has the whole grid's tables, and the same ones drawn by one
 * process without MPI: mpi_columns DIRECTORY [serial | small]. Files of the same names are to be the same to the byte, also
 * where nodes have no memory to share (small).
 */
#include "mpi_columns.h"

static const struct {
    const char *name, *more, *light;
} SCENES[] = {
    {"f32", "", ""},
    {"f64", "precision = \"f64\"\ncore = \"transparent\"", ""},
    {"lit", "background = \"transparent\"", "[light]\nkind = \"headlight\""},
    {"two", "heights = \"native\"", ""},
    {"corners", "heights = \"native\"", ""},
};
enum { FRAMES = COUNT(SCENES), CORNERS = FRAMES - 1, TWO = FRAMES - 2 };
static const char *const KINDS[PARTITIONS] = {"contiguous", "random", "single_cell", "no_cell"};
static const char *sharing;
static int heard;

static void hear(void *user, int32_t level, const char *message)
{
    (void)user;
    heard += level == ICORAY_LOG_DEBUG && strstr(message, sharing) != NULL;
}

static void set(icoray_ctx *ctx, int scene)
{
    static const char one[] = "[transfer]\n" VIRIDIS;
    static const char two[] =
        "[[volumes]]\nfield = \"f\"\n[volumes.transfer]\n" VIRIDIS "[[volumes]]\nfield = \"g\"\n[volumes.transfer]\n"
        "map = \"magma\"\nrange = [-1, 1]\nopacity = [[-1, 0.0], [0, 0.0], [1, 0.9]]\n";
    OK(icoray_scene_text(ctx, text_of(
        "%sexaggeration = 60\n%s\n[image]\nwidth = 70\nheight = 58\n" CAMERA "%s"
        "[output]\nfile = \"%s_{step}.exr\"\nerror = \"%s_error_{step}.png\"\n%s\n",
        scene == TWO ? "" : scene == CORNERS ? "field = \"c\"\n" : "field = \"f\"\n", SCENES[scene].more, scene == TWO ? two : one, SCENES[scene].name,
        SCENES[scene].name, SCENES[scene].light)));
}

static icoray_ctx *fresh(const char *directory, const World *w)
{
    icoray_config config = CONFIG(.output_dir = directory, .threads = 1 + rank % 2, .log = hear,
                                  .log_level = ICORAY_LOG_DEBUG);
    icoray_ctx *ctx = opened_by_all(&config);
    OK(icoray_grid_set(ctx, &w->grid));
    set_layers(ctx, w->layers);
    return ctx;
}

/*
 * Each node wrote every field of the scene once, and heights where it needs them, in any shares, and has gradients once;
 * a rank alone on its node also knows which gradients it has.
 */
static void check_report(const icoray_frame_report *r, const World *w, double nodes, int scene)
{
    double values = (double)(w->grid.cells * w->layers), of = scene == TWO ? KINDS_OF_VALUES : 1;
    double copied = (double)r->bytes_copied, all = 0.0, lit = (double)r->bytes_derived, derived = 0.0;
    int is_plain = scene != TWO && scene != CORNERS;
    if (scene == CORNERS) {
        values = (double)(w->grid.corners * w->layers);
        of = 2;
    }
    MPI_Allreduce(&copied, &all, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    CHECK(all == nodes * of * values * 4);
    CHECK(r->scheme == ICORAY_TILES && r->ranks == ranks && r->copy_s > 0.0 && r->missing_values == 0);
    CHECK(r->fragments == 0);
    MPI_Allreduce(&lit, &derived, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    double expected = nodes * values * 8 + (nodes == ranks ? nodes * w->grid.cells : 0);
    CHECK(!is_plain || derived == (r->lights != 0 ? expected : 0));
}

static void draw(const char *directory, const World *w, int kind, double nodes)
{
    int *owner = partition(w, kind, ranks);
    icoray_ctx *ctx;
    Mine mine;
    if (owner == NULL) {
        return;
    }
    trying = KINDS[kind];
    mine = mine_of(w, owner, kind % 2);
    ctx = fresh(path_of(directory, KINDS[kind]), w);
    OK(icoray_part_set(ctx, &mine.part));
    memset(mine.global, 0x55, (size_t)mine.part.cells * 4); /* nothing is kept of it */
    memset(mine.corner_global, 0x55, (size_t)mine.corner_array.columns * 4);
    OK(icoray_field_set(ctx, "f", &mine.array));
    set_more(ctx, mine.array, mine.all);
    for (int step = 0; step < FRAMES; step++) {
        icoray_frame_report report;
        set(ctx, step);
        compute(&mine, w, step);
        if (step == CORNERS) {
            compute_corners(&mine, w);
            set_corners(ctx, mine.corner_array, mine.at_corners);
        }
        OK(icoray_execute(ctx, step, 0.0, NULL));
        report = report_of(ctx);
        check_report(&report, w, nodes, step);
        CHECK(heard == step + 1);
    }
    heard = 0;
    OK(icoray_close(&ctx));
    end_mine(&mine);
    free(owner);
}

static void draw_alone(const char *directory, const World *w)
{
    icoray_config config = plain(directory);
    icoray_ctx *ctx = NULL;
    World now = *w;
    float *all[KINDS_OF_VALUES], *base = corner_values(w), *at_corners[2];
    icoray_array corner = w->array;
    corner.location = ICORAY_CORNER;
    corner.columns = w->grid.corners;
    for (int k = 0; k < 2; k++) {
        at_corners[k] = calloc((size_t)(w->grid.corners * w->layers), sizeof **at_corners);
        for (int64_t i = 0; i < w->grid.corners * w->layers; i++) {
            at_corners[k][i] = corner_value(base, w, k, i / w->layers, (int)(i % w->layers));
        }
    }
    for (int k = 0; k < KINDS_OF_VALUES; k++) {
        all[k] = calloc((size_t)(w->grid.cells * w->layers), sizeof *now.values);
    }
    now.values = all[F];
    now.array.data = now.values;
    OK(icoray_open_serial(&config, &ctx));
    fill(ctx, &now);
    set_more(ctx, now.array, all);
    for (int step = 0; step < FRAMES; step++) {
        for (int64_t i = 0; i < w->grid.cells * w->layers; i++) {
            for (int k = 0; k < KINDS_OF_VALUES; k++) {
                all[k][i] = value(w, k, i / w->layers, (int)(i % w->layers), step);
            }
        }
        set(ctx, step);
        if (step == CORNERS) {
            set_corners(ctx, corner, at_corners);
        }
        OK(icoray_execute(ctx, step, 0.0, NULL));
        CHECK(report_of(ctx).bytes_copied == 0);
    }
    OK(icoray_close(&ctx));
    free(base);
    free(at_corners[0]);
    free(at_corners[1]);
    for (int k = 0; k < KINDS_OF_VALUES; k++) {
        free(all[k]);
    }
}

/* Errors on the last rank only are the same status on all, and correct inputs are drawn afterwards. */
static void refusals(const char *directory, const World *w)
{
    int *owner = partition(w, CONTIGUOUS, ranks);
    int odd = ranks - 1, is_odd = rank == odd;
    Mine mine = mine_of(w, owner, 1);
    icoray_ctx *ctx = fresh(directory, w);
    icoray_part part = mine.part;
    icoray_array array = mine.array;
    const char *text = by_rank(odd);
    int32_t kept = mine.global[0];
    if (is_odd) {
        mine.global[0] = (int32_t)w->grid.cells + w->grid.index_base;
    }
    ALL_REFUSED(GRID, "a row of the grid's tables", icoray_part_set(ctx, &part));
    if (is_odd) {
        mine.global[0] = w->grid.index_base - 1;
    }
    ALL_REFUSED(GRID, text, icoray_part_set(ctx, &part));
    mine.global[0] = kept;
    part.is_owned = is_odd ? NULL : mine.is_owned;
    ALL_REFUSED(GRID, "is owned by no rank", icoray_part_set(ctx, &part));
    part.owned_cells = part.cells + 1;
    ALL_REFUSED(GRID, text, icoray_part_set(ctx, &part));
    part.is_owned = mine.is_owned;
    if (is_odd) {
        mine.global[0] = 0; /* the first rank's */
    }
    ALL_REFUSED(GRID, "cell 0 is owned by ranks 0 and", icoray_part_set(ctx, &part));
    mine.global[0] = kept;

    /* Corners. */
    kept = mine.corner_global[0];
    if (is_odd) {
        mine.corner_global[0] = (int32_t)w->grid.corners + w->grid.index_base;
    }
    ALL_REFUSED(GRID, "corner_global row 0: ", icoray_part_set(ctx, &part));
    mine.corner_global[0] = kept;
    part.is_corner_owned = is_odd ? NULL : mine.is_corner_owned;
    ALL_REFUSED(GRID, "of the whole grid is owned by no rank", icoray_part_set(ctx, &part));
    part.owned_corners = part.corners;
    /* The second rank has some of the others as a halo. */
    part.is_corner_owned = rank == 1 ? NULL : mine.is_corner_owned;
    ALL_REFUSED(GRID, "expected one owner", icoray_part_set(ctx, &part));
    part = mine.part;
    OK(icoray_part_set(ctx, &part));

    /* Fields. */
    compute(&mine, w, 0);
    set(ctx, 0);
    array.columns -= is_odd;
    OK(icoray_field_set(ctx, "f", &array));
    ALL_REFUSED(FIELD, text, icoray_execute(ctx, 1, 0.0, NULL));
    OK(icoray_field_set(ctx, "f", is_odd ? &mine.corner_array : &mine.array));
    ALL_REFUSED(MPI, "has \"f\" at corners, but \"f\" at centres on rank 0", icoray_execute(ctx, 2, 0.0, NULL));
    array = mine.corner_array;
    array.columns -= is_odd;
    OK(icoray_field_set(ctx, "f", &array));
    ALL_REFUSED(FIELD, "one per row of corner_global", icoray_execute(ctx, 2, 0.0, NULL));
    OK(icoray_field_set(ctx, "f", &mine.array));
    OK(icoray_execute(ctx, 3, 0.0, NULL));

    /* A second field, and heights, that one rank has otherwise or not at all. */
    set(ctx, TWO);
    if (!is_odd) {
        set_more(ctx, mine.array, mine.all);
    }
    ALL_REFUSED(FIELD, "the scene's field \"g\" was not given", icoray_execute(ctx, 5, 0.0, NULL));
    array = mine.array;
    array.data = mine.all[G];
    array.has_fill = is_odd;
    OK(icoray_field_set(ctx, "g", &array));
    ALL_REFUSED(FIELD, "none were given by icoray_heights_set", icoray_execute(ctx, 6, 0.0, NULL));
    set_more(ctx, mine.array, mine.all);
    OK(icoray_field_set(ctx, "g", &array));
    ALL_REFUSED(MPI, "has \"g\" with missing values marked by Some(0.0)", icoray_execute(ctx, 7, 0.0, NULL));
    set_more(ctx, mine.array, mine.all);
    OK(icoray_execute(ctx, 8, 0.0, NULL));
    set(ctx, 0);

    /* As Fortran gives it: the columns are found among the dimensions. */
    icoray_ndarray nd = {.struct_size = sizeof nd, .data = mine.values, .type = ICORAY_F32, .rank = 2};
    nd.extent[0] = w->layers;
    nd.extent[1] = mine.part.cells;
    nd.stride[0] = mine.array.layer_stride;
    nd.stride[1] = mine.array.column_stride;
    OK(icoray_field_set_ndarray(ctx, "f", &nd));
    OK(icoray_execute(ctx, 4, 0.0, NULL));
    compute_corners(&mine, w);
    nd.data = mine.at_corners[0];
    nd.location = ICORAY_CORNER;
    nd.extent[1] = mine.corner_array.columns;
    nd.stride[0] = mine.corner_array.layer_stride;
    nd.stride[1] = mine.corner_array.column_stride;
    OK(icoray_field_set_ndarray(ctx, "f", &nd));
    OK(icoray_execute(ctx, 9, 0.0, NULL));
    CHECK(report_of(ctx).missing_values == 0);
    OK(icoray_close(&ctx));
    end_mine(&mine);
    free(owner);
}

/* One rank closes, and the memory that all share is left alone. */
static void leaves(const char *directory, const World *w)
{
    int *owner = partition(w, CONTIGUOUS, ranks);
    Mine mine = mine_of(w, owner, 0);
    icoray_ctx *ctx = fresh(directory, w);
    OK(icoray_part_set(ctx, &mine.part));
    OK(icoray_field_set(ctx, "f", &mine.array));
    compute(&mine, w, 0);
    set(ctx, 0);
    OK(icoray_execute(ctx, 100, 0.0, NULL));
    ALL_REFUSED(MPI, "call", rank == 0 ? icoray_close(&ctx) : icoray_execute(ctx, 101, 0.0, NULL));
    if (rank != 0) {
        OK(icoray_close(&ctx));
    }
    end_mine(&mine);
    free(owner);
}

/* Number of nodes into which the environment divides this one. */
static double count_nodes(void)
{
    const char *most = getenv("ICORAY_NODE_RANKS");
    return most == NULL ? 1.0 : ceil((double)ranks / atof(most));
}

int main(int argc, char **argv)
{
    World w;
    int is_small = argc > 2 && strcmp(argv[2], "small") == 0;
    if (argc > 2 && !is_small) {
        w = world(4, 5);
        draw_alone(argv[1], &w);
        end_world(&w);
        return verdict("mpi_columns");
    }
    begin(&argc, &argv);
    w = world(4, 5);
    if (is_small) {
        take_all();
    }
    sharing = is_small     ? "(tiles: every rank has the whole grid, the field is assembled once per rank, as nodes"
              : ranks == 1 ? "(tiles: every rank has the whole grid)"
                           : "(tiles: every rank has the whole grid, the field is assembled once per node)";
    for (int kind = 0; kind < (is_small ? 1 : PARTITIONS); kind++) {
        draw(argv[1], &w, kind, is_small ? ranks : count_nodes());
    }
    if (!is_small) {
        trying = "refusals";
        refusals(path_of(argv[1], "refusals"), &w);
        trying = "leaving";
        leaves(path_of(argv[1], "leaving"), &w);
    }
    end_world(&w);
    return end("mpi_columns");
}
