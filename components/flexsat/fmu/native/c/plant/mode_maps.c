#include "mode_maps.h"

#include <math.h>
#include <string.h>

#include "linear_algebra.h"
#include "zero_order_hold.h"

int take_map(Component *component, const FreeModes *free, Map *map)
{
    const size_t m = (size_t)free->modes;
    Memory *memory = &component->memory;
    size_t coupled = 0;
    int part;

    for (part = 0; part < free->parts; part++)
        if (free->clamped[part]) { /* up to the end of its block */
            const size_t k = (size_t)(free->first[part + 1] - free->first[part]);
            coupled = 2 * free->place[part] + 4 * k * k;
        }
    map->pp = memory_doubles(memory, m);
    map->pq = memory_doubles(memory, m);
    map->qp = memory_doubles(memory, m);
    map->qq = memory_doubles(memory, m);
    map->coupled = memory_doubles(memory, coupled);
    return memory->failed ? refuse(component, "there is not enough memory") : 0;
}

/* (exp(x) - 1)/x of x = re + i im; 1 at x = 0. */
static void mean_growth(double re, double im, double *result_re, double *result_im)
{
    const double half = sin(0.5 * im), square = re * re + im * im;
    const double grown_re = expm1(re) * cos(im) - 2.0 * half * half, grown_im = exp(re) * sin(im);

    if (!(square > 0.0)) {
        *result_re = 1.0, *result_im = 0.0;
        return;
    }
    *result_re = (grown_re * re + grown_im * im) / square;
    *result_im = (grown_im * re - grown_re * im) / square;
}

static void place_transition(const FreeModes *free, int place, double time, Map *power, Map *integral)
{
    const double first = free->value[place] * time, second = free->other[place] * time;
    double re, im, unused;

    if (free->oscillates[place]) {
        re = exp(first) * cos(second);
        im = exp(first) * sin(second);
        power->pp[place] = power->qq[place] = re;
        power->pq[place] = im, power->qp[place] = -im;
        mean_growth(first, second, &re, &im);
        integral->pp[place] = integral->qq[place] = time * re;
        integral->pq[place] = time * im, integral->qp[place] = -(time * im);
    } else {
        power->pp[place] = exp(first), power->qq[place] = exp(second);
        power->pq[place] = power->qp[place] = 0.0;
        mean_growth(first, 0.0, &re, &unused);
        mean_growth(second, 0.0, &im, &unused);
        integral->pp[place] = time * re, integral->qq[place] = time * im;
        integral->pq[place] = integral->qp[place] = 0.0;
    }
}

void free_transition(const FreeModes *free, double time, Map *power, Map *integral)
{
    int part, place;

    for (part = 0; part < free->parts; part++) {
        const int from = free->first[part], to = free->first[part + 1];
        const size_t block = 2 * free->place[part];
        if (free->clamped[part])
            transition_with(2 * (to - from), free->matrix + block, time, power->coupled + block,
                            integral->coupled + block, free->work);
        else
            for (place = from; place < to; place++)
                place_transition(free, place, time, power, integral);
    }
}

static void map_places(const FreeModes *free, int count, int from, const Map *map, const double *p, const double *q,
                       double *new_p, double *new_q)
{
    free->two_products(count, map->pp + from, p, map->pq + from, q, new_p);
    free->two_products(count, map->qp + from, p, map->qq + from, q, new_q);
}

/* Apply the block of a clamped part to `columns` columns of rows. */
static void map_clamped(const FreeModes *free, const Map *map, int part, int columns, const double *rows,
                        double *result)
{
    const int from = free->first[part], k = free->first[part + 1] - from;
    const size_t width = (size_t)columns;
    const double *block = map->coupled + 2 * free->place[part];
    int i, j, column;

    for (i = 0; i < 2 * k; i++, block += 2 * k) {
        double *row = result + (size_t)(i < k ? from + i : free->q[from + i - k]) * width;
        memset(row, 0, width * sizeof(double));
        for (j = 0; j < 2 * k; j++) {
            const double *other = rows + (size_t)(j < k ? from + j : free->q[from + j - k]) * width;
            for (column = 0; column < columns; column++)
                row[column] += block[j] * other[column];
        }
    }
}

