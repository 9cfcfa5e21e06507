/* A host that was built against libcatalyst: host SCENE wedges|prisms|hexes|points flat|hills STEPS
 * ORDER [FAULT].
 *
 * It gives its mesh anew at each step, in memory that it frees after the step. ORDER of points and elements: "column"
 * (level-fastest), "level" (column-fastest), "top" (level-fastest, from the outermost), "shuffled"; "float" and "strided"
 * are of columns, in 32 bits and with gaps. */
/* FAULT "moving": hills at odd steps; "renumbered": in order of levels at odd steps; "empty", "no data" and "mesh state":
 * rank 1 has all elements, the others give arrays of none, an empty node, or no channel while step and time are in the
 * mesh alone; others are at their places. */
#include "ball.h"

#include <catalyst.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef HOST_MPI
#include <mpi.h>
#endif

/* The part of this rank. */
typedef struct {
    const ball *whole;
    int columns, polygons;
    int *column, *polygon; /* their numbers in the whole mesh */
    int *local;            /* the column of a whole mesh's column */
    const char *order;
    int stretch, is_float;
} part;

static int64_t shuffled(int64_t i, int64_t count)
{
    /* A step that has no divisor in common with the count. */
    int64_t step = 7919;
    while (count % step == 0) {
        step += 2;
    }
    return (i * (step % count) + 5) % count;
}

static int64_t place(const part *of, int column, int level, int columns, int levels)
{
    if (strcmp(of->order, "level") == 0) {
        return (int64_t)level * columns + column;
    }
    if (strcmp(of->order, "top") == 0) {
        return (int64_t)column * levels + levels - 1 - level;
    }
    int64_t i = (int64_t)column * levels + level;
    return strcmp(of->order, "shuffled") == 0 ? shuffled(i, (int64_t)columns * levels) : i;
}

static part part_of(const ball *whole, int rank, int ranks, const char *order)
{
    part to = {whole, 0, 0, NULL, NULL, NULL, order, 1, 0};
    to.column = malloc((size_t)whole->columns * sizeof(int));
    to.polygon = malloc((size_t)whole->polygons * sizeof(int));
    to.local = malloc((size_t)whole->columns * sizeof(int));
    to.stretch = strcmp(order, "strided") == 0 ? 3 : 1;
    to.is_float = strcmp(order, "float") == 0;
    for (int i = 0; i < whole->columns; i++) {
        to.local[i] = -1;
    }
    for (int i = 0; i < whole->polygons; i++) {
        if (ball_owner(whole, i, ranks) != rank) {
            continue;
        }
        to.polygon[to.polygons++] = i;
        for (int k = 0; k < whole->sides[i]; k++) {
            int node = whole->polygon[6 * i + k];
            if (to.local[node] < 0) {
                to.local[node] = to.columns;
                to.column[to.columns++] = node;
            }
        }
    }
    return to;
}

/* Gives an array of reals, of which every `stretch`-th is a value. */
static void give(conduit_node *to, const part *of, const char *path, double *values, int64_t count)
{
    conduit_index_t stride = of->stretch * (conduit_index_t)(of->is_float ? sizeof(float) : sizeof(double));
    if (of->is_float) {
        float *small = (float *)(void *)values;
        for (int64_t i = 0; i < count * of->stretch; i++) {
            float value = (float)values[i];
            memcpy(small + i, &value, sizeof value);
        }
        conduit_node_set_path_external_float32_ptr_detailed(to, path, small, count, 0, stride, sizeof(float), 0);
    } else {
        conduit_node_set_path_external_float64_ptr_detailed(to, path, values, count, 0, stride, sizeof(double), 0);
    }
}

static double *array(const part *of, int64_t count, void **memory, int *used)
{
    double *values = malloc((size_t)(count + 1) * (size_t)of->stretch * sizeof(double));
    for (int64_t i = 0; i < count * of->stretch; i++) {
        values[i] = NAN;
    }
    memory[(*used)++] = values;
    return values;
}

#define MESH "catalyst/channels/grid/data/"

static void give_points(conduit_node *to, const part *of, int has_hills, int is_bad, void **memory, int *used)
{
    const char *paths[] = {MESH "coordsets/coords/values/x", MESH "coordsets/coords/values/y", MESH "coordsets/coords/values/z"};
    int64_t count = (int64_t)of->columns * LEVELS;
    conduit_node_set_path_char8_str(to, MESH "coordsets/coords/type", "explicit");
    for (int axis = 0; axis < 3; axis++) {
        double *values = array(of, count, memory, used);
        for (int64_t i = 0; i < count; i++) {
            int column = (int)(i / LEVELS), level = (int)(i % LEVELS), whole = of->column[column];
            double radius = ball_radius(of->whole, whole, level, has_hills);
            values[place(of, column, level, of->columns, LEVELS) * of->stretch] = radius * of->whole->x[3 * whole + axis];
        }
        if (is_bad) {
            values[0] = NAN;
        }
        give(to, of, paths[axis], values, count);
    }
}

