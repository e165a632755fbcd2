/* Directional derivatives as FMI 2.0 has them. */
#include "fmi2_instance.h"

/* Return whether a reference is that of a real variable with a flag, INPUT or OUTPUT. */
static int is_real(fmi2ValueReference reference, int flag)
{
    return reference < (fmi2ValueReference)port_table.counts[REAL] &&
           (ports[port_of_reference[reference]].flags & flag) != 0;
}

/* Refuse lists that are NULL, what is no derivative, and calls out of order. */
static Status examine(Instance *instance, const char *call, const fmi2ValueReference unknown[], size_t unknowns,
                      const fmi2ValueReference known[], size_t knowns, const fmi2Real seed[],
                      const fmi2Real sensitivity[])
{
    size_t k;

    if (unknowns > 0 && (unknown == NULL || sensitivity == NULL))
        return refuse_call(instance, call, "%lu unknowns in a NULL array", (unsigned long)unknowns);
    if (knowns > 0 && (known == NULL || seed == NULL))
        return refuse_call(instance, call, "%lu knowns in a NULL array", (unsigned long)knowns);
    for (k = 0; k < unknowns; k++)
        if (!is_real(unknown[k], OUTPUT))
            return refuse_call(instance, call, "unknown %lu: value reference %u is not that of a real output",
                               (unsigned long)k + 1, unknown[k]);
    for (k = 0; k < knowns; k++)
        if (!is_real(known[k], INPUT))
            return refuse_call(instance, call, "known %lu: value reference %u is not that of a real input",
                               (unsigned long)k + 1, known[k]);
    return begin_to_differentiate(instance, call);
}

fmi2Status FMI2(fmi2GetDirectionalDerivative)(fmi2Component c, const fmi2ValueReference unknown[], size_t unknowns,
                                              const fmi2ValueReference known[], size_t knowns, const fmi2Real seed[],
                                              fmi2Real sensitivity[])
{
    static const char call[] = "getDirectionalDerivative";
    Instance *instance = c;
    size_t k;

    if (instance == NULL)
        return fmi2Error;
    if (port_table.differentiate == NULL)
        return (fmi2Status)refuse_call(instance, "GetDirectionalDerivative",
                                       "not supported; the model description says so");
    if (examine(instance, call, unknown, unknowns, known, knowns, seed, sensitivity) != CALL_OK)
        return fmi2Error;
    for (k = 0; k < knowns; k++)
        if (add_seed(instance, call, (int)known[k], seed[k], k + 1) != CALL_OK)
            return fmi2Error;
    if (differentiate(instance, call) != CALL_OK)
        return fmi2Error;
    for (k = 0; k < unknowns; k++)
        if (check_derivative(instance, call, (int)unknown[k]) != CALL_OK)
            return fmi2Error;
    for (k = 0; k < unknowns; k++)
        sensitivity[k] = instance->change[unknown[k]];
    return fmi2OK;
}
