/* The functions of FMI 2.0 that make, prepare, step and end a bundle. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "components.h"
#include "finite.h"
#include "initialise.h"
#include "memory.h"
#include "messages.h"
#include "program_file.h"
#include "resource_folder.h"
#include "run.h"
#include "states.h"
#include "values.h"

FMI2_EXPORT fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                          const fmi2CallbackFunctions *callbacks, fmi2Boolean visible,
                                          fmi2Boolean logging);
FMI2_EXPORT void fmi2FreeInstance(fmi2Component instance);
FMI2_EXPORT fmi2Status fmi2SetupExperiment(fmi2Component instance, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                                           fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop);
FMI2_EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component instance);
FMI2_EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component instance);
FMI2_EXPORT fmi2Status fmi2DoStep(fmi2Component instance, fmi2Real time, fmi2Real step, fmi2Boolean complete);
FMI2_EXPORT fmi2Status fmi2Terminate(fmi2Component instance);
FMI2_EXPORT fmi2Status fmi2Reset(fmi2Component instance);

/* Note a status that ends the instance's use, and return it. */
static fmi2Status noted(bundle_t *bundle, fmi2Status status)
{
    if (status >= fmi2Error && bundle->life != FATAL)
        bundle->life = FAILED;
    return status;
}

static void free_bundle(bundle_t *bundle)
{
    free_states(bundle);
    unload_components(bundle);
    free_ports(bundle);
    free_kept(bundle);
    free(bundle->program);
    free(bundle->name);
    free(bundle->resources);
    free(bundle->resources_uri);
    free(bundle);
}

static fmi2Status prepare(bundle_t *bundle, fmi2String guid, fmi2String resources)
{
    const char *problem;

    bundle->resources_uri = resources == NULL ? NULL : copy_text(resources);
    bundle->resources = resources == NULL ? NULL : folder_of_uri(resources);
    if (bundle->resources == NULL)
        return refuse(bundle, "fmuResourceLocation %s: it must be the file: URI of the folder resources",
                      resources == NULL ? "(none)" : resources);
    if (bundle->resources_uri[0] != '\0' && bundle->resources_uri[strlen(bundle->resources_uri) - 1] == '/')
        bundle->resources_uri[strlen(bundle->resources_uri) - 1] = '\0';
    problem = read_program(bundle);
    if (problem != NULL)
        return refuse(bundle, "%s", problem);
    if (guid == NULL || strcmp(guid, bundle->guid) != 0)
        return refuse(bundle, "GUID %s: the FMU's is %s", guid == NULL ? "(none)" : guid, bundle->guid);
    if (!start_ports(bundle))
        return refuse(bundle, "there is no memory");
    return load_components(bundle);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    bundle_t *bundle = calloc(1, sizeof *bundle);
    fmi2Status status = fmi2OK;

    (void)visible;
    if (bundle == NULL)
        return NULL;
    if (callbacks != NULL)
        bundle->host = *callbacks;
    bundle->logging = logging ? fmi2True : fmi2False;
    bundle->life = INSTANTIATED;
    bundle->second = 1;
    bundle->name = copy_text(name == NULL ? "" : name);
    if (bundle->name == NULL || type != fmi2CoSimulation)
        status = refuse(bundle, "the FMU is one for co-simulation");
    if (status == fmi2OK)
        status = prepare(bundle, guid, resources);
    if (status == fmi2OK)
        return bundle;
    free_bundle(bundle);
    return NULL;
}

void fmi2FreeInstance(fmi2Component instance)
{
    if (instance != NULL)
        free_bundle(instance);
}

static const char *const lives[] = {"instantiated", "initialization mode", "step mode", "terminated", "failed",
                                    "failed fatally"};

static fmi2Status refuse_call(const bundle_t *bundle, const char *call)
{
    return refuse(bundle, "%s: is not allowed now: the instance is in the state: %s", call, lives[bundle->life]);
}

