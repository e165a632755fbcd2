#include "keep_out.h"

#include <math.h>
#include <string.h>

#include "number_text.h"
#include "rotations.h"

#define PI 3.14159265358979323846
#define EDGE 1e-12 /* of a cosine: rounding at the edge of a cone */

static const char *const names[CONES] = {"first", "second"};
/* tangent of a ring's angle over that of the cone: turns between neighbours on it stay outside */
static const double rings[RINGS] = {1.03, 1.2};

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double c[3])
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static int is_zero(const double a[3])
{
    return a[0] == 0.0 && a[1] == 0.0 && a[2] == 0.0;
}

/* Divide by the length; returns it. A vector of zeros stays. */
static double normalise(double a[3])
{
    const double length = sqrt(dot(a, a));
    int k;

    for (k = 0; k < 3 && length > 0.0; k++)
        a[k] /= length;
    return length;
}

/* A unit vector normal to two, or to the first if they are parallel. */
static void across(const double one[3], const double other[3], double normal[3])
{
    double unit[3] = {0.0, 0.0, 0.0};
    int k, least = 0;

    cross(one, other, normal);
    if (dot(normal, normal) < 1e-12) {
        for (k = 1; k < 3; k++)
            if (fabs(one[k]) < fabs(one[least]))
                least = k;
        unit[least] = 1.0;
        cross(one, unit, normal);
    }
    normalise(normal);
}

/* An inertial vector in the body axes of an attitude. */
static void in_body(const double attitude[4], const double vector[3], double seen[3])
{
    double twice[3], more[3];
    int k;

    cross(vector, attitude, twice);
    for (k = 0; k < 3; k++)
        twice[k] *= 2.0;
    cross(twice, attitude, more);
    for (k = 0; k < 3; k++)
        seen[k] = vector[k] + attitude[3] * twice[k] + more[k];
}

/* Where the body axis points, inertial. */
static void pointing_of(const KeepOut *cones, const double attitude[4], double pointing[3])
{
    const double back[4] = {-attitude[0], -attitude[1], -attitude[2], attitude[3]};

    in_body(back, cones->axis, pointing);
}

/* An attitude turned the short way until the body axis points so. */
static void swing(const KeepOut *cones, const double attitude[4], const double pointing[3], double swung[4])
{
    double seen[3], axis[3], angle;
    int k;

    in_body(attitude, pointing, seen);
    cross(cones->axis, seen, axis);
    angle = atan2(normalise(axis), dot(seen, cones->axis));
    if (is_zero(axis))
        across(cones->axis, cones->axis, axis); /* for half a turn any axis across will do */
    for (k = 0; k < 3; k++)
        axis[k] *= angle;
    rotate_quaternion(attitude, axis, swung);
}

int keep_out(Component *component, const double axis[3], const double *const directions[CONES],
             const double half_angles[CONES], KeepOut *cones)
{
    char text[NUMBER_SIZE];
    int k;

    memset(cones, 0, sizeof *cones);
    for (k = 0; k < CONES; k++) {
        if (!(half_angles[k] >= 0.0 && half_angles[k] < PI))
            return refuse(component, "keep_out.%s.half_angle must be in [0, pi), got %s", names[k],
                          number_text(half_angles[k], text));
        if (half_angles[k] > 0.0 && is_zero(directions[k]))
            return refuse(component, "keep_out.%s.direction must not be zero where its half_angle is > 0", names[k]);
        memcpy(cones->direction[k], directions[k], 3 * sizeof(double));
        normalise(cones->direction[k]);
        cones->half_angle[k] = half_angles[k];
        cones->active |= half_angles[k] != 0.0;
    }
    if (is_zero(axis))
        return refuse(component, "keep_out.axis must not be zero");
    memcpy(cones->axis, axis, 3 * sizeof(double));
    normalise(cones->axis);
    return 0;
}

int is_clear(const KeepOut *cones, const double attitude[4], const double rotation[3])
{
    double about[3] = {rotation[0], rotation[1], rotation[2]}, seen[3], beside[3];
    const double angle = normalise(about), along = dot(about, cones->axis);
    int k;

    for (k = 0; k < CONES; k++) {
        double c0, c1, c2, nearest, most;
        if (!(cones->half_angle[k] > 0.0))
            continue;
        /* cosine of the angle to the direction after turning by x: c0 + c1 cos x + c2 sin x */
        in_body(attitude, cones->direction[k], seen);
        cross(about, seen, beside);
        c0 = along * dot(about, seen);
        c1 = dot(seen, cones->axis) - c0;
        c2 = -dot(beside, cones->axis);
        nearest = atan2(c2, c1);
        if (nearest < 0.0)
            nearest += 2.0 * PI;
        most = nearest < angle ? hypot(c1, c2) : fmax(c1, c1 * cos(angle) + c2 * sin(angle));
        if (c0 + most > cos(cones->half_angle[k]) + EDGE)
            return 0;
    }
    return 1;
}

static int refuse_inside(Component *component, const KeepOut *cones, const char *word, const double attitude[4])
{
    const double degrees = 180.0 / PI;
    double seen[3];
    int k;

    for (k = 0; k < CONES; k++) {
        const double half_angle = cones->half_angle[k];
        double cosine;
        in_body(attitude, cones->direction[k], seen);
        cosine = dot(seen, cones->axis);
        if (half_angle > 0.0 && cosine > cos(half_angle) + EDGE)
            return refuse(component,
                          "command.rotation: the slew %s with keep_out.axis at %.6g deg from keep_out.%s.direction, "
                          "within keep_out.%s.half_angle = %.6g deg; command another attitude, or set that angle "
                          "lower",
                          word, acos(fmin(1.0, cosine)) * degrees, names[k], names[k], half_angle * degrees);
    }
    return 0;
}

