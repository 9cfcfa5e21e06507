/*
 * The winds of DCMIP test 1-1.
 *
 * Horizontal wind = rotational part (u_a, v), the same in all layers, plus divergent part (u_d, 0), which is a function
 * of place and time times s'(p). So both factor into an array over the sides and a profile over the layers. The
 * pressure velocity is omega = OMEGA s(p) sin(lon') cos(lat) cos(2 pi t / PERIOD) with lon' = lon - 2 pi t / PERIOD.
 */
#ifndef WINDS_H
#define WINDS_H

#include "mesh.h"
#include "planet.h"

#define PERIOD (12.0 * DAY) /* after which the flow has returned, s */

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

Winds winds_new(const Mesh *mesh);
void winds_free(Winds *w);

/* Sets the fluxes of air to those at a time in seconds. */
void winds_set(Winds *w, const Mesh *mesh, double time);

/* An upper bound of the horizontal wind speed at all times, m s-1. */
double winds_bound(const Winds *w, int layers);

/* The rotational part at a place: (u_a, v), m s-1. */
void rotational_wind(const Winds *w, const Place *p, double out[2]);

/* The divergent part at a place: u_d / s'(p), Pa m s-1. */
double divergent_wind(const Winds *w, const Place *p);

#endif
