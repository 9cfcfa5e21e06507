/*
 * A writer in trouble: host_writer <directory> <trouble>
 *
 * Each failure is a status and a message of a later call; other frames are still written, and no incomplete file is
 * left. `full` needs a small file system at <directory>.
 */
#define _GNU_SOURCE

#include "host.h"

#include <dirent.h>
#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* A verdict whose line is not printed. */
static int silent_verdict(void)
{
    fflush(stdout);
    int nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, STDOUT_FILENO);
    return verdict("");
}

static const char *message_of(icoray_ctx *ctx)
{
    static char message[1024];
    OK(icoray_last_error(ctx, message, sizeof message));
    return message;
}

/* Each of the frames fails, which shows when it has been waited for or at the next call. */
static void fails(icoray_ctx *ctx, int step, const char *part, const char *path)
{
    OK(icoray_execute(ctx, step, 0.0, NULL));
    CHECK(icoray_wait(ctx) == ICORAY_ERR_IO);
    CHECK(strstr(message_of(ctx), text_of("step %d: ", step)) != NULL);
    CHECK(strstr(message_of(ctx), part) != NULL && strstr(message_of(ctx), path) != NULL);
    OK(icoray_wait(ctx)); /* returned once */
    OK(icoray_execute(ctx, step + 1, 0.0, NULL));
    for (int i = 0; i < 1000 * PATIENCE_S && report_of(ctx).frames_failed % 2 != 0; i++) {
        rest_ms(1);
    }
    /* The next call returns the failure, and draws its own frame. */
    CHECK(icoray_execute(ctx, step + 2, 0.0, NULL) == ICORAY_ERR_IO);
    CHECK(strstr(message_of(ctx), text_of("step %d: ", step + 1)) != NULL);
    CHECK(report_of(ctx).step == step + 2);
    CHECK(icoray_wait(ctx) == ICORAY_ERR_IO);
    OK(icoray_execute(ctx, step + 3, 0.0, NULL));
    CHECK(icoray_wait(ctx) == ICORAY_ERR_IO);
    CHECK(report_of(ctx).frames_failed % 4 == 0);
}

static void well(icoray_ctx *ctx, const char *directory, int step)
{
    uint64_t written = report_of(ctx).frames_written;
    DRAW(ctx, step, 0.0, NULL);
    CHECK(report_of(ctx).frames_written == written + 1);
    CHECK(is_whole_png(text_of("%s/frame_%d.png", directory, step)));
}

static void full(const char *directory, const World *w)
{
    static char nothing[4096];
    icoray_config config = CONFIG(.output_dir = directory, .existing = ICORAY_OVERWRITE);
    icoray_ctx *ctx = opened(&config, w, 64);
    DRAW(ctx, 0, 0.0, NULL);
    int filler = open(path_of(directory, "filler"), O_CREAT | O_WRONLY, 0600);
    for (int i = 0; i < 4096 && write(filler, nothing, sizeof nothing) > 0; i++) {
    }
    CHECK(write(filler, nothing, 1) < 0);
    fails(ctx, 10, "No space left", "frame_10.png");
    int pictures = entries(directory, ".png");
    CHECK(pictures == 1 && entries(directory, ".tmp") == 0);
    /* The picture that was there is still whole where the new one finds no room. */
    OK(icoray_execute(ctx, 0, 0.0, NULL));
    CHECK(icoray_wait(ctx) == ICORAY_ERR_IO);
    CHECK(is_whole_png(path_of(directory, "frame_0.png")));
    CHECK(close(filler) == 0 && remove(path_of(directory, "filler")) == 0);
    well(ctx, directory, 20);
    OK(icoray_close(&ctx));
    CHECK(entries(directory, ".tmp") == 0);
    /* The report is whole lines, of whole pictures. */
    FILE *report = fopen(path_of(directory, "report.csv"), "r");
    char line[2048];
    int lines = 0;
    while (report != NULL && fgets(line, sizeof line, report) != NULL) {
        lines++;
        CHECK(strstr(line, lines == 1 ? "step," : lines == 2 ? "frame_0.png" : "frame_20.png") != NULL);
    }
    fclose(report);
    CHECK(lines == 3);
}

