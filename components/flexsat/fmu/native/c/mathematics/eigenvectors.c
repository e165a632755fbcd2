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

/* A divisor that is not below `least`: equal eigenvalues get vectors that are as far apart as rounding lets. */
static Number not_below(Number divisor, double least)
{
    if (fabs(divisor.re) + fabs(divisor.im) < least)
        divisor.re = least, divisor.im = 0.0;
    return divisor;
}

/* a -= b c */
static void subtract_product(Number *a, Number b, Number c)
{
    const Number product = times(b, c);

    a->re -= product.re;
    a->im -= product.im;
}

/* Solve matrix x = right of two rows, by elimination with a row pivot. */
static void solve_two(Number matrix[2][2], Number right[2], double least)
{
    const int pivot = fabs(matrix[1][0].re) + fabs(matrix[1][0].im) > fabs(matrix[0][0].re) + fabs(matrix[0][0].im);
    const Number *first = matrix[pivot];
    Number *second = matrix[!pivot], above = right[pivot], below = right[!pivot];
    const Number factor = over(second[0], not_below(first[0], least));

    subtract_product(&second[1], factor, first[1]);
    subtract_product(&below, factor, above);
    right[1] = over(below, not_below(second[1], least));
    subtract_product(&above, first[1], right[1]);
    right[0] = over(above, not_below(first[0], least));
}

/* Solve (T - value) x = 0 for the elements of x before `given`, whose others are given, up to `count`. */
static void substitute_back(int n, const double *t, Number value, int given, int count, double least, double *re,
                            double *im)
{
    int i, j, k;

    for (i = given - 1; i >= 0; i--) {
        const int two = i > 0 && t[(size_t)i * (size_t)n + (size_t)i - 1] != 0.0;
        Number right[2] = {{0.0, 0.0}, {0.0, 0.0}};
        for (k = 0; k <= two; k++) {
            const double *row = t + (size_t)(i - two + k) * (size_t)n;
            for (j = i + 1; j < count; j++) {
                right[k].re -= row[j] * re[j];
                right[k].im -= row[j] * im[j];
            }
        }
        if (two) {
            const double *row = t + (size_t)i * (size_t)n + (size_t)i, *above = row - n;
            Number matrix[2][2] = {{{0.0, 0.0}, {0.0, 0.0}}, {{0.0, 0.0}, {0.0, 0.0}}};
            matrix[0][0].re = above[-1] - value.re, matrix[0][0].im = -value.im, matrix[0][1].re = above[0];
            matrix[1][1].re = row[0] - value.re, matrix[1][1].im = -value.im, matrix[1][0].re = row[-1];
            solve_two(matrix, right, least);
        } else {
            Number divisor = {0.0, 0.0};
            divisor.re = t[(size_t)i * (size_t)n + (size_t)i] - value.re, divisor.im = -value.im;
            right[0] = over(right[0], not_below(divisor, least));
        }
        for (k = two; k >= 0; k--) {
            re[i - two + k] = right[k].re;
            im[i - two + k] = right[k].im;
        }
        i -= two;
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
    double *turned = work, *re = work + width * width, *im = re + n, size = 0.0, least;
    size_t e;
    int k;

    if (real_schur(n, a, turned, re))
        return 1;
    for (e = 0; e < width * width; e++)
        if (fabs(a[e]) > size)
            size = fabs(a[e]);
    least = DBL_EPSILON * size + DBL_MIN; /* which is not 0 */
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
            substitute_back(n, a, value, k, k + 2, least, re, im);
            turn_back(n, k + 2, turned, re, vector);
            turn_back(n, k + 2, turned, im, vector + n);
            normalise(2 * n, vector); /* both parts together */
            k++;
        } else {
            re[k] = 1.0;
            real[k] = value.re, imaginary[k] = 0.0;
            substitute_back(n, a, value, k, k + 1, least, re, im);
            turn_back(n, k + 1, turned, re, vector);
            normalise(n, vector);
        }
    }
    return 0;
}
