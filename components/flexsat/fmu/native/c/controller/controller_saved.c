#include "controller_saved.h"

#define MOST_STEPS INT64_C(0x20000000000000)

/* Whether a motion can be followed: its knots are in order. There is one alone where a slew begins so late that the
numbers of its times are the same. */
static int is_motion(const Motion *motion, int knots, int allocations)
{
    int k;

    if (motion->allocation < 0 || motion->allocation >= allocations || motion->knots != knots || motion->count < 1 ||
        motion->count > knots)
        return 0;
    for (k = 1; k < motion->count; k++)
        if (!(motion->times[k] > motion->times[k - 1]))
            return 0;
    return 1;
}

static int is_count(int64_t value)
{
    return value >= 0 && value <= MOST_STEPS;
}

int is_reachable(const PreparedController *prepared, const ControllerState *state)
{
    const int knots = prepared->knots, allocations = prepared->slew_wheels.count;

    return is_count(state->count) && is_count(state->held) && is_count(state->since_star_tracker) &&
           is_motion(&state->commanded.profile, knots, allocations) &&
           is_motion(&state->commanded.following, knots, allocations);
}
