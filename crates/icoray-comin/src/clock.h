/* Dates of ICON as steps and seconds. */
#ifndef ICORAY_COMIN_CLOCK_H
#define ICORAY_COMIN_CLOCK_H

#include <stddef.h>
#include <stdint.h>

/* The time of a call: seconds since the start of the experiment, and steps of `step_s` in them, so that a restarted run
 * goes on counting; the date as icoray takes it, without fractions of seconds. Returns 0 where a date cannot be read.
 */
int clock_read(const char *start, const char *now, double step_s, int64_t *step, double *seconds, char date[24]);

#endif
