/* Messages to the host: those of the bundle, and those of its components with their names. */
#ifndef BUNDLE_MESSAGES_H
#define BUNDLE_MESSAGES_H

#include "bundle.h"

#if defined(__GNUC__)
#define PRINTED_FROM(text, arguments) __attribute__((format(printf, text, arguments)))
#else
#define PRINTED_FROM(text, arguments)
#endif

/* Report an error of the host or the bundle; return fmi2Error. */
fmi2Status refuse(const bundle_t *bundle, const char *format, ...) PRINTED_FROM(2, 3);

/* Judge the status of a call to a component, named without prefix as in FMI 2.0, which failed above fmi2Warning; return the status. */
fmi2Status judge(component_t *component, const char *call, fmi2Status status);

/* The logger of components; their environment is the component. */
void component_message(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                       fmi2String category, fmi2String message, ...);
void component_message3(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                        fmi3String message);

#endif
