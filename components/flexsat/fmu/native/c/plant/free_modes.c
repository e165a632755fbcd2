#include "free_modes.h"

#include <math.h>
#include <string.h>

#include "eigenvectors.h"
#include "linear_algebra.h"

static const double WORST_CONDITION = 1e6; /* of a part's eigenvectors: six digits are lost */

/* Number the parts: part[j] of each mode; returns how many there are. `size` counts their modes. */
static int connect(int m, const double *effective, int *part, int *size, int *waiting)
{
    int parts = 0, i, j;

    for (i = 0; i < m; i++)
        part[i] = -1;
    for (i = 0; i < m; i++) {
        int count = 0;
        if (part[i] >= 0)
            continue;
        waiting[count++] = i;
        part[i] = parts;
        size[parts] = 0;
        while (count > 0) {
            const double *row = effective + (size_t)waiting[--count] * (size_t)m;
            size[parts]++;
            for (j = 0; j < m; j++)
                if (row[j] != 0.0 && part[j] < 0) {
                    part[j] = parts;
                    waiting[count++] = j;
                }
        }
        parts++;
    }
    return parts;
}

/* Give the modes their places, parts of one mode first; returns the elements of all blocks (k, 2 k). */
static size_t arrange(FreeModes *free, const int *part, const int *size, int parts)
{
    size_t elements = 0;
    int places = 0, larger, number, j;

    free->parts = 0;
    for (larger = 0; larger < 2; larger++)
        for (number = 0; number < parts; number++)
            if ((size[number] > 1) == larger) {
                free->first[free->parts] = places;
                free->place[free->parts++] = elements;
                elements += 2 * (size_t)size[number] * (size_t)size[number];
                for (j = 0; j < free->modes; j++)
                    if (part[j] == number)
                        free->mode[places++] = j;
            }
    free->first[free->parts] = places;
    return elements;
}

/* Turn the phase of a vector (2 k) of (omega eta, eta') so that its largest speed is real. */
static void turn_phase(int k, double *re, double *im)
{
    double largest = -1.0, size, cosine, sine;
    int chosen = k, i;

    for (i = k; i < 2 * k; i++)
        if (re[i] * re[i] + im[i] * im[i] > largest) {
            largest = re[i] * re[i] + im[i] * im[i];
            chosen = i;
        }
    size = sqrt(largest);
    if (!(size > 0.0))
        return;
    cosine = re[chosen] / size;
    sine = -im[chosen] / size;
    for (i = 0; i < 2 * k; i++) {
        const double was = re[i];
        re[i] = cosine * was - sine * im[i];
        im[i] = sine * was + cosine * im[i];
    }
    im[chosen] = 0.0;
}

/* Write the free modes of a part of k modes: eigenvalues, and vectors as the columns of `basis` (2 k, 2 k). `vectors`
has them as rows. */
static void choose_basis(int k, const double *real, const double *imaginary, double *vectors, double *value,
                         double *other, int *oscillates, double *basis)
{
    const size_t width = 2 * (size_t)k;
    int pairs = 0, alone = 0, i, e;

    for (i = 0; i < 2 * k; i++)
        pairs += imaginary[i] > 0.0;
    for (i = 0, e = 0; i < 2 * k; i++) {
        double *vector = vectors + (size_t)i * width;
        int place = e, second = 0, j;
        if (imaginary[i] > 0.0) {
            turn_phase(k, vector, vector + width);
            for (j = 0; j < 2 * k; j++)
                basis[(size_t)j * width + (size_t)(k + place)] = vector[width + (size_t)j];
            value[e] = real[i];
            other[e] = imaginary[i];
            oscillates[e++] = 1;
            i++;
        } else { /* real ones, two by two in their order, behind the pairs */
            place = pairs + alone / 2;
            second = alone++ % 2;
            (second ? other : value)[place] = real[i];
            oscillates[place] = 0;
        }
        for (j = 0; j < 2 * k; j++)
            basis[(size_t)j * width + (size_t)(second ? k + place : place)] = vector[j];
    }
}

static double norm(size_t count, const double *a)
{
    double square = 0.0;
    size_t e;

    for (e = 0; e < count; e++)
        square += a[e] * a[e];
    return sqrt(square);
}

/* Find the free modes of a part; returns 1 where they are too few, or nearly. `work` holds 20 k k + 12 k doubles. */
static int part_modes(const double *effective, const double *stiffness, const double *damping, int part,
                      FreeModes *free, double *work)
{
    const int from = free->first[part], k = free->first[part + 1] - from, *mode = free->mode + from;
    const size_t width = 2 * (size_t)k, count = width * width, m = (size_t)free->modes;
    double *a = work, *vectors = a + count, *basis = vectors + count, *real = basis + count;
    double *imaginary = real + width, *rest = imaginary + width, *back = a;
    double *displacement = free->displacement + free->place[part], *velocity = free->velocity + free->place[part];
    double *of_structure = free->of_structure + 2 * free->place[part], size;
    int i, j;

    memset(a, 0, count * sizeof(double)); /* of (omega eta, eta') */
    for (i = 0; i < k; i++) {
        a[(size_t)i * width + (size_t)(k + i)] = sqrt(stiffness[mode[i]]);
        for (j = 0; j < k; j++) {
            const double element = effective[(size_t)mode[i] * m + (size_t)mode[j]];
            a[(size_t)(k + i) * width + (size_t)j] = -element * sqrt(stiffness[mode[j]]);
            a[(size_t)(k + i) * width + (size_t)(k + j)] = -element * damping[mode[j]];
        }
    }
    if (eigenvectors(2 * k, a, real, imaginary, vectors, rest))
        return 1;
    choose_basis(k, real, imaginary, vectors, free->value + from, free->other + from, free->oscillates + from, basis);
    memcpy(vectors, basis, count * sizeof(double));
    size = norm(count, basis);
    if (invert(2 * k, vectors, back) || !(size * norm(count, back) < WORST_CONDITION))
        return 1; /* norms of all elements, which are at least those of matrices; the negation also finds NaN */
    for (i = 0; i < k; i++)
        for (j = 0; j < 2 * k; j++) {
            const double scaled = basis[(size_t)i * width + (size_t)j]; /* omega eta */
            displacement[(size_t)i * width + (size_t)j] = scaled / sqrt(stiffness[mode[i]]);
            velocity[(size_t)i * width + (size_t)j] = basis[(size_t)(k + i) * width + (size_t)j];
        }
    for (i = 0; i < 2 * k; i++)
        for (j = 0; j < k; j++) {
            const double scaled = back[(size_t)i * width + (size_t)j];
            of_structure[(size_t)i * width + (size_t)j] = scaled * sqrt(stiffness[mode[j]]);
            of_structure[(size_t)i * width + (size_t)(k + j)] = back[(size_t)i * width + (size_t)(k + j)];
        }
    return 0;
}

