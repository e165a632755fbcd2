/* The life cycle and the values: what a host calls between fmi2Instantiate and fmi2FreeInstance, without the states.

   The model knows which call is legal when; it states what it refuses in `control->outcome`. Here are the checks that
   must come before the wrapper, which crashes on them: no instance, no array, text that is not UTF-8. */

#include "shim.h"

#include <math.h>
#include <string.h>

/* Prepare for a call; return its status at once if it cannot be made. */
fmi2Status begin(Instance *instance) {
    if (!instance) return fmi2Error;
    if (instance->fatal) return fmi2Fatal;
    if (!instance->control) return refuse(instance, "there is no model since fmi2Reset failed; free the instance");
    instance->control->outcome = fmi2OK;
    return fmi2OK;
}

/* Return the status of a call that the wrapper has made. */
fmi2Status outcome(Instance *instance, fmi2Status status) {
    if (status >= fmi2Fatal) {
        instance->fatal = 1; /* the wrapper has freed its objects, and would free them again */
        return fmi2Fatal;
    }
    return instance->control && instance->control->outcome ? (fmi2Status)instance->control->outcome : status;
}

#define BEGIN                                                                                                          \
    Instance *instance = c;                                                                                            \
    fmi2Status status = begin(instance);                                                                               \
    if (status != fmi2OK) return status
#define CALL(name, ...) return outcome(instance, wrapper.name(instance->wrapped, __VA_ARGS__))

EXPORTED fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    BEGIN;
    if (n && !categories) return refuse(instance, "setDebugLogging: %zu categories in a NULL array", n);
    for (size_t k = 0; k < n; k++)
        if (!categories[k]) return refuse(instance, "setDebugLogging: category %zu is NULL", k + 1);
    instance->logging = on;
    for (size_t k = 0; k < n; k++)
        if (strcmp(categories[k], CATEGORY)) {
            log_to_host(instance->host, instance->name, fmi2Warning,
                        "setDebugLogging: no category %.200s; there is " CATEGORY, categories[k]);
            status = fmi2Warning;
        }
    return status;
}

EXPORTED fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean defined, fmi2Real tolerance, fmi2Real start,
                                        fmi2Boolean ends, fmi2Real stop) {
    BEGIN;
    CALL(fmi2SetupExperiment, defined, tolerance, start, ends, stop);
}

EXPORTED fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    BEGIN;
    return outcome(instance, wrapper.fmi2EnterInitializationMode(instance->wrapped));
}

EXPORTED fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    BEGIN;
    return outcome(instance, wrapper.fmi2ExitInitializationMode(instance->wrapped));
}

EXPORTED fmi2Status fmi2Terminate(fmi2Component c) {
    BEGIN;
    return outcome(instance, wrapper.fmi2Terminate(instance->wrapped));
}

EXPORTED fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean noSetFMUStatePrior) {
    BEGIN;
    CALL(fmi2DoStep, time, step, noSetFMUStatePrior);
}

/* Refuse lists without arrays, and references that no variable has; `foreign`: whether one is that of another kind,
   which the model names. */
static fmi2Status examine(Instance *instance, const char *call, const char *kind, fmi2ValueReference first, size_t count,
                          const fmi2ValueReference vr[], size_t n, const void *values, int *foreign) {
    const size_t all = instance->first.strings + instance->strings;
    if (n && !vr) return refuse(instance, "%s: %zu value references in a NULL array", call, n);
    if (n && !values) return refuse(instance, "%s: %zu values in a NULL array", call, n);
    for (size_t k = 0; k < n; k++) {
        if (vr[k] >= first && vr[k] - first < count) continue;
        *foreign = 1;
        if (vr[k] >= all && count)
            return refuse(instance, "%s: %s value reference %u: no such variable; there are %zu, from %u on", call, kind,
                          vr[k], count, first);
        if (vr[k] >= all)
            return refuse(instance, "%s: %s value reference %u: no such variable; there are none", call, kind, vr[k]);
    }
    return fmi2OK;
}

#define EXAMINE(call, kind, first, count)                                                                              \
    BEGIN;                                                                                                             \
    int foreign = 0;                                                                                                   \
    if ((status = examine(instance, call, kind, first, count, vr, n, values, &foreign)) != fmi2OK) return status

/* Return whether all references allow `access`; `pending` become those that have to be computed first, if any: one on
   demand, and one that follows inputs which were set. */
static int allowed(const Instance *instance, const Buffer *buffer, fmi2ValueReference first,
                   const fmi2ValueReference vr[], size_t n, int access, const fmi2ValueReference *pending[2]) {
    if (!(instance->control->access & access)) return 0;
    for (size_t k = 0; k < n; k++) {
        const unsigned char bits = buffer->access[vr[k] - first];
        if (!(bits & access)) return 0;
        if (bits & ON_DEMAND) pending[0] = &vr[k];
        if (bits & FOLLOWS && instance->control->inputs_set) pending[1] = &vr[k];
    }
    return 1;
}

