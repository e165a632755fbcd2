/* Random sequences of FMI calls, legal and illegal, on two instances of a bundle, for the sanitizers:

     fuzz RESOURCES GUID SEQUENCES SEED

   CALLS is a header with the calls of a version of FMI; a status is an int, and a state a pointer, in all of them.

   What a call that is refused in step mode leaves is the state before it, in every byte; a state that is restored goes on
   with the same rows; all memory that the host gave is freed. It prints the numbers of calls by their status. */

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { OK, WARNING, DISCARD, PENDING = 5 };
enum { INSTANCES = 2, STATES = 4, LONGEST = 60, MOST = 6, OUTPUTS = 200 };

typedef struct {
    void *c;
    int life; /* 0 instantiated, 1 initialising, 2 stepping, 3 other */
    long tick;
    void *states[STATES];
} Slot;

static Slot slots[INSTANCES];
static long blocks, counts[6], lines;
static unsigned long long seed;
static const char *resources, *guid;
static char *kept;
static size_t kept_size;

static unsigned draw(unsigned below)
{
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    return (unsigned)(seed >> 33) % below;
}

static void fail(const char *why)
{
    fprintf(stderr, "fuzz: %s, after %ld fatal failures\n", why, counts[4]);
    abort();
}

static int counted(int status)
{
    if (status < OK || status > PENDING)
        fail("a status that FMI does not know");
    counts[status]++;
    return status;
}

#include CALLS

static void begin(Slot *slot)
{
    slot->c = instantiate((int)draw(2));
    if (slot->c == NULL)
        fail("cannot be instantiated");
    slot->life = 0;
    slot->tick = 0;
}

static void end(Slot *slot)
{
    if (slot->c != NULL)
        free_instance(slot->c);
    memset(slot, 0, sizeof *slot); /* states that are left are freed with the instance */
}

/* Return the state as bytes, or NULL. */
static char *bytes_of(Slot *slot, size_t *size)
{
    void *state = NULL;
    char *bytes = NULL;
    if (get_state(slot->c, &state) <= WARNING && state_size(slot->c, state, size) <= WARNING) {
        bytes = malloc(*size);
        if (serialize(slot->c, state, bytes, *size) > WARNING)
            fail("a state is not serialised");
    }
    free_state(slot->c, &state);
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
    char *first = bytes_of(slot, &before), *second;
    double time = time_of(slot) + (draw(2) ? 0.25 : 0.0);
    if (counted(do_step(slot->c, time, steps[draw(6)])) <= WARNING)
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
        int status = counted(do_step(slot->c, time_of(slot), ticks / 1000.0));
        if (status <= WARNING)
            slot->tick += ticks;
        else
            slot->life = 3;
    }
}

/* Rows after each of some steps from a state, twice. */
static void goes_on(Slot *slot)
{
    void *state = NULL;
    char *first, *second;
    size_t one = 0, two = 0;
    long tick = slot->tick;
    if (counted(get_state(slot->c, &state)) > WARNING)
        return;
    steps(slot, 1);
    first = bytes_of(slot, &one);
    if (slot->life == 2) {
        unsigned ticks = (unsigned)(slot->tick - tick);
        counted(set_state(slot->c, state));
        slot->tick = tick;
        if (do_step(slot->c, time_of(slot), ticks / 1000.0) <= WARNING)
            slot->tick += ticks;
        second = bytes_of(slot, &two);
        if (first != NULL && second != NULL && (one != two || memcmp(first, second, one) != 0))
            fail("a restored state goes on otherwise");
        free(second);
    }
    free(first);
    counted(free_state(slot->c, &state));
}

static void states(Slot *slot)
{
    void **state = &slot->states[draw(STATES)];
    Slot *other = &slots[draw(INSTANCES)];
    size_t size = 0;
    switch (draw(6)) {
    case 0: counted(get_state(slot->c, state)); break;
    case 1: counted(free_state(slot->c, state)); break;
    case 2: /* of any instance; where it was taken is not followed */
        if (counted(set_state(slot->c, other->states[draw(STATES)])) <= WARNING)
            slot->life = 3;
        break;
    case 3:
        free(kept);
        kept = bytes_of(slot, &kept_size);
        if (kept == NULL) kept_size = 0;
        break;
    case 4:
        if (*state == NULL && kept != NULL)
            counted(deserialize(slot->c, kept, kept_size - (draw(3) ? 0 : draw((unsigned)kept_size + 1)), state));
        break;
    default:
        if (*state == NULL && kept != NULL) {
            unsigned at = draw((unsigned)kept_size);
            kept[at] ^= 1;
            if (deserialize(slot->c, kept, kept_size, state) <= WARNING)
                fail("damaged bytes are accepted");
            kept[at] ^= 1;
            state_size(slot->c, *state, &size);
        }
    }
}

static void act(Slot *slot)
{
    unsigned what = draw(24);
    int status;
    if (slot->c == NULL) begin(slot);
    switch (what) {
    case 0: counted(set_up(slot->c, 0)); break;
    case 1: case 2: case 3:
        if (slot->life == 0 && draw(4) == 0) end_soon(slot->c);
        status = counted(enter_initialization(slot->c, slot->life == 0));
        if (status <= WARNING) slot->life = 1;
        else if (slot->life != 2) slot->life = 3;
        break;
    case 4: case 5: case 6:
        status = counted(exit_initialization(slot->c));
        if (status <= WARNING) slot->life = 2;
        else if (slot->life == 1) slot->life = 3;
        break;
    case 7: case 8: case 9: if (slot->life == 2) steps(slot, 2); break;
    case 10: wrong_step(slot); break;
    case 11: case 12: counted(touch(slot->c, 1, draw(3) == 0)); break;
    case 13: case 14: counted(touch(slot->c, 0, draw(3) == 0)); break;
    case 15: if (slot->life == 2) goes_on(slot); break;
    case 16: case 17: case 18: states(slot); break;
    case 19: if (draw(4) == 0) { counted(terminate(slot->c)); slot->life = 3; } break;
    case 20: if (draw(3) == 0 && counted(reset(slot->c)) <= WARNING) { slot->life = 0; slot->tick = 0; } break;
    case 21: if (draw(6) == 0) end(slot); break;
    case 22: counted(log_more(slot->c)); break;
    default: ask(slot->c);
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