/* Let a part keep eta and eta'. */
static void keep_clamped(const double *effective, const double *stiffness, const double *damping, int part,
                         FreeModes *free)
{
    const int from = free->first[part], k = free->first[part + 1] - from, *mode = free->mode + from;
    const size_t width = 2 * (size_t)k, m = (size_t)free->modes;
    double *displacement = free->displacement + free->place[part], *velocity = free->velocity + free->place[part];
    double *matrix = free->matrix + 2 * free->place[part];
    int i, j;

    free->clamped[part] = 1;
    free->clamped_parts++;
    identity(2 * k, free->of_structure + 2 * free->place[part]);
    memset(displacement, 0, (size_t)k * width * sizeof(double));
    memset(velocity, 0, (size_t)k * width * sizeof(double));
    for (i = 0; i < k; i++) {
        displacement[(size_t)i * width + (size_t)i] = 1.0;
        velocity[(size_t)i * width + (size_t)(k + i)] = 1.0;
        matrix[(size_t)i * width + (size_t)(k + i)] = 1.0;
        for (j = 0; j < k; j++) {
            const double element = effective[(size_t)mode[i] * m + (size_t)mode[j]];
            matrix[(size_t)(k + i) * width + (size_t)j] = -element * stiffness[mode[j]];
            matrix[(size_t)(k + i) * width + (size_t)(k + j)] = -element * damping[mode[j]];
        }
    }
}

/* Place the second coordinates in z. */
static void place_seconds(FreeModes *free)
{
    const int m = free->modes;
    int place;

    free->alone = 0;
    while (free->alone < free->parts && free->first[free->alone + 1] == free->alone + 1 &&
           !free->clamped[free->alone] && free->oscillates[free->alone])
        free->alone++;
    free->read = 2 * m - free->alone;
    for (place = 0; place < m; place++)
        free->q[place] = place < free->alone ? free->read + place : m + place - free->alone;
}

int find_free_modes(Component *component, int modes, const double *effective, const double *stiffness,
                    const double *damping, FreeModes *free)
{
    const size_t m = (size_t)modes;
    Memory *memory = &component->memory;
    int *part = memory_take(memory, m, sizeof(int)), *size = memory_take(memory, m, sizeof(int));
    int *waiting = memory_take(memory, m, sizeof(int)), largest = 1, largest_clamped = 0, parts, i;
    MemoryBlock *mark;
    double *work;
    size_t elements;

    free->modes = modes;
    free->two_products = quickest_two_products();
    free->clamped_parts = 0;
    free->first = memory_take(memory, m + 1, sizeof(int));
    free->mode = memory_take(memory, m, sizeof(int));
    free->q = memory_take(memory, m, sizeof(int));
    free->clamped = memory_take(memory, m, sizeof(int));
    free->oscillates = memory_take(memory, m, sizeof(int));
    free->place = memory_take(memory, m, sizeof(size_t));
    free->value = memory_doubles(memory, m);
    free->other = memory_doubles(memory, m);
    if (memory->failed)
        return refuse(component, "there is not enough memory");
    parts = connect(modes, effective, part, size, waiting);
    elements = arrange(free, part, size, parts);
    for (i = 0; i < parts; i++)
        largest = size[i] > largest ? size[i] : largest;
    free->displacement = memory_doubles(memory, elements);
    free->velocity = memory_doubles(memory, elements);
    free->of_structure = memory_doubles(memory, 2 * elements);
    free->matrix = memory_doubles(memory, 2 * elements);
    mark = memory->last;
    work = memory_doubles(memory, 20 * (size_t)largest * (size_t)largest + 12 * (size_t)largest);
    if (memory->failed)
        return refuse(component, "there is not enough memory");
    for (i = 0; i < parts; i++)
        if (part_modes(effective, stiffness, damping, i, free, work)) {
            const int k = free->first[i + 1] - free->first[i];
            keep_clamped(effective, stiffness, damping, i, free);
            largest_clamped = k > largest_clamped ? k : largest_clamped;
        }
    memory_rewind(memory, mark);
    place_seconds(free);
    free->work = memory_doubles(memory, 20 * (size_t)largest_clamped * (size_t)largest_clamped);
    return memory->failed ? refuse(component, "there is not enough memory") : 0;
}
