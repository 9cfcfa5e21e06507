/* The data of ICON that the plugin reads. Only host.c includes comin.h: that of ComIn 0.2 defines constants, which two
 * files of a library must not. */
#ifndef ICORAY_COMIN_HOST_H
#define ICORAY_COMIN_HOST_H

#include <stddef.h>
#include <stdint.h>

/* A domain of ICON on this process. Columns are in blocks of nproma; column i of a table (nproma, blocks) is element i,
 * and entry k of its row in a table (nproma, blocks, 3) is element i + k*nproma*blocks. */
typedef struct {
    int id, nproma;
    int levels; /* full levels */
    int shift;  /* levels of the outermost domain above its top */
    int cells, cell_blocks, cells_of_all_ranks, vertices;
    const int *vertex_index, *vertex_block; /* of each triangle, from 1 (nproma, cell_blocks, 3) */
    const int *global_index;                /* of each triangle, from 1 */
    const int *decomposition;               /* 0 for own triangles */
    const double *lon_triangle, *lat_triangle, *lon_vertex, *lat_vertex; /* radians */
    const double *heights; /* of half levels, metres, from the top (nproma, levels + 1, cell_blocks) */
} host_domain;

/* The location of a variable's values in ICON. */
typedef enum { HOST_NOWHERE, HOST_TRIANGLES, HOST_EDGES, HOST_VERTICES } host_place;

/* Values at triangles or vertices as ICON has them at this time. */
typedef struct {
    const void *data;
    int is_float;
    int nproma, levels, blocks; /* levels is 0 for one value per column */
} host_values;

/* Whether the libcomin that is loaded has the functions of the comin.h that the plugin was compiled with. */
int host_fits(void);

/* Makes errors of ComIn return to the plugin: otherwise they end ICON. */
void host_keep_errors(void);

/* Calls these in ICON's secondary constructor, before each output (first that of the initial state), and at its end. */
void host_register(void (*set_up)(void), void (*draw)(void), void (*finish)(void));

/* Writes a line to the log of ICON. */
void host_say(int is_warning, const char *line);

/* Warns on the first process alone of what all of them find. */
void host_warn_once(const char *line);

/* The Fortran handle of the communicator of the processes that have parts of the domains. */
int32_t host_communicator(void);

/* Copies the plugin's options, or the present date. Returns 0 if `size` bytes are too few. */
int host_options(char *to, size_t size);
int host_date(char *to, size_t size);
int host_start_date(char *to, size_t size);

/* The domain of the running callback; below 1 outside of the loop over domains. */
int host_current_domain(void);
int host_domains(void);
double host_step_seconds(int domain);

/* Heights of all half levels over flat ground, metres, from the top. */
const double *host_half_levels(int *count);
void host_read_domain(int id, host_domain *domain);

/* Requests a variable for the calls before output, and writes its place; NULL if ICON has none of that name, or has it at
 * edges. In the secondary constructor only. */
void *host_request(const char *name, int domain, host_place *place);

/* Copies the metadata of a requested variable ("long_name", "units"); nothing where they are absent or `size` bytes are
 * too few. */
void host_describe(const char *name, int domain, const char *key, char *to, size_t size);

/* The current address of a variable's values, as ICON swaps time levels. Returns NULL, or why they cannot be read. */
const char *host_values_of(void *variable, host_values *values);

#endif
