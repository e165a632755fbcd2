/* Equations of motion: P, with the terms as PHYSICS section 2 gives them. The vibration and the momentum of the whole
are carried exactly, with loads held over a step; the gyroscopic and momentum terms are evaluated once, at a predicted
mid-step. Error order: 2 in the step. */
#include "plant_step.h"

#include <string.h>

#include "bearing_friction.h"
#include "linear_algebra.h"
#include "motors.h"
#include "ports.h"
#include "rotations.h"

static const double HALF_TURN = 3.141592653589793;

/* Set the loads of gyroscopic torques and momentum terms, from momenta (6) and speeds (6 + u). */
static void set_internal(Plant *plant, const double *momenta, const double *speeds)
{
    const int n = plant->motion.matrices.wheels;
    const double *p = momenta, *h = momenta + 3, *w = speeds + 3;
    double *held = plant->work.held, *terms = held + 2 * n;
    int i;

    sparse_times(&plant->motion.gyroscopic, speeds + 3, held);
    for (i = 0; i < n; i++) {
        held[i] *= plant->state.axial[i];
        held[n + i] *= plant->state.axial[i];
    }
    for (i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        terms[i] = w[j] * p[k] - w[k] * p[j];
        terms[3 + i] = w[j] * h[k] - w[k] * h[j];
    }
    sparse_times(&plant->motion.load_of_internal, held, plant->state.internal);
}

static void add(int count, const double *a, const double *b, double *sum)
{
    int i;

    for (i = 0; i < count; i++)
        sum[i] = a[i] + b[i];
}

/* Velocity, rate and slope rates, (6 + u), from z and momenta. */
static void find_speeds(const Motion *motion, const double *z, const double *momenta, double *speeds)
{
    memset(speeds, 0, (size_t)motion->speeds * sizeof(double));
    panels_add_times(&motion->speed, z, speeds);
    add_times_vector(6, 6, motion->compliance, momenta, speeds);
}

/* The same at the present time, and without momenta at the middle of the next step, from the z of both: one pass. */
static void find_both_speeds(Plant *plant)
{
    const Motion *motion = &plant->motion;
    PlantWork *work = &plant->work;
    const double *z = plant->state.z;

    map_vector(&motion->free, &plant->step->half, z, work->middle);
    memset(work->seen, 0, (size_t)motion->speeds * sizeof(double));
    memset(work->ahead, 0, (size_t)motion->speeds * sizeof(double));
    motion->speed.products(&motion->speed, z, work->middle, work->seen, work->ahead);
    add_times_vector(6, 6, motion->compliance, plant->state.momentum, work->seen);
    work->ahead_length = plant->step->length;
}

/* See the present state beyond the speeds: accelerations without products and loads, turn due to eta. */
static void look(Plant *plant)
{
    const Motion *motion = &plant->motion;
    const FreeModes *free = &motion->free;
    const double *z = plant->state.z, *seconds = z + free->read;
    double *folded = plant->work.folded, *acceleration = plant->work.seen + motion->speeds;
    const int alone = free->alone;

    free->two_products(alone, motion->fold_p, z, motion->fold_q, seconds, folded);
    memcpy(folded + alone, z + alone, (size_t)(free->read - alone) * sizeof(double));
    memset(acceleration, 0, (size_t)motion->matrices.accelerometers * sizeof(double));
    panels_add_times(&motion->restoring, folded, acceleration);
    sparse_times(&motion->turn, z, plant->work.turn);
}

/* Let the loads act on z over the step: `end` is z of its end, without them before. */
static void drive(Plant *plant, double *end)
{
    const FreeModes *free = &plant->motion.free;
    double *pushed = plant->work.pushed, *seconds = end + free->read;
    int i;

    memset(pushed, 0, (size_t)free->alone * sizeof(double));
    panels_add_times(&plant->motion.push, plant->state.load, pushed);
    for (i = 0; i < free->alone; i++) {
        end[i] += plant->step->push_p[i] * pushed[i];
        seconds[i] += plant->step->push_q[i] * pushed[i];
    }
    panels_add_times(&plant->step->driven, plant->state.load, end);
}

