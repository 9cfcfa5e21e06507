/*
 * Used by every C program here: counted checks, which print what failed and the library's message, and the strings and
 * small functions that several programs need. Compiles as C99 and as C++11.
 */
#ifndef CHECK_H
#define CHECK_H

#include <icoray.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The case that is being tested; printed with each failure. */
extern const char *trying;

/* The source line of a check. */
typedef struct {
    const char *file;
    int line;
} Place;

Place place(const char *file, int line);
void check(int good, const char *what, Place at);
void went_well(icoray_status status, const char *what, Place at);

/* Makes a call that fails with another message, so that a stale message cannot pass for that of the next call. */
void provoke(icoray_ctx *ctx);

/* Checks that a call returned this status, and that both messages (the context's and the thread's) contain `part`. */
void refused(icoray_status status, icoray_status expected, const icoray_ctx *ctx, const char *part,
             const char *what, Place at);

/* Number of failed checks so far. */
int failed_checks(void);

/* Prints the last line of a program, and returns its exit status. */
int verdict(const char *program);

/* The report of the last frame. */
icoray_frame_report report_of(icoray_ctx *ctx);

/* A formatted text of up to 2047 characters, in one of 64 buffers that are used in turn. Not for several threads. */
const char *text_of(const char *format, ...);
/* directory/name, as a text_of(). */
const char *path_of(const char *directory, const char *name);

/* Camera and transfer function of most scenes. */
#define CAMERA "[camera]\nlon = 20\nlat = 35\ndistance = 3.2\nfov = 45\n"
#define VIRIDIS "map = \"viridis\"\nrange = [-1.5, 1.5]\nopacity = [[-1.5, 0.8], [0, 0.1], [1.5, 0.9]]\n"
#define VIEW CAMERA "[transfer]\n" VIRIDIS

/* Number of entries of a directory whose names contain `part`, or -1 where there is no directory. */
int entries(const char *directory, const char *part);

/* Seconds that a test waits for an event that always comes before it takes it for a hang. */
#define PATIENCE_S 900

/* Threads of this process, or -1 where the system does not report them. */
int threads_now(void);
/* Whether there come to be that many within PATIENCE_S, as joined threads linger; true where they are not reported. */
int settles_at(int threads);
void rest_ms(int ms);

/* Zeroed memory; ends the program where there is none. */
void *allocate(size_t count, size_t size);

/* Writes an element of an array of ICORAY_F32 or ICORAY_F64, and of a table of ICORAY_I32 or ICORAY_I64. */
void set_real(void *array, int32_t type, int64_t at, double value);
void set_index(void *table, int32_t type, int64_t at, int64_t value);

#define COUNT(table) (sizeof(table) / sizeof(table)[0])

#define HERE place(__FILE__, __LINE__)
#define CHECK(condition) check((condition), #condition, HERE)
#define OK(call) went_well((call), #call, HERE)
/* Checks that a call is refused with ICORAY_ERR_`error`, or with a status, and a message that contains `part`. */
#define REFUSED(ctx, error, part, call) \
    (provoke(ctx), refused((call), ICORAY_ERR_##error, (ctx), (part), #call, HERE))
#define REFUSED_AS(ctx, status, part, call) (provoke(ctx), refused((call), (status), (ctx), (part), #call, HERE))
/* Draws and writes a frame. */
#define DRAW(ctx, ...) (OK(icoray_execute(ctx, __VA_ARGS__)), OK(icoray_wait(ctx)))

#endif
