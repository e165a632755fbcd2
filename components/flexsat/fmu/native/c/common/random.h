/* Random numbers, bit for bit those of numpy: SeedSequence([seed, stream]).spawn(..), default_rng, and three methods
of its generator, PCG64 (O'Neill 2014). */
#ifndef FLEXSAT_RANDOM_H
#define FLEXSAT_RANDOM_H

#include <stdint.h>

/* State of a generator, copied as it is to save it. */
typedef struct Random {
    uint64_t high, low; /* of a number of 128 bits */
    uint64_t increment_high, increment_low;
} Random;

/* Begin as default_rng(SeedSequence([seed, stream]).spawn(child + 1)[child]) does. */
void random_begin(Random *random, uint64_t seed, uint32_t stream, uint32_t child);

uint64_t random_bits(Random *random);

/* The generator's random(): in [0, 1). */
double random_unit(Random *random);

/* The generator's uniform(low, high), one number. */
double random_uniform(Random *random, double low, double high);

/* The generator's standard_normal(), one number; n of them in turn are its standard_normal(n). */
double random_normal(Random *random);

#endif
