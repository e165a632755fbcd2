/* How hosts of FMI 3.0 take messages: they know an instance by its environment. */
#include "fmi3.h"
#include "interface.h"

const char host_mark = '#';

void host_message(const bundle_t *bundle, fmi2Status status, const char *category, const char *text)
{
    fmi3Status known = status > fmi2Fatal ? fmi3Error : (fmi3Status)status;

    ((fmi3LogMessageCallback)bundle->host.logger)(bundle->host.environment, known, category, text);
}
