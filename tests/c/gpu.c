/*
 * Scenes that ask for a GPU, and for the CPU: gpu DIRECTORY here|gone. Pictures of a kind have the same names in the folders
 * cpu and gpu. `gone` means that there is no adapter: then the CPU draws both.
 */
#include "host.h"

#include <math.h>

/* Lines of the log that name the drawing device. */
typedef struct {
    int drawn, warned;
    char last[512];
} Lines;

static void listen(void *user, int32_t level, const char *message)
{
    Lines *lines = (Lines *)user;
    if (strstr(message, "drawn") == NULL || level > ICORAY_LOG_INFO) {
        return;
    }
    lines->drawn++;
    lines->warned += level <= ICORAY_LOG_WARN;
    snprintf(lines->last, sizeof lines->last, "%s", message);
}

static const char *const KINDS[] = {"", "light = { kind = \"headlight\" }\n", "time_budget_ms = 60000\n", "core = \"transparent\"\nbackground = \"transparent\"\n"};

static void set(icoray_ctx *ctx, const char *keys, int kind)
{
    set_view(ctx, text_of("%s\n%s", keys, KINDS[kind]), 130, 97, text_of("[output]\nfile = \"%d_{step}.exr\"\n", kind));
}

/* All kinds of scenes, twice each; the last report. */
static icoray_frame_report draw(icoray_ctx *ctx, const char *keys)
{
    icoray_frame_report report = {0};
    int64_t step = 0;
    for (int kind = 0; kind < (int)COUNT(KINDS); kind++) {
        set(ctx, keys, kind);
        for (int i = 0; i < 2; i++, step++) {
            OK(icoray_execute(ctx, step, 0.0, NULL));
        }
        OK(icoray_wait(ctx));
        report = report_of(ctx);
        CHECK(report.rays > 1000 && report.frusta > report.rays && report.pixel_step == 1);
    }
    CHECK(report.frames_written == (uint64_t)step && report.frames_failed == 0);
    return report;
}

/* A context of its own for scenes with `keys`, whose pictures go to directory/name. */
static icoray_frame_report drawn(const char *directory, const char *name, const char *keys, const World *w, int is_async,
                                 Lines *lines)
{
    icoray_frame_report report;
    icoray_ctx *ctx;
    memset(lines, 0, sizeof *lines);
    icoray_config config = CONFIG(.output_dir = path_of(directory, name), .threads = 2, .async_render = is_async,
                                  .log = listen, .log_user = lines, .log_level = ICORAY_LOG_DEBUG);
    ctx = opened(&config, w, 16);
    report = draw(ctx, keys);
    OK(icoray_close(&ctx));
    return report;
}

static void is_of_the_cpu(const icoray_frame_report *r)
{
    CHECK(r->drawn_on == ICORAY_CPU && r->upload_s == 0.0 && isnan(r->device_s) && r->bytes_uploaded == 0);
}

int main(int argc, char **argv)
{
    const char *directory = argc > 2 ? argv[1] : "";
    int is_gone = argc > 2 && strcmp(argv[2], "gone") == 0;
    World w = world(4, HOST_LAYERS);
    icoray_frame_report report;
    Lines lines;
    int threads, files;
    report = drawn(directory, "cpu", "backend = \"cpu\"", &w, 0, &lines);
    is_of_the_cpu(&report);
    CHECK(lines.drawn == 0);
    threads = threads_now();
    for (int is_async = 0; is_async < 2; is_async++) {
        trying = is_async ? "in the background" : "in the call";
        report = drawn(directory, is_async ? "async" : "gpu", "backend = \"gpu\"\ndevice = 0", &w, is_async, &lines);
        CHECK(lines.drawn == 1 && lines.warned == is_gone);
        if (is_gone) {
            is_of_the_cpu(&report);
            CHECK(strstr(lines.last, "drawn on the CPU: no Vulkan adapter was found") != NULL);
            continue;
        }
        CHECK(report.drawn_on == ICORAY_GPU && report.upload_s > 0.0 && report.upload_s <= report.render_s);
        CHECK(report.bytes_uploaded >= (uint64_t)(w.grid.cells * w.layers * 4));
        CHECK(isnan(report.device_s) || (report.device_s > 0.0 && report.device_s < report.render_s));
        CHECK(strncmp(lines.last, "step 0: drawn on ", 17) == 0 && strstr(lines.last, "CPU:") == NULL);
    }
    trying = "";
    /* A GPU that is not there is missed once, by name. */
    report = drawn(directory, "other", "backend = \"gpu\"\ndevice = \"Voodoo\"", &w, 0, &lines);
    is_of_the_cpu(&report);
    CHECK(lines.drawn == 1 && lines.warned == 1);
    CHECK(is_gone || strstr(lines.last, "\"Voodoo\"") != NULL);
    /* Without a requested device the log has a line and no warning. */
    report = drawn(directory, "auto", "", &w, 0, &lines);
    CHECK(lines.drawn == 1 && lines.warned == 0);
    CHECK(settles_at(threads));
    /* Contexts that come and go leave no files open. */
    files = open_files();
    for (int i = 0; i < 2; i++) {
        drawn(directory, "again", "backend = \"gpu\"\n", &w, 0, &lines);
        if (i == 0) {
            CHECK(remove(path_of(directory, "again/report.csv")) == 0);
            for (int k = 0; k < 2 * (int)COUNT(KINDS); k++) {
                CHECK(remove(text_of("%s/again/%d_%d.exr", directory, k / 2, k)) == 0);
            }
        }
    }
    CHECK(open_files() <= files && settles_at(threads));
    end_world(&w);
    return verdict("gpu");
}
