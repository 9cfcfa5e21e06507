/*
 * Pictures that ranks draw in the background, and the same ones drawn within icoray_execute, of a grid and field that every
 * rank has, of columns over whole tables and of parts: mpi_async DIRECTORY. Files of DIRECTORY/KIND_async and
 * DIRECTORY/KIND_sync are to be the same. With `apart` as a second word: frames in the background of
 * which one rank closes its context, or all end MPI, before they are drawn.
 */
#include "mpi_cut.h"

enum { WHOLE, COLUMNS, PARTS, KINDS };
static const char *const NAMES[KINDS] = {"whole", "columns", "parts"};
enum { STEPS = 9, PIXELS = 90 };

/* A model: what this rank has of the world, and its field as it was at the start. */
typedef struct {
    World w;
    int *owner;
    Cut cut;
    icoray_array array;
    icoray_part part;
    int32_t *global;
    float *values, *start;
    size_t count;
    int kind;
    icoray_array corner; /* heights at corners, of all or of those of this rank's part */
    float *heights, *heights_start;
    size_t heights_count;
} Model;

/* Heights at the corners that this rank has: not a number where they are not its own in a part. */
static void add_heights(Model *m)
{
    float *all = corner_values(&m->w);
    const float *values = m->kind == PARTS ? m->cut.corner.data : all;
    size_t layers = (size_t)m->w.layers;
    m->corner = m->kind == PARTS ? m->cut.corner : m->w.array;
    m->corner.location = ICORAY_CORNER;
    m->corner.columns = m->kind == PARTS ? m->cut.grid.corners : m->w.grid.corners;
    m->heights_count = (size_t)m->corner.columns * layers;
    m->heights = calloc(m->heights_count + 1, sizeof *m->heights);
    m->heights_start = calloc(m->heights_count + 1, sizeof *m->heights);
    for (size_t i = 0; i < m->heights_count; i++) {
        m->heights[i] = m->heights_start[i] = 5e3f * (float)(i % layers) + 2e3f * values[i];
    }
    m->corner.data = m->heights;
    free(all);
}

static Model model(int kind)
{
    Model m = {.kind = kind, .w = world(5, 5)};
    m.owner = partition(&m.w, CONTIGUOUS, ranks);
    m.array = m.w.array;
    if (kind == PARTS) {
        m.cut = cut(&m.w, m.owner, rank, 1);
        m.array = m.cut.center;
        m.part = m.cut.part;
    } else if (kind == COLUMNS) {
        float *mine = calloc((size_t)(m.w.grid.cells * m.w.layers), sizeof *mine);
        m.global = calloc((size_t)m.w.grid.cells, sizeof *m.global);
        m.part.struct_size = sizeof m.part;
        m.part.index_type = ICORAY_I32;
        for (int64_t c = 0; c < m.w.grid.cells; c++) {
            if (m.owner[c] == rank) {
                memcpy(mine + m.part.cells * m.w.layers, m.w.values + c * m.w.layers, (size_t)m.w.layers * sizeof *mine);
                m.global[m.part.cells++] = (int32_t)c + m.w.grid.index_base;
            }
        }
        m.part.owned_cells = m.part.cells;
        m.part.cell_global = m.global;
        m.array.columns = m.part.cells;
        m.array.data = mine;
    }
    m.values = (float *)(uintptr_t)m.array.data;
    m.count = (size_t)(m.array.columns * m.array.column_stride);
    m.start = calloc(m.count + 1, sizeof *m.start);
    memcpy(m.start, m.values, m.count * sizeof *m.start);
    add_heights(&m);
    return m;
}

static void end_model(Model *m)
{
    if (m->kind == PARTS) {
        end_cut(&m->cut);
    }
    if (m->kind == COLUMNS) {
        free(m->values);
    }
    free(m->global);
    free(m->heights);
    free(m->heights_start);
    free(m->start);
    free(m->owner);
    end_world(&m->w);
}

