/* Defaults of all functions of FMI 2.0 co-simulation but Instantiate and DoStep. */

#include "defaults.h"

#include "fmi2Functions.h"

WEAK const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
WEAK const char *fmi2GetVersion(void) { return fmi2Version; }
WEAK void fmi2FreeInstance(fmi2Component c) { free(c); }

#define DEFAULT(NAME, BODY) extern fmi2##NAME##TYPE fmi2##NAME __attribute__((weak, alias(#BODY)));

DEFAULT(SetDebugLogging, accept_all)
DEFAULT(SetupExperiment, accept_all)
DEFAULT(EnterInitializationMode, accept_all)
DEFAULT(ExitInitializationMode, accept_all)
DEFAULT(Terminate, accept_all)
DEFAULT(Reset, refuse)

DEFAULT(GetReal, no_values) DEFAULT(SetReal, no_values)
DEFAULT(GetInteger, no_values) DEFAULT(SetInteger, no_values)
DEFAULT(GetBoolean, no_values) DEFAULT(SetBoolean, no_values)
DEFAULT(GetString, no_values) DEFAULT(SetString, no_values)

DEFAULT(GetFMUstate, get_state)
DEFAULT(SetFMUstate, set_state)
DEFAULT(FreeFMUstate, free_state)
DEFAULT(SerializedFMUstateSize, measure_state)
DEFAULT(SerializeFMUstate, serialise_state)
DEFAULT(DeSerializeFMUstate, deserialise_state)

DEFAULT(GetDirectionalDerivative, refuse) DEFAULT(SetRealInputDerivatives, refuse) DEFAULT(GetRealOutputDerivatives, refuse)
DEFAULT(CancelStep, refuse) DEFAULT(GetStatus, refuse) DEFAULT(GetRealStatus, refuse) DEFAULT(GetIntegerStatus, refuse)
DEFAULT(GetBooleanStatus, refuse) DEFAULT(GetStringStatus, refuse)
