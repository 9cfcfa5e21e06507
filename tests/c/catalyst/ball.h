/* Meshes of wedges and of prisms over an icosahedral mesh, of hexahedra over a cubed sphere, and of points, with heights
 * and values. */
#ifndef BALL_H
#define BALL_H

#include "icoray.h"

/* Points of a column; with one the elements are triangles and quadrilaterals on a sphere. */
#ifndef LEVELS
#define LEVELS 6
#endif

typedef enum { WEDGES, PRISMS, HEXES, POINTS } ball_shape;

/* Columns of points, and the polygons of columns around each column of elements: triangles of wedges, with points at
 * cells; the cells as prisms, with points at corners; quadrilaterals; or each column of points itself. */
typedef struct {
    ball_shape shape;
    int columns, polygons;
    int layers; /* elements of a column */
    int *polygon, *sides; /* six per polygon */
    double *x; /* unit vectors of columns */
} ball;

/* The mesh of a shape by its name. */
ball ball_make(const char *shape);

/* The radius of a point: spheres, or layers over hills. */
double ball_radius(const ball *of, int column, int level, int has_hills);

/* Values at points or, midway between levels, at elements. */
double ball_at_point(const ball *of, int column, int level, int step);
double ball_at_element(const ball *of, int polygon, int layer, int step);

/* The direction of the middle of a polygon: the centroid of its flat triangles. */
void ball_middle(const ball *of, int polygon, double x[3]);

/* The rank of a polygon, in strips of the sphere with some single polygons of other ranks among them. */
int ball_owner(const ball *of, int polygon, int ranks);

#endif
