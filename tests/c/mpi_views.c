/*
 * Scene files of several views on a grid that is spread over ranks: mpi_views DIRECTORY. Conditions have the
 * same result on all ranks, for any distribution of the values.
 */
#include "mpi_cut.h"

#define STEPS 6

static const char *const SCENE =
    "field = \"f\"\nexaggeration = 60\nimage = { width = 24, height = 20 }\n"
    "camera = { lon = 20, lat = 35, distance = 3.2, fov = 45 }\n"
    "[transfer]\nmap = \"viridis\"\nrange = [-1.5, 1.5]\nopacity = [[-1.5, 0.5], [1.5, 0.3]]\n"
    "[output]\nfile = \"{view}_{step}.png\"\n"
    "[[views]]\nname = \"two\"\nevery = 2\noutput.concat = \"two.ffconcat\"\n"
    "[[views]]\nname = \"high\"\nwhen = \"max(w) > 100\"\n"
    "[[views]]\nname = \"low\"\nwhen = \"min(w) < -100\"\n"
    "[[views]]\nname = \"mean\"\nwhen = [\"mean(w) > 2.999\", \"mean(w) < 3.001\"]\n"
    "[[views]]\nname = \"sides\"\nat_steps = [5]\nsweep.lon = [0, 90]\n"
    "output = { cinema = \"sides.cdb\", file = \"{step}_{lon}.png\" }\n";

/* The values of a step: its number, of which the mean is sure; in one own cell of a rank more, and in another less. */
static void fill_values(float *values, const Cut *mine, const int *owned, int step)
{
    int64_t layers = mine->center.layers, columns = mine->center.columns;
    int seen = 0;
    for (int64_t c = 0; c < columns; c++) {
        for (int64_t l = 0; l < layers; l++) {
            /* What is not its own must not count. */
            values[c * layers + l] = owned[c] ? (float)step : 1e6f;
        }
        if (!owned[c]) {
            continue;
        }
        if (step == 1 && rank == ranks - 1 && seen == 0) {
            values[c * layers] = 101.0f;
        }
        if (step == 4 && rank == 0 && seen == 1) {
            values[c * layers + 1] = -101.0f;
        }
        seen++;
    }
}

/* Which rows of a part are its own, in either way of saying it. */
static int *owned_of(const Cut *mine)
{
    int *owned = calloc((size_t)mine->center.columns + 1, sizeof *owned);
    for (int64_t c = 0; c < mine->center.columns; c++) {
        owned[c] = mine->part.is_owned != NULL ? mine->part.is_owned[c] != 0 : c < mine->part.owned_cells;
    }
    return owned;
}

/* A field that one rank lacks fails one view on all, and no other view. */
static void lost(icoray_ctx *ctx, const icoray_array *w)
{
    const char *text = text_of("%.*s%s", (int)(strstr(SCENE, "[[views]]") - SCENE), SCENE,
                               "[[views]]\nname = \"lost\"\nwhen = \"max(u) > 0\"\n[[views]]\nname = \"good\"\n"
                               "[[views]]\nname = \"bad\"\nfield = \"u\"\n[[views]]\nname = \"fine\"\n");
    if (rank == 0) {
        OK(icoray_field_set(ctx, "u", w));
    }
    OK(icoray_scene_text(ctx, text));
    ALL_REFUSED(FIELD, "rank 1: step 20: view \"lost\": when: field \"u\" was not given by icoray_field_set",
         icoray_execute(ctx, 20, 0.0, NULL));
    CHECK(report_of(ctx).frames == 2 && report_of(ctx).frames_failed == 2);
}

static void draw(const char *directory, const World *w, int kind)
{
    int *owner = partition(w, kind, ranks), *owned;
    icoray_config config = plain(path_of(directory, kind == RANDOM ? "random" : "contiguous"));
    icoray_array array;
    float *values;
    uint64_t drawn = 0;
    Cut mine = cut(w, owner, rank, 1);
    owned = owned_of(&mine);
    values = calloc((size_t)(mine.center.columns * w->layers) + 1, sizeof *values);
    array = mine.center;
    array.data = values;
    icoray_ctx *ctx = opened_by_all(&config);
    fill_cut(ctx, &mine, w->layers);
    OK(icoray_part_set(ctx, &mine.part));
    OK(icoray_field_set(ctx, "w", &array));
    OK(icoray_scene_text(ctx, SCENE));
    for (int step = 0; step < STEPS; step++) {
        int count = (step % 2 == 0) + (step == 1) + (step == 4) + (step == 3) + (step == 5 ? 2 : 0);
        int32_t wants = 7;
        fill_values(values, &mine, owned, step);
        OK(icoray_wants_field(ctx, "w", step, 0.0, &wants));
        CHECK(wants == 1);
        OK(icoray_execute(ctx, step, 60.0 * step, NULL));
        drawn += (uint64_t)count;
        CHECK(report_of(ctx).step == step && report_of(ctx).frames == (uint64_t)count);
    }
    OK(icoray_wait(ctx));
    CHECK(report_of(ctx).frames_written == (rank == 0 ? drawn : 0));
    lost(ctx, &array);
    OK(icoray_close(&ctx));
    free(values);
    free(owned);
    end_cut(&mine);
    free(owner);
}

int main(int argc, char **argv)
{
    World w;
    begin(&argc, &argv);
    w = world(4, 4);
    draw(argv[1], &w, CONTIGUOUS);
    draw(argv[1], &w, RANDOM);
    end_world(&w);
    return end("mpi_views");
}
