/* Mission manager: the twin of runtime/missions/manager.py, which documents it, and of fmu/python/mission.py. */
#include <math.h>
#include <string.h>

#include "failure_detection.h"
#include "mode_logic.h"
#include "off_loading.h"
#include "plain_component.h"
#include "ports.h"
#include "rotations.h"
#include "thruster_model.h"
#include "vectors.h"

#define MOVING 1e-8 /* rad/s, of the reference */
#define MOST_STEPS INT64_C(0x20000000000000)

typedef struct PreparedManager {
    PreparedModes modes;
    PreparedDetection detection;
    PreparedOffLoading off_loading;
    PreparedThrusters thrusters;
    double step, forget, inverse[3][3]; /* of all wheels */
} PreparedManager;

typedef struct ManagerState {
    int64_t count, lost_axis;
    ModeState modes;
    DetectionState detection;
    OffLoadingState off_loading;
    ThrusterState thrusters;
    double inverse[3][3], owed[3];
    double torque[WHEELS], applied[WHEELS], hidden_speed[WHEELS], shown_speed[WHEELS], momentum[3], error;
} ManagerState;

static ManagerState *state_of(const Component *component) { return (ManagerState *)(void *)component->state; }

static int prepare(Component *component, double step)
{
    const double *real = component->real;
    PreparedManager *prepared = component->own;
    PreparedDetection *detection = &prepared->detection;
    const int64_t all_work[WHEELS] = {WORKS};

    prepared->thrusters.noise = 0.0;
    if (prepare_thrusters(component, step, &prepared->thrusters)
        || prepare_off_loading(component, &prepared->thrusters, &prepared->off_loading)
        || prepare_modes(component, step, &prepared->modes))
        return 1;
    prepared->step = step;
    prepared->forget = 1.0 - step / fmax(real[PORT_OFF_LOADING_MEMORY], step);
    if (inverse_of_axes(real + PORT_WHEEL_AXIS, all_work, prepared->inverse))
        return refuse(component, "wheel.axis must be axes that lie in no plane, for a torque about any axis");
    detection->enabled = component->boolean[PORT_FAILURE_ENABLED];
    detection->wheel_inertia = real + PORT_WHEEL_INERTIA;
    detection->step = step;
    detection->follow = step / (real[PORT_FAILURE_TIME_CONSTANT] + step);
    detection->threshold = real[PORT_FAILURE_THRESHOLD];
    detection->seized_speed = real[PORT_FAILURE_SEIZED_SPEED];
    detection->braking_time = fmax(step, real[PORT_FAILURE_BRAKING_TIME]);
    detection->persistence = (int64_t)fmax(1.0, floor(real[PORT_FAILURE_PERSISTENCE] / step + 0.5));
    return 0;
}

static void write_outputs(Component *component)
{
    const PreparedManager *prepared = component->own;
    const ManagerState *state = state_of(component);
    double *real = component->real;
    int *integer = component->integer;
    int k;

    memcpy(real + PORT_WHEEL_TORQUE, state->torque, sizeof state->torque);
    memcpy(real + PORT_APPLIED_WHEEL_TORQUE, state->applied, sizeof state->applied);
    memcpy(real + PORT_SHOWN_ENCODER_SPEED, state->shown_speed, sizeof state->shown_speed);
    memcpy(real + PORT_COMMAND_ROTATION, state->modes.rotation, sizeof state->modes.rotation);
    memcpy(real + PORT_THRUST_COMMAND, state->off_loading.command, sizeof state->off_loading.command);
    memcpy(real + PORT_MOMENTUM, state->momentum, sizeof state->momentum);
    memcpy(real + PORT_WHEEL_RESIDUAL, state->detection.residual, sizeof state->detection.residual);
    for (k = 0; k < WHEELS; k++)
        integer[PORT_WHEEL_STATUS + k] = (int)state->detection.status[k];
    real[PORT_COMMAND_START_TIME] = state->modes.start;
    real[PORT_POINTING_ERROR] = state->error;
    integer[PORT_MODE] = (int)state->modes.mode;
    integer[PORT_TIMELINE_DONE] = (int)state->modes.next;
    component->boolean[PORT_APPLIED_VALID] = 1;
    component->boolean[PORT_STAR_TRACKER_OUTAGE] = star_tracker_is_out(&prepared->modes, &state->modes);
}

