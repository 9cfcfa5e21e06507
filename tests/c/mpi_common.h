/* What the programs that run under mpirun share. */
#ifndef MPI_COMMON_H
#define MPI_COMMON_H

#include "host.h"

#include <mpi.h>

extern int rank, ranks;

/* Initialises MPI as most models do, for one thread. */
void begin(int *argc, char ***argv);

/* Rank 0 says how many checks there were; the others only speak of what failed. */
int end(const char *program);

/* A context of all ranks of a communicator, with the grid, layers and field of a world; pictures go to directory. */
icoray_ctx *together(MPI_Comm comm, const char *directory, const World *w, icoray_config config);

/* Gives a context the grid, layers and field of a world. */
void fill(icoray_ctx *ctx, const World *w);

/* All ranks were told this status, in the same words, which have this part. */
void told_all(icoray_status status, icoray_status expected, const char *part, const char *what, Place at);

#define TOLD(expected, part, call) (said_before(), told_all((call), (expected), (part), #call, HERE))

/* So that a message from before cannot pass for that of the next call. */
void said_before(void);

#endif
