/*
 * Scene files of several views: views <directory>
 *
 * The same run twice, in the call and from copies; abi.rs compares the pictures and their lists.
 */
#include "pictures.h"

#define STEPS 8
#define STEP_S 60.0

static const char *const HEAD =
    "field = \"f\"\nbackend = \"cpu\"\nexaggeration = 40\nimage = { width = 48, height = 48 }\n"
    "camera = { lon = 20, lat = 35, distance = 3.2, fov = 45 }\n"
    "[transfer]\nmap = \"viridis\"\nrange = [-1.5, 1.5]\nopacity = [[-1.5, 0.8], [0, 0.1], [1.5, 0.9]]\n"
    "[output]\nfile = \"{view}_{step}.png\"\n";
static const char *const TURNS =
    "[[views]]\nname = \"two\"\nevery = 2\noutput.concat = \"two.ffconcat\"\n"
    "[[views]]\nname = \"around\"\nevery = 3\ncamera.orbit = { turn = 360, steps = 12 }\n";
/* Of the field "w", whose values are the step's number but for one. */
static const char *const ONCE =
    "[[views]]\nname = \"once\"\nfield = \"g\"\nwhen = [\"mean(w) > 5.5\", \"mean(w) < 6.5\", \"max(w) >= 12\"]\n";
/* Due at the first step of 250 s or later, which is 5. */
static const char *const SIDES =
    "[[views]]\nname = \"sides\"\nat_times = [250]\nsweep = { lat = [20, 70], lon = [70, 160, 310] }\n"
    "output = { cinema = \"sides.cdb\", file = \"{step}_{lat}_{lon}.png\" }\n";

/* Fields over the mesh, level-fastest: drawn, drawn by one view, looked at by its conditions. */
static Field f, g, w;

static int asked(icoray_ctx *ctx, const char *name, int step)
{
    int32_t answer = 7;
    if (name == NULL) {
        OK(icoray_wants(ctx, step, STEP_S * step, &answer));
    } else {
        OK(icoray_wants_field(ctx, name, step, STEP_S * step, &answer));
    }
    return answer;
}

static void set_step(int step)
{
    scribble(&w, step);
    ((float *)w.memory)[1] = (float)(2 * step);
    memcpy(w.before, w.memory, w.bytes);
}

static icoray_ctx *opened_at(const char *directory, const char *name, int in_background)
{
    icoray_config config = {.threads = 2, .async_render = in_background};
    icoray_ctx *ctx = context_with(directory, name, config);
    OK(icoray_field_set(ctx, "f", &f.array));
    OK(icoray_field_set(ctx, "g", &g.array));
    OK(icoray_field_set(ctx, "w", &w.array));
    return ctx;
}

static icoray_frame_report waited_for(icoray_ctx *ctx)
{
    OK(icoray_wait(ctx));
    return report_of(ctx);
}

static void run(const char *directory, int in_background)
{
    icoray_ctx *ctx = opened_at(directory, in_background ? "background" : "call", in_background);
    uint64_t drawn = 0;
    OK(icoray_scene_text(ctx, text_of("%s%s%s%s", HEAD, TURNS, ONCE, SIDES)));
    for (int step = 0; step < STEPS; step++) {
        int two = step % 2 == 0, around = step % 3 == 0, once = step == 6, sides = step == 5 ? 6 : 0;
        int count = two + around + once + sides;
        set_step(step);
        /* The condition may hold, as far as is known before it is looked at. */
        CHECK(asked(ctx, NULL, step) == 1 && asked(ctx, "w", step) == 1 && asked(ctx, "g", step) == 1);
        CHECK(asked(ctx, "f", step) == (two || around || sides) && asked(ctx, "h", step) == 0);
        OK(icoray_execute(ctx, step, STEP_S * step, NULL));
        drawn += (uint64_t)count;
        if (in_background) {
            scribble(&f, 0.25);
            scribble(&g, 0.25);
        }
        if (count > 0) {
            icoray_frame_report report = waited_for(ctx);
            uint64_t copied = (two || around || sides ? bytes_of(&f) : 0) + (once ? bytes_of(&g) : 0);
            CHECK(report.step == step && report.frames == (uint64_t)count && report.rays > 0);
            CHECK(report.frames_written == drawn && report.frames_failed == 0 && report.host_s > 0.0);
            /* Once for all views. */
            CHECK(report.bytes_copied == (in_background ? copied : 0));
            CHECK((report.copy_s > 0.0) == in_background);
        }
        memcpy(f.memory, f.before, f.bytes);
        memcpy(g.memory, g.before, g.bytes);
    }
    /* Only what has a turn of its own, which is known without a look at the fields. */
    OK(icoray_scene_text(ctx, text_of("%s%s", HEAD, TURNS)));
    for (int step = 100; step < 112; step++) {
        int due = step % 2 == 0 || step % 3 == 0;
        CHECK(asked(ctx, NULL, step) == due && asked(ctx, "f", step) == due && asked(ctx, "w", step) == 0);
    }
    OK(icoray_close(&ctx));
}

