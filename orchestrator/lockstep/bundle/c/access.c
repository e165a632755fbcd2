#include "access.h"

#include "messages.h"

static int arrays_there(const bundle_t *bundle, const char *call, size_t count, const void *references,
                        const void *values)
{
    if (count == 0 || (references != NULL && values != NULL))
        return 1;
    refuse(bundle, "%s: has %lu references, and no array of them or of the values", call, (unsigned long)count);
    return 0;
}

int may_set(const bundle_t *bundle, const char *call, size_t count, const void *references, const void *values)
{
    if (bundle->life <= STEPPING)
        return arrays_there(bundle, call, count, references, values);
    refuse(bundle, "%s: is not allowed after the end or a failure", call);
    return 0;
}

int may_get(const bundle_t *bundle, const char *call, size_t count, const void *references, const void *values)
{
    if (bundle->life != FATAL)
        return arrays_there(bundle, call, count, references, values);
    refuse(bundle, "%s: is not allowed after a fatal failure", call);
    return 0;
}

int may_have_state(const bundle_t *bundle, const char *call, const void *given)
{
    if (bundle->life == FATAL)
        refuse(bundle, "%s: is not allowed after a fatal failure", call);
    else if (given == NULL)
        refuse(bundle, "%s: has no place for the state, or no state", call);
    else
        return 1;
    return 0;
}

fmi2Status noted_fatal(const bundle_t *bundle, fmi2Status status)
{
    return status >= fmi2Error && bundle->life == FATAL ? fmi2Fatal : status;
}
