/* Random sequences of FMI calls, legal and illegal, on two instances of a bundle, for the sanitizers:

     fuzz RESOURCES GUID SEQUENCES SEED

   What a call that is refused in step mode leaves is the state before it, in every byte; a state that is restored goes on
   with the same rows; all memory that the host gave is freed. It prints the numbers of calls by their status. */

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

enum { INSTANCES = 2, STATES = 4, LONGEST = 60, MOST = 6, OUTPUTS = 200 };

typedef struct {
    fmi2Component c;
    int life; /* 0 instantiated, 1 initialising, 2 stepping, 3 other */
    long tick;
    fmi2FMUstate states[STATES];
} Slot;

static Slot slots[INSTANCES];
static long blocks, counts[6], lines;
static unsigned long long seed;
static const char *resources, *guid;
static fmi2Byte *kept;
static size_t kept_size;

static unsigned draw(unsigned below)
{
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    return (unsigned)(seed >> 33) % below;
}

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

static void fail(const char *why)
{
    fprintf(stderr, "fuzz: %s, after %ld fatal failures\n", why, counts[4]);
    abort();
}

static fmi2Status counted(fmi2Status status)
{
    if (status < fmi2OK || status > fmi2Pending)
        fail("a status that FMI does not know");
    counts[status]++;
    return status;
}

static void begin(Slot *slot)
{
    slot->c = fmi2Instantiate("it", fmi2CoSimulation, guid, resources, &callbacks, fmi2False, draw(2));
    if (slot->c == NULL)
        fail("cannot be instantiated");
    slot->life = 0;
    slot->tick = 0;
}

static void end(Slot *slot)
{
    if (slot->c != NULL)
        fmi2FreeInstance(slot->c);
    memset(slot, 0, sizeof *slot); /* states that are left are freed with the instance */
}

/* Return the state as bytes, or NULL. */
static fmi2Byte *bytes_of(Slot *slot, size_t *size)
{
    fmi2FMUstate state = NULL;
    fmi2Byte *bytes = NULL;
    if (fmi2GetFMUstate(slot->c, &state) <= fmi2Warning && fmi2SerializedFMUstateSize(slot->c, state, size) <= fmi2Warning) {
        bytes = malloc(*size);
        if (fmi2SerializeFMUstate(slot->c, state, bytes, *size) > fmi2Warning)
            fail("a state is not serialised");
    }
    fmi2FreeFMUstate(slot->c, &state);
    return bytes;
}

static double time_of(const Slot *slot)
{
    return (double)slot->tick / 1000.0;
}

static void wrong_step(Slot *slot)
{
    static const double steps[] = {0.0, -0.001, 0.0015, 1e300, 0.0 / 0.0, 1e-12};
    size_t before = 0, after = 0;
    fmi2Byte *first = bytes_of(slot, &before), *second;
    double time = time_of(slot) + (draw(2) ? 0.25 : 0.0);
    if (counted(fmi2DoStep(slot->c, time, steps[draw(6)], fmi2True)) <= fmi2Warning)
        fail("a wrong step is accepted");
    second = bytes_of(slot, &after);
    if (first != NULL && second != NULL && (before != after || memcmp(first, second, before) != 0))
        fail("a refused step changed the state");
    free(first), free(second);
}

static void steps(Slot *slot, int count)
{
    for (int k = 0; k < count; k++) {
        unsigned ticks = 1 + draw(3);
        fmi2Status status = counted(fmi2DoStep(slot->c, time_of(slot), ticks / 1000.0, fmi2True));
        if (status <= fmi2Warning)
            slot->tick += ticks;
        else
            slot->life = 3;
    }
}

static void values(Slot *slot, int set)
{
    fmi2ValueReference references[MOST];
    unsigned count = draw(MOST + 1), any = draw(3) == 0;
    fmi2Real reals[MOST];
    fmi2Integer integers[MOST];
    fmi2String texts[MOST];
    fmi2Status status;
    for (unsigned k = 0; k < count; k++) {
        references[k] = draw(any ? 100 : 60);
        reals[k] = draw(40) ? draw(1000) / 100.0 - 5.0 : 1e308;
        integers[k] = (int)draw(9);
        texts[k] = draw(5) ? "text" : NULL;
    }
    switch (draw(4)) {
    case 0: status = set ? fmi2SetReal(slot->c, references, count, reals) : fmi2GetReal(slot->c, references, count, reals); break;
    case 1: status = set ? fmi2SetInteger(slot->c, references, count, integers)
                         : fmi2GetInteger(slot->c, references, count, integers); break;
    case 2: status = set ? fmi2SetBoolean(slot->c, references, count, integers)
                         : fmi2GetBoolean(slot->c, references, count, integers); break;
    default: status = set ? fmi2SetString(slot->c, references, count, texts) : fmi2GetString(slot->c, references, count, texts);
    }
    counted(status);
}

