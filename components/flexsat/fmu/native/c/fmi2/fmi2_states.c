/* Saved states as FMI 2.0 has them. */
#include "fmi2_instance.h"

fmi2Status FMI2(fmi2GetFMUstate)(fmi2Component c, fmi2FMUstate *state)
{
    return c == NULL ? fmi2Error : (fmi2Status)keep_state(c, "getFMUstate", state);
}

fmi2Status FMI2(fmi2SetFMUstate)(fmi2Component c, fmi2FMUstate state)
{
    return c == NULL ? fmi2Error : (fmi2Status)restore_kept(c, "setFMUstate", state);
}

fmi2Status FMI2(fmi2FreeFMUstate)(fmi2Component c, fmi2FMUstate *state)
{
    return c == NULL ? fmi2Error : (fmi2Status)free_state(c, "freeFMUstate", state);
}

fmi2Status FMI2(fmi2SerializedFMUstateSize)(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    return c == NULL ? fmi2Error : (fmi2Status)serialised_size(c, "serializedFMUstateSize", state, size);
}

fmi2Status FMI2(fmi2SerializeFMUstate)(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    return c == NULL ? fmi2Error
                     : (fmi2Status)serialise(c, "serializeFMUstate", state, (unsigned char *)bytes, size);
}

fmi2Status FMI2(fmi2DeSerializeFMUstate)(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    return c == NULL ? fmi2Error
                     : (fmi2Status)deserialise(c, "deSerializeFMUstate", (const unsigned char *)bytes, size, state);
}
