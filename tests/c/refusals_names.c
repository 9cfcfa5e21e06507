/* Several grids and sets of layers in one context, and unknown names of these. */
#include "refusals.h"

/* Describes the field "n", with strings that are freed after the call. */
static void described(icoray_ctx *ctx)
{
    char name[] = "n", long_name[] = "gr\xc3\xb6\xc3\x9f" "e of n", units[] = "m s-1";
    REFUSED(ctx, NULL, "name", icoray_field_describe(ctx, NULL, long_name, units));
    REFUSED(ctx, ARGUMENT, "name: \"\"", icoray_field_describe(ctx, "", long_name, units));
    REFUSED(ctx, ARGUMENT, "name", icoray_field_describe(ctx, NO_UTF8, long_name, units));
    REFUSED(ctx, ARGUMENT, "long_name", icoray_field_describe(ctx, name, NO_UTF8, units));
    REFUSED(ctx, ARGUMENT, "units", icoray_field_describe(ctx, name, long_name, NO_UTF8));
    REFUSED(NULL, NULL, "ctx", icoray_field_describe(NULL, name, long_name, units));
    OK(icoray_field_describe(ctx, name, long_name, units));
    name[0] = long_name[0] = units[0] = 'z';
}

void names(icoray_ctx *ctx)
{
    static const char *const unknown[] = {"b", "A", "a ", "unnamed", "\xc3\xa9"};
    icoray_mesh *fine = NULL;
    icoray_grid grid = {sizeof grid}, other = good_grid;
    icoray_layers layers = good_layers;
    icoray_array array = good_array;
    char name[] = "a";
    OK(icoray_mesh_create(LEVEL + 1, &fine));
    OK(icoray_mesh_grid(fine, &grid));
    CHECK(grid.name == NULL && grid.index_type == ICORAY_I32);
    OK(icoray_scene_text(ctx, SCENE("n", "4", "names_{step}.png")));
    for (size_t i = 0; i < COUNT(unknown); i++) {
        trying = unknown[i];
        array = good_array;
        array.grid_name = unknown[i];
        OK(icoray_field_set(ctx, "n", &array)); /* may come first */
        NOT_DRAWN(ctx, ARGUMENT, text_of("no grid named \"%s\"", unknown[i]));
        NOT_DRAWN(ctx, ARGUMENT, "field \"n\"");
        array = good_array;
        array.layers_name = unknown[i];
        OK(icoray_field_set(ctx, "n", &array));
        NOT_DRAWN(ctx, ARGUMENT, text_of("no set of layers named \"%s\"", unknown[i]));
        NOT_DRAWN(ctx, ARGUMENT, "icoray_layers_set");
    }
    trying = "";

    /* A name is copied, and distinguishes grids: a field of the one does not fit the other. */
    grid.name = layers.name = name;
    OK(icoray_grid_set(ctx, &grid));
    OK(icoray_layers_set(ctx, &layers));
    array = good_array;
    array.grid_name = array.layers_name = name;
    OK(icoray_field_set(ctx, "n", &array));
    name[0] = 'z';
    NOT_DRAWN(ctx, FIELD, "42 columns, expected 162");
    array.grid_name = "";
    array.layers_name = "a";
    OK(icoray_field_set(ctx, "n", &array));
    OK(icoray_execute(ctx, 1, 0.0, NULL)); /* the empty name is none */

    /* A refused grid leaves that of its name as it was, and so does one of another name. */
    other.name = "a";
    other.edge_corner = good_grid.corner_cell;
    REFUSED(ctx, GRID, "edge_corner", icoray_grid_set(ctx, &other));
    array.grid_name = "a";
    OK(icoray_field_set(ctx, "n", &array));
    REFUSED(ctx, FIELD, "42 columns, expected 162", icoray_execute(ctx, 2, 0.0, NULL));
    other.edge_corner = good_grid.edge_corner;
    OK(icoray_grid_set(ctx, &other));
    OK(icoray_field_describe(ctx, "another", "its name", "its units"));
    OK(icoray_execute(ctx, 3, 0.0, NULL));
    described(ctx);
    OK(icoray_field_set(ctx, "n", &array));
    OK(icoray_execute(ctx, 5, 0.0, NULL)); /* what it is called stays when it is handed over anew */
    OK(icoray_field_describe(ctx, "n", " ", NULL));
    OK(icoray_execute(ctx, 6, 0.0, NULL));
    layers.name = "a";
    layers.count = 2;
    OK(icoray_layers_set(ctx, &layers));
    REFUSED(ctx, FIELD, "3 layers, expected 2", icoray_execute(ctx, 4, 0.0, NULL));
    OK(icoray_wait(ctx));
    CHECK(!file_exists("names_0.png") && is_picture("names_1.png") && !file_exists("names_2.png"));
    CHECK(!says("names_3.png", "long name") && !says("names_3.png", "its"));
    CHECK(says("names_5.png", "gr\xc3\xb6\xc3\x9f" "e of n") && says("names_5.png", "m s-1"));
    CHECK(is_picture("names_6.png") && !says("names_6.png", "long name") && !says("names_6.png", "units"));
    CHECK(is_picture("names_3.png") && !file_exists("names_4.png"));
    OK(icoray_mesh_free(&fine)); /* no context reads it any more */
    OK(icoray_scene_text(ctx, good_scene));
}
