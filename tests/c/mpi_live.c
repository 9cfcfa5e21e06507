/* live.c over ranks, which have the whole grid or parts of it. */
#define LIVE_MPI
#include "live.c"
