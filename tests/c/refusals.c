/*
 * Everything that the ABI refuses, with the status and the words it has for it: refusals <directory>
 *
 * After each group of refused calls the context draws: what was set before is still there.
 */
#include "check.h"

#include <limits.h>
#include <math.h>
#include <stddef.h>

/* The numbers are part of the ABI: a program that was compiled before must understand them. */
#define FIXED(name, number) typedef char fixed_##name[(name) == (number) ? 1 : -1]
FIXED(ICORAY_OK, 0);
FIXED(ICORAY_ERR_NULL, 1);
FIXED(ICORAY_ERR_STRUCT_SIZE, 2);
FIXED(ICORAY_ERR_ARGUMENT, 3);
FIXED(ICORAY_ERR_GRID, 4);
FIXED(ICORAY_ERR_UNSUPPORTED, 5);
FIXED(ICORAY_ERR_LAYERS, 6);
FIXED(ICORAY_ERR_FIELD, 7);
FIXED(ICORAY_ERR_SCENE, 8);
FIXED(ICORAY_ERR_ORDER, 9);
FIXED(ICORAY_ERR_IO, 10);
FIXED(ICORAY_ERR_INTERNAL, 11);
FIXED(ICORAY_F32, 1);
FIXED(ICORAY_F64, 2);
FIXED(ICORAY_CENTER, 0);
FIXED(ICORAY_CORNER, 1);

#define COUNT(table) (sizeof(table) / sizeof(table)[0])
#define NO_UTF8 "caf\xe9"
#define LEVEL 1
#define LAYERS 3
#define DEEP 100000

static icoray_mesh *mesh;
static icoray_grid good_grid;
static icoray_layers good_layers;
static icoray_array good_array;
static icoray_config good_config;
static const double radius[LAYERS] = {6.4e6, 6.5e6, 6.7e6};
static float *values;
static const char *directory;

#define SCENE(field, distance, file)                                                                \
    "field = \"" field "\"\n"                                                                       \
    "[image]\nwidth = 16\nheight = 16\n"                                                            \
    "[camera]\nlon = 10\nlat = 40\ndistance = " distance "\n"                                       \
    "[transfer]\nmap = \"viridis\"\nrange = [0, 2]\nopacity = [[0, 0.1], [2, 0.9]]\n"               \
    "[output]\nfile = \"" file "\"\n"

static const char good_scene[] = SCENE("f", "4", "{field}_{step}.png");

static char *path_of(char *buffer, size_t size, const char *name)
{
    snprintf(buffer, size, "%s/%s", directory, name);
    return buffer;
}

static int write_file(const char *path, const char *text)
{
    FILE *file = fopen(path, "wb");
    if (file == NULL) {
        return 0;
    }
    fputs(text, file);
    return fclose(file) == 0;
}

static int file_exists(const char *name)
{
    char path[1024];
    FILE *file = fopen(path_of(path, sizeof path, name), "rb");
    if (file != NULL) {
        fclose(file);
    }
    return file != NULL;
}

static void prepare(void)
{
    OK(icoray_mesh_create(LEVEL, &mesh));
    good_grid.struct_size = sizeof good_grid;
    OK(icoray_mesh_grid(mesh, &good_grid));
    good_layers.struct_size = sizeof good_layers;
    good_layers.count = LAYERS;
    good_layers.radius_m = radius;
    good_layers.planet_radius_m = 6.4e6;
    values = malloc((size_t)good_grid.cells * LAYERS * sizeof *values);
    if (values == NULL) {
        printf("out of memory\n");
        exit(EXIT_FAILURE);
    }
    for (int i = 0; i < (int)good_grid.cells * LAYERS; i++) {
        values[i] = 0.5f * (float)(i % 5);
    }
    good_array.struct_size = sizeof good_array;
    good_array.data = values;
    good_array.type = ICORAY_F32;
    good_array.location = ICORAY_CENTER;
    good_array.columns = good_grid.cells;
    good_array.layers = LAYERS;
    good_array.column_stride = LAYERS;
    good_array.layer_stride = 1;
    good_config.struct_size = sizeof good_config;
    good_config.output_dir = directory;
    good_config.threads = 1;
}

static icoray_ctx *opened(void)
{
    icoray_ctx *ctx = NULL;
    OK(icoray_open_serial(&good_config, &ctx));
    return ctx;
}

static icoray_ctx *filled(void)
{
    icoray_ctx *ctx = opened();
    OK(icoray_grid_set(ctx, &good_grid));
    OK(icoray_layers_set(ctx, &good_layers));
    OK(icoray_field_set(ctx, "f", &good_array));
    OK(icoray_scene_text(ctx, good_scene));
    return ctx;
}

/* The context draws what it drew before: always the same picture. */
static void still_draws(icoray_ctx *ctx)
{
    static uint64_t frusta;
    icoray_frame_report report;
    memset(&report, 0, sizeof report);
    report.struct_size = sizeof report;
    trying = "drawing after what was refused";
    OK(icoray_execute(ctx, 1, 0.0, NULL));
    OK(icoray_report(ctx, &report));
    CHECK(report.frusta > 0 && report.value_min == 0.0 && report.value_max == 2.0);
    CHECK(frusta == 0 || report.frusta == frusta);
    frusta = report.frusta;
    trying = "";
}

