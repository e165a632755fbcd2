/* Configuration, event mode, clocks, and what only other kinds of simulation have: hosts look for these functions,
and an FMU for co-simulation without them refuses the calls. */
#include "fmi3_instance.h"

static fmi3Status unsupported(fmi3Instance c, const char *call)
{
    return c == NULL ? fmi3Error
                     : (fmi3Status)refuse_call(c, call, "not supported; the model description says so");
}

fmi3Status FMI3(fmi3EnterConfigurationMode)(fmi3Instance c) { return unsupported(c, "enterConfigurationMode"); }

fmi3Status FMI3(fmi3ExitConfigurationMode)(fmi3Instance c) { return unsupported(c, "exitConfigurationMode"); }

fmi3Status FMI3(fmi3EnterEventMode)(fmi3Instance c) { return unsupported(c, "enterEventMode"); }

fmi3Status FMI3(fmi3EnterStepMode)(fmi3Instance c) { return unsupported(c, "enterStepMode"); }

fmi3Status FMI3(fmi3EvaluateDiscreteStates)(fmi3Instance c) { return unsupported(c, "evaluateDiscreteStates"); }

fmi3Status FMI3(fmi3UpdateDiscreteStates)(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *ends,
                                          fmi3Boolean *nominals_changed, fmi3Boolean *states_changed,
                                          fmi3Boolean *next_defined, fmi3Float64 *next)
{
    (void)again, (void)ends, (void)nominals_changed, (void)states_changed, (void)next_defined, (void)next;
    return unsupported(c, "updateDiscreteStates");
}

fmi3Status FMI3(fmi3ActivateModelPartition)(fmi3Instance c, fmi3ValueReference vr, fmi3Float64 time)
{
    (void)vr, (void)time;
    return unsupported(c, "activateModelPartition");
}

fmi3Status FMI3(fmi3GetIntervalDecimal)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                        fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
{
    (void)vr, (void)n, (void)intervals, (void)qualifiers;
    return unsupported(c, "getIntervalDecimal");
}

fmi3Status FMI3(fmi3GetIntervalFraction)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                         fmi3UInt64 counters[], fmi3UInt64 resolutions[],
                                         fmi3IntervalQualifier qualifiers[])
{
    (void)vr, (void)n, (void)counters, (void)resolutions, (void)qualifiers;
    return unsupported(c, "getIntervalFraction");
}

fmi3Status FMI3(fmi3GetShiftDecimal)(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 shifts[])
{
    (void)vr, (void)n, (void)shifts;
    return unsupported(c, "getShiftDecimal");
}

fmi3Status FMI3(fmi3GetShiftFraction)(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3UInt64 counters[],
                                      fmi3UInt64 resolutions[])
{
    (void)vr, (void)n, (void)counters, (void)resolutions;
    return unsupported(c, "getShiftFraction");
}

fmi3Status FMI3(fmi3SetIntervalDecimal)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                        const fmi3Float64 intervals[])
{
    (void)vr, (void)n, (void)intervals;
    return unsupported(c, "setIntervalDecimal");
}

fmi3Status FMI3(fmi3SetIntervalFraction)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                         const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
{
    (void)vr, (void)n, (void)counters, (void)resolutions;
    return unsupported(c, "setIntervalFraction");
}

fmi3Status FMI3(fmi3SetShiftDecimal)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                     const fmi3Float64 shifts[])
{
    (void)vr, (void)n, (void)shifts;
    return unsupported(c, "setShiftDecimal");
}

fmi3Status FMI3(fmi3SetShiftFraction)(fmi3Instance c, const fmi3ValueReference vr[], size_t n,
                                      const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
{
    (void)vr, (void)n, (void)counters, (void)resolutions;
    return unsupported(c, "setShiftFraction");
}

fmi3Status FMI3(fmi3EnterContinuousTimeMode)(fmi3Instance c) { return unsupported(c, "enterContinuousTimeMode"); }

fmi3Status FMI3(fmi3CompletedIntegratorStep)(fmi3Instance c, fmi3Boolean no_set_state_prior, fmi3Boolean *events,
                                             fmi3Boolean *ends)
{
    (void)no_set_state_prior, (void)events, (void)ends;
    return unsupported(c, "completedIntegratorStep");
}

fmi3Status FMI3(fmi3SetTime)(fmi3Instance c, fmi3Float64 time)
{
    (void)time;
    return unsupported(c, "setTime");
}

fmi3Status FMI3(fmi3SetContinuousStates)(fmi3Instance c, const fmi3Float64 values[], size_t size)
{
    (void)values, (void)size;
    return unsupported(c, "setContinuousStates");
}

fmi3Status FMI3(fmi3GetContinuousStateDerivatives)(fmi3Instance c, fmi3Float64 values[], size_t size)
{
    (void)values, (void)size;
    return unsupported(c, "getContinuousStateDerivatives");
}

fmi3Status FMI3(fmi3GetEventIndicators)(fmi3Instance c, fmi3Float64 values[], size_t size)
{
    (void)values, (void)size;
    return unsupported(c, "getEventIndicators");
}

fmi3Status FMI3(fmi3GetContinuousStates)(fmi3Instance c, fmi3Float64 values[], size_t size)
{
    (void)values, (void)size;
    return unsupported(c, "getContinuousStates");
}

fmi3Status FMI3(fmi3GetNominalsOfContinuousStates)(fmi3Instance c, fmi3Float64 values[], size_t size)
{
    (void)values, (void)size;
    return unsupported(c, "getNominalsOfContinuousStates");
}

fmi3Status FMI3(fmi3GetNumberOfEventIndicators)(fmi3Instance c, size_t *n)
{
    (void)n;
    return unsupported(c, "getNumberOfEventIndicators");
}

fmi3Status FMI3(fmi3GetNumberOfContinuousStates)(fmi3Instance c, size_t *n)
{
    (void)n;
    return unsupported(c, "getNumberOfContinuousStates");
}
