/* The calls of the fuzzer as FMI 2.0 has them. */
#include "fmi2Functions.h"

static void *give(size_t count, size_t size)
{
    blocks++;
    return calloc(count, size);
}

static void take(void *block)
{
    if (block != NULL)
        blocks--;
    free(block);
}

static void logger(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                   fmi2String message, ...)
{
    char text[3000];
    va_list arguments;
    (void)environment, (void)name, (void)status, (void)category;
    va_start(arguments, message);
    vsnprintf(text, sizeof text, message, arguments);
    va_end(arguments);
    lines++;
}

static const fmi2CallbackFunctions callbacks = {logger, give, take, NULL, NULL};

static void *instantiate(int logging)
{
    return fmi2Instantiate("it", fmi2CoSimulation, guid, resources, &callbacks, fmi2False, logging);
}

#define free_instance fmi2FreeInstance
#define exit_initialization fmi2ExitInitializationMode
#define terminate fmi2Terminate
#define reset fmi2Reset
#define get_state fmi2GetFMUstate
#define set_state fmi2SetFMUstate
#define free_state fmi2FreeFMUstate
#define state_size fmi2SerializedFMUstateSize
#define serialize fmi2SerializeFMUstate
#define deserialize fmi2DeSerializeFMUstate

static int do_step(void *c, double time, double step)
{
    return fmi2DoStep(c, time, step, fmi2True);
}

/* Announce the experiment, usual or not. */
static int set_up(void *c, int usual)
{
    if (usual)
        return fmi2SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0);
    return fmi2SetupExperiment(c, draw(2), draw(3) / 10.0, 0.0, draw(2), draw(3) - 1.0);
}

static int enter_initialization(void *c, int instantiated)
{
    if (instantiated)
        counted(set_up(c, 1));
    return fmi2EnterInitializationMode(c);
}

static int touch(void *c, int set, unsigned any)
{
    fmi2ValueReference references[MOST];
    unsigned count = draw(MOST + 1);
    fmi2Real reals[MOST];
    fmi2Integer integers[MOST];
    fmi2String texts[MOST];
    for (unsigned k = 0; k < count; k++) {
        references[k] = draw(any ? 100 : 60);
        reals[k] = draw(40) ? draw(1000) / 100.0 - 5.0 : 1e308;
        integers[k] = (int)draw(9);
        texts[k] = draw(5) ? "text" : NULL;
    }
    switch (draw(4)) {
    case 0: return set ? fmi2SetReal(c, references, count, reals) : fmi2GetReal(c, references, count, reals);
    case 1: return set ? fmi2SetInteger(c, references, count, integers) : fmi2GetInteger(c, references, count, integers);
    case 2: return set ? fmi2SetBoolean(c, references, count, integers) : fmi2GetBoolean(c, references, count, integers);
    default: return set ? fmi2SetString(c, references, count, texts) : fmi2GetString(c, references, count, texts);
    }
}

/* Have a component ask for the end of the simulation soon. */
static void end_soon(void *c)
{
    const fmi2ValueReference end_at = 32 + 6 * draw(4);
    const fmi2Real time = draw(20) / 1000.0;
    counted(fmi2SetReal(c, &end_at, 1, &time));
}

static void ask(void *c)
{
    fmi2Real real;
    fmi2Boolean boolean;
    counted(fmi2GetRealStatus(c, (fmi2StatusKind)draw(4), &real));
    counted(fmi2GetBooleanStatus(c, (fmi2StatusKind)draw(4), &boolean));
    counted(fmi2CancelStep(c));
}

static int log_more(void *c)
{
    return fmi2SetDebugLogging(c, draw(2), 0, NULL);
}
