/* Real Schur form: a = Q T Q', Q orthogonal, T triangular but for blocks of two on its diagonal. */
#ifndef FLEXSAT_REAL_SCHUR_H
#define FLEXSAT_REAL_SCHUR_H

/* Write T over a (n, n), and Q', whose rows are the columns of Q, into `turned` (n, n); `work` holds 2 n doubles. The
blocks of two have conjugate eigenvalues, and what stands below diagonal and blocks is 0. Returns 0, or 1 if the
iteration does not converge. */
int real_schur(int n, double *a, double *turned, double *work);

#endif
