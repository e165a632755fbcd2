/* Saved states as FMI 3.0 has them. */
#include "fmi3_instance.h"

fmi3Status FMI3(fmi3GetFMUState)(fmi3Instance c, fmi3FMUState *state)
{
    return c == NULL ? fmi3Error : (fmi3Status)keep_state(c, "getFMUState", state);
}

fmi3Status FMI3(fmi3SetFMUState)(fmi3Instance c, fmi3FMUState state)
{
    return c == NULL ? fmi3Error : (fmi3Status)restore_kept(c, "setFMUState", state);
}

fmi3Status FMI3(fmi3FreeFMUState)(fmi3Instance c, fmi3FMUState *state)
{
    return c == NULL ? fmi3Error : (fmi3Status)free_state(c, "freeFMUState", state);
}

fmi3Status FMI3(fmi3SerializedFMUStateSize)(fmi3Instance c, fmi3FMUState state, size_t *size)
{
    return c == NULL ? fmi3Error : (fmi3Status)serialised_size(c, "serializedFMUStateSize", state, size);
}

fmi3Status FMI3(fmi3SerializeFMUState)(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    return c == NULL ? fmi3Error : (fmi3Status)serialise(c, "serializeFMUState", state, bytes, size);
}

fmi3Status FMI3(fmi3DeserializeFMUState)(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    return c == NULL ? fmi3Error : (fmi3Status)deserialise(c, "deserializeFMUState", bytes, size, state);
}
