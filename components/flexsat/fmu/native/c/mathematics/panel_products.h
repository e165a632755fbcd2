/* Products of panels with vectors: the same bits on every processor, in the widest registers that it has. */
#ifndef FLEXSAT_PANEL_PRODUCTS_H
#define FLEXSAT_PANEL_PRODUCTS_H

#include "panels.h"

/* y (rows) += a x (columns) */
typedef void PanelProduct(const Panels *panels, const Real *x, Real *y);

/* For any processor. */
PanelProduct panel_product;

/* The quickest on this processor. */
PanelProduct *quickest_panel_product(void);

#endif
