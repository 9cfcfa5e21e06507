/* Writes domain 1 as ICON's output does: file PATH LAST, with the steps 0 to LAST. */
#include "icon.h"

#include <netcdf.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int file;

static void check(int status)
{
    if (status != NC_NOERR) {
        fprintf(stderr, "%s\n", nc_strerror(status));
        exit(1);
    }
}

static int dimension(const char *name, size_t length)
{
    int id;
    check(nc_def_dim(file, name, length, &id));
    return id;
}

static int variable(const char *name, int rank, int a, int b, int c, const char *units)
{
    int id, dimensions[] = {a, b, c};
    check(nc_def_var(file, name, NC_DOUBLE, rank, dimensions, &id));
    check(nc_put_att_text(file, id, "units", strlen(units), units));
    return id;
}

static double *numbers(size_t count)
{
    double *values = malloc((count + 1) * sizeof *values);
    if (values == NULL) {
        abort();
    }
    return values;
}

/* The longitude or latitude of the corners of each triangle. */
static double *bounds(const icon_domain *domain, const double *of_vertex)
{
    size_t columns = (size_t)domain->blocks * NPROMA;
    double *values = numbers(3 * (size_t)domain->triangles);
    for (int i = 0; i < domain->triangles; i++) {
        for (int k = 0; k < 3; k++) {
            size_t at = (size_t)i + (size_t)k * columns;
            values[3 * i + k] = of_vertex[(domain->vertex_block[at] - 1) * NPROMA + domain->vertex_index[at] - 1];
        }
    }
    return values;
}

int main(int argc, char **argv)
{
    icon_domain domain = icon_make(1, 0, 1);
    size_t cells = (size_t)domain.triangles;
    int last = argc > 2 ? atoi(argv[2]) : 0;
    check(nc_create(argv[1], NC_NETCDF4 | NC_CLOBBER, &file));
    int ncells = dimension("ncells", cells), vertices = dimension("vertices", 3);
    int height = dimension("height", LEVELS), height_2 = dimension("height_2", LEVELS + 1);
    int time = dimension("time", (size_t)last + 1);
    int clon = variable("clon", 1, ncells, 0, 0, "radian"), clat = variable("clat", 1, ncells, 0, 0, "radian");
    int clon_bnds = variable("clon_bnds", 2, ncells, vertices, 0, "radian");
    int clat_bnds = variable("clat_bnds", 2, ncells, vertices, 0, "radian");
    int z_ifc = variable("z_ifc", 2, height_2, ncells, 0, "m");
    int seconds = variable("time", 1, time, 0, 0, "seconds since 2026-02-28 12:00:00"), of[VARIABLES];
    for (int v = 0; v < VARIABLES; v++) {
        int levels = icon_variables[v].levels, is_2d = levels == 0;
        of[v] = variable(icon_variables[v].name, is_2d ? 2 : 3, time,
                         is_2d ? ncells : levels == LEVELS ? height : height_2, ncells, "1");
    }
    check(nc_enddef(file));
    check(nc_put_var_double(file, clon, domain.lon_triangle));
    check(nc_put_var_double(file, clat, domain.lat_triangle));
    double *lon = bounds(&domain, domain.lon_vertex), *lat = bounds(&domain, domain.lat_vertex);
    check(nc_put_var_double(file, clon_bnds, lon));
    check(nc_put_var_double(file, clat_bnds, lat));
    double *values = numbers(cells);
    for (int level = 0; level <= LEVELS; level++) {
        size_t start[] = {(size_t)level, 0}, count[] = {1, cells};
        for (size_t i = 0; i < cells; i++) {
            values[i] = icon_height(domain.lon_triangle[i], domain.lat_triangle[i], level);
        }
        check(nc_put_vara_double(file, z_ifc, start, count, values));
    }
    for (int step = 0; step <= last; step++) {
        size_t at = (size_t)step;
        double now = 1800.0 * step;
        check(nc_put_var1_double(file, seconds, &at, &now));
        for (int v = 0; v < VARIABLES; v++) {
            int levels = icon_variables[v].levels, rows = levels > 0 ? levels : 1;
            for (int level = 0; level < rows; level++) {
                size_t start[] = {at, levels > 0 ? (size_t)level : 0, 0}, count[] = {1, levels > 0 ? 1 : cells, cells};
                for (size_t i = 0; i < cells; i++) {
                    values[i] = icon_value(v, domain.lon_triangle[i], domain.lat_triangle[i], level, step);
                }
                check(nc_put_vara_double(file, of[v], start, count, values));
            }
        }
    }
    check(nc_close(file));
    return 0;
}
