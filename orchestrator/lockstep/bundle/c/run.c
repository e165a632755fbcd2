#include "run.h"

#include <string.h>

#include "components.h"
#include "finite.h"
#include "messages.h"
#include "values.h"

static fmi2Status set_inputs(component_t *component, const set_t *set)
{
    const bundle_t *bundle = component->bundle;

    if (set->type == REAL) {
        const double *bus = bundle->bus[REAL];
        double *values = set->buffer;
        for (uint32_t k = 0; k < set->count; k++)
            values[k] = bus[set->sources[k]];
        if (set->gains != NULL)
            for (uint32_t k = 0; k < set->count; k++) {
                values[k] = set->gains[k] * values[k] + set->biases[k];
                if (!is_finite(values[k]))
                    return refuse(bundle, "%s: the input of reference %u is %g at %.9g s after the conversion of its "
                                  "connection", component->name, set->targets[k], values[k],
                                  time_of(bundle, bundle->tick));
            }
    } else {
        const int32_t *bus = bundle->bus[set->type];
        int32_t *values = set->buffer;
        for (uint32_t k = 0; k < set->count; k++)
            values[k] = bus[set->sources[k]];
    }
    return set_values(component, (int)set->type, set->targets, set->count, set->buffer);
}

/* Judge a step that was discarded: a component may ask for a regular end of the simulation. */
static fmi2Status discarded(component_t *component, double time)
{
    bundle_t *bundle = component->bundle;
    fmi2Boolean asked = fmi2False;
    fmi2Real reached = 0.0;
    double end = time + component->length;

    if (component->call.boolean_status(component->instance, fmi2Terminated, &asked) > fmi2Warning || !asked)
        return judge(component, "fmi2DoStep", fmi2Error); /* half a tick cannot be taken back */
    bundle->ended = 1;
    judge(component, "fmi2DoStep", fmi2Discard);
    if (component->call.real_status(component->instance, fmi2LastSuccessfulTime, &reached) > fmi2Warning)
        return fmi2Discard;
    return reached >= end - 1e-9 * (end > 1.0 ? end : 1.0) ? fmi2OK : fmi2Discard;
}

static fmi2Status step(bundle_t *bundle, const step_t *step, double time)
{
    component_t *component = &bundle->components[step->component];
    fmi2Status status, worst = fmi2OK;

    for (uint32_t k = 0; k < step->set_count; k++) {
        worst = worse(worst, set_inputs(component, &step->sets[k]));
        if (worst > fmi2Warning)
            return worst;
    }
    status = component->call.do_step(component->instance, time, component->length, fmi2True);
    if (status != fmi2OK) {
        status = status == fmi2Discard ? discarded(component, time) : judge(component, "fmi2DoStep", status);
        worst = worse(worst, status);
        if (worst > fmi2Warning)
            return worst;
    }
    for (uint32_t k = 0; k < step->get_count; k++) {
        const get_t *get = &step->gets[k];
        char *place = (char *)bundle->bus[get->type] + get->start * sizes[get->type];
        worst = worse(worst, get_values(component, (int)get->type, get->references, get->count, place));
        if (worst <= fmi2Warning && get->type == REAL)
            worst = worse(worst, check_finite(component, get, (const double *)(const void *)place,
                                              bundle->tick + (component->flags & CONTINUOUS ? component->period : 0)));
        if (worst > fmi2Warning)
            return worst;
    }
    return worst;
}

static fmi2Status steps(bundle_t *bundle, const counts_t *numbers)
{
    double time = time_of(bundle, bundle->tick);
    fmi2Status worst = fmi2OK;

    for (uint32_t k = 0; k < numbers->count && worst <= fmi2Warning; k++)
        worst = worse(worst, step(bundle, &bundle->steps[numbers->items[k]], time));
    return worst;
}

fmi2Status run_to_start(bundle_t *bundle)
{
    fmi2Status status;

    memset(bundle->row[REAL], 0, bundle->row_size[REAL] * sizes[REAL]);
    status = steps(bundle, &bundle->ticks[0].early);
    if (status <= fmi2Warning)
        take_row(bundle);
    return status;
}

fmi2Status run_ticks(bundle_t *bundle, int64_t count)
{
    fmi2Status worst = fmi2OK;

    for (int64_t done = 0; done < count && worst <= fmi2Warning && !bundle->ended; done++) {
        worst = worse(worst, steps(bundle, &bundle->ticks[bundle->tick % bundle->cycle].late));
        if (worst > fmi2Warning)
            break;
        bundle->tick++;
        if (!bundle->ended)
            worst = worse(worst, steps(bundle, &bundle->ticks[bundle->tick % bundle->cycle].early));
    }
    if (worst > fmi2Warning)
        return worst;
    if (!bundle->ended) {
        take_row(bundle);
        return worst;
    }
    take_last_row(bundle);
    return fmi2Discard;
}
