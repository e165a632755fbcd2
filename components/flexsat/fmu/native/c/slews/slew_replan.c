#include "slew_replan.h"

#include <math.h>
#include <string.h>

#include "rotations.h"

#define PI 3.14159265358979323846
#define NO_TURN 1e-12 /* rad: rounding of attitudes */

/* The short rotation vector [rad] from an attitude to another; zero for one that is rounding. */
static void turn_between(const double attitude[4], const double target[4], double turn[3])
{
    double relative[4], axis[3];

    relative_quaternion(target, attitude, relative);
    rotation_vector(relative, turn);
    if (!(axis_of(turn, axis) > NO_TURN))
        memset(turn, 0, 3 * sizeof(double));
}

/* The turns from where a motion ends to an attitude. */
static int turns_after(Component *component, const PreparedController *prepared, const Commanded *state,
                       const Motion *motion, const double target[4], double turns[LEGS][3])
{
    double attitude[4], turn[3];

    attitude_after(state, motion, attitude);
    turn_between(attitude, target, turn);
    return turns_from(component, prepared, state, attitude, turn, turns);
}

static double end_of(const PreparedController *prepared, const Motion *motion, double turns[LEGS][3])
{
    double end = 0.0;
    int k;

    for (k = 0; k < LEGS; k++)
        end += duration_of(prepared, turns[k]);
    return motion->end + end;
}

/* Try to turn on, with the quadratic programme, to where the turns after it are shortest. Returns 1 if it can. */
static int onward(const PreparedController *prepared, const Commanded *state, double time, const double target[4],
                  Motion *motion)
{
    const double *axis = state->profile.axis;
    double relative[4], about[3], angle;
    int k;

    relative_quaternion(target, state->origin, relative);
    angle = 2.0 * atan2(axis[0] * relative[0] + axis[1] * relative[1] + axis[2] * relative[2], relative[3]);
    if (angle < 0.0)
        angle += 2.0 * PI;
    *motion = state->profile;
    for (k = 0; k < 3; k++)
        about[k] = angle * axis[k];
    return turn_on(prepared, time, angle, motion) && is_clear(&prepared->keep_out, state->origin, about);
}

int replan(Component *component, const PreparedController *prepared, Commanded *state, double time,
           const double rotation[3], double start)
{
    /* no tap of the shaper has seen it */
    const double earliest =
        time + prepared->parameters.actuation_delay + shaper_spacing(prepared) + prepared->period;
    double target[4], turn[3], turns[LEGS][3], others[LEGS][3];
    Motion motion = state->profile, other;
    int onwards = 0;

    rotate_quaternion(state->base, rotation, target);
    if (!motion_begun(prepared, &state->profile, time)) { /* at rest between two turns */
        const int turns_ended = state->turns_ended;
        turn_between(state->origin, target, turn);
        if (begin_command(component, prepared, state, state->origin, turn, start, time))
            return 1;
        state->turns_ended = turns_ended;
        forget_following(prepared, state);
        return 0;
    }
    brake(prepared, earliest, &motion);
    if (turns_after(component, prepared, state, &motion, target, turns))
        return 1;
    if (prepared->optimal && start <= earliest && onward(prepared, state, earliest, target, &other)) {
        if (turns_after(component, prepared, state, &other, target, others))
            return 1;
        onwards = end_of(prepared, &other, others) < end_of(prepared, &motion, turns);
    }
    forget_following(prepared, state);
    state->profile = onwards ? other : motion;
    memcpy(state->turns, onwards ? others : turns, sizeof state->turns);
    state->braking = !onwards;
    return 0;
}
