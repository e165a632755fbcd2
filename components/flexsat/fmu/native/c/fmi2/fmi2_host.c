/* The order of calls that FMI 2.0 allows in co-simulation (2.0.4, section 4.2.4), for a slave that steps at once; and
the way to the log of its hosts. */
#include "fmi2_instance.h"

#define IN(phase) (1 << (phase))

/* Calls that touch states, free or reset the instance are allowed in every phase, and do not stand here. */
static const int allowed[CALLS] = {
    IN(INSTANTIATED),                                            /* SETUP_EXPERIMENT */
    IN(INSTANTIATED),                                            /* ENTER_INITIALIZATION */
    IN(INITIALIZING),                                            /* EXIT_INITIALIZATION */
    IN(STEPPING),                                                /* DO_STEP */
    IN(STEPPING),                                                /* TERMINATE */
    IN(INITIALIZING) | IN(STEPPING) | IN(TERMINATED) | IN(FAILED), /* GET; after an error for debugging only */
    IN(INSTANTIATED) | IN(INITIALIZING) | IN(STEPPING),          /* SET */
    IN(INITIALIZING) | IN(STEPPING) | IN(TERMINATED),            /* DIFFERENTIATE */
};

static const char *const moments[] = {
    "",
    "before fmi2EnterInitializationMode",
    "before fmi2ExitInitializationMode",
    "after fmi2ExitInitializationMode",
    "after fmi2Terminate",
};

Status check_order(Instance *instance, Call call, const char *name)
{
    if (allowed[call] & IN(instance->phase))
        return CALL_OK;
    if (instance->phase == FAILED)
        return refuse_call(instance, name, "refused since: %s", instance->failure);
    return refuse_call(instance, name, "not allowed %s", moments[instance->phase]);
}

/* Whatever categories and debug logging a host has switched on: only refusals are logged. */
void send_to_host(const Host *host, const char *name, Status status, const char *text)
{
    if (host->logger != NULL)
        ((Logger)host->logger)(host->environment, name, (fmi2Status)status, CATEGORY, "%s", text);
}
