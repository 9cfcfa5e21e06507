/*
 * Two bells of a passive tracer, carried by the winds.
 *
 * Finite volumes on the prisms over the Voronoi cells of an icosahedral grid. The fluxes of air are non-divergent to
 * rounding, so a constant mixing ratio stays constant. The tracer takes one MUSCL-Hancock step (van Leer 1984) with
 * slope limiters at a time, second order in space and time.
 */
#ifndef TRANSPORT_H
#define TRANSPORT_H

#include "mesh.h"
#include "winds.h"

/* Arrays of cells x layers values; layers run fastest, from the bottom up. */
typedef struct {
    double *q;        /* mixing ratio */
    double *initial;  /* mixing ratio at the start */
    double *lifted;   /* q carried up or down for half a step */
    double *half;     /* `lifted` carried horizontally for half a step: values at the middle of the step */
    double *slope[2]; /* limited slopes of `lifted`, east and north, m-1 */
    double *outflow;  /* of tracer through the sides, Pa m2 s-1 */
} State;

/* The two bells at the start. Ends the program when there is no memory. */
State state_new(const Mesh *mesh);
void state_free(State *s);

/* One step of dt seconds from a time, with the winds of its middle. */
void advance(const Mesh *mesh, Winds *w, State *s, double time, double dt);

/* Mass of the tracer, kg. */
double tracer_mass(const Mesh *mesh, const Winds *w, const State *s);

/* Relative l2 error against the initial field, weighted by volume. */
double l2_error(const Mesh *mesh, const State *s);

#endif
