#define _POSIX_C_SOURCE 200809L
#include "catalyst.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 16, EMPTY = 0, OBJECT = 1, LIST = 2, INT64 = 6, FLOAT32 = 11, FLOAT64 = 12, CHAR8_STR = 13 };

struct conduit_node {
    char name[40];
    int type, children;
    conduit_node *child[MOST];
    char *own; /* what the node has allocated */
    char *data;
    conduit_index_t count, stride;
};

/* Where Conduit throws an error. */
static void *thrown(const char *what)
{
    fprintf(stderr, "conduit: %s\n", what);
    abort();
}

conduit_node *conduit_node_create(void)
{
    conduit_node *node = calloc(1, sizeof *node);
    return node != NULL ? node : thrown("no memory");
}

void conduit_node_destroy(conduit_node *node)
{
    for (int i = 0; i < node->children; i++) {
        conduit_node_destroy(node->child[i]);
    }
    free(node->own);
    free(node);
}

static conduit_node *find(conduit_node *node, const char *path, int may_make)
{
    while (*path != 0) {
        size_t length = strcspn(path, "/");
        conduit_node *next = NULL;
        for (int i = 0; i < node->children && node->type == OBJECT; i++) {
            int is_it = strlen(node->child[i]->name) == length && strncmp(node->child[i]->name, path, length) == 0;
            next = is_it ? node->child[i] : next;
        }
        if (next == NULL) {
            if (!may_make) {
                return NULL;
            }
            if (node->children == MOST || length >= sizeof node->name) {
                thrown("too many children for the double");
            }
            next = conduit_node_create();
            memcpy(next->name, path, length);
            node->type = OBJECT;
            node->child[node->children++] = next;
        }
        node = next;
        path += length + (path[length] == '/');
    }
    return node;
}

conduit_node *conduit_node_append(conduit_node *node)
{
    if (node->children == MOST) {
        thrown("too many children for the double");
    }
    node->type = LIST;
    return node->child[node->children++] = conduit_node_create();
}

conduit_node *conduit_node_fetch(conduit_node *node, const char *path)
{
    return find(node, path, 1);
}

int conduit_node_has_path(const conduit_node *node, const char *path)
{
    return find((conduit_node *)node, path, 0) != NULL;
}

conduit_node *conduit_node_fetch_existing(conduit_node *node, const char *path)
{
    conduit_node *found = find(node, path, 0);
    return found != NULL ? found : thrown("no such path");
}

conduit_index_t conduit_node_number_of_children(conduit_node *node)
{
    return node->children;
}

conduit_node *conduit_node_child(conduit_node *node, conduit_index_t i)
{
    return i >= 0 && i < node->children ? node->child[i] : thrown("no such child");
}

char *conduit_node_name(const conduit_node *node)
{
    return strdup(node->name);
}

const conduit_datatype *conduit_node_dtype(const conduit_node *node)
{
    return node;
}

void *conduit_node_element_ptr(conduit_node *node, conduit_index_t i)
{
    return node->data + i * node->stride;
}

char *conduit_node_as_char8_str(conduit_node *node)
{
    return node->type == CHAR8_STR ? node->data : thrown("no string");
}

static void set(conduit_node *node, const char *path, int type, void *data, conduit_index_t count, conduit_index_t stride)
{
    conduit_node *to = find(node, path, 1);
    free(to->own);
    to->own = NULL;
    to->type = type;
    to->data = data;
    to->count = count;
    to->stride = stride;
}

static void set_copy(conduit_node *node, const char *path, int type, const void *data, conduit_index_t count, size_t bytes)
{
    char *own = malloc((size_t)count * bytes);
    memcpy(own, data, (size_t)count * bytes);
    set(node, path, type, own, count, (conduit_index_t)bytes);
    find(node, path, 0)->own = own;
}

void conduit_node_set_path_char8_str(conduit_node *node, const char *path, const char *text)
{
    set_copy(node, path, CHAR8_STR, text, (conduit_index_t)strlen(text) + 1, 1);
}

void conduit_node_set_path_int64(conduit_node *node, const char *path, int64_t value)
{
    set_copy(node, path, INT64, &value, 1, sizeof value);
}

void conduit_node_set_path_float64(conduit_node *node, const char *path, double value)
{
    set_copy(node, path, FLOAT64, &value, 1, sizeof value);
}

