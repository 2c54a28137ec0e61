/*
 * Two bumps of supercritical mass collapse to points, which then fall towards each other (Zhelezov & Fatkullin, Section 5.2.2): particles on
 * a mesh, with random numbers of the host's own.
 *
 * In units of the critical mass 8 pi the bumps hold 2.4 and 5.6. Once they are points, the second moment falls with the slope
 * -32 (1 - 0.3^2 - 0.7^2) = -13.44, until they meet.
 *
 * usage: pks [particles [cells]]
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mollis.h"

#define PI 3.14159265358979323846

static void check(mollis_status status, const char *what) {
    if (status != 0) {
        fprintf(stderr, "%s: %s\n", what, mollis_status_text(status));
        exit(1);
    }
}

/* The host's generator: xorshift64*, one stream. */
static int32_t fill(void *state, uint64_t *out, size_t n) {
    uint64_t x = *(uint64_t *)state;
    for (size_t i = 0; i < n; ++i) {
        x ^= x >> 12;
        x ^= x << 25;
        x ^= x >> 27;
        out[i] = x * UINT64_C(2685821657736338717);
    }
    *(uint64_t *)state = x;
    return 0;
}

static double uniform(uint64_t *state) {
    uint64_t word;
    fill(state, &word, 1);
    return (double)(word >> 11) / 9007199254740992.0;
}

/* A point of the unit disc with density exp(1 / (|x|^2 - 1)). */
static void bump(uint64_t *state, double x[2]) {
    double square;
    do {
        x[0] = 2 * uniform(state) - 1;
        x[1] = 2 * uniform(state) - 1;
        square = x[0] * x[0] + x[1] * x[1];
    } while (square >= 1 || uniform(state) >= exp(1 + 1 / (square - 1)));
}

/* Second moment about the centre of mass, divided by the mass; the two largest masses. */
static double moment(size_t n, const double (*x)[2], const double *m, double largest[2]) {
    double mass = 0, centre[2] = {0, 0}, sum = 0;
    largest[0] = largest[1] = 0;
    for (size_t i = 0; i < n; ++i) {
        mass += m[i];
        centre[0] += m[i] * x[i][0];
        centre[1] += m[i] * x[i][1];
        if (m[i] > largest[0]) {
            largest[1] = largest[0];
            largest[0] = m[i];
        } else if (m[i] > largest[1]) {
            largest[1] = m[i];
        }
    }
    for (size_t i = 0; i < n; ++i) {
        double dx = x[i][0] - centre[0] / mass, dy = x[i][1] - centre[1] / mass;
        sum += m[i] * (dx * dx + dy * dy);
    }
    return sum / mass;
}

int main(int argc, char **argv) {
    size_t n = argc > 1 ? strtoul(argv[1], NULL, 10) : 2000;
    size_t cells = argc > 2 ? strtoul(argv[2], NULL, 10) : 64;
    const double critical = 8 * PI, mass = 8 * critical, dt = 0.002;
    const size_t first = (size_t)(0.3 * (double)n);
    uint64_t random = UINT64_C(0x9E3779B97F4A7C15);

    /* The state: plain arrays, and progress. */
    double(*x)[2] = malloc(n * sizeof *x);
    double *m = malloc(n * sizeof *m);
    uint64_t *labels = malloc(n * sizeof *labels);
    mollis_pks_particles particles = {n, x, m, labels, NULL, NULL};
    mollis_pks_progress progress = {0, 0, 0, 0};
    mollis_pks_event log[64];
    mollis_pks_events events = {0};
    if (n == 0 || !x || !m || !labels) return 1;
    for (size_t i = 0; i < n; ++i) {
        bump(&random, x[i]);
        x[i][0] += i < first ? 3 : -3;
        x[i][1] += i < first ? 1 : -1;
        m[i] = mass / (double)n;
        labels[i] = i;
    }
    progress.count = n;
    events.events = log;
    events.room = sizeof log / sizeof *log;
    events.labels = malloc(n * sizeof *events.labels);
    events.labels_room = n;
    if (!events.labels) return 1;

    mollis_pks_options options;
    check(mollis_pks_options_init(&options, sizeof options), "options");
    options.chi = 1;
    options.noise = mass / (double)n; /* mu~ = mu M / N, mu = 1 */
    mollis_mesh2 mesh = {{-15, -15}, {15, 15}, {cells, cells}};
    mollis_pks_attraction attraction;
    memset(&attraction, 0, sizeof attraction);
    attraction.kind = MOLLIS_PKS_ATTRACTION_MESH;
    attraction.mesh = &mesh;
    mollis_generator generator = {&random, fill};

    size_t bytes;
    check(mollis_pks_workspace_bytes(n, &attraction, &options, NULL, &bytes), "size");
    void *workspace = malloc(bytes);
    if (!workspace) return 1;

    size_t merges = 0, absorbed = 0;
    double largest[2], from[2] = {0, 0}, last[2] = {0, 0};
    for (int step = 0; step < 400; ++step) {
        mollis_status status;
        do {
            status = mollis_pks_step(&particles, &progress, &attraction, &generator, dt, 1, &events, &options, NULL, workspace,
                                     bytes, NULL);
            merges += events.written;
            absorbed += events.labels_written;
            events.written = events.labels_written = 0;
        } while (status == MOLLIS_ERR_EVENTS_FULL);
        check(status, "step");
        double second = moment(progress.count, (const double(*)[2])x, m, largest);
        if (step % 50 == 49)
            printf("t %.3f: %zu particles, the two largest hold %.3f and %.3f critical masses, second moment %.3f\n",
                   progress.time, (size_t)progress.count, largest[0] / critical, largest[1] / critical, second);
        if (largest[0] > 0.9 * mass) {
            printf("merged\n");
            break;
        }
        if (largest[0] + largest[1] > 0.99 * mass) {
            if (from[0] == 0) {
                from[0] = progress.time;
                from[1] = second;
            }
            last[0] = progress.time;
            last[1] = second;
        }
    }
    if (last[0] > from[0])
        printf("slope of the second moment between t = %.3f and %.3f: %.2f\n", from[0], last[0],
               (last[1] - from[1]) / (last[0] - from[0]));

    /* What was lost is in the log, and nothing else is lost. */
    double total = 0, heavy[2] = {0.3 * mass, 0.7 * mass};
    for (size_t i = 0; i < progress.count; ++i) total += m[i];
    mollis_pks_prediction prediction;
    check(mollis_pks_predict(mass, 1, 1, 9 * mass, 2, heavy, &prediction), "prediction");
    printf("theory: %.2f\n", prediction.second_moment_rate);
    int whole = absorbed + progress.count == n && fabs(total / mass - 1) < 1e-12 && merges > 0;
    printf("%s\n", whole ? "mass and labels are conserved" : "LOST");
    free(x);
    free(m);
    free(labels);
    free(events.labels);
    free(workspace);
    return whole ? 0 : 1;
}
