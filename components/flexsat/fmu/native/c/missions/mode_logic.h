/* Modes and timeline: the twin of runtime/missions/mode_logic.py, which documents them. */
#ifndef FLEXSAT_MODE_LOGIC_H
#define FLEXSAT_MODE_LOGIC_H

#include <stdint.h>

#include "component.h"
#include "ports.h"

#define COMMANDS PORT_TIMELINE_TIME_SIZE

enum { ACQUISITION, SLEW, SETTLE, FINE, OFF_LOAD, SAFE, MODES };
enum { NOTHING, DO_SLEW, DO_OFF_LOAD, DO_SAFE, DO_RESUME };

typedef struct PreparedModes {
    const double *time, *rotation; /* parameters */
    const int *action;
    double lead, band, automatic;
    int64_t dwell, outage, safe_outage, start_limit; /* steps */
} PreparedModes;

typedef struct Seen {
    int star_tracker_valid, moving, off_loaded, lost_axis;
    double error, speed_share;
} Seen;

typedef struct ModeState {
    int64_t mode, steps, settled, since_star_tracker, next, moved;
    double rotation[3], start;
} ModeState;

/* Read the parameters at a step [s]; refuse a timeline whose times do not rise. */
int prepare_modes(Component *component, double step, PreparedModes *prepared);

void init_modes(const PreparedModes *prepared, ModeState *state);
int star_tracker_is_out(const PreparedModes *prepared, const ModeState *state);

/* Change the mode and carry out what is due; returns whether an off-loading begins now. */
int step_modes(const PreparedModes *prepared, ModeState *state, double time, const Seen *seen);

#endif
