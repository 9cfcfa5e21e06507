/* The double of libcomin. What ends ICON in the real one, ends the process here, with status 3. */
#include "double.h"

#include <comin.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

double_state double_icon;
static bool errors_return;
static int error;
static struct {
    int entry_point;
    void (*call)(void);
} callbacks[8];
static int callback_count, current_domain, is_past_setup;

static void set_error(const char *what)
{
    error = 1;
    if (!errors_return) {
        printf("ComIn ends the model: %s\n", what);
        exit(3);
    }
}

void double_call(int entry_point, int domain)
{
    current_domain = domain;
    for (int i = 0; i < callback_count; i++) {
        if (callbacks[i].entry_point == entry_point) {
            callbacks[i].call();
        }
    }
    is_past_setup |= entry_point == EP_SECONDARY_CONSTRUCTOR;
    if (error != 0) {
        printf("an error is left in ComIn\n");
    }
}

int comin_current_get_domain_id(void) { return current_domain; }
int comin_parallel_get_host_mpi_rank(void) { return double_icon.rank; }
int comin_parallel_get_host_mpi_comm(void) { return double_icon.communicator; }
void comin_error_set_errors_return(bool on) { errors_return = on; }
double comin_descrdata_get_timesteplength(int jg) { return 1800.0 / jg; }
int comin_descrdata_get_global_n_dom(void) { return double_icon.domains; }
int comin_descrdata_get_global_nproma(void) { return NPROMA; }
int comin_descrdata_get_domain_nlev(int jg) { return jg > 0 ? LEVELS : 0; }
int comin_descrdata_get_domain_nshift_total(int jg) { return jg > 0 ? 0 : -1; }

static void text_of(const char *text, char const **val, int *len)
{
    *val = text;
    *len = (int)strlen(text);
}

void comin_current_get_plugin_options(char const **val, int *len) { text_of(double_icon.options, val, len); }
void comin_current_get_datetime(char const **val, int *len) { text_of(double_icon.date, val, len); }
void comin_descrdata_get_simulation_interval_exp_start(char const **val, int *len)
{
    text_of(double_icon.start, val, len);
}

void comin_callback_register(t_comin_entry_point entry_point_id, void (*fct_ptr)(void))
{
    callbacks[callback_count].entry_point = (int)entry_point_id;
    callbacks[callback_count++].call = fct_ptr;
}

/* A handle is a variable of a domain. */
t_comin_var_handle *comin_var_get(int context_len, t_comin_entry_point *context,
                                  struct t_comin_var_descriptor descriptor, int flag)
{
    if (is_past_setup || context_len != 1 || (int)context[0] != EP_ATM_WRITE_OUTPUT_BEFORE || flag != COMIN_FLAG_READ) {
        set_error("comin_var_get");
        return NULL;
    }
    for (int i = 0; i < double_icon.variables; i++) {
        double_variable *variable = &double_icon.variable[i];
        if (strcmp(variable->of->name, descriptor.name) == 0 && variable->domain == descriptor.id) {
            printf("requested %s of domain %d\n", descriptor.name, descriptor.id);
            return (void *)variable;
        }
    }
    set_error("no such variable");
    return NULL;
}

void comin_var_get_shape(t_comin_var_handle *handle, int shape[5])
{
    const double_variable *variable = (void *)handle;
    int blocks = icon_blocks(&double_icon.domain[variable->domain], variable->of), levels = variable->of->levels;
    int of[5] = {NPROMA, levels > 0 ? levels : blocks, levels > 0 ? blocks : 1, 1, 1};
    memcpy(shape, of, sizeof of);
}

/* An iterator is the number of a key. Variables of plugins (few and many) have no key of their place. */
static const char *const keys[] = {"units", "long_name", "hgrid_id"};

static const double_variable *described(struct t_comin_var_descriptor descriptor)
{
    for (int i = 0; i < double_icon.variables; i++) {
        const double_variable *variable = &double_icon.variable[i];
        if (strcmp(variable->of->name, descriptor.name) == 0 && variable->domain == descriptor.id) {
            return variable;
        }
    }
    set_error("no such variable");
    return double_icon.variable;
}

static int key_count(struct t_comin_var_descriptor of)
{
    const char *name = described(of)->of->name;
    return strcmp(name, "few") == 0 || strcmp(name, "many") == 0 ? 1 : 3;
}

static t_comin_metadata_iterator *iterator(int number)
{
    int *made = malloc(sizeof *made);
    if (made == NULL) {
        abort();
    }
    *made = number;
    return (void *)made;
}

t_comin_metadata_iterator *comin_metadata_get_iterator_begin(struct t_comin_var_descriptor of)
{
    (void)of;
    return iterator(0);
}
t_comin_metadata_iterator *comin_metadata_get_iterator_end(struct t_comin_var_descriptor of)
{
    return iterator(key_count(of));
}
const char *comin_metadata_iterator_get_key(t_comin_metadata_iterator *it) { return keys[*(int *)(void *)it]; }
bool comin_metadata_iterator_compare(t_comin_metadata_iterator *a, t_comin_metadata_iterator *b)
{
    return *(int *)(void *)a == *(int *)(void *)b;
}
void comin_metadata_iterator_next(t_comin_metadata_iterator *it) { ++*(int *)(void *)it; }
void comin_metadata_iterator_delete(t_comin_metadata_iterator *it) { free(it); }

