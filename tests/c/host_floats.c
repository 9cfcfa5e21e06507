/*
 * The host's floating-point environment: host_floats <directory>
 *
 * Whatever rounding, flushing, traps and raised flags a model runs with, each call leaves them as they were, draws the
 * same picture, and takes no trap, on the library's threads neither.
 */
#define _GNU_SOURCE /* feenableexcept */

#include "host.h"

#include <fenv.h>
#include <math.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __SSE__
#include <xmmintrin.h>
#endif

#define FLUSH 0x8040u /* flush to zero, denormals are zero */
#define TRAPS (FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW)

typedef struct {
    int rounding, flags, traps;
    unsigned sse;
    unsigned short x87;
} Floats;

static Floats floats(void)
{
    Floats now;
    memset(&now, 0, sizeof now);
    now.rounding = fegetround();
    now.flags = fetestexcept(FE_ALL_EXCEPT);
    now.traps = fegetexcept();
#ifdef __SSE__
    now.sse = _mm_getcsr();
#endif
#if defined(__x86_64__) || defined(__i386__)
    __asm__ volatile("fnstcw %0" : "=m"(now.x87));
#endif
    return now;
}

static int same(Floats a, Floats b)
{
    return a.rounding == b.rounding && a.flags == b.flags && a.traps == b.traps && a.sse == b.sse &&
           a.x87 == b.x87;
}

/* The environments that are tried. */
typedef struct {
    const char *name;
    int rounding, flags, traps;
    unsigned sse;
} Setting;

static const Setting settings[] = {
    {"default", FE_TONEAREST, 0, 0, 0},
    {"flags", FE_TONEAREST, FE_INEXACT | FE_UNDERFLOW, 0, 0},
    {"all flags", FE_TONEAREST, FE_ALL_EXCEPT, 0, 0},
    {"down", FE_DOWNWARD, 0, 0, 0},
    {"up and flushed", FE_UPWARD, FE_INEXACT, 0, FLUSH},
    {"to zero", FE_TOWARDZERO, 0, 0, 0},
    {"traps", FE_TONEAREST, 0, TRAPS, 0},
    {"traps, flushed, down", FE_DOWNWARD, FE_INEXACT, TRAPS, FLUSH},
};

static void set(const Setting *to)
{
    fedisableexcept(FE_ALL_EXCEPT);
    feclearexcept(FE_ALL_EXCEPT);
#ifdef __SSE__
    _mm_setcsr((_mm_getcsr() & ~FLUSH) | to->sse);
#endif
    fesetround(to->rounding);
    /* Raised before traps are on, or raising them would be a trap. */
    feraiseexcept(to->flags & ~FE_INVALID);
    if (to->flags & FE_INVALID) {
        volatile double zero = 0.0;
        volatile double nan = zero / zero;
        (void)nan;
    }
    if (to->traps != 0) {
        feenableexcept(to->traps);
    }
}

