/* A panel's sums run sixteen at once, so that a processor need not wait for each: eight of the columns 0, 2, 4 and so on
of each run, and eight of the others, which are added at the end. That order, and rounding after each product, are the
same in the three ways of writing it. */
#include "panel_products.h"

#include <string.h>

#include "wide_registers.h"

#if !defined(FLEXSAT_FLOATS) && (defined(__SSE2__) || defined(_M_X64)) /* every x86-64 */
#include <emmintrin.h>
#define TWO_AT_ONCE
#if defined(FOUR_IN_REGISTERS)
#include <immintrin.h>
#define FOUR_AT_ONCE
#endif
#endif

/* sums (2, 8) += the columns of a run, those of odd number to the second eight */
#ifdef TWO_AT_ONCE
static void add_columns(int count, const double *value, const double *x, double sums[2 * PANEL])
{
    __m128d s0 = _mm_loadu_pd(sums), s1 = _mm_loadu_pd(sums + 2), s2 = _mm_loadu_pd(sums + 4);
    __m128d s3 = _mm_loadu_pd(sums + 6), t0 = _mm_loadu_pd(sums + 8), t1 = _mm_loadu_pd(sums + 10);
    __m128d t2 = _mm_loadu_pd(sums + 12), t3 = _mm_loadu_pd(sums + 14), factor;
    int j;

    for (j = 0; j + 1 < count; j += 2, value += 2 * PANEL) {
        const __m128d other = _mm_set1_pd(x[j + 1]);
        factor = _mm_set1_pd(x[j]);
        s0 = _mm_add_pd(s0, _mm_mul_pd(_mm_loadu_pd(value), factor));
        s1 = _mm_add_pd(s1, _mm_mul_pd(_mm_loadu_pd(value + 2), factor));
        s2 = _mm_add_pd(s2, _mm_mul_pd(_mm_loadu_pd(value + 4), factor));
        s3 = _mm_add_pd(s3, _mm_mul_pd(_mm_loadu_pd(value + 6), factor));
        t0 = _mm_add_pd(t0, _mm_mul_pd(_mm_loadu_pd(value + 8), other));
        t1 = _mm_add_pd(t1, _mm_mul_pd(_mm_loadu_pd(value + 10), other));
        t2 = _mm_add_pd(t2, _mm_mul_pd(_mm_loadu_pd(value + 12), other));
        t3 = _mm_add_pd(t3, _mm_mul_pd(_mm_loadu_pd(value + 14), other));
    }
    if (j < count) {
        factor = _mm_set1_pd(x[j]);
        s0 = _mm_add_pd(s0, _mm_mul_pd(_mm_loadu_pd(value), factor));
        s1 = _mm_add_pd(s1, _mm_mul_pd(_mm_loadu_pd(value + 2), factor));
        s2 = _mm_add_pd(s2, _mm_mul_pd(_mm_loadu_pd(value + 4), factor));
        s3 = _mm_add_pd(s3, _mm_mul_pd(_mm_loadu_pd(value + 6), factor));
    }
    _mm_storeu_pd(sums, s0);
    _mm_storeu_pd(sums + 2, s1);
    _mm_storeu_pd(sums + 4, s2);
    _mm_storeu_pd(sums + 6, s3);
    _mm_storeu_pd(sums + 8, t0);
    _mm_storeu_pd(sums + 10, t1);
    _mm_storeu_pd(sums + 12, t2);
    _mm_storeu_pd(sums + 14, t3);
}
#else
static void add_columns(int count, const Real *value, const Real *x, Real sums[2 * PANEL])
{
    int j, k;

    for (j = 0; j + 1 < count; j += 2, value += 2 * PANEL)
        for (k = 0; k < PANEL; k++) {
            sums[k] += value[k] * x[j];
            sums[PANEL + k] += value[PANEL + k] * x[j + 1];
        }
    for (k = 0; k < PANEL && j < count; k++)
        sums[k] += value[k] * x[j];
}
#endif

void panel_product(const Panels *panels, const Real *x, Real *y)
{
    const Real *value = panels->value;
    int panel, run, k;

    for (panel = 0; panel < panels->count; panel++) {
        const int *row = panels->row + PANEL * panel;
        Real sums[2 * PANEL];
        memset(sums, 0, sizeof sums);
        for (run = panels->first[panel]; run < panels->first[panel + 1]; run++) {
            add_columns(panels->width[run], value, x + panels->from[run], sums);
            value += PANEL * panels->width[run];
        }
        for (k = 0; k < PANEL; k++)
            y[row[k]] += sums[k] + sums[PANEL + k];
    }
}

void panel_products(const Panels *panels, const Real *x, const Real *other_x, Real *y, Real *other_y)
{
    panel_product(panels, x, y);
    panel_product(panels, other_x, other_y);
}

