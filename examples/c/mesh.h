/* The geometry of an icosahedral grid: what finite volumes need to know of its cells and their sides. */
#ifndef MESH_H
#define MESH_H

#include <icoray.h>

#include <stddef.h>

#define SIDES 6 /* of a cell; a pentagon's last neighbour is itself, with no weight */

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

/* The mesh of a grid whose coordinates are doubles. Ends the program when there is no memory. */
Mesh mesh_new(const icoray_grid *grid, int layers);
void mesh_free(Mesh *mesh);

/* The place at a longitude and latitude in radians. */
Place place_at(double lon, double lat);

/* Angle between two unit vectors, accurate for small ones. */
double angle(const double a[3], const double b[3]);

/* Zeroed memory for rows x row elements; ends the program when there is none. */
void *allocate(int rows, int row, size_t size);

#endif
