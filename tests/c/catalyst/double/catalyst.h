/* A double of libcatalyst, as much of it as the host here calls and an implementation of Catalyst reads. With
 * EXTERNAL_CONDUIT the functions of Conduit have the names of Conduit's own library, with OTHER_CONDUIT one has another. */
#ifndef CATALYST_DOUBLE_H
#define CATALYST_DOUBLE_H

#include <stdint.h>

#ifdef EXTERNAL_CONDUIT
#define NAME(name) conduit_##name
#else
#define NAME(name) catalyst_conduit_##name
#endif
#define conduit_node_create NAME(node_create)
#define conduit_node_destroy NAME(node_destroy)
#define conduit_node_append NAME(node_append)
#define conduit_node_fetch NAME(node_fetch)
#define conduit_node_has_path NAME(node_has_path)
#define conduit_node_fetch_existing NAME(node_fetch_existing)
#define conduit_node_number_of_children NAME(node_number_of_children)
#define conduit_node_child NAME(node_child)
#define conduit_node_name NAME(node_name)
#define conduit_node_dtype NAME(node_dtype)
#define conduit_node_element_ptr NAME(node_element_ptr)
#define conduit_node_as_char8_str NAME(node_as_char8_str)
#define conduit_node_set_path_char8_str NAME(node_set_path_char8_str)
#define conduit_node_set_path_int64 NAME(node_set_path_int64)
#define conduit_node_set_path_float64 NAME(node_set_path_float64)
#define conduit_node_set_path_external_int64_ptr NAME(node_set_path_external_int64_ptr)
#define conduit_node_set_path_external_float32_ptr_detailed NAME(node_set_path_external_float32_ptr_detailed)
#define conduit_node_set_path_external_float64_ptr_detailed NAME(node_set_path_external_float64_ptr_detailed)
#define conduit_node_fetch_path_as_char8_str NAME(node_fetch_path_as_char8_str)
#define conduit_node_fetch_path_as_int64 NAME(node_fetch_path_as_int64)
#define conduit_datatype_id NAME(datatype_id)
#define conduit_datatype_number_of_elements NAME(datatype_number_of_elements)
#ifdef OTHER_CONDUIT
#define conduit_datatype_stride NAME(datatype_distance)
#else
#define conduit_datatype_stride NAME(datatype_stride)
#endif
#define conduit_datatype_endianness_matches_machine NAME(datatype_endianness_matches_machine)

typedef struct conduit_node conduit_node;
typedef struct conduit_node conduit_datatype;
typedef int64_t conduit_index_t;

conduit_node *conduit_node_create(void);
void conduit_node_destroy(conduit_node *node);
conduit_node *conduit_node_append(conduit_node *node);
conduit_node *conduit_node_fetch(conduit_node *node, const char *path);
int conduit_node_has_path(const conduit_node *node, const char *path);
conduit_node *conduit_node_fetch_existing(conduit_node *node, const char *path);
conduit_index_t conduit_node_number_of_children(conduit_node *node);
conduit_node *conduit_node_child(conduit_node *node, conduit_index_t i);
char *conduit_node_name(const conduit_node *node);
const conduit_datatype *conduit_node_dtype(const conduit_node *node);
void *conduit_node_element_ptr(conduit_node *node, conduit_index_t i);
char *conduit_node_as_char8_str(conduit_node *node);
void conduit_node_set_path_char8_str(conduit_node *node, const char *path, const char *text);
void conduit_node_set_path_int64(conduit_node *node, const char *path, int64_t value);
void conduit_node_set_path_float64(conduit_node *node, const char *path, double value);
void conduit_node_set_path_external_int64_ptr(conduit_node *node, const char *path, int64_t *data, conduit_index_t count);
void conduit_node_set_path_external_float32_ptr_detailed(conduit_node *node, const char *path, float *data,
                                                         conduit_index_t count, conduit_index_t offset,
                                                         conduit_index_t stride, conduit_index_t element_bytes,
                                                         conduit_index_t endianness);
void conduit_node_set_path_external_float64_ptr_detailed(conduit_node *node, const char *path, double *data,
                                                         conduit_index_t count, conduit_index_t offset,
                                                         conduit_index_t stride, conduit_index_t element_bytes,
                                                         conduit_index_t endianness);
char *conduit_node_fetch_path_as_char8_str(conduit_node *node, const char *path);
int64_t conduit_node_fetch_path_as_int64(conduit_node *node, const char *path);
conduit_index_t conduit_datatype_id(const conduit_datatype *type);
conduit_index_t conduit_datatype_number_of_elements(const conduit_datatype *type);
conduit_index_t conduit_datatype_stride(const conduit_datatype *type);
int conduit_datatype_endianness_matches_machine(const conduit_datatype *type);

enum catalyst_status { catalyst_status_ok = 0, catalyst_status_not_found = 3, catalyst_status_incomplete = 5 };

enum catalyst_status catalyst_initialize(const conduit_node *params);
enum catalyst_status catalyst_execute(const conduit_node *params);
enum catalyst_status catalyst_finalize(const conduit_node *params);
enum catalyst_status catalyst_about(conduit_node *params);
enum catalyst_status catalyst_results(conduit_node *params);

enum catalyst_status catalyst_stub_initialize(const conduit_node *params);
enum catalyst_status catalyst_stub_execute(const conduit_node *params);
enum catalyst_status catalyst_stub_finalize(const conduit_node *params);

#endif
