/* What is linear in the coordinates of the free structure's vibration; the second part of the twin of
runtime/free_modes.py. */
#ifndef FLEXSAT_MODE_MAPS_H
#define FLEXSAT_MODE_MAPS_H

#include "free_modes.h"

/* A linear map of z whose parts do not couple: [p, q] becomes [pp p + pq q, qp p + qq q], each (m) by places; the
clamped parts have a block (2 k, 2 k) of `coupled` instead, at twice their place. */
typedef struct Map {
    double *pp, *pq, *qp, *qq, *coupled;
} Map;

int take_map(Component *component, const FreeModes *free, Map *map);

/* exp(A t), and its integral from 0 to t, at t = time [s]. */
void free_transition(const FreeModes *free, double time, Map *power, Map *integral);

/* result (2 m) = map z */
void map_vector(const FreeModes *free, const Map *map, const double *z, double *result);

/* result (2 m, columns) = map rows (2 m, columns) */
void map_rows(const FreeModes *free, const Map *map, int columns, const double *rows, double *result);

/* eta or eta', (m), from z, by the blocks `displacement` or `velocity`. */
void structure_of(const FreeModes *free, const double *blocks, const double *z, double *structure);

/* result (rows, 2 m) = a (rows, m) times these blocks: what is linear in eta or eta', from z. */
void from_coordinates(const FreeModes *free, const double *blocks, int rows, const double *a, double *result);

/* z (2 m, columns) from eta and eta', (m, columns) each; NULL stands for zeros. */
void coordinates_of(const FreeModes *free, int columns, const double *eta, const double *speed, double *z);

#endif
