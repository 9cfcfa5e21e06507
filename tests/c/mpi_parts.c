/*
 * Pictures of a grid that is spread over ranks, and the same ones of the whole grid drawn by one process without MPI:
 * mpi_parts DIRECTORY [serial|small]. Files of the same names are to be nearly the same.
 */
#include "mpi_cut.h"

#include <math.h>

static const struct {
    const char *name, *field, *camera, *more, *light;
} SCENES[] = {
    {"f64_far", "f", "lon = 20\nlat = 35\ndistance = 3.2\nfov = 45", "core = \"transparent\"\nbackground = \"transparent\"",
     ""},
    {"f64_lit", "f", "lon = -100\nlat = -60\ndistance = 1.9\nfov = 60", "", "[light]\nkind = \"headlight\""},
    {"f64_corner", "v", "lon = 20\nlat = 35\ndistance = 3.2\nfov = 45", "", "[light]\nkind = \"headlight\""},
    {"f64_native", "v", "lon = 20\nlat = 35\ndistance = 3.2\nfov = 45", "heights = \"native\"", "[light]\nkind = \"headlight\""},
    {"f32_native", "f", "lon = -100\nlat = -60\ndistance = 1.9\nfov = 60", "heights = \"native\"", ""},
    {"f32_far", "f", "lon = 20\nlat = 35\ndistance = 3.2\nfov = 45", "core = \"transparent\"", ""},
    {"f32_lit", "v", "lon = -100\nlat = -60\ndistance = 1.9\nfov = 60", "", "[light]\nkind = \"headlight\""},
    /* From within the shell, and forced, which makes no difference. */
    {"f32_inside", "f", "lon = 26\nlat = 33\ndistance = 1.1\nfov = 110", "core = \"transparent\"\nranks = \"fragments\"",
     ""},
    /* A field alone: it has the look that is suggested for the values of all ranks. */
    {"f32_look", "v", NULL, "", ""},
};
static const char *const KINDS[PARTITIONS] = {"contiguous", "random", "single_cell", "no_cell"};

static int heard;
/* Ranks that share memory; 0 for all. */
static int node_ranks;
/* Whether there is no memory to share. */
static int is_small;

static void hear(void *user, int32_t level, const char *message)
{
    (void)user;
    heard += level == ICORAY_LOG_DEBUG && strstr(message, "over ranks (") != NULL
             && (ranks == 1 || strstr(message, is_small ? "parts and the field are assembled once per rank"
                                                          : "its ranks' parts and the field are assembled once per node") != NULL);
}

static void set(icoray_ctx *ctx, size_t scene)
{
    int is_wide = strncmp(SCENES[scene].name, "f64", 3) == 0;
    if (SCENES[scene].camera == NULL) {
        OK(icoray_scene_text(ctx, text_of("field = \"%s\"\ntolerance = 1e-6\nimage = { width = 34, height = 28 }\n"
                                          "[output]\nfile = \"%s.exr\"\n", SCENES[scene].field, SCENES[scene].name)));
        return;
    }
    OK(icoray_scene_text(ctx, text_of(
        "field = \"%s\"\nexaggeration = 60\nprecision = \"%.3s\"\ntolerance = %s\n%s\n[image]\nwidth = 34\n"
        "height = 28\n[camera]\n%s\n[transfer]\nmap = \"viridis\"\nrange = [-1.5, 1.5]\n"
        "opacity = [[-1.5, 0.5], [-0.2, 0.05], [0.2, 0.8], [1.5, 0.3]]\n[output]\nfile = \"%s.exr\"\n%s\n",
        SCENES[scene].field, SCENES[scene].name, is_wide ? "1e-7" : "1e-6", SCENES[scene].more,
        SCENES[scene].camera, SCENES[scene].name, SCENES[scene].light)));
}

