#include "transport.h"

#include "planet.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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

State state_new(const Mesh *mesh)
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

void state_free(State *s)
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

void advance(const Mesh *mesh, Winds *w, State *s, double time, double dt)
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

/* By compensated summation (Neumaier 1974) so that the sum itself does not blur the balance. */
double tracer_mass(const Mesh *mesh, const Winds *w, const State *s)
{
    double sum = 0.0, lost = 0.0;
    for (size_t i = 0, n = (size_t)mesh->layers; i < (size_t)mesh->cells * n; i++) {
        double term = s->q[i] * mesh->cell[i / n].area * w->thickness[i % n] / GRAVITY, next = sum + term;
        lost += fabs(sum) >= fabs(term) ? (sum - next) + term : (term - next) + sum;
        sum = next;
    }
    return sum + lost;
}

double l2_error(const Mesh *mesh, const State *s)
{
    double error = 0.0, norm = 0.0;
    for (size_t i = 0, n = (size_t)mesh->layers; i < (size_t)mesh->cells * n; i++) {
        double difference = s->q[i] - s->initial[i], area = mesh->cell[i / n].area;
        error += area * difference * difference;
        norm += area * s->initial[i] * s->initial[i];
    }
    return sqrt(error / norm);
}
