/* What the C programs share: checks that are counted, and that say what failed and what the library said of it. */
#ifndef CHECK_H
#define CHECK_H

#include <icoray.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What no message of interest has, with a context and without: see provoke(). */
#define MARK "provoked_by_the_test"
#define LEVEL_MARK "-76543"

static int checks, failures;
/* The row of a table that is being tried. */
static const char *trying = "";

static void check(int good, const char *what, int line)
{
    checks++;
    if (!good) {
        failures++;
        printf("line %d: %s [%s]\n", line, what, trying);
    }
}

#define CHECK(condition) check((condition), #condition, __LINE__)

static void went_well(icoray_status status, const char *what, int line)
{
    char message[512] = "";
    check(status == 0, what, line);
    if (status != 0) {
        icoray_last_error(NULL, message, sizeof message);
        printf("  status %d: %s\n", (int)status, message);
    }
}

#define OK(call) went_well((call), #call, __LINE__)

/* Fails a call, so that a message from before cannot pass for that of the next one. */
static void provoke(icoray_ctx *ctx)
{
    if (ctx != NULL) {
        icoray_scene_text(ctx, MARK);
    } else {
        icoray_mesh *none;
        icoray_mesh_create(atoi(LEVEL_MARK), &none);
    }
}

/* The call gave this status, and its message, the context's and the thread's, has this part. */
static void refused(icoray_status status, icoray_status expected, const icoray_ctx *ctx, const char *part,
                    const char *what, int line)
{
    char message[1024], thread_message[1024];
    int good = status == expected && expected != 0;
    check(good, what, line);
    if (icoray_last_error(ctx, message, sizeof message) != 0 ||
        icoray_last_error(NULL, thread_message, sizeof thread_message) != 0) {
        check(0, "icoray_last_error", line);
        return;
    }
    if (!good) {
        printf("  status %d, expected %d: %s\n", (int)status, (int)expected, message);
        return;
    }
    good = part[0] != '\0' && strstr(message, part) != NULL && strcmp(message, thread_message) == 0 &&
           strstr(message, MARK) == NULL && strstr(message, LEVEL_MARK) == NULL;
    check(good, "the message", line);
    if (!good) {
        printf("  '%s' and '%s', expected both to say '%s'\n", message, thread_message, part);
    }
}

#define REFUSED(ctx, expected, part, call) \
    (provoke(ctx), refused((call), (expected), (ctx), (part), #call, __LINE__))

/* The last line that a program prints, and its exit status. */
static int verdict(const char *program)
{
    printf("%s: %d checks, %d failed\n", program, checks, failures);
    return failures == 0 && checks > 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

#endif
