#include "mode_logic.h"

#include <math.h>
#include <string.h>

#include "number_text.h"

#define LEFT 3.0
#define EARLY 1e-9
#define START_LIMIT 20.0 /* s, after the lead */

static int64_t steps_in(double time, double step) { return (int64_t)floor(time / step + 0.5); }

int prepare_modes(Component *component, double step, PreparedModes *prepared)
{
    const double *real = component->real, *rotation = real + PORT_TIMELINE_ROTATION;
    char text[NUMBER_SIZE], other[NUMBER_SIZE];
    double last = 0.0;
    int k;

    prepared->time = real + PORT_TIMELINE_TIME;
    prepared->rotation = rotation;
    prepared->action = component->integer + PORT_TIMELINE_ACTION;
    for (k = 0; k < COMMANDS && prepared->action[k] != NOTHING; k++) {
        if (prepared->time[k] < last)
            return refuse(component, "timeline.time[%d] must be >= the one before, %s s, got %s", k + 1,
                          number_text(last, text), number_text(prepared->time[k], other));
        if (prepared->action[k] == DO_SLEW && rotation[3 * k] == 0.0 && rotation[3 * k + 1] == 0.0
            && rotation[3 * k + 2] == 0.0)
            return refuse(component, "timeline.rotation[%d] to [%d] must turn somewhere, got a slew by 0", 3 * k + 1,
                          3 * k + 3);
        last = prepared->time[k];
    }
    prepared->lead = real[PORT_SLEW_LEAD];
    prepared->band = real[PORT_SETTLE_BAND];
    prepared->dwell = steps_in(real[PORT_SETTLE_DWELL], step);
    prepared->outage = steps_in(real[PORT_STAR_TRACKER_OUTAGE_TIME], step);
    prepared->safe_outage = steps_in(real[PORT_SAFE_OUTAGE_TIME], step);
    prepared->start_limit = steps_in(prepared->lead + START_LIMIT, step);
    prepared->automatic = real[PORT_OFF_LOADING_AUTOMATIC];
    return 0;
}

void init_modes(const PreparedModes *prepared, ModeState *state)
{
    memset(state, 0, sizeof *state);
    state->mode = ACQUISITION;
    state->since_star_tracker = prepared->outage + 1;
}

int star_tracker_is_out(const PreparedModes *prepared, const ModeState *state)
{
    return state->since_star_tracker > prepared->outage;
}

/* The mode that follows from what is seen, the timeline aside. */
static int64_t followed(const PreparedModes *prepared, ModeState *state, const Seen *seen)
{
    const int64_t mode = state->mode;

    if (mode == SAFE || seen->lost_axis || state->since_star_tracker > prepared->safe_outage + prepared->outage + 1)
        return SAFE;
    if (mode == SLEW) {
        state->moved = state->moved || seen->moving;
        return (state->moved && !seen->moving) || (!state->moved && state->steps > prepared->start_limit) ? SETTLE
                                                                                                        : SLEW;
    }
    if (mode == OFF_LOAD)
        return seen->off_loaded ? SETTLE : OFF_LOAD;
    if (star_tracker_is_out(prepared, state))
        return ACQUISITION;
    if (mode == ACQUISITION)
        return SETTLE;
    if (prepared->automatic > 0.0 && seen->speed_share > prepared->automatic && state->steps > prepared->dwell)
        return OFF_LOAD;
    if (mode == SETTLE)
        return state->settled >= prepared->dwell ? FINE : SETTLE;
    return seen->error > LEFT * prepared->band ? SETTLE : FINE;
}

/* The action of the command whose time has come. */
static int due(const PreparedModes *prepared, const ModeState *state, double time)
{
    if (state->next >= COMMANDS || time < prepared->time[state->next] - EARLY)
        return NOTHING;
    return prepared->action[state->next];
}

int step_modes(const PreparedModes *prepared, ModeState *state, double time, const Seen *seen)
{
    int64_t mode;
    int action, began;

    state->since_star_tracker = seen->star_tracker_valid ? 0 : state->since_star_tracker + 1;
    state->settled = seen->error < prepared->band ? state->settled + 1 : 0;
    state->steps++;
    mode = followed(prepared, state, seen);
    began = mode == OFF_LOAD && state->mode != OFF_LOAD;
    action = due(prepared, state, time);
    if (action == DO_SAFE || (mode == SAFE && action != DO_RESUME)) {
        if (action != NOTHING) {
            mode = SAFE;
            state->next++;
        }
    } else if (action == DO_RESUME) {
        mode = mode == SAFE ? ACQUISITION : mode;
        state->next++;
    } else if (action != NOTHING && (mode == SETTLE || mode == FINE) && state->mode == mode
               && state->steps > prepared->dwell) {
        if (action == DO_SLEW) {
            memcpy(state->rotation, prepared->rotation + 3 * state->next, sizeof state->rotation);
            state->start = time + prepared->lead;
            state->moved = 0;
            mode = SLEW;
        } else {
            mode = OFF_LOAD;
            began = 1;
        }
        state->next++;
    }
    if (mode == SAFE) {
        memset(state->rotation, 0, sizeof state->rotation);
        began = 0;
    }
    if (mode != state->mode) {
        state->mode = mode;
        state->steps = state->settled = 0;
    }
    return began;
}
