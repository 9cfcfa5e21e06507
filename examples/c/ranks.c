#include "ranks.h"

#ifdef TRACER_MPI

#include <mpi.h>

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>

static int me;

void ranks_start(int *argc, char ***argv)
{
    int provided;
    MPI_Init_thread(argc, argv, MPI_THREAD_FUNNELED, &provided);
    MPI_Comm_rank(MPI_COMM_WORLD, &me);
    if (me > 0 && freopen("/dev/null", "w", stdout) == NULL) {
        MPI_Abort(MPI_COMM_WORLD, EXIT_FAILURE);
    }
}

void ranks_finish(void)
{
    MPI_Finalize();
}

int ranks_me(void)
{
    return me;
}

icoray_status ranks_open(const icoray_config *config, icoray_ctx **ctx)
{
    return icoray_open(config, MPI_Comm_c2f(MPI_COMM_WORLD), ctx);
}

int ranks_first(int condition)
{
    int mine = condition ? me : INT_MAX, first;
    MPI_Allreduce(&mine, &first, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    return first == INT_MAX ? -1 : first;
}

#else

void ranks_start(int *argc, char ***argv)
{
    (void)argc;
    (void)argv;
}

void ranks_finish(void)
{
}

int ranks_me(void)
{
    return 0;
}

icoray_status ranks_open(const icoray_config *config, icoray_ctx **ctx)
{
    return icoray_open_serial(config, ctx);
}

int ranks_first(int condition)
{
    return condition ? 0 : -1;
}

#endif
