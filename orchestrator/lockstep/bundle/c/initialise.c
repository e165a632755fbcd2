#include "initialise.h"

#include <string.h>

#include "components.h"
#include "finite.h"
#include "messages.h"
#include "values.h"

/* Return how many ticks there are up to the stop time, the last one whole or not. */
static int64_t ticks_to_stop(const bundle_t *bundle)
{
    double ticks = (bundle->stop - bundle->start) * (double)bundle->second / (double)bundle->state.length;
    int64_t whole;

    if (!(ticks >= 0.0 && ticks < 9e15))
        return 0;
    whole = (int64_t)ticks;
    return ticks - (double)whole > 1e-6 ? whole + 1 : whole;
}

static fmi2Status announce(component_t *component)
{
    bundle_t *bundle = component->bundle;
    experiment_t *experiment = &component->experiment;
    double tolerance = bundle->tolerance_defined ? bundle->tolerance : component->tolerance;
    int64_t last = ticks_to_stop(bundle), steps;
    int tolerant = bundle->tolerance_defined || component->tolerance > 0.0;

    if ((component->flags & CONTINUOUS) == 0)
        last++; /* it takes its sample at the stop time too */
    steps = (last - (int64_t)component->offset + (int64_t)component->period - 1) / (int64_t)component->period;
    if (steps < 0)
        steps = 0;
    last = (int64_t)component->offset + steps * (int64_t)component->period;
    experiment->tolerant = tolerant;
    experiment->tolerance = tolerance;
    experiment->start = time_of(bundle, component->offset);
    experiment->ends = bundle->stop_defined;
    experiment->stop = bundle->stop_defined ? time_of(bundle, last) : 0.0;
    if (component->flags & VERSION_3)
        return fmi2OK; /* it is announced with the initialization */
    return judge(component, "SetupExperiment",
                 component->call.setup_experiment(component->instance, tolerant ? fmi2True : fmi2False, tolerance,
                                                  experiment->start, experiment->ends, experiment->stop));
}

static fmi2Status enter(component_t *component)
{
    static const char call[] = "EnterInitializationMode";
    const experiment_t *given = &component->experiment;

    if (component->flags & VERSION_3)
        return judge(component, call,
                     (fmi2Status)component->call.enter_initialization3(component->instance, given->tolerant != 0,
                                                                       given->tolerance, given->start,
                                                                       given->ends != 0, given->stop));
    return judge(component, call, component->call.enter_initialization(component->instance));
}

static fmi2Status set_starts(component_t *component)
{
    fmi2Status status = fmi2OK;

    for (int type = 0; type < ALL_TYPES && status <= fmi2Warning; type++) {
        const start_t *start = &component->starts[type];
        if (start->references.count > 0)
            status = worse(status, set_values(component, type, start->references.items, start->references.count,
                                              start->values));
    }
    return status;
}

fmi2Status begin_initialization(bundle_t *bundle)
{
    fmi2Status status = fmi2OK;

    bundle->state.tick = 0;
    bundle->state.begun = 0;
    for (uint32_t k = 0; k < bundle->order.count && status <= fmi2Warning; k++) {
        component_t *component = &bundle->components[bundle->order.items[k]];
        component->fetched = 0;
        status = worse(status, announce(component));
        if (status <= fmi2Warning)
            status = worse(status, set_starts(component));
    }
    if (status <= fmi2Warning)
        status = worse(status, set_given(bundle));
    for (uint32_t k = 0; k < bundle->order.count && status <= fmi2Warning; k++) {
        component_t *component = &bundle->components[bundle->order.items[k]];
        status = worse(status, enter(component));
    }
    bundle->propagated = 0;
    return status;
}

/* Set the inputs of one type whose producers' initial outputs have been fetched. */
static fmi2Status set_initial_of(component_t *component, uint32_t type)
{
    bundle_t *bundle = component->bundle;
    size_t count = 0;

    for (uint32_t k = 0; k < component->initial_set_count; k++) {
        const set_t *set = &component->initial_sets[k];
        if (set->type != type || !bundle->components[set->producer].fetched)
            continue;
        for (uint32_t n = 0; n < set->count; n++, count++) {
            bundle->references[count] = set->targets[n];
            if (type == REAL) {
                double value = ((double *)bundle->slots[REAL])[set->sources[n]];
                if (set->gains != NULL)
                    value = set->gains[n] * value + set->biases[n];
                if (!is_finite(value))
                    return refuse_converted(component, set->targets[n], value);
                ((double *)bundle->values)[count] = value;
            } else
                ((int32_t *)bundle->values)[count] = ((int32_t *)bundle->slots[type])[set->sources[n]];
        }
    }
    return count == 0 ? fmi2OK : set_values(component, (int)type, bundle->references, count, bundle->values);
}

static fmi2Status set_initial(component_t *component)
{
    fmi2Status status = fmi2OK;

    for (uint32_t type = 0; type < BUS_TYPES && status <= fmi2Warning; type++)
        status = worse(status, set_initial_of(component, type));
    return status;
}

/* Fetch values into an array from `start` on; those that connections read have to be finite. */
static fmi2Status fetch(component_t *component, const get_t *list, uint32_t count, void *const arrays[BUS_TYPES])
{
    fmi2Status status = fmi2OK;

    for (uint32_t k = 0; k < count && status <= fmi2Warning; k++) {
        const get_t *get = &list[k];
        char *place = (char *)arrays[get->type] + get->start * sizes[get->type];
        status = worse(status, get_values(component, (int)get->type, get->references, get->count, place));
        if (status <= fmi2Warning && get->type == REAL)
            status = worse(status, check_finite(component, get, (const double *)(const void *)place, 0));
    }
    return status;
}

fmi2Status propagate(bundle_t *bundle)
{
    fmi2Status status = fmi2OK;

    if (bundle->propagated)
        return fmi2OK;
    for (uint32_t k = 0; k < bundle->component_count; k++)
        bundle->components[k].fetched = 0;
    for (uint32_t k = 0; k < bundle->order.count && status <= fmi2Warning; k++) {
        component_t *component = &bundle->components[bundle->order.items[k]];
        status = worse(status, set_initial(component));
        if (status <= fmi2Warning)
            status = worse(status, fetch(component, component->initial_gets, component->initial_get_count,
                                         bundle->slots));
        component->fetched = 1;
    }
    bundle->propagated = status <= fmi2Warning;
    return status;
}

fmi2Status complete_initialization(bundle_t *bundle)
{
    fmi2Status status = fmi2OK;

    for (uint32_t k = 0; k < bundle->component_count; k++)
        bundle->components[k].fetched = 0;
    for (uint32_t k = 0; k < bundle->order.count && status <= fmi2Warning; k++) {
        component_t *component = &bundle->components[bundle->order.items[k]];
        status = worse(status, set_initial(component));
        if (status <= fmi2Warning)
            status = worse(status, judge(component, "ExitInitializationMode",
                                         component->call.exit_initialization(component->instance)));
        if (status <= fmi2Warning)
            status = worse(status, fetch(component, component->initial_gets, component->initial_get_count,
                                         bundle->slots));
        if (status <= fmi2Warning)
            status = worse(status, fetch(component, component->initial_bus, component->initial_bus_count,
                                         bundle->bus));
        component->fetched = 1;
    }
    for (uint32_t k = 0; k < bundle->order.count && status <= fmi2Warning; k++)
        status = worse(status, set_initial(&bundle->components[bundle->order.items[k]]));
    return status;
}
