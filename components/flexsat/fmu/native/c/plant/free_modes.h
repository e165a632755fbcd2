/* The vibration of the free structure in coordinates that do not couple: the twin of runtime/free_modes.py.

Modes of the clamped structure couple through the motion of the body alone. Those that no such chain connects are
parts of their own: on a symmetric structure most modes move no body, and the others fall into sets for each direction.
A part's eigenvectors are found by themselves, which takes the cube of its size. Where they are too few, or nearly, the
coordinates of that part are eta and eta' themselves. */
#ifndef FLEXSAT_FREE_MODES_H
#define FLEXSAT_FREE_MODES_H

#include "component.h"
#include "element_products.h"

/* The vector of coordinates, z (2 m), holds a pair (p, q) for each place from 0 to m - 1. First stand the parts of one
mode: they move at the speed eta' = velocity p, without q. Their q stand last in z, so that what depends on speeds reads
the first `read` elements of it alone. */
typedef struct FreeModes {
    int modes, parts;
    int alone;        /* places of the parts whose speed has no q */
    int read;         /* 2 m - alone */
    int *first;       /* (parts + 1) first place of each */
    int *mode;        /* (m) mode of each place */
    int *q;           /* (m) where the second coordinate of each place stands in z; the first stands at the place */
    int *clamped;     /* (parts): eta and eta' themselves */
    int clamped_parts;
    int *oscillates;  /* (m) by places: a pair of conjugate eigenvalues, otherwise two real ones */
    double *value;    /* (m): real part, or the first of two */
    double *other;    /* (m): imaginary part, or the second */
    /* Blocks of each part of k modes, one part after the other; columns are p, then q, of its places. */
    size_t *place;    /* (parts) of the first element of (k, 2 k); of (2 k, 2 k): twice that */
    double *displacement; /* (k, 2 k): eta */
    double *velocity;     /* (k, 2 k): eta' */
    double *of_structure; /* (2 k, 2 k): p and q, from eta and eta' */
    double *matrix;       /* (2 k, 2 k): z' = matrix z, of the clamped parts */
    double *work;         /* for `free_transition` */
    TwoProducts *two_products; /* for this processor */
} FreeModes;

/* Find the coordinates. `effective` (m, m) is the inverse of the modes' mass with the body free; stiffness (m) [1/s2],
damping (m) [1/s]. */
int find_free_modes(Component *component, int modes, const double *effective, const double *stiffness,
                    const double *damping, FreeModes *free);

#endif
