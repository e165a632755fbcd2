/* The functions of FMI 2.0 co-simulation that an FMU of the tests need not define: all but Instantiate and DoStep. */

#include "rest.h"

#include "fmi2Functions.h"

WEAK const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
WEAK const char *fmi2GetVersion(void) { return fmi2Version; }
WEAK void fmi2FreeInstance(fmi2Component c) { free(c); }

#define REST(NAME, BODY) extern fmi2##NAME##TYPE fmi2##NAME __attribute__((weak, alias(#BODY)));

REST(SetDebugLogging, accept_all)
REST(SetupExperiment, accept_all)
REST(EnterInitializationMode, accept_all)
REST(ExitInitializationMode, accept_all)
REST(Terminate, accept_all)
REST(Reset, refuse)

REST(GetReal, no_values) REST(SetReal, no_values)
REST(GetInteger, no_values) REST(SetInteger, no_values)
REST(GetBoolean, no_values) REST(SetBoolean, no_values)
REST(GetString, no_values) REST(SetString, no_values)

REST(GetFMUstate, get_state)
REST(SetFMUstate, set_state)
REST(FreeFMUstate, free_state)
REST(SerializedFMUstateSize, measure_state)
REST(SerializeFMUstate, serialise_state)
REST(DeSerializeFMUstate, deserialise_state)

REST(GetDirectionalDerivative, refuse) REST(SetRealInputDerivatives, refuse) REST(GetRealOutputDerivatives, refuse)
REST(CancelStep, refuse) REST(GetStatus, refuse) REST(GetRealStatus, refuse) REST(GetIntegerStatus, refuse)
REST(GetBooleanStatus, refuse) REST(GetStringStatus, refuse)