/* The report is that of the whole picture. */
static void check_report(const icoray_frame_report *r, const World *w, size_t scene)
{
    const char *field = SCENES[scene].field;
    int is_forced = strstr(SCENES[scene].more, "ranks") != NULL;
    int has_fragments = is_forced || (node_ranks > 0 && node_ranks < ranks);
    int64_t copied = r->bytes_copied, all = 0, one = w->grid.cells * w->layers * (int64_t)sizeof(float);
    double same[6], roots[6];
    CHECK(r->ranks == ranks && r->scheme == (has_fragments ? ICORAY_FRAGMENTS : ICORAY_TILES) && r->rays > 0);
    CHECK((r->fragments > 0) == has_fragments && (r->fragment_bytes > 0) == (has_fragments && ranks > 1));
    CHECK(r->compose_s >= 0.0 && (ranks > 1 || copied == 0));
    MPI_Allreduce(&copied, &all, 1, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
    if (ranks > 1 && strcmp(field, "f") == 0) {
        /* Once per node, with what nodes have of each other. */
        CHECK(node_ranks > 0 ? all > one : all == (is_small ? ranks : 1) * one);
    } else {
        /* Fields and heights at corners are averaged where they are. */
        CHECK(all == 0);
    }
    CHECK(r->missing_values == 0 && r->void_frusta == 0 && r->error_max > 0.0);
    same[0] = (double)r->rays;
    same[1] = (double)r->fragments;
    same[2] = (double)r->fragment_bytes;
    same[3] = r->error_mean;
    same[4] = r->value_min;
    same[5] = r->value_max;
    memcpy(roots, same, sizeof roots);
    MPI_Bcast(roots, 6, MPI_DOUBLE, 0, MPI_COMM_WORLD);
    CHECK(memcmp(roots, same, sizeof roots) == 0);
    if (strcmp(field, "f") == 0) {
        float low = INFINITY, high = -INFINITY;
        for (int64_t i = 0; i < w->grid.cells * w->layers; i++) {
            low = fminf(low, w->values[i]);
            high = fmaxf(high, w->values[i]);
        }
        CHECK((float)r->value_min == low && (float)r->value_max == high);
    }
}

/* Mountains where `values` at corners are high: what is not a number stays so. */
static float *raise(icoray_ctx *ctx, icoray_array array)
{
    size_t layers = (size_t)array.layers, count = (size_t)array.columns * layers;
    const float *values = array.data;
    float *heights = calloc(count + 1, sizeof *heights);
    for (size_t i = 0; i < count; i++) {
        heights[i] = 6e3f * (float)(i % layers) + 2e3f * values[i];
    }
    array.data = heights;
    OK(icoray_heights_set(ctx, &array));
    return heights;
}

static void draw(const char *directory, const World *w, int kind)
{
    icoray_config config;
    int *owner = partition(w, kind, ranks);
    Cut mine;
    if (owner == NULL) {
        return;
    }
    trying = KINDS[kind];
    mine = cut(w, owner, rank, 1);
    config = plain(path_of(directory, KINDS[kind]));
    config.threads = 1 + rank % 2;
    config.log = hear;
    config.log_level = ICORAY_LOG_DEBUG;
    icoray_ctx *ctx = opened_by_all(&config);
    fill_cut(ctx, &mine, w->layers);
    float *heights = raise(ctx, mine.corner);
    OK(icoray_part_set(ctx, &mine.part));
    memset((void *)(uintptr_t)mine.part.cell_global, 0x55, (size_t)mine.part.cells * 4); /* nothing is kept of it */
    heard = 0;
    node_ranks = getenv("ICORAY_NODE_RANKS") != NULL ? atoi(getenv("ICORAY_NODE_RANKS")) : 0;
    for (size_t i = 0; i < sizeof SCENES / sizeof *SCENES; i++) {
        icoray_frame_report report;
        set(ctx, i);
        OK(icoray_execute(ctx, (int64_t)i, 0.0, NULL));
        CHECK(heard == (int)i + 1);
        report = report_of(ctx);
        check_report(&report, w, i);
        if (rank == 0 && i == 0) {
            printf("note: %s: %d ranks, %d rays of %d fragments, %.1f kB\n", KINDS[kind], ranks, (int)report.rays,
                   (int)report.fragments, (double)report.fragment_bytes / 1e3);
        }
    }
    OK(icoray_close(&ctx));
    end_cut(&mine);
    free(heights);
    free(owner);
}

/* Of the whole grid, and the same where it is called a part that has all. */
static void draw_alone(const char *directory, const World *w, int has_part)
{
    icoray_array corner = w->array;
    float *values = corner_values(w);
    icoray_ctx *ctx = alone(path_of(directory, has_part ? "part" : "whole"), w);
    corner.data = values;
    corner.location = ICORAY_CORNER;
    corner.columns = w->grid.corners;
    OK(icoray_field_set(ctx, "v", &corner));
    float *heights = raise(ctx, corner);
    if (has_part) {
        int *owner = partition(w, CONTIGUOUS, 1);
        Cut all = cut(w, owner, 0, 1);
        icoray_part part = all.part;
        int32_t *number = (int32_t *)(uintptr_t)part.cell_global;
        OK(icoray_part_set(ctx, &part));
        /* Each cell and corner has one owner here too. */
        part.owned_cells--;
        REFUSED(ctx, GRID, "owned by no rank", icoray_part_set(ctx, &part));
        part.owned_cells++;
        number[1] = number[0];
        REFUSED(ctx, GRID, "expected different numbers", icoray_part_set(ctx, &part));
        end_cut(&all);
        free(owner);
    }
    for (size_t i = 0; i < sizeof SCENES / sizeof *SCENES; i++) {
        icoray_frame_report report;
        set(ctx, i);
        OK(icoray_execute(ctx, (int64_t)i, 0.0, NULL));
        report = report_of(ctx);
        CHECK(report.ranks == 1 && report.scheme == ICORAY_ALONE);
        CHECK(report.bytes_copied == 0 && report.fragment_bytes == 0 && (report.fragments > 0) == (strstr(SCENES[i].more, "ranks") != NULL));
    }
    OK(icoray_close(&ctx));
    free(heights);
    free(values);
}

int main(int argc, char **argv)
{
    World w;
    if (argc > 2 && strcmp(argv[2], "serial") == 0) {
        w = world(4, 4);
        draw_alone(argv[1], &w, 0);
        draw_alone(argv[1], &w, 1);
        end_world(&w);
        return verdict("mpi_parts");
    }
    begin(&argc, &argv);
    w = world(4, 4);
    is_small = argc > 2 && strcmp(argv[2], "small") == 0;
    if (is_small) {
        take_all();
    }
    for (int kind = 0; kind < (is_small ? 1 : PARTITIONS); kind++) {
        draw(argv[1], &w, kind);
    }
    end_world(&w);
    return end("mpi_parts");
}