/* Rows after each of some steps from a state, twice. */
static void goes_on(Slot *slot)
{
    fmi2FMUstate state = NULL;
    fmi2Byte *first, *second;
    size_t one = 0, two = 0;
    long tick = slot->tick;
    if (counted(fmi2GetFMUstate(slot->c, &state)) > fmi2Warning)
        return;
    steps(slot, 1);
    first = bytes_of(slot, &one);
    if (slot->life == 2) {
        unsigned ticks = (unsigned)(slot->tick - tick);
        counted(fmi2SetFMUstate(slot->c, state));
        slot->tick = tick;
        if (fmi2DoStep(slot->c, time_of(slot), ticks / 1000.0, fmi2True) <= fmi2Warning)
            slot->tick += ticks;
        second = bytes_of(slot, &two);
        if (first != NULL && second != NULL && (one != two || memcmp(first, second, one) != 0))
            fail("a restored state goes on otherwise");
        free(second);
    }
    free(first);
    counted(fmi2FreeFMUstate(slot->c, &state));
}

static void states(Slot *slot)
{
    fmi2FMUstate *state = &slot->states[draw(STATES)];
    Slot *other = &slots[draw(INSTANCES)];
    size_t size = 0;
    switch (draw(6)) {
    case 0: counted(fmi2GetFMUstate(slot->c, state)); break;
    case 1: counted(fmi2FreeFMUstate(slot->c, state)); break;
    case 2: /* of any instance; where it was taken is not followed */
        if (counted(fmi2SetFMUstate(slot->c, other->states[draw(STATES)])) <= fmi2Warning)
            slot->life = 3;
        break;
    case 3:
        free(kept);
        kept = bytes_of(slot, &kept_size);
        if (kept == NULL) kept_size = 0;
        break;
    case 4:
        if (*state == NULL && kept != NULL)
            counted(fmi2DeSerializeFMUstate(slot->c, kept, kept_size - (draw(3) ? 0 : draw((unsigned)kept_size + 1)), state));
        break;
    default:
        if (*state == NULL && kept != NULL) {
            unsigned at = draw((unsigned)kept_size);
            kept[at] ^= 1;
            if (fmi2DeSerializeFMUstate(slot->c, kept, kept_size, state) <= fmi2Warning)
                fail("damaged bytes are accepted");
            kept[at] ^= 1;
            fmi2SerializedFMUstateSize(slot->c, *state, &size);
        }
    }
}

static void act(Slot *slot)
{
    fmi2Real real;
    fmi2Boolean boolean;
    unsigned what = draw(24);
    fmi2Status status;
    if (slot->c == NULL) begin(slot);
    switch (what) {
    case 0: counted(fmi2SetupExperiment(slot->c, draw(2), draw(3) / 10.0, 0.0, draw(2), draw(3) - 1.0)); break;
    case 1: case 2: case 3:
        if (slot->life == 0) counted(fmi2SetupExperiment(slot->c, fmi2False, 0.0, 0.0, fmi2False, 0.0));
        status = counted(fmi2EnterInitializationMode(slot->c));
        if (status <= fmi2Warning) slot->life = 1;
        else if (slot->life != 2) slot->life = 3;
        break;
    case 4: case 5: case 6:
        status = counted(fmi2ExitInitializationMode(slot->c));
        if (status <= fmi2Warning) slot->life = 2;
        else if (slot->life == 1) slot->life = 3;
        break;
    case 7: case 8: case 9: if (slot->life == 2) steps(slot, 2); break;
    case 10: wrong_step(slot); break;
    case 11: case 12: values(slot, 1); break;
    case 13: case 14: values(slot, 0); break;
    case 15: if (slot->life == 2) goes_on(slot); break;
    case 16: case 17: case 18: states(slot); break;
    case 19: if (draw(4) == 0) { counted(fmi2Terminate(slot->c)); slot->life = 3; } break;
    case 20: if (draw(3) == 0 && counted(fmi2Reset(slot->c)) <= fmi2Warning) { slot->life = 0; slot->tick = 0; } break;
    case 21: if (draw(6) == 0) end(slot); break;
    case 22: counted(fmi2SetDebugLogging(slot->c, draw(2), 0, NULL)); break;
    default:
        counted(fmi2GetRealStatus(slot->c, (fmi2StatusKind)draw(4), &real));
        counted(fmi2GetBooleanStatus(slot->c, (fmi2StatusKind)draw(4), &boolean));
        counted(fmi2CancelStep(slot->c));
    }
}

int main(int argument_count, char **arguments)
{
    if (argument_count != 5) return 2;
    resources = arguments[1];
    guid = arguments[2];
    seed = strtoull(arguments[4], NULL, 10);
    for (long k = atol(arguments[3]); k > 0; k--) {
        for (unsigned n = 10 + draw(LONGEST); n > 0; n--) act(&slots[draw(4) == 0]);
        for (int n = 0; n < INSTANCES; n++) end(&slots[n]);
        if (blocks != 0) fail("memory of the host is not freed");
        free(kept);
        kept = NULL;
        kept_size = 0;
    }
    printf("calls: %ld OK, %ld warnings, %ld discarded, %ld refused, %ld fatal; %ld messages\n", counts[0], counts[1], counts[2],
           counts[3], counts[4], lines);
    return 0;
}
