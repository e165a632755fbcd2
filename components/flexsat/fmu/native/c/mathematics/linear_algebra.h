/* Matrices are arrays of doubles, row after row. Results must not overlap arguments unless said. */
#ifndef FLEXSAT_LINEAR_ALGEBRA_H
#define FLEXSAT_LINEAR_ALGEBRA_H

/* y (m) = a (m, n) x */
void times_vector(int m, int n, const double *a, const double *x, double *y);

/* y (m) += a (m, n) x */
void add_times_vector(int m, int n, const double *a, const double *x, double *y);

/* c (m, n) = a (m, k) b (k, n) */
void times_matrix(int m, int k, int n, const double *a, const double *b, double *c);

/* c (m, n) += a (m, k) b (k, n) */
void add_times_matrix(int m, int k, int n, const double *a, const double *b, double *c);

/* b (n, m) = transpose of a (m, n) */
void transpose(int m, int n, const double *a, double *b);

/* a (n, n) = identity */
void identity(int n, double *a);

/* Solve a (n, n) x = b (n, m) by elimination with row pivoting: b becomes x, a is lost. Returns 0, or 1 if singular. */
int solve(int n, int m, double *a, double *b);

/* inverse (n, n) of a (n, n), which is lost; returns 0, or 1 if singular. */
int invert(int n, double *a, double *inverse);

/* Cholesky factor in the lower triangle of a (n, n), in place; returns 0, or 1 if a is not positive definite. */
int cholesky(int n, double *a);

#endif
