/* Environment of a circular orbit: the twin of runtime/missions/environment.py, which documents it. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "number_text.h"
#include "plain_component.h"
#include "ports.h"
#include "vectors.h"

#define EARTH 3.986004418e14   /* m3/s2 */
#define EARTH_RADIUS 6.3781370e6 /* m, of the shadow */
#define FIELD_RADIUS 6.3712e6  /* m */

typedef struct PreparedEnvironment {
    double radius, rate, argument; /* m, rad/s, rad */
    double towards_node[3], along_orbit[3];
    double gradient; /* 1/s2 */
    double field;    /* T */
    double sun[3], normal[3], pole[3];
} PreparedEnvironment;

/* Direction cosines, body from inertial, of a quaternion whose norm may not be one exactly. */
static void direction_cosines(const double *quaternion, double matrix[3][3])
{
    double norm = 0.0, q[4];
    int k;

    for (k = 0; k < 4; k++)
        norm += quaternion[k] * quaternion[k];
    norm = sqrt(norm);
    for (k = 0; k < 4; k++)
        q[k] = quaternion[k] / norm;
    matrix[0][0] = 1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2]);
    matrix[1][1] = 1.0 - 2.0 * (q[0] * q[0] + q[2] * q[2]);
    matrix[2][2] = 1.0 - 2.0 * (q[0] * q[0] + q[1] * q[1]);
    matrix[0][1] = 2.0 * (q[0] * q[1] + q[3] * q[2]);
    matrix[1][0] = 2.0 * (q[0] * q[1] - q[3] * q[2]);
    matrix[0][2] = 2.0 * (q[0] * q[2] - q[3] * q[1]);
    matrix[2][0] = 2.0 * (q[0] * q[2] + q[3] * q[1]);
    matrix[1][2] = 2.0 * (q[1] * q[2] + q[3] * q[0]);
    matrix[2][1] = 2.0 * (q[1] * q[2] - q[3] * q[0]);
}

static int unit(Component *component, int place, const char *name, double direction[3])
{
    const double *given = component->real + place;
    const double length = sqrt(dot3(given, given));
    char x[NUMBER_SIZE], y[NUMBER_SIZE], z[NUMBER_SIZE];
    int k;

    if (!(length > 1e-6))
        return refuse(component, "%s must be a direction, got (%s, %s, %s)", name, number_text(given[0], x),
                      number_text(given[1], y), number_text(given[2], z));
    for (k = 0; k < 3; k++)
        direction[k] = given[k] / length;
    return 0;
}

/* Force of sunlight from a direction, body axes, on a plate that is lit on either side. */
static void plate_force(const double *real, const PreparedEnvironment *prepared, const double sun[3], double force[3])
{
    const double cosine = dot3(prepared->normal, sun), side = cosine >= 0.0 ? 1.0 : -1.0, size = fabs(cosine);
    const double specular = real[PORT_SOLAR_SPECULAR], along_sun = 1.0 - specular;
    const double along_normal = 2.0 * (specular * size + real[PORT_SOLAR_DIFFUSE] / 3.0);
    const double scale = -real[PORT_SOLAR_PRESSURE] * real[PORT_SOLAR_AREA] * size;
    int k;

    for (k = 0; k < 3; k++)
        force[k] = scale * (along_sun * sun[k] + along_normal * side * prepared->normal[k]);
}