void comin_metadata_get_integer(struct t_comin_var_descriptor of, const char *key, int *value)
{
    if (strcmp(key, "hgrid_id") != 0 || key_count(of) < 3) {
        set_error("no such key");
        return;
    }
    *value = described(of)->of->place;
}

void comin_metadata_get_character(struct t_comin_var_descriptor of, const char *key, char const **val, int *len)
{
    const icon_variable *variable = described(of)->of;
    if (strcmp(key, "units") != 0 && (strcmp(key, "long_name") != 0 || key_count(of) < 3)) {
        set_error("no such key");
        return;
    }
    text_of(strcmp(key, "units") == 0 ? variable->units : variable->long_name, val, len);
}

t_comin_var_descr_list_iterator *comin_var_get_descr_list_head(void) { return (void *)double_icon.variable; }

t_comin_var_descr_list_iterator *comin_var_get_descr_list_next(t_comin_var_descr_list_iterator *current)
{
    double_variable *next = (double_variable *)(void *)current + 1;
    return next < double_icon.variable + double_icon.variables ? (void *)next : NULL;
}

void comin_var_get_descr_list_var_desc(t_comin_var_descr_list_iterator *current, struct t_comin_var_descriptor *to)
{
    const double_variable *variable = (void *)current;
    strcpy(to->name, variable->of->name);
    to->id = variable->domain;
}

#if COMIN_DOUBLE >= 3
void *comin_var_get_ptr(t_comin_var_handle *handle) { return ((double_variable *)(void *)handle)->now; }
double *comin_var_get_ptr_double(t_comin_var_handle *handle)
{
    double_variable *variable = (void *)handle;
    if (variable->is_float) {
        set_error("not a double");
    }
    return variable->is_float ? NULL : variable->now;
}
float *comin_var_get_ptr_float(t_comin_var_handle *handle)
{
    double_variable *variable = (void *)handle;
    if (!variable->is_float) {
        set_error("not a float");
    }
    return variable->is_float ? variable->now : NULL;
}
void comin_var_get_dim_semantics(t_comin_var_handle *handle, int dim_semantics[5])
{
    const double_variable *variable = (void *)handle;
    int has_levels = variable->of->levels > 0, unused = COMIN_DIM_SEMANTICS_UNUSED;
    int flat[5] = {COMIN_DIM_SEMANTICS_NPROMA, COMIN_DIM_SEMANTICS_BLOCK, unused, unused, unused};
    int deep[5] = {COMIN_DIM_SEMANTICS_NPROMA, COMIN_DIM_SEMANTICS_LEVEL, COMIN_DIM_SEMANTICS_BLOCK, unused, unused};
    memcpy(dim_semantics, has_levels ? deep : flat, sizeof flat);
}
void comin_var_descr_list_iterator_delete(t_comin_var_descr_list_iterator **it) { *it = NULL; }
void comin_error_reset(void) { error = 0; }
void comin_print_info(const char *msg) { printf("info: %s\n", msg); }
void comin_print_warning(const char *msg) { printf("warning: %s\n", msg); }
#else
double *comin_var_get_ptr(void *handle) { return ((double_variable *)handle)->now; }
void comin_var_get_pos(void *handle, int *pos_jc, int *pos_jk, int *pos_jb, int *pos_jn)
{
    int has_levels = ((double_variable *)handle)->of->levels > 0;
    *pos_jc = 0;
    *pos_jk = has_levels ? 1 : -2;
    *pos_jb = has_levels ? 2 : 1;
    *pos_jn = -2;
}
#endif

void comin_descrdata_get_global_vct_a(TABLE double **vct_a, int *arr_size)
{
    *vct_a = (TABLE double *)icon_half_levels;
    *arr_size = LEVELS + 1;
}

#define SIZE(member, count) \
    int comin_descrdata_get_domain_##member(int jg) { return double_icon.domain[jg].count; }
SIZE(cells_ncells, triangles)
SIZE(cells_ncells_global, all_triangles)
SIZE(verts_nverts, vertices)

/* Tables of two dimensions, (NPROMA, blocks), of three, or of one. */
#define ARRAY(type, member, name, extent0, extent1, extent2) \
    void comin_descrdata_get_domain_##member(int jg, TABLE type **to, int *arr_size) \
    { \
        const icon_domain *of = &double_icon.domain[jg]; \
        int extents[3] = {extent0, extent1, extent2}; \
        *to = of->name; \
        for (int i = 0; i < 3 && extents[i] > 0; i++) { \
            arr_size[i] = extents[i]; \
        } \
    }
ARRAY(int, cells_vertex_idx, vertex_index, NPROMA, of->blocks, 3)
ARRAY(int, cells_vertex_blk, vertex_block, NPROMA, of->blocks, 3)
ARRAY(int, cells_glb_index, global_index, of->triangles, 0, 0)
ARRAY(int, cells_decomp_domain, decomposition, NPROMA, of->blocks, 0)
ARRAY(double, cells_clon, lon_triangle, NPROMA, of->blocks, 0)
ARRAY(double, cells_clat, lat_triangle, NPROMA, of->blocks, 0)
ARRAY(double, cells_hhl, heights, NPROMA, LEVELS + 1, of->blocks)
ARRAY(double, verts_vlon, lon_vertex, NPROMA, of->vertex_blocks, 0)
ARRAY(double, verts_vlat, lat_vertex, NPROMA, of->vertex_blocks, 0)
