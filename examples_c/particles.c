/*
 * Four uses of mollis from C: the velocities of vortices that are an array of structures, steps of vortices and of blobs that attract each
 * other, and coalescing particles with a random generator of the program's own. The result is 0 if what is known of each holds.
 *
 * At the portable level every machine computes the same bits, and particles.cpp, particles.f90 and this program print the same lines.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mollis.h"

typedef struct {
    double x[2], circulation, core, velocity[2];
} vortex;

/* A prepared kernel. */
typedef struct {
    void *start;
    size_t bytes;
} kernel;

static mollis_run run;

static void check(mollis_status status, const char *what)
{
    if (status != MOLLIS_OK) {
        fprintf(stderr, "%s: %s\n", what, mollis_status_text(status));
        exit(1);
    }
}

static void *memory(size_t bytes)
{
    void *start = malloc(bytes);
    if (start == NULL) {
        fprintf(stderr, "out of memory\n");
        exit(1);
    }
    return start;
}

/* Marsaglia's xorshift, as a stream of words. */
static int32_t xorshift(void *state, uint64_t *words, size_t n)
{
    uint64_t x = *(uint64_t *)state;
    size_t k;
    for (k = 0; k < n; k++) {
        x ^= x << 13;
        x ^= x >> 7;
        x ^= x << 17;
        words[k] = x;
    }
    *(uint64_t *)state = x;
    return 0;
}

/* n points without a pattern. */
static void places(int n, double (*x)[2])
{
    int k;
    for (k = 1; k <= n; k++) {
        x[k - 1][0] = (37 * k % 101 - 50) / 64.0;
        x[k - 1][1] = (53 * k % 103 - 51) / 64.0;
    }
}

/* A Newtonian kernel. */
static kernel newtonian(mollis_mollifier mollifier, double delta)
{
    const mollis_kernel_term term = {MOLLIS_KERNEL_NEWTONIAN, 0, 1.0, {0.0, 0.0}};
    kernel made;
    check(mollis_kernel2_bytes(&term, 1, NULL, mollifier, &made.bytes), "kernel size");
    made.start = memory(made.bytes);
    check(mollis_kernel2_prepare(made.start, made.bytes, &term, 1, NULL, mollifier, delta), "kernel");
    return made;
}

/* Two equal vortices with the core of Vatistas turn about each other with speed g d / (2 pi (d^4 + core^4)^(1/2)), d being their distance. The
 * array is read and written where it is. */
static int vortices(void)
{
    vortex v[2] = {{{0.0, 0.0}, 2.0, 0.1, {0.0, 0.0}}, {{0.5, 0.0}, 2.0, 0.2, {0.0, 0.0}}};
    const mollis_mollifier vatistas = {MOLLIS_MOLLIFIER_VATISTAS, 0, 0};
    const kernel by = newtonian(vatistas, 0.1);
    const size_t stride = sizeof *v / sizeof(double);
    const double known = 2.0 * 0.5 / (2 * acos(-1.0) * sqrt(pow(0.5, 4) + pow(0.1, 4)));
    mollis_sources2 sources = {0};
    mollis_outputs2 outputs = {0};
    mollis_field_options options;
    size_t bytes;
    void *workspace;
    sources.n = 2;
    sources.positions[0] = v->x;
    sources.masses = &v->circulation;
    sources.radii = &v->core;
    outputs.gradient[0] = v->velocity;
    sources.stride = sources.mass_stride = sources.radius_stride = outputs.gradient_stride = stride;
    check(mollis_field_options_init(&options, sizeof options), "options");
    options.combination[0] = 0;
    options.combination[1] = 1;
    check(mollis_field2_workspace_bytes(by.start, by.bytes, &sources, NULL, &outputs, &options, &run, &bytes), "size");
    workspace = memory(bytes);
    check(mollis_field2_eval(by.start, by.bytes, &sources, NULL, &outputs, &options, &run, workspace, bytes, NULL), "field");
    free(workspace);
    free(by.start);
    printf("vortices: velocity%24.16E%24.16E\n", v[1].velocity[0], v[1].velocity[1]);
    return fabs(v[1].velocity[1] - known) < 1e-15 && fabs(v[1].velocity[0]) < 1e-15;
}

/* Two equal vortices at the distance d turn about their centre at the rate g / (pi d^2), counter-clockwise, in steps of the blob method. Its velocity is minus the
 * gradient output of a sum, so the combination is (0, -1). */
