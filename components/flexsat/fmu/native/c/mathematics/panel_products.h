/* Products of panels with vectors: the same bits on every processor, in the widest registers that it has. */
#ifndef FLEXSAT_PANEL_PRODUCTS_H
#define FLEXSAT_PANEL_PRODUCTS_H

#include "panels.h"

/* For any processor. */
PanelProduct panel_product;
PanelProducts panel_products;

/* The quickest on this processor. */
void choose_products(Panels *panels);

#endif
