/* Sines and cosines of many angles: the same bits on every processor, which those of its C library need not be. */
#ifndef FLEXSAT_SINES_H
#define FLEXSAT_SINES_H

/* Write sine (n), cosine (n) of angle (n) [rad], to 2e-16. No array may be another. */
typedef void Sines(int n, const double *angle, double *sine, double *cosine);

/* For any processor. */
void sines_one_by_one(int n, const double *angle, double *sine, double *cosine);

/* The quickest on this processor. */
Sines *quickest_sines(void);

#endif
