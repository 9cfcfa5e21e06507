/* Writes what ComIn's comin_replay plays back in place of ICON: replay RANKS LAST VARIABLES PLUGIN OPTIONS MAJOR MINOR
 * writes N.nc with the domain of each rank and vars_N.nc with its variables for the steps 0 to LAST, and master.nml. */
#include "icon.h"

#include <netcdf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Entry points of comin.h. */
enum { SECONDARY_CONSTRUCTOR = 1, TIMELOOP_START = 10, WRITE_OUTPUT_BEFORE = 17, DESTRUCTOR = 42 };

static void check(int status)
{
    if (status != NC_NOERR) {
        fprintf(stderr, "%s\n", nc_strerror(status));
        exit(1);
    }
}

static void put_int(int file, const char *name, int value)
{
    check(nc_put_att_int(file, NC_GLOBAL, name, NC_INT, 1, &value));
}

/* Extents as in Fortran, the first running fastest. */
static int define(int file, const char *name, nc_type type, int rank, const size_t *extents, int first)
{
    char dimension[80];
    int dimensions[7], variable, count = 0;
    if (first >= 0) {
        dimensions[count++] = first;
    }
    for (int i = rank - 1; i >= 0; i--) {
        snprintf(dimension, sizeof dimension, "%s_dim_%d", name, i + 1);
        check(nc_def_dim(file, dimension, extents[i], &dimensions[count++]));
    }
    check(nc_def_var(file, name, type, count, dimensions, &variable));
    return variable;
}

static void put(int file, const char *name, nc_type type, size_t a, size_t b, size_t c, const void *values)
{
    size_t extents[] = {a, b, c};
    int variable = define(file, name, type, b == 0 ? 1 : c == 0 ? 2 : 3, extents, -1);
    check(nc_put_var(file, variable, values));
}

static int create(const char *prefix, int rank, int ranks, const int version[3])
{
    char path[40];
    int file;
    snprintf(path, sizeof path, "%s%d.nc", prefix, rank);
    check(nc_create(path, NC_NETCDF4 | NC_CLOBBER, &file));
    check(nc_put_att_int(file, NC_GLOBAL, "comin_version", NC_INT, 3, version));
    put_int(file, "host_comm_rank", rank);
    put_int(file, "host_comm_size", ranks);
    return file;
}

static void write_domain(int file, const icon_domain *domain)
{
    static const char *const dates[] = {"exp_start", "exp_stop", "run_start", "run_stop"};
    static const struct {
        const char *name;
        int value;
    } numbers[] = {{"n_dom", 1},          {"max_dom", 1},         {"nproma", NPROMA},     {"wp", 8},
                   {"min_rlcell_int", -4}, {"min_rlcell", -8},     {"max_rlcell", 14},     {"min_rlvert_int", -4},
                   {"min_rlvert", -7},     {"max_rlvert", 7},      {"min_rledge_int", -8}, {"min_rledge", -13},
                   {"max_rledge", 28},     {"grf_bdywidth_c", 4},  {"grf_bdywidth_e", 9},  {"lrestartrun", 0},
                   {"yac_instance_id", -1}, {"has_device", 0}};
    int group;
    double zero = 0.0, step_s = 1800.0;
    size_t blocks = (size_t)domain->blocks, vertex_blocks = (size_t)domain->vertex_blocks;
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        put_int(file, numbers[i].name, numbers[i].value);
    }
    for (int i = 0; i < 4; i++) {
        char date[48];
        icon_date(i % 2 == 0 ? 0 : 40, date);
        check(nc_put_att_text(file, NC_GLOBAL, dates[i], strlen(date), date));
    }
    put(file, "vct_a", NC_DOUBLE, LEVELS + 1, 0, 0, icon_half_levels);
    check(nc_def_grp(file, "domain_1", &group));
    check(nc_put_att_double(group, NC_GLOBAL, "dom_start", NC_DOUBLE, 1, &zero));
    check(nc_put_att_double(group, NC_GLOBAL, "dom_end", NC_DOUBLE, 1, &zero));
    check(nc_put_att_double(group, NC_GLOBAL, "timestep_length", NC_DOUBLE, 1, &step_s));
    put_int(group, "id", 1);
    put_int(group, "nlev", LEVELS);
    put_int(group, "nshift_total", 0);
    put_int(group, "cells%ncells", domain->triangles);
    put_int(group, "cells%ncells_global", domain->all_triangles);
    put_int(group, "cells%nblks", domain->blocks);
    put_int(group, "verts%nverts", domain->vertices);
    put_int(group, "verts%nblks", domain->vertex_blocks);
    put(group, "cells%vertex_idx", NC_INT, NPROMA, blocks, 3, domain->vertex_index);
    put(group, "cells%vertex_blk", NC_INT, NPROMA, blocks, 3, domain->vertex_block);
    put(group, "cells%clon", NC_DOUBLE, NPROMA, blocks, 0, domain->lon_triangle);
    put(group, "cells%clat", NC_DOUBLE, NPROMA, blocks, 0, domain->lat_triangle);
    put(group, "cells%hhl", NC_DOUBLE, NPROMA, LEVELS + 1, blocks, domain->heights);
    put(group, "cells%glb_index", NC_INT, (size_t)domain->triangles, 0, 0, domain->global_index);
    put(group, "cells%decomp_domain", NC_INT, NPROMA, blocks, 0, domain->decomposition);
    put(group, "verts%vlon", NC_DOUBLE, NPROMA, vertex_blocks, 0, domain->lon_vertex);
    put(group, "verts%vlat", NC_DOUBLE, NPROMA, vertex_blocks, 0, domain->lat_vertex);
}

