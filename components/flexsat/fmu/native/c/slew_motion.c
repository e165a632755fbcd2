#include "slew_motion.h"

#include <math.h>
#include <string.h>

/* The last knot that is not after `time`, which lies between the first and the last. */
static int knot_before(const Motion *motion, double time)
{
    int low = 0, high = motion->count;

    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (motion->times[middle] <= time)
            low = middle;
        else
            high = middle;
    }
    return low;
}

double motion_rate(const Motion *motion, double time)
{
    const int last = motion->count - 1;
    const double *times = motion->times, *rates = motion->rates;
    int k;

    if (!(time > times[0]))
        return rates[0];
    if (time >= times[last])
        return rates[last];
    k = knot_before(motion, time);
    return (rates[k + 1] - rates[k]) / (times[k + 1] - times[k]) * (time - times[k]) + rates[k];
}

double motion_rotation(const Motion *motion, double time)
{
    const int last = motion->count - 1;
    int k;

    if (time <= motion->times[0])
        return 0.0;
    if (time >= motion->times[last])
        return motion->turned[last];
    k = knot_before(motion, time);
    return motion->turned[k] + 0.5 * (time - motion->times[k]) * (motion->rates[k] + motion_rate(motion, time));
}

/* Keep the knots that follow others, and integrate. */
static void make(const double axis[3], int count, const double *times, const double *rates, int knots, double angle,
                 double scale, Motion *motion)
{
    Motion made;
    int k, kept = 0;

    memset(&made, 0, sizeof made);
    memcpy(made.axis, axis, sizeof made.axis);
    made.angle = angle;
    made.scale = scale;
    made.start = times[0];
    made.end = times[count - 1];
    made.knots = knots;
    for (k = 0; k < count; k++) {
        if (k > 0 && !(times[k] - times[k - 1] > 0.0)) /* a triangle has no coast */
            continue;
        made.times[kept] = times[k];
        made.rates[kept] = rates[k];
        kept++;
    }
    for (k = 1; k < kept; k++)
        made.turned[k] = made.turned[k - 1] +
                         0.5 * (made.rates[k] + made.rates[k - 1]) * (made.times[k] - made.times[k - 1]);
    made.count = kept;
    *motion = made;
}

/* The angle under straight lines between samples of the rate, at `phase` plus whole periods. */
static double sampled_angle(int count, const double *times, const double *rates, double period, double phase)
{
    double exact = 0.0, corners = 0.0, before = 0.0;
    int k;

    for (k = 0; k < count; k++) {
        const double place = (times[k] - phase) / period, part = place - floor(place);
        double slope = 0.0;
        if (k + 1 < count) {
            const double length = times[k + 1] - times[k];
            exact += 0.5 * (rates[k + 1] + rates[k]) * length;
            if (length > 0.0)
                slope = (rates[k + 1] - rates[k]) / length;
        }
        corners += (slope - before) * (part * (1.0 - part));
        before = slope;
    }
    return exact + 0.5 * period * period * corners;
}

void motion_still(int knots, double start, Motion *motion)
{
    const double axis[3] = {1.0, 0.0, 0.0}, rates[2] = {0.0, 0.0};
    const double times[2] = {start, start + 1.0};

    make(axis, 2, times, rates, knots, 0.0, 1.0, motion);
}

void motion_from_profile(const Profile *profile, int knots, double period, double phase, Motion *motion)
{
    const double start = profile->start;
    const double times[4] = {start, start + profile->ramp, start + (profile->ramp + profile->coast),
                             start + (profile_end(profile) - start)};
    const double rates[4] = {0.0, profile->coast_rate, profile->coast_rate, 0.0};

    motion_from_knots(profile->axis, profile->angle, 4, times, rates, knots, period, phase, motion);
}

void motion_from_knots(const double axis[3], double angle, int count, const double *times, const double *rates,
                       int knots, double period, double phase, Motion *motion)
{
    const double turned = sampled_angle(count, times, rates, period, phase);

    make(axis, count, times, rates, knots, angle, turned > 0.0 ? angle / turned : 1.0, motion);
}

void motion_stop(Motion *motion, double time, double deceleration, double period, double phase)
{
    const double rate = motion_rate(motion, time), end = time + rate / deceleration;
    double times[MOST_KNOTS], rates[MOST_KNOTS], angle;
    int kept = 0;

    while (kept < motion->count && motion->times[kept] < time)
        kept++;
    if (end >= motion->end || kept == 0 || kept + 2 > motion->knots)
        return;
    memcpy(times, motion->times, (size_t)kept * sizeof(double));
    memcpy(rates, motion->rates, (size_t)kept * sizeof(double));
    times[kept] = time;
    rates[kept] = rate;
    times[kept + 1] = end;
    rates[kept + 1] = 0.0;
    angle = motion->scale * sampled_angle(kept + 2, times, rates, period, phase);
    make(motion->axis, kept + 2, times, rates, motion->knots, angle, motion->scale, motion);
}

double shaped_rate_change(const Motion *motion, const Shaper *shaper, double time, double period)
{
    double change = 0.0;
    int k;

    for (k = 0; k < 3; k++)
        change += shaper->weights[k] * (motion_rate(motion, time + period + shaper->shifts[k]) -
                                        motion_rate(motion, time + shaper->shifts[k]));
    return motion->scale * change;
}