fmi2Status fmi2SetupExperiment(fmi2Component instance, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop)
{
    bundle_t *bundle = instance;
    double origin;

    if (bundle == NULL)
        return fmi2Error;
    if (bundle->life != INSTANTIATED)
        return refuse_call(bundle, "fmi2SetupExperiment");
    origin = start * (double)bundle->second;
    if (!(origin < 9e15 && origin > -9e15))
        return refuse(bundle, "fmi2SetupExperiment: start time %g s must be a number below 9e6 s", start);
    if (stop_defined && !(stop > start))
        return refuse(bundle, "fmi2SetupExperiment: stop time %g s must be after the start time %g s", stop, start);
    if (tolerance_defined && !(tolerance > 0.0 && is_finite(tolerance)))
        return refuse(bundle, "fmi2SetupExperiment: tolerance %g must be > 0", tolerance);
    bundle->start = start;
    bundle->state.origin = (int64_t)(origin < 0.0 ? origin - 0.5 : origin + 0.5);
    bundle->stop = stop_defined ? stop : 0.0;
    bundle->stop_defined = stop_defined ? fmi2True : fmi2False;
    bundle->tolerance = tolerance_defined ? tolerance : 0.0;
    bundle->tolerance_defined = tolerance_defined ? fmi2True : fmi2False;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component instance)
{
    bundle_t *bundle = instance;
    fmi2Status status;

    if (bundle == NULL)
        return fmi2Error;
    if (bundle->life != INSTANTIATED)
        return refuse_call(bundle, "fmi2EnterInitializationMode");
    status = begin_initialization(bundle);
    if (status <= fmi2Warning)
        bundle->life = INITIALISING;
    else if (status == fmi2Discard)
        status = fmi2Error;
    return noted(bundle, status);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component instance)
{
    bundle_t *bundle = instance;
    fmi2Status status;

    if (bundle == NULL)
        return fmi2Error;
    if (bundle->life != INITIALISING)
        return refuse_call(bundle, "fmi2ExitInitializationMode");
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
static int64_t ticks_of(const bundle_t *bundle, double time, double step)
{
    double unit = (double)bundle->state.length / bundle->state.second, now = time_now(bundle);
    double late = time - now, ticks = step / unit;
    double rounding = 1e-6 + 2e-15 * (now < 0.0 ? -now : now) / unit; /* hosts add up times */
    int64_t whole = ticks > 0.0 && ticks < 1e15 ? (int64_t)(ticks + 0.5) : 0;
    double error = ticks - (double)whole;

    if (!(late <= rounding * unit && late >= -rounding * unit)) {
        refuse(bundle, "fmi2DoStep: begins at %.9g s, and the instance is at %.9g s", time, now);
        return 0;
    }
    if (whole > 0 && error <= rounding + 2e-15 * ticks && error >= -rounding - 2e-15 * ticks && whole % (int64_t)bundle->step_ticks == 0)
        return whole;
    refuse(bundle, "fmi2DoStep: step %.9g s must be a multiple of %.9g s, the tick of the system", step,
           unit * (double)bundle->step_ticks);
    return 0;
}

fmi2Status fmi2DoStep(fmi2Component instance, fmi2Real time, fmi2Real step, fmi2Boolean complete)
{
    bundle_t *bundle = instance;
    int64_t ticks;

    (void)complete;
    if (bundle == NULL)
        return fmi2Error;
    if (bundle->life != STEPPING)
        return refuse_call(bundle, "fmi2DoStep");
    if (bundle->ended)
        return refuse(bundle, "fmi2DoStep: a component has asked for the end of the simulation");
    ticks = ticks_of(bundle, time, step);
    return ticks == 0 ? fmi2Error : noted(bundle, run_ticks(bundle, ticks));
}

fmi2Status fmi2Terminate(fmi2Component instance)
{
    bundle_t *bundle = instance;
    fmi2Status worst = fmi2OK;

    if (bundle == NULL)
        return fmi2Error;
    if (bundle->life != STEPPING)
        return refuse_call(bundle, "fmi2Terminate");
    for (uint32_t k = 0; k < bundle->component_count; k++) {
        component_t *component = &bundle->components[k];
        if (component->worst < fmi2Error)
            worst = worse(worst, judge(component, "fmi2Terminate", component->call.terminate(component->instance)));
    }
    if (bundle->life != FATAL)
        bundle->life = TERMINATED;
    return worst;
}

fmi2Status fmi2Reset(fmi2Component instance)
{
    bundle_t *bundle = instance;
    fmi2Status worst = fmi2OK;

    if (bundle == NULL)
        return fmi2Error;
    if (bundle->life == FATAL)
        return refuse_call(bundle, "fmi2Reset");
    for (uint32_t k = 0; k < bundle->component_count && worst < fmi2Fatal; k++) {
        component_t *component = &bundle->components[k];
        component->worst = fmi2OK;
        component->fetched = 0;
        worst = worse(worst, judge(component, "fmi2Reset", component->call.reset(component->instance)));
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
        worst = worse(worst, refuse(bundle, "fmi2Reset: there is no memory"));
    if (worst <= fmi2Warning)
        bundle->life = INSTANTIATED;
    return noted(bundle, worst);
}
