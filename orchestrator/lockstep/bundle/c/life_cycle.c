#include "life_cycle.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arrays.h"
#include "components.h"
#include "finite.h"
#include "initialise.h"
#include "memory.h"
#include "messages.h"
#include "program_file.h"
#include "run.h"
#include "states.h"
#include "values.h"

/* Note a status that ends the instance's use, and return it. */
static fmi2Status noted(bundle_t *bundle, fmi2Status status)
{
    if (status >= fmi2Error && bundle->life != FATAL)
        bundle->life = FAILED;
    return status;
}

void free_bundle(bundle_t *bundle)
{
    if (bundle == NULL)
        return;
    free_states(bundle);
    unload_components(bundle);
    free_ports(bundle);
    free_kept(bundle);
    free(bundle->program);
    free(bundle->name);
    free(bundle->resources);
    free(bundle->resources_uri);
    free(bundle->given.memory);
    free(bundle->expanded.memory);
    free(bundle);
}

bundle_t *new_bundle(const char *name, const host_t *host, int logging)
{
    bundle_t *bundle = calloc(1, sizeof *bundle);

    if (bundle == NULL)
        return NULL;
    bundle->host = *host;
    bundle->logging = logging ? fmi2True : fmi2False;
    bundle->life = INSTANTIATED;
    bundle->second = 1;
    bundle->name = copy_text(name == NULL ? "" : name);
    if (bundle->name != NULL)
        return bundle;
    free_bundle(bundle);
    return NULL;
}

fmi2Status open_bundle(bundle_t *bundle, const char *what, const char *token)
{
    const char *problem = read_program(bundle);

    if (problem != NULL)
        return refuse(bundle, "%s", problem);
    if (token == NULL || strcmp(token, bundle->guid) != 0)
        return refuse(bundle, "%s %s: the FMU's is %s", what, token == NULL ? "(none)" : token, bundle->guid);
    if (!start_ports(bundle))
        return refuse(bundle, "there is no memory");
    return load_components(bundle);
}

static const char *const lives[] = {"instantiated", "initialization mode", "step mode", "terminated", "failed",
                                    "failed fatally"};

static fmi2Status refuse_call(const bundle_t *bundle, const char *call)
{
    return refuse(bundle, "%s: is not allowed now: the instance is in the state: %s", call, lives[bundle->life]);
}

fmi2Status set_experiment(bundle_t *bundle, const char *call, int tolerance_defined, double tolerance, double start,
                          int stop_defined, double stop)
{
    double origin = start * (double)bundle->second;

    if (bundle->life != INSTANTIATED)
        return refuse_call(bundle, call);
    if (!(origin < 9e15 && origin > -9e15))
        return refuse(bundle, "%s: start time %g s must be a number below 9e6 s", call, start);
    if (stop_defined && !(stop > start))
        return refuse(bundle, "%s: stop time %g s must be after the start time %g s", call, stop, start);
    if (tolerance_defined && !(tolerance > 0.0 && is_finite(tolerance)))
        return refuse(bundle, "%s: tolerance %g must be > 0", call, tolerance);
    bundle->start = start;
    bundle->state.origin = (int64_t)(origin < 0.0 ? origin - 0.5 : origin + 0.5);
    bundle->stop = stop_defined ? stop : 0.0;
    bundle->stop_defined = stop_defined ? fmi2True : fmi2False;
    bundle->tolerance = tolerance_defined ? tolerance : 0.0;
    bundle->tolerance_defined = tolerance_defined ? fmi2True : fmi2False;
    return fmi2OK;
}

fmi2Status enter_initialization(bundle_t *bundle, const char *call)
{
    fmi2Status status;

    if (bundle->life != INSTANTIATED)
        return refuse_call(bundle, call);
    status = begin_initialization(bundle);
    if (status <= fmi2Warning)
        bundle->life = INITIALISING;
    else if (status == fmi2Discard)
        status = fmi2Error;
    return noted(bundle, status);
}

fmi2Status exit_initialization(bundle_t *bundle, const char *call)
{
    fmi2Status status;

    if (bundle->life != INITIALISING)
        return refuse_call(bundle, call);
    status = complete_initialization(bundle);
    if (status <= fmi2Warning) {
        bundle->ended = 0;
        status = worse(status, run_to_start(bundle));
    }
    if (status <= fmi2Warning)
        bundle->life = STEPPING;
    else if (status == fmi2Discard)
        status = fmi2Error;
    return noted(bundle, status);
}

