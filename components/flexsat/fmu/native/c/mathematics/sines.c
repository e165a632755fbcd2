/* An angle less the nearest whole number of quarter turns lies within an eighth of a turn, where Taylor's series to the
17th power is exact to rounding. A quarter turn is subtracted in three parts; products with the first two are exact
for angles up to LARGEST. Both ways of writing it round alike. */
#include "sines.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "wide_registers.h"

#define LARGEST 1e8                /* rad; those beyond are the C library's */
#define QUARTERS 0.63661977236758134308
#define WHOLE 6755399441055744.0   /* 1.5 * 2^52: what is added to it is rounded to a whole number, in its last bits */
#define FIRST_PART 0x1.921fb54p+0  /* of a quarter turn, 27 bits each */
#define SECOND_PART 0x1.10b4610p-30
#define THIRD_PART 0x1.a62633145c06ep-58

/* 1/k!, with the signs of the series */
#define S3 -1.6666666666666666667e-1
#define S5 8.3333333333333333333e-3
#define S7 -1.9841269841269841270e-4
#define S9 2.7557319223985890653e-6
#define S11 -2.5052108385441718775e-8
#define S13 1.6059043836821614599e-10
#define S15 -7.6471637318198164759e-13
#define S17 2.8114572543455207632e-15
#define C4 4.1666666666666666667e-2
#define C6 -1.3888888888888888889e-3
#define C8 2.4801587301587301587e-5
#define C10 -2.7557319223985890653e-7
#define C12 2.0876756987868098979e-9
#define C14 -1.1470745597729724714e-11
#define C16 4.7794773323873852974e-14

static void sine_and_cosine(double angle, double *sine, double *cosine)
{
    const double shifted = angle * QUARTERS + WHOLE, quarters = shifted - WHOLE;
    double x, square, s, c;
    uint64_t bits;

    if (!(fabs(angle) <= LARGEST)) { /* the negation also finds NaN */
        *sine = sin(angle);
        *cosine = cos(angle);
        return;
    }
    x = ((angle - quarters * FIRST_PART) - quarters * SECOND_PART) - quarters * THIRD_PART;
    square = x * x;
    s = ((((((S17 * square + S15) * square + S13) * square + S11) * square + S9) * square + S7) * square + S5) * square;
    s = x + x * (square * (s + S3));
    c = (((((C16 * square + C14) * square + C12) * square + C10) * square + C8) * square + C6) * square;
    c = 1.0 + square * (square * (c + C4) - 0.5);
    memcpy(&bits, &shifted, sizeof bits);
    *sine = bits & 1 ? c : s;
    *cosine = bits & 1 ? s : c;
    if (bits & 2)
        *sine = -*sine;
    if ((bits + 1) & 2)
        *cosine = -*cosine;
}

void sines_one_by_one(int n, const double *angle, double *sine, double *cosine)
{
    int k;

    for (k = 0; k < n; k++)
        sine_and_cosine(angle[k], sine + k, cosine + k);
}

#ifdef FOUR_IN_REGISTERS
#include <immintrin.h>

#define ALL(number) _mm256_set1_pd(number)
#define NEXT(sum, factor, constant) sum = _mm256_add_pd(_mm256_mul_pd(sum, factor), ALL(constant))

IN_WIDE_REGISTERS
static void by_four(int n, const double *angle, double *sine, double *cosine)
{
    const __m256d sign = ALL(-0.0);
    int k;

    for (k = 0; k + 3 < n; k += 4) {
        const __m256d given = _mm256_loadu_pd(angle + k);
        const __m256d size = _mm256_andnot_pd(sign, given);
        const __m256d shifted = _mm256_add_pd(_mm256_mul_pd(given, ALL(QUARTERS)), ALL(WHOLE));
        const __m256d quarters = _mm256_sub_pd(shifted, ALL(WHOLE));
        const __m256i bits = _mm256_castpd_si256(shifted), next = _mm256_add_epi64(bits, _mm256_set1_epi64x(1));
        const __m256d odd = _mm256_castsi256_pd(_mm256_slli_epi64(bits, 63));
        __m256d x, square, s, c;
        if (_mm256_movemask_pd(_mm256_cmp_pd(size, ALL(LARGEST), _CMP_LE_OQ)) != 15) {
            sines_one_by_one(4, angle + k, sine + k, cosine + k);
            continue;
        }
        x = _mm256_sub_pd(given, _mm256_mul_pd(quarters, ALL(FIRST_PART)));
        x = _mm256_sub_pd(x, _mm256_mul_pd(quarters, ALL(SECOND_PART)));
        x = _mm256_sub_pd(x, _mm256_mul_pd(quarters, ALL(THIRD_PART)));
        square = _mm256_mul_pd(x, x);
        s = ALL(S17);
        NEXT(s, square, S15);
        NEXT(s, square, S13);
        NEXT(s, square, S11);
        NEXT(s, square, S9);
        NEXT(s, square, S7);
        NEXT(s, square, S5);
        NEXT(s, square, S3);
        s = _mm256_add_pd(x, _mm256_mul_pd(x, _mm256_mul_pd(square, s)));
        c = ALL(C16);
        NEXT(c, square, C14);
        NEXT(c, square, C12);
        NEXT(c, square, C10);
        NEXT(c, square, C8);
        NEXT(c, square, C6);
        NEXT(c, square, C4);
        c = _mm256_sub_pd(_mm256_mul_pd(square, c), ALL(0.5));
        c = _mm256_add_pd(ALL(1.0), _mm256_mul_pd(square, c));
        _mm256_storeu_pd(sine + k,
                         _mm256_xor_pd(_mm256_blendv_pd(s, c, odd),
                                       _mm256_and_pd(sign, _mm256_castsi256_pd(_mm256_slli_epi64(bits, 62)))));
        _mm256_storeu_pd(cosine + k,
                         _mm256_xor_pd(_mm256_blendv_pd(c, s, odd),
                                       _mm256_and_pd(sign, _mm256_castsi256_pd(_mm256_slli_epi64(next, 62)))));
    }
    sines_one_by_one(n - k, angle + k, sine + k, cosine + k);
}
#endif

Sines *quickest_sines(void)
{
#ifdef FOUR_IN_REGISTERS
    if (has_wide_registers())
        return by_four;
#endif
    return sines_one_by_one;
}
