/* Eigenvalues and eigenvectors of a real matrix. */
#ifndef FLEXSAT_EIGENVECTORS_H
#define FLEXSAT_EIGENVECTORS_H

/* Find the n eigenvalues, real and imaginary parts, and the eigenvectors of a (n, n), row after row, which is lost.

Two conjugate eigenvalues stand side by side, that with the positive imaginary part first; then the real part of its
vector is row k of `vectors` (n, n), the imaginary part row k + 1. A real eigenvalue has one row. Norms are 1. `work`
holds n (n + 2) doubles. Returns 0, or 1 if the iteration does not converge. */
int eigenvectors(int n, double *a, double *real, double *imaginary, double *vectors, double *work);

#endif
