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
    icoray_grid grid = good_grid;
    icoray_array array = good_array;
    icoray_ctx *ctx;
    too_long = longest = 0;
    ctx = filled_logging(good_config, measure, NULL, ICORAY_LOG_DEBUG);
    trying = "long messages";

    /* Both ends of what is too long are there, and what is wrong with it. */
    array.columns = -7;
    REFUSED(ctx, ARGUMENT, "tail\": icoray_array.columns: -7, expected 0 to",
            icoray_field_set(ctx, long_name(name, "head", "tail"), &array));
    REFUSED(ctx, ARGUMENT, "field \"head", icoray_field_set(ctx, long_name(name, "head", "tail"), &array));
    REFUSED(ctx, IO, "tail.toml: cannot read the scene",
            icoray_scene_load(ctx, long_name(name, "/head/", "/tail.toml")));
    array = good_array;
    array.grid_name = long_name(name, "head", "tail");
    OK(icoray_field_set(ctx, "f", &array));
    NOT_DRAWN(ctx, ARGUMENT, "tail\" was given by icoray_grid_set; given: [\"\"]");
    OK(icoray_field_set(ctx, "f", &good_array));
    snprintf(scene, sizeof scene, SCENE("%s", "4", "q.png"), long_name(name, "other", "tail"));
    OK(icoray_scene_text(ctx, scene));
    NOT_DRAWN(ctx, FIELD, "tail\" was not given by icoray_field_set; given: [\"f\"]");
    snprintf(scene, sizeof scene, "%s = 1\n", long_name(name, "head", "tail"));
    REFUSED(ctx, SCENE, "line 1", icoray_scene_text(ctx, scene));
    memset(name, ' ', LONG);
    for (int i = 1; i < LONG; i += 3) {
        name[i] = 'w';
    }
    snprintf(scene, sizeof scene, SCENE("%s", "4", "q.png"), name);
    OK(icoray_scene_text(ctx, scene));
    NOT_DRAWN(ctx, FIELD, "given: [\"f\"]");
    REFUSED(ctx, SCENE, "\"none such\", expected one of",
            icoray_scene_text(ctx, "field = \"f\"\n[image]\nwidth = 16\nheight = 16\n[camera]\nlon = 1\nlat = 1\n"
                                   "distance = 4\n[transfer]\nmap = \"none such\"\nrange = [0, 1]\n"
                                   "opacity = [[0, 0.1], [1, 0.9]]\n"));

    /* Many names: some of them, and how many more there are. */
    for (int i = 0; i < 40; i++) {
        OK(icoray_field_set(ctx, text_of("a field with a name of some length, number %02d", i), &good_array));
    }
    OK(icoray_scene_text(ctx, SCENE("q", "4", "q.png")));
    NOT_DRAWN(ctx, FIELD, "number 05\" and 35 more]");

    grid.name = long_name(name, "head", "tail");
    grid.index_base = 7;
    REFUSED(ctx, ARGUMENT, "index_base: 7", icoray_grid_set(ctx, &grid));
    OK(icoray_scene_text(ctx, good_scene));
    still_draws(ctx);
    OK(icoray_close(&ctx));
    CHECK(too_long == 0);
    CHECK(longest > 300);
}

/* The message of a later call. */
void given_and_refused(void)
{
    icoray_ctx *ctx = opened();
    icoray_array array = good_array;
    icoray_layers layers = good_layers;
    icoray_grid grid = good_grid;
    trying = "given and refused";
    OK(icoray_scene_text(ctx, good_scene));
    grid.cells = -3;
    REFUSED(ctx, ARGUMENT, "icoray_grid.cells: -3", icoray_grid_set(ctx, &grid));
    NOT_DRAWN(ctx, ORDER, "grid was refused by icoray_grid_set: icoray_grid.cells: -3");
    OK(icoray_grid_set(ctx, &good_grid));
    NOT_DRAWN(ctx, ORDER, "icoray_execute was called before a set of layers was set");
    layers.planet_radius_m = -1;
    REFUSED(ctx, LAYERS, "planet radius -1", icoray_layers_set(ctx, &layers));
    NOT_DRAWN(ctx, ORDER, "layers was refused by icoray_layers_set: bad layers: planet radius -1");
    OK(icoray_layers_set(ctx, &good_layers));

    array.type = 77;
    REFUSED(ctx, ARGUMENT, "icoray_array.type: 77", icoray_field_set(ctx, "f", &array));
    NOT_DRAWN(ctx, FIELD, "field \"f\" was refused by icoray_field_set: icoray_array.type: 77");
    array.struct_size = 5;
    REFUSED(ctx, STRUCT_SIZE, "icoray_array.struct_size: 5", icoray_field_set(ctx, "f", &array));
    NOT_DRAWN(ctx, FIELD, "refused by icoray_field_set: icoray_array.struct_size: 5");
    OK(icoray_field_set(ctx, "f", &good_array));
    still_draws(ctx);
    /* A field that was refused leaves the one before, which is drawn. */
    REFUSED(ctx, STRUCT_SIZE, "struct_size", icoray_field_set(ctx, "f", &array));
    still_draws(ctx);

    REFUSED_WITH(array, location, 9, ARGUMENT, "location: 9", icoray_heights_set(ctx, &array));
    OK(icoray_scene_text(ctx, "heights = \"native\"\n" SCENE("f", "4", "q.png")));
    NOT_DRAWN(ctx, FIELD, "heights were refused by icoray_heights_set: icoray_array.location: 9");
    OK(icoray_heights_set(ctx, NULL));
    NOT_DRAWN(ctx, FIELD, "none were given by icoray_heights_set");

    /* By a binding, before it came to the library. */
    trying = "refused by a binding";
    OK(icoray_scene_text(ctx, SCENE("b", "4", "q.png")));
    REFUSED(ctx, ARGUMENT, "field \"b\": dimension 2 steps by 7 bytes",
            icoray_refuse(ctx, "icoray_field_set", "b", ICORAY_ERR_ARGUMENT, "dimension 2 steps by 7 bytes"));
    NOT_DRAWN(ctx, FIELD, "field \"b\" was refused by icoray_field_set: dimension 2 steps by 7 bytes");
    REFUSED(ctx, ORDER, "open already",
            icoray_refuse(ctx, "icoray_open", NULL, ICORAY_ERR_ORDER, "the context is open already"));
    REFUSED(ctx, NULL, "not associated",
            icoray_refuse(ctx, "icoray_grid_set", "g", ICORAY_ERR_NULL, "lon_center is not associated"));
    REFUSED(ctx, ARGUMENT, "no bug",
            icoray_refuse(ctx, "icoray_field_set", "b", ICORAY_ERR_INTERNAL, "no bug of icoray's"));
    REFUSED(ctx, NULL, "call", icoray_refuse(ctx, NULL, "b", ICORAY_ERR_NULL, "m"));
    REFUSED(ctx, NULL, "message", icoray_refuse(ctx, "icoray_field_set", "b", ICORAY_ERR_NULL, NULL));
    REFUSED(NULL, NULL, "ctx", icoray_refuse(NULL, "icoray_field_set", "b", ICORAY_ERR_NULL, "m"));
    array = good_array;
    array.grid_name = "g";
    OK(icoray_field_set(ctx, "b", &array));
    NOT_DRAWN(ctx, ARGUMENT, "grid \"g\" was refused by icoray_grid_set: lon_center is not associated");
    OK(icoray_scene_text(ctx, good_scene));
    still_draws(ctx);
    OK(icoray_close(&ctx));
}
