#include "controller_law.h"

#include <math.h>
#include <string.h>

#include "linear_algebra.h"
#include "rotations.h"

static const double no_rotation[4] = {0.0, 0.0, 0.0, 1.0};

static size_t history_size(const PreparedController *prepared)
{
    return ((size_t)prepared->whole_delay + 2) * WHEELS;
}

size_t controller_state_size(const PreparedController *prepared)
{
    return sizeof(ControllerState) + history_size(prepared) * sizeof(Real);
}

int controller_init(Component *component, const PreparedController *prepared, const double rotation[3], double start,
                    ControllerState *state)
{
    Commanded *commanded = &state->commanded;

    if (plan_motion(component, prepared, rotation, start, &commanded->profile) ||
        check_start(component, prepared, commanded->profile.angle, start))
        return 1;
    motion_still(prepared->knots, 0.0, &commanded->following);
    state->since_star_tracker = prepared->phases - 1;
    memcpy(state->attitude, no_rotation, sizeof no_rotation);
    memcpy(state->slow.attitude, no_rotation, sizeof no_rotation);
    memcpy(commanded->origin, no_rotation, sizeof no_rotation);
    memcpy(commanded->base, no_rotation, sizeof no_rotation);
    memcpy(commanded->following_base, no_rotation, sizeof no_rotation);
    memcpy(commanded->rotation, rotation, sizeof commanded->rotation);
    commanded->start = start;
    return 0;
}

int controller_is_due(ControllerState *state, int64_t calls)
{
    const int due = state->held == 0;

    state->held = (state->held + 1) % calls;
    return due;
}

/* y (rows) = a x */
static void panels_times(const Panels *a, const Real *x, Real *y)
{
    memset(y, 0, (size_t)a->rows * sizeof(Real));
    panels_add_times(a, x, y);
}

/* Sine and cosine of the wheels' angles in the middle of a period that begins `ahead` [s] after the measurement,
times speed squared. */
static void jitter_after(const PreparedController *prepared, const Measurements *measured, double ahead, Real *jitter)
{
    double middle[WHEELS], sine[WHEELS], cosine[WHEELS];
    int k;

    for (k = 0; k < WHEELS; k++) {
        const double speed = measured->encoder_speed[k];
        middle[k] = measured->encoder_angle[k] + ahead * speed + 0.5 * prepared->period * speed;
    }
    prepared->sines(WHEELS, middle, sine, cosine);
    for (k = 0; k < WHEELS; k++) {
        const double speed = measured->encoder_speed[k], square = speed * speed;
        jitter[k] = (Real)(sine[k] * square);
        jitter[WHEELS + k] = (Real)(cosine[k] * square);
    }
}

/* Turn an attitude by the small rotation in a state of the linear model: four times its first three. */
static void turn_attitude(const double attitude[4], const Real *linear, double turned[4])
{
    const double rotation[3] = {4.0 * linear[0], 4.0 * linear[1], 4.0 * linear[2]};

    rotate_quaternion(attitude, rotation, turned);
}

/* The small rotation [rad] from the predicted to the measured attitude; the prediction moves to `attitude`.

A first measurement that is far from it is the attitude at which the run begins: the estimate is set to it, and before
a slew has begun the reference too. */
static int attitude_innovation(Component *component, const PreparedController *prepared, ControllerState *state,
                               double time, const Measurements *measured, Real *innovation)
{
    const double limit = prepared->parameters.capture_angle;
    const int first = !state->commanded.captured;
    double seen[4], off[3], square = 0.0;
    int k;

    turn_attitude(state->attitude, state->estimate, state->attitude);
    memset(state->estimate, 0, 3 * sizeof(Real));
    memset(innovation, 0, 3 * sizeof(Real));
    if (!measured->star_tracker_valid)
        return 0;
    quaternion_from_mrp(measured->star_tracker_mrp, seen);
    relative_mrp(seen, state->attitude, off);
    for (k = 0; k < 3; k++) {
        off[k] *= 4.0;
        square += off[k] * off[k];
    }
    state->commanded.captured = 1;
    if (first && square > limit * limit) {
        memcpy(state->attitude, seen, sizeof seen);
        return start_from(component, prepared, &state->commanded, time, seen);
    }
    for (k = 0; k < 3; k++)
        innovation[k] = (Real)off[k];
    return first && start_from(component, prepared, &state->commanded, time, state->commanded.origin);
}