static void nulls(icoray_ctx *ctx)
{
    icoray_ctx *none = NULL;
    icoray_mesh *no_mesh = NULL;
    icoray_grid grid = good_grid;
    icoray_frame_report report;
    char buffer[4] = "abc";
    memset(&report, 0, sizeof report);
    report.struct_size = sizeof report;

    REFUSED(NULL, ICORAY_ERR_NULL, "ctx", icoray_open_serial(&good_config, NULL));
    REFUSED(NULL, ICORAY_ERR_NULL, "icoray_config", icoray_open_serial(NULL, &none));
    REFUSED(NULL, ICORAY_ERR_NULL, "ctx", icoray_grid_set(NULL, &good_grid));
    REFUSED(ctx, ICORAY_ERR_NULL, "icoray_grid", icoray_grid_set(ctx, NULL));
    REFUSED(NULL, ICORAY_ERR_NULL, "ctx", icoray_layers_set(NULL, &good_layers));
    REFUSED(ctx, ICORAY_ERR_NULL, "icoray_layers", icoray_layers_set(ctx, NULL));
    REFUSED(NULL, ICORAY_ERR_NULL, "ctx", icoray_field_set(NULL, "f", &good_array));
    REFUSED(ctx, ICORAY_ERR_NULL, "name", icoray_field_set(ctx, NULL, &good_array));
    REFUSED(ctx, ICORAY_ERR_NULL, "icoray_array", icoray_field_set(ctx, "f", NULL));
    REFUSED(NULL, ICORAY_ERR_NULL, "ctx", icoray_scene_load(NULL, "scene.toml"));
    REFUSED(ctx, ICORAY_ERR_NULL, "path", icoray_scene_load(ctx, NULL));
    REFUSED(NULL, ICORAY_ERR_NULL, "ctx", icoray_scene_text(NULL, good_scene));
    REFUSED(ctx, ICORAY_ERR_NULL, "toml", icoray_scene_text(ctx, NULL));
    REFUSED(NULL, ICORAY_ERR_NULL, "ctx", icoray_execute(NULL, 0, 0.0, NULL));
    REFUSED(NULL, ICORAY_ERR_NULL, "ctx", icoray_report(NULL, &report));
    REFUSED(ctx, ICORAY_ERR_NULL, "report", icoray_report(ctx, NULL));
    REFUSED(NULL, ICORAY_ERR_NULL, "ctx", icoray_close(NULL));
    REFUSED(NULL, ICORAY_ERR_NULL, "mesh", icoray_mesh_create(1, NULL));
    REFUSED(NULL, ICORAY_ERR_NULL, "mesh", icoray_mesh_grid(NULL, &grid));
    REFUSED(NULL, ICORAY_ERR_NULL, "grid", icoray_mesh_grid(mesh, NULL));
    REFUSED(NULL, ICORAY_ERR_NULL, "mesh", icoray_mesh_free(NULL));

    /* These give no message: it would take the place of the one that is asked for. */
    CHECK(icoray_last_error(ctx, NULL, 4) == ICORAY_ERR_NULL);
    CHECK(icoray_last_error(NULL, NULL, 0) == ICORAY_ERR_NULL);
    CHECK(icoray_last_error(ctx, buffer, 0) == ICORAY_ERR_ARGUMENT);
    CHECK(strcmp(buffer, "abc") == 0);

    /* Closing and freeing nothing is fine, so twice is fine. */
    OK(icoray_close(&none));
    OK(icoray_mesh_free(&no_mesh));
    OK(icoray_open_serial(&good_config, &none));
    OK(icoray_close(&none));
    CHECK(none == NULL);
    OK(icoray_close(&none));
    OK(icoray_mesh_create(0, &no_mesh));
    OK(icoray_mesh_free(&no_mesh));
    CHECK(no_mesh == NULL);
    OK(icoray_mesh_free(&no_mesh));
}

static void struct_sizes(icoray_ctx *ctx)
{
    static const struct {
        const char *name;
        size_t size;
    } structs[] = {
        {"icoray_config", sizeof(icoray_config)}, {"icoray_grid", sizeof(icoray_grid)},
        {"icoray_layers", sizeof(icoray_layers)}, {"icoray_array", sizeof(icoray_array)},
        {"icoray_frame_report", sizeof(icoray_frame_report)},
    };
    for (size_t i = 0; i < COUNT(structs); i++) {
        size_t sizes[] = {0, 1, structs[i].size - 1, structs[i].size + 1, structs[i].size + 8, SIZE_MAX};
        for (size_t k = 0; k < COUNT(sizes); k++) {
            icoray_config config = good_config;
            icoray_grid grid = good_grid, zeroed;
            icoray_layers layers = good_layers;
            icoray_array array = good_array;
            icoray_frame_report report;
            icoray_ctx *none = ctx;
            char words[64];
            memset(&report, 0, sizeof report);
            memset(&zeroed, 0, sizeof zeroed);
            config.struct_size = grid.struct_size = layers.struct_size = sizes[k];
            array.struct_size = report.struct_size = zeroed.struct_size = sizes[k];
            snprintf(words, sizeof words, "%s.struct_size: %lu, expected %lu", structs[i].name,
                     (unsigned long)sizes[k], (unsigned long)structs[i].size);
            trying = words;
            switch (i) {
            case 0:
                REFUSED(NULL, ICORAY_ERR_STRUCT_SIZE, words, icoray_open_serial(&config, &none));
                CHECK(none == NULL);
                break;
            case 1:
                REFUSED(ctx, ICORAY_ERR_STRUCT_SIZE, words, icoray_grid_set(ctx, &grid));
                REFUSED(NULL, ICORAY_ERR_STRUCT_SIZE, words, icoray_mesh_grid(mesh, &zeroed));
                CHECK(zeroed.struct_size == sizes[k] && zeroed.cells == 0 && zeroed.edge_corner == NULL);
                break;
            case 2:
                REFUSED(ctx, ICORAY_ERR_STRUCT_SIZE, words, icoray_layers_set(ctx, &layers));
                break;
            case 3:
                REFUSED(ctx, ICORAY_ERR_STRUCT_SIZE, words, icoray_field_set(ctx, "f", &array));
                break;
            default:
                REFUSED(ctx, ICORAY_ERR_STRUCT_SIZE, words, icoray_report(ctx, &report));
                CHECK(report.struct_size == sizes[k] && report.rays == 0);
            }
        }
    }
    trying = "";
}

