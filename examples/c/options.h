/* The command line. */
#ifndef OPTIONS_H
#define OPTIONS_H

typedef struct {
    int level, layers, threads;
    double days, dt; /* dt 0: from the Courant number */
    long every;      /* 0: twice a day */
    const char *scene, *out;
} Options;

/* Reads the command line. Ends the program after --help, or with the usage when something is wrong. */
Options options_from(int argc, char **argv);

#endif
