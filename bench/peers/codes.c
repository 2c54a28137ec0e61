/* Sums as particle codes have them, written plainly: vortex elements in space with a core radius each, gravity with Plummer's softening over an array of structures, and vortices in the plane with Vatistas' core and a
 * core radius each, in single precision. Optimisation is left to the compiler (-O3 -march=native -ffast-math). */
#include <math.h>
#include <stddef.h>

/* 128 bytes: mass, position, velocity, acceleration, and what the code keeps besides. */
struct body {
    double mass, x[3], v[3], a[3], rest[6];
};

void peer_gravity(size_t n, struct body *bodies, double softening)
{
    const double e2 = softening * softening;
    for (size_t i = 0; i < n; i++) {
        const double xi = bodies[i].x[0], yi = bodies[i].x[1], zi = bodies[i].x[2];
        double ax = 0, ay = 0, az = 0;
        for (size_t j = 0; j < n; j++) {
            const double dx = bodies[j].x[0] - xi, dy = bodies[j].x[1] - yi, dz = bodies[j].x[2] - zi;
            const double q = dx * dx + dy * dy + dz * dz + e2;
            const double f = bodies[j].mass / (q * sqrt(q));
            ax += f * dx;
            ay += f * dy;
            az += f * dz;
        }
        bodies[i].a[0] = ax;
        bodies[i].a[1] = ay;
        bodies[i].a[2] = az;
    }
}

/* Velocities times 2 pi. */
void peer_vortices(size_t n, const float *restrict x, const float *restrict y, const float *restrict circulation,
                   const float *restrict radius, float *restrict u, float *restrict v)
{
    for (size_t i = 0; i < n; i++) {
        const float xi = x[i], yi = y[i];
        float su = 0, sv = 0;
        for (size_t j = 0; j < n; j++) {
            const float dx = xi - x[j], dy = yi - y[j], r2 = dx * dx + dy * dy, c2 = radius[j] * radius[j];
            const float f = circulation[j] / sqrtf(r2 * r2 + c2 * c2);
            su -= f * dy;
            sv += f * dx;
        }
        u[i] = su;
        v[i] = sv;
    }
}

/* Velocities of vortex elements times 4 pi: compact core of order 2, M = 2, with a radius each. g is the truncated series of (1 - t)^(-3/2) inside. */
void peer_elements(size_t n, const double *restrict x, const double *restrict y, const double *restrict z,
                   const double *restrict a, const double *restrict b, const double *restrict c,
                   const double *restrict radius, double *restrict u, double *restrict v, double *restrict w)
{
    for (size_t i = 0; i < n; i++) {
        const double xi = x[i], yi = y[i], zi = z[i];
        double su = 0, sv = 0, sw = 0;
        for (size_t j = 0; j < n; j++) {
            const double dx = xi - x[j], dy = yi - y[j], dz = zi - z[j], r2 = dx * dx + dy * dy + dz * dz;
            const double per = 1.0 / (radius[j] * radius[j]), t = 1.0 - r2 * per;
            const double near = per / radius[j] * (1.0 + t * (1.5 + t * 1.875));
            const double g = r2 < radius[j] * radius[j] ? near : 1.0 / (r2 * sqrt(r2));
            su += g * (dy * c[j] - dz * b[j]);
            sv += g * (dz * a[j] - dx * c[j]);
            sw += g * (dx * b[j] - dy * a[j]);
        }
        u[i] = su;
        v[i] = sv;
        w[i] = sw;
    }
}