static int64_t *numbers(conduit_node *to, const char *path, int64_t count, void **memory, int *used)
{
    int64_t *table = malloc((size_t)(count + 1) * sizeof *table);
    memory[(*used)++] = table;
    conduit_node_set_path_external_int64_ptr(to, path, table, count);
    return table;
}

/* The places of a hexahedron's points, where its vertical edges are those of another axis. */
static const int TURNED[8] = {0, 4, 5, 1, 3, 7, 6, 2};

/* Elements of as many points each: wedges, hexahedra, triangles, quadrilaterals or points. */
static void give_uniform(conduit_node *to, const part *of, void **memory, int *used)
{
    static const char *const names[2][5] = {{"", "point", "", "tri", "quad"}, {"", "point", "", "wedge", "hex"}};
    int layers = of->whole->layers, sides = of->whole->sides[0], size = (layers < LEVELS ? 2 : 1) * sides;
    int64_t count = (int64_t)of->polygons * layers;
    int64_t *table = numbers(to, MESH "topologies/mesh/elements/connectivity", size * count, memory, used);
    conduit_node_set_path_char8_str(to, MESH "topologies/mesh/elements/shape", names[size > sides][sides]);
    if (count == 0) {
        /* Arrays of nothing may be of any type. */
        give(to, of, MESH "topologies/mesh/elements/connectivity", array(of, 0, memory, used), 0);
    }
    for (int64_t i = 0; i < count; i++) {
        int polygon = (int)(i / layers), layer = (int)(i % layers);
        int64_t element = place(of, polygon, layer, of->polygons, layers);
        for (int k = 0; k < size; k++) {
            /* Some elements are upside down, and begin with another point; others stand on another side. */
            int turn = of->order[0] == 's' && element % 3 == 1, corner = (k + (turn ? 2 : 0)) % sides;
            int column = of->local[of->whole->polygon[6 * of->polygon[polygon] + corner]];
            int level = layer + (size > sides && (k < sides) == turn);
            int at = size == 8 && of->order[0] == 's' && element % 3 == 2 ? TURNED[k] : k;
            table[size * element + at] = place(of, column, level, of->columns, LEVELS);
        }
    }
}

static void give_prisms(conduit_node *to, const part *of, void **memory, int *used)
{
    int64_t elements = (int64_t)of->polygons * of->whole->layers, caps = (int64_t)of->polygons * LEVELS, sides = 0;
    for (int i = 0; i < of->polygons; i++) {
        sides += of->whole->sides[of->polygon[i]];
    }
    int64_t faces = caps + sides * of->whole->layers, side = caps, at = 0, face_at = 0;
    conduit_node_set_path_char8_str(to, MESH "topologies/mesh/elements/shape", "polyhedral");
    conduit_node_set_path_char8_str(to, MESH "topologies/mesh/subelements/shape", "polygonal");
    int64_t *connectivity = numbers(to, MESH "topologies/mesh/elements/connectivity", 2 * elements + sides * of->whole->layers, memory, used);
    int64_t *sizes = numbers(to, MESH "topologies/mesh/elements/sizes", elements, memory, used);
    int64_t *offsets = numbers(to, MESH "topologies/mesh/elements/offsets", elements, memory, used);
    int64_t *points = numbers(to, MESH "topologies/mesh/subelements/connectivity", sides * LEVELS + 4 * sides * of->whole->layers, memory, used);
    int64_t *face_sizes = numbers(to, MESH "topologies/mesh/subelements/sizes", faces, memory, used);
    for (int64_t cap = 0; cap < caps; cap++) {
        int polygon = of->polygon[cap / LEVELS];
        face_sizes[cap] = of->whole->sides[polygon];
        for (int k = 0; k < of->whole->sides[polygon]; k++) {
            int column = of->local[of->whole->polygon[6 * polygon + k]];
            points[face_at++] = place(of, column, (int)(cap % LEVELS), of->columns, LEVELS);
        }
    }
    int64_t *element_of = malloc((size_t)(elements + 1) * sizeof *element_of);
    for (int64_t i = 0; i < elements; i++) {
        element_of[place(of, (int)(i / of->whole->layers), (int)(i % of->whole->layers), of->polygons, of->whole->layers)] = i;
    }
    for (int64_t element = 0; element < elements; element++) {
        int local = (int)(element_of[element] / of->whole->layers), layer = (int)(element_of[element] % of->whole->layers);
        int polygon = of->polygon[local], count = of->whole->sides[polygon];
        offsets[element] = at;
        sizes[element] = 2 + count;
        connectivity[at++] = (int64_t)local * LEVELS + layer + 1;
        for (int k = 0; k < count; k++) {
            int a = of->local[of->whole->polygon[6 * polygon + k]];
            int b = of->local[of->whole->polygon[6 * polygon + (k + 1) % count]];
            face_sizes[side] = 4;
            connectivity[at++] = side++;
            points[face_at++] = place(of, a, layer, of->columns, LEVELS);
            points[face_at++] = place(of, b, layer, of->columns, LEVELS);
            points[face_at++] = place(of, b, layer + 1, of->columns, LEVELS);
            points[face_at++] = place(of, a, layer + 1, of->columns, LEVELS);
        }
        connectivity[at++] = (int64_t)local * LEVELS + layer;
    }
    free(element_of);
}

