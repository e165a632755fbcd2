/* Which FMU this is; the generated identity.c says it. */
#ifndef FLEXSAT_IDENTITY_H
#define FLEXSAT_IDENTITY_H

typedef struct Identity {
    const char *guid;        /* of the model description: what a host instantiates with */
    int equal_steps;         /* whether all steps have to be as long as the first */
    const char *step_set_by; /* the parameter that sets the only step accepted; NULL: none does */
} Identity;

extern const Identity this_fmu;

#endif
