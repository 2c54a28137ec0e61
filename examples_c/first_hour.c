/*
 * An N-body code before and after: gravity in space with Plummer's softening by a plain loop and by mollis, a leapfrog loop around it, and the fast
 * sum in the plane. The result is 0 if each agrees with a plain loop. docs/first-hour.md shows the parts; first_hour.f90 prints the same lines.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mollis.h"

#define TRY(call)                                                         \
    do {                                                                  \
        const mollis_status code = (call);                                \
        if (code != MOLLIS_OK) {                                          \
            fprintf(stderr, "%s: %s\n", #call, mollis_status_text(code)); \
            exit(1);                                                      \
        }                                                                 \
    } while (0)

static const double pi = 3.14159265358979323846, G = 1;

typedef struct { double x[3], v[3], a[3], mass; } body;

/* Overwrites the accelerations of n bodies. */
static void plain(size_t n, body *b, double eps)
{
    for (size_t i = 0; i < n; i++) {
        double a[3] = {0, 0, 0};
        for (size_t j = 0; j < n; j++) {
            const double dx = b[j].x[0] - b[i].x[0], dy = b[j].x[1] - b[i].x[1], dz = b[j].x[2] - b[i].x[2];
            const double q = dx * dx + dy * dy + dz * dz + eps * eps, f = G * b[j].mass / (q * sqrt(q));
            a[0] += f * dx;
            a[1] += f * dy;
            a[2] += f * dz;
        }
        memcpy(b[i].a, a, sizeof a);
    }
}

/* Moves n bodies with the plain loop: kick, drift, kick. */
static void plain_leapfrog(size_t n, body *b, double eps, double dt, int steps)
{
    plain(n, b, eps);
    for (int step = 0; step < steps; step++) {
        for (size_t i = 0; i < n; i++)
            for (int k = 0; k < 3; k++) {
                b[i].v[k] += dt / 2 * b[i].a[k];
                b[i].x[k] += dt * b[i].v[k];
            }
        plain(n, b, eps);
        for (size_t i = 0; i < n; i++)
            for (int k = 0; k < 3; k++) b[i].v[k] += dt / 2 * b[i].a[k];
    }
}

/* The same by mollis. Without steps it computes the accelerations. */
static void leapfrog(size_t n, body *b, double eps, double dt, int steps)
{
    const mollis_kernel_term newtonian = {.kind = MOLLIS_KERNEL_NEWTONIAN, .coefficient = 4 * pi * G};
    const mollis_mollifier plummer = {.kind = MOLLIS_MOLLIFIER_PLUMMER};
    const size_t stride = sizeof *b / sizeof(double);
    const mollis_sources3 bodies = {.n = n, .positions = {b->x}, .stride = stride, .masses = &b->mass, .mass_stride = stride};
    const mollis_outputs3 outputs = {.gradient = {b->a}, .gradient_stride = stride, .factor = -1};
    size_t kernel_bytes, bytes;
    TRY(mollis_kernel3_bytes(&newtonian, 1, NULL, plummer, &kernel_bytes));
    void *kernel = malloc(kernel_bytes);
    TRY(mollis_kernel3_prepare(kernel, kernel_bytes, &newtonian, 1, NULL, plummer, eps));
    TRY(mollis_field3_workspace_bytes(kernel, kernel_bytes, &bodies, NULL, &outputs, NULL, NULL, &bytes));
    void *workspace = malloc(bytes);
    TRY(mollis_field3_eval(kernel, kernel_bytes, &bodies, NULL, &outputs, NULL, NULL, workspace, bytes, NULL));
    /* Time stepping: kick, drift, kick. The structures point to the arrays, which the program moves. */
    for (int step = 0; step < steps; step++) {
        for (size_t i = 0; i < n; i++)
            for (int k = 0; k < 3; k++) {
                b[i].v[k] += dt / 2 * b[i].a[k];
                b[i].x[k] += dt * b[i].v[k];
            }
        TRY(mollis_field3_eval(kernel, kernel_bytes, &bodies, NULL, &outputs, NULL, NULL, workspace, bytes, NULL));
        for (size_t i = 0; i < n; i++)
            for (int k = 0; k < 3; k++) b[i].v[k] += dt / 2 * b[i].a[k];
    }
    free(workspace);
    free(kernel);
}