static void openings(void)
{
    static const int32_t threads[] = {-1, INT32_MIN, 4097, INT32_MAX};
    static const int32_t levels[] = {-1, INT32_MIN, 13, INT32_MAX};
    icoray_config config = good_config;
    for (size_t i = 0; i < COUNT(threads); i++) {
        icoray_ctx *ctx = (icoray_ctx *)&config;
        config.threads = threads[i];
        REFUSED(NULL, ICORAY_ERR_ARGUMENT, "icoray_config.threads", icoray_open_serial(&config, &ctx));
        CHECK(ctx == NULL);
    }
    config = good_config;
    config.output_dir = NO_UTF8;
    icoray_ctx *ctx = (icoray_ctx *)&config;
    REFUSED(NULL, ICORAY_ERR_ARGUMENT, "icoray_config.output_dir", icoray_open_serial(&config, &ctx));
    CHECK(ctx == NULL);
    for (size_t i = 0; i < COUNT(levels); i++) {
        icoray_mesh *none = mesh;
        REFUSED(NULL, ICORAY_ERR_ARGUMENT, "level", icoray_mesh_create(levels[i], &none));
        CHECK(none == NULL);
    }
}

static void grids(icoray_ctx *ctx)
{
#define MEMBER(name) {"icoray_grid." #name, offsetof(icoray_grid, name)}
    static const struct {
        const char *name;
        size_t offset;
    } tables[] = {MEMBER(lon_center_rad), MEMBER(lat_center_rad), MEMBER(lon_corner_rad), MEMBER(lat_corner_rad),
                  MEMBER(cell_corner),    MEMBER(corner_cell),    MEMBER(corner_edge),    MEMBER(edge_corner)},
      counts[] = {MEMBER(cells), MEMBER(corners), MEMBER(edges), MEMBER(cell_corner_row)};
#undef MEMBER
    static const int64_t impossible[] = {-1, INT64_MIN, INT64_MAX, (int64_t)1 << 40};
    static const int64_t zero = 0;
    static const int32_t kinds[] = {0, 3, -1, INT32_MAX};
    static const int32_t bases[] = {-1, 2, INT32_MIN, INT32_MAX};
    const char *const no_table = NULL;
    icoray_grid grid;
    for (size_t i = 0; i < COUNT(tables); i++) {
        const char *aside;
        trying = tables[i].name;
        grid = good_grid;
        memcpy((char *)&grid + tables[i].offset, &no_table, sizeof no_table);
        REFUSED(ctx, ICORAY_ERR_NULL, tables[i].name, icoray_grid_set(ctx, &grid));
        memcpy(&aside, (const char *)&good_grid + tables[i].offset, sizeof aside);
        aside += 1;
        memcpy((char *)&grid + tables[i].offset, &aside, sizeof aside);
        REFUSED(ctx, ICORAY_ERR_ARGUMENT, tables[i].name, icoray_grid_set(ctx, &grid));
    }
    for (size_t i = 0; i < COUNT(counts); i++) {
        trying = counts[i].name;
        grid = good_grid;
        for (size_t k = 0; k < COUNT(impossible); k++) {
            memcpy((char *)&grid + counts[i].offset, &impossible[k], sizeof impossible[k]);
            REFUSED(ctx, ICORAY_ERR_ARGUMENT, counts[i].name, icoray_grid_set(ctx, &grid));
        }
        memcpy((char *)&grid + counts[i].offset, &zero, sizeof zero);
        REFUSED(ctx, ICORAY_ERR_GRID, "expected", icoray_grid_set(ctx, &grid));
    }
    trying = "";
    for (size_t i = 0; i < COUNT(kinds); i++) {
        grid = good_grid;
        grid.real_type = kinds[i];
        REFUSED(ctx, ICORAY_ERR_ARGUMENT, "ICORAY_F32", icoray_grid_set(ctx, &grid));
        grid = good_grid;
        grid.index_base = bases[i];
        REFUSED(ctx, ICORAY_ERR_ARGUMENT, "index_base", icoray_grid_set(ctx, &grid));
    }
    memset(&grid, 0, sizeof grid);
    grid.struct_size = sizeof grid;
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "icoray_grid", icoray_grid_set(ctx, &grid));
    /* Numbered from 0 and said to be from 1: cell 0 looks like a hole's mark. */
    grid = good_grid;
    grid.index_base = 1;
    REFUSED(ctx, ICORAY_ERR_UNSUPPORTED, "hole", icoray_grid_set(ctx, &grid));
}

static int32_t *copied(const int32_t *table, int64_t entries)
{
    int32_t *copy = malloc((size_t)entries * sizeof *copy);
    if (copy == NULL) {
        printf("out of memory\n");
        exit(EXIT_FAILURE);
    }
    if (table != NULL) {
        memcpy(copy, table, (size_t)entries * sizeof *copy);
    }
    return copy;
}

