/* Dates such as 2026-11-24T06:00:00.000, in the proleptic Gregorian calendar. */
#include "clock.h"

#include <math.h>
#include <stdio.h>

typedef struct {
    int year, month, day, hour, minute;
    double second;
} moment;

static int moment_read(const char *text, moment *to)
{
    int count = sscanf(text, "%d-%d-%dT%d:%d:%lf", &to->year, &to->month, &to->day, &to->hour, &to->minute,
                       &to->second);
    return count == 6 && to->month >= 1 && to->month <= 12;
}

/* Days since 0000-03-01: years that begin in March end with the leap day. */
static int64_t days_of(const moment *at)
{
    int64_t year = (int64_t)at->year - (at->month < 3), month = (at->month + 9) % 12;
    int64_t era = (year >= 0 ? year : year - 399) / 400, of_era = year - 400 * era;
    return 146097 * era + 365 * of_era + of_era / 4 - of_era / 100 + (153 * month + 2) / 5 + at->day - 1;
}

int clock_read(const char *start, const char *now, double step_s, int64_t *step, double *seconds, char date[24])
{
    moment from, to;
    if (!moment_read(start, &from) || !moment_read(now, &to) || !(step_s > 0.0)) {
        return 0;
    }
    double minutes = 60.0 * (to.hour - from.hour) + (to.minute - from.minute);
    *seconds = 86400.0 * (double)(days_of(&to) - days_of(&from)) + 60.0 * minutes + (to.second - from.second);
    *step = (int64_t)floor(*seconds / step_s + 0.5);
    int length = snprintf(date, 24, "%04d-%02d-%02dT%02d:%02d:%02d", to.year, to.month, to.day, to.hour, to.minute,
                          (int)to.second);
    return length > 0 && length < 24;
}
