#include "options.h"

#include "planet.h"
#include "ranks.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void usage(FILE *stream)
{
    fprintf(stream, "usage: tracer [options]\n"
                    "  --level n      icosahedral grid of 10 * 4^n + 2 cells, 1 to 9 (5)\n"
                    "  --layers N     layers between the ground and 12 km, 6 to 1000 (30)\n"
                    "  --days D       length of the simulation; the flow has returned after 12 (12)\n"
                    "  --dt S         longest time step in seconds (from the Courant number)\n"
                    "  --every k      steps between pictures (half a day)\n"
                    "  --scene FILE   scene to draw (examples/scenes/tracer.toml)\n"
                    "  --out DIR      where pictures go (the current directory)\n"
                    "  --threads T    threads that draw, 0 for all (0)\n"
                    "  --help         print this and leave\n");
}

/* Ends the program; on all ranks, which have the same command line. */
static void refuse(const char *option, const char *why)
{
    if (ranks_me() == 0) {
        fprintf(stderr, "tracer: %s: %s\n", option, why);
        usage(stderr);
    }
    ranks_finish();
    exit(2);
}

/* The number in `text`; refuses what is none, or out of range. */
static double number(const char *option, const char *text, double lowest, double highest)
{
    char *end;
    double value = strtod(text, &end);
    if (end == text || *end != '\0' || !(value >= lowest && value <= highest)) {
        refuse(option, "not a number in its range");
    }
    return value;
}

static long whole(const char *option, const char *text, double lowest, double highest)
{
    double value = number(option, text, lowest, highest);
    if (value != floor(value)) {
        refuse(option, "not a whole number");
    }
    return (long)value;
}

Options options_from(int argc, char **argv)
{
    Options o = {5, 30, 0, 12.0, 0.0, 0, "examples/scenes/tracer.toml", NULL};
    for (int i = 1; i < argc; i += 2) {
        const char *name = argv[i], *value = i + 1 < argc ? argv[i + 1] : "";
        if (strcmp(name, "--help") == 0) {
            usage(stdout);
            ranks_finish();
            exit(EXIT_SUCCESS);
        } else if (strcmp(name, "--level") == 0) {
            o.level = (int)whole(name, value, 1, 9);
        } else if (strcmp(name, "--layers") == 0) {
            o.layers = (int)whole(name, value, 6, 1000);
        } else if (strcmp(name, "--days") == 0) {
            o.days = number(name, value, 0.01, 10000);
        } else if (strcmp(name, "--dt") == 0) {
            o.dt = number(name, value, 0.01, DAY);
        } else if (strcmp(name, "--every") == 0) {
            o.every = whole(name, value, 1, 1e9);
        } else if (strcmp(name, "--threads") == 0) {
            o.threads = (int)whole(name, value, 0, 4096);
        } else if (strcmp(name, "--scene") == 0 && *value != '\0') {
            o.scene = value;
        } else if (strcmp(name, "--out") == 0 && *value != '\0') {
            o.out = value;
        } else {
            refuse(name, "unknown, or without its value");
        }
    }
    return o;
}
