/*
 * tracer: a small transport model that draws itself with icoray while it runs.
 *
 * Two bells of a passive tracer are carried by the prescribed three-dimensional deformational flow of DCMIP test 1-1
 * (Kent, Ullrich and Jablonowski 2014, doi:10.1002/qj.2208). The flow reverses half way, so that after 12 days the
 * exact solution is the initial field and the error can be measured.
 *
 * Discretisation: finite volumes on the prisms over the Voronoi cells of an icosahedral grid. The fluxes of air are
 * non-divergent to rounding, so a constant mixing ratio stays constant. The tracer takes one MUSCL-Hancock step (van
 * Leer 1984) with slope limiters at a time, second order in space and time.
 *
 *   cc -std=c99 -O2 -o tracer tracer.c -licoray -lm
 *
 * All that a model adds in order to be drawn stands under "what a model adds", further down.
 */
#define _POSIX_C_SOURCE 199309L /* clock_gettime */

#include <icoray.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define PI 3.14159265358979323846
#define DAY 86400.0               /* s */
#define RADIUS 6371220.0          /* of the planet, m */
#define GRAVITY 9.80616           /* m s-2 */
#define SCALE_HEIGHT (287.0 * 300.0 / GRAVITY) /* of an isothermal atmosphere, m */
#define SURFACE_PRESSURE 100000.0 /* Pa */
#define MODEL_TOP 12000.0         /* m */
#define PERIOD (12.0 * DAY)
#define ROTATION (2.0 * PI * RADIUS / PERIOD) /* wind speeds, m s-1 */
#define DEFORMATION (10.0 * RADIUS / PERIOD)
#define OMEGA (23000.0 * PI / PERIOD) /* largest pressure velocity, Pa s-1 */
#define MAX_COURANT 0.6           /* of the default time step */
#define SIDES 6                   /* of a cell; a pentagon's last neighbour is itself, with no weight */

/* ---- the mesh ---- */

/* A point of the unit sphere, with the sines and cosines that winds are made of. */
typedef struct {
    double xyz[3];
    double sin_lon, cos_lon, sin_lat, cos_lat;
} Place;

/* The side between two cells. Air that flows from cell[0] to cell[1] counts as positive. */
typedef struct {
    int cell[2];
    int corner[2];       /* corner[0] on the right of that direction */
    double offset[2][2]; /* from each cell's centroid to the middle of the side, east and north, m */
    double length_east;  /* length times the eastward component of the normal, m */
    Place middle;
} Side;

typedef struct {
    int count; /* of sides */
    int neighbour[SIDES];
    double weight[SIDES][2]; /* of neighbour minus own value in the least-squares gradient, m-1 */
    double offset[SIDES][2]; /* from the centroid to the middle of each side, m */
    double area;             /* m2 */
    Place centroid;
} Cell;

typedef struct {
    int cells, corners, sides, layers;
    Cell *cell;
    Place *corner;
    Side *side;
    double shortest; /* distance between neighbours, m */
    double *radius;  /* of each layer's middle, from the planet's centre, m */
} Mesh;