/* One call between two looks; checks come later, for they might do arithmetic of their own. */
static Floats before;
#define KEEPS(call)                                                                                          \
    do {                                                                                                     \
        before = floats();                                                                                   \
        icoray_status status = (call);                                                                       \
        Floats after = floats();                                                                             \
        check(same(before, after), "floating-point environment after " #call, HERE);                         \
        went_well(status, #call, HERE);                                                                      \
    } while (0)
#define KEEPS_FAILING(call)                                                                                  \
    do {                                                                                                     \
        before = floats();                                                                                   \
        icoray_status status = (call);                                                                       \
        Floats after = floats();                                                                             \
        check(same(before, after), "floating-point environment after " #call, HERE);                         \
        CHECK(status != ICORAY_OK);                                                                          \
    } while (0)

/* The look can fail: an inexact sum shows, and a trap is one. */
static void looks(void)
{
    volatile double third = 3.0;
    set(&settings[0]);
    before = floats();
    third = 1.0 / third;
    Floats after = floats();
    CHECK(!same(before, after));
    for (size_t i = 0; i < sizeof settings / sizeof *settings; i++) {
        trying = settings[i].name;
        set(&settings[0]);
        before = floats();
        set(&settings[i]);
        after = floats();
        set(&settings[0]);
        CHECK(i == 0 || !same(before, after));
    }
    fflush(stdout);
    pid_t child = fork();
    if (child == 0) {
        volatile double zero = 0.0;
        signal(SIGFPE, SIG_DFL); /* a sanitizer would make a report of it */
        set(&settings[6]);
        zero = zero / zero;
        _exit(0);
    }
    int status = 0;
    CHECK(waitpid(child, &status, 0) == child);
    CHECK(WIFSIGNALED(status) && WTERMSIG(status) == SIGFPE);
    set(&settings[0]);
}

static void draw(const char *directory, const World *w, const Setting *setting, int async, int kind)
{
    char name[256], text[512];
    icoray_ctx *ctx = NULL;
    icoray_mesh *mesh = NULL, *none = NULL;
    icoray_grid grid;
    int32_t wants = 0;
    snprintf(name, sizeof name, "%s/%d%d_%s", directory, kind, async, setting->name);
    icoray_config config = plain(name);
    config.async_render = async;
    config.threads = 2;
    icoray_layers layers;
    double radius[HOST_LAYERS] = {6371e3, 6376e3, 6383e3, 6391e3};
    memset(&layers, 0, sizeof layers);
    layers.struct_size = sizeof layers;
    layers.count = HOST_LAYERS;
    layers.radius_m = radius;
    layers.planet_radius_m = 6371e3;
    memset(&grid, 0, sizeof grid);
    grid.struct_size = sizeof grid;
    icoray_frame_report report;
    memset(&report, 0, sizeof report);
    report.struct_size = sizeof report;
    const char *scene = "field = \"f\"\nexaggeration = 40\n[image]\nwidth = 24\nheight = 24\n[camera]\nlon = 20\n"
                        "lat = 35\ndistance = 3.2\nfov = 45\n[transfer]\nmap = \"viridis\"\nrange = [-1.5, 1.5]\n"
                        "opacity = [[-1.5, 0.8], [0, 0.1], [1.5, 0.9]]\n[light]\nkind = \"headlight\"\n"
                        "[output]\nfile = \"frame_{step}.png\"\n";

    set(setting);
    KEEPS(icoray_open_serial(&config, &ctx));
    KEEPS(icoray_mesh_create(2, &mesh));
    KEEPS(icoray_mesh_grid(mesh, &grid));
    KEEPS(icoray_grid_set(ctx, &w->grid));
    KEEPS(icoray_layers_set(ctx, &layers));
    KEEPS(icoray_field_set(ctx, "f", &w->array));
    KEEPS(icoray_scene_text(ctx, scene));
    KEEPS(icoray_wants(ctx, 1, 0.0, &wants));
    for (int step = 0; step < 3; step++) {
        KEEPS(icoray_execute(ctx, step, 0.5, NULL));
    }
    KEEPS(icoray_wait(ctx));
    KEEPS(icoray_report(ctx, &report));
    KEEPS_FAILING(icoray_execute(ctx, 1, 0.5, NULL));
    KEEPS_FAILING(icoray_scene_text(ctx, "x"));
    KEEPS_FAILING(icoray_field_set(ctx, "f", NULL));
    KEEPS_FAILING(icoray_mesh_create(99, &none));
    KEEPS(icoray_last_error(ctx, text, sizeof text));
    KEEPS(icoray_close(&ctx));
    set(&settings[0]);
    OK(icoray_mesh_free(&mesh));

    CHECK(wants == 1 && report.rays > 0 && report.frames_written == 3);
    snprintf(text, sizeof text, "%s/%d0_default", directory, kind);
    CHECK(same_files(path_of(text, "frame_2.png"), path_of(name, "frame_2.png")));
}

/* Fields that computing with raises every flag: NaN, infinities, denormals, numbers whose sums overflow. */
static void spoil(World *w, int kind)
{
    static const float odd[] = {1e-42f, 3.4e38f, -3.4e38f, 1e-38f};
    for (int64_t i = 0; i < w->grid.cells * HOST_LAYERS; i++) {
        if (kind == 1) {
            w->values[i] = i % 11 == 0 ? NAN : i % 17 == 0 ? INFINITY : i % 19 == 0 ? -INFINITY : w->values[i];
        } else if (kind == 2) {
            w->values[i] = odd[i % 4];
        } else if (kind == 3) {
            w->values[i] = NAN;
        }
    }
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        return EXIT_FAILURE;
    }
    looks();
    for (int kind = 0; kind < 4; kind++) {
        set(&settings[0]);
        World w = world(2, HOST_LAYERS);
        spoil(&w, kind);
        for (size_t i = 0; i < sizeof settings / sizeof *settings; i++) {
            trying = settings[i].name;
            draw(argv[1], &w, &settings[i], 0, kind);
            draw(argv[1], &w, &settings[i], 1, kind);
        }
        end_world(&w);
    }
    return verdict("host_floats");
}
