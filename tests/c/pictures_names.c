/* Several grids and sets of layers in one context, and scenes of fields on each of them. */
#include "pictures.h"

static const double thick[LAYERS] = {PLANET, PLANET + 8e3, PLANET + 18e3, PLANET + 40e3};

void names(const char *directory)
{
    static const struct {
        const char *field, *group, *light;
    } scenes[] = {
        {"g", "coarse", "none"},     {"f", "plain", "none"},       {"thick g", "thick coarse", "none"},
        {"corner", "corner", "none"}, {"thick f", "thick", "none"}, {"flat g", "coarse", "none"},
        {"f", "lit", "headlight"},
    };
    icoray_mesh *coarse_mesh = NULL;
    icoray_grid coarse = {sizeof coarse};
    icoray_layers layers = layers_of(thick, NULL);
    icoray_ctx *ctx;
    int level = 0;
    while (10 * ((int64_t)1 << 2 * (level + 1)) + 2 < cells) {
        level++;
    }
    OK(icoray_mesh_create(level, &coarse_mesh)); /* one level coarser */
    OK(icoray_mesh_grid(coarse_mesh, &coarse));
    CHECK(4 * (coarse.cells - 2) == cells - 2);
    icoray_array shape = shaped(ICORAY_F32, ICORAY_CENTER, LAYERS, LAYERS, 1);
    Field f = field(ICORAY_F32, ICORAY_CENTER, LAYERS, (size_t)cells * LAYERS, 0, LAYERS, 1);
    Field g = filled(&coarse, shape, (size_t)coarse.cells * LAYERS, 0);
    Field corner = field(ICORAY_F32, ICORAY_CORNER, LAYERS, (size_t)corners * LAYERS, 0, 1, corners);

    /* Each by itself, without names. */
    ctx = context(directory, "names/alone", 2);
    OK(icoray_grid_set(ctx, &coarse));
    picture(ctx, "coarse", "none", 0, &g);
    OK(icoray_layers_set(ctx, &layers));
    picture(ctx, "thick coarse", "none", 1, &g);
    OK(icoray_grid_set(ctx, &grid));
    picture(ctx, "thick", "none", 2, &f);
    OK(icoray_close(&ctx));

    /* All in one context, with names that last no longer than the calls; a scene of each after the other, twice. */
    ctx = context(directory, "names/together", 2);
    for (int again = 0; again < 2; again++) {
        char grid_name[] = "coarse", layers_name[] = "thick";
        icoray_grid named = coarse;
        icoray_array array;
        named.name = grid_name;
        layers.name = layers_name;
        OK(icoray_grid_set(ctx, &named));
        OK(icoray_layers_set(ctx, &layers));
        OK(icoray_field_set(ctx, "f", &f.array));
        OK(icoray_field_set(ctx, "corner", &corner.array));
        array = g.array;
        array.grid_name = grid_name;
        OK(icoray_field_set(ctx, "g", &array));
        array.layers_name = layers_name;
        OK(icoray_field_set(ctx, "thick g", &array));
        array = f.array;
        array.layers_name = layers_name;
        OK(icoray_field_set(ctx, "thick f", &array));
        {
            icoray_ndarray flat = {.struct_size = sizeof flat, .data = g.array.data, .type = g.array.type, .rank = 2};
            flat.extent[0] = LAYERS, flat.stride[0] = 1;
            flat.extent[1] = coarse.cells, flat.stride[1] = LAYERS;
            flat.grid_name = grid_name;
            OK(icoray_field_set_ndarray(ctx, "flat g", &flat));
        }
        memset(grid_name, 'x', sizeof grid_name - 1);
        memset(layers_name, 'x', sizeof layers_name - 1);
        for (int i = 0; i < (int)COUNT(scenes); i++) {
            scene_of(ctx, scenes[i].field, scenes[i].group, scenes[i].light);
            frame(ctx, 10 * again + 1 + i);
        }
    }
    OK(icoray_close(&ctx));
    OK(icoray_mesh_free(&coarse_mesh));
    release(&f);
    release(&g);
    release(&corner);
}