static void *allocate(int rows, int row, size_t size)
{
    void *memory = calloc((size_t)rows * (size_t)row, size);
    if (memory == NULL) {
        fprintf(stderr, "tracer: out of memory\n");
        exit(EXIT_FAILURE);
    }
    return memory;
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* Angle between two unit vectors, accurate for small ones. */
static double angle(const double a[3], const double b[3])
{
    double normal[3];
    cross(a, b, normal);
    return atan2(sqrt(dot(normal, normal)), dot(a, b));
}

/* Area of a triangle on the unit sphere (van Oosterom and Strackee 1983). */
static double triangle_area(const double a[3], const double b[3], const double c[3])
{
    double normal[3];
    cross(a, b, normal);
    return 2.0 * atan2(fabs(dot(normal, c)), 1.0 + dot(a, b) + dot(b, c) + dot(c, a));
}

static Place place_at(double lon, double lat)
{
    Place p = {{cos(lat) * cos(lon), cos(lat) * sin(lon), sin(lat)}, sin(lon), cos(lon), sin(lat), cos(lat)};
    return p;
}

/* The place in the direction of a vector of any length. */
static Place place_along(const double v[3])
{
    return place_at(atan2(v[1], v[0]), atan2(v[2], hypot(v[0], v[1])));
}

/* The offset from one place to another in the tangent plane of the first, east and north, m. */
static void offset_between(const Place *from, const Place *to, double out[2])
{
    double east[3] = {-from->sin_lon, from->cos_lon, 0.0}, north[3];
    cross(from->xyz, east, north);
    out[0] = RADIUS * dot(to->xyz, east);
    out[1] = RADIUS * dot(to->xyz, north);
}

/* The two cells on the sides of an edge are those that its two corners share, whatever the order of the tables. */
static void shared_cells(const icoray_grid *grid, const int corner[2], int out[2])
{
    int found = 0;
    for (int i = 0; i < 9; i++) {
        int cell = grid->corner_cell[3 * corner[0] + i / 3];
        if (cell == grid->corner_cell[3 * corner[1] + i % 3] && found < 2) {
            out[found++] = cell - grid->index_base;
        }
    }
    if (found != 2) {
        fprintf(stderr, "tracer: an edge without two cells\n");
        exit(EXIT_FAILURE);
    }
}

/* Joins the tables into sides; adds up the area and centroid of each cell, triangle by triangle. */
static void build_sides(Mesh *mesh, const icoray_grid *grid)
{
    const double *lon = grid->lon_center_rad, *lat = grid->lat_center_rad;
    double *moment = allocate(mesh->cells, 3, sizeof *moment);
    for (int e = 0; e < mesh->sides; e++) {
        Side *side = &mesh->side[e];
        double sum[3], along[3], normal[3], ahead = 0.0;
        side->corner[0] = grid->edge_corner[2 * e] - grid->index_base;
        side->corner[1] = grid->edge_corner[2 * e + 1] - grid->index_base;
        shared_cells(grid, side->corner, side->cell);
        const double *a = mesh->corner[side->corner[0]].xyz, *b = mesh->corner[side->corner[1]].xyz;
        for (int i = 0; i < 3; i++) {
            sum[i] = a[i] + b[i];
            along[i] = b[i] - a[i];
        }
        side->middle = place_along(sum);
        cross(along, side->middle.xyz, normal);
        for (int s = 0; s < 2; s++) {
            int c = side->cell[s];
            Place centre = place_at(lon[c], lat[c]);
            double area = triangle_area(centre.xyz, a, b);
            mesh->cell[c].area += area * RADIUS * RADIUS;
            for (int i = 0; i < 3; i++) {
                moment[3 * c + i] += area * (centre.xyz[i] + sum[i]) / 3.0;
            }
            ahead += (s == 0 ? -1.0 : 1.0) * dot(normal, centre.xyz);
        }
        double east = normal[1] * side->middle.cos_lon - normal[0] * side->middle.sin_lon;
        side->length_east = RADIUS * angle(a, b) * east / sqrt(dot(along, along));
        if (ahead < 0.0) { /* the normal must point from cell[0] to cell[1] */
            int swap = side->cell[0];
            side->cell[0] = side->cell[1];
            side->cell[1] = swap;
        }
    }
    for (int c = 0; c < mesh->cells; c++) {
        mesh->cell[c].centroid = place_along(moment + 3 * c);
    }
    free(moment);
}

/* Lists the neighbours of each cell, with the weights of its least-squares gradient. */
static void build_cells(Mesh *mesh)
{
    for (int i = 0; i < 2 * mesh->sides; i++) {
        Side *side = &mesh->side[i / 2];
        Cell *cell = &mesh->cell[side->cell[i % 2]];
        int j = cell->count++;
        if (j == SIDES) {
            fprintf(stderr, "tracer: a cell with more than %d sides\n", SIDES);
            exit(EXIT_FAILURE);
        }
        cell->neighbour[j] = side->cell[1 - i % 2];
        offset_between(&cell->centroid, &side->middle, cell->offset[j]);
        offset_between(&cell->centroid, &mesh->cell[cell->neighbour[j]].centroid, cell->weight[j]);
        memcpy(side->offset[i % 2], cell->offset[j], sizeof cell->offset[j]);
    }
    mesh->shortest = RADIUS;
    for (int c = 0; c < mesh->cells; c++) {
        Cell *cell = &mesh->cell[c];
        double xx = 0.0, xy = 0.0, yy = 0.0;
        for (int j = 0; j < cell->count; j++) {
            double x = cell->weight[j][0], y = cell->weight[j][1];
            xx += x * x, xy += x * y, yy += y * y;
            mesh->shortest = fmin(mesh->shortest, hypot(x, y));
        }
        for (int j = 0; j < cell->count; j++) {
            double x = cell->weight[j][0], y = cell->weight[j][1], determinant = xx * yy - xy * xy;
            cell->weight[j][0] = (yy * x - xy * y) / determinant;
            cell->weight[j][1] = (xx * y - xy * x) / determinant;
        }
        for (int j = cell->count; j < SIDES; j++) {
            cell->neighbour[j] = c;
        }
    }
}

static Mesh mesh_new(const icoray_grid *grid, int layers)
{
    Mesh mesh = {(int)grid->cells, (int)grid->corners, (int)grid->edges, layers, NULL, NULL, NULL, 0.0, NULL};
    const double *lon = grid->lon_corner_rad, *lat = grid->lat_corner_rad;
    mesh.cell = allocate(mesh.cells, 1, sizeof *mesh.cell);
    mesh.corner = allocate(mesh.corners, 1, sizeof *mesh.corner);
    mesh.side = allocate(mesh.sides, 1, sizeof *mesh.side);
    mesh.radius = allocate(layers, 1, sizeof *mesh.radius);
    for (int v = 0; v < mesh.corners; v++) {
        mesh.corner[v] = place_at(lon[v], lat[v]);
    }
    build_sides(&mesh, grid);
    build_cells(&mesh);
    for (int k = 0; k < layers; k++) {
        mesh.radius[k] = RADIUS + (k + 0.5) * MODEL_TOP / layers;
    }
    return mesh;
}

static void mesh_free(Mesh *mesh)
{
    free(mesh->cell);
    free(mesh->corner);
    free(mesh->side);
    free(mesh->radius);
}

/* ---- the winds of DCMIP test 1-1 ----
 *
 * Horizontal wind = rotational part (u_a, v), the same in all layers, plus divergent part (u_d, 0), which is a function
 * of place and time times s'(p). So both factor into an array over the sides and a profile over the layers. The
 * pressure velocity is omega = OMEGA s(p) sin(lon') cos(lat) cos(2 pi t / PERIOD) with lon' = lon - 2 pi t / PERIOD. */

typedef struct {
    double sin_turn, cos_turn; /* of 2 pi t / PERIOD */
    double deformation;        /* DEFORMATION cos(pi t / PERIOD), m s-1 */
    double overturning;        /* OMEGA RADIUS cos(2 pi t / PERIOD), Pa m s-1 */
    double *rotational;        /* sides: integral of (u_a, v) across the side, m2 s-1 */
    double *divergent;         /* sides: integral of u_d / s'(p) across the side, Pa m2 s-1 */
    double *divergence;        /* cells: sum of `divergent` outward, Pa m2 s-1 */
    double *shape;             /* layers + 1 interfaces from the bottom up: s(p), zero at bottom and top */
    double *shape_drop;        /* layers: s(p) at the bottom minus at the top */
    double *thickness;         /* layers: pressure at the bottom minus at the top, Pa */
} Winds;

static double sin_moving(const Winds *w, const Place *p) { return p->sin_lon * w->cos_turn - p->cos_lon * w->sin_turn; }
static double cos_moving(const Winds *w, const Place *p) { return p->cos_lon * w->cos_turn + p->sin_lon * w->sin_turn; }

/* psi, m2 s-1: u_a = -1/a d(psi)/d(lat), v = 1/(a cos lat) d(psi)/d(lon). */
static double streamfunction(const Winds *w, const Place *p)
{
    double wave = sin_moving(w, p) * p->cos_lat;
    return RADIUS * (w->deformation * wave * wave - ROTATION * p->sin_lat);
}

/* (u_a, v), m s-1. */
static void rotational_wind(const Winds *w, const Place *p, double out[2])
{
    double wave = 2.0 * w->deformation * sin_moving(w, p) * p->cos_lat;
    out[0] = wave * sin_moving(w, p) * p->sin_lat + ROTATION * p->cos_lat;
    out[1] = wave * cos_moving(w, p);
}

/* u_d / s'(p), Pa m s-1. */
static double divergent_wind(const Winds *w, const Place *p)
{
    return w->overturning * cos_moving(w, p) * p->cos_lat * p->cos_lat;
}

static double pressure_at(double height)
{
    return SURFACE_PRESSURE * exp(-height / SCALE_HEIGHT);
}

/* s(p) = 1 + exp((top - p0) / (b top)) - exp((p - p0) / (b top)) - exp((top - p) / (b top)), b = 0.2. */
static double shape_at(double pressure)
{
    double top = pressure_at(MODEL_TOP), scale = 0.2 * top;
    return 1.0 + exp((top - SURFACE_PRESSURE) / scale) - exp((pressure - SURFACE_PRESSURE) / scale) -
           exp((top - pressure) / scale);
}

static Winds winds_new(const Mesh *mesh)
{
    Winds w = {0};
    int n = mesh->layers;
    w.rotational = allocate(mesh->sides, 1, sizeof(double));
    w.divergent = allocate(mesh->sides, 1, sizeof(double));
    w.divergence = allocate(mesh->cells, 1, sizeof(double));
    w.shape = allocate(n + 1, 1, sizeof(double));
    w.shape_drop = allocate(n, 1, sizeof(double));
    w.thickness = allocate(n, 1, sizeof(double));
    for (int k = 0; k < n; k++) {
        double low = pressure_at(k * MODEL_TOP / n), high = pressure_at((k + 1) * MODEL_TOP / n);
        w.shape[k + 1] = k + 1 < n ? shape_at(high) : 0.0;
        w.shape_drop[k] = w.shape[k] - w.shape[k + 1];
        w.thickness[k] = low - high;
    }
    return w;
}

static void winds_free(Winds *w)
{
    free(w->rotational);
    free(w->divergent);
    free(w->divergence);
    free(w->shape);
    free(w->shape_drop);
    free(w->thickness);
}

/* Fluxes of air at a time. Differences of the streamfunction make the rotational part exactly non-divergent. */
static void winds_set(Winds *w, const Mesh *mesh, double time)
{
    double turn = 2.0 * PI * time / PERIOD;
    w->sin_turn = sin(turn);
    w->cos_turn = cos(turn);
    w->deformation = DEFORMATION * cos(0.5 * turn);
    w->overturning = OMEGA * RADIUS * cos(turn);
    memset(w->divergence, 0, (size_t)mesh->cells * sizeof(double));
    for (int e = 0; e < mesh->sides; e++) {
        const Side *side = &mesh->side[e];
        const Place *right = &mesh->corner[side->corner[0]], *left = &mesh->corner[side->corner[1]];
        w->rotational[e] = streamfunction(w, right) - streamfunction(w, left);
        w->divergent[e] = divergent_wind(w, &side->middle) * side->length_east;
        w->divergence[side->cell[0]] += w->divergent[e];
        w->divergence[side->cell[1]] -= w->divergent[e];
    }
}

/* An upper bound of the horizontal wind speed at all times, m s-1. */
static double winds_bound(const Winds *w, int layers)
{
    double steepest = 0.0;
    for (int k = 0; k < layers; k++) {
        steepest = fmax(steepest, fabs(w->shape_drop[k]) / w->thickness[k]);
    }
    return ROTATION + DEFORMATION + OMEGA * RADIUS * steepest;
}

/* ---- the tracer ---- */

/* Arrays of cells x layers values; layers run fastest, from the bottom up. */
typedef struct {
    double *q;        /* mixing ratio */
    double *initial;  /* mixing ratio at the start */
    double *lifted;   /* q carried up or down for half a step */
    double *half;     /* `lifted` carried horizontally for half a step: values at the middle of the step */
    double *slope[2]; /* limited slopes of `lifted`, east and north, m-1 */
    double *outflow;  /* of tracer through the sides, Pa m2 s-1 */
} State;

/* Two cosine bells: q = sum of (1 + cos(pi d)) / 2, d = min(1, (2 r / RADIUS)^2 + ((z - 5 km) / 1 km)^2). */
static double bells_at(const Place *p, double height)
{
    double sum = 0.0, z = (height - 5000.0) / 1000.0;
    for (int i = 5; i <= 7; i += 2) {
        Place centre = place_at(i * PI / 6.0, 0.0);
        double r = 2.0 * angle(p->xyz, centre.xyz);
        sum += 0.5 * (1.0 + cos(PI * fmin(1.0, r * r + z * z)));
    }
    return sum;
}

static State state_new(const Mesh *mesh)
{
    State s;
    double **array[] = {&s.q, &s.initial, &s.lifted, &s.half, &s.slope[0], &s.slope[1], &s.outflow};
    for (size_t i = 0; i < sizeof array / sizeof *array; i++) {
        *array[i] = allocate(mesh->cells, mesh->layers, sizeof(double));
    }
    for (size_t i = 0, n = (size_t)mesh->layers; i < (size_t)mesh->cells * n; i++) {
        s.initial[i] = s.q[i] = bells_at(&mesh->cell[i / n].centroid, mesh->radius[i % n] - RADIUS);
    }
    return s;
}

static void state_free(State *s)
{
    free(s->q);
    free(s->initial);
    free(s->lifted);
    free(s->half);
    free(s->slope[0]);
    free(s->slope[1]);
    free(s->outflow);
}

/* Change per layer, from the values below, here and above: the monotonized central slope (van Leer 1977). */
static double limited_rise(double below, double here, double above)
{
    double lower = here - below, upper = above - here;
    double steepest = 2.0 * fmin(fabs(lower), fabs(upper)), central = 0.5 * (above - below);
    return lower * upper > 0.0 ? copysign(fmin(steepest, fabs(central)), central) : 0.0;
}

/* Half a step of dq/dt = -w dq/dz in one column. Bottom and top layer have no slope. */
static void lift(const Mesh *mesh, const Winds *w, State *s, int c, double dt)
{
    const size_t n = (size_t)mesh->layers, start = (size_t)c * n;
    const double *q = s->q + start;
    s->lifted[start] = q[0];
    for (size_t k = 1; k + 1 < n; k++) {
        double mass = mesh->cell[c].area * w->thickness[k];
        double layers_per_second = 0.5 * (w->shape[k] + w->shape[k + 1]) * w->divergence[c] / mass;
        s->lifted[start + k] = q[k] - 0.5 * dt * layers_per_second * limited_rise(q[k - 1], q[k], q[k + 1]);
    }
    s->lifted[start + n - 1] = q[n - 1];
}

/* Factor that keeps a linear reconstruction within the neighbours' values (Barth and Jespersen 1989). */
static double limiter(double value, double lowest, double highest, double fall, double rise)
{
    double factor = rise > highest - value ? (highest - value) / rise : 1.0;
    return fall < lowest - value ? fmin(factor, (lowest - value) / fall) : factor;
}

/* Slopes of one column, and half a step of dq/dt = -u dq/dx - v dq/dy with them. */
static void predict(const Mesh *mesh, const Winds *w, State *s, int c, double dt)
{
    const Cell *cell = &mesh->cell[c];
    const size_t n = (size_t)mesh->layers, start = (size_t)c * n;
    const double *q = s->lifted + start, *near[SIDES];
    double wind[2], divergent = divergent_wind(w, &cell->centroid);
    rotational_wind(w, &cell->centroid, wind);
    for (int j = 0; j < SIDES; j++) {
        near[j] = s->lifted + (size_t)cell->neighbour[j] * n;
    }
    for (size_t k = 0; k < n; k++) {
        double x = 0.0, y = 0.0, lowest = q[k], highest = q[k], fall = 0.0, rise = 0.0;
        for (int j = 0; j < SIDES; j++) {
            double value = near[j][k];
            x += cell->weight[j][0] * (value - q[k]);
            y += cell->weight[j][1] * (value - q[k]);
            lowest = value < lowest ? value : lowest;
            highest = value > highest ? value : highest;
        }
        for (int j = 0; j < SIDES; j++) {
            double change = x * cell->offset[j][0] + y * cell->offset[j][1];
            fall = change < fall ? change : fall;
            rise = change > rise ? change : rise;
        }
        double factor = limiter(q[k], lowest, highest, fall, rise);
        double east = wind[0] + divergent * w->shape_drop[k] / w->thickness[k];
        s->slope[0][start + k] = factor * x;
        s->slope[1][start + k] = factor * y;
        s->half[start + k] = q[k] - 0.5 * dt * factor * (east * x + wind[1] * y);
    }
}

/* Tracer through one side: flux of air times the upwind cell's linear reconstruction at the middle of the side. */
static void exchange(const Mesh *mesh, const Winds *w, State *s, int e)
{
    const Side *side = &mesh->side[e];
    const size_t n = (size_t)mesh->layers;
    double *from = s->outflow + (size_t)side->cell[0] * n, *to = s->outflow + (size_t)side->cell[1] * n;
    for (size_t k = 0; k < n; k++) {
        double air = w->rotational[e] * w->thickness[k] + w->divergent[e] * w->shape_drop[k];
        int upwind = air < 0.0;
        size_t i = (size_t)side->cell[upwind] * n + k;
        const double *offset = side->offset[upwind];
        double tracer = air * (s->half[i] + s->slope[0][i] * offset[0] + s->slope[1][i] * offset[1]);
        from[k] += tracer;
        to[k] -= tracer;
    }
}

/* New values of one column. The flux of air up through an interface, divergence times s(p), is what flows in through
 * the sides of all layers below it. Bottom and top are closed. */
static void settle(const Mesh *mesh, const Winds *w, State *s, int c, double dt)
{
    const size_t n = (size_t)mesh->layers, start = (size_t)c * n;
    const double *half = s->half + start;
    double below = 0.0;
    for (size_t k = 0; k < n; k++) {
        double air = w->divergence[c] * w->shape[k + 1], above = 0.0;
        if (k + 1 < n && air > 0.0) {
            above = air * (half[k] + (k > 0 ? 0.5 * limited_rise(half[k - 1], half[k], half[k + 1]) : 0.0));
        } else if (k + 1 < n) {
            above = air * (half[k + 1] - (k + 2 < n ? 0.5 * limited_rise(half[k], half[k + 1], half[k + 2]) : 0.0));
        }
        s->q[start + k] -= dt * (s->outflow[start + k] + above - below) / (mesh->cell[c].area * w->thickness[k]);
        below = above;
    }
}

/* One step, with the winds of its middle. */
static void advance(const Mesh *mesh, Winds *w, State *s, double time, double dt)
{
    winds_set(w, mesh, time + 0.5 * dt);
    memset(s->outflow, 0, (size_t)mesh->cells * (size_t)mesh->layers * sizeof(double));
    for (int c = 0; c < mesh->cells; c++) {
        lift(mesh, w, s, c, dt);
    }
    for (int c = 0; c < mesh->cells; c++) {
        predict(mesh, w, s, c, dt);
    }
    for (int e = 0; e < mesh->sides; e++) {
        exchange(mesh, w, s, e);
    }
    for (int c = 0; c < mesh->cells; c++) {
        settle(mesh, w, s, c, dt);
    }
}

/* Tracer mass in kg, by compensated summation (Neumaier 1974) so that the sum itself does not blur the balance. */
static double tracer_mass(const Mesh *mesh, const Winds *w, const State *s)
{
    double sum = 0.0, lost = 0.0;
    for (size_t i = 0, n = (size_t)mesh->layers; i < (size_t)mesh->cells * n; i++) {
        double term = s->q[i] * mesh->cell[i / n].area * w->thickness[i % n] / GRAVITY, next = sum + term;
        lost += fabs(sum) >= fabs(term) ? (sum - next) + term : (term - next) + sum;
        sum = next;
    }
    return sum + lost;
}

/* Relative l2 error against the initial field, weighted by volume. */
static double l2_error(const Mesh *mesh, const State *s)
{
    double error = 0.0, norm = 0.0;
    for (size_t i = 0, n = (size_t)mesh->layers; i < (size_t)mesh->cells * n; i++) {
        double difference = s->q[i] - s->initial[i], area = mesh->cell[i / n].area;
        error += area * difference * difference;
        norm += area * s->initial[i] * s->initial[i];
    }
    return sqrt(error / norm);
}

/* ---- the command line ---- */

typedef struct {
    int level, layers, threads;
    double days, dt; /* dt 0: from the Courant number */
    long every;      /* 0: twice a day */
    const char *scene, *out;
} Options;

static void usage(FILE *stream)
{
    fprintf(stream, "usage: tracer [options]\n"
                    "  --level n      icosahedral grid of 10 * 4^n + 2 cells, 1 to 9 (5)\n"
                    "  --layers N     layers between the ground and 12 km, 6 to 1000 (30)\n"
                    "  --days D       length of the simulation; the flow has returned after 12 (12)\n"
                    "  --dt S         longest time step in seconds (from the Courant number)\n"
                    "  --every k      steps between pictures (half a day)\n"
                    "  --scene FILE   scene to draw (examples/scenes/tracer.toml)\n"
                    "  --out DIR      where pictures go (the current directory)\n"
                    "  --threads T    threads that draw, 0 for all (0)\n"
                    "  --help         print this and leave\n");
}

static void refuse(const char *option, const char *why)
{
    fprintf(stderr, "tracer: %s: %s\n", option, why);
    usage(stderr);
    exit(2);
}

/* The number in `text`; refuses what is none, or out of range. */
static double number(const char *option, const char *text, double lowest, double highest)
{
    char *end;
    double value = strtod(text, &end);
    if (end == text || *end != '\0' || !(value >= lowest && value <= highest)) {
        refuse(option, "not a number in its range");
    }
    return value;
}

static long whole(const char *option, const char *text, double lowest, double highest)
{
    double value = number(option, text, lowest, highest);
    if (value != floor(value)) {
        refuse(option, "not a whole number");
    }
    return (long)value;
}

static Options options_from(int argc, char **argv)
{
    Options o = {5, 30, 0, 12.0, 0.0, 0, "examples/scenes/tracer.toml", NULL};
    for (int i = 1; i < argc; i += 2) {
        const char *name = argv[i], *value = i + 1 < argc ? argv[i + 1] : "";
        if (strcmp(name, "--help") == 0) {
            usage(stdout);
            exit(EXIT_SUCCESS);
        } else if (strcmp(name, "--level") == 0) {
            o.level = (int)whole(name, value, 1, 9);
        } else if (strcmp(name, "--layers") == 0) {
            o.layers = (int)whole(name, value, 6, 1000);
        } else if (strcmp(name, "--days") == 0) {
            o.days = number(name, value, 0.01, 10000);
        } else if (strcmp(name, "--dt") == 0) {
            o.dt = number(name, value, 0.01, DAY);
        } else if (strcmp(name, "--every") == 0) {
            o.every = whole(name, value, 1, 1e9);
        } else if (strcmp(name, "--threads") == 0) {
            o.threads = (int)whole(name, value, 0, 4096);
        } else if (strcmp(name, "--scene") == 0 && *value != '\0') {
            o.scene = value;
        } else if (strcmp(name, "--out") == 0 && *value != '\0') {
            o.out = value;
        } else {
            refuse(name, "unknown, or without its value");
        }
    }
    return o;
}

/* ---- what a model adds ---- */

typedef struct {
    icoray_ctx *ctx; /* NULL after a failure: the simulation goes on without pictures */
    int failed, frames;
    double seconds; /* wall-clock time inside icoray, and the parts of it that the frame reports name */
    double prepare, render, write;
} Pictures;

static double wall_clock(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Checks one status. On an error, says why and draws no more. */
static int succeeded(Pictures *pictures, icoray_status status, const char *call)
{
    char message[1024] = "";
    if (status == ICORAY_OK) {
        return 1;
    }
    (void)icoray_last_error(pictures->ctx, message, sizeof message);
    fprintf(stderr, "tracer: %s: status %d: %s\n", call, (int)status, message);
    fprintf(stderr, "tracer: the simulation goes on without pictures\n");
    pictures->failed = 1;
    if (pictures->ctx != NULL) {
        (void)icoray_close(&pictures->ctx);
        pictures->ctx = NULL;
    }
    return 0;
}

/* Once, before the time loop: hands over the mesh, the layers and the tracer, and reads the scene. */
static Pictures pictures_open(const icoray_grid *grid, const Mesh *mesh, const State *s, const Options *options)
{
    Pictures pictures = {0};
    double start = wall_clock();

    icoray_config config = {0};
    config.struct_size = sizeof config;
    config.threads = options->threads;
    config.output_dir = options->out;

    icoray_layers layers = {0};
    layers.struct_size = sizeof layers;
    layers.count = mesh->layers;
    layers.radius_m = mesh->radius;
    layers.planet_radius_m = RADIUS;

    icoray_array q = {0};
    q.struct_size = sizeof q;
    q.data = s->q; /* the model's own array, read anew at each icoray_execute */
    q.type = ICORAY_F64;
    q.location = ICORAY_CENTER;
    q.columns = mesh->cells;
    q.layers = mesh->layers;
    q.column_stride = mesh->layers;
    q.layer_stride = 1;

    (void)(succeeded(&pictures, icoray_open_serial(&config, &pictures.ctx), "icoray_open_serial") &&
           succeeded(&pictures, icoray_grid_set(pictures.ctx, grid), "icoray_grid_set") &&
           succeeded(&pictures, icoray_layers_set(pictures.ctx, &layers), "icoray_layers_set") &&
           succeeded(&pictures, icoray_field_set(pictures.ctx, "q", &q), "icoray_field_set") &&
           succeeded(&pictures, icoray_scene_load(pictures.ctx, options->scene), "icoray_scene_load"));
    pictures.seconds = wall_clock() - start;
    return pictures;
}

/* Each k steps: draws the scene from the arrays as they are now. Returns the seconds that it took. */
static double pictures_draw(Pictures *pictures, long step, double time, const char *date)
{
    icoray_frame_report frame = {0};
    double start = wall_clock();
    frame.struct_size = sizeof frame;
    if (pictures->ctx != NULL &&
        succeeded(pictures, icoray_execute(pictures->ctx, step, time, date), "icoray_execute") &&
        succeeded(pictures, icoray_report(pictures->ctx, &frame), "icoray_report")) {
        pictures->frames++;
        pictures->prepare += frame.prepare_s;
        pictures->render += frame.render_s;
        pictures->write += frame.write_s;
    }
    double seconds = wall_clock() - start;
    pictures->seconds += seconds;
    return seconds;
}

/* Once, after the time loop and before the arrays are freed. */
static void pictures_close(Pictures *pictures)
{
    if (pictures->ctx != NULL) {
        (void)succeeded(pictures, icoray_close(&pictures->ctx), "icoray_close");
    }
}

/* ---- the program ---- */

/* Time as a date of a 365-day calendar that starts on 1 January of year 0, to the nearest second. */
static void format_date(double time, char *text, size_t size)
{
    static const int length[12] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
    double whole_seconds = floor(time + 0.5);
    int seconds = (int)fmod(whole_seconds, DAY), days = (int)(whole_seconds / DAY), year = days / 365, month = 0;
    for (days %= 365; days >= length[month]; month++) {
        days -= length[month];
    }
    snprintf(text, size, "%04d-%02d-%02d_%02d:%02d:%02d", year, month + 1, days + 1, seconds / 3600, seconds / 60 % 60,
             seconds % 60);
}

/* Sets the number of steps, and of those between pictures, so that dt is at most the one asked for or allowed. */
static void plan_steps(const Options *o, const Mesh *mesh, const Winds *w, long *steps, long *every)
{
    double dt = o->dt > 0.0 ? o->dt : MAX_COURANT * mesh->shortest / winds_bound(w, mesh->layers);
    double intervals = fmax(1.0, floor(2.0 * o->days + 0.5)); /* of half a day */
    *every = o->every > 0 ? o->every : (long)ceil(o->days * DAY / intervals / dt);
    *steps = o->every > 0 ? (long)ceil(o->days * DAY / dt) : (long)intervals * *every;
}

/* The state's part of a line of the log. */
static void print_state(const Mesh *mesh, const Winds *w, const State *s, long step, double time, double start_mass)
{
    double mass = tracer_mass(mesh, w, s), lowest = s->q[0], highest = s->q[0];
    for (size_t i = 1; i < (size_t)mesh->cells * (size_t)mesh->layers; i++) {
        lowest = fmin(lowest, s->q[i]);
        highest = fmax(highest, s->q[i]);
    }
    printf("%7ld %7.3f %20.13e %10.2e %10.2e %9.6f", step, time / DAY, mass, mass / start_mass - 1.0, lowest, highest);
}

int main(int argc, char **argv)
{
    Options options = options_from(argc, argv);
    icoray_mesh *generated = NULL;
    icoray_grid grid = {0};
    grid.struct_size = sizeof grid;
    if (icoray_mesh_create(options.level, &generated) != ICORAY_OK || icoray_mesh_grid(generated, &grid) != ICORAY_OK) {
        char message[1024] = "";
        (void)icoray_last_error(NULL, message, sizeof message);
        fprintf(stderr, "tracer: no grid: %s\n", message);
        return EXIT_FAILURE;
    }
    Mesh mesh = mesh_new(&grid, options.layers);
    Winds winds = winds_new(&mesh);
    State state = state_new(&mesh);
    long steps, every;
    plan_steps(&options, &mesh, &winds, &steps, &every);
    double dt = options.days * DAY / (double)steps, start_mass = tracer_mass(&mesh, &winds, &state);

    printf("tracer: %d cells, %d layers, %ld steps of %.3f s, a picture each %ld steps, icoray %s\n", mesh.cells,
           mesh.layers, steps, dt, every, icoray_version());
    printf("   step     day              mass/kg      drift      min q     max q simulate/s visualize/s\n");
    Pictures pictures = pictures_open(&grid, &mesh, &state, &options);
    double simulation = 0.0, shown = 0.0;
    for (long step = 0;; step++) {
        double time = (double)step * dt, start;
        if (step % every == 0 || step == steps) {
            char date[64];
            format_date(time, date, sizeof date);
            print_state(&mesh, &winds, &state, step, time, start_mass);
            printf(" %10.3f %11.3f\n", simulation - shown, pictures_draw(&pictures, step, time, date));
            fflush(stdout);
            shown = simulation;
        }
        if (step == steps) {
            break;
        }
        start = wall_clock();
        advance(&mesh, &winds, &state, time, dt);
        simulation += wall_clock() - start;
    }
    pictures_close(&pictures);

    printf("simulation    %9.3f s, %9.6f s per step\n", simulation, simulation / (double)steps);
    printf("visualization %9.3f s, %9.6f s per step; %d pictures: prepare %.3f s, render %.3f s, write %.3f s\n",
           pictures.seconds, pictures.seconds / (double)steps, pictures.frames, pictures.prepare, pictures.render,
           pictures.write);
    printf("mass drift    %9.2e\n", tracer_mass(&mesh, &winds, &state) / start_mass - 1.0);
    if (fabs(options.days * DAY - PERIOD) < 1e-6) {
        printf("l2 error      %9.6f\n", l2_error(&mesh, &state));
    }
    if (pictures.failed) {
        printf("pictures      failed, see above\n");
    }
    state_free(&state);
    winds_free(&winds);
    mesh_free(&mesh);
    (void)icoray_mesh_free(&generated);
    return pictures.failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
