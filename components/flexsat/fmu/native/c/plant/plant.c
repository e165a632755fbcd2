/* The plant behind the FMI layer: the flexible spacecraft with its reaction wheels; the twin of fmu/python/plant.py. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "bearing_friction.h"
#include "component.h"
#include "number_text.h"
#include "plant_derivatives.h"
#include "plant_step.h"
#include "plant_telemetry.h"
#include "ports.h"
#include "turned_state.h"
#include "turning_appendages.h"

/* What stays when the plant is prepared for other angles, and where the memory begins that is prepared anew. */
typedef struct TurningPlant {
    Plant plant; /* first: the component's own */
    Kept kept;
    MemoryBlock *mark;
    int angles; /* t */
} TurningPlant;

static const double SHORTEST = 1e-9; /* s: lengths of steps are whole multiples of it */

/* Let the views point into the block of the state, and return how many doubles it has. */
static size_t lay_out(const Motion *motion, double *block, PlantState *state)
{
    const size_t m = (size_t)motion->matrices.modes, n = (size_t)motion->matrices.wheels;
    const size_t r = (size_t)motion->loads.count;
    double **views[10];
    size_t sizes[10] = {1, 3, 2 * m, 6, r, r, n, n, n, 3}, place = 0;
    int i;

    views[0] = &state->length, views[1] = &state->mrp, views[2] = &state->z, views[3] = &state->momentum;
    views[4] = &state->load, views[5] = &state->internal, views[6] = &state->axial, views[7] = &state->angle;
    views[8] = &state->speed, views[9] = &state->turn;
    for (i = 0; i < 10; place += sizes[i++])
        if (block != NULL)
            *views[i] = block + place;
    return place;
}

static int take_work(Memory *memory, const Motion *motion, PlantWork *work)
{
    const size_t m = (size_t)motion->matrices.modes, n = (size_t)motion->matrices.wheels;
    const size_t k = (size_t)motion->matrices.accelerometers, speeds = (size_t)motion->speeds;

    work->given = memory_doubles(memory, (size_t)motion->loads.inputs);
    work->input_load = memory_doubles(memory, (size_t)motion->loads.count);
    work->held = memory_doubles(memory, 2 * n + 6);
    work->speeds = memory_doubles(memory, speeds);
    work->middle = memory_doubles(memory, 2 * m);
    work->ahead = memory_doubles(memory, speeds);
    work->end = memory_doubles(memory, 2 * m);
    work->folded = memory_doubles(memory, 2 * m);
    work->pushed = memory_doubles(memory, m);
    work->turn = memory_doubles(memory, 3);
    work->seen = memory_doubles(memory, speeds + k + n + PRODUCTS);
    work->unbraked = memory_doubles(memory, n);
    work->holding = memory_doubles(memory, 2 * n);
    work->response = memory_doubles(memory, n * n);
    work->structure = memory_doubles(memory, 2 * m);
    work->input_change = memory_doubles(memory, (size_t)motion->loads.inputs);
    work->load_change = memory_doubles(memory, (size_t)motion->loads.count);
    work->present_load = memory_doubles(memory, (size_t)motion->loads.count);
    return memory->failed;
}

/* Use the plant prepared for steps of a length, or prepare it in the place of the one made first. */
static void use_step(Component *component, Plant *plant, double length)
{
    int i;

    for (i = 0; i < KEPT_STEPS && plant->steps[i].length != length; i++)
        ;
    if (i == KEPT_STEPS) {
        i = plant->next;
        plant->next = (i + 1) % KEPT_STEPS;
        at_step(&plant->motion, length, &plant->steps[i]);
    }
    plant->step = &plant->steps[i];
    *plant->state.length = length;
    if (plant->step->braked < 0)
        prepare_friction(plant, component->real + PORT_WHEEL_FRICTION_TORQUE);
}

/* Doubles of the state of any plant that a component may start. */
static size_t most_doubles(void)
{
    const size_t loads = 6 + 6 * (size_t)PORT_JITTER_FORCE_X_SIZE + 3;

    return 1 + 3 + 2 * (size_t)PORT_MODAL_DISPLACEMENT_SIZE + 6 + 2 * loads + 3 * (size_t)PORT_WHEEL_TORQUE_SIZE + 3;
}

