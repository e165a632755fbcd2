/* A panel's sums run sixteen at once, so that a processor need not wait for each: eight of the columns 0, 2, 4 and so on,
and eight of the others, which are added at the end. That order, and rounding after each product, are the same in the
three ways of writing it. */
#include "panel_products.h"

#include "wide_registers.h"

#if !defined(FLEXSAT_FLOATS) && (defined(__SSE2__) || defined(_M_X64)) /* every x86-64 */
#include <emmintrin.h>
#define TWO_AT_ONCE
#if defined(FOUR_IN_REGISTERS)
#include <immintrin.h>
#define FOUR_AT_ONCE
#endif
#endif

#ifdef TWO_AT_ONCE
static void sum_columns(int count, const double *value, const double *x, double sums[PANEL])
{
    __m128d s0 = _mm_setzero_pd(), s1 = s0, s2 = s0, s3 = s0, t0 = s0, t1 = s0, t2 = s0, t3 = s0, factor;
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
    _mm_storeu_pd(sums, _mm_add_pd(s0, t0));
    _mm_storeu_pd(sums + 2, _mm_add_pd(s1, t1));
    _mm_storeu_pd(sums + 4, _mm_add_pd(s2, t2));
    _mm_storeu_pd(sums + 6, _mm_add_pd(s3, t3));
}
#else
static void sum_columns(int count, const Real *value, const Real *x, Real sums[PANEL])
{
    Real others[PANEL] = {0};
    int j, k;

    for (k = 0; k < PANEL; k++)
        sums[k] = 0;
    for (j = 0; j + 1 < count; j += 2, value += 2 * PANEL)
        for (k = 0; k < PANEL; k++) {
            sums[k] += value[k] * x[j];
            others[k] += value[PANEL + k] * x[j + 1];
        }
    for (k = 0; k < PANEL && j < count; k++)
        sums[k] += value[k] * x[j];
    for (k = 0; k < PANEL; k++)
        sums[k] += others[k];
}
#endif

void panel_product(const Panels *panels, const Real *x, Real *y)
{
    int panel, k;

    for (panel = 0; panel < panels->count; panel++) {
        const int *row = panels->row + PANEL * panel, from = panels->from[panel];
        Real sums[PANEL];
        sum_columns(panels->to[panel] - from, panels->value + panels->place[panel], x + from, sums);
        for (k = 0; k < PANEL; k++)
            y[row[k]] += sums[k];
    }
}

#ifdef FOUR_AT_ONCE
/* Whether the rows of a panel stand one after the other; then those that fill a panel up are not among them. */
static int is_block(const int *row) { return row[PANEL - 1] == row[0] + PANEL - 1; }

IN_WIDE_REGISTERS
static void panel_product_of_four(const Panels *panels, const double *x, double *y)
{
    int panel, j, k;

    for (panel = 0; panel < panels->count; panel++) {
        const int *row = panels->row + PANEL * panel, from = panels->from[panel], count = panels->to[panel] - from;
        const double *value = panels->value + panels->place[panel], *factors = x + from;
        __m256d s0 = _mm256_setzero_pd(), s1 = s0, t0 = s0, t1 = s0;
        for (j = 0; j + 1 < count; j += 2, value += 2 * PANEL) {
            const __m256d factor = _mm256_broadcast_sd(factors + j), other = _mm256_broadcast_sd(factors + j + 1);
            s0 = _mm256_add_pd(s0, _mm256_mul_pd(_mm256_loadu_pd(value), factor));
            s1 = _mm256_add_pd(s1, _mm256_mul_pd(_mm256_loadu_pd(value + 4), factor));
            t0 = _mm256_add_pd(t0, _mm256_mul_pd(_mm256_loadu_pd(value + 8), other));
            t1 = _mm256_add_pd(t1, _mm256_mul_pd(_mm256_loadu_pd(value + 12), other));
        }
        if (j < count) {
            const __m256d factor = _mm256_broadcast_sd(factors + j);
            s0 = _mm256_add_pd(s0, _mm256_mul_pd(_mm256_loadu_pd(value), factor));
            s1 = _mm256_add_pd(s1, _mm256_mul_pd(_mm256_loadu_pd(value + 4), factor));
        }
        s0 = _mm256_add_pd(s0, t0);
        s1 = _mm256_add_pd(s1, t1);
        if (is_block(row)) {
            double *sums = y + row[0];
            _mm256_storeu_pd(sums, _mm256_add_pd(_mm256_loadu_pd(sums), s0));
            _mm256_storeu_pd(sums + 4, _mm256_add_pd(_mm256_loadu_pd(sums + 4), s1));
        } else {
            double sums[PANEL];
            _mm256_storeu_pd(sums, s0);
            _mm256_storeu_pd(sums + 4, s1);
            for (k = 0; k < PANEL; k++)
                y[row[k]] += sums[k];
        }
    }
}
#endif

PanelProduct *quickest_panel_product(void)
{
#ifdef FOUR_AT_ONCE
    if (has_wide_registers())
        return panel_product_of_four;
#endif
    return panel_product;
}
