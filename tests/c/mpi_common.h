/* Used by the programs that run under mpirun. */
#ifndef MPI_COMMON_H
#define MPI_COMMON_H

#include "host.h"

#include <mpi.h>

extern int rank, ranks;

/* Initialises MPI as most models do, for one thread. */
void begin(int *argc, char ***argv);

/* Finalises MPI. Rank 0 prints the number of checks; every rank prints its own failures. */
int end(const char *program);

/* A context of all ranks of a communicator, with the grid, layers and field of a world; pictures go to directory. */
icoray_ctx *together(MPI_Comm comm, const char *directory, const World *w, icoray_config config);

/* Takes all memory that can be shared, in a file system that is this test's own. Collective. */
void take_all(void);

/* A context of this process alone, with the same. */
icoray_ctx *alone(const char *directory, const World *w);

/* An empty context of all ranks. */
icoray_ctx *opened_by_all(const icoray_config *config);

/* Checks that a value is the same on all ranks. */
int is_same_on_all(int value);

/* Gives a context the grid, layers and field of a world. */
void fill(icoray_ctx *ctx, const World *w);

/* Checks that all ranks got this status and the same message, which contains `part`. */
void refused_by_all(icoray_status status, icoray_status expected, const char *part, const char *what, Place at);

/* The communicator of all ranks, as icoray_open takes it. */
#define EVERYONE ((int32_t)MPI_Comm_c2f(MPI_COMM_WORLD))

/*
 * The world with another field, at its corners, and a table of the numbers of its cells' corners, which the averages of
 * every frame read. The field's values are to be freed.
 */
World at_corners(const World *w);

/*
 * icoray_execute with numbers of cells' corners that the model has overwritten on this rank: with a world at_corners a panic,
 * which breaks the context of all.
 */
icoray_status execute_spoilt(icoray_ctx *ctx, const icoray_grid *grid, int64_t step, int is_here);

/* "rank %d: ", with which messages about a failure on one rank begin. */
const char *by_rank(int odd);

#define ALL_REFUSED(error, part, call) (said_before(), refused_by_all((call), ICORAY_ERR_##error, (part), #call, HERE))
#define ALL_REFUSED_AS(status, part, call) (said_before(), refused_by_all((call), (status), (part), #call, HERE))

/* Sets another last message, so that a stale one cannot pass for that of the next call. */
void said_before(void);

#endif