static int turning(void)
{
    double x[2][2] = {{0.25, 0.0}, {-0.25, 0.0}};
    const double circulation[2] = {2.0, 2.0}, quarter = acos(-1.0) * acos(-1.0) / 16;
    const mollis_mollifier compact = {MOLLIS_MOLLIFIER_COMPACT, 4, 5};
    const kernel by = newtonian(compact, 0.1);
    mollis_particles2 particles = {0};
    mollis_blob_options options;
    mollis_blob_report report;
    size_t bytes;
    void *workspace;
    particles.n = 2;
    particles.positions[0] = x[0];
    particles.masses = circulation;
    check(mollis_blob_options_init(&options, sizeof options), "options");
    options.combination[0] = 0;
    options.combination[1] = -1;
    check(mollis_blob2_workspace_bytes(by.start, by.bytes, &particles, NULL, &options, &run, &bytes), "size");
    workspace = memory(bytes);
    check(mollis_blob2_step(by.start, by.bytes, &particles, NULL, quarter / 50, 50, &options, &run, workspace, bytes, &report), "step");
    free(workspace);
    free(by.start);
    printf("a quarter of a turn: the first at%24.16E%24.16E\n", x[0][0], x[0][1]);
    return report.steps == 50 && fabs(x[0][0]) < 1e-7 && fabs(x[0][1] - 0.25) < 1e-7;
}

/* Blobs that attract each other keep their centre of mass. */
static int blobs(void)
{
    enum { n = 128 };
    static double x[n][2], mass[n];
    const mollis_mollifier compact = {MOLLIS_MOLLIFIER_COMPACT, 4, 5};
    const kernel by = newtonian(compact, 0.3);
    mollis_particles2 particles = {0};
    mollis_blob_report report;
    double before[2], after[2];
    size_t bytes, k;
    void *workspace;
    places(n, x);
    for (k = 0; k < n; k++) mass[k] = 1.0 / n;
    check(mollis_moments2(n, (const double(*)[2])x, mass, NULL, NULL, &before, NULL), "moments");
    particles.n = n;
    particles.positions[0] = x[0];
    particles.masses = mass;
    check(mollis_blob2_workspace_bytes(by.start, by.bytes, &particles, NULL, NULL, &run, &bytes), "size");
    workspace = memory(bytes);
    check(mollis_blob2_step(by.start, by.bytes, &particles, NULL, 0.01, 20, NULL, &run, workspace, bytes, &report), "step");
    check(mollis_moments2(n, (const double(*)[2])x, mass, NULL, NULL, &after, NULL), "moments");
    free(workspace);
    free(by.start);
    printf("blobs after %d steps: the last at%24.16E%24.16E\n", (int)report.steps, x[n - 1][0], x[n - 1][1]);
    return report.steps == 20 && fabs(after[0] - before[0]) < 1e-15 && fabs(after[1] - before[1]) < 1e-15;
}

/* Particles merge, and mass is lost by rounding alone. */
static int coalescence(void)
{
    enum { n = 200 };
    static double x[n][2], mass[n];
    static uint64_t labels[n], absorbed[n];
    static mollis_pks_event merges[n];
    const mollis_mollifier compact = {MOLLIS_MOLLIFIER_COMPACT, 2, 4};
    const kernel by = newtonian(compact, 0.01);
    uint64_t state = UINT64_C(88172645463325252);
    mollis_pks_particles particles = {0};
    mollis_pks_progress progress = {0};
    mollis_pks_attraction attraction = {0};
    mollis_pks_events events = {0};
    mollis_generator generator;
    mollis_pks_options options;
    double total = 0;
    size_t bytes, k;
    void *workspace;
    places(n, x);
    for (k = 0; k < n; k++) {
        mass[k] = 0.125;
        labels[k] = k + 1;
    }
    particles.room = n;
    particles.positions = x;
    particles.masses = mass;
    particles.labels = labels;
    progress.count = n;
    attraction.kind = MOLLIS_PKS_ATTRACTION_SUM;
    attraction.kernel = by.start;
    attraction.kernel_bytes = by.bytes;
    events.events = merges;
    events.room = n;
    events.labels = absorbed;
    events.labels_room = n;
    generator.state = &state;
    generator.fill = xorshift;
    check(mollis_pks_options_init(&options, sizeof options), "options");
    options.chi = 3;
    options.noise = 0.125;
    check(mollis_pks_workspace_bytes(n, &attraction, &options, &run, &bytes), "size");
    workspace = memory(bytes);
    check(mollis_pks_step(&particles, &progress, &attraction, &generator, 1e-3, 20, &events, &options, &run, workspace, bytes, NULL),
          "step");
    free(workspace);
    free(by.start);
    for (k = 0; k < progress.count; k++) total += mass[k];
    printf("coalescing: %d particles left after %d merges, mass %12.9f, the last at%24.16E%24.16E\n", (int)progress.count,
           (int)events.written, total, x[progress.count - 1][0], x[progress.count - 1][1]);
    return progress.count + events.labels_written == n && fabs(total - 0.125 * n) < 1e-12 && events.written > 0;
}

int main(void)
{
    int good;
    check(mollis_run_init(&run, sizeof run), "run");
    run.level = MOLLIS_LEVEL_PORTABLE;
    good = vortices();
    good = turning() && good;
    good = blobs() && good;
    good = coalescence() && good;
    return good ? 0 : 1;
}
