#include <mpi.h>
#include <stdio.h>

/* Without an argument "size N", the number of ranks; with any argument the library that is linked. */
int main(int count, char **arguments) {
    char version[MPI_MAX_LIBRARY_VERSION_STRING];
    int length = 0, size = 0;
    if (count > 1) {
        MPI_Get_library_version(version, &length);
        printf("%s\n", version);
        return 0;
    }
    MPI_Init(&count, &arguments);
    MPI_Comm_size(MPI_COMM_WORLD, &size);
    printf("size %d\n", size);
    MPI_Finalize();
    return 0;
}
