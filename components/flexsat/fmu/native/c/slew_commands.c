#include "slew_commands.h"

#include <math.h>
#include <string.h>

#include "rotations.h"

#define PI 3.14159265358979323846
#define NO_TURN 1e-12 /* rad: rounding of attitudes */

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

static int in_flight(const PreparedController *prepared, const Commanded *state, double time)
{
    const Motion *profile = &state->profile;
    const int has_begun = state->turns_ended > 0 || begun(prepared, profile, time);

    return profile->angle > 0.0 && has_begun && !ended(prepared, profile, time);
}

static int is_turn(const double rotation[3])
{
    return rotation[0] != 0.0 || rotation[1] != 0.0 || rotation[2] != 0.0;
}

/* The first start time of a slew after the present one [s]. */
static double clear_of(const PreparedController *prepared, const Commanded *state)
{
    double others = 0.0;
    int k;

    for (k = 0; k < LEGS; k++)
        others += duration_of(prepared, state->turns[k]);
    return state->profile.end + pause_between(prepared) + others;
}

/* The attitude at which a motion from the present origin ends. */
static void end_attitude(const Commanded *state, const Motion *motion, double attitude[4])
{
    double turn[3];
    int k;

    for (k = 0; k < 3; k++)
        turn[k] = motion->angle * motion->axis[k];
    rotate_quaternion(state->origin, turn, attitude);
}

/* The attitude at which the present slew ends. */
static void final_attitude(const Commanded *state, double attitude[4])
{
    int k;

    end_attitude(state, &state->profile, attitude);
    for (k = 0; k < LEGS; k++)
        rotate_quaternion(attitude, state->turns[k], attitude);
}

/* The turns of a slew; from an attitude that is not known yet one, which start_from checks. */
static int turns_of(Component *component, const PreparedController *prepared, const Commanded *state,
                    const double attitude[4], const double rotation[3], double turns[LEGS][3])
{
    if (state->captured || !prepared->keep_out.active)
        return plan_turns(component, prepared, attitude, rotation, turns);
    memset(turns, 0, LEGS * 3 * sizeof(double));
    memcpy(turns[0], rotation, 3 * sizeof(double));
    return 0;
}

/* The turns of a slew without its first. */
static void set_after_first(const double turns[LEGS][3], double others[LEGS][3])
{
    memmove(others[0], turns[1], (LEGS - 1) * 3 * sizeof(double));
    memset(others[LEGS - 1], 0, 3 * sizeof(double));
}

static void forget_following(const PreparedController *prepared, Commanded *state)
{
    motion_still(prepared->knots, 0.0, &state->following);
    memset(state->following_turns, 0, sizeof state->following_turns);
    if (state->braking)
        memset(state->turns, 0, sizeof state->turns);
}

/* Count the motion from the end of the one before, if that was flown, else from where that would have begun. */
static void begin(Commanded *state, const Motion *motion, int has_ended)
{
    int k;

    if (has_ended && state->profile.angle > 0.0) {
        end_attitude(state, &state->profile, state->origin);
        for (k = 0; k < 3; k++)
            state->reference[k] -= 0.25 * state->profile.angle * state->profile.axis[k];
    }
    state->profile = *motion;
    state->braking = 0;
    state->turns_ended = 0;
}

/* Plan a slew from an attitude at rest, in place of the present one. */
static int begin_command(Component *component, const PreparedController *prepared, Commanded *state,
                         const double attitude[4], const double rotation[3], double start, double time)
{
    const int has_ended = ended(prepared, &state->profile, time);
    double turns[LEGS][3];
    Motion motion;

    if (turns_of(component, prepared, state, attitude, rotation, turns) ||
        plan_motion(component, prepared, turns[0], fmax(start, time + lead(prepared)), &motion))
        return 1;
    begin(state, &motion, has_ended);
    set_after_first((const double(*)[3])turns, state->turns);
    return 0;
}

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

    end_attitude(state, motion, attitude);
    turn_between(attitude, target, turn);
    return turns_of(component, prepared, state, attitude, turn, turns);
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

/* Turn to where the command leads from the attitude at which the slew in flight began: the turn in flight is braked,
or with the quadratic programme goes on, if the command is then reached earlier. */
static int replan(Component *component, const PreparedController *prepared, Commanded *state, double time,
                  const double rotation[3], double start)
{
    /* no tap of the shaper has seen it */
    const double earliest =
        time + prepared->parameters.actuation_delay + spacing_of(prepared) + prepared->period;
    double target[4], turn[3], turns[LEGS][3], others[LEGS][3];
    Motion motion = state->profile, other;
    int onwards = 0;

    rotate_quaternion(state->base, rotation, target);
    if (!begun(prepared, &state->profile, time)) { /* at rest between two turns */
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

static int refuse_during_slew(Component *component, const PreparedController *prepared, const Commanded *state,
                              double time)
{
    return refuse(component,
                  "command.rotation changed at %.3f s, after the slew of %.3f s had begun: command the next slew to "
                  "begin at %.3f s or later, or set command.during_slew to 'replan'",
                  time, state->profile.start, clear_of(prepared, state));
}

/* One that has ended stays as it is until the next begins: the shaped torque has no more to do. */
static int command_at_rest(Component *component, const PreparedController *prepared, Commanded *state, double time,
                           const double rotation[3], double start)
{
    const int flown = ended(prepared, &state->profile, time);
    double attitude[4];

    if (!is_turn(rotation) && flown)
        return 0;
    memcpy(attitude, state->origin, sizeof attitude);
    if (flown)
        end_attitude(state, &state->profile, attitude);
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
    if (turns_of(component, prepared, state, attitude, rotation, turns) ||
        plan_motion(component, prepared, turns[0], start, &state->following))
        return 1;
    set_after_first((const double(*)[3])turns, state->following_turns);
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
    if (!in_flight(prepared, state, time))
        refused = command_at_rest(component, prepared, state, time, rotation, start);
    else if (!is_turn(rotation))
        forget_following(prepared, state);
    else if (start >= clear_of(prepared, state) && !state->braking)
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
    begin(state, &motion, 1);
    set_after_first((const double(*)[3])state->turns, state->turns);
    state->turns_ended = turns_ended;
    return 0;
}

int proceed(Component *component, const PreparedController *prepared, Commanded *state, double time)
{
    int k;

    for (k = 0; k < 2 * LEGS && state->profile.angle != 0.0 && ended(prepared, &state->profile, time); k++) {
        if (is_turn(state->turns[0])) {
            if (begin_turn(component, prepared, state))
                return 1;
        } else if (state->following.angle > 0.0) {
            begin(state, &state->following, 1);
            memcpy(state->turns, state->following_turns, sizeof state->turns);
            motion_still(prepared->knots, 0.0, &state->following);
            memset(state->following_turns, 0, sizeof state->following_turns);
            memcpy(state->base, state->following_base, sizeof state->base);
        } else {
            break;
        }
    }
    if (prepared->keep_out.active && !state->captured && in_flight(prepared, state, time))
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
    if (state->profile.angle != 0.0 && (state->turns_ended > 0 || begun(prepared, &state->profile, time)))
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