/* Add the attitudes swung to a ring round a direction; azimuths count from the start's. */
static void add_ring(const KeepOut *cones, const double attitude[4], const double direction[3],
                     const double north[3], const double east[3], double ring, Search *search)
{
    double pointing[3];
    int azimuth, k;

    for (azimuth = 0; azimuth < AZIMUTHS; azimuth++) {
        const double angle = 2.0 * PI * azimuth / AZIMUTHS;
        for (k = 0; k < 3; k++)
            pointing[k] = cos(ring) * direction[k] + sin(ring) * (cos(angle) * north[k] + sin(angle) * east[k]);
        swing(cones, attitude, pointing, search->node[search->count++]);
    }
}

/* Add the attitudes through which a chain may lead: swung from the start, and from the end. */
static void add_waypoints(const KeepOut *cones, Search *search)
{
    const double *start = search->node[0], *end = search->node[1];
    double from_start[3], to_end[3], east[3], north[3], seen[3], turn;
    int cone, k;

    pointing_of(cones, start, from_start);
    pointing_of(cones, end, to_end);
    for (cone = 0; cone < CONES; cone++) {
        const double *direction = cones->direction[cone], half_angle = cones->half_angle[cone];
        double *beside;
        if (half_angle == 0.0)
            continue;
        across(direction, from_start, east);
        cross(east, direction, north);
        for (k = 0; k < RINGS; k++) {
            const double wider = half_angle < 0.5 * PI ? rings[k] : 1.0 / rings[k];
            const double ring = atan2(wider * sin(half_angle), cos(half_angle));
            add_ring(cones, start, direction, north, east, ring, search);
            add_ring(cones, end, direction, north, east, ring, search);
        }
        /* about the direction to the meridian of the end, and along it */
        turn = atan2(dot(to_end, east), dot(to_end, north));
        in_body(start, direction, seen);
        for (k = 0; k < 3; k++)
            seen[k] *= -turn;
        beside = search->node[search->count++];
        rotate_quaternion(start, seen, beside);
        swing(cones, beside, to_end, search->node[search->count++]);
    }
}

/* The short rotation vector [rad] from a node to another. */
static void turn_between(const Search *search, int from, int to, double turn[3])
{
    double relative[4];

    relative_quaternion(search->node[to], search->node[from], relative);
    rotation_vector(relative, turn);
}

/* The nodes of the quickest path from node 0 to node 1 in at most LEGS turns; returns their number, 0 for none. */
static int quickest(Search *search, int path[LEGS + 1])
{
    const int count = search->count;
    int reversed[LEGS + 1], length = 0, leg, from, to, k;

    memcpy(search->total, search->cost[0], (size_t)count * sizeof(double));
    for (leg = 1; leg < LEGS; leg++) {
        for (to = 0; to < count; to++) {
            int best = 0;
            for (from = 1; from < count; from++)
                if (search->total[from] + search->cost[from][to] < search->total[best] + search->cost[best][to])
                    best = from;
            search->least[to] = search->total[best] + search->cost[best][to];
            search->before[leg][to] = best;
        }
        for (to = 0; to < count; to++) {
            if (search->least[to] < search->total[to])
                search->total[to] = search->least[to];
            else
                search->before[leg][to] = -1; /* reached as quickly in fewer */
        }
    }
    if (!isfinite(search->total[1]))
        return 0;
    reversed[length++] = to = 1;
    for (leg = LEGS - 1; leg > 0; leg--)
        if (search->before[leg][to] >= 0)
            reversed[length++] = to = search->before[leg][to];
    if (to != 0)
        reversed[length++] = 0;
    for (k = 0; k < length; k++)
        path[k] = reversed[length - 1 - k];
    return length;
}

int plan_legs(Component *component, const KeepOut *cones, const double attitude[4], const double rotation[3],
              TurnDuration duration, const void *context, double legs[LEGS][3])
{
    Search *search = cones->search;
    double turn[3];
    int path[LEGS + 1], length, from, to, k;

    memset(legs, 0, LEGS * 3 * sizeof(double));
    memcpy(legs[0], rotation, 3 * sizeof(double));
    if (!cones->active || is_zero(rotation))
        return 0;
    memcpy(search->node[0], attitude, 4 * sizeof(double));
    rotate_quaternion(attitude, rotation, search->node[1]);
    search->count = 2;
    if (refuse_inside(component, cones, "begins", search->node[0]) ||
        refuse_inside(component, cones, "ends", search->node[1]))
        return 1;
    if (is_clear(cones, attitude, rotation))
        return 0;
    add_waypoints(cones, search);
    for (from = 0; from < search->count; from++)
        for (to = 0; to < search->count; to++) {
            turn_between(search, from, to, turn);
            search->cost[from][to] =
                is_clear(cones, search->node[from], turn) ? duration(context, turn) : (double)INFINITY;
        }
    length = quickest(search, path);
    if (length == 0)
        return refuse(component,
                      "keep_out: no chain of %d turns leads round the cones; command intermediate attitudes, or set "
                      "keep_out.first.half_angle or keep_out.second.half_angle lower",
                      (int)LEGS);
    memset(legs, 0, LEGS * 3 * sizeof(double));
    for (k = 0; k + 1 < length; k++)
        turn_between(search, path[k], path[k + 1], legs[k]);
    return 0;
}