/* As a user who may not write there; root may write anywhere. */
static int denied_as_user(const char *directory, const World *w)
{
    if (geteuid() == 0 && (setgid(65534) != 0 || setuid(65534) != 0)) {
        return 0;
    }
    const char *mine = path_of(directory, "open/mine");
    icoray_config config = plain(path_of(directory, "closed"));
    icoray_ctx *ctx = NULL;
    REFUSED(NULL, IO, "ermission denied", icoray_open_serial(&config, &ctx));
    config.output_dir = path_of(directory, "closed/further");
    REFUSED(NULL, IO, "closed/further: cannot make pictures", icoray_open_serial(&config, &ctx));
    CHECK(ctx == NULL);

    /* By the scene's names; and closed after all was well. */
    CHECK(mkdir(mine, 0755) == 0);
    config.output_dir = mine;
    ctx = opened(&config, w, 16);
    REFUSED(ctx, IO, "ermission denied",
            icoray_scene_text(ctx, "field = \"f\"\n[camera]\nlon = 0\nlat = 0\ndistance = 3\n"
                                   "[transfer]\nmap = \"viridis\"\nrange = [0, 1]\nopacity = [[0, 0], [1, 0.5]]\n"
                                   "[output]\nfile = \"../../closed/{step}.png\"\n"));
    CHECK(chmod(mine, 0555) == 0);
    fails(ctx, 10, "ermission denied", "open/mine");
    OK(icoray_close(&ctx));
    CHECK(rmdir(mine) == 0);
    return 1;
}

static void denied(const char *directory, const World *w)
{
    CHECK(mkdir(path_of(directory, "closed"), 0555) == 0 && chmod(directory, 0755) == 0);
    CHECK(chmod(path_of(directory, "closed"), 0555) == 0);
    CHECK(mkdir(path_of(directory, "open"), 0777) == 0 && chmod(path_of(directory, "open"), 0777) == 0);
    fflush(stdout);
    pid_t child = fork();
    if (child == 0) {
        int is_user = denied_as_user(directory, w);
        if (!is_user) {
            note("skipped: cannot become another user");
        }
        /* The child's verdict covers its checks; only the lines of failures belong in the test's output. */
        int status = is_user ? silent_verdict() : EXIT_SUCCESS;
        fflush(stdout);
        _exit(status);
    }
    int status = -1;
    CHECK(waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == EXIT_SUCCESS);
    CHECK(entries(path_of(directory, "closed"), "") == 0);
}

/* The directory goes, and something else takes its place. */
static void gone(const char *directory, const World *w)
{
    const char *at = path_of(directory, "gone");
    icoray_config config = plain(at);
    icoray_ctx *ctx = opened(&config, w, 16);
    DRAW(ctx, 0, 0.0, NULL);
    CHECK(remove(path_of(at, "frame_0.png")) == 0 && remove(path_of(at, "report.csv")) == 0);
    CHECK(rmdir(at) == 0);
    well(ctx, at, 1); /* made anew */
    CHECK(remove(path_of(at, "frame_1.png")) == 0 && remove(path_of(at, "report.csv")) == 0);
    CHECK(rmdir(at) == 0 && symlink("nowhere", at) == 0);
    fails(ctx, 10, "cannot make the directory", "gone");
    CHECK(remove(at) == 0);
    well(ctx, at, 20);
    CHECK(remove(path_of(at, "frame_20.png")) == 0 && remove(path_of(at, "report.csv")) == 0);
    CHECK(rmdir(at) == 0);
    FILE *file = fopen(at, "w");
    CHECK(file != NULL && fclose(file) == 0);
    /* Known before the first ray. */
    CHECK(icoray_execute(ctx, 30, 0.0, NULL) == ICORAY_ERR_IO);
    CHECK(strstr(message_of(ctx), "gone") != NULL);
    CHECK(remove(at) == 0);
    well(ctx, at, 31);
    /* A change of the working directory has no effect. */
    CHECK(chdir("/") == 0);
    well(ctx, at, 32);
    OK(icoray_close(&ctx));
}

static volatile int is_spinning;

static void *spin(void *data)
{
    while (is_spinning) {
    }
    return data;
}

/* Slows the library's writer down: it shares a processor with a busy thread, at idle priority. */
static pthread_t slowed(void)
{
    pthread_t spinner;
    cpu_set_t all, one;
    struct sched_param none;
    int found = 0;
    memset(&none, 0, sizeof none);
    sched_getaffinity(0, sizeof all, &all);
    CPU_ZERO(&one);
    for (int cpu = 0; cpu < CPU_SETSIZE && CPU_COUNT(&one) == 0; cpu++) {
        if (CPU_ISSET(cpu, &all)) {
            CPU_SET(cpu, &one);
        }
    }
    for (int i = 0; i < 1000 * PATIENCE_S && found == 0; i++) { /* threads take a moment to name themselves */
        DIR *tasks = opendir("/proc/self/task");
        for (struct dirent *task; tasks != NULL && (task = readdir(tasks)) != NULL;) {
            char path[300], name[64] = "";
            snprintf(path, sizeof path, "/proc/self/task/%s/comm", task->d_name);
            FILE *comm = fopen(path, "r");
            if (comm != NULL && fgets(name, sizeof name, comm) != NULL && strcmp(name, "icoray-writer\n") == 0) {
                pid_t thread = atoi(task->d_name);
                found += sched_setaffinity(thread, sizeof one, &one) == 0 &&
                         sched_setscheduler(thread, SCHED_IDLE, &none) == 0;
            }
            if (comm != NULL) {
                fclose(comm);
            }
        }
        closedir(tasks);
        rest_ms(1);
    }
    CHECK(found == 1);
    is_spinning = 1;
    CHECK(pthread_create(&spinner, NULL, spin, NULL) == 0);
    CHECK(pthread_setaffinity_np(spinner, sizeof one, &one) == 0);
    return spinner;
}

