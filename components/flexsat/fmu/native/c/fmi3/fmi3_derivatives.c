/* Derivatives and dependencies as FMI 3.0 has them: directional ones where the model gives them, no others. */
#include "fmi3_instance.h"

static fmi3Status unsupported(fmi3Instance c, const char *call)
{
    return c == NULL ? fmi3Error
                     : (fmi3Status)refuse_call(c, call, "not supported; the model description says so");
}

/* Return whether a reference is that of a real port with a flag, INPUT or OUTPUT. */
static int is_real(fmi3ValueReference reference, int flag)
{
    const Port *port = port_of(reference);

    return port != NULL && port->kind == REAL && (port->flags & flag) != 0;
}

/* Refuse a list that is NULL, that has other variables than real ones with a flag, or another number of elements. */
static Status examine(Instance *instance, const char *call, const char *what, int flag, const fmi3ValueReference vr[],
                      size_t n, const fmi3Float64 values[], size_t size)
{
    size_t scalars = 0, k;

    if ((n > 0 && vr == NULL) || (size > 0 && values == NULL))
        return refuse_call(instance, call, "%lu %ss in a NULL array", (unsigned long)n, what);
    for (k = 0; k < n; k++) {
        if (!is_real(vr[k], flag))
            return refuse_call(instance, call, "%s %lu: value reference %u is not that of a Float64 %s", what,
                               (unsigned long)k + 1, (unsigned)vr[k], flag == INPUT ? "input" : "output");
        scalars += (size_t)port_of(vr[k])->size;
    }
    if (size != scalars)
        return refuse_call(instance, call, "%lu values, where the %ss have %lu elements", (unsigned long)size, what,
                           (unsigned long)scalars);
    return CALL_OK;
}

fmi3Status FMI3(fmi3GetDirectionalDerivative)(fmi3Instance c, const fmi3ValueReference unknowns[], size_t n_unknowns,
                                              const fmi3ValueReference knowns[], size_t n_knowns,
                                              const fmi3Float64 seed[], size_t n_seed, fmi3Float64 sensitivity[],
                                              size_t n_sensitivity)
{
    static const char call[] = "getDirectionalDerivative";
    Instance *instance = c;
    size_t k, number = 0;
    int i;

    if (instance == NULL || port_table.differentiate == NULL)
        return unsupported(c, call);
    if (examine(instance, call, "unknown", OUTPUT, unknowns, n_unknowns, sensitivity, n_sensitivity) != CALL_OK
        || examine(instance, call, "known", INPUT, knowns, n_knowns, seed, n_seed) != CALL_OK
        || begin_to_differentiate(instance, call) != CALL_OK)
        return fmi3Error;
    for (k = 0; k < n_knowns; k++)
        for (i = 0; i < port_of(knowns[k])->size; i++, number++)
            if (add_seed(instance, call, port_of(knowns[k])->first + i, seed[number], number + 1) != CALL_OK)
                return fmi3Error;
    if (differentiate(instance, call) != CALL_OK)
        return fmi3Error;
    for (k = 0; k < n_unknowns; k++)
        for (i = 0; i < port_of(unknowns[k])->size; i++)
            if (check_derivative(instance, call, port_of(unknowns[k])->first + i) != CALL_OK)
                return fmi3Error;
    for (k = 0; k < n_unknowns; k++)
        for (i = 0; i < port_of(unknowns[k])->size; i++)
            *sensitivity++ = instance->change[port_of(unknowns[k])->first + i];
    return fmi3OK;
}

fmi3Status FMI3(fmi3GetAdjointDerivative)(fmi3Instance c, const fmi3ValueReference unknowns[], size_t n_unknowns,
                                          const fmi3ValueReference knowns[], size_t n_knowns,
                                          const fmi3Float64 seed[], size_t n_seed, fmi3Float64 sensitivity[],
                                          size_t n_sensitivity)
{
    (void)unknowns, (void)n_unknowns, (void)knowns, (void)n_knowns, (void)seed, (void)n_seed, (void)sensitivity,
        (void)n_sensitivity;
    return unsupported(c, "getAdjointDerivative");
}

fmi3Status FMI3(fmi3GetOutputDerivatives)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                          const fmi3Int32 orders[], fmi3Float64 values[], size_t size)
{
    (void)vr, (void)n, (void)orders, (void)values, (void)size;
    return unsupported(c, "getOutputDerivatives");
}

fmi3Status FMI3(fmi3GetNumberOfVariableDependencies)(fmi3Instance c, fmi3ValueReference vr, size_t *n)
{
    (void)vr, (void)n;
    return unsupported(c, "getNumberOfVariableDependencies");
}

fmi3Status FMI3(fmi3GetVariableDependencies)(fmi3Instance c, fmi3ValueReference vr, size_t elements[],
                                             fmi3ValueReference independents[], size_t independent_elements[],
                                             fmi3DependencyKind kinds[], size_t n)
{
    (void)vr, (void)elements, (void)independents, (void)independent_elements, (void)kinds, (void)n;
    return unsupported(c, "getVariableDependencies");
}
