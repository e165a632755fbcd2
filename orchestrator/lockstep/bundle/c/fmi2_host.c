/* How hosts of FMI 2.0 take messages. */
#include "interface.h"

const char host_mark = '%';

void host_message(const bundle_t *bundle, fmi2Status status, const char *category, const char *text)
{
    ((fmi2CallbackLogger)bundle->host.logger)(bundle->host.environment, bundle->name, status, category, text);
}