/* Prepare for the present parameters, but for the state. */
static int prepare(Component *component, TurningPlant *own)
{
    Plant *plant = &own->plant;
    const double *angle = appendage_angles(component);
    int i;

    if (prepare_motion(component, &plant->motion))
        return 1;
    for (i = 0; i < KEPT_STEPS; i++)
        if (take_step(component, &plant->motion, &plant->steps[i]))
            return 1;
    plant->next = 0;
    if (take_work(&component->memory, &plant->motion, &plant->work))
        return refuse(component, "there is not enough memory");
    for (i = 0; i < own->angles; i++)
        own->kept.angle[i] = angle[i];
    component->state_size = sizeof(double) * lay_out(&plant->motion, (double *)(void *)component->state, &plant->state);
    return 0;
}

int component_start(Component *component)
{
    Memory *memory = &component->memory;
    TurningPlant *own = memory_take(memory, 1, sizeof(TurningPlant));
    Plant *plant = own == NULL ? NULL : &own->plant;

    component->own = plant;
    component->step_length = 0.0;
    component->state = memory_take(memory, most_doubles(), sizeof(double));
    if (memory->failed)
        return refuse(component, "there is not enough memory");
    own->angles = plant_corrected.turn_axis_rows;
    if (take_kept(memory, PORT_MODAL_DISPLACEMENT_SIZE, own->angles, &own->kept))
        return refuse(component, "there is not enough memory");
    own->mark = memory->last;
    if (prepare(component, own))
        return 1;
    use_step(component, plant, plant->motion.matrices.data->step_size);
    plant_begin(component, plant);
    return 0;
}

/* Prepare the plant for the present angles, and continue its motion. */
static int turn(Component *component, TurningPlant *own)
{
    Plant *plant = &own->plant;
    const double length = plant->step->length;

    keep_motion(plant, &own->kept);
    memory_rewind(&component->memory, own->mark);
    if (prepare(component, own))
        return 1;
    use_step(component, plant, length);
    continue_motion(component, plant, &own->kept);
    return 0;
}

int component_first_step(Component *component, double length)
{
    (void)component;
    (void)length; /* steps may differ */
    return 0;
}

int component_advance(Component *component, double time, double length)
{
    Plant *plant = component->own;
    char text[NUMBER_SIZE];

    (void)time;
    if (length != plant->step->length) {
        /* masters that subtract times give the same step with other last digits */
        const double rounded = floor(length / SHORTEST + 0.5) / 1e9;
        if (!(rounded > 0.0))
            return refuse(component, "a step of %s s is not accepted; the shortest is 1e-9 s", number_text(rounded, text));
        use_step(component, plant, rounded);
    }
    return plant_step(component, plant);
}

int component_tuned(Component *component)
{
    Plant *plant = component->own;
    TurningPlant *own = component->own;
    const double *angle = appendage_angles(component);
    int i;

    for (i = 0; i < own->angles; i++)
        if (angle[i] != own->kept.angle[i])
            return turn(component, own);
    for (i = 0; i < KEPT_STEPS; i++)
        plant->steps[i].braked = -1;
    prepare_friction(plant, component->real + PORT_WHEEL_FRICTION_TORQUE);
    return 0;
}

int component_follow_inputs(Component *component)
{
    plant_feed_through(component, component->own);
    return 0;
}

int component_differentiate(Component *component, const double *seed, double *change)
{
    plant_differentiate(component, component->own, seed, change);
    return 0;
}

int component_evaluate(Component *component)
{
    plant_telemetry(component, component->own);
    return 0;
}

int component_restored(Component *component)
{
    Plant *plant = component->own;
    const double length = *plant->state.length;

    if (!(length > 0.0 && length <= DBL_MAX))
        return refuse(component, "the saved state has a step of %g s, which is none", length);
    plant->work.ahead_length = 0.0;
    use_step(component, plant, length);
    return component_tuned(component);
}
