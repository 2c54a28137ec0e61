/* The direct sum as a competent user writes it in C: structure of arrays, no branch in the inner loop. Optimisation is left
 * to the compiler (-O3 -march=native -ffast-math). Newtonian kernel, compact mollifier of order 2, M = 4. Inside delta the
 * gradient factor is the truncated series of (1-t)^(-D/2) in powers of t = 1 - (r/delta)^2; outside it is 1/r^D. */
#include <math.h>
#include <stddef.h>

/* g = sum_j m_j x / r^2. The caller multiplies by 1 / (2 pi). */
void peer_gradient2(size_t n, const double *restrict x, const double *restrict y, const double *restrict m, size_t k,
                    const double *restrict tx, const double *restrict ty, double delta, double *restrict gx,
                    double *restrict gy)
{
    const double d2 = delta * delta, per = 1.0 / d2;
    for (size_t i = 0; i < k; i++) {
        const double xi = tx[i], yi = ty[i];
        double sx = 0, sy = 0;
        for (size_t j = 0; j < n; j++) {
            const double dx = xi - x[j], dy = yi - y[j], r2 = dx * dx + dy * dy;
            const double t = 1.0 - r2 * per;
            const double near = per * (1.0 + t * (1.0 + t * (1.0 + t * (1.0 + t))));
            const double f = m[j] * (r2 < d2 ? near : 1.0 / r2);
            sx += f * dx;
            sy += f * dy;
        }
        gx[i] = sx;
        gy[i] = sy;
    }
}

void peer_gradient3(size_t n, const double *restrict x, const double *restrict y, const double *restrict z,
                    const double *restrict m, size_t k, const double *restrict tx, const double *restrict ty,
                    const double *restrict tz, double delta, double *restrict gx, double *restrict gy,
                    double *restrict gz)
{
    const double d2 = delta * delta, per = 1.0 / d2, per3 = per / delta;
    for (size_t i = 0; i < k; i++) {
        const double xi = tx[i], yi = ty[i], zi = tz[i];
        double sx = 0, sy = 0, sz = 0;
        for (size_t j = 0; j < n; j++) {
            const double dx = xi - x[j], dy = yi - y[j], dz = zi - z[j], r2 = dx * dx + dy * dy + dz * dz;
            const double t = 1.0 - r2 * per;
            const double near =
                per3 * (1.0 + t * (1.5 + t * (15.0 / 8 + t * (35.0 / 16 + t * (315.0 / 128)))));
            const double f = m[j] * (r2 < d2 ? near : 1.0 / (r2 * sqrt(r2)));
            sx += f * dx;
            sy += f * dy;
            sz += f * dz;
        }
        gx[i] = sx;
        gy[i] = sy;
        gz[i] = sz;
    }
}

/* The same as peer_gradient2, and p = sum_j m_j log r^2 / 2 outside delta. */
void peer_both2(size_t n, const double *restrict x, const double *restrict y, const double *restrict m, size_t k,
                const double *restrict tx, const double *restrict ty, double delta, double *restrict p,
                double *restrict gx, double *restrict gy)
{
    const double d2 = delta * delta, per = 1.0 / d2, edge = log(delta);
    for (size_t i = 0; i < k; i++) {
        const double xi = tx[i], yi = ty[i];
        double s = 0, sx = 0, sy = 0;
        for (size_t j = 0; j < n; j++) {
            const double dx = xi - x[j], dy = yi - y[j], r2 = dx * dx + dy * dy;
            double f, u;
            if (r2 < d2) {
                const double t = 1.0 - r2 * per;
                f = per * (1.0 + t * (1.0 + t * (1.0 + t * (1.0 + t))));
                u = edge - 0.5 * t * (1.0 + t * (1.0 / 2 + t * (1.0 / 3 + t * (1.0 / 4 + t * (1.0 / 5)))));
            } else {
                f = 1.0 / r2;
                u = 0.5 * log(r2);
            }
            s += m[j] * u;
            sx += m[j] * f * dx;
            sy += m[j] * f * dy;
        }
        p[i] = s;
        gx[i] = sx;
        gy[i] = sy;
    }
}