/* Write the outputs from what is seen; accelerations are those with the loads held last. */
static void write_outputs(Component *component, Plant *plant)
{
    const Motion *motion = &plant->motion;
    const int n = motion->matrices.wheels, k = motion->matrices.accelerometers;
    double *seen = plant->work.seen, *acceleration = seen + motion->speeds, *products = acceleration + k + n;
    const double *v = seen, *w = seen + 3;
    int i;

    panels_add_times(&motion->acceleration, plant->state.load, acceleration);
    memcpy(acceleration + k, plant->state.axial, (size_t)n * sizeof(double));
    for (i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, l = (i + 2) % 3;
        products[i] = w[j] * v[l] - w[l] * v[j];
        products[3 + i] = w[i] * w[i];
    }
    products[6] = w[0] * w[1];
    products[7] = w[0] * w[2];
    products[8] = w[1] * w[2];
    sparse_times(&motion->output, seen, component->real + PORT_RATE); /* and all up to the accelerations */
    memcpy(component->real + PORT_ATTITUDE_MRP, plant->state.mrp, 3 * sizeof(double));
    quaternion_from_mrp(plant->state.mrp, component->real + PORT_ATTITUDE_QUATERNION);
    memcpy(component->real + PORT_WHEEL_ANGLE, plant->state.angle, (size_t)n * sizeof(double));
}

/* Hold the inputs from now on, the torques limited and with friction. `end` is z at the step's end, without loads. */
static void hold(Component *component, Plant *plant, const double *end)
{
    const Motion *motion = &plant->motion;
    const int r = motion->loads.count;
    double *given = plant->work.given;

    memcpy(given, component->real + PORT_WHEEL_TORQUE, (size_t)motion->loads.inputs * sizeof(double));
    drive_motors(plant, given);
    sparse_times(&motion->load_of_input, given, plant->work.input_load);
    /* with the internal loads of the last step, to predict the middle of this one */
    add(r, plant->work.input_load, plant->state.internal, plant->state.load);
    if (plant->step->braked > 0) {
        add_friction(plant, component->real + PORT_WHEEL_FRICTION_TORQUE, end);
        sparse_times(&motion->load_of_input, given, plant->work.input_load);
        add(r, plant->work.input_load, plant->state.internal, plant->state.load);
    }
}

/* Evaluate what is explicit, at a predicted mid-step, and let the torques act on the rotors. */
static void act(Plant *plant)
{
    const Motion *motion = &plant->motion;
    PlantState *state = &plant->state;
    const int n = motion->matrices.wheels;
    const double half = 0.5 * plant->step->length, *torque = plant->work.given;
    double momenta[6], *speeds = plant->work.speeds;
    int i;

    if (plant->work.ahead_length == plant->step->length) {
        memcpy(speeds, plant->work.ahead, (size_t)motion->speeds * sizeof(double));
    } else { /* the first step, or one after steps of another length */
        map_vector(&motion->free, &plant->step->half, state->z, plant->work.middle);
        memset(speeds, 0, (size_t)motion->speeds * sizeof(double));
        panels_add_times(&motion->speed, plant->work.middle, speeds);
    }
    for (i = 0; i < 6; i++)
        momenta[i] = state->momentum[i] + half * state->load[i];
    add_times_vector(6, 6, motion->compliance, momenta, speeds);
    panels_add_times(&plant->step->middle_of_load, state->load, speeds);
    for (i = 0; i < n; i++)
        state->axial[i] += half * torque[i];
    set_internal(plant, momenta, speeds);
    for (i = 0; i < n; i++)
        state->axial[i] += half * torque[i];
    add(motion->loads.count, plant->work.input_load, state->internal, state->load);
}

