#include "zero_order_hold.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "linear_algebra.h"

enum { TAYLOR_TERMS = 18 }; /* with the norm scaled below 1/2 the remainder is under 2^-18/18! < 1e-21 */

static double column_norm(int n, const double *a)
{
    double largest = 0.0;
    int i, j;

    for (j = 0; j < n; j++) {
        double sum = 0.0;
        for (i = 0; i < n; i++)
            sum += fabs(a[(size_t)i * (size_t)n + (size_t)j]);
        if (sum > largest)
            largest = sum;
    }
    return largest;
}

void transition_with(int n, const double *a, double period, double *exponential, double *integral, double *work)
{
    const size_t count = (size_t)n * (size_t)n;
    double *scaled = work, *term = scaled + count, *next = term + count;
    double norm = period * column_norm(n, a), step;
    int squarings = 0, k;
    size_t e;

    if (norm > 0.0 && norm <= DBL_MAX) { /* beyond, nothing is finite anyway */
        const int needed = (int)ceil(log2(norm)) + 1;
        squarings = needed > 0 ? needed : 0;
    }
    step = ldexp(period, -squarings);
    for (e = 0; e < count; e++)
        scaled[e] = step * a[e];
    identity(n, term);
    identity(n, exponential);
    identity(n, integral);
    for (k = 1; k <= TAYLOR_TERMS; k++) {
        times_matrix(n, n, n, term, scaled, next);
        for (e = 0; e < count; e++) {
            term[e] = next[e] / k;
            exponential[e] += term[e];
            integral[e] += term[e] / (k + 1);
        }
    }
    for (e = 0; e < count; e++)
        integral[e] *= step;
    for (k = 0; k < squarings; k++) {
        memcpy(term, integral, count * sizeof(double));
        add_times_matrix(n, n, n, exponential, term, integral);
        memcpy(term, exponential, count * sizeof(double));
        times_matrix(n, n, n, term, term, exponential);
    }
}

int transition(Memory *memory, int n, const double *a, double period, double *exponential, double *integral)
{
    MemoryBlock *mark = memory->last;
    double *work = memory_doubles(memory, 3 * (size_t)n * (size_t)n);

    if (memory->failed)
        return 1;
    transition_with(n, a, period, exponential, integral, work);
    memory_rewind(memory, mark);
    return 0;
}

int zero_order_hold(Memory *memory, int n, int m, const double *a, const double *b, double period, double *ad,
                    double *bd)
{
    MemoryBlock *mark = memory->last;
    double *integral = memory_doubles(memory, (size_t)n * (size_t)n);

    if (memory->failed || transition(memory, n, a, period, ad, integral))
        return 1;
    times_matrix(n, n, m, integral, b, bd);
    memory_rewind(memory, mark);
    return 0;
}
