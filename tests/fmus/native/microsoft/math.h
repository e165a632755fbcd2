/* What the C files use of Microsoft's math.h, declared as there: no M_PI, INFINITY is a float. */
#ifndef MICROSOFT_MATH_H
#define MICROSOFT_MATH_H

#define INFINITY ((float)(1e+300 * 1e+300))
#define NAN (-(float)(INFINITY * 0.0F))

short __cdecl _dclass(double x);
#define isfinite(x) (_dclass(x) <= 0)

double __cdecl acos(double x);
double __cdecl asin(double x);
double __cdecl atan2(double y, double x);
double __cdecl cbrt(double x);
double __cdecl ceil(double x);
double __cdecl copysign(double x, double sign);
double __cdecl cos(double x);
double __cdecl exp(double x);
double __cdecl expm1(double x);
double __cdecl fabs(double x);
double __cdecl floor(double x);
double __cdecl fmax(double x, double y);
double __cdecl fmin(double x, double y);
double __cdecl fmod(double x, double y);
double __cdecl frexp(double x, int *exponent);
double __cdecl hypot(double x, double y);
double __cdecl ldexp(double x, int exponent);
double __cdecl log(double x);
double __cdecl log1p(double x);
double __cdecl log2(double x);
double __cdecl nan(const char *text);
double __cdecl pow(double x, double y);
double __cdecl rint(double x);
double __cdecl sin(double x);
double __cdecl sqrt(double x);
double __cdecl tan(double x);
float __cdecl floorf(float x);

#endif