/* More frames than the writer takes. */
static void drops(const char *directory, const World *w, int async)
{
    const char *name = path_of(directory, async ? "async" : "sync");
    uint64_t frames = 60;
    icoray_config config = CONFIG(.output_dir = name, .async_render = async, .when_full = ICORAY_DROP_OLDEST,
                                  .writer_queue = 1);
    icoray_ctx *ctx = opened(&config, w, 300);
    /* Nothing in view: drawn at once, and encoded as slowly as any. */
    OK(icoray_scene_text(ctx, "field = \"f\"\n[image]\nwidth = 300\nheight = 300\n[camera]\neye = [9, 0, 0]\n"
                              "target = [10, 0, 0]\n[transfer]\nmap = \"viridis\"\nrange = [0, 1]\n"
                              "opacity = [[0, 0], [1, 0.5]]\n[output]\nfile = \"frame_{step}.png\"\n"
                              "error = \"error_{step}.png\"\n"));
    pthread_t spinner = slowed();
    for (uint64_t step = 0; step < frames; step++) {
        OK(icoray_execute(ctx, (int64_t)step, 0.0, NULL));
    }
    is_spinning = 0;
    pthread_join(spinner, NULL);
    OK(icoray_wait(ctx));
    icoray_frame_report report = report_of(ctx);
    CHECK(report.frames_written + report.frames_dropped == frames && report.frames_failed == 0);
    CHECK(report.frames_written >= 1);
    if (report.frames_dropped == 0) {
        note("%s", "skipped: a core was free, and the writer kept up");
    }
    OK(icoray_close(&ctx));
    CHECK((uint64_t)entries(name, "frame_") == report.frames_written);
    CHECK(is_whole_png(path_of(name, "frame_59.png")) && entries(name, ".tmp") == 0);
    note("%s: of %d frames %d written, %d dropped", async ? "async" : "sync", (int)frames, (int)report.frames_written,
         (int)report.frames_dropped);
}

typedef struct {
    const char *path;
    volatile int is_done;
    int whole, partial, missing;
} Reader;

static void *look(void *data)
{
    Reader *reader = data;
    while (!reader->is_done) {
        if (is_whole_png(reader->path)) {
            reader->whole++;
        } else if (is_file(reader->path)) {
            reader->partial++;
        } else {
            reader->missing++;
        }
    }
    return NULL;
}

/* Another thread reads the picture while it is replaced. */
static void watched(const char *directory, const World *w)
{
    const char *name = path_of(directory, "watched");
    Reader reader = {0};
    pthread_t thread;
    icoray_config config = CONFIG(.output_dir = name, .existing = ICORAY_OVERWRITE);
    icoray_ctx *ctx = opened(&config, w, 64);
    reader.path = path_of(name, "frame_7.png");
    DRAW(ctx, 7, 0.0, NULL);
    CHECK(pthread_create(&thread, NULL, look, &reader) == 0);
    for (int i = 0; i < 300; i++) {
        OK(icoray_execute(ctx, 7, i, NULL));
    }
    OK(icoray_close(&ctx));
    reader.is_done = 1;
    pthread_join(thread, NULL);
    CHECK(reader.whole > 100 && reader.partial == 0 && reader.missing == 0);
    CHECK(entries(name, ".tmp") == 0);
    note("watched: %d looks, none in part", reader.whole);
    /* The look can fail. */
    CHECK(truncate(reader.path, 300) == 0 && !is_whole_png(reader.path));
}

int main(int argc, char **argv)
{
    if (argc != 3) {
        return EXIT_FAILURE;
    }
    World w = world(2, HOST_LAYERS);
    if (strcmp(argv[2], "full") == 0) {
        full(argv[1], &w);
    } else if (strcmp(argv[2], "denied") == 0) {
        denied(argv[1], &w);
    } else if (strcmp(argv[2], "gone") == 0) {
        gone(argv[1], &w);
    } else if (strcmp(argv[2], "slow") == 0) {
        drops(argv[1], &w, 0);
        drops(argv[1], &w, 1);
    } else {
        watched(argv[1], &w);
    }
    end_world(&w);
    return verdict("host_writer");
}
