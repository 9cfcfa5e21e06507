/*
 * Other state of the host's process: host_process <directory> [loud]
 *
 * The calls do not change affinity, environment, directory, umask, locale, open files and threads, and print nothing,
 * which the Rust test checks. `loud` fails with icoray_log_stderr, the only function that prints.
 */
#define _GNU_SOURCE /* sched_getaffinity */

#include "host.h"

#include <dirent.h>
#include <locale.h>
#include <sched.h>
#include <sys/stat.h>
#include <unistd.h>

extern char **environ;

typedef struct {
    cpu_set_t cpus;
    char environment[65536], directory[4096], locale[512];
    char **where;
    mode_t mask;
    int files, threads;
} Process;

static void look(Process *now)
{
    size_t end = 0;
    memset(now, 0, sizeof *now);
    sched_getaffinity(0, sizeof now->cpus, &now->cpus);
    now->where = environ;
    for (char **entry = environ; *entry != NULL && end < sizeof now->environment; entry++) {
        end += (size_t)snprintf(now->environment + end, sizeof now->environment - end, "%p %s\n", (void *)*entry, *entry);
    }
    CHECK(getcwd(now->directory, sizeof now->directory) != NULL);
    snprintf(now->locale, sizeof now->locale, "%s", setlocale(LC_ALL, NULL));
    now->mask = umask(0);
    umask(now->mask);
    now->files = open_files();
    now->threads = threads_now();
}

static int same(const Process *a, const Process *b)
{
    return CPU_EQUAL(&a->cpus, &b->cpus) && a->where == b->where && strcmp(a->environment, b->environment) == 0 &&
           strcmp(a->directory, b->directory) == 0 && strcmp(a->locale, b->locale) == 0 && a->mask == b->mask;
}

static Process before, after;

#define UNCHANGED() (look(&after), CHECK(same(&before, &after)))

/* Checks that look() sees changes. */
static void looks(void)
{
    look(&before);
    setenv("ICORAY_TEST_ODD", "1", 1);
    look(&after);
    CHECK(!same(&before, &after));
    look(&before);
    umask(031);
    look(&after);
    CHECK(!same(&before, &after));
    look(&before);
    FILE *open = fopen("/dev/null", "r");
    look(&after);
    CHECK(same(&before, &after) && after.files == before.files + 1);
    fclose(open);
}

/* Every thread of the process may run where this one may, or on fewer. */
static int threads_inside(const cpu_set_t *mask)
{
    int count = 0;
    DIR *tasks = opendir("/proc/self/task");
    for (struct dirent *task; tasks != NULL && (task = readdir(tasks)) != NULL;) {
        cpu_set_t theirs, both;
        if (task->d_name[0] == '.' || sched_getaffinity(atoi(task->d_name), sizeof theirs, &theirs) != 0) {
            continue;
        }
        CPU_AND(&both, &theirs, mask);
        if (!CPU_EQUAL(&both, &theirs)) {
            closedir(tasks);
            return -1;
        }
        count++;
    }
    closedir(tasks);
    return count;
}

/* Frames that are drawn, refused and failed, and all that may leave something behind. */
static void calls(const char *directory, const World *w, int async)
{
    const char *name = text_of("%s/%d", directory, async);
    icoray_ctx *ctx, *second;
    icoray_config config = CONFIG(.output_dir = name, .async_render = async);
    look(&before);
    ctx = opened(&config, w, 32);
    UNCHANGED();
    config.threads = 3;
    config.output_dir = path_of(name, "second");
    second = opened(&config, w, 32);
    for (int step = 0; step < 5; step++) {
        OK(icoray_execute(ctx, step, 0.0, "2000-01-02_03:04:05"));
        OK(icoray_execute(second, step, 0.0, NULL));
    }
    UNCHANGED();
    CHECK(threads_inside(&before.cpus) >= 4);
    OK(icoray_wait(ctx));
    OK(icoray_wait(second));
    CHECK(icoray_execute(ctx, 1, 0.0, NULL) == ICORAY_ERR_EXISTS);
    CHECK(icoray_scene_load(ctx, "nowhere.toml") == ICORAY_ERR_IO);
    CHECK(icoray_scene_text(ctx, "nothing") == ICORAY_ERR_SCENE);
    UNCHANGED();
    /* Frames that fail on the writer's thread. */
    set_scene(ctx, 32, "");
    OK(icoray_scene_text(second, "field = \"f\"\n[image]\nwidth = 8\nheight = 8\n[camera]\nlon = 0\nlat = 0\ndistance = 3\n"
                                 "[transfer]\nmap = \"viridis\"\nrange = [0, 1]\nopacity = [[0, 0], [1, 0.5]]\n"
                                 "[output]\nfile = \"late/{step}.png\"\n"));
    CHECK(symlink("nowhere", path_of(path_of(name, "second"), "late")) == 0);
    icoray_status late = icoray_execute(second, 9, 0.0, NULL);
    CHECK(late == ICORAY_OK || late == ICORAY_ERR_IO);
    CHECK((icoray_wait(second) == ICORAY_ERR_IO) == (late == ICORAY_OK));
    OK(icoray_execute(ctx, 10, 0.0, NULL));
    OK(icoray_close(&second));
    OK(icoray_close(&ctx));
    UNCHANGED();
    CHECK(settles_at(before.threads));
    CHECK(after.files == before.files);
}