/* Gravity in the plane, phi = G m log r, under the compact mollifier of order 2 and exponent 4. Arrays of their own. */
static void plain_plane(size_t n, const double *x, const double *y, const double *mass, double delta, double *ax, double *ay)
{
    for (size_t i = 0; i < n; i++) {
        ax[i] = ay[i] = 0;
        for (size_t j = 0; j < n; j++) {
            const double dx = x[j] - x[i], dy = y[j] - y[i], rr = dx * dx + dy * dy, t = fmax(1 - rr / (delta * delta), 0);
            const double f = rr > 0 ? G * mass[j] * (1 - pow(t, 5)) / rr : 0;
            ax[i] += f * dx;
            ay[i] += f * dy;
        }
    }
}

/* The same by mollis; `text` gets the method. A tolerance of 0 asks for the sum over all pairs. */
static void plane(size_t n, const double *x, const double *y, const double *mass, double delta, double tolerance, double *ax, double *ay,
                  char text[512])
{
    const mollis_kernel_term newtonian = {.kind = MOLLIS_KERNEL_NEWTONIAN, .coefficient = 2 * pi * G};
    const mollis_mollifier compact = {MOLLIS_MOLLIFIER_COMPACT, 2, 4};
    const mollis_sources2 bodies = {.n = n, .positions = {x, y}, .masses = mass};
    const mollis_outputs2 outputs = {.gradient = {ax, ay}, .factor = -1};
    mollis_field_options options;
    TRY(mollis_field_options_init(&options, sizeof options));
    options.tolerance = tolerance;
    size_t kernel_bytes, bytes;
    TRY(mollis_kernel2_bytes(&newtonian, 1, NULL, compact, &kernel_bytes));
    void *kernel = malloc(kernel_bytes);
    TRY(mollis_kernel2_prepare(kernel, kernel_bytes, &newtonian, 1, NULL, compact, delta));
    TRY(mollis_field2_workspace_bytes(kernel, kernel_bytes, &bodies, NULL, &outputs, &options, NULL, &bytes));
    void *workspace = malloc(bytes);
    TRY(mollis_field2_eval(kernel, kernel_bytes, &bodies, NULL, &outputs, &options, NULL, workspace, bytes, NULL));
    TRY(mollis_field2_text(kernel, kernel_bytes, &bodies, NULL, &outputs, &options, text, 512, NULL));
    free(workspace);
    free(kernel);
}

/* Whether n vectors agree up to 10^exponent, in the l2 norm. */
static int agree(const char *what, size_t n, int width, size_t stride, const double *got, const double *want, int exponent)
{
    double apart = 0, all = 0;
    for (size_t i = 0; i < n; i++)
        for (int k = 0; k < width; k++) {
            apart += pow(got[i * stride + k] - want[i * stride + k], 2);
            all += pow(want[i * stride + k], 2);
        }
    apart = sqrt(apart / all);
    if (!(apart < pow(10, exponent))) {
        printf("%s: differs by %.1e\n", what, apart);
        return 0;
    }
    printf("%s: agrees to 1e%d\n", what, exponent);
    return 1;
}

int main(void)
{
    enum { n = 500, many = 2000 };
    static body one[n], two[n];
    static double x[2][many], mass[many], a[3][2 * many];
    const size_t stride = sizeof *one / sizeof(double);
    char text[512];
    int good;
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < 3; k++) one[i].x[k] = fmod((i + 1) * (0.8191725134 - 0.148 * k), 1.0);
        one[i].mass = 1.0 / n;
    }
    memcpy(two, one, sizeof one);
    plain(n, one, 0.05);
    leapfrog(n, two, 0.05, 0.01, 0);
    good = agree("acceleration", n, 3, stride, two->a, one->a, -13);
    plain_leapfrog(n, one, 0.05, 0.01, 20);
    leapfrog(n, two, 0.05, 0.01, 20);
    good &= agree("position after 20 steps", n, 3, stride, two->x, one->x, -13);
    good &= agree("velocity after 20 steps", n, 3, stride, two->v, one->v, -13);

    for (int i = 0; i < many; i++) {
        x[0][i] = fmod((i + 1) * 0.7548776662, 1.0);
        x[1][i] = fmod((i + 1) * 0.5698402910, 1.0);
        mass[i] = 1.0 / many;
    }
    plain_plane(many, x[0], x[1], mass, 0.02, a[0], a[0] + many);
    for (int k = 1; k < 3; k++) {
        plane(many, x[0], x[1], mass, 0.02, k == 1 ? 0 : 1e-6, a[k], a[k] + many, text);
        *strstr(text, " (") = 0;
        good &= agree(text, 2 * many, 1, 1, a[k], a[0], k == 1 ? -13 : -6);
    }
    return good ? 0 : 1;
}