/* One wrong entry in one table. */
static void bad_tables(icoray_ctx *ctx)
{
    enum { CELL_CORNER, CELL_CORNER_COUNT, CORNER_CELL, CORNER_EDGE, EDGE_CORNER };
    icoray_grid grid = good_grid;
    int32_t cells = (int32_t)grid.cells, corners = (int32_t)grid.corners, edges = (int32_t)grid.edges;
    int32_t *table[5];
    struct {
        int table, entry;
        int32_t value;
        icoray_status status;
        const char *part;
    } cases[] = {
        {CORNER_CELL, 10, -1, ICORAY_ERR_UNSUPPORTED, "corner_cell row 3"},
        {CORNER_CELL, 10, cells, ICORAY_ERR_UNSUPPORTED, "hole"},
        {CORNER_CELL, 10, -2, ICORAY_ERR_GRID, "corner_cell row 3, column 1: -2"},
        {CORNER_CELL, 10, cells + 1, ICORAY_ERR_GRID, "corner_cell row 3, column 1: 43"},
        {CORNER_CELL, 10, INT32_MAX, ICORAY_ERR_GRID, "corner_cell row 3, column 1: 2147483647"},
        {CORNER_CELL, 10, INT32_MIN, ICORAY_ERR_GRID, "corner_cell row 3, column 1: -2147483648"},
        {CORNER_CELL, 1, good_grid.corner_cell[0], ICORAY_ERR_GRID, "three different cells"},
        {CORNER_CELL, 10, (good_grid.corner_cell[10] + 20) % cells, ICORAY_ERR_GRID, "corner_cell row"},
        {CORNER_EDGE, 7, edges, ICORAY_ERR_GRID, "corner_edge row 2, column 1: 120"},
        {CORNER_EDGE, 7, -1, ICORAY_ERR_GRID, "corner_edge row 2, column 1: -1"},
        {CORNER_EDGE, 7, good_grid.corner_edge[6], ICORAY_ERR_GRID, "corner_edge row 2"},
        {CORNER_EDGE, 7, (good_grid.corner_edge[7] + 60) % edges, ICORAY_ERR_GRID, "corner_edge row 2"},
        {EDGE_CORNER, 5, corners, ICORAY_ERR_GRID, "edge_corner row 2, column 1: 80"},
        {EDGE_CORNER, 5, INT32_MIN, ICORAY_ERR_GRID, "edge_corner row 2, column 1"},
        {EDGE_CORNER, 5, good_grid.edge_corner[4], ICORAY_ERR_GRID, "edge_corner row 2"},
        {CELL_CORNER, 122, corners, ICORAY_ERR_GRID, "cell_corner row 20, column 2: 80"},
        {CELL_CORNER, 122, INT32_MIN, ICORAY_ERR_GRID, "cell_corner row 20, column 2"},
        {CELL_CORNER_COUNT, 3, 7, ICORAY_ERR_GRID, "cell_corner_count row 3: 7"},
        {CELL_CORNER_COUNT, 3, 2, ICORAY_ERR_GRID, "cell_corner_count row 3: 2"},
        {CELL_CORNER_COUNT, 3, INT32_MIN, ICORAY_ERR_GRID, "cell_corner_count row 3"},
    };
    struct {
        int array, row;
        double value;
        const char *part;
    } places[] = {
        {0, 7, NAN, "center row 7"},       {0, 7, INFINITY, "center row 7"}, {1, 7, 2.0, "center row 7"},
        {1, 7, -INFINITY, "center row 7"}, {2, 5, NAN, "corner row 5"},      {2, 5, 360.0, "corner row 5"},
        {3, 5, NAN, "corner row 5"},       {3, 5, -90.0, "corner row 5"},
    };
    table[CELL_CORNER] = copied(good_grid.cell_corner, 6 * good_grid.cells);
    table[CELL_CORNER_COUNT] = copied(NULL, good_grid.cells);
    table[CORNER_CELL] = copied(good_grid.corner_cell, 3 * good_grid.corners);
    table[CORNER_EDGE] = copied(good_grid.corner_edge, 3 * good_grid.corners);
    table[EDGE_CORNER] = copied(good_grid.edge_corner, 2 * good_grid.edges);
    for (int i = 0; i < cells; i++) {
        table[CELL_CORNER_COUNT][i] = 6;
    }
    grid.cell_corner = table[CELL_CORNER];
    grid.cell_corner_count = table[CELL_CORNER_COUNT];
    grid.corner_cell = table[CORNER_CELL];
    grid.corner_edge = table[CORNER_EDGE];
    grid.edge_corner = table[EDGE_CORNER];
    for (size_t i = 0; i < COUNT(cases); i++) {
        int32_t *entry = &table[cases[i].table][cases[i].entry], was = *entry;
        trying = cases[i].part;
        *entry = cases[i].value;
        REFUSED(ctx, cases[i].status, cases[i].part, icoray_grid_set(ctx, &grid));
        *entry = was;
    }
    for (size_t i = 0; i < COUNT(places); i++) {
        const void **arrays[4];
        icoray_grid other = good_grid;
        size_t rows = (size_t)(places[i].array < 2 ? cells : corners);
        double *copy = malloc(rows * sizeof *copy);
        arrays[0] = &other.lon_center_rad, arrays[1] = &other.lat_center_rad;
        arrays[2] = &other.lon_corner_rad, arrays[3] = &other.lat_corner_rad;
        trying = places[i].part;
        if (copy != NULL) {
            memcpy(copy, *arrays[places[i].array], rows * sizeof *copy);
            copy[places[i].row] = places[i].value;
            *arrays[places[i].array] = copy;
            REFUSED(ctx, ICORAY_ERR_GRID, places[i].part, icoray_grid_set(ctx, &other));
            free(copy);
        }
    }
    /* The tables were right but for those entries. */
    trying = "";
    OK(icoray_grid_set(ctx, &grid));
    OK(icoray_grid_set(ctx, &good_grid));
    for (int i = 0; i < 5; i++) {
        free(table[i]);
    }
}

