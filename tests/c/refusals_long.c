/* Messages about long names, paths, lists and scenes, which stay short; and inputs that were given and refused. */
#include "refusals.h"

enum { LONG = 3000 };

/* Lines of the log longer than any message may be, and the longest. */
static size_t too_long, longest;

static void measure(void *user, int32_t level, const char *message)
{
    size_t length = strlen(message);
    (void)user;
    (void)level;
    too_long += length > 400;
    longest = length > longest ? length : longest;
}

/* A name of LONG characters that begins and ends with these words. */
static const char *long_name(char *buffer, const char *head, const char *tail)
{
    memset(buffer, 'x', LONG);
    memcpy(buffer, head, strlen(head));
    memcpy(buffer + LONG - strlen(tail), tail, strlen(tail));
    buffer[LONG] = '\0';
    return buffer;
}

void long_messages(void)
{
    static char name[LONG + 1], scene[8 * LONG];
    icoray_config config = good_config;
    icoray_grid grid = good_grid;
    icoray_array array = good_array;
    icoray_ctx *ctx;
    config.log = measure;
    config.log_level = ICORAY_LOG_DEBUG;
    too_long = longest = 0;
    ctx = filled_with(&config);
    trying = "long messages";

    /* Both ends of what is too long are there, and what is wrong with it. */
    array.columns = -7;
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "tail\": icoray_array.columns: -7, expected 0 to",
            icoray_field_set(ctx, long_name(name, "head", "tail"), &array));
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "field \"head",
            icoray_field_set(ctx, long_name(name, "head", "tail"), &array));
    REFUSED(ctx, ICORAY_ERR_IO, "tail.toml: cannot read the scene",
            icoray_scene_load(ctx, long_name(name, "/head/", "/tail.toml")));
    array = good_array;
    array.grid_name = long_name(name, "head", "tail");
    OK(icoray_field_set(ctx, "f", &array));
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "tail\" was given by icoray_grid_set; given: [\"\"]",
            icoray_execute(ctx, 1, 0.0, NULL));
    OK(icoray_field_set(ctx, "f", &good_array));
    snprintf(scene, sizeof scene, SCENE("%s", "4", "q.png"), long_name(name, "other", "tail"));
    OK(icoray_scene_text(ctx, scene));
    REFUSED(ctx, ICORAY_ERR_FIELD, "tail\" was not given by icoray_field_set; given: [\"f\"]",
            icoray_execute(ctx, 1, 0.0, NULL));
    snprintf(scene, sizeof scene, "%s = 1\n", long_name(name, "head", "tail"));
    REFUSED(ctx, ICORAY_ERR_SCENE, "line 1", icoray_scene_text(ctx, scene));
    memset(name, ' ', LONG);
    for (int i = 1; i < LONG; i += 3) {
        name[i] = 'w';
    }
    snprintf(scene, sizeof scene, SCENE("%s", "4", "q.png"), name);
    OK(icoray_scene_text(ctx, scene));
    REFUSED(ctx, ICORAY_ERR_FIELD, "given: [\"f\"]", icoray_execute(ctx, 1, 0.0, NULL));
    REFUSED(ctx, ICORAY_ERR_SCENE, "\"none such\", expected one of",
            icoray_scene_text(ctx, "field = \"f\"\n[image]\nwidth = 16\nheight = 16\n[camera]\nlon = 1\nlat = 1\n"
                                   "distance = 4\n[transfer]\nmap = \"none such\"\nrange = [0, 1]\n"
                                   "opacity = [[0, 0.1], [1, 0.9]]\n"));

    /* Many names: some of them, and how many more there are. */
    for (int i = 0; i < 40; i++) {
        char each[64];
        snprintf(each, sizeof each, "a field with a name of some length, number %02d", i);
        OK(icoray_field_set(ctx, each, &good_array));
    }
    OK(icoray_scene_text(ctx, SCENE("q", "4", "q.png")));
    REFUSED(ctx, ICORAY_ERR_FIELD, "number 05\" and 35 more]", icoray_execute(ctx, 1, 0.0, NULL));

    grid.name = long_name(name, "head", "tail");
    grid.index_base = 7;
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "index_base: 7", icoray_grid_set(ctx, &grid));
    OK(icoray_scene_text(ctx, good_scene));
    still_draws(ctx);
    OK(icoray_close(&ctx));
    CHECK(too_long == 0);
    CHECK(longest > 300);
    trying = "";
}