int component_start(Component *component)
{
    const PreparedManager *prepared;
    ManagerState *state;

    if (take_component_memory(component, sizeof(PreparedManager), sizeof(ManagerState))
        || prepare(component, component->real[PORT_THRUST_PERIOD]))
        return 1;
    prepared = component->own;
    state = state_of(component);
    init_modes(&prepared->modes, &state->modes);
    memcpy(state->inverse, prepared->inverse, sizeof state->inverse);
    memcpy(state->shown_speed, component->real + PORT_WHEEL_NOMINAL_SPEED, sizeof state->shown_speed);
    write_outputs(component);
    return 0;
}

/* Prepare for steps of this length. */
int component_first_step(Component *component, double length)
{
    if (prepare(component, length))
        return 1;
    component->step_length = length;
    return 0;
}

static double pointing_error(const double *estimate, const double *reference)
{
    double attitude[4], base[4], error[3];

    quaternion_from_mrp(estimate, attitude);
    quaternion_from_mrp(reference, base);
    relative_mrp(attitude, base, error);
    return 4.0 * sqrt(dot3(error, error));
}

/* Momentum of the wheels that work beside that of their nominal speeds; returns the farthest speed over the band. */
static double weigh(const Component *component, ManagerState *state)
{
    const double *real = component->real;
    double farthest = 0.0;
    int i, k;

    memset(state->momentum, 0, sizeof state->momentum);
    for (k = 0; k < WHEELS; k++)
        if (state->detection.status[k] == WORKS) {
            const double deviation = real[PORT_ENCODER_SPEED + k] - real[PORT_WHEEL_NOMINAL_SPEED + k];
            farthest = fmax(farthest, fabs(deviation));
            for (i = 0; i < 3; i++)
                state->momentum[i] += real[PORT_WHEEL_AXIS + 3 * k + i] * (real[PORT_WHEEL_INERTIA + k] * deviation);
        }
    return farthest / real[PORT_WHEEL_SPEED_BAND];
}

static double clipped(double value, double most) { return fmin(fmax(value, -most), most); }

/* Torques of the wheels that work for those that do not, as far as they go; the rest is owed. */
static void answer_failure(const Component *component, const PreparedManager *prepared, ManagerState *state,
                           double *torque)
{
    const double *axis = component->real + PORT_WHEEL_AXIS, *limit = component->real + PORT_WHEEL_TORQUE_LIMIT;
    double wanted[3], shared[3], left[3];
    int cut = 0, i, k;

    for (i = 0; i < 3; i++)
        wanted[i] = state->owed[i] / prepared->step;
    for (k = 0; k < WHEELS; k++)
        for (i = 0; i < 3 && state->detection.status[k] != WORKS; i++)
            wanted[i] += axis[3 * k + i] * (torque[k] - state->detection.given[k]);
    times3(state->inverse[0], wanted, shared);
    memcpy(left, wanted, sizeof left);
    for (k = 0; k < WHEELS; k++) {
        double delivered;
        if (state->detection.status[k] != WORKS) {
            torque[k] = state->detection.given[k];
            continue;
        }
        torque[k] += dot3(axis + 3 * k, shared);
        delivered = clipped(torque[k], limit[k]);
        cut |= delivered != torque[k];
        for (i = 0; i < 3; i++)
            left[i] -= axis[3 * k + i] * delivered;
    }
    /* what the controller demands at the same time counts too: it brakes the same motion */
    for (i = 0; i < 3; i++)
        state->owed[i] = cut ? prepared->step * fmin(fmax(left[i], fmin(wanted[i], 0.0)), fmax(wanted[i], 0.0)) : 0.0;
}