static void layers(icoray_ctx *ctx)
{
    static const struct {
        double radius[3], planet;
        int64_t count;
        icoray_status status;
        const char *part;
    } cases[] = {
        {{1, 2, 3}, 1, 0, ICORAY_ERR_LAYERS, "0 layers"},
        {{1, 2, 3}, 1, 1, ICORAY_ERR_LAYERS, "1 layers"},
        {{1, 2, 3}, 1, -1, ICORAY_ERR_ARGUMENT, "icoray_layers.count: -1"},
        {{1, 2, 3}, 1, INT64_MIN, ICORAY_ERR_ARGUMENT, "icoray_layers.count"},
        {{1, 2, 3}, 1, INT64_MAX, ICORAY_ERR_ARGUMENT, "icoray_layers.count"},
        {{1, 2, 2}, 1, 3, ICORAY_ERR_LAYERS, "layers 1 and 2"},
        {{1, 1, 2}, 1, 3, ICORAY_ERR_LAYERS, "layers 0 and 1"},
        {{1, 3, 2}, 1, 3, ICORAY_ERR_LAYERS, "strictly rising"},
        {{3, 1, 2}, 1, 3, ICORAY_ERR_LAYERS, "strictly falling"},
        {{1, NAN, 3}, 1, 3, ICORAY_ERR_LAYERS, "layer 1"},
        {{1, 2, INFINITY}, 1, 3, ICORAY_ERR_LAYERS, "layer 2"},
        {{-INFINITY, 2, 3}, 1, 3, ICORAY_ERR_LAYERS, "layer 0"},
        {{0, 2, 3}, 1, 3, ICORAY_ERR_LAYERS, "layer 0: radius 0"},
        {{-3, -2, -1}, 1, 3, ICORAY_ERR_LAYERS, "layer 0: radius -3"},
        {{1, 2, 3}, 0, 3, ICORAY_ERR_LAYERS, "planet radius 0"},
        {{1, 2, 3}, -1, 3, ICORAY_ERR_LAYERS, "planet radius -1"},
        {{1, 2, 3}, NAN, 3, ICORAY_ERR_LAYERS, "planet radius NaN"},
        {{1, 2, 3}, INFINITY, 3, ICORAY_ERR_LAYERS, "planet radius inf"},
    };
    icoray_layers layers;
    for (size_t i = 0; i < COUNT(cases); i++) {
        trying = cases[i].part;
        layers = good_layers;
        layers.count = cases[i].count;
        layers.radius_m = cases[i].radius;
        layers.planet_radius_m = cases[i].planet;
        REFUSED(ctx, cases[i].status, cases[i].part, icoray_layers_set(ctx, &layers));
    }
    trying = "";
    layers = good_layers;
    layers.radius_m = NULL;
    REFUSED(ctx, ICORAY_ERR_NULL, "icoray_layers.radius_m", icoray_layers_set(ctx, &layers));
    layers.radius_m = (const double *)((const char *)radius + 1);
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "icoray_layers.radius_m", icoray_layers_set(ctx, &layers));
}

