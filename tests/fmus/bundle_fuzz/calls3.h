/* The calls of the fuzzer as FMI 3.0 has them; a step that asks for the end counts as discarded, as in FMI 2.0. */
#include "fmi3Functions.h"

enum { LONGEST_ARRAY = 3 };

static void logger(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message)
{
    (void)environment, (void)status, (void)category;
    if (strlen(message) > 0)
        lines++;
}

static void *instantiate(int logging)
{
    return fmi3InstantiateCoSimulation("it", guid, resources, false, logging != 0, false, false, NULL, 0, NULL, logger, NULL);
}

#define free_instance fmi3FreeInstance
#define exit_initialization fmi3ExitInitializationMode
#define terminate fmi3Terminate
#define reset fmi3Reset
#define get_state fmi3GetFMUState
#define set_state fmi3SetFMUState
#define free_state fmi3FreeFMUState
#define state_size fmi3SerializedFMUStateSize
#define serialize(c, state, bytes, size) fmi3SerializeFMUState(c, state, (fmi3Byte *)(bytes), size)
#define deserialize(c, bytes, size, state) fmi3DeserializeFMUState(c, (const fmi3Byte *)(bytes), size, state)

static int do_step(void *c, double time, double step)
{
    bool events, ends = false, early;
    double reached;
    fmi3Status status = fmi3DoStep(c, time, step, true, &events, &ends, &early, &reached);
    if (status <= fmi3Warning && (events || early))
        fail("a step has a flag that it must not have");
    return status <= fmi3Warning && ends ? fmi3Discard : status;
}

static int set_up(void *c, int usual) /* there is no such call */
{
    return c == NULL && usual ? fmi3Error : fmi3OK;
}

static int enter_initialization(void *c, int instantiated)
{
    if (instantiated && draw(4) == 0) /* wrong, most of the time */
        return fmi3EnterInitializationMode(c, draw(2), draw(3) / 10.0, 0.0, draw(2), draw(3) - 1.0);
    return fmi3EnterInitializationMode(c, false, 0.0, 0.0, false, 0.0);
}

static int touch(void *c, int set, unsigned any)
{
    fmi3ValueReference references[MOST];
    unsigned count = draw(MOST + 1), size = 0;
    fmi3Float64 reals[MOST * LONGEST_ARRAY];
    fmi3Int32 integers[MOST * LONGEST_ARRAY];
    fmi3Int64 wide[MOST * LONGEST_ARRAY];
    fmi3Boolean booleans[MOST * LONGEST_ARRAY];
    fmi3String texts[MOST * LONGEST_ARRAY];
    unsigned kind = draw(6);
    for (unsigned k = 0; k < count; k++) {
        references[k] = draw(any ? 100 : 50);
        if (kind == 0 && !any) /* inputs or parameters; arrays of outputs */
            references[k] = set ? (draw(3) ? 22 + 6 * draw(4) + draw(5) : 1 + draw(2)) : 7 + 4 * draw(4);
        size += kind == 0 && !set && !any ? LONGEST_ARRAY : 1;
    }
    for (unsigned k = 0; k < MOST * LONGEST_ARRAY; k++) {
        reals[k] = draw(40) ? draw(1000) / 100.0 - 5.0 : 1e308;
        integers[k] = (int)draw(9);
        wide[k] = draw(9);
        booleans[k] = draw(2);
        texts[k] = draw(5) ? "text" : NULL;
    }
    if (draw(8) == 0)
        size = draw(MOST * LONGEST_ARRAY);
    switch (kind) {
    case 0: return set ? fmi3SetFloat64(c, references, count, reals, size) : fmi3GetFloat64(c, references, count, reals, size);
    case 1: return set ? fmi3SetInt32(c, references, count, integers, size) : fmi3GetInt32(c, references, count, integers, size);
    case 2: return set ? fmi3SetInt64(c, references, count, wide, size) : fmi3GetInt64(c, references, count, wide, size);
    case 3: return set ? fmi3SetBoolean(c, references, count, booleans, size)
                       : fmi3GetBoolean(c, references, count, booleans, size);
    case 4: return set ? fmi3SetString(c, references, count, texts, size) : fmi3GetString(c, references, count, texts, size);
    default: return set ? fmi3SetClock(c, references, count, booleans) : fmi3GetClock(c, references, count, booleans);
    }
}

/* Have a component ask for the end of the simulation soon. */
static void end_soon(void *c)
{
    const fmi3ValueReference end_at = 25 + 6 * draw(4);
    const fmi3Float64 time = draw(20) / 1000.0;
    counted(fmi3SetFloat64(c, &end_at, 1, &time, 1));
}

static void ask(void *c)
{
    size_t number;
    counted(fmi3EnterEventMode(c));
    counted(fmi3EnterConfigurationMode(c));
    counted(fmi3GetNumberOfContinuousStates(c, &number));
}

static int log_more(void *c)
{
    return fmi3SetDebugLogging(c, draw(2), 0, NULL);
}