/* A failure of one view does not stop the others; the first failure is returned. */
static void failures(const char *directory, int in_background)
{
    static const char parts[] =
        "[[views]]\nname = \"good\"\n[[views]]\nname = \"bad\"\nfield = \"q\"\n[[views]]\nname = \"within\"\n"
        "camera.distance = 0.5\n[[views]]\nname = \"fine\"\n";
    static const char conditions[] =
        "[[views]]\nname = \"lost\"\nwhen = \"max(q) > 1\"\n[[views]]\nname = \"other\"\nwhen = \"min(w) > 1\"\n";
    static const char taken[] = "[[views]]\nname = \"good\"\n[[views]]\nname = \"new\"\n";
    icoray_ctx *ctx = opened_at(directory, in_background ? "bad_background" : "bad_call", in_background);
    icoray_frame_report report;
    OK(icoray_scene_text(ctx, text_of("%s%s", HEAD, parts)));
    REFUSED(ctx, FIELD, "step 9: view \"bad\": the scene's field \"q\" was not given by icoray_field_set",
            icoray_execute(ctx, 9, 0.0, NULL));
    report = waited_for(ctx);
    CHECK(report.frames == 2 && report.frames_written == 2 && report.frames_failed == 2);
    /* Files that are there are the user's wish, and no failures. */
    OK(icoray_scene_text(ctx, text_of("%s%s", HEAD, taken)));
    REFUSED(ctx, EXISTS, "step 9: view \"good\": ", icoray_execute(ctx, 9, 0.0, NULL));
    report = waited_for(ctx);
    CHECK(report.frames == 1 && report.frames_written == 3 && report.frames_failed == 2);
    set_step(3);
    OK(icoray_scene_text(ctx, text_of("%s%s", HEAD, conditions)));
    REFUSED(ctx, FIELD, "step 10: view \"lost\": when: field \"q\" was not given by icoray_field_set",
            icoray_execute(ctx, 10, 0.0, NULL));
    report = waited_for(ctx);
    CHECK(report.frames == 1 && report.frames_written == 4 && report.frames_failed == 3);
    OK(icoray_close(&ctx));
}

/* The message names line and key; the script before stays. */
static void refused_scripts(const char *directory)
{
    static const struct {
        const char *text, *part;
    } cases[] = {
        {"[[views]]\nname = \"a\"\nevery = 0\n", "view \"a\": line 14, key every: 0"},
        {"[[views]]\nname = \"a\"\nwhen = \"most(w) > 1\"\n", "expected min, max or mean"},
        {"[[views]]\nname = \"a\"\ncolour = 1\n", "line 14"},
        {"[[views]]\nname = \"a\"\n[[views]]\nname = \"a\"\n", "\"a\""},
        {"[[views]]\nname = \"a\"\ncamera.lat = 95\n", "view \"a\": line 14, key camera.lat: 95"},
    };
    icoray_ctx *ctx = opened_at(directory, "refused", 0);
    OK(icoray_scene_text(ctx, text_of("%s%s", HEAD, TURNS)));
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        trying = cases[i].text;
        REFUSED(ctx, SCENE, cases[i].part, icoray_scene_text(ctx, text_of("%s%s", HEAD, trying)));
        CHECK(asked(ctx, NULL, 2) == 1 && asked(ctx, NULL, 1) == 0);
    }
    trying = "";
    OK(icoray_close(&ctx));
}

int main(int argc, char **argv)
{
    size_t n;
    CHECK(argc == 2);
    make_mesh(3);
    n = (size_t)cells * LAYERS;
    f = field(ICORAY_F32, ICORAY_CENTER, LAYERS, n, 0, LAYERS, 1);
    g = field(ICORAY_F64, ICORAY_CENTER, LAYERS, n, 0, 1, cells);
    w = field(ICORAY_F32, ICORAY_CENTER, LAYERS, n, 0, LAYERS, 1);
    for (int in_background = 0; in_background < 2; in_background++) {
        run(argv[1], in_background);
        failures(argv[1], in_background);
    }
    refused_scripts(argv[1]);
    release(&f);
    release(&g);
    release(&w);
    OK(icoray_mesh_free(&mesh));
    return verdict("views");
}