static void arrays(icoray_ctx *ctx)
{
    enum { TYPE, LOCATION, COLUMNS, ROWS, COLUMN_STRIDE, LAYER_STRIDE };
    static const struct {
        int member;
        int64_t value;
        icoray_status status;
        const char *part;
    } cases[] = {
        {TYPE, 0, ICORAY_ERR_ARGUMENT, "type 0"},
        {TYPE, 3, ICORAY_ERR_ARGUMENT, "type 3"},
        {TYPE, -1, ICORAY_ERR_ARGUMENT, "type -1"},
        {LOCATION, 2, ICORAY_ERR_ARGUMENT, "icoray_array.location: 2"},
        {LOCATION, -1, ICORAY_ERR_ARGUMENT, "icoray_array.location: -1"},
        {COLUMNS, -1, ICORAY_ERR_ARGUMENT, "icoray_array.columns: -1"},
        {COLUMNS, INT64_MAX, ICORAY_ERR_ARGUMENT, "icoray_array.columns"},
        {COLUMNS, 0, ICORAY_ERR_FIELD, "0 columns"},
        {ROWS, -1, ICORAY_ERR_ARGUMENT, "icoray_array.layers: -1"},
        {ROWS, INT64_MIN, ICORAY_ERR_ARGUMENT, "icoray_array.layers"},
        {ROWS, INT64_MAX, ICORAY_ERR_ARGUMENT, "icoray_array.layers"},
        {ROWS, 0, ICORAY_ERR_FIELD, "0 layers"},
        {COLUMN_STRIDE, INT64_MAX, ICORAY_ERR_ARGUMENT, "strides"},
        {COLUMN_STRIDE, INT64_MIN, ICORAY_ERR_ARGUMENT, "strides"},
        {COLUMN_STRIDE, INT64_MAX / 41, ICORAY_ERR_ARGUMENT, "strides"},
        {COLUMN_STRIDE, INT64_MIN / 41, ICORAY_ERR_ARGUMENT, "strides"},
        {LAYER_STRIDE, INT64_MAX, ICORAY_ERR_ARGUMENT, "strides"},
        {LAYER_STRIDE, INT64_MIN, ICORAY_ERR_ARGUMENT, "strides"},
        {LAYER_STRIDE, INT64_MAX / 8, ICORAY_ERR_ARGUMENT, "strides"},
    };
    icoray_array array;
    for (size_t i = 0; i < COUNT(cases); i++) {
        int64_t v = cases[i].value;
        trying = cases[i].part;
        array = good_array;
        switch (cases[i].member) {
        case TYPE: array.type = (int32_t)v; break;
        case LOCATION: array.location = (int32_t)v; break;
        case COLUMNS: array.columns = v; break;
        case ROWS: array.layers = v; break;
        case COLUMN_STRIDE: array.column_stride = v; break;
        default: array.layer_stride = v;
        }
        REFUSED(ctx, cases[i].status, cases[i].part, icoray_field_set(ctx, "f", &array));
        REFUSED(ctx, cases[i].status, "field \"f\"", icoray_field_set(ctx, "f", &array));
    }
    trying = "";
    /* One reaches far down, the other far up: each is within bounds, the whole is not. */
    array = good_array;
    array.columns = array.layers = 2;
    array.column_stride = -((int64_t)1 << 59);
    array.layer_stride = (int64_t)1 << 59;
    array.type = ICORAY_F64;
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "address space", icoray_field_set(ctx, "f", &array));
    array = good_array;
    array.data = NULL;
    REFUSED(ctx, ICORAY_ERR_NULL, "icoray_array.data", icoray_field_set(ctx, "f", &array));
    array.data = (const char *)values + 2;
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "not aligned", icoray_field_set(ctx, "f", &array));
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "UTF-8", icoray_field_set(ctx, NO_UTF8, &good_array));
}

/* Fields that are right by themselves and do not fit grid, layers or scene. */
static void misfits(icoray_ctx *ctx)
{
    static const struct {
        int location;
        int64_t columns, layers;
        const char *part;
    } cases[] = {
        {ICORAY_CENTER, 41, LAYERS, "41 columns, expected 42"},
        {ICORAY_CENTER, 1, LAYERS, "1 columns, expected 42"},
        {ICORAY_CORNER, 42, LAYERS, "42 columns, expected 80"},
        {ICORAY_CENTER, 42, 1, "1 layers, expected 3"},
        {ICORAY_CENTER, 31, 4, "31 columns, expected 42"},
    };
    icoray_array array;
    icoray_layers two = good_layers;
    for (size_t i = 0; i < COUNT(cases); i++) {
        trying = cases[i].part;
        array = good_array;
        array.location = cases[i].location;
        array.columns = cases[i].columns;
        array.layers = cases[i].layers;
        array.column_stride = cases[i].layers;
        OK(icoray_field_set(ctx, "f", &array));
        REFUSED(ctx, ICORAY_ERR_FIELD, cases[i].part, icoray_execute(ctx, 0, 0.0, NULL));
    }
    trying = "";
    OK(icoray_field_set(ctx, "f", &good_array));
    /* More layers than the field, handed over after it. */
    two.count = 2;
    OK(icoray_layers_set(ctx, &two));
    REFUSED(ctx, ICORAY_ERR_FIELD, "3 layers, expected 2", icoray_execute(ctx, 0, 0.0, NULL));
    OK(icoray_layers_set(ctx, &good_layers));
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "iso_datetime", icoray_execute(ctx, 0, 0.0, NO_UTF8));
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "time_s", icoray_execute(ctx, 0, NAN, NULL));
}

