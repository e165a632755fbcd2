/* The life of an instance as FMI 2.0 has it. */
#include "fmi2_instance.h"

#include <stdlib.h>

const char *FMI2(fmi2GetTypesPlatform)(void) { return "default"; }

const char *FMI2(fmi2GetVersion)(void) { return "2.0"; }

fmi2Component FMI2(fmi2Instantiate)(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                    const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    static const char call[] = "fmi2Instantiate";
    const int by_host = functions != NULL && functions->allocateMemory != NULL && functions->freeMemory != NULL;
    Memory memory = {calloc, free, NULL, 0};
    Host host = {NULL, NULL, 1};

    (void)resources; /* there are none */
    (void)visible;
    (void)logging; /* only refusals are logged, and always */
    if (by_host) {
        memory.allocate = functions->allocateMemory;
        memory.release = functions->freeMemory;
    }
    if (functions != NULL) {
        host.logger = (void (*)(void))functions->logger;
        host.environment = functions->componentEnvironment;
    }
    if (type != fmi2CoSimulation) {
        log_to_host(&host, name != NULL ? name : "", CALL_ERROR, "%s: this FMU is for co-simulation only", call);
        return NULL;
    }
    return instantiate(call, name, guid, "GUID", memory, &host);
}

void FMI2(fmi2FreeInstance)(fmi2Component c) { free_instance(c); }

fmi2Status FMI2(fmi2Reset)(fmi2Component c)
{
    if (c == NULL)
        return fmi2Error;
    begin_anew(c);
    return fmi2OK;
}

fmi2Status FMI2(fmi2SetDebugLogging)(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[])
{
    (void)on; /* only refusals are logged, and always */
    return c == NULL ? fmi2Error : (fmi2Status)choose_categories(c, n, categories);
}

fmi2Status FMI2(fmi2SetupExperiment)(fmi2Component c, fmi2Boolean defined, fmi2Real tolerance, fmi2Real start,
                                     fmi2Boolean ends, fmi2Real stop)
{
    static const char call[] = "setupExperiment";

    if (c == NULL || check_order(c, SETUP_EXPERIMENT, call) != CALL_OK)
        return fmi2Error;
    return (fmi2Status)set_experiment(c, call, defined, tolerance, start, ends, stop);
}

fmi2Status FMI2(fmi2EnterInitializationMode)(fmi2Component c)
{
    static const char call[] = "enterInitializationMode";
    Instance *instance = c;

    if (instance == NULL || check_order(instance, ENTER_INITIALIZATION, call) != CALL_OK)
        return fmi2Error;
    if (!instance->set_up)
        return (fmi2Status)refuse_call(instance, call, "not allowed before fmi2SetupExperiment");
    instance->phase = INITIALIZING;
    return fmi2OK;
}

fmi2Status FMI2(fmi2ExitInitializationMode)(fmi2Component c)
{
    return c == NULL ? fmi2Error : (fmi2Status)exit_initialization(c);
}

fmi2Status FMI2(fmi2Terminate)(fmi2Component c) { return c == NULL ? fmi2Error : (fmi2Status)terminate(c); }

fmi2Status FMI2(fmi2DoStep)(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set_state_prior)
{
    (void)no_set_state_prior;
    return c == NULL ? fmi2Error : (fmi2Status)make_step(c, time, step);
}