static void predict(const PreparedController *prepared, ControllerState *state)
{
    const Real *late = state->history + (size_t)prepared->whole_delay * WHEELS;
    Real next[STATES];

    panels_times(&prepared->predict, state->estimate, next);
    panels_add_times(&prepared->predict_late, late, next);
    panels_add_times(&prepared->predict_early, late + WHEELS, next);
    if (prepared->parameters.feed_forward_jitter)
        panels_add_times(&prepared->predict_jitter, state->jitter, next);
    if (prepared->estimates_slow)
        add_times_torque(&prepared->slow.enters, &state->slow, next);
    memcpy(state->estimate, next, sizeof next);
    if (prepared->estimates_slow)
        slow_errors_predict(&prepared->slow, late, late + WHEELS, &state->slow);
}

/* Correct torque and biases, before the step's sample of the star tracker is counted. */
static void correct_slow_errors(const PreparedController *prepared, const Measurements *measured, ControllerState *state)
{
    const int64_t steps = state->commanded.captured ? state->since_star_tracker + 1 : prepared->phases + 1;
    double seen[4];

    if (measured->star_tracker_valid)
        quaternion_from_mrp(measured->star_tracker_mrp, seen);
    slow_errors_correct(&prepared->slow, measured->gyro_rate, measured->star_tracker_valid ? seen : NULL, steps,
                        &state->slow);
}

/* Predict the estimate to the time of the measurement and correct it; predict the jitter of the next period. */
static int correct(Component *component, const PreparedController *prepared, ControllerState *state, double time,
                   const Measurements *measured)
{
    Real innovation[MEASURED], expected[MEASURED];
    Real *speed = innovation + GYROS + ACCELEROMETERS, *attitude = speed + WHEELS;
    int64_t phase;
    int k;

    if (state->count > prepared->first_measurement)
        predict(prepared, state);
    if (prepared->estimates_slow)
        correct_slow_errors(prepared, measured, state);
    state->since_star_tracker = measured->star_tracker_valid ? 0 : state->since_star_tracker + 1;
    phase = state->since_star_tracker < prepared->phases ? state->since_star_tracker : prepared->phases - 1;
    memcpy(innovation, measured->gyro_rate, GYROS * sizeof(Real));
    memcpy(innovation + GYROS, measured->accelerometer, ACCELEROMETERS * sizeof(Real));
    for (k = 0; k < WHEELS; k++)
        speed[k] = (Real)(measured->encoder_speed[k] - prepared->nominal_speed[k]);
    for (k = 0; k < 3; k++)
        attitude[k] = (Real)(4.0 * measured->star_tracker_mrp[k]);
    panels_times(&prepared->c, state->estimate, expected);
    for (k = 0; k < MEASURED; k++)
        innovation[k] -= expected[k];
    for (k = 0; k < GYROS; k++)
        innovation[k] -= (Real)state->slow.errors[TORQUES + k];
    if (!prepared->parameters.linear_attitude &&
        attitude_innovation(component, prepared, state, time, measured, attitude))
        return 1;
    panels_add_times(&prepared->gain[phase], innovation, state->estimate);
    if (prepared->parameters.feed_forward_jitter)
        jitter_after(prepared, measured, 0.0, state->jitter);
    return 0;
}

/* Add the torque against the harmonic jitter while the torque of this step will act. */
static void cancel_jitter(const PreparedController *prepared, const Measurements *measured, Real *torque)
{
    const double ahead = prepared->parameters.measurement_delay + prepared->parameters.actuation_delay;
    Real jitter[2 * WHEELS];

    jitter_after(prepared, measured, ahead, jitter);
    panels_add_times(&prepared->jitter_torque, jitter, torque);
}

/* The smoothed reference: the rigid profile itself, modes at rest. */
static void smooth_reference(const PreparedController *prepared, const Motion *profile, double time,
                             const double momentum_axis[3], double *reference)
{
    const double rate = motion_rate(profile, time), turned = motion_rotation(profile, time);
    double momentum[3], *speed = reference + 6 + 2 * MODES;
    int k;

    memset(reference, 0, CONTROLLED * sizeof(double));
    for (k = 0; k < 3; k++) {
        reference[k] = 0.25 * turned * profile->axis[k];
        reference[3 + MODES + k] = rate * profile->axis[k];
        momentum[k] = momentum_axis[k] * rate;
    }
    share_torque(&prepared->slew_wheels, profile->allocation, momentum, speed);
    for (k = 0; k < WHEELS; k++)
        speed[k] /= prepared->wheel_inertia[k];
}

