/* Parts of a grid that are refused on a context of one process, which owns every cell. */
#include "refusals.h"

void grid_parts(icoray_ctx *ctx)
{
#define IN(name) offsetof(icoray_part, name), sizeof(((icoray_part *)0)->name)
    static int32_t global[42], marks[42], corner[80];
    static const char *const unknown = "no such grid", *const no_utf8 = NO_UTF8;
    static const void *const none = NULL, *const some = global;
    static const char *const aside = (const char *)global + 1;
    static const int64_t minus_one = -1, one_fewer = 41, one_more = 43, huge = INT64_MAX;
    static const int32_t no_type = 0, a_real = ICORAY_F32;
    static const struct {
        size_t offset, size;
        const void *value;
        icoray_status status;
        const char *part;
    } cases[] = {
        {IN(grid), &unknown, ICORAY_ERR_ARGUMENT, "no grid named \"no such grid\""},
        {IN(grid), &no_utf8, ICORAY_ERR_ARGUMENT, "icoray_part.grid"},
        {IN(cells), &minus_one, ICORAY_ERR_ARGUMENT, "icoray_part.cells: -1"},
        {IN(cells), &huge, ICORAY_ERR_ARGUMENT, "icoray_part.cells: 9"},
        {IN(cells), &one_fewer, ICORAY_ERR_GRID, "41 rows, expected 42"},
        {IN(index_type), &no_type, ICORAY_ERR_ARGUMENT, "icoray_part.index_type: 0, expected ICORAY_I32"},
        {IN(index_type), &a_real, ICORAY_ERR_ARGUMENT, "icoray_part.index_type: 1, expected ICORAY_I32"},
        {IN(cell_global), &none, ICORAY_ERR_NULL, "icoray_part.cell_global is NULL"},
        {IN(cell_global), &aside, ICORAY_ERR_ARGUMENT, "icoray_part.cell_global"},
        {IN(owned_cells), &minus_one, ICORAY_ERR_ARGUMENT, "icoray_part.owned_cells: -1"},
        {IN(owned_cells), &one_more, ICORAY_ERR_GRID, "43 own cells, expected at most 42"},
        {IN(owned_cells), &one_fewer, ICORAY_ERR_GRID, "owned by no rank"},
        {IN(is_owned), &aside, ICORAY_ERR_ARGUMENT, "icoray_part.is_owned"},
        {IN(corners), &minus_one, ICORAY_ERR_ARGUMENT, "icoray_part.corners: -1"},
        {IN(corners), &one_more, ICORAY_ERR_NULL, "icoray_part.corner_global is NULL"},
        {IN(corner_global), &some, ICORAY_ERR_GRID, "corner_global: 0 rows, expected 80, one per corner"},
    };
#undef IN
    icoray_part good = {sizeof good}, part;
    icoray_grid no_cells = {sizeof no_cells};
    icoray_ctx *fresh = opened();
    good.cells = good.owned_cells = COUNT(global);
    good.index_type = ICORAY_I32;
    good.cell_global = global;
    for (int32_t i = 0; i < (int32_t)COUNT(global); i++) {
        global[i] = 5 * i;
        marks[i] = 1;
    }
    trying = "parts";
    REFUSED(NULL, NULL, "ctx", icoray_part_set(NULL, &good));
    REFUSED(ctx, NULL, "icoray_part", icoray_part_set(ctx, NULL));
    REFUSED(ctx, ARGUMENT, "not aligned", icoray_part_set(ctx, (icoray_part *)(void *)((char *)&part + 1)));
    part = good;
    part.struct_size--;
    REFUSED(ctx, STRUCT_SIZE, "icoray_part.struct_size", icoray_part_set(ctx, &part));
    REFUSED(fresh, ORDER, "icoray_grid_set", icoray_part_set(fresh, &good));
    OK(icoray_close(&fresh));
    for (size_t i = 0; i < COUNT(cases); i++) {
        trying = cases[i].part;
        part = good;
        memcpy((char *)&part + cases[i].offset, cases[i].value, cases[i].size);
        REFUSED_AS(ctx, cases[i].status, cases[i].part, icoray_part_set(ctx, &part));
    }
    trying = "marks";
    part = good;
    part.is_owned = marks;
    part.owned_cells = -1; /* not read */
    OK(icoray_part_set(ctx, &part));
    still_draws(ctx);
    marks[7] = 0;
    REFUSED(ctx, GRID, "cell 35 is in the halo of rank 0, but owned by no rank", icoray_part_set(ctx, &part));
    global[9] = global[4];
    REFUSED(ctx, GRID, "rows 4 and 9: both 20", icoray_part_set(ctx, &good));
    global[9] = -1;
    REFUSED(ctx, GRID, "row 9: -1, expected 0 or more", icoray_part_set(ctx, &good));

    trying = "corners of a part";
    for (int32_t i = 0; i < (int32_t)COUNT(global); i++) {
        global[i] = i;
    }
    for (int32_t i = 0; i < (int32_t)COUNT(corner); i++) {
        corner[i] = i;
    }
    part = good;
    part.corners = part.owned_corners = COUNT(corner);
    part.corner_global = corner;
    OK(icoray_part_set(ctx, &part));
    still_draws(ctx);
    part.owned_corners = COUNT(corner) + 1;
    REFUSED(ctx, GRID, "81 own corners, expected at most 80", icoray_part_set(ctx, &part));
    part.owned_corners = -1;
    REFUSED(ctx, ARGUMENT, "icoray_part.owned_corners: -1", icoray_part_set(ctx, &part));
    part.owned_corners = 79;
    REFUSED(ctx, GRID, "corner 79 is owned by no rank", icoray_part_set(ctx, &part));
    part.is_corner_owned = (const int32_t *)(const void *)aside;
    REFUSED(ctx, ARGUMENT, "icoray_part.is_corner_owned", icoray_part_set(ctx, &part));
    part.is_corner_owned = corner; /* but for the first */
    REFUSED(ctx, GRID, "corner 0 is owned by no rank", icoray_part_set(ctx, &part));
    part.is_corner_owned = NULL;
    part.owned_corners = COUNT(corner);
    corner[7] = 80;
    REFUSED(ctx, GRID, "corner_global row 7: 80, expected 7", icoray_part_set(ctx, &part));
    part.corner_global = aside;
    REFUSED(ctx, ARGUMENT, "icoray_part.corner_global", icoray_part_set(ctx, &part));

    /* Only one of several ranks can be without cells. */
    trying = "no cells";
    no_cells.real_type = ICORAY_F32;
    no_cells.index_type = ICORAY_I64;
    no_cells.cell_corner_row = 6;
    REFUSED(ctx, GRID, "0 cells, expected at least 1", icoray_grid_set(ctx, &no_cells));
}
