/* Cones that a body axis stays outside of: a check of turns, and chains of turns round the cones. The twin of
runtime/keep_out.py, which documents it. */
#ifndef FLEXSAT_KEEP_OUT_H
#define FLEXSAT_KEEP_OUT_H

#include "component.h"

enum {
    LEGS = 5, /* most turns in a chain */
    CONES = 2,
    AZIMUTHS = 16, /* attitudes on a ring */
    RINGS = 2,
    MOST_NODES = 2 + CONES * (2 * RINGS * AZIMUTHS + 2)
};

/* What a search works in. */
typedef struct Search {
    int count;
    double node[MOST_NODES][4]; /* attitudes: first the start, then the end */
    double cost[MOST_NODES][MOST_NODES]; /* s, of the turn from one to another; infinite if it is not clear */
    double total[MOST_NODES], least[MOST_NODES];
    int before[LEGS][MOST_NODES];
} Search;

/* A cone of half-angle 0 is none. */
typedef struct KeepOut {
    double axis[3];              /* in the body, unit vector */
    double direction[CONES][3];  /* inertial, unit vectors */
    double half_angle[CONES];    /* rad */
    int active;                  /* there is a cone */
    Search *search;              /* where there is one */
} KeepOut;

/* How long a turn by a rotation vector [rad] lasts [s]. */
typedef double (*TurnDuration)(const void *context, const double turn[3]);

/* The cones, with unit vectors; refuse a half-angle outside [0, pi), or a cone without a direction. */
int keep_out(Component *component, const double axis[3], const double *const directions[CONES],
             const double half_angles[CONES], KeepOut *cones);

/* The rotation vectors [rad] to turn by one after the other, zeros where there are fewer, for a slew by `rotation`
from an attitude; refuse one that begins or ends within a cone, or if no chain leads round the cones. */
int plan_legs(Component *component, const KeepOut *cones, const double attitude[4], const double rotation[3],
              TurnDuration duration, const void *context, double legs[LEGS][3]);

/* Whether a turn from an attitude by a rotation vector [rad] stays outside all cones. */
int is_clear(const KeepOut *cones, const double attitude[4], const double rotation[3]);

#endif
