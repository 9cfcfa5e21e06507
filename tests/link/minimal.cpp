// A picture from C++: the header is plain C++11, and a context closes with its owner.
#include <icoray.h>

#include <cmath>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

static void check(icoray_ctx *ctx, icoray_status status)
{
    if (status != ICORAY_OK) {
        std::string message(1024, '\0');
        icoray_last_error(ctx, &message[0], message.size());
        throw std::runtime_error(message.c_str());
    }
}

template <class T> T sized()
{
    T all_zero = T();
    all_zero.struct_size = sizeof(T);
    return all_zero;
}

static void draw()
{
    icoray_mesh *made = nullptr;
    check(nullptr, icoray_mesh_create(3, &made));
    std::unique_ptr<icoray_mesh, void (*)(icoray_mesh *)> mesh(made, [](icoray_mesh *m) { icoray_mesh_free(&m); });
    icoray_grid grid = sized<icoray_grid>();
    check(nullptr, icoray_mesh_grid(mesh.get(), &grid));
    const double *lat = static_cast<const double *>(grid.lat_center_rad);
    std::vector<float> field(static_cast<size_t>(grid.cells));
    for (size_t i = 0; i < field.size(); i++) {
        field[i] = static_cast<float>(std::sin(lat[i]));
    }
    const double radius[2] = {6.4e6, 6.9e6};

    icoray_config config = sized<icoray_config>();
    icoray_layers layers = sized<icoray_layers>();
    layers.count = 2;
    layers.radius_m = radius;
    layers.planet_radius_m = 6.4e6;
    icoray_array array = sized<icoray_array>();
    array.data = field.data();
    array.type = ICORAY_F32;
    array.columns = grid.cells;
    array.layers = 2; /* the same values twice: a stride of 0 */
    array.column_stride = 1;
    icoray_ctx *opened = nullptr;
    check(nullptr, icoray_open_serial(&config, &opened));
    std::unique_ptr<icoray_ctx, void (*)(icoray_ctx *)> ctx(opened, [](icoray_ctx *c) { icoray_close(&c); });
    check(opened, icoray_grid_set(opened, &grid));
    check(opened, icoray_layers_set(opened, &layers));
    check(opened, icoray_field_set(opened, "q", &array));
    check(opened, icoray_scene_text(opened, "field = 'q'\n"
                                            "image = { width = 64, height = 64 }\n"
                                            "camera = { lon = 0, lat = 30, distance = 4, fov = 40 }\n"
                                            "transfer = { unit_length = 0.1, knots = [\n"
                                            "    { value = -1, color = '#0000ff', opacity = 0.5 },\n"
                                            "    { value = 1, color = '#ff0000', opacity = 0.5 }] }\n"
                                            "output = { file = 'cpp_{step:04}.png' }\n"));
    check(opened, icoray_execute(opened, 0, 0.0, nullptr));
}

int main()
{
    try {
        draw();
        return 0;
    } catch (const std::exception &error) {
        std::cerr << error.what() << "\n";
        return 1;
    }
}