int plant_step(Component *component, Plant *plant)
{
    const Motion *motion = &plant->motion;
    PlantState *state = &plant->state;
    const int n = motion->matrices.wheels;
    const double length = plant->step->length, *speed = component->real + PORT_WHEEL_SPEED;
    double *end = plant->work.end, turned[3];
    int i, j;

    map_vector(&motion->free, &plant->step->whole, state->z, end);
    hold(component, plant, end);
    act(plant);

    drive(plant, end);
    memcpy(state->z, end, 2 * (size_t)motion->free.modes * sizeof(double));
    for (i = 0; i < 3; i++) { /* the body turns by its momentum's integral, and by what the structure moves */
        turned[i] = 0.0;
        for (j = 0; j < 6; j++)
            turned[i] += motion->compliance[6 * (3 + i) + j] *
                         (length * state->momentum[j] + 0.5 * length * length * state->load[j]);
    }
    for (i = 0; i < 6; i++)
        state->momentum[i] += length * state->load[i];
    find_both_speeds(plant);
    look(plant);
    for (i = 0; i < 3; i++) {
        turned[i] += plant->work.turn[i] - state->turn[i];
        state->turn[i] = plant->work.turn[i];
    }
    if (!(turned[0] * turned[0] + turned[1] * turned[1] + turned[2] * turned[2] < HALF_TURN * HALF_TURN))
        return refuse(component, /* the negation also finds NaN */
                      "the motion has diverged: steps of %g s are too long for this rate; take shorter ones", length);
    rotate_mrp(state->mrp, turned, state->mrp);
    write_outputs(component, plant);
    /* trapezoid: exact for the spin, second order for the mount's motion */
    for (i = 0; i < n; i++)
        state->angle[i] += 0.5 * length * (state->speed[i] + speed[i]);
    memcpy(component->real + PORT_WHEEL_ANGLE, state->angle, (size_t)n * sizeof(double));
    memcpy(state->speed, speed, (size_t)n * sizeof(double));
    return 0;
}

void plant_feed_through(Component *component, Plant *plant)
{
    const Motion *motion = &plant->motion;

    if (plant->step->braked > 0)
        map_vector(&motion->free, &plant->step->whole, plant->state.z, plant->work.end);
    hold(component, plant, plant->work.end);
    find_speeds(motion, plant->state.z, plant->state.momentum, plant->work.seen);
    look(plant);
    write_outputs(component, plant);
}

void plant_place(Plant *plant, const double *eta, const double *body, const double *speed)
{
    const Motion *motion = &plant->motion;
    PlantState *state = &plant->state;
    const int m = motion->matrices.modes, size = 6 + m;
    int i, j;

    coordinates_of(&motion->free, 1, eta, speed, state->z);
    for (i = 0; i < 6; i++) {
        state->momentum[i] = 0.0;
        for (j = 0; j < size; j++)
            state->momentum[i] += motion->mass[i * size + j] * (j < 6 ? body[j] : speed[j - 6]);
    }
    find_speeds(motion, state->z, state->momentum, plant->work.speeds);
    set_internal(plant, state->momentum, plant->work.speeds);
    memcpy(state->load, state->internal, (size_t)motion->loads.count * sizeof(double));
    plant->work.ahead_length = 0.0;
}

void plant_begin(Component *component, Plant *plant)
{
    const Motion *motion = &plant->motion;
    const PlantMatrices *matrices = &motion->matrices;
    const PlantParameters *given = &motion->parameters;
    const int n = matrices->wheels, m = matrices->modes, all = matrices->data->frequency_rows;
    PlantState *state = &plant->state;
    double body[6], quaternion[4];
    int i, j, axis;

    quaternion_from_mrp(given->mrp, quaternion);
    mrp_from_quaternion(quaternion, state->mrp);
    for (i = 0; i < n; i++) {
        const double *direction = matrices->wheel_axis + 3 * i;
        double speed = given->wheel_speed[i];
        for (axis = 0; axis < 3; axis++) {
            const double *slope = matrices->wheel_slope + (size_t)(3 * i + axis) * (size_t)all;
            speed += direction[axis] * given->rate[axis];
            for (j = 0; j < m; j++)
                speed += direction[axis] * slope[j] * given->modal_velocity[j];
        }
        state->axial[i] = matrices->data->wheel_inertia[i] * speed;
        state->angle[i] = given->wheel_angle[i];
        state->speed[i] = given->wheel_speed[i];
    }
    memcpy(body, given->velocity, 3 * sizeof(double));
    memcpy(body + 3, given->rate, 3 * sizeof(double));
    plant_place(plant, given->modal_displacement, body, given->modal_velocity);
    find_speeds(motion, state->z, state->momentum, plant->work.seen);
    look(plant);
    memcpy(state->turn, plant->work.turn, 3 * sizeof(double));
    write_outputs(component, plant);
}
