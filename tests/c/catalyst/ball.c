#include "ball.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 6 };
static const double heights[MOST] = {0.0, 2e3, 5e3, 10e3, 16e3, 24e3};

static void allocate(ball *to, int columns, int polygons)
{
    to->columns = columns;
    to->polygons = polygons;
    to->polygon = malloc(6 * (size_t)polygons * sizeof *to->polygon);
    to->sides = malloc((size_t)polygons * sizeof *to->sides);
    to->x = malloc(3 * (size_t)columns * sizeof *to->x);
}

enum { SIDE = 10, ROW = SIDE + 1 };

/* The column at a place of the cube's lattice, a little beside its regular place: no four are on one circle. */
static int cube_column(ball *to, int *number, const int at[3])
{
    int *found = number + (at[0] * ROW + at[1]) * ROW + at[2];
    if (*found == 0) {
        double *x = to->x + 3 * to->columns, length = 0.0;
        for (int k = 0; k < 3; k++) {
            double shift = (to->columns * 7919 + k * 104729) % 1000 / 1000.0 - 0.5;
            x[k] = tan(0.785398 * ((2.0 * at[k] + 0.3 * shift) / SIDE - 1.0));
            length += x[k] * x[k];
        }
        for (int k = 0; k < 3; k++) {
            x[k] /= sqrt(length);
        }
        *found = ++to->columns;
    }
    return *found - 1;
}

static void make_cube(ball *to)
{
    int *number = calloc(ROW * ROW * ROW, sizeof *number);
    allocate(to, 6 * ROW * ROW, 6 * SIDE * SIDE);
    to->columns = 0;
    for (int i = 0; i < to->polygons; i++) {
        int face = i / (SIDE * SIDE), u = i % SIDE, v = i / SIDE % SIDE;
        to->sides[i] = 4;
        for (int k = 0; k < 4; k++) {
            int at[3];
            at[face % 3] = face / 3 * SIDE;
            at[(face + 1) % 3] = u + (k == 1 || k == 2);
            at[(face + 2) % 3] = v + k / 2;
            to->polygon[6 * i + k] = cube_column(to, number, at);
        }
    }
    free(number);
}

static ball make_icosahedral(int is_wedges)
{
    ball to = {0};
    icoray_mesh *mesh = NULL;
    icoray_grid of = {sizeof of};
    if (icoray_mesh_create(3, &mesh) || icoray_mesh_grid(mesh, &of)) {
        abort();
    }
    allocate(&to, (int)(is_wedges ? of.cells : of.corners), (int)(is_wedges ? of.corners : of.cells));
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

ball ball_make(const char *shape)
{
    static const char *const names[] = {"wedges", "prisms", "hexes", "points"};
    ball to = {0};
    int found = 0;
    while (strcmp(names[found], shape) != 0) {
        found++;
    }
    if (found == HEXES) {
        make_cube(&to);
    } else {
        to = make_icosahedral(found != PRISMS);
    }
    to.shape = (ball_shape)found;
    to.layers = LEVELS > 1 && found != POINTS ? LEVELS - 1 : LEVELS;
    for (int i = 0; found == POINTS && i < to.columns; i++) {
        to.polygon[6 * i] = i;
        to.sides[i] = 1;
        to.polygons = to.columns;
    }
    return to;
}

double ball_radius(const ball *of, int column, int level, int has_hills)
{
    const double *x = of->x + 3 * column;
    double hill = has_hills ? 900.0 * (1.0 + sin(3.0 * x[0]) * x[1]) : 0.0, z = heights[level];
    return 6.371229e6 + 40.0 * (z + hill * (1.0 - z / heights[MOST - 1]));
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
    if (of->sides[polygon] == 1) {
        memcpy(x, a, 3 * sizeof *x);
    }
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
