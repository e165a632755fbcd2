#include "periods.h"

#include <math.h>

int64_t whole_multiple(double period, double step)
{
    const double count = rint(period / step);

    if (!(count >= 1.0 && count < 0x1p53) || fabs(count * step - period) > 1e-6 * step)
        return 0;
    return (int64_t)count;
}