static int any(int count, const double *values)
{
    int k;

    for (k = 0; k < count; k++)
        if (values[k] != 0.0)
            return 1;
    return 0;
}

/* Add the torque that keeps a turning body from being turned by its momentum, and what it does to the wheels. */
static void follow_momentum(const PreparedController *prepared, Commanded *commanded, const double *reference,
                            double *torque)
{
    const double *rate = reference + 3 + MODES, *speed = reference + 6 + 2 * MODES;
    double momentum[3], body[3], added[WHEELS];
    int i, k;

    times_vector(3, 3, prepared->inertia, rate, momentum);
    for (k = 0; k < WHEELS; k++)
        for (i = 0; i < 3; i++)
            momentum[i] += prepared->wheel_inertia[k] * (prepared->nominal_speed[k] + speed[k]) *
                           prepared->slew_wheels.axes[3 * k + i];
    for (i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, l = (i + 2) % 3;
        body[i] = rate[j] * momentum[l] - rate[l] * momentum[j];
    }
    share_torque(&prepared->slew_wheels, commanded->profile.allocation, body, added);
    for (k = 0; k < WHEELS; k++) {
        torque[k] += added[k];
        commanded->reference[6 + 2 * MODES + k] += prepared->period * added[k] / prepared->wheel_inertia[k];
    }
}

/* Write the reference at `time` and the feed-forward torque from then on; propagate the reference by a period. The
reference attitude is body from inertial. */
static void refer(const PreparedController *prepared, ControllerState *state, double time,
                  const ControllerOutputs *outputs, double attitude[4])
{
    Commanded *commanded = &state->commanded;
    const Motion *profile = &commanded->profile;
    const double change = shaped_rate_change(profile, &prepared->shaper, time, prepared->period);
    double momentum_axis[3], body_torque[3], origin[3], torque[WHEELS], reference[CONTROLLED];
    int k;

    times_vector(3, 3, prepared->inertia, profile->axis, momentum_axis);
    for (k = 0; k < 3; k++)
        body_torque[k] = momentum_axis[k] * (change / prepared->period);
    share_torque(&prepared->slew_wheels, profile->allocation, body_torque, torque);
    if (prepared->smoothed) {
        smooth_reference(prepared, profile, time, momentum_axis, reference);
    } else {
        memcpy(reference, commanded->reference, sizeof reference);
        memset(commanded->reference, 0, sizeof commanded->reference);
        if (any(CONTROLLED, reference)) /* between slews there is nothing to propagate */
            panels_add_times_exactly(&prepared->reference_a, reference, commanded->reference);
        if (any(WHEELS, torque))
            panels_add_times_exactly(&prepared->reference_b, torque, commanded->reference);
        if (prepared->parameters.gyroscopic && profile->angle > 0.0 && time < profile->end + shaper_spacing(prepared))
            follow_momentum(prepared, commanded, reference, torque);
    }
    reference_attitude(commanded->origin, profile->axis, reference, attitude);
    if (prepared->parameters.linear_attitude) {
        mrp_from_quaternion(commanded->origin, origin);
        for (k = 0; k < 3; k++)
            reference[k] += origin[k];
    } else {
        mrp_from_quaternion(attitude, reference);
    }
    for (k = 0; k < CONTROLLED; k++)
        outputs->reference[k] = (Real)reference[k];
    for (k = 0; k < WHEELS; k++)
        outputs->reference_torque[k] = (Real)torque[k];
}

/* Limit to the motor, then to what leaves the speed band within a period (PHYSICS section 6). */
static void saturate(const PreparedController *prepared, const Real *speed, Real *torque)
{
    const double *limits = prepared->parameters.torque_limits, *bands = prepared->parameters.speed_bands;
    int k;

    for (k = 0; k < WHEELS; k++) {
        const double scale = prepared->wheel_inertia[k] / prepared->period;
        const double limited = fmin(fmax(torque[k], -limits[k]), limits[k]);
        torque[k] = (Real)fmin(fmax(limited, scale * (-bands[k] - speed[k])), scale * (bands[k] - speed[k]));
    }
}

