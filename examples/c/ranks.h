/*
 * The ranks of a run: one, or with -DTRACER_MPI those of mpirun. Each computes the whole model, which takes no exchange, and
 * they share out the pictures.
 */
#ifndef RANKS_H
#define RANKS_H

#include <icoray.h>

/* First and last in the program. In between, standard output is rank 0's alone: all would say the same. */
void ranks_start(int *argc, char ***argv);
void ranks_finish(void);

/* The number of this one, from 0. */
int ranks_me(void);

/* Opens a context over all ranks. */
icoray_status ranks_open(const icoray_config *config, icoray_ctx **ctx);

/* Together on all: the first rank where the condition holds; -1 where it does on none. */
int ranks_first(int condition);

#endif
