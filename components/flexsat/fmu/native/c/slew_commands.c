#include "slew_commands.h"

#include <math.h>
#include <string.h>

#include "rotations.h"

static double spacing_of(const PreparedController *prepared)
{
    return prepared->shaper.shifts[0];
}

/* How long before its start time a slew must be known [s]: for its shaped torque, and both delays. */
static double lead(const PreparedController *prepared)
{
    return spacing_of(prepared) + prepared->parameters.measurement_delay + prepared->parameters.actuation_delay;
}

static int begun(const PreparedController *prepared, const Motion *motion, double time)
{
    return time + prepared->parameters.actuation_delay >= motion->start - spacing_of(prepared);
}

/* Whether no slew is planned, or the shaped torque of the one that was has ended. */
static int ended(const PreparedController *prepared, const Motion *motion, double time)
{
    return motion->angle == 0.0 ||
           time + prepared->parameters.actuation_delay >= motion->end + spacing_of(prepared);
}

static int in_flight(const PreparedController *prepared, const Motion *motion, double time)
{
    return motion->angle > 0.0 && begun(prepared, motion, time) && !ended(prepared, motion, time);
}

/* The first start time of a slew after this one [s]. */
static double clear_of(const PreparedController *prepared, const Motion *motion)
{
    return motion->end + 2.0 * spacing_of(prepared) + prepared->period;
}

/* The attitude at which the slew ends. */
static void end_attitude(const Commanded *state, double attitude[4])
{
    double turn[3];
    int k;

    for (k = 0; k < 3; k++)
        turn[k] = state->profile.angle * state->profile.axis[k];
    rotate_quaternion(state->origin, turn, attitude);
}

/* Count the motion from the end of the one before, if that was flown, else from where that would have begun. */
static void begin(Commanded *state, const Motion *motion, int has_ended)
{
    int k;

    if (has_ended && state->profile.angle > 0.0) {
        end_attitude(state, state->origin);
        for (k = 0; k < 3; k++)
            state->reference[k] -= 0.25 * state->profile.angle * state->profile.axis[k];
    }
    state->profile = *motion;
    state->braking = 0;
}

/* Brake the slew in flight, then turn to where the command leads from the attitude at which that slew began. */
static int replan(Component *component, const PreparedController *prepared, Commanded *state, double time,
                  const double rotation[3], double start)
{
    const double delay = prepared->parameters.actuation_delay;
    const double earliest = time + delay + spacing_of(prepared) + prepared->period; /* no tap has seen it */
    double target[4], stop[4], relative[4], turn[3], clear;

    motion_stop(&state->profile, earliest, acceleration_about(prepared, state->profile.axis), prepared->period,
                delay);
    rotate_quaternion(state->base, rotation, target);
    end_attitude(state, stop);
    relative_quaternion(target, stop, relative);
    rotation_vector(relative, turn);
    motion_still(prepared->knots, 0.0, &state->following);
    clear = clear_of(prepared, &state->profile);
    if (rotation_angle(turn) > 0.0 &&
        plan_motion(component, prepared, turn, start > clear ? start : clear, &state->following))
        return 1;
    memcpy(state->following_base, state->base, sizeof state->base);
    state->braking = 1;
    return 0;
}

static int refuse_during_slew(Component *component, const PreparedController *prepared, const Motion *profile,
                              double time)
{
    return refuse(component,
                  "command.rotation changed at %.3f s, after the slew of %.3f s had begun: command the next slew to "
                  "begin at %.3f s or later, or set command.during_slew to 'replan'",
                  time, profile->start, clear_of(prepared, profile));
}

/* One that has ended stays as it is until the next begins: the shaped torque has no more to do. */
static int command_at_rest(Component *component, const PreparedController *prepared, Commanded *state, double time,
                           const double rotation[3], double start, int turns)
{
    const int has_ended = ended(prepared, &state->profile, time);
    const double earliest = time + lead(prepared);
    Motion motion;

    if (!turns && has_ended)
        return 0;
    if (plan_motion(component, prepared, rotation, start > earliest ? start : earliest, &motion))
        return 1;
    begin(state, &motion, has_ended);
    memcpy(state->base, state->origin, sizeof state->origin);
    return 0;
}

int command(Component *component, const PreparedController *prepared, Commanded *state, double time,
            const double rotation[3], double start)
{
    const int turns = rotation[0] != 0.0 || rotation[1] != 0.0 || rotation[2] != 0.0;
    int refused = 0;

    if (state->start == start && state->rotation[0] == rotation[0] && state->rotation[1] == rotation[1] &&
        state->rotation[2] == rotation[2])
        return 0;
    proceed(prepared, state, time);
    if (!in_flight(prepared, &state->profile, time)) {
        refused = command_at_rest(component, prepared, state, time, rotation, start, turns);
    } else if (!turns) {
        motion_still(prepared->knots, 0.0, &state->following);
    } else if (start >= clear_of(prepared, &state->profile) && !state->braking) {
        refused = plan_motion(component, prepared, rotation, start, &state->following);
        end_attitude(state, state->following_base);
    } else if (prepared->parameters.replans) {
        refused = replan(component, prepared, state, time, rotation, start);
    } else {
        refused = refuse_during_slew(component, prepared, &state->profile, time);
    }
    if (refused)
        return 1;
    memcpy(state->rotation, rotation, sizeof state->rotation);
    state->start = start;
    return 0;
}

void proceed(const PreparedController *prepared, Commanded *state, double time)
{
    if (!(state->following.angle > 0.0) || !ended(prepared, &state->profile, time))
        return;
    begin(state, &state->following, 1);
    motion_still(prepared->knots, 0.0, &state->following);
    memcpy(state->base, state->following_base, sizeof state->base);
}

void start_from(const PreparedController *prepared, Commanded *state, double time, const double attitude[4])
{
    if (state->profile.angle != 0.0 && begun(prepared, &state->profile, time))
        return;
    memcpy(state->origin, attitude, sizeof state->origin);
    memcpy(state->base, attitude, sizeof state->base);
    memcpy(state->following_base, attitude, sizeof state->following_base);
}

void reference_attitude(const double origin[4], const double axis[3], const double quarter[3], double attitude[4])
{
    const double turned = 4.0 * (axis[0] * quarter[0] + axis[1] * quarter[1] + axis[2] * quarter[2]);
    double about[3], rest[3], between[4];
    int k;

    memcpy(attitude, origin, 4 * sizeof(double));
    if (quarter[0] == 0.0 && quarter[1] == 0.0 && quarter[2] == 0.0)
        return;
    for (k = 0; k < 3; k++) {
        about[k] = turned * axis[k];
        rest[k] = 4.0 * quarter[k] - about[k];
    }
    rotate_quaternion(origin, about, between);
    rotate_quaternion(between, rest, attitude);
}