/* Write the torque of the wheels, and the torque and speed that the controller is to know. */
static void command(Component *component, const PreparedManager *prepared, ManagerState *state)
{
    const double *real = component->real, *limit = real + PORT_WHEEL_TORQUE_LIMIT, *axis = real + PORT_WHEEL_AXIS;
    const double closed[THRUSTERS] = {0.0};
    double thrust[THRUSTERS], outside[3], shared[3], torque[WHEELS], demanded[WHEELS], taken[WHEELS];
    double less[3] = {0.0};
    int any_failed = 0, i, k;

    step_thrusters(&prepared->thrusters, &state->thrusters, state->off_loading.command, closed, thrust);
    for (i = 0; i < 3; i++) {
        outside[i] = 0.0;
        for (k = 0; k < THRUSTERS; k++)
            outside[i] += prepared->thrusters.wrench[3 + i][k] * thrust[k];
        outside[i] *= real[PORT_OFF_LOADING_FEED_FORWARD];
    }
    for (k = 0; k < WHEELS; k++) {
        torque[k] = demanded[k] = clipped(real[PORT_DEMANDED_WHEEL_TORQUE + k], limit[k]);
        any_failed |= state->detection.status[k] != WORKS;
    }
    if (any_failed)
        answer_failure(component, prepared, state, torque);
    times3(state->inverse[0], outside, shared);
    for (k = 0; k < WHEELS; k++) {
        const int works = state->detection.status[k] == WORKS;
        taken[k] = works ? dot3(axis + 3 * k, shared) : 0.0;
        state->torque[k] = works ? clipped(torque[k] + taken[k], limit[k]) : 0.0;
        for (i = 0; i < 3; i++)
            less[i] += axis[3 * k + i]
                       * (demanded[k] - (works ? state->torque[k] - taken[k] : state->detection.given[k]));
    }
    times3(prepared->inverse[0], less, shared);
    for (k = 0; k < WHEELS; k++) {
        const double gain = prepared->step / real[PORT_WHEEL_INERTIA + k];
        state->applied[k] = demanded[k] - dot3(axis + 3 * k, shared);
        if (state->detection.status[k] == WORKS)
            state->shown_speed[k] = real[PORT_ENCODER_SPEED + k] - state->hidden_speed[k];
        state->shown_speed[k] += gain * state->applied[k];
        state->hidden_speed[k] = prepared->forget
                                 * (state->hidden_speed[k] + gain * (state->torque[k] - state->applied[k]));
    }
}

/* Sample the inputs at `time`; the outputs hold from then on. */
int component_advance(Component *component, double time, double step)
{
    const PreparedManager *prepared = component->own;
    ManagerState *state = state_of(component);
    DetectionState *detection = &state->detection;
    const double *real = component->real;
    int64_t known[WHEELS];
    Seen seen;
    int changed = 0, k;

    (void)step;
    memcpy(known, detection->status, sizeof known);
    detect_failures(&prepared->detection, detection, state->count == 0, state->torque, real + PORT_ENCODER_SPEED);
    for (k = 0; k < WHEELS; k++)
        changed |= (known[k] == WORKS) != (detection->status[k] == WORKS);
    if (changed)
        state->lost_axis = inverse_of_axes(real + PORT_WHEEL_AXIS, detection->status, state->inverse);

    seen.speed_share = weigh(component, state);
    state->error = seen.error = pointing_error(real + PORT_ESTIMATE_MRP, real + PORT_REFERENCE_MRP);
    seen.star_tracker_valid = component->boolean[PORT_STAR_TRACKER_VALID];
    seen.moving = sqrt(dot3(real + PORT_REFERENCE_RATE, real + PORT_REFERENCE_RATE)) > MOVING;
    for (k = 0; k < WHEELS; k++)
        seen.moving |= real[PORT_REFERENCE_TORQUE + k] != 0.0;
    seen.off_loaded = state->modes.mode == OFF_LOAD
                      && off_loading_is_done(&prepared->off_loading, &state->off_loading, time, state->momentum);
    seen.lost_axis = (int)state->lost_axis;
    if (step_modes(&prepared->modes, &state->modes, time, &seen))
        begin_off_loading(&prepared->off_loading, &state->off_loading, time);
    if (thrusters_begin_a_period(&prepared->thrusters, &state->thrusters)) {
        if (state->modes.mode == OFF_LOAD)
            plan_off_loading(&prepared->off_loading, &state->off_loading, time, state->momentum);
        else
            stop_off_loading(&state->off_loading);
    }
    for (k = 0; k < WHEELS && state->count == 0; k++)
        state->hidden_speed[k] = detection->status[k] == WORKS ? real[PORT_ENCODER_SPEED + k]
                                                                    - real[PORT_WHEEL_NOMINAL_SPEED + k]
                                                              : 0.0;
    command(component, prepared, state);
    state->count++;
    write_outputs(component);
    return 0;
}

static int is_reachable(const PreparedManager *prepared, const ManagerState *state)
{
    int k;

    if (state->count < 0 || state->count > MOST_STEPS || !is_thruster_state(&prepared->thrusters, &state->thrusters)
        || state->modes.mode < 0 || state->modes.mode >= MODES || state->modes.next < 0 || state->modes.next > COMMANDS)
        return 0;
    for (k = 0; k < WHEELS; k++)
        if (state->detection.status[k] < WORKS || state->detection.status[k] > SEIZED)
            return 0;
    return 1;
}

int component_restored(Component *component)
{
    if (component->step_length > 0.0 && prepare(component, component->step_length))
        return 1;
    if (!is_reachable(component->own, state_of(component)))
        return refuse(component, "the saved state is none that a mission reaches");
    return 0;
}
