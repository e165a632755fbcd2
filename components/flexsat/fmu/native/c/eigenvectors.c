#include "eigenvectors.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "real_schur.h"

typedef struct Number { /* complex; C99's own is not everywhere */
    double re, im;
} Number;

static Number times(Number a, Number b)
{
    const Number product = {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};

    return product;
}

/* a/b, where b is not 0. */
static Number over(Number a, Number b)
{
    const double size = fabs(b.re) + fabs(b.im);
    const Number scaled = {b.re / size, -b.im / size};
    const double square = (scaled.re * scaled.re + scaled.im * scaled.im) * size;
    const Number product = times(a, scaled), quotient = {product.re / square, product.im / square};

    return quotient;
}

/* A divisor that is not smaller than `least`: equal eigenvalues get vectors that are as far apart as rounding lets. */
static Number not_below(Number divisor, double least)
{
    if (fabs(divisor.re) + fabs(divisor.im) < least)
        divisor.re = least, divisor.im = 0.0;
    return divisor;
}

/* Solve (T - value) x = 0 for the elements of x before `given`, whose others are given. */
static void substitute_back(int n, const double *t, Number value, int given, double size, double *re, double *im)
{
    int i, j;

    for (i = given - 1; i >= 0; i--) {
        const double *row = t + (size_t)i * (size_t)n, *above = row - n;
        Number right = {0.0, 0.0}, divisor = {row[i] - value.re, -value.im};
        const double least = DBL_EPSILON * size;
        int count = n;
        while (count > i + 1 && re[count - 1] == 0.0 && im[count - 1] == 0.0)
            count--;
        for (j = i + 1; j < count; j++) {
            right.re -= row[j] * re[j];
            right.im -= row[j] * im[j];
        }
        if (i == 0 || row[i - 1] == 0.0) {
            right = over(right, not_below(divisor, least));
            re[i] = right.re, im[i] = right.im;
        } else { /* two at once, by Cramer's rule */
            Number upper = {0.0, 0.0}, other = {above[i - 1] - value.re, -value.im}, determinant;
            for (j = i + 1; j < count; j++) {
                upper.re -= above[j] * re[j];
                upper.im -= above[j] * im[j];
            }
            determinant = times(other, divisor);
            determinant.re -= above[i] * row[i - 1];
            determinant = not_below(determinant, least * (fabs(above[i]) + fabs(row[i - 1])));
            divisor = times(upper, divisor);
            divisor.re -= above[i] * right.re;
            divisor.im -= above[i] * right.im;
            other = times(other, right);
            other.re -= row[i - 1] * upper.re;
            other.im -= row[i - 1] * upper.im;
            divisor = over(divisor, determinant);
            other = over(other, determinant);
            re[i - 1] = divisor.re, im[i - 1] = divisor.im;
            re[i] = other.re, im[i] = other.im;
            i--;
        }
    }
}

/* vector (n) = sum of the first `count` rows of Q', each times its element of x. */
static void turn_back(int n, int count, const double *turned, const double *x, double *vector)
{
    int i, j;

    memset(vector, 0, (size_t)n * sizeof(double));
    for (j = 0; j < count; j++)
        for (i = 0; i < n; i++)
            vector[i] += x[j] * turned[(size_t)j * (size_t)n + (size_t)i];
}

static void normalise(int n, double *vector)
{
    double square = 0.0;
    int i;

    for (i = 0; i < n; i++)
        square += vector[i] * vector[i];
    for (i = 0; i < n; i++)
        vector[i] /= sqrt(square);
}

int eigenvectors(int n, double *a, double *real, double *imaginary, double *vectors, double *work)
{
    const size_t width = (size_t)n;
    double *turned = work, *re = work + width * width, *im = re + n, size = 0.0;
    size_t e;
    int k;

    if (real_schur(n, a, turned, re))
        return 1;
    for (e = 0; e < width * width; e++)
        if (fabs(a[e]) > size)
            size = fabs(a[e]);
    for (k = 0; k < n; k++) {
        const double *block = a + (size_t)k * width + (size_t)k;
        double *vector = vectors + (size_t)k * width;
        Number value = {block[0], 0.0};
        memset(re, 0, 2 * width * sizeof(double));
        if (k + 1 < n && block[n] != 0.0) {
            const double half = 0.5 * (block[0] - block[n + 1]);
            value.re = block[n + 1] + half;
            value.im = sqrt(-(half * half + block[1] * block[n]));
            if (fabs(block[1]) >= fabs(block[n])) { /* the row of the block that loses less */
                re[k] = block[1], re[k + 1] = value.re - block[0], im[k + 1] = value.im;
            } else {
                re[k] = value.re - block[n + 1], im[k] = value.im, re[k + 1] = block[n];
            }
            real[k] = real[k + 1] = value.re;
            imaginary[k] = value.im, imaginary[k + 1] = -value.im;
            substitute_back(n, a, value, k, size, re, im);
            turn_back(n, k + 2, turned, re, vector);
            turn_back(n, k + 2, turned, im, vector + n);
            normalise(2 * n, vector); /* both parts together */
            k++;
        } else {
            re[k] = 1.0;
            real[k] = value.re, imaginary[k] = 0.0;
            substitute_back(n, a, value, k, size, re, im);
            turn_back(n, k + 1, turned, re, vector);
            normalise(n, vector);
        }
    }
    return 0;
}
