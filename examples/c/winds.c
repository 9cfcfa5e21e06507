#include "winds.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ROTATION (2.0 * PI * RADIUS / PERIOD) /* wind speeds, m s-1 */
#define DEFORMATION (10.0 * RADIUS / PERIOD)
#define OMEGA (23000.0 * PI / PERIOD) /* largest pressure velocity, Pa s-1 */

static double sin_moving(const Winds *w, const Place *p) { return p->sin_lon * w->cos_turn - p->cos_lon * w->sin_turn; }
static double cos_moving(const Winds *w, const Place *p) { return p->cos_lon * w->cos_turn + p->sin_lon * w->sin_turn; }

/* psi, m2 s-1: u_a = -1/a d(psi)/d(lat), v = 1/(a cos lat) d(psi)/d(lon). */
static double streamfunction(const Winds *w, const Place *p)
{
    double wave = sin_moving(w, p) * p->cos_lat;
    return RADIUS * (w->deformation * wave * wave - ROTATION * p->sin_lat);
}

void rotational_wind(const Winds *w, const Place *p, double out[2])
{
    double wave = 2.0 * w->deformation * sin_moving(w, p) * p->cos_lat;
    out[0] = wave * sin_moving(w, p) * p->sin_lat + ROTATION * p->cos_lat;
    out[1] = wave * cos_moving(w, p);
}

double divergent_wind(const Winds *w, const Place *p)
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

Winds winds_new(const Mesh *mesh)
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

void winds_free(Winds *w)
{
    free(w->rotational);
    free(w->divergent);
    free(w->divergence);
    free(w->shape);
    free(w->shape_drop);
    free(w->thickness);
}

/* Fluxes of air at a time. Differences of the streamfunction make the rotational part exactly non-divergent. */
void winds_set(Winds *w, const Mesh *mesh, double time)
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

double winds_bound(const Winds *w, int layers)
{
    double steepest = 0.0;
    for (int k = 0; k < layers; k++) {
        steepest = fmax(steepest, fabs(w->shape_drop[k]) / w->thickness[k]);
    }
    return ROTATION + DEFORMATION + OMEGA * RADIUS * steepest;
}
