/* Products of panels with vectors: the same bits on every processor, in the widest registers that it has. */
#ifndef FLEXSAT_PANEL_PRODUCTS_H
#define FLEXSAT_PANEL_PRODUCTS_H

#include "panels.h"

/* For any processor. */
void panel_product(const Panels *panels, const Real *x, Real *y);
void panel_products(const Panels *panels, const Real *x, const Real *other_x, Real *y, Real *other_y);

/* The quickest on this processor. */
void choose_products(Panels *panels);

#endif