/* What a later call says of it. */
void given_and_refused(void)
{
    icoray_ctx *ctx = opened();
    icoray_array array = good_array;
    icoray_layers layers = good_layers;
    icoray_grid grid = good_grid;
    trying = "given and refused";
    OK(icoray_scene_text(ctx, good_scene));
    grid.cells = -3;
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "icoray_grid.cells: -3", icoray_grid_set(ctx, &grid));
    REFUSED(ctx, ICORAY_ERR_ORDER, "grid was refused by icoray_grid_set: icoray_grid.cells: -3",
            icoray_execute(ctx, 1, 0.0, NULL));
    OK(icoray_grid_set(ctx, &good_grid));
    REFUSED(ctx, ICORAY_ERR_ORDER, "icoray_execute was called before a set of layers was set",
            icoray_execute(ctx, 1, 0.0, NULL));
    layers.planet_radius_m = -1;
    REFUSED(ctx, ICORAY_ERR_LAYERS, "planet radius -1", icoray_layers_set(ctx, &layers));
    REFUSED(ctx, ICORAY_ERR_ORDER, "layers was refused by icoray_layers_set: bad layers: planet radius -1",
            icoray_execute(ctx, 1, 0.0, NULL));
    OK(icoray_layers_set(ctx, &good_layers));

    array.type = 77;
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "icoray_array.type: 77", icoray_field_set(ctx, "f", &array));
    REFUSED(ctx, ICORAY_ERR_FIELD, "field \"f\" was refused by icoray_field_set: icoray_array.type: 77",
            icoray_execute(ctx, 1, 0.0, NULL));
    array.struct_size = 5;
    REFUSED(ctx, ICORAY_ERR_STRUCT_SIZE, "icoray_array.struct_size: 5", icoray_field_set(ctx, "f", &array));
    REFUSED(ctx, ICORAY_ERR_FIELD, "refused by icoray_field_set: icoray_array.struct_size: 5",
            icoray_execute(ctx, 1, 0.0, NULL));
    OK(icoray_field_set(ctx, "f", &good_array));
    still_draws(ctx);
    /* A field that was refused leaves the one before, which is drawn. */
    REFUSED(ctx, ICORAY_ERR_STRUCT_SIZE, "struct_size", icoray_field_set(ctx, "f", &array));
    still_draws(ctx);

    array = good_array;
    array.location = ICORAY_CORNER;
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "ICORAY_CORNER", icoray_heights_set(ctx, &array));
    OK(icoray_scene_text(ctx, "heights = \"native\"\n" SCENE("f", "4", "q.png")));
    REFUSED(ctx, ICORAY_ERR_FIELD, "heights were refused by icoray_heights_set: icoray_array.location: ICORAY_CORNER",
            icoray_execute(ctx, 1, 0.0, NULL));
    OK(icoray_heights_set(ctx, NULL));
    REFUSED(ctx, ICORAY_ERR_FIELD, "none were given by icoray_heights_set", icoray_execute(ctx, 1, 0.0, NULL));

    /* By a binding, before it came to the library. */
    trying = "refused by a binding";
    OK(icoray_scene_text(ctx, SCENE("b", "4", "q.png")));
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "field \"b\": dimension 2 steps by 7 bytes",
            icoray_refuse(ctx, "icoray_field_set", "b", ICORAY_ERR_ARGUMENT, "dimension 2 steps by 7 bytes"));
    REFUSED(ctx, ICORAY_ERR_FIELD, "field \"b\" was refused by icoray_field_set: dimension 2 steps by 7 bytes",
            icoray_execute(ctx, 1, 0.0, NULL));
    REFUSED(ctx, ICORAY_ERR_ORDER, "open already",
            icoray_refuse(ctx, "icoray_open", NULL, ICORAY_ERR_ORDER, "the context is open already"));
    REFUSED(ctx, ICORAY_ERR_NULL, "not associated",
            icoray_refuse(ctx, "icoray_grid_set", "g", ICORAY_ERR_NULL, "lon_center is not associated"));
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "no bug",
            icoray_refuse(ctx, "icoray_field_set", "b", ICORAY_ERR_INTERNAL, "no bug of icoray's"));
    REFUSED(ctx, ICORAY_ERR_NULL, "call", icoray_refuse(ctx, NULL, "b", ICORAY_ERR_NULL, "m"));
    REFUSED(ctx, ICORAY_ERR_NULL, "message", icoray_refuse(ctx, "icoray_field_set", "b", ICORAY_ERR_NULL, NULL));
    REFUSED(NULL, ICORAY_ERR_NULL, "ctx", icoray_refuse(NULL, "icoray_field_set", "b", ICORAY_ERR_NULL, "m"));
    array = good_array;
    array.grid_name = "g";
    OK(icoray_field_set(ctx, "b", &array));
    REFUSED(ctx, ICORAY_ERR_ARGUMENT, "grid \"g\" was refused by icoray_grid_set: lon_center is not associated",
            icoray_execute(ctx, 1, 0.0, NULL));
    OK(icoray_scene_text(ctx, good_scene));
    still_draws(ctx);
    OK(icoray_close(&ctx));
    trying = "";
}