static int32_t threads_of(const char *directory, const char *name, const World *w)
{
    icoray_config config = plain(path_of(directory, name));
    icoray_ctx *ctx = opened(&config, w, 16);
    OK(icoray_execute(ctx, 0, 0.0, NULL));
    int32_t threads = report_of(ctx).threads;
    OK(icoray_close(&ctx));
    return threads;
}

/* As many threads as the mask allows, independent of the environment. */
static void affinity(const char *directory, const World *w)
{
    cpu_set_t all, one;
    sched_getaffinity(0, sizeof all, &all);
    int32_t most = CPU_COUNT(&all), usual = threads_of(directory, "usual", w);
    /* A quota of the container may allow less than the mask. */
    CHECK(usual >= 1 && usual <= most);
    setenv("RAYON_NUM_THREADS", "7", 1);
    setenv("RAYON_RS_NUM_CPUS", "7", 1);
    CHECK(threads_of(directory, "environment", w) == usual);
    CPU_ZERO(&one);
    for (int cpu = 0; cpu < CPU_SETSIZE && CPU_COUNT(&one) == 0; cpu++) {
        if (CPU_ISSET(cpu, &all)) {
            CPU_SET(cpu, &one);
        }
    }
    CHECK(sched_setaffinity(0, sizeof one, &one) == 0);
    CHECK(threads_of(directory, "one", w) == 1);
    look(&before);
    icoray_config config = CONFIG(.output_dir = path_of(directory, "three"), .threads = 3, .async_render = 1);
    icoray_ctx *ctx = opened(&config, w, 16);
    OK(icoray_execute(ctx, 0, 0.0, NULL));
    CHECK(threads_inside(&one) == before.threads + 5);
    CHECK(threads_inside(&all) == before.threads + 5);
    UNCHANGED();
    OK(icoray_close(&ctx));
    CHECK(sched_setaffinity(0, sizeof all, &all) == 0);
    CHECK(CPU_COUNT(&all) == 1 || threads_inside(&one) == -1); /* the look can fail */
    unsetenv("RAYON_NUM_THREADS");
    unsetenv("RAYON_RS_NUM_CPUS");
}

static int loud(const char *directory)
{
    icoray_config config = CONFIG(.output_dir = directory, .log = icoray_log_stderr, .log_level = ICORAY_LOG_WARN);
    icoray_ctx *ctx = NULL;
    OK(icoray_open_serial(&config, &ctx));
    CHECK(icoray_scene_text(ctx, "nothing") == ICORAY_ERR_SCENE);
    OK(icoray_close(&ctx));
    return verdict("host_process");
}

int main(int argc, char **argv)
{
    if (argc == 3) {
        return loud(argv[1]);
    }
    if (argc != 2) {
        return EXIT_FAILURE;
    }
    looks();
    look(&before);
    World w = world(3, HOST_LAYERS);
    UNCHANGED();
    CHECK(settles_at(before.threads) && after.files == before.files);
    calls(argv[1], &w, 0);
    calls(argv[1], &w, 1);
    affinity(argv[1], &w);
    end_world(&w);
    return verdict("host_process");
}
