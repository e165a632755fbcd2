#include "slew_commands.h"

#include <math.h>
#include <string.h>

#include "rotations.h"
#include "slew_replan.h"

static int refuse_during_slew(Component *component, const PreparedController *prepared, const Commanded *state,
                              double time)
{
    return refuse(component,
                  "command.rotation changed at %.3f s, after the slew of %.3f s had begun: command the next slew to "
                  "begin at %.3f s or later, or set command.during_slew to 'replan'",
                  time, state->profile.start, clear_after(prepared, state));
}

/* One that has ended stays as it is until the next begins: the shaped torque has no more to do. */
static int command_at_rest(Component *component, const PreparedController *prepared, Commanded *state, double time,
                           const double rotation[3], double start)
{
    const int flown = motion_ended(prepared, &state->profile, time);
    double attitude[4];

    if (!is_turn(rotation) && flown)
        return 0;
    memcpy(attitude, state->origin, sizeof attitude);
    if (flown)
        attitude_after(state, &state->profile, attitude);
    if (begin_command(component, prepared, state, attitude, rotation, start, time))
        return 1;
    memcpy(state->base, state->origin, sizeof state->origin);
    return 0;
}

/* Plan the slew after the present one. */
static int queue(Component *component, const PreparedController *prepared, Commanded *state,
                 const double rotation[3], double start)
{
    double attitude[4], turns[LEGS][3];

    final_attitude(state, attitude);
    if (turns_from(component, prepared, state, attitude, rotation, turns) ||
        plan_motion(component, prepared, turns[0], start, &state->following))
        return 1;
    memcpy(state->following_turns, turns, sizeof turns);
    drop_first(state->following_turns);
    memcpy(state->following_base, attitude, sizeof attitude);
    return 0;
}

int command(Component *component, const PreparedController *prepared, Commanded *state, double time,
            const double rotation[3], double start)
{
    int refused = 0;

    if (state->start == start && state->rotation[0] == rotation[0] && state->rotation[1] == rotation[1] &&
        state->rotation[2] == rotation[2])
        return 0;
    if (proceed(component, prepared, state, time))
        return 1;
    if (!slew_in_flight(prepared, state, time))
        refused = command_at_rest(component, prepared, state, time, rotation, start);
    else if (!is_turn(rotation))
        forget_following(prepared, state);
    else if (start >= clear_after(prepared, state) && !state->braking)
        refused = queue(component, prepared, state, rotation, start);
    else if (prepared->parameters.replans)
        refused = replan(component, prepared, state, time, rotation, start);
    else
        refused = refuse_during_slew(component, prepared, state, time);
    if (refused)
        return 1;
    memcpy(state->rotation, rotation, sizeof state->rotation);
    state->start = start;
    return 0;
}

/* Begin with the next turn of the present slew. */
static int begin_turn(Component *component, const PreparedController *prepared, Commanded *state)
{
    /* a braked slew waits for the start time of the command that braked it */
    const double earliest = state->braking ? state->start : 0.0;
    const int turns_ended = state->turns_ended + 1;
    Motion motion;

    if (plan_motion(component, prepared, state->turns[0],
                    fmax(state->profile.end + pause_between(prepared), earliest), &motion))
        return 1;
    begin_motion(state, &motion, 1);
    drop_first(state->turns);
    state->turns_ended = turns_ended;
    return 0;
}

int proceed(Component *component, const PreparedController *prepared, Commanded *state, double time)
{
    int k;

    for (k = 0; k < 2 * LEGS && state->profile.angle != 0.0 && motion_ended(prepared, &state->profile, time); k++) {
        if (is_turn(state->turns[0])) {
            if (begin_turn(component, prepared, state))
                return 1;
        } else if (state->following.angle > 0.0) {
            begin_motion(state, &state->following, 1);
            memcpy(state->turns, state->following_turns, sizeof state->turns);
            motion_still(prepared->knots, 0.0, &state->following);
            memset(state->following_turns, 0, sizeof state->following_turns);
            memcpy(state->base, state->following_base, sizeof state->base);
        } else {
            break;
        }
    }
    if (prepared->keep_out.active && !state->captured && slew_in_flight(prepared, state, time))
        return refuse(component,
                      "keep_out: the slew of %.3f s begins before the star tracker has given an attitude; command it "
                      "to begin later",
                      state->profile.start);
    return 0;
}

int start_from(Component *component, const PreparedController *prepared, Commanded *state, double time,
               const double attitude[4])
{
    state->captured = 1;
    if (state->profile.angle != 0.0 && (state->turns_ended > 0 || motion_begun(prepared, &state->profile, time)))
        return 0;
    memmove(state->origin, attitude, sizeof state->origin);
    memcpy(state->base, state->origin, sizeof state->base);
    memcpy(state->following_base, state->origin, sizeof state->following_base);
    if (!prepared->keep_out.active || !(state->profile.angle > 0.0))
        return 0;
    return begin_command(component, prepared, state, state->origin, state->rotation, state->profile.start, time);
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