void conduit_node_set_path_external_int64_ptr(conduit_node *node, const char *path, int64_t *data, conduit_index_t count)
{
    set(node, path, INT64, data, count, sizeof *data);
}

void conduit_node_set_path_external_float32_ptr_detailed(conduit_node *node, const char *path, float *data,
                                                         conduit_index_t count, conduit_index_t offset,
                                                         conduit_index_t stride, conduit_index_t element_bytes,
                                                         conduit_index_t endianness)
{
    (void)element_bytes, (void)endianness;
    set(node, path, FLOAT32, (char *)data + offset, count, stride);
}

void conduit_node_set_path_external_float64_ptr_detailed(conduit_node *node, const char *path, double *data,
                                                         conduit_index_t count, conduit_index_t offset,
                                                         conduit_index_t stride, conduit_index_t element_bytes,
                                                         conduit_index_t endianness)
{
    (void)element_bytes, (void)endianness;
    set(node, path, FLOAT64, (char *)data + offset, count, stride);
}

char *conduit_node_fetch_path_as_char8_str(conduit_node *node, const char *path)
{
    return conduit_node_as_char8_str(conduit_node_fetch_existing(node, path));
}

int64_t conduit_node_fetch_path_as_int64(conduit_node *node, const char *path)
{
    return *(int64_t *)(void *)conduit_node_fetch_existing(node, path)->data;
}

conduit_index_t conduit_datatype_id(const conduit_datatype *type)
{
    return type->type;
}

conduit_index_t conduit_datatype_number_of_elements(const conduit_datatype *type)
{
    return type->count;
}

conduit_index_t conduit_datatype_stride(const conduit_datatype *type)
{
    return type->stride;
}

int conduit_datatype_endianness_matches_machine(const conduit_datatype *type)
{
    return type != NULL;
}

/* Catalyst's struct of an implementation. */
static const struct {
    int version;
    enum catalyst_status (*initialize)(const conduit_node *);
    enum catalyst_status (*execute)(const conduit_node *);
    enum catalyst_status (*finalize)(const conduit_node *);
    enum catalyst_status (*about)(conduit_node *);
    enum catalyst_status (*results)(conduit_node *);
} *loaded;

enum catalyst_status catalyst_initialize(const conduit_node *params)
{
    const char *name = getenv("CATALYST_IMPLEMENTATION_NAME"), *directory = getenv("CATALYST_IMPLEMENTATION_PATHS");
    char path[1024];
    snprintf(path, sizeof path, "%s/libcatalyst-%s.so", directory, name);
    void *library = dlopen(path, RTLD_LAZY | RTLD_GLOBAL);
    if (library == NULL) {
        fprintf(stderr, "%s\n", dlerror());
        return catalyst_status_not_found;
    }
    loaded = dlsym(library, "catalyst_api_impl");
    int is_whole = loaded != NULL && loaded->version == 1 && loaded->initialize && loaded->execute && loaded->finalize &&
                   loaded->about && loaded->results;
    return is_whole ? loaded->initialize(params) : catalyst_status_incomplete;
}

enum catalyst_status catalyst_execute(const conduit_node *params)
{
    return loaded->execute(params);
}

enum catalyst_status catalyst_finalize(const conduit_node *params)
{
    return loaded->finalize(params);
}

enum catalyst_status catalyst_about(conduit_node *params)
{
    return loaded->about(params);
}

enum catalyst_status catalyst_results(conduit_node *params)
{
    return loaded->results(params);
}

/* Where libcatalyst writes the arguments of a call. */
static enum catalyst_status dump(const char *call, const conduit_node *params)
{
    const char *directory = getenv("CATALYST_DATA_DUMP_DIRECTORY"), *rank = getenv("OMPI_COMM_WORLD_RANK");
    char path[1024];
    snprintf(path, sizeof path, "%s/%s_params.%s", directory, call, rank != NULL ? rank : "0");
    FILE *file = params != NULL ? fopen(path, "a") : NULL;
    if (file == NULL) {
        thrown("failed to open a file");
    }
    fclose(file);
    return catalyst_status_ok;
}

enum catalyst_status catalyst_stub_initialize(const conduit_node *params)
{
    return dump("initialize", params);
}

enum catalyst_status catalyst_stub_execute(const conduit_node *params)
{
    return dump("execute", params);
}

enum catalyst_status catalyst_stub_finalize(const conduit_node *params)
{
    return dump("finalize", params);
}
