/* Pulses behind a lag: the twin of runtime/missions/thrusters.py, which documents it. */
#ifndef FLEXSAT_THRUSTER_MODEL_H
#define FLEXSAT_THRUSTER_MODEL_H

#include <stdint.h>

#include "component.h"
#include "ports.h"

#define THRUSTERS (PORT_THRUSTER_POSITION_SIZE / 3)

typedef struct PreparedThrusters {
    double wrench[6][THRUSTERS]; /* force and torque of a unit of thrust */
    double most_thrust, minimum_impulse, period, step; /* N, N.s, s, s */
    int64_t steps; /* in a period */
    double decay, mean, noise;
} PreparedThrusters;

typedef struct ThrusterState {
    int64_t count;
    double open_time[THRUSTERS], level[THRUSTERS], thrust[THRUSTERS];
    int64_t pulses[THRUSTERS];
    double impulse, angular_impulse[3];
} ThrusterState;

/* Read the parameters that `ports.h` places, but for the noise, and sample the lag at a step [s]. */
int prepare_thrusters(Component *component, double step, PreparedThrusters *prepared);

/* Mean thrust of each over the coming step; `draw` has a normal number for each, of where a period begins. */
int thrusters_begin_a_period(const PreparedThrusters *prepared, const ThrusterState *state);
void step_thrusters(const PreparedThrusters *prepared, ThrusterState *state, const double *command,
                    const double *draw, double *mean);

/* Whether a state is one that a run may reach. */
int is_thruster_state(const PreparedThrusters *prepared, const ThrusterState *state);

#endif
