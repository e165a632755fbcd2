/* What is logged: one line for each refused call, whatever categories and debug logging a host has switched on. */
#include "instance.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Return the length of the UTF-8 sequence at `text`, or 0 if there is none: no overlong form, no surrogate. */
static int sequence(const char *text)
{
    static const unsigned long least[] = {0, 0, 0x80, 0x800, 0x10000};
    const unsigned char *bytes = (const unsigned char *)text;
    unsigned long letter;
    int length, k;

    if (bytes[0] < 0x80)
        return 1;
    if (bytes[0] < 0xc2 || bytes[0] > 0xf4)
        return 0;
    length = bytes[0] >= 0xf0 ? 4 : bytes[0] >= 0xe0 ? 3 : 2;
    letter = bytes[0] & (0x7fu >> length);
    for (k = 1; k < length; k++) {
        if ((bytes[k] & 0xc0) != 0x80) /* the zero at the end too */
            return 0;
        letter = letter << 6 | (bytes[k] & 0x3fu);
    }
    if (letter < least[length] || letter > 0x10ffff || (letter >= 0xd800 && letter <= 0xdfff))
        return 0;
    return length;
}

int is_utf8(const char *text)
{
    while (*text) {
        const int length = sequence(text);
        if (length == 0)
            return 0;
        text += length;
    }
    return 1;
}

void replace_bytes_not_utf8(char *text)
{
    while (*text) {
        const int length = sequence(text);
        if (length == 0)
            *text = '?';
        text += length ? length : 1;
    }
}

static void pass_on(const fmi2CallbackFunctions *host, fmi2String name, fmi2Status status, char *text)
{
    replace_bytes_not_utf8(text); /* it may quote what a host gave, and be cut inside a letter */
    if (host != NULL && host->logger != NULL)
        host->logger(host->componentEnvironment, name, status, CATEGORY, "%s", text);
}

void log_to_host(const fmi2CallbackFunctions *host, fmi2String name, fmi2Status status, const char *format, ...)
{
    char text[REASON_SIZE];
    va_list arguments;

    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    pass_on(host, name, status, text);
}

fmi2Status refuse_call(Instance *instance, const char *call, const char *format, ...)
{
    char text[REASON_SIZE];
    va_list arguments;
    int written;

    written = snprintf(text, sizeof text, "%s: ", call);
    if (written > 0 && (size_t)written < sizeof text) {
        va_start(arguments, format);
        vsnprintf(text + written, sizeof text - (size_t)written, format, arguments);
        va_end(arguments);
    }
    if (instance->failure[0] == '\0') {
        strcpy(instance->failure, text);
        poison_outputs(&instance->component); /* so that they are not mistaken for results */
    }
    instance->phase = FAILED;
    pass_on(&instance->host, instance->name, fmi2Error, text);
    return fmi2Error;
}

fmi2Status refuse_for_model(Instance *instance, const char *call)
{
    const char *message = instance->component.message;

    instance->started = 0;
    return refuse_call(instance, call, "%s", message[0] != '\0' ? message : "the model gives no reason");
}
