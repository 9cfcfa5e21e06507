/*
 * The host's signals: host_signals <directory>
 *
 * Handlers and masks do not change, and signals sent to the process are handled on the host's threads only.
 */
#define _GNU_SOURCE /* SYS_gettid */

#include "host.h"

#include <dirent.h>
#include <pthread.h>
#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#define SIGNALS 64
#define SENT 1000

typedef struct {
    struct sigaction actions[SIGNALS + 1];
    sigset_t mask;
    stack_t stack;
} Signals;

static Signals look(void)
{
    Signals now = {0};
    for (int s = 1; s <= SIGNALS; s++) {
        sigaction(s, NULL, &now.actions[s]);
    }
    pthread_sigmask(SIG_SETMASK, NULL, &now.mask);
    sigaltstack(NULL, &now.stack);
    return now;
}

static int same(const Signals *a, const Signals *b)
{
    int same = a->stack.ss_sp == b->stack.ss_sp && a->stack.ss_flags == b->stack.ss_flags;
    for (int s = 1; s <= SIGNALS; s++) {
        const struct sigaction *x = &a->actions[s], *y = &b->actions[s];
        same &= x->sa_handler == y->sa_handler && x->sa_flags == y->sa_flags;
        same &= sigismember(&a->mask, s) == sigismember(&b->mask, s);
        for (int t = 1; t <= SIGNALS; t++) {
            same &= sigismember(&x->sa_mask, t) == sigismember(&y->sa_mask, t);
        }
    }
    return same;
}

static pid_t host_thread;
static volatile sig_atomic_t handled, elsewhere;

static void handler(int signal)
{
    (void)signal;
    if ((pid_t)syscall(SYS_gettid) == host_thread) {
        handled++;
    } else {
        elsewhere++;
    }
}

static void *send(void *data)
{
    volatile int *is_done = data;
    for (int i = 0; i < SENT; i++) {
        kill(getpid(), SIGUSR1);
        rest_ms(1);
    }
    *is_done = 1;
    return NULL;
}

static void *stay(void *data)
{
    volatile int *is_done = data;
    while (!*is_done) {
        rest_ms(1);
    }
    return NULL;
}

/* Starts a thread that blocks SIGUSR1, or one that does not. */
static pthread_t started(void *(*work)(void *), void *data, int blocked)
{
    pthread_t thread;
    sigset_t usr1, before;
    sigemptyset(&usr1);
    sigaddset(&usr1, SIGUSR1);
    pthread_sigmask(blocked ? SIG_BLOCK : SIG_UNBLOCK, &usr1, &before);
    CHECK(pthread_create(&thread, NULL, work, data) == 0);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return thread;
}

/* Number of the library's threads; checks that each of them blocks all signals that can be blocked. */
static int library_threads_now(void)
{
    int count = 0;
    DIR *tasks = opendir("/proc/self/task");
    CHECK(tasks != NULL);
    for (struct dirent *task; tasks != NULL && (task = readdir(tasks)) != NULL;) {
        char path[300], line[256], name[64] = "";
        unsigned long long blocked = 0;
        snprintf(path, sizeof path, "/proc/self/task/%s/status", task->d_name);
        FILE *status = fopen(path, "r");
        if (task->d_name[0] == '.' || status == NULL) {
            continue;
        }
        while (fgets(line, sizeof line, status) != NULL) {
            sscanf(line, "Name: %63s", name);
            sscanf(line, "SigBlk: %llx", &blocked);
        }
        fclose(status);
        if (strncmp(name, "icoray", 6) == 0) {
            count++;
            /* But SIGKILL, SIGSTOP, and the two that pthreads keep for themselves; and those that a thread raises itself,
             * which the host may want to handle wherever they come from (SIGILL, SIGTRAP, SIGBUS, SIGFPE, SIGSEGV, SIGSYS). */
            unsigned long long raised = 1ull << 3 | 1ull << 4 | 1ull << 6 | 1ull << 7 | 1ull << 10 | 1ull << 30;
            CHECK((blocked | raised | 1ull << 8 | 1ull << 18 | 3ull << 31) == ~0ull && (blocked & raised) == 0);
        }
    }
    closedir(tasks);
    return count;
}

/* Threads take a moment to name themselves, and the system one to forget them. */
static int has_library_threads(int expected)
{
    for (int i = 0; i < 1000 * PATIENCE_S && library_threads_now() != expected; i++) {
        rest_ms(1);
    }
    return library_threads_now() == expected;
}

static void draw(const char *directory, const World *w, int async)
{
    const char *name = text_of("%s/%d", directory, async);
    volatile int is_done = 0;
    int step = 0;
    Signals before = look(), after;
    icoray_config config = CONFIG(.output_dir = name, .async_render = async, .threads = 2);
    handled = 0;
    icoray_ctx *ctx = opened(&config, w, 64);
    after = look();
    CHECK(same(&before, &after));
    CHECK(has_library_threads(3 + async));
    pthread_t sender = started(send, (void *)&is_done, 1);
    while (!is_done) {
        OK(icoray_execute(ctx, step++, 0.0, NULL));
        if (step % 8 == 0) {
            OK(icoray_wait(ctx));
            OK(icoray_grid_set(ctx, &w->grid));
        }
    }
    pthread_join(sender, NULL);
    after = look();
    CHECK(same(&before, &after));
    OK(icoray_wait(ctx));
    CHECK(report_of(ctx).frames_written == (uint64_t)step && report_of(ctx).frames_failed == 0);
    OK(icoray_close(&ctx));
    after = look();
    CHECK(same(&before, &after));
    CHECK(handled > SENT / 20 && elsewhere == 0);
    CHECK(has_library_threads(0));
    note("%s: %d frames under %d signals, %d handled by the host, %d elsewhere", async ? "async" : "sync", step, SENT,
         (int)handled, (int)elsewhere);
}

int main(int argc, char **argv)
{
    struct sigaction action;
    volatile int is_done = 0;
    if (argc != 2) {
        return EXIT_FAILURE;
    }
    host_thread = (pid_t)syscall(SYS_gettid);
    memset(&action, 0, sizeof action);
    action.sa_handler = handler; /* without SA_RESTART: system calls are interrupted */
    Signals none = look();
    sigaction(SIGUSR1, &action, NULL);
    Signals one = look();
    CHECK(!same(&none, &one)); /* the look can fail */

    World w = world(3, HOST_LAYERS);
    draw(argv[1], &w, 0);
    draw(argv[1], &w, 1);

    /* So can the count: a thread that does not block the signal handles it where the host's does. */
    sigset_t usr1;
    sigemptyset(&usr1);
    sigaddset(&usr1, SIGUSR1);
    pthread_t other = started(stay, (void *)&is_done, 0);
    pthread_sigmask(SIG_BLOCK, &usr1, NULL);
    for (int i = 0; i < 1000 * PATIENCE_S && elsewhere == 0; i++) {
        kill(getpid(), SIGUSR1);
        rest_ms(1);
    }
    is_done = 1;
    pthread_join(other, NULL);
    CHECK(elsewhere > 0);

    /* With all blocked, and the library opened so. */
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, NULL);
    Signals before = look();
    icoray_config config = plain(path_of(argv[1], "blocked"));
    icoray_ctx *ctx = opened(&config, &w, 16);
    OK(icoray_execute(ctx, 0, 0.0, NULL));
    OK(icoray_close(&ctx));
    Signals after = look();
    CHECK(same(&before, &after));
    end_world(&w);
    return verdict("host_signals");
}
