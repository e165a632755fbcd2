#include "operations.h"

#include <string.h>

#include "arrays.h"
#include "memory.h"

/* Return how many operations a step has at most: with FMI 3.0, one for each array. */
static size_t most_of(const step_t *step)
{
    size_t most = 1;

    for (uint32_t k = 0; k < step->set_count; k++)
        most += 4 + (size_t)step->sets[k].count;
    for (uint32_t k = 0; k < step->get_count; k++)
        most += 3 + (size_t)step->gets[k].count;
    return most;
}

typedef struct {
    bundle_t *bundle;
    tick_operation *operations;
    size_t count;
    int bad; /* there is no memory */
} maker_t;

static tick_operation *add(maker_t *maker, uint32_t kind, uint32_t component, const set_t *set, const get_t *get)
{
    tick_operation *made = &maker->operations[maker->count];
    origin_t *origin = &maker->bundle->origins[maker->count];

    maker->count++;
    made->kind = kind;
    origin->component = component;
    origin->set = set;
    origin->get = get;
    return made;
}

/* Return the positions of elements in the memory of their type; NULL if there is no memory. */
static int64_t *positions_of(bundle_t *bundle, const component_t *component, const uint32_t *references, size_t count)
{
    int64_t *positions = keep(bundle, count, sizeof *positions);

    for (size_t k = 0; positions != NULL && k < count; k++)
        positions[k] = (int64_t)component->elements[references[k]].position;
    return positions;
}

/* Set or get the arrays of elements, one call for each run of neighbours. */
static void add_arrays(maker_t *maker, uint32_t number, const set_t *set, const get_t *get)
{
    const component_t *component = &maker->bundle->components[number];
    const int type = (int)(set != NULL ? set->type : get->type);
    const arrays_t *arrays = &component->arrays[type];
    char *memory = set != NULL ? arrays->memory : arrays->fetched;
    uint32_t array = 0, end;

    touch_arrays(component, type, set != NULL ? set->targets : get->references, set != NULL ? set->count : get->count);
    for (; next_run(arrays, &array, &end); array = end) {
        tick_operation *made = add(maker, TICK_ARRAYS, number, set, get);
        made->references = &arrays->handles[array];
        made->count = end - array;
        made->buffer = memory + arrays->begins[array] * array_sizes[type];
        made->values = arrays->begins[end] - arrays->begins[array];
    }
}

static void add_set(maker_t *maker, uint32_t component, const set_t *set)
{
    tick_operation *made = add(maker, set->type == REAL ? TICK_GATHER_8 : TICK_GATHER_4, component, set, NULL);

    made->source = maker->bundle->bus[set->type];
    made->index = set->sources;
    made->buffer = set->buffer;
    made->count = set->count;
    if (set->gains != NULL) {
        made = add(maker, TICK_CONVERT, component, set, NULL);
        made->buffer = set->buffer;
        made->first = set->gains;
        made->second = set->biases;
        made->count = set->count;
    }
    if (maker->bundle->components[component].flags & VERSION_3) {
        static const uint32_t kinds[BUS_TYPES] = {TICK_SCATTER_8, TICK_SCATTER_4, TICK_NARROW};
        const component_t *third = &maker->bundle->components[component];
        made = add(maker, kinds[set->type], component, set, NULL);
        made->source = set->buffer;
        made->index = positions_of(maker->bundle, third, set->targets, set->count);
        made->buffer = third->arrays[set->type].memory;
        made->count = set->count;
        maker->bad |= made->index == NULL;
        add_arrays(maker, component, set, NULL);
        return;
    }
    made = add(maker, TICK_VALUES, component, set, NULL);
    made->references = set->targets;
    made->buffer = set->buffer;
    made->count = set->count;
}

static void add_get(maker_t *maker, uint32_t component, const get_t *get)
{
    const component_t *from = &maker->bundle->components[component];
    char *place = (char *)maker->bundle->bus[get->type] + get->start * sizes[get->type];
    tick_operation *made;

    if (from->flags & VERSION_3) {
        static const uint32_t kinds[BUS_TYPES] = {TICK_GATHER_8, TICK_GATHER_4, TICK_WIDEN};
        add_arrays(maker, component, NULL, get);
        made = add(maker, kinds[get->type], component, NULL, get);
        made->source = from->arrays[get->type].fetched;
        made->index = positions_of(maker->bundle, from, get->references, get->count);
        maker->bad |= made->index == NULL;
    } else {
        made = add(maker, TICK_VALUES, component, NULL, get);
        made->references = get->references;
    }
    made->buffer = place;
    made->count = get->count;
    if (get->type == REAL && get->checked) {
        made = add(maker, TICK_FINITE, component, NULL, get);
        made->buffer = place;
        made->marks = get->unused;
        made->count = get->count;
    }
}

