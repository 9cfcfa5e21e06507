/*
 * The host's floating-point environment: host_floats <directory>
 *
 * With any rounding mode, flushing, traps and raised flags of the model, each call restores them, draws the same
 * picture, and raises no trap, also on the library's threads.
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
    Floats now = {.rounding = fegetround(), .flags = fetestexcept(FE_ALL_EXCEPT), .traps = fegetexcept()};
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

/* Compares the environment before and after a call; the checks follow, as they may do arithmetic themselves. */
static Floats before;
#define KEEPS_AND(call, is_expected)                                                                         \
    do {                                                                                                     \
        before = floats();                                                                                   \
        icoray_status status = (call);                                                                       \
        Floats after = floats();                                                                             \
        check(same(before, after), "floating-point environment after " #call, HERE);                         \
        is_expected;                                                                                         \
    } while (0)
#define KEEPS(call) KEEPS_AND(call, went_well(status, #call, HERE))
#define KEEPS_FAILING(call) KEEPS_AND(call, CHECK(status != ICORAY_OK))

/* Checks that floats() sees a change: of flags by an inexact quotient, and of each setting; and that traps work. */
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
    const char *name = text_of("%s/%d%d_%s", directory, kind, async, setting->name);
    char text[512];
    icoray_ctx *ctx = NULL;
    icoray_mesh *mesh = NULL, *none = NULL;
    icoray_grid grid = {sizeof grid};
    int32_t wants = 0;
    icoray_config config = CONFIG(.output_dir = name, .async_render = async, .threads = 2);
    double radius[HOST_LAYERS] = {6371e3, 6376e3, 6383e3, 6391e3};
    icoray_layers layers = {.struct_size = sizeof layers, .count = HOST_LAYERS, .radius_m = radius,
                            .planet_radius_m = 6371e3};
    icoray_frame_report report = {sizeof report};
    const char *scene = "field = \"f\"\nexaggeration = 40\n[image]\nwidth = 24\nheight = 24\n" VIEW
                        "[light]\nkind = \"headlight\"\n[output]\nfile = \"frame_{step}.png\"\n";

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
    CHECK(same_files(text_of("%s/%d0_default/frame_2.png", directory, kind), path_of(name, "frame_2.png")));
}

/* Values that raise every flag in arithmetic: NaN, infinities, denormals, numbers whose sums overflow. */
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
