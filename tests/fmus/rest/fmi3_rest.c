/* The functions of FMI 3.0 that an FMU of the tests need not define: all but InstantiateCoSimulation and DoStep. */

#include "rest.h"

#include "fmi3Functions.h"

WEAK const char *fmi3GetVersion(void) { return fmi3Version; }
WEAK void fmi3FreeInstance(fmi3Instance c) { free(c); }

static void *no_instance(void) { return NULL; }

#define REST(NAME, BODY) extern fmi3##NAME##TYPE fmi3##NAME __attribute__((weak, alias(#BODY)));
#define VALUES(TYPE) REST(Get##TYPE, no_values) REST(Set##TYPE, no_values)

REST(InstantiateModelExchange, no_instance) REST(InstantiateScheduledExecution, no_instance)
REST(SetDebugLogging, accept_all)
REST(EnterInitializationMode, accept_all)
REST(ExitInitializationMode, accept_all)
REST(Terminate, accept_all)
REST(Reset, refuse)

VALUES(Float32) VALUES(Float64) VALUES(Boolean) VALUES(String) VALUES(Binary) VALUES(Clock)
VALUES(Int8) VALUES(Int16) VALUES(Int32) VALUES(Int64) VALUES(UInt8) VALUES(UInt16) VALUES(UInt32) VALUES(UInt64)

REST(GetFMUState, get_state)
REST(SetFMUState, set_state)
REST(FreeFMUState, free_state)
REST(SerializedFMUStateSize, measure_state)
REST(SerializeFMUState, serialise_state)
REST(DeserializeFMUState, deserialise_state)

REST(GetNumberOfVariableDependencies, refuse) REST(GetVariableDependencies, refuse)
REST(GetDirectionalDerivative, refuse) REST(GetAdjointDerivative, refuse) REST(GetOutputDerivatives, refuse)
REST(EnterConfigurationMode, refuse) REST(ExitConfigurationMode, refuse)
REST(EnterEventMode, refuse) REST(EvaluateDiscreteStates, refuse) REST(UpdateDiscreteStates, refuse)
REST(GetIntervalDecimal, refuse) REST(GetIntervalFraction, refuse) REST(SetIntervalDecimal, refuse)
REST(SetIntervalFraction, refuse) REST(GetShiftDecimal, refuse) REST(GetShiftFraction, refuse)
REST(SetShiftDecimal, refuse) REST(SetShiftFraction, refuse) REST(ActivateModelPartition, refuse)
REST(EnterContinuousTimeMode, refuse) REST(CompletedIntegratorStep, refuse) REST(EnterStepMode, refuse)
REST(SetTime, refuse) REST(SetContinuousStates, refuse) REST(GetContinuousStates, refuse)
REST(GetContinuousStateDerivatives, refuse) REST(GetNominalsOfContinuousStates, refuse)
REST(GetNumberOfContinuousStates, refuse) REST(GetEventIndicators, refuse) REST(GetNumberOfEventIndicators, refuse)
