/* Types of FMI 3.0 that no variable of a bundle has: lists of their variables are empty, or refused. */
#include "fmi3_functions.h"
#include "messages.h"

static fmi3Status without_variables(fmi3Instance instance, const char *call, size_t count, size_t size)
{
    if (instance == NULL)
        return fmi3Error;
    if (count == 0 && size == 0)
        return fmi3OK;
    return (fmi3Status)refuse(instance, "%s: the FMU has no variable of this type", call);
}

#define WITHOUT_VARIABLES(Type)                                                                                     \
    fmi3Status fmi3Get##Type(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3##Type values[],          \
                             size_t size)                                                                           \
    {                                                                                                               \
        (void)vr, (void)values;                                                                                     \
        return without_variables(c, "fmi3Get" #Type, n, size);                                                      \
    }                                                                                                               \
                                                                                                                    \
    fmi3Status fmi3Set##Type(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3##Type values[],    \
                             size_t size)                                                                           \
    {                                                                                                               \
        (void)vr, (void)values;                                                                                     \
        return without_variables(c, "fmi3Set" #Type, n, size);                                                      \
    }

WITHOUT_VARIABLES(Float32)
WITHOUT_VARIABLES(Int8)
WITHOUT_VARIABLES(UInt8)
WITHOUT_VARIABLES(Int16)
WITHOUT_VARIABLES(UInt16)
WITHOUT_VARIABLES(UInt32)
WITHOUT_VARIABLES(UInt64)

fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, size_t sizes[],
                         fmi3Binary values[], size_t size)
{
    (void)vr, (void)sizes, (void)values;
    return without_variables(c, "fmi3GetBinary", n, size);
}

fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const size_t sizes[],
                               const fmi3Binary values[], size_t size)
{
    (void)vr, (void)sizes, (void)values;
    return without_variables(c, "fmi3SetBinary", n, size);
}

fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Clock values[])
{
    (void)vr, (void)values;
    return without_variables(c, "fmi3GetClock", n, 0);
}

fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Clock values[])
{
    (void)vr, (void)values;
    return without_variables(c, "fmi3SetClock", n, 0);
}
