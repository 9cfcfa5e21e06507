#include "ball.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double heights[LEVELS] = {0.0, 2e3, 5e3, 10e3, 16e3, 24e3};

ball ball_make(int is_wedges)
{
    ball to = {0};
    icoray_mesh *mesh = NULL;
    icoray_grid of = {sizeof of};
    if (icoray_mesh_create(3, &mesh) || icoray_mesh_grid(mesh, &of)) {
        abort();
    }
    to.is_wedges = is_wedges;
    to.columns = (int)(is_wedges ? of.cells : of.corners);
    to.polygons = (int)(is_wedges ? of.corners : of.cells);
    to.polygon = malloc(6 * (size_t)to.polygons * sizeof *to.polygon);
    to.sides = malloc((size_t)to.polygons * sizeof *to.sides);
    to.x = malloc(3 * (size_t)to.columns * sizeof *to.x);
    const double *lon = is_wedges ? of.lon_center_rad : of.lon_corner_rad;
    const double *lat = is_wedges ? of.lat_center_rad : of.lat_corner_rad;
    for (int i = 0; i < to.columns; i++) {
        to.x[3 * i] = cos(lat[i]) * cos(lon[i]);
        to.x[3 * i + 1] = cos(lat[i]) * sin(lon[i]);
        to.x[3 * i + 2] = sin(lat[i]);
    }
    const int32_t *rows = is_wedges ? of.corner_cell : of.cell_corner;
    int row = is_wedges ? 3 : (int)of.cell_corner_row;
    for (int i = 0; i < to.polygons; i++) {
        to.sides[i] = 0;
        for (int k = 0; k < row; k++) {
            int is_new = 1, node = rows[row * i + k];
            for (int j = 0; j < to.sides[i]; j++) {
                is_new &= to.polygon[6 * i + j] != node;
            }
            if (is_new && node >= 0) {
                to.polygon[6 * i + to.sides[i]++] = node;
            }
        }
    }
    icoray_mesh_free(&mesh);
    return to;
}

double ball_radius(const ball *of, int column, int level, int has_hills)
{
    const double *x = of->x + 3 * column;
    double hill = has_hills ? 900.0 * (1.0 + sin(3.0 * x[0]) * x[1]) : 0.0, z = heights[level];
    return 6.371229e6 + 40.0 * (z + hill * (1.0 - z / heights[LEVELS - 1]));
}

static double value(const double x[3], double level, int step, int kind)
{
    return sin(3.0 * x[0] + 0.4 * step) * cos((2.0 + kind) * x[1]) + 0.5 * x[2] + 0.15 * level;
}

double ball_at_point(const ball *of, int column, int level, int step)
{
    return value(of->x + 3 * column, level, step, 0);
}

double ball_at_element(const ball *of, int polygon, int layer, int step)
{
    double x[3];
    ball_middle(of, polygon, x);
    return value(x, layer, step, 1);
}

void ball_middle(const ball *of, int polygon, double x[3])
{
    const double *a = of->x + 3 * of->polygon[6 * polygon];
    memset(x, 0, 3 * sizeof *x);
    for (int k = 1; k + 1 < of->sides[polygon]; k++) {
        const double *b = of->x + 3 * of->polygon[6 * polygon + k], *c = of->x + 3 * of->polygon[6 * polygon + k + 1];
        double n[3], u[3], v[3];
        for (int i = 0; i < 3; i++) {
            u[i] = b[i] - a[i];
            v[i] = c[i] - a[i];
        }
        for (int i = 0; i < 3; i++) {
            n[i] = u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3];
        }
        double area = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (int i = 0; i < 3; i++) {
            x[i] += area * (a[i] + b[i] + c[i]);
        }
    }
    double length = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
    for (int i = 0; i < 3; i++) {
        x[i] /= length;
    }
}

int ball_owner(const ball *of, int polygon, int ranks)
{
    double x[3];
    ball_middle(of, polygon, x);
    int strip = (int)((atan2(x[1], x[0]) + 7.0) * 1.7) + (x[2] > 0.3);
    return (strip + (polygon % 11 == 3)) % ranks;
}
