#include "commanded.h"

#include <math.h>
#include <string.h>

#include "rotations.h"

double shaper_spacing(const PreparedController *prepared)
{
    return prepared->shaper.shifts[0];
}

/* How long before its start time a slew must be known [s]: for its shaped torque, and both delays. */
static double lead(const PreparedController *prepared)
{
    return shaper_spacing(prepared) + prepared->parameters.measurement_delay + prepared->parameters.actuation_delay;
}

int motion_begun(const PreparedController *prepared, const Motion *motion, double time)
{
    return time + prepared->parameters.actuation_delay >= motion->start - shaper_spacing(prepared);
}

int motion_ended(const PreparedController *prepared, const Motion *motion, double time)
{
    return motion->angle == 0.0 ||
           time + prepared->parameters.actuation_delay >= motion->end + shaper_spacing(prepared);
}

int slew_in_flight(const PreparedController *prepared, const Commanded *state, double time)
{
    const Motion *profile = &state->profile;
    const int has_begun = state->turns_ended > 0 || motion_begun(prepared, profile, time);

    return profile->angle > 0.0 && has_begun && !motion_ended(prepared, profile, time);
}

int is_turn(const double rotation[3])
{
    return rotation[0] != 0.0 || rotation[1] != 0.0 || rotation[2] != 0.0;
}

double clear_after(const PreparedController *prepared, const Commanded *state)
{
    double others = 0.0;
    int k;

    for (k = 0; k < LEGS; k++)
        others += duration_of(prepared, state->turns[k]);
    return state->profile.end + pause_between(prepared) + others;
}

void attitude_after(const Commanded *state, const Motion *motion, double attitude[4])
{
    double turn[3];
    int k;

    for (k = 0; k < 3; k++)
        turn[k] = motion->angle * motion->axis[k];
    rotate_quaternion(state->origin, turn, attitude);
}

void final_attitude(const Commanded *state, double attitude[4])
{
    int k;

    attitude_after(state, &state->profile, attitude);
    for (k = 0; k < LEGS; k++)
        rotate_quaternion(attitude, state->turns[k], attitude);
}

int turns_from(Component *component, const PreparedController *prepared, const Commanded *state,
               const double attitude[4], const double rotation[3], double turns[LEGS][3])
{
    if (state->captured || !prepared->keep_out.active)
        return plan_turns(component, prepared, attitude, rotation, turns);
    memset(turns, 0, LEGS * 3 * sizeof(double));
    memcpy(turns[0], rotation, 3 * sizeof(double));
    return 0;
}

void drop_first(double (*turns)[3])
{
    memmove(turns[0], turns[1], (LEGS - 1) * 3 * sizeof(double));
    memset(turns[LEGS - 1], 0, 3 * sizeof(double));
}

void forget_following(const PreparedController *prepared, Commanded *state)
{
    motion_still(prepared->knots, 0.0, &state->following);
    memset(state->following_turns, 0, sizeof state->following_turns);
    if (state->braking)
        memset(state->turns, 0, sizeof state->turns);
}

void begin_motion(Commanded *state, const Motion *motion, int has_ended)
{
    int k;

    if (has_ended && state->profile.angle > 0.0) {
        attitude_after(state, &state->profile, state->origin);
        for (k = 0; k < 3; k++)
            state->reference[k] -= 0.25 * state->profile.angle * state->profile.axis[k];
    }
    state->profile = *motion;
    state->braking = 0;
    state->turns_ended = 0;
}

int begin_command(Component *component, const PreparedController *prepared, Commanded *state,
                  const double attitude[4], const double rotation[3], double start, double time)
{
    const int has_ended = motion_ended(prepared, &state->profile, time);
    double turns[LEGS][3];
    Motion motion;

    if (turns_from(component, prepared, state, attitude, rotation, turns) ||
        plan_motion(component, prepared, turns[0], fmax(start, time + lead(prepared)), &motion))
        return 1;
    begin_motion(state, &motion, has_ended);
    memcpy(state->turns, turns, sizeof turns);
    drop_first(state->turns);
    return 0;
}