/* Return how many ticks a step takes; 0 and a message if it cannot be made. */
static int64_t ticks_of(const bundle_t *bundle, const char *call, double time, double step)
{
    double unit = (double)bundle->state.length / bundle->state.second, now = time_now(bundle);
    double late = time - now, ticks = step / unit;
    double rounding = 1e-6 + 2e-15 * (now < 0.0 ? -now : now) / unit; /* hosts add up times */
    int64_t whole = ticks > 0.0 && ticks < 1e15 ? (int64_t)(ticks + 0.5) : 0;
    double error = ticks - (double)whole;

    if (!(late <= rounding * unit && late >= -rounding * unit)) {
        refuse(bundle, "%s: begins at %.9g s, and the instance is at %.9g s", call, time, now);
        return 0;
    }
    if (whole > 0 && error <= rounding + 2e-15 * ticks && error >= -rounding - 2e-15 * ticks && whole % (int64_t)bundle->step_ticks == 0)
        return whole;
    refuse(bundle, "%s: step %.9g s must be a multiple of %.9g s, the tick of the system", call, step,
           unit * (double)bundle->step_ticks);
    return 0;
}

fmi2Status make_step(bundle_t *bundle, const char *call, double time, double step)
{
    int64_t ticks;

    if (bundle->life != STEPPING)
        return refuse_call(bundle, call);
    if (bundle->ended)
        return refuse(bundle, "%s: a component has asked for the end of the simulation", call);
    ticks = ticks_of(bundle, call, time, step);
    return ticks == 0 ? fmi2Error : noted(bundle, run_ticks(bundle, ticks));
}

fmi2Status terminate_bundle(bundle_t *bundle, const char *call)
{
    fmi2Status worst = fmi2OK;

    if (bundle->life != STEPPING)
        return refuse_call(bundle, call);
    for (uint32_t k = 0; k < bundle->component_count; k++) {
        component_t *component = &bundle->components[k];
        if (component->worst < fmi2Error)
            worst = worse(worst, judge(component, "Terminate", component->call.terminate(component->instance)));
    }
    if (bundle->life != FATAL)
        bundle->life = TERMINATED;
    return worst;
}

fmi2Status reset_bundle(bundle_t *bundle, const char *call)
{
    fmi2Status worst = fmi2OK;

    if (bundle->life == FATAL)
        return refuse_call(bundle, call);
    for (uint32_t k = 0; k < bundle->component_count && worst < fmi2Fatal; k++) {
        component_t *component = &bundle->components[k];
        component->worst = fmi2OK;
        component->fetched = 0;
        if ((component->flags & VERSION_3) != 0 && !start_arrays(component))
            worst = worse(worst, refuse(bundle, "%s: there is no memory", call));
        worst = worse(worst, judge(component, "Reset", component->call.reset(component->instance)));
    }
    bundle->start = bundle->stop = bundle->tolerance = 0.0;
    bundle->stop_defined = bundle->tolerance_defined = 0;
    bundle->state.origin = bundle->state.tick = 0;
    bundle->state.begun = 0;
    bundle->ended = bundle->propagated = 0;
    for (int type = 0; type < BUS_TYPES; type++) {
        memset(bundle->bus[type], 0, bundle->bus_size[type] * sizes[type]);
        memset(bundle->row[type], 0, bundle->row_size[type] * sizes[type]);
    }
    if (!start_ports(bundle))
        worst = worse(worst, refuse(bundle, "%s: there is no memory", call));
    if (worst <= fmi2Warning)
        bundle->life = INSTANTIATED;
    return noted(bundle, worst);
}

fmi2Status set_logging(bundle_t *bundle, const char *call, int on)
{
    fmi2Status worst = fmi2OK;

    if (bundle->life == FATAL)
        return refuse_call(bundle, call);
    bundle->logging = on ? fmi2True : fmi2False;
    for (uint32_t k = 0; k < bundle->component_count && worst < fmi2Fatal; k++) /* they have categories of their own */
        worst = worse(worst, log_component(&bundle->components[k], bundle->logging));
    return worst;
}