EXPORTED fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real values[]) {
    EXAMINE("getReal", "real", instance->first.reals, instance->reals.count);
    const fmi2ValueReference first = instance->first.reals, *pending[2] = {NULL, NULL};
    if (foreign || !allowed(instance, &instance->reals, first, vr, n, READ, pending))
        CALL(fmi2GetReal, vr, n, values);
    for (int k = 0; k < 2; k++) { /* Python computes all of a kind when one is asked for */
        fmi2Real computed;
        if (!pending[k]) continue;
        status = outcome(instance, wrapper.fmi2GetReal(instance->wrapped, pending[k], 1, &computed));
        if (status > fmi2Warning) return status;
    }
    const fmi2Real *all = (const fmi2Real *)instance->reals.values;
    for (size_t k = 0; k < n; k++) values[k] = all[vr[k] - first];
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real values[]) {
    EXAMINE("setReal", "real", instance->first.reals, instance->reals.count);
    const fmi2ValueReference first = instance->first.reals, *pending[2] = {NULL, NULL};
    int shared = !foreign && allowed(instance, &instance->reals, first, vr, n, WRITE, pending);
    for (size_t k = 0; shared && k < n; k++) shared = isfinite(values[k]); /* Python refuses it, by name */
    if (!shared) CALL(fmi2SetReal, vr, n, values);
    fmi2Real *all = (fmi2Real *)instance->reals.values;
    for (size_t k = 0; k < n; k++) all[vr[k] - first] = values[k];
    instance->control->inputs_set = 1;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean values[]) {
    EXAMINE("getBoolean", "boolean", instance->first.booleans, instance->booleans.count);
    const fmi2ValueReference first = instance->first.booleans, *pending[2] = {NULL, NULL};
    if (foreign || !allowed(instance, &instance->booleans, first, vr, n, READ, pending) || pending[0])
        CALL(fmi2GetBoolean, vr, n, values);
    for (size_t k = 0; k < n; k++) values[k] = instance->booleans.values[vr[k] - first] != 0;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                   const fmi2Boolean values[]) {
    EXAMINE("setBoolean", "boolean", instance->first.booleans, instance->booleans.count);
    const fmi2ValueReference first = instance->first.booleans, *pending[2] = {NULL, NULL};
    if (foreign || !allowed(instance, &instance->booleans, first, vr, n, WRITE, pending))
        CALL(fmi2SetBoolean, vr, n, values);
    for (size_t k = 0; k < n; k++) instance->booleans.values[vr[k] - first] = values[k] != 0;
    return fmi2OK;
}

/* Integers and Strings always go through Python, which names a reference of another kind. */
EXPORTED fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer values[]) {
    EXAMINE("getInteger", "integer", instance->first.integers, instance->integers);
    CALL(fmi2GetInteger, vr, n, values);
}

EXPORTED fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                   const fmi2Integer values[]) {
    EXAMINE("setInteger", "integer", instance->first.integers, instance->integers);
    CALL(fmi2SetInteger, vr, n, values);
}

EXPORTED fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String values[]) {
    EXAMINE("getString", "string", instance->first.strings, instance->strings);
    CALL(fmi2GetString, vr, n, values);
}

EXPORTED fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String values[]) {
    EXAMINE("setString", "string", instance->first.strings, instance->strings);
    for (size_t k = 0; k < n; k++) {
        if (!values[k]) return refuse(instance, "setString: value %zu is NULL", k + 1);
        if (!is_utf8(values[k])) return refuse(instance, "setString: value %zu is not UTF-8: %.200s", k + 1, values[k]);
    }
    CALL(fmi2SetString, vr, n, values);
}

/* What no FMU of flexsat has, as their model descriptions say. */
#define UNSUPPORTED(name, parameters)                                                                                  \
    EXPORTED fmi2Status fmi2##name parameters {                                                                        \
        BEGIN;                                                                                                         \
        return refuse(instance, #name ": not supported; the model description says so");                               \
    }
#pragma GCC diagnostic ignored "-Wunused-parameter"
UNSUPPORTED(GetDirectionalDerivative,
            (fmi2Component c, const fmi2ValueReference unknown[], size_t nu, const fmi2ValueReference known[],
             size_t nk, const fmi2Real seed[], fmi2Real sensitivity[]))
UNSUPPORTED(SetRealInputDerivatives, (fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                      const fmi2Integer order[], const fmi2Real values[]))
UNSUPPORTED(GetRealOutputDerivatives, (fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], fmi2Real values[]))

EXPORTED fmi2Status fmi2CancelStep(fmi2Component c) {
    BEGIN;
    return refuse(instance, "cancelStep: no step is in progress: fmi2DoStep returns at its end");
}

/* Return whether the status may be inquired: after a step, or the end. */
static fmi2Status inquiry(Instance *instance, const char *call, const void *value) {
    if (instance->control->phase != STEPPING && instance->control->phase != TERMINATED)
        return refuse(instance, "%s: not allowed %s", call,
                      instance->control->phase == FAILED ? "after a refused call" : "before initialisation has ended");
    return value ? fmi2OK : refuse(instance, "%s: the value goes to a NULL pointer", call);
}

/* Steps are never pending nor discarded: two of the four kinds have an answer. */
#define INQUIRY(what, type, kind, answer)                                                                              \
    EXPORTED fmi2Status fmi2Get##what(fmi2Component c, fmi2StatusKind asked, type *value) {                            \
        BEGIN;                                                                                                         \
        if ((status = inquiry(instance, "get" #what, value)) != fmi2OK) return status;                                 \
        if ((int)asked == (kind)) {                                                                                    \
            *value = (answer);                                                                                         \
            return fmi2OK;                                                                                             \
        }                                                                                                              \
        log_to_host(instance->host, instance->name, fmi2Discard, "get" #what ": no answer to kind %d", (int)asked);    \
        return fmi2Discard;                                                                                            \
    }
enum { NO_KIND = -1 };
INQUIRY(Status, fmi2Status, NO_KIND, fmi2OK)
INQUIRY(RealStatus, fmi2Real, fmi2LastSuccessfulTime, *instance->now)
INQUIRY(IntegerStatus, fmi2Integer, NO_KIND, 0)
INQUIRY(BooleanStatus, fmi2Boolean, fmi2Terminated, 0)
INQUIRY(StringStatus, fmi2String, NO_KIND, "")
