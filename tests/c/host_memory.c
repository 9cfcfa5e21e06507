/*
 * Allocation as the host sees it: host_memory <directory>
 *
 * The program's own malloc counts the library's allocations. From the second frame on they are those of a picture, for
 * any size of field and mesh and any layout; averages of corners and copies for async_render have the reported size.
 */
#define _GNU_SOURCE

#include "host.h"

#include <errno.h>
#include <malloc.h>
#include <math.h>

#define PIXELS 48
#define FRAMES 4
/* Further bytes of a frame with more layers: tables of radii and spans, per layer. */
#define PER_LAYER 256
/* Queues of the pool grow when they like. */
#define SLACK 16384
/* The channels to and from the thread that draws, made when first used. */
#define CHANNELS 24576
/* Scene, plan and report of a frame that is handed over, however large its fields are. */
#define HANDING_OVER 16384

extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *memory, size_t size);
extern void *__libc_memalign(size_t alignment, size_t size);
extern void __libc_free(void *memory);

static long total, largest, held, peak;

static void *counted(void *memory, size_t size)
{
    if (memory != NULL) {
        long seen = __atomic_load_n(&largest, __ATOMIC_RELAXED);
        __atomic_add_fetch(&total, (long)size, __ATOMIC_RELAXED);
        while ((long)size > seen && !__atomic_compare_exchange_n(&largest, &seen, (long)size, 0, __ATOMIC_RELAXED,
                                                                 __ATOMIC_RELAXED)) {
        }
        long now = __atomic_add_fetch(&held, (long)malloc_usable_size(memory), __ATOMIC_RELAXED);
        seen = __atomic_load_n(&peak, __ATOMIC_RELAXED);
        while (now > seen &&
               !__atomic_compare_exchange_n(&peak, &seen, now, 0, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
        }
    }
    return memory;
}

void *malloc(size_t size)
{
    return counted(__libc_malloc(size), size);
}

void *calloc(size_t count, size_t size)
{
    return counted(__libc_calloc(count, size), count * size);
}

void free(void *memory)
{
    if (memory != NULL) {
        __atomic_sub_fetch(&held, (long)malloc_usable_size(memory), __ATOMIC_RELAXED);
        __libc_free(memory);
    }
}

void *realloc(void *memory, size_t size)
{
    long before = memory == NULL ? 0 : (long)malloc_usable_size(memory);
    void *moved = __libc_realloc(memory, size);
    if (moved != NULL) {
        __atomic_sub_fetch(&held, before, __ATOMIC_RELAXED);
    }
    return counted(moved, size);
}

void *memalign(size_t alignment, size_t size)
{
    return counted(__libc_memalign(alignment, size), size);
}

void *aligned_alloc(size_t alignment, size_t size)
{
    return memalign(alignment, size);
}

int posix_memalign(void **memory, size_t alignment, size_t size)
{
    *memory = memalign(alignment, size);
    return *memory == NULL ? ENOMEM : 0;
}

enum layout { LEVEL_FASTEST, CELL_FASTEST, BLOCKED, PADDED, LAYOUTS };
static const char *const names[] = {"level-fastest", "cell-fastest", "blocked", "padded"};

typedef struct {
    void *memory;
    icoray_array array;
} Data;

/* An array that is not counted: it is the host's. */
static Data data(const icoray_grid *grid, enum layout layout, int layers, int type, int location)
{
    int64_t columns = location == ICORAY_CORNER ? grid->corners : grid->cells, block = 16;
    int64_t blocks = (columns + block - 1) / block, row = layout == PADDED ? layers + 5 : layers;
    size_t elements = (size_t)(layout == BLOCKED ? blocks * block * layers : columns * row);
    Data d = {.memory = __libc_calloc(elements, type == ICORAY_F32 ? 4 : 8)};
    for (size_t i = 0; i < elements; i++) {
        double value = sin(0.01 * (double)i);
        set_real(d.memory, type, (int64_t)i, value);
    }
    int has_rows = layout == LEVEL_FASTEST || layout == PADDED;
    d.array = (icoray_array){.struct_size = sizeof d.array, .data = d.memory, .type = type, .location = location,
                             .columns = columns, .layers = layers, .column_stride = has_rows ? row : 1,
                             .layer_stride = has_rows ? 1 : layout == BLOCKED ? block : columns,
                             .block = layout == BLOCKED ? block : 0,
                             .block_stride = layout == BLOCKED ? block * layers : 0};
    return d;
}

typedef struct {
    long first, later, largest, largest_later;
    icoray_frame_report report;
} Use;

/* Bytes that frames of a field allocate: the first one, and the largest of the later ones. */
static Use use(const char *directory, const World *w, enum layout layout, int layers, int type, int location, int async,
               const char *light)
{
    Use u = {0};
    Data d = data(&w->grid, layout, layers, type, location);
    World seen = *w;
    seen.array = d.array;
    seen.layers = layers;
    icoray_config config = CONFIG(.output_dir = directory, .existing = ICORAY_OVERWRITE, .threads = 1,
                                  .async_render = async);
    icoray_ctx *ctx = opened(&config, &seen, PIXELS);
    if (light[0] == '\0') {
        set_scene(ctx, PIXELS, "tolerance = 1e-2\nbackend = \"cpu\"");
    } else {
        const char *rest = text_of("[light]\nkind = \"%s\"\n[output]\nfile = \"frame_{step}.png\"\n", light);
        set_view(ctx, "backend = \"cpu\"", PIXELS, PIXELS, rest);
    }
    for (int i = 0; i < FRAMES; i++) {
        total = largest = 0;
        icoray_status status = icoray_execute(ctx, 0, 0.0, NULL);
        icoray_status waited = icoray_wait(ctx);
        long bytes = total, block = largest;
        CHECK(status == ICORAY_OK && waited == ICORAY_OK);
        if (i == 0) {
            u.first = bytes;
            u.largest = block;
        } else {
            u.later = bytes > u.later ? bytes : u.later;
            u.largest_later = block > u.largest_later ? block : u.largest_later;
        }
    }
    u.report = report_of(ctx);
    OK(icoray_close(&ctx));
    __libc_free(d.memory);
    return u;
}

static int near(long a, long b, long most)
{
    return labs(a - b) <= most;
}

/* Fields of 8 and 32 layers on both meshes. */
static void in_place(const char *directory, const World *small, const World *large)
{
    long worst = 0;
    for (int layout = 0; layout < LAYOUTS; layout++) {
        for (int type = ICORAY_F32; type <= ICORAY_F64; type++) {
            trying = names[layout];
            Use thin = use(directory, small, layout, 8, type, ICORAY_CENTER, 0, "");
            Use thick = use(directory, small, layout, 32, type, ICORAY_CENTER, 0, "");
            Use wide = use(directory, large, layout, 8, type, ICORAY_CENTER, 0, "");
            CHECK(near(thin.later, thick.later, 24 * PER_LAYER + SLACK));
            CHECK(near(thin.later, wide.later, SLACK));
            CHECK(thin.largest_later == thick.largest_later && thin.largest_later == wide.largest_later);
            CHECK(thin.largest == thick.largest && thin.largest == wide.largest);
            CHECK(thick.report.bytes_derived == 0 && thick.report.bytes_copied == 0);
            worst = labs(thin.later - thick.later) > worst ? labs(thin.later - thick.later) : worst;
            worst = labs(thin.later - wide.later) > worst ? labs(thin.later - wide.later) : worst;
            if (layout == LEVEL_FASTEST && type == ICORAY_F32) {
                note("a frame of %dx%d allocates %ld bytes, the largest block %ld", PIXELS, PIXELS, thin.later,
                     thin.largest_later);
            }
        }
    }
    note("8 to 32 layers and %d to %d cells in 4 layouts and 2 types: at most %ld bytes apart", (int)small->grid.cells,
         (int)large->grid.cells, worst);
}

/* Averages and gradients are what the report says, and frames behind the first have their memory. */
static void derived(const char *directory, const World *w)
{
    for (int type = ICORAY_F32; type <= ICORAY_F64; type++) {
        for (int lit = 0; lit < 2; lit++) {
            trying = lit ? "corner, lit" : "corner";
            const char *light = lit ? "headlight" : "none";
            Use plainly = use(directory, w, LEVEL_FASTEST, 8, type, ICORAY_CENTER, 0, "none");
            Use thin = use(directory, w, BLOCKED, 8, type, ICORAY_CORNER, 0, light);
            Use thick = use(directory, w, BLOCKED, 32, type, ICORAY_CORNER, 0, light);
            long size = type == ICORAY_F32 ? 4 : 8;
            CHECK((long)thick.report.bytes_derived == w->grid.cells * (32 * (size + (lit ? 8 : 0)) + lit));
            /* Lit tiles have rows of their own for rays side by side, whatever the layers, as thick ones check. */
            CHECK(lit || near(thin.first - plainly.first, (long)thin.report.bytes_derived, 24 * PER_LAYER + SLACK));
            CHECK(near(thick.later, thin.later, 24 * PER_LAYER + SLACK));
            CHECK(near(thick.first - thin.first,
                       (long)thick.report.bytes_derived - (long)thin.report.bytes_derived, 24 * PER_LAYER + SLACK));
            if (type == ICORAY_F32) {
                note("corners%s: 32 layers take %ld bytes more than 8, the report says %ld", lit ? ", lit" : "",
                     thick.first - thin.first,
                     (long)thick.report.bytes_derived - (long)thin.report.bytes_derived);
            }
        }
    }
}

/* The copy is made once and used again. */
static void copied(const char *directory, const World *w)
{
    for (int layout = 0; layout < LAYOUTS; layout++) {
        for (int type = ICORAY_F32; type <= ICORAY_F64; type++) {
            trying = names[layout];
            Use at_once = use(directory, w, layout, 32, type, ICORAY_CENTER, 0, "");
            Use later = use(directory, w, layout, 32, type, ICORAY_CENTER, 1, "");
            long size = type == ICORAY_F32 ? 4 : 8;
            CHECK((long)later.report.bytes_copied == w->grid.cells * 32 * size);
            CHECK(later.largest == (long)later.report.bytes_copied);
            CHECK(near(later.first - at_once.first, (long)later.report.bytes_copied, SLACK + CHANNELS));
            CHECK(near(later.later, at_once.later, SLACK + HANDING_OVER));
            CHECK(later.largest_later == at_once.largest_later);
            if (layout == CELL_FASTEST && type == ICORAY_F64) {
                note("async: the first frame takes %ld bytes more, the report says %ld; later ones %ld",
                     later.first - at_once.first, (long)later.report.bytes_copied, later.later - at_once.later);
            }
        }
    }
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        return EXIT_FAILURE;
    }
    mallopt(M_ARENA_MAX, 1);
    long before = total;
    void *volatile some = malloc(1000);
    free(some);
    CHECK(total - before == 1000);
    held = peak = 0;
    World small = world(3, HOST_LAYERS), large = world(4, HOST_LAYERS);
    in_place(argv[1], &small, &large);
    derived(argv[1], &small);
    copied(argv[1], &small);
    /* The reported peak is the sum of the library's allocations, up to rounding and the host's own. */
    Use last = use(argv[1], &small, LEVEL_FASTEST, 8, ICORAY_F32, ICORAY_CENTER, 0, "");
    long said = (long)last.report.bytes_peak;
    CHECK(said <= peak && said >= peak - peak / 20 - 65536);
    note("the report's peak is %ld bytes, the host counts %ld", said, peak);
    end_world(&small);
    end_world(&large);
    return verdict("host_memory");
}
