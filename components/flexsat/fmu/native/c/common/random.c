#include "random.h"

#include <math.h>

#include "ziggurat.h"

enum { POOL = 4 }; /* words of 32 bits; a seed takes one or two of them, the stream the next */

/* SeedSequence: constants of O'Neill's seed_seq_fe */
#define POOL_START UINT32_C(0x43b0d7e5)
#define POOL_FACTOR UINT32_C(0x931e8875)
#define STATE_START UINT32_C(0x8b51f9dd)
#define STATE_FACTOR UINT32_C(0x58f38ded)
#define MIX_LEFT UINT32_C(0xca01f9dd)
#define MIX_RIGHT UINT32_C(0x4973f715)

/* PCG64: the multiplier of 128 bits */
#define FACTOR_HIGH UINT64_C(0x2360ed051fc65da4)
#define FACTOR_LOW UINT64_C(0x4385df649fccf645)

static uint32_t hashed(uint32_t word, uint32_t *constant, uint32_t factor)
{
    word ^= *constant;
    *constant *= factor;
    word *= *constant;
    return word ^ (word >> 16);
}

static uint32_t mixed(uint32_t left, uint32_t right)
{
    const uint32_t word = MIX_LEFT * left - MIX_RIGHT * right;

    return word ^ (word >> 16);
}

/* Mix the words of the seed, and of the key of the child, which follows the first POOL words, into the pool. */
static void fill_pool(const uint32_t words[POOL + 1], uint32_t pool[POOL])
{
    uint32_t constant = POOL_START;
    int from, to;

    for (to = 0; to < POOL; to++)
        pool[to] = hashed(words[to], &constant, POOL_FACTOR);
    for (from = 0; from < POOL; from++)
        for (to = 0; to < POOL; to++)
            if (from != to)
                pool[to] = mixed(pool[to], hashed(pool[from], &constant, POOL_FACTOR));
    for (to = 0; to < POOL; to++)
        pool[to] = mixed(pool[to], hashed(words[POOL], &constant, POOL_FACTOR));
}

/* state = state * factor + increment, modulo 2^128 */
#ifdef __SIZEOF_INT128__
__extension__ typedef unsigned __int128 Wide;

static void advance(Random *random)
{
    const Wide factor = (Wide)FACTOR_HIGH << 64 | FACTOR_LOW;
    const Wide increment = (Wide)random->increment_high << 64 | random->increment_low;
    const Wide state = ((Wide)random->high << 64 | random->low) * factor + increment;

    random->high = (uint64_t)(state >> 64);
    random->low = (uint64_t)(state & UINT64_MAX);
}
#else /* from products of 32 bits */
static void advance(Random *random)
{
    const uint64_t mask = UINT64_C(0xffffffff);
    const uint64_t low = random->low & mask, high = random->low >> 32;
    const uint64_t factor_low = FACTOR_LOW & mask, factor_high = FACTOR_LOW >> 32;
    const uint64_t lowest = low * factor_low, across = high * factor_low + (lowest >> 32);
    const uint64_t middle = low * factor_high + (across & mask);
    const uint64_t product_low = (middle << 32) | (lowest & mask);
    const uint64_t product_high = high * factor_high + (across >> 32) + (middle >> 32) + random->high * FACTOR_LOW +
                                  random->low * FACTOR_HIGH;

    random->low = product_low + random->increment_low;
    random->high = product_high + random->increment_high + (random->low < product_low);
}
#endif

void random_begin(Random *random, uint64_t seed, uint32_t stream, uint32_t child)
{
    uint32_t words[POOL + 1] = {0}, pool[POOL], constant = STATE_START;
    uint64_t state[4];
    int count = 0, k;

    words[count++] = (uint32_t)(seed & UINT64_C(0xffffffff));
    if (seed >> 32)
        words[count++] = (uint32_t)(seed >> 32);
    words[count] = stream;
    words[POOL] = child;
    fill_pool(words, pool);
    for (k = 0; k < 4; k++) {
        const uint64_t low = hashed(pool[2 * k % POOL], &constant, STATE_FACTOR);
        const uint64_t high = hashed(pool[(2 * k + 1) % POOL], &constant, STATE_FACTOR);
        state[k] = (high << 32) | low;
    }
    random->increment_high = (state[2] << 1) | (state[3] >> 63);
    random->increment_low = (state[3] << 1) | 1;
    random->high = random->low = 0;
    advance(random);
    random->low += state[1];
    random->high += state[0] + (random->low < state[1]);
    advance(random);
}

/* XSL-RR: both halves folded into one, and rotated by the highest six bits */
uint64_t random_bits(Random *random)
{
    uint64_t folded;
    unsigned int turn;

    advance(random);
    folded = random->high ^ random->low;
    turn = (unsigned int)(random->high >> 58);
    return (folded >> turn) | (folded << ((64 - turn) & 63));
}

double random_unit(Random *random)
{
    return (double)(random_bits(random) >> 11) * 0x1p-53;
}

double random_uniform(Random *random, double low, double high)
{
    return low + (high - low) * random_unit(random);
}

/* Beyond the lowest layer's edge: Marsaglia (1964) */
static double tail(Random *random, int negative)
{
    for (;;) {
        const double beyond = -log1p(-random_unit(random)) * 0.27366123732975828; /* 1 / TAIL_BEGINS */
        const double drawn = -log1p(-random_unit(random));
        if (drawn + drawn > beyond * beyond)
            return negative ? -(TAIL_BEGINS + beyond) : TAIL_BEGINS + beyond;
    }
}

double random_normal(Random *random)
{
    for (;;) {
        uint64_t bits = random_bits(random), share;
        const int layer = (int)(bits & 0xff);
        const Layer *here = &layers[layer];
        double x;

        share = (bits >> 9) & UINT64_C(0x000fffffffffffff);
        x = (double)share * here->width;
        if (bits & 0x100)
            x = -x;
        if (share < here->inside)
            return x;
        if (layer == 0)
            return tail(random, (int)((share >> 8) & 1));
        if ((here[-1].density - here->density) * random_unit(random) + here->density < exp(-0.5 * x * x))
            return x;
    }
}