static void give_field(conduit_node *to, const part *of, const char *name, int is_at_points, int step, void **memory, int *used)
{
    char path[96];
    int columns = is_at_points ? of->columns : of->polygons, levels = is_at_points ? LEVELS : of->whole->layers;
    int64_t count = (int64_t)columns * levels;
    double *values = array(of, count, memory, used);
    for (int64_t i = 0; i < count; i++) {
        int column = (int)(i / levels), level = (int)(i % levels);
        double value = is_at_points ? ball_at_point(of->whole, of->column[column], level, step)
                                    : ball_at_element(of->whole, of->polygon[column], level, step);
        values[place(of, column, level, columns, levels) * of->stretch] = value;
    }
    sprintf(path, MESH "fields/%s/association", name);
    conduit_node_set_path_char8_str(to, path, is_at_points ? "vertex" : "element");
    sprintf(path, MESH "fields/%s/topology", name);
    conduit_node_set_path_char8_str(to, path, "mesh");
    sprintf(path, MESH "fields/%s/values", name);
    give(to, of, path, values, count);
}

static void give_mesh(conduit_node *to, const part *of, int has_hills, int is_bad, void **memory, int *used)
{
    give_points(to, of, has_hills, is_bad, memory, used);
    int is_implicit = of->whole->shape == POINTS && of->order[0] != 's';
    conduit_node_set_path_char8_str(to, MESH "topologies/mesh/type", is_implicit ? "points" : "unstructured");
    conduit_node_set_path_char8_str(to, MESH "topologies/mesh/coordset", "coords");
    if (!is_implicit) {
        (of->whole->shape == PRISMS ? give_prisms : give_uniform)(to, of, memory, used);
    }
}

#define IS(name) (strcmp(fault, name) == 0)

static void give_fields(conduit_node *to, const part *of, int step, int is_rank, const char *fault, void **memory, int *used)
{
    give_field(to, of, "theta", 1, step, memory, used);
    if (!IS("field") || !is_rank || step == 0) {
        give_field(to, of, "q", 0, step, memory, used);
    }
    if (IS("length") && is_rank) {
        numbers(to, MESH "fields/q/values", 7, memory, used);
    }
    if (IS("ghosts")) {
        give_field(to, of, "vtkGhostType", 0, step, memory, used);
    }
    if (IS("count")) {
        /* Integers, which no scene has asked for. */
        give_field(to, of, "count", 0, step, memory, used);
        numbers(to, MESH "fields/count/values", (int64_t)of->polygons * of->whole->layers, memory, used);
    }
    if (IS("two")) {
        static double nothing[1];
        conduit_node_set_path_char8_str(to, "catalyst/channels/other/data/topologies/mesh/type", "points");
        conduit_node_set_path_char8_str(to, "catalyst/channels/other/data/fields/theta/association", "vertex");
        conduit_node_set_path_char8_str(to, "catalyst/channels/other/data/fields/theta/topology", "mesh");
        conduit_node_set_path_external_float64_ptr_detailed(
            to, "catalyst/channels/other/data/fields/theta/values", nothing, 1, 0, sizeof(double), sizeof(double), 0);
    }
}

