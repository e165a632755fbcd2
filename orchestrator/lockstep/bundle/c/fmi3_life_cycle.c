/* The functions of FMI 3.0 that make, prepare, step and end a bundle, and those of its states. */
#include <stdlib.h>

#include "access.h"
#include "fmi3_functions.h"
#include "life_cycle.h"
#include "memory.h"
#include "messages.h"
#include "resource_folder.h"
#include "states.h"

static fmi2Status find_resources(bundle_t *bundle, fmi3String path)
{
    bundle->resources = path == NULL || *path == '\0' ? NULL : folder_of_path(path);
    bundle->resources_uri = bundle->resources == NULL ? NULL : uri_of_folder(bundle->resources);
    if (bundle->resources_uri != NULL)
        return fmi2OK;
    return refuse(bundle, "resourcePath %s: it must be the path of the folder resources", path == NULL ? "(none)" : path);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference intermediate[], size_t count,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                         fmi3IntermediateUpdateCallback update)
{
    const host_t host = {(void (*)(void))logger, environment, calloc, free};
    bundle_t *bundle = new_bundle(name, &host, logging);
    fmi2Status status = fmi2OK;

    (void)visible, (void)early, (void)intermediate, (void)update;
    if (bundle == NULL)
        return NULL;
    if (events)
        status = refuse(bundle, "fmi3InstantiateCoSimulation: the FMU has no event mode");
    else if (count > 0)
        status = refuse(bundle, "fmi3InstantiateCoSimulation: the FMU has no intermediate update of variables");
    if (status == fmi2OK)
        status = find_resources(bundle, resources);
    if (status == fmi2OK)
        status = open_bundle(bundle, "instantiation token", token);
    if (status == fmi2OK)
        return bundle;
    free_bundle(bundle);
    return NULL;
}

/* Refuse another kind of simulation. */
static fmi3Instance refuse_kind(const char *call, fmi3String name, fmi3InstanceEnvironment environment,
                                fmi3LogMessageCallback logger)
{
    const host_t host = {(void (*)(void))logger, environment, calloc, free};
    bundle_t *bundle = new_bundle(name, &host, 0);

    if (bundle != NULL)
        refuse(bundle, "%s: the FMU is one for co-simulation", call);
    free_bundle(bundle);
    return NULL;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback logger)
{
    (void)token, (void)resources, (void)visible, (void)logging;
    return refuse_kind("fmi3InstantiateModelExchange", name, environment, logger);
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                               fmi3Boolean visible, fmi3Boolean logging,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                               fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock)
{
    (void)token, (void)resources, (void)visible, (void)logging, (void)update, (void)lock, (void)unlock;
    return refuse_kind("fmi3InstantiateScheduledExecution", name, environment, logger);
}

void fmi3FreeInstance(fmi3Instance instance)
{
    free_bundle(instance);
}

const char *fmi3GetVersion(void)
{
    return "3.0";
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t count, const fmi3String categories[])
{
    (void)count, (void)categories;
    return instance == NULL ? fmi3Error : (fmi3Status)set_logging(instance, "fmi3SetDebugLogging", on);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean tolerance_defined, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean stop_defined, fmi3Float64 stop)
{
    static const char call[] = "fmi3EnterInitializationMode";

    if (instance == NULL
        || set_experiment(instance, call, tolerance_defined, tolerance, start, stop_defined, stop) != fmi2OK)
        return fmi3Error;
    return (fmi3Status)enter_initialization(instance, call);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    return instance == NULL ? fmi3Error : (fmi3Status)exit_initialization(instance, "fmi3ExitInitializationMode");
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 step, fmi3Boolean complete,
                      fmi3Boolean *events, fmi3Boolean *ends, fmi3Boolean *early, fmi3Float64 *reached)
{
    static const char call[] = "fmi3DoStep";
    bundle_t *bundle = instance;
    fmi2Status status;

    (void)complete;
    if (bundle == NULL)
        return fmi3Error;
    if (events == NULL || ends == NULL || early == NULL || reached == NULL)
        return (fmi3Status)refuse(bundle, "%s: a flag or the last successful time has no place", call);
    status = make_step(bundle, call, time, step);
    *events = *early = false;
    *ends = status == fmi2Discard && bundle->ended;
    *reached = time_now(bundle);
    return *ends ? fmi3OK : (fmi3Status)status;
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    return instance == NULL ? fmi3Error : (fmi3Status)terminate_bundle(instance, "fmi3Terminate");
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    return instance == NULL ? fmi3Error : (fmi3Status)reset_bundle(instance, "fmi3Reset");
}

static int has_state(const bundle_t *bundle, const char *call, const void *given)
{
    return bundle != NULL && may_have_state(bundle, call, given);
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    static const char call[] = "fmi3GetFMUState";

    return has_state(instance, call, state) ? (fmi3Status)get_state(instance, call, state) : fmi3Error;
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state)
{
    static const char call[] = "fmi3SetFMUState";

    return has_state(instance, call, state) ? (fmi3Status)set_state(instance, call, state) : fmi3Error;
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    return instance == NULL ? fmi3Error : (fmi3Status)free_state(instance, "fmi3FreeFMUState", state);
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size)
{
    static const char call[] = "fmi3SerializedFMUStateSize";

    return has_state(instance, call, size) ? (fmi3Status)state_size(instance, call, state, size) : fmi3Error;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    static const char call[] = "fmi3SerializeFMUState";

    return has_state(instance, call, bytes) ? (fmi3Status)serialize(instance, call, state, bytes, size) : fmi3Error;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    static const char call[] = "fmi3DeserializeFMUState";

    if (!has_state(instance, call, bytes) || !has_state(instance, call, state))
        return fmi3Error;
    return (fmi3Status)deserialize(instance, call, bytes, size, state);
}
