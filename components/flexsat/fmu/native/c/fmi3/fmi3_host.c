/* The order of calls that FMI 3.0 allows in co-simulation (3.0.2, sections 2.3 and 4.2), for a slave that steps at
once and has no event mode; and the way to the log of its hosts. */
#include "fmi3_instance.h"

#define IN(phase) (1 << (phase))

/* Calls that touch states, free or reset the instance are allowed in every phase, and do not stand here. After an
error the standard has an instance be terminated. */
static const int allowed[CALLS] = {
    0,                                                           /* SETUP_EXPERIMENT: no call of FMI 3.0 */
    IN(INSTANTIATED),                                            /* ENTER_INITIALIZATION */
    IN(INITIALIZING),                                            /* EXIT_INITIALIZATION */
    IN(STEPPING),                                                /* DO_STEP */
    IN(STEPPING),                                                /* TERMINATE */
    IN(INSTANTIATED) | IN(INITIALIZING) | IN(STEPPING) | IN(TERMINATED) | IN(FAILED), /* GET */
    IN(INSTANTIATED) | IN(INITIALIZING) | IN(STEPPING),          /* SET */
    IN(INITIALIZING) | IN(STEPPING) | IN(TERMINATED),            /* DIFFERENTIATE */
};

static const char *const moments[] = {
    "",
    "before fmi3EnterInitializationMode",
    "before fmi3ExitInitializationMode",
    "after fmi3ExitInitializationMode",
    "after fmi3Terminate",
};

Status check_order(Instance *instance, Call call, const char *name)
{
    if (allowed[call] & IN(instance->phase))
        return CALL_OK;
    if (instance->phase == FAILED)
        return refuse_call(instance, name, "refused since: %s", instance->failure);
    return refuse_call(instance, name, "not allowed %s", moments[instance->phase]);
}

/* In messages of FMI 3.0 a # begins a reference to a variable, and two of them are a #. */
void send_to_host(const Host *host, const char *name, Status status, const char *text)
{
    char message[2 * REASON_SIZE];
    size_t k = 0;

    (void)name; /* hosts know an instance by its environment */
    if (host->logger == NULL || !host->logging)
        return;
    for (; *text != '\0' && k < sizeof message - 2; text++) {
        if (*text == '#')
            message[k++] = '#';
        message[k++] = *text;
    }
    message[k] = '\0';
    ((fmi3LogMessageCallback)host->logger)(host->environment, (fmi3Status)status, CATEGORY, message);
}
