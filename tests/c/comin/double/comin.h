/* A double of ComIn's C interface, as far as icoray's plugin uses it: that of 0.2, or of 0.3 with COMIN_DOUBLE=3. */
#ifndef COMIN_H
#define COMIN_H

#include <stdbool.h>
#include <stdint.h>

#define COMIN_VERSION_MAJOR 0
#ifndef COMIN_DOUBLE
#error "COMIN_DOUBLE is the minor version, 2 or 3"
#endif
#define COMIN_VERSION_MINOR COMIN_DOUBLE
#define COMIN_VERSION_PATCH 0

struct t_comin_var_descriptor {
    char name[65];
    int id;
};

enum double_entry_point { EP_SECONDARY_CONSTRUCTOR = 1, EP_ATM_WRITE_OUTPUT_BEFORE = 17, EP_DESTRUCTOR = 42 };
enum { COMIN_FLAG_READ = 2 };
enum { COMIN_HGRID_UNSTRUCTURED_CELL = 1, COMIN_HGRID_UNSTRUCTURED_EDGE, COMIN_HGRID_UNSTRUCTURED_VERTEX };

#if COMIN_DOUBLE >= 3
#define TABLE const
typedef struct t_comin_var_descriptor t_comin_var_descriptor;
typedef enum double_entry_point t_comin_entry_point;
typedef struct t_comin_var_handle t_comin_var_handle;
typedef struct t_comin_var_descr_list_iterator t_comin_var_descr_list_iterator;
typedef struct t_comin_metadata_iterator t_comin_metadata_iterator;
enum {
    COMIN_DIM_SEMANTICS_NPROMA = 2,
    COMIN_DIM_SEMANTICS_BLOCK = 3,
    COMIN_DIM_SEMANTICS_LEVEL = 5,
    COMIN_DIM_SEMANTICS_UNUSED = 8
};
static const int COMIN_DOMAIN_OUTSIDE_LOOP = -1;
#else
#define TABLE
typedef int t_comin_entry_point;
typedef void t_comin_var_handle;
typedef void t_comin_var_descr_list_iterator;
typedef void t_comin_metadata_iterator;
/* Two files that include this header have it twice, and cannot be linked: as with the real one. */
const int COMIN_DOMAIN_OUTSIDE_LOOP = -1;
#endif

int comin_current_get_domain_id(void);
void comin_current_get_plugin_options(char const **val, int *len);
void comin_current_get_datetime(char const **val, int *len);
int comin_parallel_get_host_mpi_comm(void);
int comin_parallel_get_host_mpi_rank(void);
void comin_error_set_errors_return(bool errors_return);
void comin_callback_register(t_comin_entry_point entry_point_id, void (*fct_ptr)(void));
t_comin_var_handle *comin_var_get(int context_len, t_comin_entry_point *context,
                                  struct t_comin_var_descriptor descriptor, int flag);
void comin_var_get_shape(t_comin_var_handle *handle, int shape[5]);
t_comin_var_descr_list_iterator *comin_var_get_descr_list_head(void);
t_comin_var_descr_list_iterator *comin_var_get_descr_list_next(t_comin_var_descr_list_iterator *current);
void comin_var_get_descr_list_var_desc(t_comin_var_descr_list_iterator *current, struct t_comin_var_descriptor *to);

t_comin_metadata_iterator *comin_metadata_get_iterator_begin(struct t_comin_var_descriptor var_descriptor);
t_comin_metadata_iterator *comin_metadata_get_iterator_end(struct t_comin_var_descriptor var_descriptor);
const char *comin_metadata_iterator_get_key(t_comin_metadata_iterator *it);
bool comin_metadata_iterator_compare(t_comin_metadata_iterator *it1, t_comin_metadata_iterator *it2);
void comin_metadata_iterator_next(t_comin_metadata_iterator *it);
void comin_metadata_iterator_delete(t_comin_metadata_iterator *it);
void comin_metadata_get_integer(struct t_comin_var_descriptor var_descriptor, const char *key, int *val);
void comin_metadata_get_character(struct t_comin_var_descriptor var_descriptor, const char *key, char const **val,
                                  int *len);

#if COMIN_DOUBLE >= 3
void *comin_var_get_ptr(t_comin_var_handle *handle);
double *comin_var_get_ptr_double(t_comin_var_handle *handle);
float *comin_var_get_ptr_float(t_comin_var_handle *handle);
void comin_var_get_dim_semantics(t_comin_var_handle *handle, int dim_semantics[5]);
void comin_var_descr_list_iterator_delete(t_comin_var_descr_list_iterator **it);
void comin_error_reset(void);
void comin_print_info(const char *msg);
void comin_print_warning(const char *msg);
#else
double *comin_var_get_ptr(void *handle);
void comin_var_get_pos(void *handle, int *pos_jc, int *pos_jk, int *pos_jb, int *pos_jn);
#endif

double comin_descrdata_get_timesteplength(int jg);
void comin_descrdata_get_simulation_interval_exp_start(char const **val, int *len);
int comin_descrdata_get_global_n_dom(void);
int comin_descrdata_get_global_nproma(void);
void comin_descrdata_get_global_vct_a(TABLE double **vct_a, int *arr_size);
int comin_descrdata_get_domain_nlev(int jg);
int comin_descrdata_get_domain_nshift_total(int jg);
int comin_descrdata_get_domain_cells_ncells(int jg);
int comin_descrdata_get_domain_cells_ncells_global(int jg);
int comin_descrdata_get_domain_verts_nverts(int jg);
void comin_descrdata_get_domain_cells_vertex_idx(int jg, TABLE int **vertex_idx, int *arr_size);
void comin_descrdata_get_domain_cells_vertex_blk(int jg, TABLE int **vertex_blk, int *arr_size);
void comin_descrdata_get_domain_cells_glb_index(int jg, TABLE int **glb_index, int *arr_size);
void comin_descrdata_get_domain_cells_decomp_domain(int jg, TABLE int **decomp_domain, int *arr_size);
void comin_descrdata_get_domain_cells_clon(int jg, TABLE double **clon, int *arr_size);
void comin_descrdata_get_domain_cells_clat(int jg, TABLE double **clat, int *arr_size);
void comin_descrdata_get_domain_cells_hhl(int jg, TABLE double **hhl, int *arr_size);
void comin_descrdata_get_domain_verts_vlon(int jg, TABLE double **vlon, int *arr_size);
void comin_descrdata_get_domain_verts_vlat(int jg, TABLE double **vlat, int *arr_size);

#endif
