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
        return motion->turned[0];
    if (time >= motion->times[last])
        return motion->turned[last];
    k = knot_before(motion, time);
    return motion->turned[k] + 0.5 * (time - motion->times[k]) * (motion->rates[k] + motion_rate(motion, time));
}

/* Write the knots that follow others, and integrate from the angle `first`; what else a motion is, is given. */
static void set_knots(int count, const double *times, const double *rates, double first, Motion *motion)
{
    int k, kept = 0;

    memset(motion->times, 0, sizeof motion->times);
    memset(motion->rates, 0, sizeof motion->rates);
    memset(motion->turned, 0, sizeof motion->turned);
    motion->start = times[0];
    motion->end = times[count - 1];
    for (k = 0; k < count; k++) {
        if (k > 0 && !(times[k] - times[k - 1] > 0.0)) /* a triangle has no coast */
            continue;
        motion->times[kept] = times[k];
        motion->rates[kept] = rates[k];
        kept++;
    }
    motion->turned[0] = first;
    for (k = 1; k < kept; k++)
        motion->turned[k] = motion->turned[k - 1] + 0.5 * (motion->rates[k] + motion->rates[k - 1]) *
                                                        (motion->times[k] - motion->times[k - 1]);
    motion->count = kept;
}

/* The angle under straight lines between samples of the rate. */
static double sampled_angle(int count, const double *times, const double *rates, const Sampling *sampling)
{
    const double period = sampling->period, phase = sampling->phase;
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
    const double rates[2] = {0.0, 0.0}, times[2] = {start, start + 1.0};

    memset(motion, 0, sizeof *motion);
    motion->axis[0] = 1.0;
    motion->scale = 1.0;
    motion->knots = knots;
    set_knots(2, times, rates, 0.0, motion);
}

void motion_from_profile(const Profile *profile, int knots, const Sampling *sampling, int allocation, Motion *motion)
{
    const double start = profile->start;
    const double times[4] = {start, start + profile->ramp, start + (profile->ramp + profile->coast),
                             start + (profile_end(profile) - start)};
    const double rates[4] = {0.0, profile->coast_rate, profile->coast_rate, 0.0};

    motion_from_knots(profile, 4, times, rates, knots, sampling, allocation, motion);
}

void motion_from_knots(const Profile *profile, int count, const double *times, const double *rates, int knots,
                       const Sampling *sampling, int allocation, Motion *motion)
{
    const double turned = sampled_angle(count, times, rates, sampling);

    memset(motion, 0, sizeof *motion);
    memcpy(motion->axis, profile->axis, sizeof motion->axis);
    motion->angle = profile->angle;
    motion->scale = turned > 0.0 ? profile->angle / turned : 1.0;
    motion->allocation = allocation;
    motion->knots = knots;
    set_knots(count, times, rates, 0.0, motion);
}

/* The knots of a motion that a change at `time` leaves: of those that end earlier than its memory only the angle
stays, which is added to `before`. Returns how many there are. */
static int knots_left(const Motion *motion, double time, const Sampling *sampling, double *times, double *rates,
                      double *before)
{
    const double cut = time - sampling->memory;
    int first = 0, kept = 0;

    if (cut > motion->times[0]) {
        while (first < motion->count && motion->times[first] < cut)
            first++;
        memcpy(times, motion->times, (size_t)first * sizeof(double));
        memcpy(rates, motion->rates, (size_t)first * sizeof(double));
        times[first] = cut;
        rates[first] = motion_rate(motion, cut);
        *before += sampled_angle(first + 1, times, rates, sampling);
        rates[0] = rates[first];
        times[0] = cut;
        kept = 1;
        while (first < motion->count && motion->times[first] <= cut)
            first++;
    }
    for (; first < motion->count && motion->times[first] < time; first++, kept++) {
        times[kept] = motion->times[first];
        rates[kept] = motion->rates[first];
    }
    return kept;
}

/* Spread over the new knots what held torques turn more than the rates, and rounding: it ends at an angle [rad]. */
static void end_at(const Motion *motion, double angle, double before, int begin, int count, const double *times,
                   double *rates, const Sampling *sampling)
{
    const double time = times[begin], last = times[count - 1] - time;
    double more[MOST_KNOTS] = {0.0}, missing;
    int k;

    for (k = begin; k < count; k++)
        more[k] = (times[k] - time) * (last - (times[k] - time));
    missing = angle / motion->scale - before - sampled_angle(count, times, rates, sampling);
    missing /= sampled_angle(count, times, more, sampling);
    for (k = begin; k < count; k++)
        rates[k] += more[k] * missing;
}

int motion_continue(Motion *motion, double time, int count, const double *since, const double *rates,
                    const double *angle, const Sampling *sampling)
{
    double times[MOST_KNOTS + 1], flown[MOST_KNOTS + 1], before = motion->before, start = motion->start, first, at;
    double last;
    const int begin = knots_left(motion, time, sampling, times, flown, &before);
    int k;

    if (begin == 0 || begin + count > motion->knots)
        return 0;
    first = motion_rotation(motion, times[0]);
    for (k = 0; k < count; k++) {
        times[begin + k] = time + since[k];
        flown[begin + k] = rates[k];
    }
    if (angle != NULL)
        end_at(motion, *angle, before, begin, begin + count, times, flown, sampling);
    motion->before = before;
    motion->angle =
        angle != NULL ? *angle : motion->scale * (before + sampled_angle(begin + count, times, flown, sampling));
    set_knots(begin + count, times, flown, first, motion);
    motion->start = start;
    /* what is turned ends where held torques do: the difference is spread over the new knots */
    at = motion_rotation(motion, time);
    last = motion->turned[motion->count - 1];
    for (k = 0; k < motion->count && last > at; k++)
        if (motion->times[k] > time)
            motion->turned[k] += (motion->angle - last) * (motion->turned[k] - at) / (last - at);
    return 1;
}

void motion_stop(Motion *motion, double time, double deceleration, const Sampling *sampling)
{
    const double rate = motion_rate(motion, time), since[2] = {0.0, rate / deceleration}, rates[2] = {rate, 0.0};

    if (time + since[1] < motion->end)
        motion_continue(motion, time, 2, since, rates, NULL, sampling);
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
