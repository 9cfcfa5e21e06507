/* The ComIn plugin: ICON draws the scene whose path is the plugin's options, from its own arrays on all its processes.
 * A failure is a line in ICON's log; ICON goes on. */
#include "clock.h"
#include "grid.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A variable that the scene reads. */
typedef struct {
    char name[80]; /* as the scene has it */
    int domain;
    host_place place;
    void *handle; /* NULL if it is not drawn */
} field;

static icoray_ctx *context;
static char scene[512];
static grid_tables *grids; /* of all domains, from 1; those that no field is on have no tables */
static int domains;
static field *fields;
static int64_t field_count;

static void to_log(void *user, int32_t level, const char *message)
{
    (void)user;
    host_say(level <= ICORAY_LOG_WARN, message);
}

static void say_last_error(void)
{
    char message[401];
    icoray_last_error(NULL, message, sizeof message);
    host_warn_once(message);
}

/* Ends drawing. Collective: all ranks get the same status in what comes before. */
static void close_context(void)
{
    /* icoray has logged what failed. */
    icoray_close(&context);
    for (int i = 0; i < domains; i++) {
        grid_free(&grids[i]);
    }
    free(grids);
    free(fields);
    grids = NULL;
    fields = NULL;
    domains = 0;
    field_count = 0;
}

/* Splits "temp_DOM02", the variable temp of domain 2; without such an end it is of domain 1. */
static int domain_of(const char *name, char *variable, size_t size)
{
    size_t length = strlen(name);
    int domain = 1, is_nest = length > 6 && memcmp(name + length - 6, "_DOM", 4) == 0;
    if (is_nest && sscanf(name + length - 2, "%2d", &domain) == 1) {
        length -= 6;
    }
    if (domain < 1 || domain > domains || length >= size) {
        return 0;
    }
    memcpy(variable, name, length);
    variable[length] = 0;
    return domain;
}

/* Requests what the scene reads, and nothing else: on GPUs ICON copies each requested variable before each call. */
static int request_fields(void)
{
    char name[sizeof fields->name], variable[sizeof fields->name], line[160];
    for (int64_t i = 0; icoray_scene_field(context, i, name, sizeof name) == ICORAY_OK && name[0] != 0; i++) {
        field *more = realloc(fields, (size_t)(i + 1) * sizeof *fields);
        if (more == NULL) {
            return 0;
        }
        fields = more;
        field_count = i + 1;
        memcpy(fields[i].name, name, sizeof name);
        fields[i].domain = domain_of(name, variable, sizeof variable);
        fields[i].place = HOST_NOWHERE;
        fields[i].handle = fields[i].domain > 0 ? host_request(variable, fields[i].domain, &fields[i].place) : NULL;
        if (fields[i].handle == NULL) {
            snprintf(line, sizeof line, "the scene reads %s, and ICON has %s", name,
                     fields[i].place == HOST_EDGES ? "it at edges: expected a variable at triangles" : "no such variable");
            host_warn_once(line);
            continue;
        }
        char long_name[256], units[64];
        host_describe(variable, fields[i].domain, "long_name", long_name, sizeof long_name);
        host_describe(variable, fields[i].domain, "units", units, sizeof units);
        icoray_field_describe(context, name, long_name, units);
    }
    return 1;
}

/* Sets grid, part, layers and heights of a domain. Collective, also after a failure on this rank. */
static icoray_status set_domain(int domain, int has_heights)
{
    grid_tables *grid = &grids[domain - 1];
    int count = 0;
    const double *half_levels = host_half_levels(&count);
    icoray_grid tables;
    icoray_part part;
    int is_made = grid_make(grid, domain);
    if (is_made) {
        grid_describe(grid, &tables);
        grid_describe_part(grid, &part);
        /* A failure of this rank is that of the next call on all. */
        is_made = icoray_grid_set(context, &tables) == ICORAY_OK;
    }
    icoray_status status = icoray_part_set(context, is_made ? &part : NULL);
    if (status != ICORAY_OK) {
        return status;
    }
    const host_domain *at = &grid->domain;
    const double earth_radius_m = 6.371229e6;
    int64_t radii = (int64_t)at->levels + 1;
    double *radius_m = malloc((size_t)radii * sizeof *radius_m);
    if (radius_m == NULL || at->shift < 0 || at->shift + radii > count) {
        free(radius_m);
        host_warn_once("no half levels of a domain (vct_a)");
        return ICORAY_OK; /* what draws on them fails on all ranks */
    }
    for (int64_t k = 0; k < radii; k++) {
        radius_m[k] = earth_radius_m + half_levels[at->shift + k];
    }
    icoray_layers layers = {.struct_size = sizeof layers};
    layers.count = radii;
    layers.radius_m = radius_m;
    layers.planet_radius_m = earth_radius_m;
    layers.name = grid->name;
    icoray_layers_set(context, &layers);
    free(radius_m);
    if (has_heights) {
        icoray_array heights = {.struct_size = sizeof heights};
        heights.data = at->heights;
        heights.type = ICORAY_F64;
        heights.location = ICORAY_CORNER;
        heights.columns = at->cells;
        heights.layers = radii;
        heights.column_stride = 1;
        heights.layer_stride = heights.block = at->nproma;
        heights.block_stride = at->nproma * radii;
        heights.grid_name = heights.layers_name = grid->name;
        icoray_heights_set(context, &heights);
    }
    return ICORAY_OK;
}

