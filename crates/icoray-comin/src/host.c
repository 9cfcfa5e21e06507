/* ICON as ComIn shows it. One source for ComIn 0.2 and from 0.3 on: comin.h of the user's ICON decides. */
#include "host.h"

#include <comin.h>
#include <stdio.h>
#include <string.h>

#if COMIN_VERSION_MAJOR == 0 && COMIN_VERSION_MINOR < 3
#define IS_0_2 1
#else
#define IS_0_2 0
#endif

/* Functions that not every release has. A plugin that was compiled for another release is loaded all the same, and
 * host_fits finds out: a missing function would end ICON. */
#if IS_0_2
#pragma weak comin_var_get_pos
#else
#pragma weak comin_var_get_dim_semantics
#pragma weak comin_var_get_ptr_double
#pragma weak comin_var_get_ptr_float
#pragma weak comin_var_descr_list_iterator_delete
#pragma weak comin_error_reset
#pragma weak comin_print_info
#pragma weak comin_print_warning
#endif

int host_fits(void)
{
#if IS_0_2
    return comin_var_get_pos != NULL;
#else
    return comin_var_get_dim_semantics != NULL && comin_var_get_ptr_double != NULL && comin_var_get_ptr_float != NULL &&
           comin_var_descr_list_iterator_delete != NULL && comin_error_reset != NULL && comin_print_info != NULL &&
           comin_print_warning != NULL;
#endif
}

void host_keep_errors(void)
{
    comin_error_set_errors_return(true);
}

void host_register(void (*set_up)(void), void (*draw)(void), void (*finish)(void))
{
    comin_callback_register(EP_SECONDARY_CONSTRUCTOR, set_up);
    comin_callback_register(EP_ATM_WRITE_OUTPUT_BEFORE, draw);
    comin_callback_register(EP_DESTRUCTOR, finish);
}

void host_say(int is_warning, const char *line)
{
    char text[480];
    snprintf(text, sizeof text, "icoray: %s%s", is_warning ? "warning: " : "", line);
#if !IS_0_2
    if (host_fits()) {
        (is_warning ? comin_print_warning : comin_print_info)(text);
        return;
    }
#endif
    fprintf(stderr, "%s\n", text);
}

void host_warn_once(const char *line)
{
    if (comin_parallel_get_host_mpi_rank() == 0) {
        host_say(1, line);
    }
}

int32_t host_communicator(void)
{
    /* Not the communicator of the plugin, which has its external partners too. */
    return comin_parallel_get_host_mpi_comm();
}

/* Copies text of ComIn, which ends in blanks or in nothing. */
static int copied(char *to, size_t size, const char *from, int length)
{
    size_t end = from != NULL && length > 0 ? (size_t)length : 0;
    const char *nul = end > 0 ? memchr(from, 0, end) : NULL;
    if (nul != NULL) {
        end = (size_t)(nul - from);
    }
    while (end > 0 && from[end - 1] == ' ') {
        end--;
    }
    if (end >= size) {
        return 0;
    }
    if (end > 0) {
        memcpy(to, from, end);
    }
    to[end] = 0;
    return 1;
}

int host_options(char *to, size_t size)
{
    const char *text = NULL;
    int length = 0;
    comin_current_get_plugin_options(&text, &length);
    return copied(to, size, text, length);
}

int host_date(char *to, size_t size)
{
    const char *text = NULL;
    int length = 0;
    comin_current_get_datetime(&text, &length);
    return copied(to, size, text, length);
}

int host_start_date(char *to, size_t size)
{
    const char *text = NULL;
    int length = 0;
    comin_descrdata_get_simulation_interval_exp_start(&text, &length);
    return copied(to, size, text, length);
}

int host_current_domain(void)
{
    return comin_current_get_domain_id();
}

int host_domains(void)
{
    return comin_descrdata_get_global_n_dom();
}

double host_step_seconds(int domain)
{
    return comin_descrdata_get_timesteplength(domain);
}

/* Tables are given as pointers to const from 0.3 on. */
const double *host_half_levels(int *count)
{
    const double *heights = NULL;
    *count = 0;
    comin_descrdata_get_global_vct_a((void *)&heights, count);
    return heights;
}

void host_read_domain(int id, host_domain *domain)
{
    int extents[3];
    memset(domain, 0, sizeof *domain);
    domain->id = id;
    domain->nproma = comin_descrdata_get_global_nproma();
    domain->levels = comin_descrdata_get_domain_nlev(id);
    domain->shift = comin_descrdata_get_domain_nshift_total(id);
    domain->cells = comin_descrdata_get_domain_cells_ncells(id);
    domain->cells_of_all_ranks = comin_descrdata_get_domain_cells_ncells_global(id);
    domain->vertices = comin_descrdata_get_domain_verts_nverts(id);
    comin_descrdata_get_domain_cells_vertex_idx(id, (void *)&domain->vertex_index, extents);
    domain->cell_blocks = extents[1];
    comin_descrdata_get_domain_cells_vertex_blk(id, (void *)&domain->vertex_block, extents);
    comin_descrdata_get_domain_cells_glb_index(id, (void *)&domain->global_index, extents);
    comin_descrdata_get_domain_cells_decomp_domain(id, (void *)&domain->decomposition, extents);
    comin_descrdata_get_domain_cells_clon(id, (void *)&domain->lon_triangle, extents);
    comin_descrdata_get_domain_cells_clat(id, (void *)&domain->lat_triangle, extents);
    comin_descrdata_get_domain_verts_vlon(id, (void *)&domain->lon_vertex, extents);
    comin_descrdata_get_domain_verts_vlat(id, (void *)&domain->lat_vertex, extents);
    comin_descrdata_get_domain_cells_hhl(id, (void *)&domain->heights, extents);
}

