#include "thruster_model.h"

#include <math.h>

#include "number_text.h"
#include "periods.h"
#include "vectors.h"

#define WHOLE (1.0 - 1e-9)
#define MOST_STEPS INT64_C(0x20000000000000)

int prepare_thrusters(Component *component, double step, PreparedThrusters *prepared)
{
    const double *real = component->real;
    const double lag = real[PORT_THRUST_LAG];
    char text[NUMBER_SIZE];
    int i, k;

    prepared->most_thrust = real[PORT_THRUST_MAXIMUM];
    prepared->minimum_impulse = real[PORT_THRUST_MINIMUM_IMPULSE];
    prepared->period = real[PORT_THRUST_PERIOD];
    prepared->step = step;
    if (!(prepared->most_thrust > 0.0))
        return refuse(component, "thrust.maximum must be > 0, got %s", number_text(prepared->most_thrust, text));
    prepared->steps = whole_multiple(prepared->period, step);
    if (prepared->steps == 0)
        return refuse(component, "thrust.period = %g s must be a whole multiple of the step of %g s", prepared->period,
                      step);
    for (k = 0; k < THRUSTERS; k++) {
        const double *direction = real + PORT_THRUSTER_DIRECTION + 3 * k;
        const double length = sqrt(dot3(direction, direction));
        double along[3], torque[3];
        if (!(length > 1e-6))
            return refuse(component, "thruster.direction[%d] to [%d] must be a direction, got no length", 3 * k + 1,
                          3 * k + 3);
        for (i = 0; i < 3; i++)
            along[i] = direction[i] / length;
        cross3(real + PORT_THRUSTER_POSITION + 3 * k, along, torque);
        for (i = 0; i < 3; i++) {
            prepared->wrench[i][k] = along[i];
            prepared->wrench[3 + i][k] = torque[i];
        }
    }
    if (!(prepared->minimum_impulse <= prepared->most_thrust * prepared->period))
        return refuse(component,
                      "thrust.minimum_impulse must be at most thrust.maximum times thrust.period, %g N.s, got %s",
                      prepared->most_thrust * prepared->period, number_text(prepared->minimum_impulse, text));
    prepared->decay = lag > 0.0 ? exp(-step / lag) : 0.0;
    prepared->mean = lag / step * (1.0 - prepared->decay);
    return 0;
}

int thrusters_begin_a_period(const PreparedThrusters *prepared, const ThrusterState *state)
{
    return state->count % prepared->steps == 0;
}

void step_thrusters(const PreparedThrusters *prepared, ThrusterState *state, const double *command,
                    const double *draw, double *mean)
{
    const int64_t place = state->count % prepared->steps;
    double sum = 0.0;
    int i, k;

    for (k = 0; k < THRUSTERS; k++) {
        double share, valve;
        if (place == 0) {
            const double wanted = prepared->period * fmin(fmax(command[k], 0.0), prepared->most_thrust);
            const int fired = wanted > 0.0 && wanted >= WHOLE * prepared->minimum_impulse;
            state->open_time[k] = fired ? wanted / prepared->most_thrust : 0.0;
            state->level[k] = prepared->most_thrust * (1.0 + prepared->noise * draw[k]);
            state->pulses[k] += fired;
        }
        share = fmin(fmax((state->open_time[k] - (double)place * prepared->step) / prepared->step, 0.0), 1.0);
        valve = state->level[k] * share;
        mean[k] = valve + prepared->mean * (state->thrust[k] - valve);
        state->thrust[k] = valve + prepared->decay * (state->thrust[k] - valve);
        sum += mean[k];
    }
    state->impulse += prepared->step * sum;
    for (i = 0; i < 3; i++) {
        double torque = 0.0;
        for (k = 0; k < THRUSTERS; k++)
            torque += prepared->wrench[3 + i][k] * mean[k];
        state->angular_impulse[i] += prepared->step * torque;
    }
    state->count++;
}

int is_thruster_state(const PreparedThrusters *prepared, const ThrusterState *state)
{
    int k;

    if (state->count < 0 || state->count > MOST_STEPS || !isfinite(state->impulse))
        return 0;
    for (k = 0; k < THRUSTERS; k++)
        if (!isfinite(state->open_time[k]) || !isfinite(state->level[k]) || !isfinite(state->thrust[k])
            || state->open_time[k] > prepared->period * (1.0 + 1e-9) || state->pulses[k] < 0
            || state->pulses[k] > state->count)
            return 0;
    return 1;
}