void map_vector(const FreeModes *free, const Map *map, const double *z, double *result)
{
    const int m = free->modes, alone = free->alone;
    int part;

    map_places(free, alone, 0, map, z, z + free->read, result, result + free->read);
    map_places(free, m - alone, alone, map, z + alone, z + m, result + alone, result + m);
    for (part = 0; part < free->parts && free->clamped_parts > 0; part++)
        if (free->clamped[part])
            map_clamped(free, map, part, 1, z, result);
}

void map_rows(const FreeModes *free, const Map *map, int columns, const double *rows, double *result)
{
    const size_t width = (size_t)columns;
    int part, place, column;

    for (part = 0; part < free->parts; part++) {
        if (free->clamped[part]) {
            map_clamped(free, map, part, columns, rows, result);
            continue;
        }
        for (place = free->first[part]; place < free->first[part + 1]; place++) {
            const double *p = rows + (size_t)place * width, *q = rows + (size_t)free->q[place] * width;
            double *new_p = result + (size_t)place * width, *new_q = result + (size_t)free->q[place] * width;
            for (column = 0; column < columns; column++) {
                new_p[column] = map->pp[place] * p[column] + map->pq[place] * q[column];
                new_q[column] = map->qp[place] * p[column] + map->qq[place] * q[column];
            }
        }
    }
}

void structure_of(const FreeModes *free, const double *blocks, const double *z, double *structure)
{
    int part, i;

    for (part = 0; part < free->parts; part++) {
        const int from = free->first[part], k = free->first[part + 1] - from;
        const double *row = blocks + free->place[part];
        for (i = 0; i < k; i++, row += 2 * k) {
            double sum = 0.0; /* the second coordinates of a part stand one after the other too */
            add_times_vector(1, k, row, z + from, &sum);
            add_times_vector(1, k, row + k, z + free->q[from], &sum);
            structure[free->mode[from + i]] = sum;
        }
    }
}

void from_coordinates(const FreeModes *free, const double *blocks, int rows, const double *a, double *result)
{
    const size_t m = (size_t)free->modes;
    int part, i, j, row;

    memset(result, 0, (size_t)rows * 2 * m * sizeof(double));
    for (part = 0; part < free->parts; part++) {
        const int from = free->first[part], k = free->first[part + 1] - from;
        for (row = 0; row < rows; row++) {
            double *sums = result + (size_t)row * 2 * m;
            for (i = 0; i < k; i++) {
                const double *block = blocks + free->place[part] + (size_t)i * 2 * (size_t)k;
                const double factor = a[(size_t)row * m + (size_t)free->mode[from + i]];
                for (j = 0; j < k; j++) {
                    sums[from + j] += factor * block[j];
                    sums[free->q[from + j]] += factor * block[k + j];
                }
            }
        }
    }
}

void coordinates_of(const FreeModes *free, int columns, const double *eta, const double *speed, double *z)
{
    const size_t width = (size_t)columns;
    int part, i, j, column;

    memset(z, 0, 2 * (size_t)free->modes * width * sizeof(double));
    for (part = 0; part < free->parts; part++) {
        const int from = free->first[part], k = free->first[part + 1] - from;
        const double *row = free->of_structure + 2 * free->place[part];
        for (i = 0; i < 2 * k; i++, row += 2 * k) {
            double *sums = z + (size_t)(i < k ? from + i : free->q[from + i - k]) * width;
            for (j = 0; j < k; j++) {
                const size_t other = (size_t)free->mode[from + j] * width;
                for (column = 0; column < columns; column++) {
                    if (eta != NULL)
                        sums[column] += row[j] * eta[other + (size_t)column];
                    sums[column] += row[k + j] * speed[other + (size_t)column];
                }
            }
        }
    }
}
