/* The plant when the angle of an appendage changes in a run: the twin of runtime/turning/state.py. */
#ifndef FLEXSAT_TURNED_STATE_H
#define FLEXSAT_TURNED_STATE_H

#include "plant_step.h"

/* What a change of an angle keeps. */
typedef struct Kept {
    double *angle;       /* (t) [rad]: for which the plant is prepared */
    double *eta;         /* (m) */
    double *momenta;     /* (6 + m): that belong to velocity, rate, modal velocities */
    double *motion;      /* (6 + m) these velocities */
    double *mass;        /* (6 + m, 6 + m) scratch */
    double wheels[3];    /* N.m.s: angular momentum of the wheels, about axes as the structure tilts them */
} Kept;

/* Take memory for a plant of at most `modes` modes with `angles` appendages that turn. */
int take_kept(Memory *memory, int modes, int angles, Kept *kept);

/* Note the motion of the plant. */
void keep_motion(const Plant *plant, Kept *kept);

/* Continue with the plant prepared for other angles; the outputs are true afterwards. */
void continue_motion(Component *component, Plant *plant, Kept *kept);

#endif
