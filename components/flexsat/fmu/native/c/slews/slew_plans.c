#include "slew_plans.h"

#include "linear_algebra.h"

#define LEAST_REMAINING 1.01 /* of the angle of braking: below it the programme has no room */

static Sampling sampling_of(const PreparedController *prepared)
{
    Sampling sampling;

    sampling.period = prepared->period;
    sampling.phase = prepared->parameters.actuation_delay;
    sampling.memory = 2.0 * prepared->shaper.shifts[0] + 3.0 * prepared->period;
    return sampling;
}

/* The greatest acceleration [rad/s2] and rate [rad/s] of a slew about an axis, by allocations. */
static void limits_of(const PreparedController *prepared, const double axis[3],
                      double accelerations[MOST_ALLOCATIONS], double rates[MOST_ALLOCATIONS])
{
    double needed[3];

    times_vector(3, 3, prepared->inertia, axis, needed);
    limits_about(&prepared->slew_wheels, needed, accelerations, rates);
}

/* The allocation by which a turn by an angle is the quickest; `duration` [s] is that of the turn. */
static int quickest(const PreparedController *prepared, double angle, const double *accelerations,
                    const double *rates, double *duration)
{
    int chosen = 0, k;

    *duration = turn_duration(angle, accelerations[0], rates[0]);
    for (k = 1; k < prepared->slew_wheels.count; k++) {
        const double other = turn_duration(angle, accelerations[k], rates[k]);
        if (other < *duration) {
            *duration = other;
            chosen = k;
        }
    }
    return chosen;
}

int check_start(Component *component, const PreparedController *prepared, double angle, double start)
{
    const double earliest = prepared->shaper.shifts[0] + prepared->parameters.measurement_delay +
                            prepared->parameters.actuation_delay;

    if (angle > 0.0 && start < earliest)
        return refuse(component,
                      "command.start_time = %g s must be >= %g s: the shaped torque begins before the slew", start,
                      earliest);
    return 0;
}

int plan_motion(Component *component, const PreparedController *prepared, const double rotation[3], double start,
                Motion *motion)
{
    const Sampling sampling = sampling_of(prepared);
    double axis[3], accelerations[MOST_ALLOCATIONS], rates[MOST_ALLOCATIONS], duration;
    double times[OPTIMUM_KNOTS], optimal[OPTIMUM_KNOTS];
    const double angle = axis_of(rotation, axis);
    Profile profile;
    int chosen, k;

    limits_of(prepared, axis, accelerations, rates);
    chosen = quickest(prepared, angle, accelerations, rates, &duration);
    plan_trapezium(axis, angle, start, accelerations[chosen], rates[chosen], &profile);
    if (profile.angle == 0.0) {
        motion_still(prepared->knots, start, motion);
        return 0;
    }
    if (!prepared->optimal) {
        motion_from_profile(&profile, prepared->knots, &sampling, chosen, motion);
        return 0;
    }
    optimum_times(profile_end(&profile) - start, profile.ramp, times);
    if (optimal_rates(prepared->optimum, angle, accelerations[chosen], rates[chosen], times, 0.0, optimal))
        return refuse(component, "slew.guidance = 'qp': the quadratic programme has no optimum within these limits");
    for (k = 0; k < OPTIMUM_KNOTS; k++)
        times[k] += start;
    motion_from_knots(&profile, OPTIMUM_KNOTS, times, optimal, prepared->knots, &sampling, chosen, motion);
    return 0;
}

double duration_of(const PreparedController *prepared, const double turn[3])
{
    double axis[3], accelerations[MOST_ALLOCATIONS], rates[MOST_ALLOCATIONS], duration;
    const double angle = axis_of(turn, axis);

    if (!(angle > 0.0))
        return 0.0;
    limits_of(prepared, axis, accelerations, rates);
    quickest(prepared, angle, accelerations, rates, &duration);
    return duration + (prepared->optimal ? OPTIMUM_TAIL : 0.0) + pause_between(prepared);
}

static double duration_for(const void *prepared, const double turn[3])
{
    return duration_of(prepared, turn);
}

int plan_turns(Component *component, const PreparedController *prepared, const double attitude[4],
               const double rotation[3], double turns[LEGS][3])
{
    return plan_legs(component, &prepared->keep_out, attitude, rotation, duration_for, prepared, turns);
}

double pause_between(const PreparedController *prepared)
{
    return 2.0 * prepared->shaper.shifts[0] + prepared->period;
}

void brake(const PreparedController *prepared, double time, Motion *motion)
{
    const Sampling sampling = sampling_of(prepared);
    double accelerations[MOST_ALLOCATIONS], rates[MOST_ALLOCATIONS];

    limits_of(prepared, motion->axis, accelerations, rates);
    motion_stop(motion, time, accelerations[motion->allocation], &sampling);
}

int turn_on(const PreparedController *prepared, double time, double angle, Motion *motion)
{
    const Sampling sampling = sampling_of(prepared);
    const double rate = motion_rate(motion, time), remaining = angle - motion_rotation(motion, time);
    double accelerations[MOST_ALLOCATIONS], rates[MOST_ALLOCATIONS], acceleration, most, duration;
    double since[OPTIMUM_KNOTS], optimal[OPTIMUM_KNOTS];

    limits_of(prepared, motion->axis, accelerations, rates);
    acceleration = accelerations[motion->allocation];
    most = rates[motion->allocation];
    if (remaining <= 0.0 || remaining * acceleration < LEAST_REMAINING * 0.5 * (rate * rate))
        return 0;
    duration = remaining_duration(remaining, acceleration, most, rate);
    optimum_times(duration, most / acceleration, since);
    if (optimal_rates(prepared->optimum, remaining, acceleration, most, since, rate, optimal))
        return 0;
    return motion_continue(motion, time, OPTIMUM_KNOTS, since, optimal, &angle, &sampling);
}
