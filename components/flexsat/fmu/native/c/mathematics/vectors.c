#include "vectors.h"

double dot3(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

void cross3(const double *a, const double *b, double *product)
{
    product[0] = a[1] * b[2] - a[2] * b[1];
    product[1] = a[2] * b[0] - a[0] * b[2];
    product[2] = a[0] * b[1] - a[1] * b[0];
}

void times3(const double *matrix, const double *vector, double *product)
{
    int k;

    for (k = 0; k < 3; k++)
        product[k] = dot3(matrix + 3 * k, vector);
}
