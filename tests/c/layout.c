/* Prints sizes, offsets and numbers of the ABI as this compiler sees them. C99 and C++ alike. */
#include <icoray.h>

#include <stddef.h>
#include <stdio.h>

#define STRUCT(name) printf(#name " %d\n", (int)sizeof(name))
#define MEMBER(name, member) printf(#name "." #member " %d\n", (int)offsetof(name, member))
#define NUMBER(name) printf(#name " %d\n", (int)(name))

int main(void)
{
    printf("version %s\n", icoray_version());

    STRUCT(icoray_config);
    MEMBER(icoray_config, struct_size);
    MEMBER(icoray_config, output_dir);
    MEMBER(icoray_config, threads);

    STRUCT(icoray_grid);
    MEMBER(icoray_grid, struct_size);
    MEMBER(icoray_grid, cells);
    MEMBER(icoray_grid, corners);
    MEMBER(icoray_grid, edges);
    MEMBER(icoray_grid, index_base);
    MEMBER(icoray_grid, real_type);
    MEMBER(icoray_grid, lon_center_rad);
    MEMBER(icoray_grid, lat_center_rad);
    MEMBER(icoray_grid, lon_corner_rad);
    MEMBER(icoray_grid, lat_corner_rad);
    MEMBER(icoray_grid, cell_corner);
    MEMBER(icoray_grid, cell_corner_row);
    MEMBER(icoray_grid, cell_corner_count);
    MEMBER(icoray_grid, corner_cell);
    MEMBER(icoray_grid, corner_edge);
    MEMBER(icoray_grid, edge_corner);

    STRUCT(icoray_layers);
    MEMBER(icoray_layers, struct_size);
    MEMBER(icoray_layers, count);
    MEMBER(icoray_layers, radius_m);
    MEMBER(icoray_layers, planet_radius_m);

    STRUCT(icoray_array);
    MEMBER(icoray_array, struct_size);
    MEMBER(icoray_array, data);
    MEMBER(icoray_array, type);
    MEMBER(icoray_array, location);
    MEMBER(icoray_array, columns);
    MEMBER(icoray_array, layers);
    MEMBER(icoray_array, column_stride);
    MEMBER(icoray_array, layer_stride);
    MEMBER(icoray_array, has_fill);
    MEMBER(icoray_array, fill_value);

    STRUCT(icoray_frame_report);
    MEMBER(icoray_frame_report, struct_size);
    MEMBER(icoray_frame_report, step);
    MEMBER(icoray_frame_report, time_s);
    MEMBER(icoray_frame_report, prepare_s);
    MEMBER(icoray_frame_report, render_s);
    MEMBER(icoray_frame_report, write_s);
    MEMBER(icoray_frame_report, rays);
    MEMBER(icoray_frame_report, columns);
    MEMBER(icoray_frame_report, frusta);
    MEMBER(icoray_frame_report, void_frusta);
    MEMBER(icoray_frame_report, value_min);
    MEMBER(icoray_frame_report, value_max);
    MEMBER(icoray_frame_report, missing_values);
    MEMBER(icoray_frame_report, bytes_derived);
    MEMBER(icoray_frame_report, error_max);
    MEMBER(icoray_frame_report, error_mean);
    MEMBER(icoray_frame_report, error_p999);
    MEMBER(icoray_frame_report, tolerance);
    MEMBER(icoray_frame_report, error_is_bound);
    MEMBER(icoray_frame_report, pixel_step);
    MEMBER(icoray_frame_report, lights);

    STRUCT(icoray_status);
    NUMBER(ICORAY_OK);
    NUMBER(ICORAY_ERR_NULL);
    NUMBER(ICORAY_ERR_STRUCT_SIZE);
    NUMBER(ICORAY_ERR_ARGUMENT);
    NUMBER(ICORAY_ERR_GRID);
    NUMBER(ICORAY_ERR_UNSUPPORTED);
    NUMBER(ICORAY_ERR_LAYERS);
    NUMBER(ICORAY_ERR_FIELD);
    NUMBER(ICORAY_ERR_SCENE);
    NUMBER(ICORAY_ERR_ORDER);
    NUMBER(ICORAY_ERR_IO);
    NUMBER(ICORAY_ERR_INTERNAL);
    NUMBER(ICORAY_F32);
    NUMBER(ICORAY_F64);
    NUMBER(ICORAY_CENTER);
    NUMBER(ICORAY_CORNER);
    return 0;
}
