/* Wheels back to their nominal speeds by thrusters: the twin of runtime/missions/off_loading.py. */
#ifndef FLEXSAT_OFF_LOADING_H
#define FLEXSAT_OFF_LOADING_H

#include "component.h"
#include "thruster_model.h"

typedef struct PreparedOffLoading {
    double shares[THRUSTERS][3], most_share[3], least_share[3]; /* 1/m */
    double most_thrust, minimum_impulse, period, duration, last, tolerance;
} PreparedOffLoading;

typedef struct OffLoadingState {
    double until, owed[3], command[THRUSTERS];
} OffLoadingState;

/* Read the parameters; refuse thrusters that give no pure torque. */
int prepare_off_loading(Component *component, const PreparedThrusters *thrusters, PreparedOffLoading *prepared);

void begin_off_loading(const PreparedOffLoading *prepared, OffLoadingState *state, double time);
int off_loading_is_done(const PreparedOffLoading *prepared, const OffLoadingState *state, double time,
                        const double momentum[3]);
void plan_off_loading(const PreparedOffLoading *prepared, OffLoadingState *state, double time,
                      const double momentum[3]);
void stop_off_loading(OffLoadingState *state);

#endif
