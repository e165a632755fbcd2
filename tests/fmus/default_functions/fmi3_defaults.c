/* Defaults of all functions of FMI 3.0 but InstantiateCoSimulation and DoStep. */

#include "defaults.h"

#include "fmi3Functions.h"

WEAK const char *fmi3GetVersion(void) { return fmi3Version; }
WEAK void fmi3FreeInstance(fmi3Instance c) { free(c); }

static void *no_instance(void) { return NULL; }

#define DEFAULT(NAME, BODY) extern fmi3##NAME##TYPE fmi3##NAME __attribute__((weak, alias(#BODY)));
#define VALUES(TYPE) DEFAULT(Get##TYPE, no_values) DEFAULT(Set##TYPE, no_values)

DEFAULT(InstantiateModelExchange, no_instance) DEFAULT(InstantiateScheduledExecution, no_instance)
DEFAULT(SetDebugLogging, accept_all)
DEFAULT(EnterInitializationMode, accept_all)
DEFAULT(ExitInitializationMode, accept_all)
DEFAULT(Terminate, accept_all)
DEFAULT(Reset, refuse)

VALUES(Float32) VALUES(Float64) VALUES(Boolean) VALUES(String) VALUES(Binary) VALUES(Clock)
VALUES(Int8) VALUES(Int16) VALUES(Int32) VALUES(Int64) VALUES(UInt8) VALUES(UInt16) VALUES(UInt32) VALUES(UInt64)

DEFAULT(GetFMUState, get_state)
DEFAULT(SetFMUState, set_state)
DEFAULT(FreeFMUState, free_state)
DEFAULT(SerializedFMUStateSize, measure_state)
DEFAULT(SerializeFMUState, serialise_state)
DEFAULT(DeserializeFMUState, deserialise_state)

DEFAULT(GetNumberOfVariableDependencies, refuse) DEFAULT(GetVariableDependencies, refuse)
DEFAULT(GetDirectionalDerivative, refuse) DEFAULT(GetAdjointDerivative, refuse) DEFAULT(GetOutputDerivatives, refuse)
DEFAULT(EnterConfigurationMode, refuse) DEFAULT(ExitConfigurationMode, refuse)
DEFAULT(EnterEventMode, refuse) DEFAULT(EvaluateDiscreteStates, refuse) DEFAULT(UpdateDiscreteStates, refuse)
DEFAULT(GetIntervalDecimal, refuse) DEFAULT(GetIntervalFraction, refuse) DEFAULT(SetIntervalDecimal, refuse)
DEFAULT(SetIntervalFraction, refuse) DEFAULT(GetShiftDecimal, refuse) DEFAULT(GetShiftFraction, refuse)
DEFAULT(SetShiftDecimal, refuse) DEFAULT(SetShiftFraction, refuse) DEFAULT(ActivateModelPartition, refuse)
DEFAULT(EnterContinuousTimeMode, refuse) DEFAULT(CompletedIntegratorStep, refuse) DEFAULT(EnterStepMode, refuse)
DEFAULT(SetTime, refuse) DEFAULT(SetContinuousStates, refuse) DEFAULT(GetContinuousStates, refuse)
DEFAULT(GetContinuousStateDerivatives, refuse) DEFAULT(GetNominalsOfContinuousStates, refuse)
DEFAULT(GetNumberOfContinuousStates, refuse) DEFAULT(GetEventIndicators, refuse) DEFAULT(GetNumberOfEventIndicators, refuse)
