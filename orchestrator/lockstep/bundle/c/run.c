#include "run.h"

#include <string.h>

#include "components.h"
#include "finite.h"
#include "messages.h"
#include "operations.h"
#include "values.h"

/* Judge a step that was discarded: a component may ask for a regular end of the simulation. */
static fmi2Status discarded(component_t *component, double time)
{
    bundle_t *bundle = component->bundle;
    fmi2Boolean asked = fmi2False;
    fmi2Real reached = 0.0;
    double end = time + component->length;

    if (component->call.boolean_status(component->instance, fmi2Terminated, &asked) > fmi2Warning || !asked)
        return judge(component, "DoStep", fmi2Error); /* half a tick cannot be taken back */
    bundle->ended = 1;
    bundle->state.until = bundle->state.tick + 1;
    judge(component, "DoStep", fmi2Discard);
    if (component->call.real_status(component->instance, fmi2LastSuccessfulTime, &reached) > fmi2Warning)
        return fmi2Discard;
    return reached >= end - 1e-9 * (end > 1.0 ? end : 1.0) ? fmi2OK : fmi2Discard;
}

/* Judge a step of FMI 3.0 with a flag that is set, or that was discarded. */
static fmi2Status flagged(component_t *component, double time)
{
    bundle_t *bundle = component->bundle;
    double end = time + component->length;
    int events = component->flags3[0], ends = component->flags3[1], early = component->flags3[2];

    if (ends && !early) {
        bundle->ended = 1;
        bundle->state.until = bundle->state.tick + 1;
        judge(component, "DoStep", fmi2Discard);
        return component->reached >= end - 1e-9 * (end > 1.0 ? end : 1.0) ? fmi2OK : fmi2Discard;
    }
    if (early || events)
        refuse(bundle, "%s: fmi3DoStep %s at %.9g s, which is not allowed", component->name,
               early ? "returned early" : "asked for event mode", time);
    return judge(component, "DoStep", fmi2Error);
}

/* Judge why the tick in C returned at the operation where it is. */
static fmi2Status judge_operation(bundle_t *bundle, int reason)
{
    const tick_operation *at = &bundle->state.operations[bundle->state.order[bundle->state.position]];
    const origin_t *origin = &bundle->origins[at - bundle->state.operations];
    component_t *component = &bundle->components[origin->component];
    fmi2Status status = (fmi2Status)bundle->state.status;

    if (reason == TICK_NOT_FINITE && origin->set != NULL)
        return check_converted(component, origin->set, at->buffer);
    if (reason == TICK_NOT_FINITE)
        return check_finite(component, origin->get, at->buffer, bundle->state.tick
                            + (component->flags & CONTINUOUS ? (int64_t)component->period : 0));
    if (at->kind == TICK_STEP_3)
        return status == fmi2Discard ? flagged(component, bundle->state.time) : judge(component, "DoStep", status);
    if (at->kind == TICK_STEP_2)
        return status == fmi2Discard ? discarded(component, bundle->state.time)
                                     : judge(component, "DoStep", status);
    return judge(component, access_call(component, origin->set != NULL,
                                        (int)(origin->set != NULL ? origin->set->type : origin->get->type)), status);
}

/* Run to the mark of a tick, or to the end that a component asked for. */
static fmi2Status run_to(bundle_t *bundle, int64_t tick)
{
    tick_state *state = &bundle->state;
    fmi2Status worst = fmi2OK;

    bundle->mark->from = tick;
    state->until = tick + 1;
    for (;;) {
        int reason = tick_run(state);
        if (reason == TICK_CALLER_ACTS || reason == TICK_DONE)
            return worst;
        worst = worse(worst, judge_operation(bundle, reason));
        if (worst > fmi2Warning)
            return worst;
        state->position++;
    }
}

fmi2Status run_to_start(bundle_t *bundle)
{
    fmi2Status status;

    for (int type = 0; type < BUS_TYPES; type++)
        memset(bundle->row[type], 0, bundle->row_size[type] * sizes[type]);
    bundle->state.tick = 0;
    bundle->state.begun = 0;
    status = run_to(bundle, 0);
    if (status <= fmi2Warning)
        take_row(bundle);
    return status;
}

fmi2Status run_ticks(bundle_t *bundle, int64_t count)
{
    int64_t end = bundle->state.tick + count;
    fmi2Status worst;

    bundle->state.position++; /* behind the mark */
    worst = run_to(bundle, end);
    if (worst > fmi2Warning)
        return worst;
    if (bundle->state.tick == end && bundle->state.begun)
        take_row(bundle);
    else
        take_last_row(bundle);
    return bundle->ended ? fmi2Discard : worst;
}
