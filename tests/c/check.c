#define _POSIX_C_SOURCE 200809L /* nanosleep, opendir */

#include "check.h"

#include <dirent.h>
#include <stdarg.h>
#include <time.h>

/* Words that only the messages of provoke() contain: with a context, and without. */
#define MARK "provoked_by_the_test"
#define LEVEL_MARK "-76543"

/* The longest message or log line, in bytes: models print messages into lines of their own. */
#define MAX_MESSAGE 400

static int checks, failures;
const char *trying = "";

Place place(const char *file, int line)
{
    const char *slash = strrchr(file, '/');
    Place at;
    at.file = slash == NULL ? file : slash + 1;
    at.line = line;
    return at;
}

void check(int good, const char *what, Place at)
{
    checks++;
    if (!good) {
        failures++;
        printf("%s:%d: %s [%s]\n", at.file, at.line, what, trying);
    }
}

void went_well(icoray_status status, const char *what, Place at)
{
    char message[512] = "";
    check(status == 0, what, at);
    if (status != 0) {
        icoray_last_error(NULL, message, sizeof message);
        printf("  status %d: %s\n", (int)status, message);
    }
}

void provoke(icoray_ctx *ctx)
{
    if (ctx != NULL) {
        icoray_array none; /* not a collective call */
        memset(&none, 0, sizeof none);
        none.struct_size = sizeof none;
        icoray_field_set(ctx, MARK, &none);
    } else {
        icoray_mesh *none;
        icoray_mesh_create(atoi(LEVEL_MARK), &none);
    }
}

void refused(icoray_status status, icoray_status expected, const icoray_ctx *ctx, const char *part,
             const char *what, Place at)
{
    char message[1024], thread_message[1024];
    int good = status == expected && expected != 0;
    check(good, what, at);
    if (icoray_last_error(ctx, message, sizeof message) != 0 ||
        icoray_last_error(NULL, thread_message, sizeof thread_message) != 0) {
        check(0, "icoray_last_error", at);
        return;
    }
    if (!good) {
        printf("  status %d, expected %d: %s\n", (int)status, (int)expected, message);
        return;
    }
    good = part[0] != '\0' && strstr(message, part) != NULL && strcmp(message, thread_message) == 0 &&
           strlen(message) <= MAX_MESSAGE && strstr(message, MARK) == NULL && strstr(message, LEVEL_MARK) == NULL;
    check(good, "the message", at);
    if (!good) {
        printf("  '%s' and '%s', expected both to say '%s'\n", message, thread_message, part);
    }
}

int failed_checks(void)
{
    return failures;
}

int verdict(const char *program)
{
    printf("%s: %d checks, %d failed\n", program, checks, failures);
    return failures == 0 && checks > 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

icoray_frame_report report_of(icoray_ctx *ctx)
{
    icoray_frame_report report = {sizeof report};
    OK(icoray_report(ctx, &report));
    return report;
}

const char *text_of(const char *format, ...)
{
    static char texts[64][2048];
    static int next;
    va_list values;
    next = (next + 1) % 64;
    va_start(values, format);
    vsnprintf(texts[next], sizeof texts[next], format, values);
    va_end(values);
    return texts[next];
}

const char *path_of(const char *directory, const char *name)
{
    return text_of("%s/%s", directory, name);
}

void set_real(void *array, int32_t type, int64_t at, double value)
{
    if (type == ICORAY_F32) {
        ((float *)array)[at] = (float)value;
    } else {
        ((double *)array)[at] = value;
    }
}

void set_index(void *table, int32_t type, int64_t at, int64_t value)
{
    if (type == ICORAY_I32) {
        ((int32_t *)table)[at] = (int32_t)value;
    } else {
        ((int64_t *)table)[at] = value;
    }
}

int entries(const char *directory, const char *part)
{
    int count = 0;
    DIR *open = opendir(directory);
    if (open == NULL) {
        return -1;
    }
    for (struct dirent *entry; (entry = readdir(open)) != NULL;) {
        int is_self = strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0;
        count += !is_self && strstr(entry->d_name, part) != NULL;
    }
    closedir(open);
    return count;
}

int threads_now(void)
{
    return entries("/proc/self/task", "");
}

void rest_ms(int ms)
{
    struct timespec rest;
    rest.tv_sec = ms / 1000;
    rest.tv_nsec = ms % 1000 * 1000000L;
    nanosleep(&rest, NULL);
}

int settles_at(int threads)
{
    for (int i = 0; i < 1000 * PATIENCE_S && threads_now() != threads; i++) {
        rest_ms(1);
    }
    int now = threads_now();
    return now == threads || now == -1;
}

void *allocate(size_t count, size_t size)
{
    void *memory = calloc(count, size);
    if (memory == NULL) {
        printf("out of memory\n");
        exit(EXIT_FAILURE);
    }
    return memory;
}
