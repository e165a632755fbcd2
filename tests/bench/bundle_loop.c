/* Steps an FMU of FMI 2.0 and gets Reals after each step; prints the processor's time of all steps [s]:
     bundle_loop LIBRARY RESOURCES GUID STEPS SECONDS_A_STEP REFERENCES... */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "fmi2Functions.h"

static void logger(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String message, ...)
{
    (void)environment, (void)name, (void)category;
    if (status != fmi2OK)
        fprintf(stderr, "%s\n", message);
}

static const fmi2CallbackFunctions callbacks = {logger, calloc, free, NULL, NULL};

int main(int argument_count, char **arguments)
{
    if (argument_count < 6)
        return 2;
    void *library = dlopen(arguments[1], RTLD_NOW);
    if (library == NULL)
        return 2;
    fmi2InstantiateTYPE *instantiate = dlsym(library, "fmi2Instantiate");
    fmi2SetupExperimentTYPE *setup = dlsym(library, "fmi2SetupExperiment");
    fmi2EnterInitializationModeTYPE *enter = dlsym(library, "fmi2EnterInitializationMode");
    fmi2ExitInitializationModeTYPE *leave = dlsym(library, "fmi2ExitInitializationMode");
    fmi2DoStepTYPE *do_step = dlsym(library, "fmi2DoStep");
    fmi2GetRealTYPE *get = dlsym(library, "fmi2GetReal");
    fmi2Component c = instantiate("it", fmi2CoSimulation, arguments[3], arguments[2], &callbacks, fmi2False, fmi2False);
    const long steps = atol(arguments[4]), count = argument_count - 6;
    const double length = atof(arguments[5]);
    fmi2ValueReference *references = calloc((size_t)count + 1, sizeof *references);
    double *values = calloc((size_t)count + 1, sizeof *values);
    for (long k = 0; k < count; k++)
        references[k] = (fmi2ValueReference)strtoul(arguments[6 + k], NULL, 10);
    if (c == NULL || setup(c, fmi2False, 0.0, 0.0, fmi2False, 0.0) || enter(c) || leave(c))
        return 1;
    const clock_t begun = clock();
    for (long k = 0; k < steps; k++)
        if (do_step(c, (double)k * length, length, fmi2True) || get(c, references, (size_t)count, values))
            return 1;
    printf("%.9g\n", (double)(clock() - begun) / CLOCKS_PER_SEC);
    return 0;
}
