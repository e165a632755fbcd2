/* The plant of one instance, stepped exactly in its linear part: the twin of runtime/plant.py. */
#ifndef FLEXSAT_PLANT_STEP_H
#define FLEXSAT_PLANT_STEP_H

#include "prepared_plant.h"

enum { KEPT_STEPS = 4 }; /* lengths of steps that stay prepared, for masters that change between them */

/* What changes in a run: views of the component's state. */
typedef struct PlantState {
    double *length;   /* s, of the step that is prepared */
    double *mrp;      /* (3) */
    double *z;        /* (2 m) */
    double *momentum; /* (6) linear and angular, of body and structure */
    double *load;     /* (r) of the last step */
    double *internal; /* (r) those of them that are gyroscopic torques and momentum terms */
    double *axial;    /* (n) axial momenta of the wheels, inertial [N.m.s] */
    double *angle;    /* (n) [rad] */
    double *speed;    /* (n) relative [rad/s] */
    double *turn;     /* (3) of the body due to eta [rad] */
} PlantState;

/* Buffers that a step writes before it reads them. */
typedef struct PlantWork {
    double *given;      /* (inputs) with torques limited, then with friction */
    double *input_load; /* (r) */
    double *held;       /* (2 n + 6) gyroscopic torques and momentum terms */
    double *speeds;     /* (6 + u) at mid-step */
    double *middle;     /* (2 m) z of mid-step, without the loads */
    double *ahead;      /* (6 + u) at the middle of the next step, without momenta and loads */
    double ahead_length; /* s, of the step that they are for; 0: they are not known */
    double *end;        /* (2 m) z of the end */
    double *folded;     /* (2 m) z with the restoring forces of parts alone */
    double *pushed;     /* (m) accelerations of parts alone */
    double *turn;       /* (3) as in the state, at the end */
    double *seen;       /* (6 + u + k + n + 9) */
    double *unbraked;   /* (n) */
    double *holding;    /* (2 n) */
    double *response;   /* (n, n) of the wheels' speeds to their torques */
    double *structure;  /* (2 m) eta, eta' */
    double *input_change, *load_change, *present_load; /* (inputs), (r), (r) of derivatives */
} PlantWork;

typedef struct Plant {
    Motion motion;
    PlantStep steps[KEPT_STEPS], *step; /* the last is that in use */
    int next;                           /* to be replaced */
    PlantState state;
    PlantWork work;
} Plant;

/* Make the state at the start of a run, and the outputs. */
void plant_begin(Component *component, Plant *plant);

/* Set the motion of body and structure: eta (m), velocity and rate (6), eta' (m); no inputs act. */
void plant_place(Plant *plant, const double *eta, const double *body, const double *speed);

/* Advance by one step of the length in use, with the inputs held over it; the outputs are true at its end. */
int plant_step(Component *component, Plant *plant);

/* Write the outputs in the present state with the present inputs at work: the accelerations, which jump with them. */
void plant_feed_through(Component *component, Plant *plant);

#endif
