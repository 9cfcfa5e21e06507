/* What the C programs share: checks that are counted, and that say what failed and what the library said of it. */
#ifndef CHECK_H
#define CHECK_H

#include <icoray.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The row of a table that is being tried. */
extern const char *trying;

/* Where a check stands. */
typedef struct {
    const char *file;
    int line;
} Place;

Place place(const char *file, int line);
void check(int good, const char *what, Place at);
void went_well(icoray_status status, const char *what, Place at);

/* Fails a call, so that a message from before cannot pass for that of the next one. */
void provoke(icoray_ctx *ctx);

/* The call gave this status, and its message, the context's and the thread's, has this part. */
void refused(icoray_status status, icoray_status expected, const icoray_ctx *ctx, const char *part,
             const char *what, Place at);

/* Checks that have failed so far. */
int failed_checks(void);

/* The last line that a program prints, and its exit status. */
int verdict(const char *program);

#define HERE place(__FILE__, __LINE__)
#define CHECK(condition) check((condition), #condition, HERE)
#define OK(call) went_well((call), #call, HERE)
#define REFUSED(ctx, expected, part, call) \
    (provoke(ctx), refused((call), (expected), (ctx), (part), #call, HERE))

#endif