/* The calls of entry points: values are set at the start of each step, before its output. */
static void write_calls(int file, int last)
{
    int count = 2 + 2 * (last + 1), variable;
    int *calls = calloc((size_t)count, sizeof *calls), *domains = calloc((size_t)count, sizeof *domains);
    char *dates = calloc((size_t)count, 32);
    size_t extents[] = {32, (size_t)count};
    for (int i = 0; i < count; i++) {
        char date[48];
        int step = i == 0 ? 0 : i == count - 1 ? last : (i - 1) / 2;
        int in_step = i % 2 == 1 ? TIMELOOP_START : WRITE_OUTPUT_BEFORE;
        calls[i] = i == 0 ? SECONDARY_CONSTRUCTOR : i == count - 1 ? DESTRUCTOR : in_step;
        domains[i] = -1;
        icon_date(step, date);
        memcpy(dates + 32 * i, date, strlen(date));
    }
    put(file, "current_ep", NC_INT, (size_t)count, 0, 0, calls);
    put(file, "current_domain_id", NC_INT, (size_t)count, 0, 0, domains);
    variable = define(file, "current_datetime", NC_CHAR, 2, extents, -1);
    check(nc_put_var(file, variable, dates));
    free(calls);
    free(domains);
    free(dates);
}

static void write_variables(int file, const icon_domain *domain, int last)
{
    int event, group;
    check(nc_def_dim(file, "event", NC_UNLIMITED, &event));
    check(nc_def_grp(file, "domain_1", &group));
    for (int i = 0; i < VARIABLES; i++) {
        int levels = icon_variables[i].levels, is_flat = levels == 0, zaxis = is_flat ? 1 : levels == LEVELS ? 2 : 3;
        int positions[] = {1, is_flat ? -1 : 2, is_flat ? 2 : 3};
        size_t blocks = (size_t)domain->blocks;
        size_t extents[] = {NPROMA, is_flat ? blocks : (size_t)levels, is_flat ? 1 : blocks, 1, 1};
        size_t start[6] = {0}, count[6] = {1, 1, 1, extents[2], extents[1], NPROMA};
        signed char no = 0;
        int variable = define(group, icon_variables[i].name, NC_DOUBLE, 5, extents, event);
        double *values = malloc((size_t)icon_values(domain, i) * sizeof *values);
        check(nc_put_att_schar(group, variable, "metadata::tracer", NC_BYTE, 1, &no));
        check(nc_put_att_int(group, variable, "metadata::zaxis_id", NC_INT, 1, &zaxis));
        check(nc_put_att_int(group, variable, "pos_jc", NC_INT, 1, &positions[0]));
        check(nc_put_att_int(group, variable, "pos_jk", NC_INT, 1, &positions[1]));
        check(nc_put_att_int(group, variable, "pos_jb", NC_INT, 1, &positions[2]));
        for (int step = 0; step <= last; step++) {
            start[0] = (size_t)step;
            icon_fill(domain, i, step, values);
            check(nc_put_vara_double(group, variable, start, count, values));
        }
        free(values);
    }
}

int main(int argc, char **argv)
{
    int ranks = argc > 7 ? atoi(argv[1]) : 0, last = atoi(argv[2]);
    int version[3] = {atoi(argv[6]), atoi(argv[7]), 0};
    for (int rank = 0; rank < ranks; rank++) {
        icon_domain domain = icon_make(1, rank, ranks);
        int file = create("", rank, ranks, version);
        write_domain(file, &domain);
        write_calls(file, last);
        check(nc_close(file));
        file = create("vars_", rank, ranks, version);
        write_variables(file, &domain, last);
        check(nc_close(file));
    }
    FILE *list = fopen("master.nml", "w");
    fprintf(list, "&comin_nml\n  plugin_list(1)%%plugin_library = \"%s\"\n", argv[3]);
    fprintf(list, "  plugin_list(2)%%plugin_library = \"%s\", plugin_list(2)%%options = \"%s\",\n", argv[4], argv[5]);
    fprintf(list, "  plugin_list(2)%%comm = \"icoray\"\n/\n");
    return fclose(list);
}