static void scenes(icoray_ctx *ctx)
{
    static const struct {
        const char *text, *part;
    } cases[] = {
        {"", "field"},
        {"field = 3\n", "line 1 (field = 3)"},
        {"field = \"f\"\n\n[image\n", "line 3 ([image)"},
        {"field = \"f\"\ncolour = 1\n", "line 2 (colour = 1)"},
        {"field = \"\"\n[camera]\nlon = 0\nlat = 0\ndistance = 3\n[transfer]\nmap = \"viridis\"\n", "line 1"},
        {"field = \"f\"\n[camera]\nlon = 0\nlat = 95\ndistance = 3\n[transfer]\n", "line 4, key camera.lat: 95"},
        {"field = \"f\"\nexaggeration = nan\n[camera]\n[transfer]\n", "line 2, key exaggeration: NaN"},
        {"field = \"f\"\n[camera]\nlon = 0\nlat = 0\ndistance = 3\n[transfer]\nmap = \"jet\"\nrange = [0, 1]\n"
         "opacity = [[0, 0.5]]\n",
         "line 7, key transfer.map"},
        {"field = \"f\"\n[camera]\nlon = 0\nlat = 0\ndistance = 3\n[transfer]\nmap = \"viridis\"\nrange = [0, 1]\n"
         "opacity = [[0, 0.5]]\n[output]\nfile = \"f.gif\"\n",
         "line 11, key output.file"},
    };
    char path[1024], words[1200];
    char *deep = malloc(DEEP + 5);
    for (size_t i = 0; i < COUNT(cases); i++) {
        trying = cases[i].part;
        REFUSED(ctx, ICORAY_ERR_SCENE, cases[i].part, icoray_scene_text(ctx, cases[i].text));
        path_of(path, sizeof path, "bad.toml");
        CHECK(write_file(path, cases[i].text));
        REFUSED(ctx, ICORAY_ERR_SCENE, cases[i].part, icoray_scene_load(ctx, path));
        REFUSED(ctx, ICORAY_ERR_SCENE, path, icoray_scene_load(ctx, path));
    }
    trying = "";
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "UTF-8", icoray_scene_text(ctx, NO_UTF8));
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "UTF-8", icoray_scene_load(ctx, NO_UTF8));
    path_of(path, sizeof path, "missing.toml");
    snprintf(words, sizeof words, "%s: cannot read the scene", path);
    REFUSED(ctx, ICORAY_ERR_IO, words, icoray_scene_load(ctx, path));
    REFUSED(ctx, ICORAY_ERR_IO, directory, icoray_scene_load(ctx, directory));
    REFUSED(ctx, ICORAY_ERR_IO, "cannot read the scene", icoray_scene_load(ctx, ""));
    path_of(path, sizeof path, "bytes.toml");
    CHECK(write_file(path, "field = \"" NO_UTF8 "\"\n"));
    REFUSED(ctx, ICORAY_ERR_IO, path, icoray_scene_load(ctx, path));

    /* Brackets without end would overflow the stack of a careless parser. */
    if (deep != NULL) {
        memcpy(deep, "f = ", 4);
        memset(deep + 4, '[', DEEP);
        deep[DEEP + 4] = '\0';
        REFUSED(ctx, ICORAY_ERR_SCENE, "bad scene", icoray_scene_text(ctx, deep));
        free(deep);
    }

    /* A good file; and a scene that is good by itself and asks for what is not there. */
    path_of(path, sizeof path, "good.toml");
    CHECK(write_file(path, good_scene));
    OK(icoray_scene_load(ctx, path));
    still_draws(ctx);
    OK(icoray_scene_text(ctx, SCENE("q", "4", "q.png")));
    REFUSED(ctx, ICORAY_ERR_FIELD, "\"q\"", icoray_execute(ctx, 0, 0.0, NULL));
    REFUSED(ctx, ICORAY_ERR_FIELD, "[\"f\"]", icoray_execute(ctx, 0, 0.0, NULL));
    OK(icoray_scene_text(ctx, SCENE("f", "0.5", "q.png")));
    REFUSED(ctx, ICORAY_ERR_SCENE, "inside the opaque core", icoray_execute(ctx, 0, 0.0, NULL));
    CHECK(!file_exists("q.png"));
    OK(icoray_scene_text(ctx, good_scene));
}

static void order(void)
{
    icoray_ctx *ctx = opened();
    icoray_frame_report report;
    char message[64] = "not empty";
    memset(&report, 0, sizeof report);
    report.struct_size = sizeof report;

    OK(icoray_last_error(ctx, message, sizeof message));
    CHECK(message[0] == '\0'); /* nothing has failed yet */
    REFUSED(ctx, ICORAY_ERR_ORDER, "no frame", icoray_report(ctx, &report));
    REFUSED(ctx, ICORAY_ERR_ORDER, "icoray_grid_set", icoray_execute(ctx, 0, 0.0, NULL));
    OK(icoray_grid_set(ctx, &good_grid));
    REFUSED(ctx, ICORAY_ERR_ORDER, "icoray_layers_set", icoray_execute(ctx, 0, 0.0, NULL));
    OK(icoray_layers_set(ctx, &good_layers));
    REFUSED(ctx, ICORAY_ERR_ORDER, "icoray_scene_load", icoray_execute(ctx, 0, 0.0, NULL));
    OK(icoray_scene_text(ctx, good_scene));
    REFUSED(ctx, ICORAY_ERR_FIELD, "icoray_field_set", icoray_execute(ctx, 0, 0.0, NULL));
    REFUSED(ctx, ICORAY_ERR_ORDER, "no frame", icoray_report(ctx, &report));
    OK(icoray_field_set(ctx, "f", &good_array));
    still_draws(ctx);
    OK(icoray_close(&ctx));

    /* Otherwise any order will do: the last three before the first two. */
    ctx = opened();
    OK(icoray_scene_text(ctx, good_scene));
    OK(icoray_field_set(ctx, "f", &good_array));
    OK(icoray_layers_set(ctx, &good_layers));
    OK(icoray_grid_set(ctx, &good_grid));
    still_draws(ctx);
    OK(icoray_close(&ctx));

    /* Closed with a failure as its last call. */
    ctx = opened();
    REFUSED(ctx, ICORAY_ERR_NULL, "toml", icoray_scene_text(ctx, NULL));
    OK(icoray_close(&ctx));
    CHECK(ctx == NULL);
}

static void dates(icoray_ctx *ctx)
{
    static const char *const wrong[] = {"", "yesterday", "2026-01-01", "a-b-c_d:e:f", "2026-01-01_00:00:00:00"};
    OK(icoray_scene_text(ctx, SCENE("f", "4", "d_$Y-$M-$D_$h.$m.$s.png")));
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "date is absent", icoray_execute(ctx, 0, 0.0, NULL));
    for (size_t i = 0; i < COUNT(wrong); i++) {
        char words[64];
        snprintf(words, sizeof words, "date \"%s\"", wrong[i]);
        trying = words;
        REFUSED(ctx, ICORAY_ERR_ARGUMENT, words, icoray_execute(ctx, 0, 0.0, wrong[i]));
        trying = "";
    }
    CHECK(!file_exists("d_2026-11-05_06.07.08.png"));
    OK(icoray_execute(ctx, 0, 0.0, "2026-11-05_06:07:08"));
    CHECK(file_exists("d_2026-11-05_06.07.08.png"));
    OK(icoray_execute(ctx, 0, 0.0, "0001-01-05T06:07:08"));
    CHECK(file_exists("d_0001-01-05_06.07.08.png"));
    OK(icoray_scene_text(ctx, good_scene));
    OK(icoray_execute(ctx, 0, 0.0, "yesterday")); /* not needed, so not looked at */
}