/* Add the null motion of the wheels, which has what the limits leave. */
static void move_wheels(const PreparedController *prepared, const Real *speed, Real *torque)
{
    const double *limits = prepared->parameters.torque_limits, *bands = prepared->parameters.speed_bands;
    double momenta[WHEELS], least[WHEELS], most[WHEELS], added[WHEELS];
    int k;

    for (k = 0; k < WHEELS; k++) {
        const double scale = prepared->wheel_inertia[k] / prepared->period;
        least[k] = fmax(scale * (-bands[k] - speed[k]), -limits[k]) - torque[k];
        most[k] = fmin(scale * (bands[k] - speed[k]), limits[k]) - torque[k];
        momenta[k] = prepared->wheel_inertia[k] * speed[k];
    }
    null_torque(&prepared->null_motion, momenta, least, most, added);
    for (k = 0; k < WHEELS; k++)
        torque[k] += (Real)added[k];
}

/* The state when the torque of this step will act. */
static void look_ahead(const PreparedController *prepared, const ControllerState *state, Real *expected)
{
    if (!prepared->delayed) {
        memcpy(expected, state->estimate, CONTROLLED * sizeof(Real));
        return;
    }
    panels_times(&prepared->ahead, state->estimate, expected);
    panels_add_times(&prepared->ahead_history, state->history, expected);
    if (prepared->estimates_slow)
        add_times_torque(&prepared->slow.ahead, &state->slow, expected);
}

/* What the regulator acts on, and the estimate as an output. */
static void compare(const PreparedController *prepared, const ControllerState *state, const Real *expected,
                    const double attitude[4], const ControllerOutputs *outputs, Real *error)
{
    double estimated[4], turn[3];
    int k;

    for (k = 0; k < CONTROLLED; k++)
        error[k] = expected[k] - outputs->reference[k];
    memcpy(outputs->estimate, state->estimate, CONTROLLED * sizeof(Real));
    if (prepared->parameters.linear_attitude)
        return;
    turn_attitude(state->attitude, state->estimate, estimated);
    mrp_from_quaternion(estimated, turn);
    for (k = 0; k < 3; k++)
        outputs->estimate[k] = (Real)turn[k];
    if (prepared->delayed)
        turn_attitude(state->attitude, expected, estimated);
    relative_mrp(estimated, attitude, turn);
    for (k = 0; k < 3; k++)
        error[k] = (Real)turn[k];
}

int controller_step(Component *component, const PreparedController *prepared, ControllerState *state, double time,
                    const Measurements *measured, const ControllerOutputs *outputs)
{
    Real expected[CONTROLLED], error[CONTROLLED], correction[WHEELS], *torque = outputs->torque;
    double attitude[4];
    int k;

    if (measured->applied_valid && state->count > 0)
        memcpy(state->history, measured->applied_torque, WHEELS * sizeof(Real));
    if (state->count >= prepared->first_measurement && correct(component, prepared, state, time, measured))
        return 1;
    if (proceed(component, prepared, &state->commanded, time))
        return 1;
    look_ahead(prepared, state, expected);
    refer(prepared, state, time + prepared->parameters.actuation_delay, outputs, attitude);
    compare(prepared, state, expected, attitude, outputs, error);
    if (prepared->parameters.null_rate > 0.0) /* the gain sees wheel speeds where they give no momentum alone */
        memset(error + CONTROLLED - WHEELS, 0, WHEELS * sizeof(Real));
    panels_times(&prepared->feedback, error, correction);
    for (k = 0; k < WHEELS; k++)
        torque[k] = outputs->reference_torque[k] - correction[k];
    if (prepared->cancels_jitter && state->count >= prepared->first_measurement)
        cancel_jitter(prepared, measured, torque);
    if (prepared->estimates_slow)
        add_times_torque(&prepared->slow.against, &state->slow, torque);
    for (k = 0; k < SLOW; k++)
        outputs->slow_errors[k] = (Real)state->slow.errors[k];
    saturate(prepared, expected + CONTROLLED - WHEELS, torque);
    if (prepared->parameters.null_rate > 0.0)
        move_wheels(prepared, expected + CONTROLLED - WHEELS, torque);
    if (prepared->parameters.open_loop)
        memset(torque, 0, WHEELS * sizeof(Real));
    memmove(state->history + WHEELS, state->history, (history_size(prepared) - WHEELS) * sizeof(Real));
    memcpy(state->history, torque, WHEELS * sizeof(Real));
    state->count++;
    return 0;
}