/* Leaves out the fields at vertices of a domain where these are not the cells of this process alone: a process draws
 * vertices whose values ICON computes on another one. */
static void check_vertices(int domain)
{
    const grid_tables *grid = &grids[domain - 1];
    int are_cells = grid->cells == grid->domain.vertices && grid->own_corners == grid->domain.cells_of_all_ranks;
    char line[200];
    for (int64_t i = 0; i < field_count; i++) {
        if (fields[i].domain == domain && fields[i].place == HOST_VERTICES && !are_cells && fields[i].handle != NULL) {
            fields[i].handle = NULL;
            snprintf(line, sizeof line, "the scene reads %s, and ICON has it at vertices, which are drawn by one process only: "
                     "expected a variable at triangles", fields[i].name);
            host_warn_once(line);
        }
    }
}

/* The secondary constructor, where variables can be requested and the domains are known. */
static void set_up(void)
{
    icoray_config config = {.struct_size = sizeof config};
    config.output_dir = "pictures";
    config.existing = ICORAY_OVERWRITE;
    config.on_error = ICORAY_DISABLE;
    config.log_level = ICORAY_LOG_WARN;
    config.log = to_log;
    if (icoray_open(&config, host_communicator(), &context) != ICORAY_OK) {
        say_last_error();
        context = NULL;
        return;
    }
    icoray_status status = icoray_scene_load(context, scene);
    domains = host_domains();
    grids = calloc((size_t)domains + 1, sizeof *grids);
    int has_memory = grids != NULL;
    domains = has_memory ? domains : 0;
    if (status == ICORAY_OK) {
        has_memory = has_memory && request_fields();
        int has_heights = 0;
        for (int domain = 1; domain <= host_domains() && status == ICORAY_OK; domain++) {
            int is_read = 0;
            for (int64_t i = 0; i < field_count; i++) {
                is_read |= fields[i].domain == domain;
            }
            /* A rank without memory is in the same calls as the others. */
            char name[sizeof fields->name] = "";
            if (!has_memory) {
                icoray_scene_field(context, 0, name, sizeof name);
            }
            if (name[0] != 0) {
                status = icoray_part_set(context, NULL);
            } else if (is_read) {
                status = set_domain(domain, !has_heights);
                check_vertices(domain);
                has_heights = 1;
            }
        }
    }
    if (status != ICORAY_OK) {
        close_context();
    }
}

/* Gives icoray the values of a variable where they are now. */
static void set_field(const field *of)
{
    host_values values;
    char message[160];
    const grid_tables *grid = &grids[of->domain - 1];
    const char *fault = host_values_of(of->handle, &values);
    int at_vertices = of->place == HOST_VERTICES, nproma = grid->domain.nproma;
    int columns = at_vertices ? grid->domain.vertices : grid->domain.cells;
    int needed = columns / nproma + (columns % nproma > 0);
    int has_room = values.nproma == nproma && values.blocks >= needed;
    if (fault != NULL || !has_room || (!at_vertices && values.blocks > grid->domain.cell_blocks)) {
        if (fault != NULL) {
            snprintf(message, sizeof message, "%s", fault);
        } else {
            snprintf(message, sizeof message, "%d blocks of %d values, expected %d of %d as ICON's %s have", values.blocks,
                     values.nproma, needed, nproma, at_vertices ? "vertices" : "triangles");
        }
        icoray_refuse(context, "icoray_field_set", of->name, ICORAY_ERR_ARGUMENT, message);
        return;
    }
    icoray_array array = {.struct_size = sizeof array};
    array.data = values.data;
    array.type = values.is_float ? ICORAY_F32 : ICORAY_F64;
    array.location = at_vertices ? ICORAY_CENTER : ICORAY_CORNER;
    array.columns = columns;
    /* A value per column is a layer. */
    array.layers = values.levels > 0 ? values.levels : 1;
    array.column_stride = 1;
    array.layer_stride = values.nproma;
    array.block = values.nproma;
    array.block_stride = values.nproma * array.layers;
    array.grid_name = array.layers_name = grid->name;
    icoray_field_set(context, of->name, &array);
}

static void draw(void)
{
    static int64_t calls;
    char start[64], now[64], date[24] = "";
    int64_t step = calls++;
    double seconds = (double)step;
    int32_t wants = 0;
    if (context == NULL || host_current_domain() > 1) {
        return;
    }
    if (host_start_date(start, sizeof start) && host_date(now, sizeof now)) {
        clock_read(start, now, host_step_seconds(1), &step, &seconds, date);
    }
    icoray_wants(context, step, seconds, &wants);
    if (!wants) {
        return;
    }
    for (int64_t i = 0; i < field_count; i++) {
        if (fields[i].handle != NULL) {
            set_field(&fields[i]);
        }
    }
    icoray_execute(context, step, seconds, date);
}

static void finish(void)
{
    if (context != NULL) {
        close_context();
    }
}

void comin_main(void);

void comin_main(void)
{
    if (!host_fits()) {
        host_warn_once("the plugin was built for another ComIn than ICON's: build it with ICON's comin.h");
        return;
    }
    host_keep_errors();
    if (!host_options(scene, sizeof scene) || scene[0] == 0) {
        host_warn_once("the plugin's options in comin_nml have no scene: nothing is drawn");
        return;
    }
    host_register(set_up, draw, finish);
}
