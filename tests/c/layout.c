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
    MEMBER(icoray_config, existing);
    MEMBER(icoray_config, on_error);
    MEMBER(icoray_config, disable_after);
    MEMBER(icoray_config, async_render);
    MEMBER(icoray_config, writer_queue);
    MEMBER(icoray_config, when_full);
    MEMBER(icoray_config, log_level);
    MEMBER(icoray_config, log);
    MEMBER(icoray_config, log_user);

    STRUCT(icoray_grid);
    MEMBER(icoray_grid, struct_size);
    MEMBER(icoray_grid, cells);
    MEMBER(icoray_grid, corners);
    MEMBER(icoray_grid, edges);
    MEMBER(icoray_grid, index_base);
    MEMBER(icoray_grid, real_type);
    MEMBER(icoray_grid, index_type);
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
    MEMBER(icoray_grid, name);

    STRUCT(icoray_part);
    MEMBER(icoray_part, struct_size);
    MEMBER(icoray_part, grid);
    MEMBER(icoray_part, cells);
    MEMBER(icoray_part, index_type);
    MEMBER(icoray_part, cell_global);
    MEMBER(icoray_part, owned_cells);
    MEMBER(icoray_part, is_owned);

    STRUCT(icoray_layers);
    MEMBER(icoray_layers, struct_size);
    MEMBER(icoray_layers, count);
    MEMBER(icoray_layers, radius_m);
    MEMBER(icoray_layers, planet_radius_m);
    MEMBER(icoray_layers, name);

    STRUCT(icoray_array);
    MEMBER(icoray_array, struct_size);
    MEMBER(icoray_array, data);
    MEMBER(icoray_array, type);
    MEMBER(icoray_array, location);
    MEMBER(icoray_array, columns);
    MEMBER(icoray_array, layers);
    MEMBER(icoray_array, column_stride);
    MEMBER(icoray_array, layer_stride);
    MEMBER(icoray_array, block);
    MEMBER(icoray_array, block_stride);
    MEMBER(icoray_array, has_fill);
    MEMBER(icoray_array, fill_value);
    MEMBER(icoray_array, grid_name);
    MEMBER(icoray_array, layers_name);

    STRUCT(icoray_ndarray);
    MEMBER(icoray_ndarray, struct_size);
    MEMBER(icoray_ndarray, data);
    MEMBER(icoray_ndarray, type);
    MEMBER(icoray_ndarray, location);
    MEMBER(icoray_ndarray, rank);
    MEMBER(icoray_ndarray, has_fill);
    MEMBER(icoray_ndarray, fill_value);
    MEMBER(icoray_ndarray, extent);
    MEMBER(icoray_ndarray, stride);
    MEMBER(icoray_ndarray, grid_name);
    MEMBER(icoray_ndarray, layers_name);

    STRUCT(icoray_frame_report);
    MEMBER(icoray_frame_report, struct_size);
    MEMBER(icoray_frame_report, step);
    MEMBER(icoray_frame_report, time_s);
    MEMBER(icoray_frame_report, host_s);
    MEMBER(icoray_frame_report, waited_s);
    MEMBER(icoray_frame_report, copy_s);
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
    MEMBER(icoray_frame_report, bytes_copied);
    MEMBER(icoray_frame_report, bytes_derived);
    MEMBER(icoray_frame_report, bytes_peak);
    MEMBER(icoray_frame_report, error_max);
    MEMBER(icoray_frame_report, error_mean);
    MEMBER(icoray_frame_report, error_p999);
    MEMBER(icoray_frame_report, tolerance);
    MEMBER(icoray_frame_report, error_is_bound);
    MEMBER(icoray_frame_report, pixel_step);
    MEMBER(icoray_frame_report, lights);
    MEMBER(icoray_frame_report, threads);
    MEMBER(icoray_frame_report, frames_written);
    MEMBER(icoray_frame_report, frames_failed);
    MEMBER(icoray_frame_report, frames_dropped);
    MEMBER(icoray_frame_report, host_total_s);
    MEMBER(icoray_frame_report, write_total_s);
    MEMBER(icoray_frame_report, ranks);
    MEMBER(icoray_frame_report, tiles);
    MEMBER(icoray_frame_report, gather_s);
    MEMBER(icoray_frame_report, balance);
    MEMBER(icoray_frame_report, bytes_received);
    MEMBER(icoray_frame_report, scheme);
    MEMBER(icoray_frame_report, fragments);
    MEMBER(icoray_frame_report, fragment_bytes);
    MEMBER(icoray_frame_report, compose_s);
    MEMBER(icoray_frame_report, drawn_on);
    MEMBER(icoray_frame_report, upload_s);
    MEMBER(icoray_frame_report, device_s);
    MEMBER(icoray_frame_report, bytes_uploaded);
    MEMBER(icoray_frame_report, frames);
    MEMBER(icoray_frame_report, edge_pixels);
    MEMBER(icoray_frame_report, pixels_over_tolerance);

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
    NUMBER(ICORAY_ERR_EXISTS);
    NUMBER(ICORAY_ERR_DISABLED);
    NUMBER(ICORAY_ERR_BUSY);
    NUMBER(ICORAY_ERR_FORKED);
    NUMBER(ICORAY_ERR_MPI);
    NUMBER(ICORAY_F32);
    NUMBER(ICORAY_F64);
    NUMBER(ICORAY_I32);
    NUMBER(ICORAY_I64);
    NUMBER(ICORAY_CENTER);
    NUMBER(ICORAY_CORNER);
    NUMBER(ICORAY_ALONE);
    NUMBER(ICORAY_TILES);
    NUMBER(ICORAY_FRAGMENTS);
    NUMBER(ICORAY_CPU);
    NUMBER(ICORAY_GPU);
    NUMBER(ICORAY_GPU_AND_CPU);
    NUMBER(ICORAY_NEVER_MODIFY);
    NUMBER(ICORAY_OVERWRITE);
    NUMBER(ICORAY_WARN);
    NUMBER(ICORAY_IGNORE);
    NUMBER(ICORAY_DISABLE);
    NUMBER(ICORAY_BLOCK);
    NUMBER(ICORAY_DROP_OLDEST);
    NUMBER(ICORAY_LOG_OFF);
    NUMBER(ICORAY_LOG_ERROR);
    NUMBER(ICORAY_LOG_WARN);
    NUMBER(ICORAY_LOG_INFO);
    NUMBER(ICORAY_LOG_DEBUG);
    NUMBER(ICORAY_MAX_RANK);
    return 0;
}