/* An output directory that cannot be made: a file is in its place. */
static void blocked(void)
{
    char path[1024], words[1100];
    icoray_config config = good_config;
    icoray_ctx *ctx = NULL;
    path_of(path, sizeof path, "blocked");
    CHECK(write_file(path, "a file\n"));
    config.output_dir = path;
    OK(icoray_open_serial(&config, &ctx));
    OK(icoray_grid_set(ctx, &good_grid));
    OK(icoray_layers_set(ctx, &good_layers));
    OK(icoray_scene_text(ctx, good_scene));
    OK(icoray_field_set(ctx, "f", &good_array));
    REFUSED(ctx, ICORAY_ERR_IO, path, icoray_execute(ctx, 1, 0.0, NULL));
    REFUSED(ctx, ICORAY_ERR_IO, path, icoray_execute(ctx, 2, 0.0, NULL));
    REFUSED(ctx, ICORAY_ERR_NULL, "icoray_grid", icoray_grid_set(ctx, NULL));
    OK(icoray_grid_set(ctx, &good_grid));
    CHECK(remove(path) == 0);
    still_draws(ctx);
    CHECK(file_exists("blocked/f_1.png"));

    /* The report's place is taken by a directory, of another picture. */
    OK(icoray_scene_text(ctx, SCENE("f", "4", "sub/report.csv/x.png")));
    OK(icoray_execute(ctx, 3, 0.0, NULL));
    OK(icoray_scene_text(ctx, SCENE("f", "4", "sub/y.png")));
    snprintf(words, sizeof words, "%s/sub/report.csv: cannot write the report", path);
    REFUSED(ctx, ICORAY_ERR_IO, words, icoray_execute(ctx, 4, 0.0, NULL));
    OK(icoray_scene_text(ctx, good_scene));
    still_draws(ctx);
    OK(icoray_close(&ctx));
}

/* Messages, cut to the room there is. */
static void messages(icoray_ctx *ctx)
{
    /* "icoray_layers is NULL", then one whose cut would fall inside of a letter. */
    static const char whole[] = "icoray_layers is NULL";
    char buffer[64];
    icoray_array array = good_array;
    icoray_ctx *other = opened();
    array.data = NULL;
    CHECK(icoray_layers_set(ctx, NULL) == ICORAY_ERR_NULL);
    for (size_t len = 1; len <= sizeof whole + 2; len++) {
        size_t length = len - 1 < sizeof whole - 1 ? len - 1 : sizeof whole - 1;
        memset(buffer, '#', sizeof buffer);
        OK(icoray_last_error(ctx, buffer, len));
        CHECK(strlen(buffer) == length && strncmp(buffer, whole, length) == 0);
        CHECK(buffer[len] == '#'); /* nothing beyond what was said */
    }
    /* field "\u00e9": the letter takes two bytes. */
    CHECK(icoray_field_set(ctx, "\xc3\xa9", &array) == ICORAY_ERR_NULL);
    OK(icoray_last_error(ctx, buffer, 9));
    CHECK(strcmp(buffer, "field \"") == 0);
    OK(icoray_last_error(ctx, buffer, 10));
    CHECK(strcmp(buffer, "field \"\xc3\xa9") == 0);

    /* Each context has its own; the thread has the latest; calls that go well change neither. */
    CHECK(icoray_layers_set(ctx, NULL) == ICORAY_ERR_NULL);
    CHECK(icoray_grid_set(other, NULL) == ICORAY_ERR_NULL);
    OK(icoray_layers_set(ctx, &good_layers));
    OK(icoray_last_error(ctx, buffer, sizeof buffer));
    CHECK(strcmp(buffer, whole) == 0);
    OK(icoray_last_error(NULL, buffer, sizeof buffer));
    CHECK(strcmp(buffer, "icoray_grid is NULL") == 0);
    OK(icoray_close(&other));
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        printf("refusals <directory>\n");
        return EXIT_FAILURE;
    }
    directory = argv[1];
    CHECK(strcmp(icoray_version(), "") != 0);
    prepare();
    order();
    icoray_ctx *ctx = filled();
    still_draws(ctx);
    nulls(ctx);
    still_draws(ctx);
    struct_sizes(ctx);
    still_draws(ctx);
    openings();
    grids(ctx);
    still_draws(ctx);
    bad_tables(ctx);
    still_draws(ctx);
    layers(ctx);
    still_draws(ctx);
    arrays(ctx);
    still_draws(ctx);
    misfits(ctx);
    still_draws(ctx);
    scenes(ctx);
    still_draws(ctx);
    dates(ctx);
    still_draws(ctx);
    messages(ctx);
    still_draws(ctx);
    blocked();
    still_draws(ctx);
    OK(icoray_close(&ctx));
    OK(icoray_mesh_free(&mesh));
    free(values);
    return verdict("refusals");
}
