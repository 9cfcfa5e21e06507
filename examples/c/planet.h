/* The planet and its isothermal atmosphere. */
#ifndef PLANET_H
#define PLANET_H

#define PI 3.14159265358979323846
#define DAY 86400.0                            /* s */
#define RADIUS 6371220.0                       /* of the planet, m */
#define GRAVITY 9.80616                        /* m s-2 */
#define SCALE_HEIGHT (287.0 * 300.0 / GRAVITY) /* m */
#define SURFACE_PRESSURE 100000.0              /* Pa */
#define MODEL_TOP 12000.0                      /* m */

#endif
