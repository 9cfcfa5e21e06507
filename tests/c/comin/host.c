/* A host with plugins, such as ICON: host PLUGIN OPTIONS DOMAINS FIRST LAST [FAULT] runs the steps FIRST to LAST.
 * FAULT is "table" or "nan" on rank 1: a table of vertices that contradicts itself, or heights that are none. */
#include "double/double.h"

#include <comin.h>
#include <dlfcn.h>
#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Two time levels that are exchanged at each step; the one before is overwritten. qv has 32 bits where ComIn has them.
 */
static void set_variables(int step)
{
    static double *levels[2 * ALL_VARIABLES][2];
    for (int i = 0; i < double_icon.variables; i++) {
        double_variable *variable = &double_icon.variable[i];
        const icon_domain *domain = &double_icon.domain[variable->domain];
        int number = i % ALL_VARIABLES, count = icon_values(domain, number);
        for (int level = 0; level < 2; level++) {
            size_t size = ((size_t)count + 1) * sizeof(double);
            levels[i][level] = levels[i][level] ? levels[i][level] : malloc(size);
            icon_fill(domain, number, level == step % 2 ? step : 1000 + step, levels[i][level]);
        }
        variable->now = levels[i][step % 2];
        variable->is_float = COMIN_DOUBLE >= 3 && number == 3;
        for (int k = 0; k < count && variable->is_float; k++) {
            float narrow = (float)levels[i][step % 2][k];
            memcpy((char *)variable->now + 4 * k, &narrow, 4);
        }
    }
}

int main(int argc, char **argv)
{
    int rank, ranks;
    MPI_Init(&argc, &argv);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    const char *fault = argc > 6 && rank == 1 ? argv[6] : "";
    double_icon.communicator = MPI_Comm_c2f(MPI_COMM_WORLD);
    double_icon.rank = rank;
    double_icon.options = argv[2];
    double_icon.domains = atoi(argv[3]);
    double_icon.start = "2026-02-28T12:00:00.000";
    for (int number = 1; number <= double_icon.domains; number++) {
        double_icon.domain[number] = icon_make(number, rank, ranks);
        for (int i = 0; i < ALL_VARIABLES; i++) {
            double_variable variable = {&icon_variables[i], number, 0, NULL};
            double_icon.variable[double_icon.variables++] = variable;
        }
    }
    if (strcmp(fault, "table") == 0) {
        double_icon.domain[1].vertex_index[0] = double_icon.domain[1].vertex_index[1];
        double_icon.domain[1].vertex_block[0] = double_icon.domain[1].vertex_block[1];
    }
    int first = atoi(argv[4]), last = atoi(argv[5]);
    icon_date(first, double_icon.date);
    void *library = dlopen(argv[1], RTLD_NOW);
    union {
        void *object;
        void (*call)(void);
    } start = {library != NULL ? dlsym(library, "comin_main") : NULL};
    if (start.object == NULL) {
        printf("%s\n", dlerror());
        return 4;
    }
    start.call();
    set_variables(first);
    double_call(EP_SECONDARY_CONSTRUCTOR, COMIN_DOMAIN_OUTSIDE_LOOP);
    for (int step = first; step <= last; step++) {
        icon_date(step, double_icon.date);
        set_variables(step);
        double_call(EP_ATM_WRITE_OUTPUT_BEFORE, COMIN_DOMAIN_OUTSIDE_LOOP);
    }
    double_call(EP_DESTRUCTOR, COMIN_DOMAIN_OUTSIDE_LOOP);
    MPI_Finalize();
    printf("the host ended well\n");
    return 0;
}
