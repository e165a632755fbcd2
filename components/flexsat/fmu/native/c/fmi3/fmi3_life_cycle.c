/* The life of an instance as FMI 3.0 has it. */
#include "fmi3_instance.h"

#include <stdlib.h>
#include <string.h>

const char *FMI3(fmi3GetVersion)(void) { return "3.0"; }

static Host host_of(fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger, fmi3Boolean logging)
{
    Host host;

    host.logger = (void (*)(void))logger;
    host.environment = environment;
    host.logging = logging;
    return host;
}

fmi3Instance FMI3(fmi3InstantiateCoSimulation)(fmi3String name, fmi3String token, fmi3String resources,
                                               fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean events,
                                               fmi3Boolean early_return, const fmi3ValueReference intermediate[],
                                               size_t n, fmi3InstanceEnvironment environment,
                                               fmi3LogMessageCallback logger, fmi3IntermediateUpdateCallback update)
{
    static const char call[] = "fmi3InstantiateCoSimulation";
    const Host host = host_of(environment, logger, logging);
    const Memory memory = {calloc, free, NULL, 0};
    const char *known = name != NULL ? name : "";

    (void)resources; /* there are none */
    (void)visible;
    (void)early_return; /* no step returns early */
    (void)intermediate;
    (void)update;
    if (events)
        log_to_host(&host, known, CALL_ERROR, "%s: there is no event mode, as the model description says", call);
    else if (n > 0)
        log_to_host(&host, known, CALL_ERROR,
                    "%s: there is no intermediate update of variables, as the model description says", call);
    else
        return instantiate(call, name, token, "instantiation token", memory, &host);
    return NULL;
}

fmi3Instance FMI3(fmi3InstantiateModelExchange)(fmi3String name, fmi3String token, fmi3String resources,
                                                fmi3Boolean visible, fmi3Boolean logging,
                                                fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger)
{
    const Host host = host_of(environment, logger, logging);

    (void)token, (void)resources, (void)visible;
    log_to_host(&host, name != NULL ? name : "", CALL_ERROR,
                "fmi3InstantiateModelExchange: this FMU is for co-simulation only");
    return NULL;
}

fmi3Instance FMI3(fmi3InstantiateScheduledExecution)(fmi3String name, fmi3String token, fmi3String resources,
                                                     fmi3Boolean visible, fmi3Boolean logging,
                                                     fmi3InstanceEnvironment environment,
                                                     fmi3LogMessageCallback logger, fmi3ClockUpdateCallback update,
                                                     fmi3LockPreemptionCallback lock,
                                                     fmi3UnlockPreemptionCallback unlock)
{
    const Host host = host_of(environment, logger, logging);

    (void)token, (void)resources, (void)visible, (void)update, (void)lock, (void)unlock;
    log_to_host(&host, name != NULL ? name : "", CALL_ERROR,
                "fmi3InstantiateScheduledExecution: this FMU is for co-simulation only");
    return NULL;
}

void FMI3(fmi3FreeInstance)(fmi3Instance c) { free_instance(c); }

fmi3Status FMI3(fmi3Reset)(fmi3Instance c)
{
    if (c == NULL)
        return fmi3Error;
    begin_anew(c);
    return fmi3OK;
}

fmi3Status FMI3(fmi3SetDebugLogging)(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String categories[])
{
    Instance *instance = c;
    Status status;
    size_t k;

    if (instance == NULL)
        return fmi3Error;
    status = choose_categories(instance, n, categories);
    if (status == CALL_ERROR)
        return fmi3Error;
    if (n == 0) /* all categories */
        instance->host.logging = on;
    for (k = 0; k < n; k++)
        if (strcmp(categories[k], CATEGORY) == 0)
            instance->host.logging = on;
    return (fmi3Status)status;
}

fmi3Status FMI3(fmi3EnterInitializationMode)(fmi3Instance c, fmi3Boolean defined, fmi3Float64 tolerance,
                                             fmi3Float64 start, fmi3Boolean ends, fmi3Float64 stop)
{
    static const char call[] = "enterInitializationMode";
    Instance *instance = c;

    if (instance == NULL || check_order(instance, ENTER_INITIALIZATION, call) != CALL_OK
        || set_experiment(instance, call, defined, tolerance, start, ends, stop) != CALL_OK)
        return fmi3Error;
    instance->phase = INITIALIZING;
    return fmi3OK;
}

fmi3Status FMI3(fmi3ExitInitializationMode)(fmi3Instance c)
{
    return c == NULL ? fmi3Error : (fmi3Status)exit_initialization(c);
}

fmi3Status FMI3(fmi3Terminate)(fmi3Instance c) { return c == NULL ? fmi3Error : (fmi3Status)terminate(c); }

fmi3Status FMI3(fmi3DoStep)(fmi3Instance c, fmi3Float64 time, fmi3Float64 step, fmi3Boolean no_set_state_prior,
                            fmi3Boolean *events, fmi3Boolean *ends, fmi3Boolean *early, fmi3Float64 *reached)
{
    Instance *instance = c;
    Status status;

    (void)no_set_state_prior;
    if (instance == NULL)
        return fmi3Error;
    if (events == NULL || ends == NULL || early == NULL || reached == NULL)
        return (fmi3Status)refuse_call(instance, "doStep",
                                       "a flag or the last successful time goes to a NULL pointer");
    status = make_step(instance, time, step);
    *events = *ends = *early = false;
    *reached = instance->present;
    return (fmi3Status)status;
}