#ifdef FOUR_AT_ONCE
#define VALUES(place) _mm256_loadu_pd(value + (place))
#define ADD_TIMES(sum, values, factor) sum = _mm256_add_pd(sum, _mm256_mul_pd(values, factor))

/* y += sums, by the rows of a panel; inline, since what is passed in wide registers is not cleared after a call */
IN_WIDE_REGISTERS
static inline __attribute__((always_inline)) void add_sums(const int *row, __m256d first, __m256d second, double *y)
{
    double sums[PANEL];
    int k;

    if (row[PANEL - 1] == row[0] + PANEL - 1) { /* they stand one after the other; none of them fills it up */
        _mm256_storeu_pd(y + row[0], _mm256_add_pd(_mm256_loadu_pd(y + row[0]), first));
        _mm256_storeu_pd(y + row[4], _mm256_add_pd(_mm256_loadu_pd(y + row[4]), second));
        return;
    }
    _mm256_storeu_pd(sums, first);
    _mm256_storeu_pd(sums + 4, second);
    for (k = 0; k < PANEL; k++)
        y[row[k]] += sums[k];
}

IN_WIDE_REGISTERS
static void product_of_four(const Panels *panels, const double *x, double *y)
{
    const double *value = panels->value;
    int panel, run, j;

    for (panel = 0; panel < panels->count; panel++) {
        __m256d s0 = _mm256_setzero_pd(), s1 = s0, t0 = s0, t1 = s0, factor;
        for (run = panels->first[panel]; run < panels->first[panel + 1]; run++) {
            const double *factors = x + panels->from[run];
            const int width = panels->width[run];
            for (j = 0; j + 1 < width; j += 2, value += 2 * PANEL) {
                const __m256d other = _mm256_broadcast_sd(factors + j + 1);
                factor = _mm256_broadcast_sd(factors + j);
                ADD_TIMES(s0, VALUES(0), factor);
                ADD_TIMES(s1, VALUES(4), factor);
                ADD_TIMES(t0, VALUES(8), other);
                ADD_TIMES(t1, VALUES(12), other);
            }
            if (j < width) {
                factor = _mm256_broadcast_sd(factors + j);
                ADD_TIMES(s0, VALUES(0), factor);
                ADD_TIMES(s1, VALUES(4), factor);
                value += PANEL;
            }
        }
        add_sums(panels->row + PANEL * panel, _mm256_add_pd(s0, t0), _mm256_add_pd(s1, t1), y);
    }
}

IN_WIDE_REGISTERS
static void products_of_four(const Panels *panels, const double *x, const double *other_x, double *y, double *other_y)
{
    const double *value = panels->value;
    int panel, run, j;

    for (panel = 0; panel < panels->count; panel++) {
        const int *row = panels->row + PANEL * panel;
        __m256d s0 = _mm256_setzero_pd(), s1 = s0, t0 = s0, t1 = s0, u0 = s0, u1 = s0, v0 = s0, v1 = s0, factor;
        for (run = panels->first[panel]; run < panels->first[panel + 1]; run++) {
            const double *factors = x + panels->from[run], *others = other_x + panels->from[run];
            const int width = panels->width[run];
            for (j = 0; j + 1 < width; j += 2, value += 2 * PANEL) {
                const __m256d a = VALUES(0), b = VALUES(4), c = VALUES(8), d = VALUES(12);
                factor = _mm256_broadcast_sd(factors + j);
                ADD_TIMES(s0, a, factor);
                ADD_TIMES(s1, b, factor);
                factor = _mm256_broadcast_sd(others + j);
                ADD_TIMES(u0, a, factor);
                ADD_TIMES(u1, b, factor);
                factor = _mm256_broadcast_sd(factors + j + 1);
                ADD_TIMES(t0, c, factor);
                ADD_TIMES(t1, d, factor);
                factor = _mm256_broadcast_sd(others + j + 1);
                ADD_TIMES(v0, c, factor);
                ADD_TIMES(v1, d, factor);
            }
            if (j < width) {
                const __m256d a = VALUES(0), b = VALUES(4);
                factor = _mm256_broadcast_sd(factors + j);
                ADD_TIMES(s0, a, factor);
                ADD_TIMES(s1, b, factor);
                factor = _mm256_broadcast_sd(others + j);
                ADD_TIMES(u0, a, factor);
                ADD_TIMES(u1, b, factor);
                value += PANEL;
            }
        }
        add_sums(row, _mm256_add_pd(s0, t0), _mm256_add_pd(s1, t1), y);
        add_sums(row, _mm256_add_pd(u0, v0), _mm256_add_pd(u1, v1), other_y);
    }
}
#endif

void choose_products(Panels *panels)
{
    panels->product = panel_product;
    panels->products = panel_products;
#ifdef FOUR_AT_ONCE
    if (has_wide_registers()) {
        panels->product = product_of_four;
        panels->products = products_of_four;
    }
#endif
}