static void act(Component *component, double time)
{
    const PreparedEnvironment *prepared = component->own;
    double *real = component->real;
    const double angle = prepared->argument + prepared->rate * time;
    double body[3][3], outward[3], nadir[3], moment[3], field[3], sun[3], towards_sun, towards_pole, aside;
    double *gravity = real + PORT_GRAVITY_GRADIENT_TORQUE, *light = real + PORT_SOLAR_FORCE;
    int k, sunlit;

    direction_cosines(real + PORT_ATTITUDE_QUATERNION, body);
    for (k = 0; k < 3; k++)
        outward[k] = cos(angle) * prepared->towards_node[k] + sin(angle) * prepared->along_orbit[k];
    times3(body[0], outward, nadir);
    for (k = 0; k < 3; k++)
        moment[k] = dot3(real + PORT_GRAVITY_GRADIENT_INERTIA + 3 * k, nadir);
    cross3(nadir, moment, gravity);

    towards_pole = dot3(prepared->pole, outward);
    for (k = 0; k < 3; k++) {
        gravity[k] *= prepared->gradient;
        field[k] = prepared->field * (prepared->pole[k] - 3.0 * towards_pole * outward[k]);
        real[PORT_MAGNETIC_FIELD + k] = field[k];
        real[PORT_ORBIT_POSITION + k] = prepared->radius * outward[k];
    }
    times3(body[0], real + PORT_MAGNETIC_FIELD, field);
    cross3(real + PORT_MAGNETIC_RESIDUAL_DIPOLE, field, real + PORT_MAGNETIC_TORQUE);

    towards_sun = dot3(outward, prepared->sun);
    aside = prepared->radius * sqrt(fmax(0.0, 1.0 - towards_sun * towards_sun));
    sunlit = !(component->boolean[PORT_SOLAR_SHADOW] && towards_sun < 0.0 && aside < EARTH_RADIUS);
    component->boolean[PORT_SOLAR_LIT] = sunlit;
    times3(body[0], prepared->sun, sun);
    memset(light, 0, 3 * sizeof(double));
    if (sunlit)
        plate_force(real, prepared, sun, light);
    cross3(real + PORT_SOLAR_CENTRE_OF_PRESSURE, light, real + PORT_SOLAR_TORQUE);
    for (k = 0; k < 3; k++) {
        real[PORT_EXTERNAL_FORCE + k] = light[k] + real[PORT_CONSTANT_FORCE + k];
        real[PORT_EXTERNAL_TORQUE + k] = real[PORT_SOLAR_TORQUE + k] + gravity[k] + real[PORT_MAGNETIC_TORQUE + k]
                                         + real[PORT_CONSTANT_TORQUE + k];
    }
}

int component_start(Component *component)
{
    const double *real = component->real;
    PreparedEnvironment *prepared;
    const double node = real[PORT_ORBIT_NODE], tilt = real[PORT_ORBIT_INCLINATION], radius = real[PORT_ORBIT_RADIUS];
    char text[NUMBER_SIZE], other[NUMBER_SIZE];

    if (take_component_memory(component, sizeof *prepared, 0)) /* nothing is remembered between steps */
        return 1;
    prepared = component->own;
    if (!(radius > EARTH_RADIUS))
        return refuse(component, "orbit.radius must be > %.7g m, the Earth's, got %s", EARTH_RADIUS,
                      number_text(radius, text));
    if (unit(component, PORT_SOLAR_SUN_DIRECTION, "solar.sun_direction", prepared->sun)
        || unit(component, PORT_SOLAR_NORMAL, "solar.normal", prepared->normal)
        || unit(component, PORT_MAGNETIC_DIPOLE_AXIS, "magnetic.dipole_axis", prepared->pole))
        return 1;
    if (!(real[PORT_SOLAR_SPECULAR] + real[PORT_SOLAR_DIFFUSE] <= 1.0 + 1e-12))
        return refuse(component, "solar.specular + solar.diffuse must be at most 1, got %s + %s",
                      number_text(real[PORT_SOLAR_SPECULAR], text), number_text(real[PORT_SOLAR_DIFFUSE], other));
    prepared->radius = radius;
    prepared->rate = sqrt(EARTH / (radius * radius * radius));
    prepared->argument = real[PORT_ORBIT_ARGUMENT];
    prepared->towards_node[0] = cos(node);
    prepared->towards_node[1] = sin(node);
    prepared->along_orbit[0] = -sin(node) * cos(tilt);
    prepared->along_orbit[1] = cos(node) * cos(tilt);
    prepared->along_orbit[2] = sin(tilt);
    prepared->gradient = component->boolean[PORT_GRAVITY_GRADIENT_ENABLED] ? 3.0 * prepared->rate * prepared->rate : 0.0;
    prepared->field = real[PORT_MAGNETIC_EQUATORIAL_FIELD] * pow(FIELD_RADIUS / radius, 3.0);
    act(component, component->start_time);
    return 0;
}

/* Sample the attitude now; the outputs hold from now on. */
int component_advance(Component *component, double time, double step)
{
    (void)step;
    act(component, time);
    return 0;
}

int component_first_step(Component *component, double length)
{
    (void)component;
    (void)length;
    return 0;
}

int component_restored(Component *component)
{
    (void)component;
    return 0;
}
