/* The functions of FMI 2.0 that make, prepare, step and end a bundle. */
#include <string.h>

#include "life_cycle.h"
#include "memory.h"
#include "messages.h"
#include "resource_folder.h"

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
FMI2_EXPORT const char *fmi2GetTypesPlatform(void);
FMI2_EXPORT const char *fmi2GetVersion(void);
FMI2_EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component instance, fmi2Boolean on, size_t count,
                                           const fmi2String categories[]);

static fmi2Status find_resources(bundle_t *bundle, fmi2String uri)
{
    size_t length;

    bundle->resources_uri = uri == NULL ? NULL : copy_text(uri);
    bundle->resources = uri == NULL ? NULL : folder_of_uri(uri);
    if (bundle->resources == NULL || bundle->resources_uri == NULL)
        return refuse(bundle, "fmuResourceLocation %s: it must be the file: URI of the folder resources",
                      uri == NULL ? "(none)" : uri);
    length = strlen(bundle->resources_uri);
    if (length > 0 && bundle->resources_uri[length - 1] == '/')
        bundle->resources_uri[length - 1] = '\0';
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    host_t host = {NULL, NULL, NULL, NULL};
    bundle_t *bundle;
    fmi2Status status = fmi2OK;

    (void)visible;
    if (callbacks != NULL) {
        host.logger = (void (*)(void))callbacks->logger;
        host.environment = callbacks->componentEnvironment;
        host.allocate = callbacks->allocateMemory;
        host.release = callbacks->freeMemory;
    }
    bundle = new_bundle(name, &host, logging);
    if (bundle == NULL)
        return NULL;
    if (type != fmi2CoSimulation)
        status = refuse(bundle, "the FMU is one for co-simulation");
    if (status == fmi2OK)
        status = find_resources(bundle, resources);
    if (status == fmi2OK)
        status = open_bundle(bundle, "GUID", guid);
    if (status == fmi2OK)
        return bundle;
    free_bundle(bundle);
    return NULL;
}

void fmi2FreeInstance(fmi2Component instance)
{
    free_bundle(instance);
}

const char *fmi2GetTypesPlatform(void)
{
    return "default";
}

const char *fmi2GetVersion(void)
{
    return "2.0";
}

fmi2Status fmi2SetDebugLogging(fmi2Component instance, fmi2Boolean on, size_t count, const fmi2String categories[])
{
    (void)count, (void)categories;
    return instance == NULL ? fmi2Error : set_logging(instance, "fmi2SetDebugLogging", on);
}

fmi2Status fmi2SetupExperiment(fmi2Component instance, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop)
{
    if (instance == NULL)
        return fmi2Error;
    return set_experiment(instance, "fmi2SetupExperiment", tolerance_defined, tolerance, start, stop_defined, stop);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component instance)
{
    return instance == NULL ? fmi2Error : enter_initialization(instance, "fmi2EnterInitializationMode");
}

fmi2Status fmi2ExitInitializationMode(fmi2Component instance)
{
    return instance == NULL ? fmi2Error : exit_initialization(instance, "fmi2ExitInitializationMode");
}

fmi2Status fmi2DoStep(fmi2Component instance, fmi2Real time, fmi2Real step, fmi2Boolean complete)
{
    (void)complete;
    return instance == NULL ? fmi2Error : make_step(instance, "fmi2DoStep", time, step);
}

fmi2Status fmi2Terminate(fmi2Component instance)
{
    return instance == NULL ? fmi2Error : terminate_bundle(instance, "fmi2Terminate");
}

fmi2Status fmi2Reset(fmi2Component instance)
{
    return instance == NULL ? fmi2Error : reset_bundle(instance, "fmi2Reset");
}
