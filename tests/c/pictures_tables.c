/* Grids as models have them in memory. */
#include "pictures.h"

/* The tables as other models have them: from 1, longer rows with counts; and with coordinates in floats. */
void tables(const char *directory)
{
    enum { ROW = 8 };
    icoray_ctx *ctx = context(directory, "tables", 2);
    int32_t *cell_corner = allocate((size_t)cells * ROW, sizeof(int32_t));
    int32_t *count = allocate((size_t)cells, sizeof(int32_t));
    int32_t *corner_cell = allocate((size_t)corners * 3, sizeof(int32_t));
    int32_t *corner_edge = allocate((size_t)corners * 3, sizeof(int32_t));
    int32_t *edge_corner = allocate((size_t)grid.edges * 2, sizeof(int32_t));
    float *position = allocate((size_t)(cells + corners) * 2, sizeof(float));
    const double *from[4];
    float *to[4];
    int rows[4];
    icoray_grid other = grid;
    for (int c = 0; c < cells; c++) {
        const int32_t *row = grid.cell_corner + 6 * c;
        for (int i = 0; i < ROW; i++) {
            cell_corner[ROW * c + i] = -99; /* never read */
        }
        for (int i = 0; i < 6; i++) {
            int seen = 0;
            for (int j = 0; j < i; j++) {
                seen |= row[j] == row[i];
            }
            if (!seen) {
                cell_corner[ROW * c + count[c]++] = row[i] + 1;
            }
        }
        CHECK(count[c] == 5 || count[c] == 6);
    }
    for (int i = 0; i < 3 * corners; i++) {
        corner_cell[i] = grid.corner_cell[i] + 1;
        corner_edge[i] = grid.corner_edge[i] + 1;
    }
    for (int i = 0; i < 2 * (int)grid.edges; i++) {
        edge_corner[i] = grid.edge_corner[i] + 1;
    }
    other.index_base = 1;
    other.cell_corner = cell_corner;
    other.cell_corner_row = ROW;
    other.cell_corner_count = count;
    other.corner_cell = corner_cell;
    other.corner_edge = corner_edge;
    other.edge_corner = edge_corner;
    OK(icoray_grid_set(ctx, &other));
    Field f = field(ICORAY_F32, ICORAY_CENTER, LAYERS, (size_t)cells * LAYERS, 0, LAYERS, 1);
    Field corner = field(ICORAY_F32, ICORAY_CORNER, LAYERS, (size_t)corners * LAYERS, 0, LAYERS, 1);
    scene(ctx, "plain", "none");
    frame_of(ctx, 1, &f);
    scene(ctx, "lit", "headlight");
    frame_of(ctx, 2, &f);
    scene(ctx, "corner", "none");
    frame_of(ctx, 3, &corner);

    from[0] = grid.lon_center_rad, from[1] = grid.lat_center_rad, rows[0] = rows[1] = cells;
    from[2] = grid.lon_corner_rad, from[3] = grid.lat_corner_rad, rows[2] = rows[3] = corners;
    to[0] = position, to[1] = to[0] + cells, to[2] = to[1] + cells, to[3] = to[2] + corners;
    for (int k = 0; k < 4; k++) {
        for (int i = 0; i < rows[k]; i++) {
            to[k][i] = (float)from[k][i];
        }
    }
    other = grid;
    other.real_type = ICORAY_F32;
    other.lon_center_rad = to[0], other.lat_center_rad = to[1];
    other.lon_corner_rad = to[2], other.lat_corner_rad = to[3];
    OK(icoray_grid_set(ctx, &other));
    scene(ctx, "near plain", "none");
    frame_of(ctx, 4, &f);

    OK(icoray_close(&ctx));
    free(cell_corner);
    free(count);
    free(corner_cell);
    free(corner_edge);
    free(edge_corner);
    free(position);
    release(&f);
    release(&corner);
}
