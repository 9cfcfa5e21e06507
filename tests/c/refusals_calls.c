/* Checks that all calls share: null pointers, struct sizes, opening, and messages. */
#include "refusals.h"

void nulls(icoray_ctx *ctx)
{
    icoray_ctx *none = NULL;
    icoray_mesh *no_mesh = NULL;
    icoray_grid grid = good_grid;
    icoray_frame_report report = {sizeof report};
    char buffer[4] = "abc";

    REFUSED(NULL, NULL, "ctx", icoray_open_serial(&good_config, NULL));
    REFUSED(NULL, NULL, "icoray_config", icoray_open_serial(NULL, &none));
    REFUSED(NULL, NULL, "ctx", icoray_grid_set(NULL, &good_grid));
    REFUSED(ctx, NULL, "icoray_grid", icoray_grid_set(ctx, NULL));
    REFUSED(NULL, NULL, "ctx", icoray_layers_set(NULL, &good_layers));
    REFUSED(ctx, NULL, "icoray_layers", icoray_layers_set(ctx, NULL));
    REFUSED(NULL, NULL, "ctx", icoray_field_set(NULL, "f", &good_array));
    REFUSED(ctx, NULL, "name", icoray_field_set(ctx, NULL, &good_array));
    REFUSED(ctx, NULL, "icoray_array", icoray_field_set(ctx, "f", NULL));
    REFUSED(NULL, NULL, "ctx", icoray_scene_load(NULL, "scene.toml"));
    REFUSED(ctx, NULL, "path", icoray_scene_load(ctx, NULL));
    REFUSED(NULL, NULL, "ctx", icoray_scene_text(NULL, good_scene));
    REFUSED(ctx, NULL, "toml", icoray_scene_text(ctx, NULL));
    REFUSED(NULL, NULL, "ctx", icoray_execute(NULL, 0, 0.0, NULL));
    REFUSED(NULL, NULL, "ctx", icoray_report(NULL, &report));
    REFUSED(ctx, NULL, "icoray_frame_report", icoray_report(ctx, NULL));
    REFUSED(NULL, NULL, "ctx", icoray_wait(NULL));
    REFUSED(NULL, NULL, "ctx", icoray_close(NULL));
    REFUSED(NULL, NULL, "mesh", icoray_mesh_create(1, NULL));
    REFUSED(NULL, NULL, "mesh", icoray_mesh_grid(NULL, &grid));
    REFUSED(NULL, NULL, "icoray_grid", icoray_mesh_grid(mesh, NULL));
    REFUSED(NULL, NULL, "mesh", icoray_mesh_free(NULL));

    icoray_log_stderr(NULL, ICORAY_LOG_ERROR, NULL); /* has nothing to say */

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

/* Checks a call with `value`, which is `good` but for its struct_size, for each wrong size; and a condition after it. */
#define EACH_WRONG_SIZE(type, good, context, call, condition)                                                          \
    for (size_t k = 0; k < 6; k++) {                                                                                   \
        const size_t sizes[] = {0, 1, sizeof(type) - 1, sizeof(type) + 1, sizeof(type) + 8, SIZE_MAX};                 \
        type value = good;                                                                                             \
        value.struct_size = sizes[k];                                                                                  \
        trying = text_of(#type ".struct_size: %zu, expected %zu", sizes[k], sizeof(type));                             \
        REFUSED(context, STRUCT_SIZE, trying, call);                                                                   \
        CHECK(condition);                                                                                              \
        trying = "";                                                                                                   \
    }

void struct_sizes(icoray_ctx *ctx)
{
    const icoray_grid no_grid = {0};
    const icoray_ndarray no_ndarray = {0};
    const icoray_frame_report no_report = {0};
    icoray_ctx *none = ctx;
    EACH_WRONG_SIZE(icoray_config, good_config, NULL, icoray_open_serial(&value, &none), none == NULL);
    EACH_WRONG_SIZE(icoray_grid, good_grid, ctx, icoray_grid_set(ctx, &value), value.cells == good_grid.cells);
    EACH_WRONG_SIZE(icoray_grid, no_grid, NULL, icoray_mesh_grid(mesh, &value),
                    value.struct_size == sizes[k] && value.cells == 0 && value.edge_corner == NULL);
    EACH_WRONG_SIZE(icoray_layers, good_layers, ctx, icoray_layers_set(ctx, &value), value.count == LAYERS);
    EACH_WRONG_SIZE(icoray_array, good_array, ctx, icoray_field_set(ctx, "f", &value), value.layers == LAYERS);
    EACH_WRONG_SIZE(icoray_ndarray, no_ndarray, ctx, icoray_field_set_ndarray(ctx, "f", &value), value.rank == 0);
    EACH_WRONG_SIZE(icoray_frame_report, no_report, ctx, icoray_report(ctx, &value),
                    value.struct_size == sizes[k] && value.rays == 0);
}

/* A struct where none can lie, as where a byte buffer is taken for one. */
void misaligned(icoray_ctx *ctx)
{
    static double room[64]; /* more than any struct takes */
    char *aside = (char *)room + 1;
    icoray_ctx *none = ctx;
    REFUSED(NULL, ARGUMENT, "icoray_config: 0x", icoray_open_serial((icoray_config *)(void *)aside, &none));
    CHECK(none == NULL);
    REFUSED(ctx, ARGUMENT, "icoray_grid: 0x", icoray_grid_set(ctx, (icoray_grid *)(void *)aside));
    REFUSED(ctx, ARGUMENT, "icoray_layers: 0x", icoray_layers_set(ctx, (icoray_layers *)(void *)aside));
    REFUSED(ctx, ARGUMENT, "icoray_array: 0x", icoray_field_set(ctx, "f", (icoray_array *)(void *)aside));
    REFUSED(ctx, ARGUMENT, "icoray_ndarray: 0x", icoray_field_set_ndarray(ctx, "f", (icoray_ndarray *)(void *)aside));
    REFUSED(ctx, ARGUMENT, "icoray_frame_report: 0x", icoray_report(ctx, (icoray_frame_report *)(void *)aside));
    REFUSED(NULL, ARGUMENT, "icoray_grid: 0x", icoray_mesh_grid(mesh, (icoray_grid *)(void *)aside));
}

/* Every member of the config, in and out of its range. */
void openings(void)
{
#define NUMBER(name) "icoray_config." #name, MEMBER(icoray_config, name)
    static const struct {
        const char *name;
        size_t offset, size;
        int64_t wrong[4], right[4];
    } members[] = {
        {NUMBER(threads), {-1, 4097, INT32_MIN, INT32_MAX}, {0, 1, 2, 3}},
        {NUMBER(existing), {-1, 2, INT32_MIN, INT32_MAX}, {ICORAY_NEVER_MODIFY, ICORAY_OVERWRITE, 0, 0}},
        {NUMBER(on_error), {-1, 3, INT32_MIN, INT32_MAX}, {ICORAY_WARN, ICORAY_IGNORE, ICORAY_DISABLE, 0}},
        {NUMBER(disable_after), {-1, -2, INT32_MIN, INT32_MIN + 1}, {0, 1, 1000, INT32_MAX}},
        {NUMBER(writer_queue), {-1, 1025, INT32_MIN, INT32_MAX}, {0, 1, 2, 1024}},
        {NUMBER(when_full), {-1, 2, INT32_MIN, INT32_MAX}, {ICORAY_BLOCK, ICORAY_DROP_OLDEST, 0, 0}},
        {NUMBER(log_level), {-1, 5, INT32_MIN, INT32_MAX}, {ICORAY_LOG_ERROR, ICORAY_LOG_INFO, 2, ICORAY_LOG_DEBUG}},
    };
    static const int32_t truths[] = {1, -1, INT32_MIN, INT32_MAX}; /* async_render: anything but 0 */
#undef NUMBER
    static const int32_t levels[] = {-1, INT32_MIN, 13, INT32_MAX};
    icoray_config config;
    icoray_ctx *ctx;
    for (size_t i = 0; i < COUNT(members); i++) {
        for (size_t k = 0; k < 4; k++) {
            trying = text_of("%s: %d, expected", members[i].name, (int)members[i].wrong[k]);
            config = good_config;
            put(&config, members[i].offset, members[i].size, members[i].wrong[k]);
            ctx = (icoray_ctx *)&config;
            REFUSED(NULL, ARGUMENT, trying, icoray_open_serial(&config, &ctx));
            CHECK(ctx == NULL);
            put(&config, members[i].offset, members[i].size, members[i].right[k]);
            OK(icoray_open_serial(&config, &ctx));
            OK(icoray_close(&ctx));
        }
    }
    /* A limit that is out of range is refused where it has no use, too: it was meant otherwise. */
    config = good_config;
    config.on_error = ICORAY_WARN;
    config.disable_after = -1;
    REFUSED(NULL, ARGUMENT, "disable_after", icoray_open_serial(&config, &ctx));
    trying = "async_render";
    for (size_t i = 0; i < COUNT(truths); i++) {
        config = good_config;
        config.async_render = truths[i];
        OK(icoray_open_serial(&config, &ctx));
        OK(icoray_wait(ctx));
        OK(icoray_close(&ctx));
    }
    trying = "";
    config = good_config;
    config.output_dir = NO_UTF8;
    ctx = (icoray_ctx *)&config;
    REFUSED(NULL, ARGUMENT, "icoray_config.output_dir", icoray_open_serial(&config, &ctx));
    CHECK(ctx == NULL);
    for (size_t i = 0; i < COUNT(levels); i++) {
        icoray_mesh *none = mesh;
        REFUSED(NULL, ARGUMENT, "level", icoray_mesh_create(levels[i], &none));
        CHECK(none == NULL);
    }
}

/* Messages, cut to the room there is. */
void messages(icoray_ctx *ctx)
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
