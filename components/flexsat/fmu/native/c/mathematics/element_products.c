#include "element_products.h"

#include "wide_registers.h"

void two_products(int n, const double *a, const double *b, const double *c, const double *d, double *result)
{
    int i;

    for (i = 0; i < n; i++)
        result[i] = a[i] * b[i] + c[i] * d[i];
}

#ifdef FOUR_IN_REGISTERS
#include <immintrin.h>

#define FOUR(vector) _mm256_loadu_pd((vector) + i)

IN_WIDE_REGISTERS
static void two_products_of_four(int n, const double *a, const double *b, const double *c, const double *d,
                                 double *result)
{
    int i;

    for (i = 0; i + 3 < n; i += 4)
        _mm256_storeu_pd(result + i, _mm256_add_pd(_mm256_mul_pd(FOUR(a), FOUR(b)), _mm256_mul_pd(FOUR(c), FOUR(d))));
    two_products(n - i, a + i, b + i, c + i, d + i, result + i);
}
#endif

TwoProducts *quickest_two_products(void)
{
#ifdef FOUR_IN_REGISTERS
    if (has_wide_registers())
        return two_products_of_four;
#endif
    return two_products;
}