/* Whether ICON has the variable: asking for another one would leave an error in ComIn, which 0.2 cannot forget. */
static int is_there(const struct t_comin_var_descriptor *wanted)
{
    int found = 0;
    void *at = comin_var_get_descr_list_head();
    /* To the end: the step past the last one frees what 0.3 made for the loop. */
    for (; at != NULL; at = comin_var_get_descr_list_next(at)) {
        struct t_comin_var_descriptor listed;
        memset(&listed, 0, sizeof listed);
        comin_var_get_descr_list_var_desc(at, &listed);
        found |= listed.id == wanted->id && strcmp(listed.name, wanted->name) == 0;
    }
    return found;
}

/* Whether a variable has this key in its metadata. The request for an absent key would leave an error. */
static int has_key(struct t_comin_var_descriptor of, const char *key)
{
    int is_found = 0;
    void *at = comin_metadata_get_iterator_begin(of), *end = comin_metadata_get_iterator_end(of);
    for (; !comin_metadata_iterator_compare(at, end); comin_metadata_iterator_next(at)) {
        is_found |= strcmp(comin_metadata_iterator_get_key(at), key) == 0;
    }
    comin_metadata_iterator_delete(at);
    comin_metadata_iterator_delete(end);
    return is_found;
}

/* ICON gives no place for variables of plugins: they are at triangles. */
static host_place place_of(struct t_comin_var_descriptor of)
{
    int place = COMIN_HGRID_UNSTRUCTURED_CELL;
    if (has_key(of, "hgrid_id")) {
        comin_metadata_get_integer(of, "hgrid_id", &place);
    }
    return place == COMIN_HGRID_UNSTRUCTURED_CELL     ? HOST_TRIANGLES
           : place == COMIN_HGRID_UNSTRUCTURED_VERTEX ? HOST_VERTICES
                                                      : HOST_EDGES;
}

void host_describe(const char *name, int domain, const char *key, char *to, size_t size)
{
    struct t_comin_var_descriptor of;
    const char *text = NULL;
    int length = 0;
    memset(&of, 0, sizeof of);
    snprintf(of.name, sizeof of.name, "%s", name);
    of.id = domain;
    if (has_key(of, key)) {
        comin_metadata_get_character(of, key, &text, &length);
    }
    if (!copied(to, size, text, length)) {
        to[0] = 0;
    }
}

void *host_request(const char *name, int domain, host_place *place)
{
    struct t_comin_var_descriptor wanted;
#if IS_0_2
    int places[] = {EP_ATM_WRITE_OUTPUT_BEFORE};
#else
    t_comin_entry_point places[] = {EP_ATM_WRITE_OUTPUT_BEFORE};
#endif
    memset(&wanted, 0, sizeof wanted);
    *place = HOST_NOWHERE;
    if (strlen(name) >= sizeof wanted.name) {
        return NULL;
    }
    strcpy(wanted.name, name);
    wanted.id = domain;
    if (!is_there(&wanted)) {
        return NULL;
    }
    *place = place_of(wanted);
    return *place != HOST_EDGES ? comin_var_get(1, places, wanted, COMIN_FLAG_READ) : NULL;
}

/* The positions of the dimensions nproma, levels (negative if there is none) and blocks. */
static void positions(void *variable, int *column, int *level, int *block)
{
#if IS_0_2
    int other = -1;
    comin_var_get_pos(variable, column, level, block, &other);
#else
    int meanings[5] = {0};
    *column = *level = *block = -1;
    comin_var_get_dim_semantics(variable, meanings);
    for (int i = 4; i >= 0; i--) {
        *column = meanings[i] == COMIN_DIM_SEMANTICS_NPROMA ? i : *column;
        *level = meanings[i] == COMIN_DIM_SEMANTICS_LEVEL ? i : *level;
        *block = meanings[i] == COMIN_DIM_SEMANTICS_BLOCK ? i : *block;
    }
#endif
}

const char *host_values_of(void *variable, host_values *values)
{
    int shape[5] = {0}, column, level, block;
    memset(values, 0, sizeof *values);
    positions(variable, &column, &level, &block);
    comin_var_get_shape(variable, shape);
    /* In ICON's containers a variable is a slice, whose strides ComIn gives only if it is in one piece. */
    if (column != 0 || !((level < 0 && block == 1) || (level == 1 && block == 2))) {
        return "not an array (nproma, blocks) or (nproma, levels, blocks)";
    }
    values->nproma = shape[0];
    values->levels = level < 0 ? 0 : shape[1];
    values->blocks = shape[block];
#if IS_0_2
    values->data = comin_var_get_ptr(variable);
#else
    values->data = comin_var_get_ptr_double(variable);
    if (values->data == NULL) {
        comin_error_reset();
        values->data = comin_var_get_ptr_float(variable);
        values->is_float = 1;
        comin_error_reset();
    }
#endif
    return values->data == NULL ? "without values in 32 or 64 bits" : NULL;
}
