/* Products of vectors element by element, in the widest registers of the processor; all of them round alike. */
#ifndef FLEXSAT_ELEMENT_PRODUCTS_H
#define FLEXSAT_ELEMENT_PRODUCTS_H

/* result (n) = a b + c d; it may be none of the others, unless at the same place. */
typedef void TwoProducts(int n, const double *a, const double *b, const double *c, const double *d, double *result);

/* For any processor. */
void two_products(int n, const double *a, const double *b, const double *c, const double *d, double *result);

/* The quickest on this processor. */
TwoProducts *quickest_two_products(void);

#endif
