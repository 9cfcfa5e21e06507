#include "check.h"

/* What no message of interest has, with a context and without: see provoke(). */
#define MARK "provoked_by_the_test"
#define LEVEL_MARK "-76543"

/* Models print messages into lines of theirs: no message and no line of the log is longer. */
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
        icoray_array none; /* a call that each rank makes alone */
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
           strlen(message) <= MAX_MESSAGE &&
           strstr(message, MARK) == NULL && strstr(message, LEVEL_MARK) == NULL;
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