static void give_grid(icoray_ctx *ctx, const Model *m)
{
    OK(icoray_grid_set(ctx, m->kind == PARTS ? &m->cut.grid : &m->w.grid));
    if (m->kind != WHOLE) {
        OK(icoray_part_set(ctx, &m->part));
    }
}

static icoray_ctx *open_model(const Model *m, const char *directory, int async)
{
    icoray_config config = CONFIG(.output_dir = directory, .threads = 1, .async_render = async);
    icoray_ctx *ctx = opened_by_all(&config);
    give_grid(ctx, m);
    set_layers(ctx, m->w.layers);
    OK(icoray_field_set(ctx, "f", &m->array));
    OK(icoray_heights_set(ctx, &m->corner));
    set_scene(ctx, PIXELS, "every = 2\nheights = \"native\"");
    return ctx;
}

/* The field at a step, made with messages of the model's own, while ranks are at different places. */
static void compute(Model *m, int step)
{
    double mine = 1.0, all = 0.0;
    int left = 0, right = (rank + 1) % ranks, from = (rank + ranks - 1) % ranks;
    MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
    CHECK(all == (double)ranks);
    rest_ms(1 + rank);
    MPI_Sendrecv(&rank, 1, MPI_INT, right, 77, &left, 1, MPI_INT, from, 77, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    CHECK(left == from);
    for (size_t i = 0; i < m->count; i++) {
        m->values[i] = m->start[i] * (1.0f - 0.1f * (float)step);
    }
    memcpy(m->heights, m->heights_start, m->heights_count * sizeof *m->heights);
}

/* The model overwrites the drawn values with the next ones. */
static void spoil(Model *m)
{
    for (size_t i = 0; i < m->count; i++) {
        m->values[i] = 1e30f;
    }
    for (size_t i = 0; i < m->heights_count; i++) {
        m->heights[i] = -1e6f * (float)i;
    }
    MPI_Barrier(MPI_COMM_WORLD);
}

static void run(const char *directory, int kind, int async)
{
    const char *name = text_of("%s_%s", NAMES[kind], async ? "async" : "sync");
    icoray_frame_report report;
    Model m = model(kind);
    icoray_ctx *ctx = open_model(&m, path_of(directory, name), async);
    trying = name;
    for (int step = 0; step < STEPS; step++) {
        int32_t wants = -1;
        compute(&m, step);
        OK(icoray_field_set(ctx, "f", &m.array));
        OK(icoray_wants(ctx, step, 60.0 * step, &wants));
        CHECK(wants == (step % 2 == 0));
        if (wants) {
            OK(icoray_execute(ctx, step, 60.0 * step, NULL));
        }
        spoil(&m);
        if (step == 5) { /* A frame of before is finished first, and its tables may go. */
            icoray_grid wrong = m.w.grid;
            wrong.struct_size = 1;
            if (rank == ranks - 1) {
                REFUSED(ctx, STRUCT_SIZE, "struct_size", icoray_grid_set(ctx, &wrong));
            } else {
                OK(icoray_grid_set(ctx, m.kind == PARTS ? &m.cut.grid : &m.w.grid));
            }
            give_grid(ctx, &m);
        }
        if (step == 6) {
            OK(icoray_wait(ctx));
            report = report_of(ctx);
            CHECK(report.step == 6 && report.ranks == ranks && report.frames == 1);
            CHECK(report.frames_failed == 0 && (rank > 0 || report.frames_written == 4));
            CHECK(!async || (report.bytes_copied > 0 && report.copy_s > 0.0));
            CHECK(report.host_s > 0.0 && report.balance > 0.0 && report.tiles >= 0);
        }
    }
    OK(icoray_close(&ctx)); /* without a wait for the last frame */
    end_model(&m);
}

/* Heights that are wrong on the last rank are found while the frame is drawn. */
static void fail_late(const char *directory)
{
    Model m = model(WHOLE);
    icoray_ctx *ctx = open_model(&m, path_of(directory, "late"), 1);
    size_t cells = (size_t)m.w.grid.cells, layers = (size_t)m.w.layers;
    float *heights = calloc(cells * layers, sizeof *heights);
    icoray_array array = m.array;
    icoray_status status;
    trying = "late";
    for (size_t i = 0; i < cells * layers; i++) {
        size_t layer = i % layers;
        heights[i] = 5e3f * (float)(rank == ranks - 1 && i / layers == 7 ? layers - layer : layer + 1);
    }
    array.data = heights;
    OK(icoray_heights_set(ctx, &array));
    set_scene(ctx, PIXELS, "heights = \"native\"");
    OK(icoray_execute(ctx, 0, 0.0, NULL));
    spoil(&m);
    compute(&m, 0);
    set_scene(ctx, PIXELS, "");
    /* The next frame is drawn nevertheless; the next call returns the failure, once. */
    said_before();
    status = icoray_execute(ctx, 1, 60.0, NULL);
    if (status == ICORAY_OK) {
        ALL_REFUSED(LAYERS, "step 0", icoray_wait(ctx));
    } else {
        refused_by_all(status, ICORAY_ERR_LAYERS, "step 0", "icoray_execute", HERE);
        OK(icoray_wait(ctx));
    }
    DRAW(ctx, 2, 120.0, NULL);
    CHECK(rank > 0 || report_of(ctx).frames_written == 2);
    CHECK(report_of(ctx).frames_failed == 1);
    OK(icoray_close(&ctx));
    free(heights);
    end_model(&m);
}

/* Ranks that differ in async_render, and one that closes while others go on. */
static void part_ways(const char *directory)
{
    Model m = model(WHOLE);
    icoray_config config = plain(path_of(directory, "ways"));
    icoray_ctx *ctx = NULL;
    icoray_status status;
    trying = "ways";
    if (ranks > 1) {
        config.async_render = rank == 1;
        ALL_REFUSED(MPI, "async_render", icoray_open(&config, EVERYONE, &ctx));
        CHECK(ctx == NULL);
    }
    ctx = open_model(&m, path_of(directory, "ways"), 1);
    OK(icoray_execute(ctx, 0, 0.0, NULL));
    if (ranks > 1) {
        status = rank == 1 ? icoray_close(&ctx) : icoray_execute(ctx, 2, 0.0, NULL);
        CHECK(status == ICORAY_ERR_MPI);
    }
    status = icoray_close(&ctx);
    CHECK(ctx == NULL && (status == ICORAY_OK || status == ICORAY_ERR_MPI));
    end_model(&m);
}

/* MPI ends before the context is closed. */
static int finalise_first(const char *directory)
{
    Model m = model(WHOLE);
    icoray_ctx *ctx = open_model(&m, path_of(directory, "finalised"), 1);
    icoray_status status;
    int failed;
    trying = "finalised";
    OK(icoray_execute(ctx, 0, 0.0, NULL));
    failed = failed_checks();
    MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_SUM, MPI_COMM_WORLD);
    MPI_Finalize();
    status = icoray_close(&ctx);
    CHECK(ctx == NULL && (status == ICORAY_OK || status == ICORAY_ERR_MPI));
    end_model(&m);
    return failed;
}

int main(int argc, char **argv)
{
    int failed;
    begin(&argc, &argv);
    if (argc > 2) {
        part_ways(argv[1]);
        failed = finalise_first(argv[1]);
        if (rank == 0) {
            verdict("mpi_async");
        }
        return failed == 0 && failed_checks() == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
    }
    for (int kind = 0; kind < KINDS; kind++) {
        run(argv[1], kind, 0);
        run(argv[1], kind, 1);
    }
    fail_late(argv[1]);
    return end("mpi_async");
}
