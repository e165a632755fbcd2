/* Vectors of three. Results must not overlap arguments. */
#ifndef FLEXSAT_VECTORS_H
#define FLEXSAT_VECTORS_H

double dot3(const double *a, const double *b);
void cross3(const double *a, const double *b, double *product); /* a x b */
void times3(const double *matrix, const double *vector, double *product); /* of a matrix, row after row */

#endif
