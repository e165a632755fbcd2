/* Types of FMI 3.0 that no variable has: lists of their variables are empty, or refused. */
#include "fmi3_instance.h"

static fmi3Status without_variables(Instance *instance, Call access, const char *call, const char *type,
                                    const fmi3ValueReference vr[], size_t n, size_t size)
{
    if (instance == NULL)
        return fmi3Error;
    if (n > 0 && vr == NULL)
        return (fmi3Status)refuse_call(instance, call, "%lu value references in a NULL array", (unsigned long)n);
    if (n > 0)
        return (fmi3Status)refuse_reference(instance, call, type, vr[0]);
    if (size > 0)
        return (fmi3Status)refuse_call(instance, call, "%lu values of no variable", (unsigned long)size);
    return (fmi3Status)check_order(instance, access, call);
}

#define WITHOUT_VARIABLES(Type)                                                                                      \
    fmi3Status FMI3(fmi3Get##Type)(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3##Type values[],     \
                                   size_t size)                                                                      \
    {                                                                                                                \
        (void)values;                                                                                                \
        return without_variables(c, GET, "get" #Type, #Type, vr, n, size);                                           \
    }                                                                                                                \
                                                                                                                     \
    fmi3Status FMI3(fmi3Set##Type)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,                          \
                                   const fmi3##Type values[], size_t size)                                           \
    {                                                                                                                \
        (void)values;                                                                                                \
        return without_variables(c, SET, "set" #Type, #Type, vr, n, size);                                           \
    }

WITHOUT_VARIABLES(Float32)
WITHOUT_VARIABLES(Int8)
WITHOUT_VARIABLES(UInt8)
WITHOUT_VARIABLES(Int16)
WITHOUT_VARIABLES(UInt16)
WITHOUT_VARIABLES(UInt32)
WITHOUT_VARIABLES(Int64)
WITHOUT_VARIABLES(UInt64)

fmi3Status FMI3(fmi3GetBinary)(fmi3Instance c, const fmi3ValueReference vr[], size_t n, size_t sizes[],
                               fmi3Binary values[], size_t size)
{
    (void)sizes, (void)values;
    return without_variables(c, GET, "getBinary", "Binary", vr, n, size);
}

fmi3Status FMI3(fmi3SetBinary)(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const size_t sizes[],
                               const fmi3Binary values[], size_t size)
{
    (void)sizes, (void)values;
    return without_variables(c, SET, "setBinary", "Binary", vr, n, size);
}

fmi3Status FMI3(fmi3GetClock)(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Clock values[])
{
    (void)values;
    return without_variables(c, GET, "getClock", "Clock", vr, n, 0);
}

fmi3Status FMI3(fmi3SetClock)(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Clock values[])
{
    (void)values;
    return without_variables(c, SET, "setClock", "Clock", vr, n, 0);
}
