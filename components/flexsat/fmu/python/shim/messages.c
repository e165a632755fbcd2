/* What the shim logs. Messages above fmi2OK need no category and no debug logging: a host that switches both off still
   learns why a call failed. */

#include "shim.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LONGEST = 1000 }; /* bytes of a message of the shim's own */

void log_to_host(const fmi2CallbackFunctions *host, fmi2String name, fmi2Status status, const char *format, ...) {
    char text[LONGEST], *safe;
    va_list arguments;
    if (!host || !host->logger) return;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    safe = copy_as_utf8(text); /* it may quote what a host gave, and be cut inside a letter */
    if (safe) host->logger(host->componentEnvironment, name, status, CATEGORY, "%s", safe);
    free(safe);
}

/* The wrapper passes on messages of the model, which are formats already, and its own, which are not. */
void log_of_wrapper(void *given, fmi2String name, fmi2Status status, fmi2String category, fmi2String message, ...) {
    const Instance *instance = given;
    (void)name; /* of the wrapper: where the host's is not UTF-8, it is another */
    if (!instance->host || !instance->host->logger || (status == fmi2OK && !instance->logging)) return;
    if (category && *category)
        instance->host->logger(instance->host->componentEnvironment, instance->name, status, category, message);
    else
        instance->host->logger(instance->host->componentEnvironment, instance->name, status, CATEGORY, "%s", message);
}

/* Log why a call is refused, and stop the model: after fmi2Error it waits for a reset, or a saved state. */
fmi2Status refuse(Instance *instance, const char *format, ...) {
    const fmi2ValueReference reference = REFUSAL_REFERENCE;
    char text[LONGEST], *safe = NULL;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (instance->control && !instance->fatal) safe = copy_as_utf8(text);
    if (safe)
        outcome(instance, wrapper.fmi2SetString(instance->wrapped, &reference, 1, (const fmi2String *)&safe));
    else
        log_to_host(instance->host, instance->name, fmi2Error, "%s", text);
    free(safe);
    return instance->fatal ? fmi2Fatal : fmi2Error;
}

/* Return the length of the UTF-8 sequence at `text`, or 0 if there is none: no overlong form, no surrogate. */
static int sequence(const unsigned char *text) {
    static const unsigned int least[] = {0, 0, 0x80, 0x800, 0x10000};
    if (text[0] < 0x80) return 1;
    int length = text[0] >= 0xf0 ? 4 : text[0] >= 0xe0 ? 3 : 2;
    if (text[0] < 0xc2 || text[0] > 0xf4) return 0;
    unsigned int letter = text[0] & (0x7fu >> length);
    for (int k = 1; k < length; k++) {
        if ((text[k] & 0xc0) != 0x80) return 0; /* the zero at the end too */
        letter = letter << 6 | (text[k] & 0x3fu);
    }
    if (letter < least[length] || letter > 0x10ffff || (letter >= 0xd800 && letter <= 0xdfff)) return 0;
    return length;
}

int is_utf8(const char *text) {
    for (int length; *text; text += length)
        if (!(length = sequence((const unsigned char *)text))) return 0;
    return 1;
}

/* Return a copy to be freed, with a question mark for each byte that is not UTF-8. */
char *copy_as_utf8(const char *text) {
    char *copy = malloc(strlen(text) + 1), *end = copy;
    if (!copy) return NULL;
    while (*text) {
        int length = sequence((const unsigned char *)text);
        if (!length) *end++ = '?', text++;
        for (; length; length--) *end++ = *text++;
    }
    *end = '\0';
    return copy;
}