static void give_step(conduit_node *params, const part *of, int has_hills, int step, int is_rank, const char *fault,
                      void **memory, int *used)
{
    if (IS("mesh state") && of->polygons == 0) {
        return;
    }
    if (IS("mesh state")) {
        conduit_node_set_path_int64(params, MESH "state/cycle", step);
        conduit_node_set_path_float64(params, MESH "state/time", 0.5 * step);
    } else {
        conduit_node_set_path_int64(params, "catalyst/state/timestep", step);
        conduit_node_set_path_float64(params, "catalyst/state/time", 0.5 * step);
    }
    conduit_node_set_path_char8_str(params, "catalyst/channels/grid/type", IS("type") ? "multimesh" : "mesh");
    if (IS("no data") && of->polygons == 0) {
        conduit_node_fetch(params, "catalyst/channels/grid/data");
        return;
    }
    give_mesh(params, of, has_hills, IS("rank") && is_rank, memory, used);
    if (IS("shape")) {
        conduit_node_set_path_char8_str(params, MESH "topologies/mesh/elements/shape", "tet");
    }
    give_fields(params, of, step, is_rank, fault, memory, used);
}

static void say(const char *call, enum catalyst_status status)
{
    if (status != catalyst_status_ok) {
        printf("%s returned %d\n", call, (int)status);
    }
}

int main(int argc, char **argv)
{
    int rank = 0, ranks = 1;
    if (argc < 6) {
        return 2;
    }
    const char *fault = argc > 6 ? argv[6] : "";
    int has_hills = strncmp(argv[3], "hills", 5) == 0;
    conduit_node *params = conduit_node_create();
#ifdef HOST_MPI
    MPI_Init(&argc, &argv);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    conduit_node_set_path_int64(params, "catalyst/mpi_comm", MPI_Comm_c2f(MPI_COMM_WORLD));
#endif
    ball whole = ball_make(argv[2]);
    part of = part_of(&whole, rank, ranks, argv[5]);
    int is_on_one = IS("empty") || IS("no data") || IS("mesh state");
    if (is_on_one && ranks > 1) {
        /* Rank 1 has all, the others none. */
        of = part_of(&whole, rank == 1 ? 0 : 1, 1, argv[5]);
    }
    if (IS("list")) {
        conduit_node *scripts = conduit_node_fetch(params, "catalyst/scripts");
        conduit_node_set_path_char8_str(conduit_node_append(scripts), "filename", "pipeline.py");
        conduit_node_set_path_char8_str(conduit_node_append(scripts), "filename", argv[1]);
    } else {
        conduit_node_set_path_char8_str(params, "catalyst/scripts/paraview", "pipeline.py");
    }
    if (!IS("list") && !IS("no scene")) {
        conduit_node_set_path_char8_str(params, "catalyst/scripts/icoray/filename", argv[1]);
    }
    if (!IS("no radius")) {
        conduit_node_set_path_float64(params, "catalyst/icoray/planet_radius", 6.371229e6);
    }
    say("catalyst_initialize", catalyst_initialize(params));
    conduit_node_destroy(params);
    /* Before there is a picture. */
    params = conduit_node_create();
    say("catalyst_results", catalyst_results(params));
    conduit_node_destroy(params);
    for (int step = 0; step < atoi(argv[4]); step++) {
        void *memory[32];
        int used = 0, is_rank = rank == ranks - 1;
        params = conduit_node_create();
        of.order = IS("renumbered") && step % 2 == 1 ? "level" : argv[5];
        give_step(params, &of, IS("moving") ? step % 2 : has_hills, step, is_rank, fault, memory, &used);
        say("catalyst_execute", catalyst_execute(IS("null") && is_rank && step > 0 ? NULL : params));
        conduit_node_destroy(params);
        while (used > 0) {
            free(memory[--used]);
        }
    }
    params = conduit_node_create();
    say("catalyst_about", catalyst_about(params));
    if (rank == 0 && conduit_node_has_path(params, "catalyst/implementation")) {
        printf("implementation %s\n", conduit_node_fetch_path_as_char8_str(params, "catalyst/implementation"));
    }
    say("catalyst_results", catalyst_results(params));
    if (rank == 0 && conduit_node_has_path(params, "icoray/bytes_copied")) {
        printf("%d bytes copied\n", (int)conduit_node_fetch_path_as_int64(params, "icoray/bytes_copied"));
    }
    say("catalyst_finalize", catalyst_finalize(params));
    conduit_node_destroy(params);
#ifdef HOST_MPI
    MPI_Finalize();
#endif
    printf("the host ended well\n");
    return 0;
}
