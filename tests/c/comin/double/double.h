/* State that the double's host sets, and its calls of the plugin. */
#ifndef DOUBLE_H
#define DOUBLE_H

#include "../icon.h"

typedef struct {
    const icon_variable *of;
    int domain, is_float;
    void *now; /* the present time level */
} double_variable;

typedef struct {
    int communicator, rank, domains, variables;
    const char *options, *start;
    char date[48];
    icon_domain domain[3]; /* from 1 */
    double_variable variable[2 * ALL_VARIABLES];
} double_state;
extern double_state double_icon;

void double_call(int entry_point, int domain);

#endif