static void add_step(maker_t *maker, const step_t *step)
{
    component_t *component;
    tick_operation *made;

    for (uint32_t k = 0; k < step->set_count; k++)
        add_set(maker, step->component, &step->sets[k]);
    component = &maker->bundle->components[step->component];
    made = add(maker, component->flags & VERSION_3 ? TICK_STEP_3 : TICK_STEP_2, step->component, NULL, NULL);
    made->length = component->length;
    made->marks = (unsigned char *)component->flags3;
    made->buffer = &component->reached;
    for (uint32_t k = 0; k < step->get_count; k++)
        add_get(maker, step->component, &step->gets[k]);
}

/* Append the operations of steps to the order; `begins` are the first of each step, and the one after the last. */
static uint32_t *append(uint32_t *to, const counts_t *steps, const size_t *begins)
{
    for (uint32_t k = 0; k < steps->count; k++)
        for (size_t n = begins[steps->items[k]]; n < begins[steps->items[k] + 1]; n++)
            *to++ = (uint32_t)n;
    return to;
}

static size_t operations_of(const counts_t *steps, const size_t *begins)
{
    size_t count = 0;

    for (uint32_t k = 0; k < steps->count; k++)
        count += begins[steps->items[k] + 1] - begins[steps->items[k]];
    return count;
}

static int make_order(bundle_t *bundle, const size_t *begins, uint32_t mark)
{
    uint64_t *first = keep(bundle, bundle->cycle, sizeof *first), *last = keep(bundle, bundle->cycle, sizeof *last);
    size_t size = bundle->cycle;
    uint32_t *order, *end;

    for (uint32_t k = 0; k < bundle->cycle; k++)
        size += operations_of(&bundle->ticks[k].early, begins) + operations_of(&bundle->ticks[k].late, begins);
    order = end = keep(bundle, size, sizeof *order);
    bundle->mark_positions = keep(bundle, bundle->cycle, sizeof *bundle->mark_positions);
    if (first == NULL || last == NULL || order == NULL || bundle->mark_positions == NULL)
        return 0;
    for (uint32_t k = 0; k < bundle->cycle; k++) {
        first[k] = (uint64_t)(end - order);
        end = append(end, &bundle->ticks[k].early, begins);
        bundle->mark_positions[k] = (uint64_t)(end - order);
        *end++ = mark;
        end = append(end, &bundle->ticks[k].late, begins);
        last[k] = (uint64_t)(end - order);
    }
    bundle->state.order = order;
    bundle->state.begins = first;
    bundle->state.ends = last;
    bundle->state.cycle = bundle->cycle;
    return 1;
}

int make_operations(bundle_t *bundle)
{
    maker_t maker = {bundle, NULL, 0, 0};
    size_t most = 1, *begins = keep(bundle, (size_t)bundle->step_count + 1, sizeof *begins);

    for (uint32_t k = 0; k < bundle->step_count; k++)
        most += most_of(&bundle->steps[k]);
    maker.operations = keep(bundle, most, sizeof *maker.operations);
    bundle->origins = keep(bundle, most, sizeof *bundle->origins);
    if (begins == NULL || maker.operations == NULL || bundle->origins == NULL)
        return 0;
    for (uint32_t k = 0; k < bundle->step_count; k++) {
        begins[k] = maker.count;
        add_step(&maker, &bundle->steps[k]);
    }
    if (maker.bad)
        return 0;
    begins[bundle->step_count] = maker.count;
    bundle->mark = add(&maker, TICK_CALLER, 0, NULL, NULL);
    bundle->mark->until = INT64_MAX;
    bundle->state.operations = maker.operations;
    return make_order(bundle, begins, (uint32_t)(bundle->mark - maker.operations));
}

/* Copy a function to a pointer of another type: all of them are called with their own. */
#define COPY_FUNCTION(to, from) memcpy(&(to), &(from), sizeof(to))

void bind_operations(bundle_t *bundle)
{
    tick_operation *operations = (tick_operation *)bundle->state.operations;

    for (tick_operation *one = operations; one != bundle->mark; one++) {
        const origin_t *origin = &bundle->origins[one - operations];
        const component_t *component = &bundle->components[origin->component];
        one->instance = component->instance;
        if (one->kind == TICK_STEP_3)
            COPY_FUNCTION(one->function, component->call.do_step3);
        else if (one->kind == TICK_ARRAYS && origin->set != NULL)
            COPY_FUNCTION(one->function, component->call.set3[origin->set->type]);
        else if (one->kind == TICK_ARRAYS)
            COPY_FUNCTION(one->function, component->call.get3[origin->get->type]);
        else if (one->kind == TICK_STEP_2)
            COPY_FUNCTION(one->function, component->call.do_step);
        else if (one->kind == TICK_VALUES && origin->set != NULL)
            COPY_FUNCTION(one->function, component->call.set[origin->set->type]);
        else if (one->kind == TICK_VALUES)
            COPY_FUNCTION(one->function, component->call.get[origin->get->type]);
    }
}

void go_to_mark(bundle_t *bundle)
{
    tick_state *state = &bundle->state;

    state->begun = 1;
    state->position = bundle->mark_positions[(uint64_t)state->tick % state->cycle];
    state->time = time_now(bundle);
}
