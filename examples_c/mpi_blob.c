/*
 * The blob method for the aggregation equation on the ranks of MPI; each rank calls the library as a program alone does.
 *
 *   mpirun -n 4 mpi_blob [n [steps [tolerance [delta]]]]       2000, 10, 0 and 4 h^0.9 if not given
 *
 * rho_0(x) = (1 - |x|^2)^2 on the about n points of the lattice h Z^2 in the unit disc, K the attractive Newtonian kernel
 * under the compact mollifier of order 4, to t = 0.5 by RK4. A tolerance of 0 asks for sums over all pairs; with one of 1e-6
 * the library takes the fast multipole method where that is faster.
 *
 * Each rank owns a slice of the particles, sums over all particles at those of its slice, and advances them. Communicated:
 * the positions, 16 n bytes into each rank, in each of a step's four stages (here also after it, for the lines printed);
 * once the masses and once the densities, 8 n bytes each. Cost and limits: docs/scaling.md.
 *
 * The lines printed are the same for any number of ranks: over all pairs bit for bit, by the fast multipole method to the
 * tolerance. For the former, slices begin at multiples of 128 particles: the library sums blocks of 128 targets, and the
 * order of a target's terms may depend on others of its block. Exit status 1: the centre of mass has moved by more than the
 * tolerance, or the second moment has not fallen. Times go to stderr.
 */
#include <math.h>
#include <mpi.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mollis.h"

enum { BLOCK = 128 };
static const double t_end = 0.5, pi = 3.14159265358979323846;

/* States, stages, slopes: {x, y, density}. */
typedef struct {
    double state[3], stage[3], slope[3], next[3], mass;
} particle;
enum { STRIDE = sizeof(particle) / sizeof(double) };

static int rank, ranks, *counts, *starts;
/* This rank's particles are `own` of all n, from `first` on. What is gathered of all: positions, masses, densities. */
static particle *mine;
static size_t n, first, own, kernel_bytes, workspace_bytes;
static double *positions, *masses, *densities, seconds[2];
static void *kernel, *workspace;
static mollis_field_options options;

/* Every call of the library returns a status; the text explains it. Errors of MPI end the program by themselves. */
static void try(mollis_status status, const char *what)
{
    if (status != MOLLIS_OK) {
        fprintf(stderr, "rank %d: %s: %s\n", rank, what, mollis_status_text(status));
        MPI_Abort(MPI_COMM_WORLD, 1);
    }
}

static void *memory(size_t bytes)
{
    void *start = malloc(bytes > 0 ? bytes : 1);
    if (start == NULL) {
        fprintf(stderr, "rank %d: out of memory\n", rank);
        MPI_Abort(MPI_COMM_WORLD, 1);
    }
    return start;
}

/* Gathers `each` doubles of every particle into every rank. One type for all ranks: by its size MPI may choose how. */
static void gather(const double *member, int each, double *whole)
{
    const double start = MPI_Wtime();
    MPI_Datatype packed, spaced;
    MPI_Type_contiguous(each, MPI_DOUBLE, &packed);
    MPI_Type_create_resized(packed, 0, sizeof(particle), &spaced);
    MPI_Type_commit(&packed);
    MPI_Type_commit(&spaced);
    MPI_Allgatherv(member, (int)own, spaced, whole, counts, starts, packed, MPI_COMM_WORLD);
    MPI_Type_free(&packed);
    MPI_Type_free(&spaced);
    seconds[1] += MPI_Wtime() - start;
}

/* The velocities -grad u and their divergences at this rank's particles. */
static void sums(void)
{
    const double start = MPI_Wtime();
    const mollis_sources2 from = {.n = n, .positions = {positions}, .masses = masses};
    const mollis_targets2 at = {.n = own, .positions = {positions + 2 * first}};
    const mollis_outputs2 to = {.gradient = {mine->slope}, .gradient_stride = STRIDE, .laplacian = mine->slope + 2,
                                .laplacian_stride = STRIDE, .factor = -1.0};
    if (workspace == NULL) {
        char text[512];
        try(mollis_field2_workspace_bytes(kernel, kernel_bytes, &from, &at, &to, &options, NULL, &workspace_bytes), "size");
        workspace = memory(workspace_bytes);
        try(mollis_field2_text(kernel, kernel_bytes, &from, &at, &to, &options, text, sizeof text, NULL), "text");
        if (rank == 0) {
            printf("%lu particles, %.*s\n", (unsigned long)n, (int)strcspn(text, ":"), text);
        }
    }
    try(mollis_field2_eval(kernel, kernel_bytes, &from, &at, &to, &options, NULL, workspace, workspace_bytes, NULL), "sums");
    seconds[0] += MPI_Wtime() - start;
}

/* A step of RK4 of dx/dt = v, d rho/dt = -rho div v. */
static void step(double dt)
{
    static const double at[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    for (int s = 0; s < 4; s++) {
        for (particle *p = mine; p < mine + own; p++) {
            for (int k = 0; k < 3; k++) {
                p->next[k] = s == 0 ? p->state[k] : p->next[k];
                p->stage[k] = p->state[k] + at[s] * dt * p->slope[k];
            }
        }
        gather(mine->stage, 2, positions);
        sums();
        for (particle *p = mine; p < mine + own; p++) {
            p->slope[2] *= -p->stage[2];
            for (int k = 0; k < 3; k++) {
                p->next[k] += weight[s] * dt * p->slope[k];
                p->state[k] = s == 3 ? p->next[k] : p->state[k];
            }
        }
    }
}

/* The lattice's points in the disc, column by column: fills in this rank's. Returns how many there are. */
static size_t lattice(double h)
{
    const long reach = (long)ceil(1.0 / h);
    size_t count = 0;
    for (long a = -reach; a <= reach; a++) {
        for (long b = -reach; b <= reach; b++) {
            const double x = (double)a * h, y = (double)b * h, t = 1.0 - x * x - y * y;
            if (t > 0.0 && count >= first && count - first < own) {
                mine[count - first] = (particle){.state = {x, y, t * t}, .mass = t * t * h * h};
            }
            count += t > 0.0;
        }
    }
    return count;
}

int main(int argc, char **argv)
{
    MPI_Init(&argc, &argv);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    try(mollis_field_options_init(&options, sizeof options), "options");
    const double h = sqrt(pi / (argc > 1 ? atof(argv[1]) : 2000.0));
    const long steps = argc > 2 ? atol(argv[2]) : 10;
    options.tolerance = argc > 3 ? atof(argv[3]) : 0.0;
    const double delta = argc > 4 ? atof(argv[4]) : 4.0 * pow(h, 0.9);
    if (!(h > 5e-5 && h < 1.0) || steps < 1) {
        fprintf(stderr, "usage: mpi_blob [n [steps [tolerance [delta]]]], n from 4 to 1e9\n");
        MPI_Abort(MPI_COMM_WORLD, 2);
    }

    /* Slices of whole blocks that differ by one block at most. */
    n = lattice(h);
    const size_t blocks = (n + BLOCK - 1) / BLOCK;
    counts = memory(2 * (size_t)ranks * sizeof *counts);
    starts = counts + ranks;
    for (int r = 0; r < ranks; r++) {
        const size_t end = blocks * ((size_t)r + 1) / (size_t)ranks * BLOCK;
        starts[r] = (int)(blocks * (size_t)r / (size_t)ranks * BLOCK);
        counts[r] = (int)(end < n ? end : n) - starts[r];
    }
    first = (size_t)starts[rank];
    own = (size_t)counts[rank];
    mine = memory(own * sizeof *mine);
    positions = memory(4 * n * sizeof *positions);
    masses = positions + 2 * n;
    densities = positions + 3 * n;
    lattice(h);
    gather(&mine->mass, 1, masses);

    const mollis_kernel_term newtonian = {MOLLIS_KERNEL_NEWTONIAN, 0, 1.0, {0.0, 0.0}};
    const mollis_mollifier mollifier = {MOLLIS_MOLLIFIER_COMPACT, 4, 9};
    try(mollis_kernel2_bytes(&newtonian, 1, NULL, mollifier, &kernel_bytes), "kernel's size");
    kernel = memory(kernel_bytes);
    try(mollis_kernel2_prepare(kernel, kernel_bytes, &newtonian, 1, NULL, mollifier, delta), "kernel");

    /* Every rank has all positions, so moments are the same on every rank. The lattice's centre is at 0. */
    double centre[2], second, last = HUGE_VAL, error = 0.0, slowest[2];
    int good = 1;
    for (long s = 0; s <= steps; s++) {
        if (s > 0) {
            step(t_end / (double)steps);
        }
        gather(mine->state, 2, positions);
        try(mollis_moments2(n, (const double(*)[2])positions, masses, NULL, NULL, &centre, &second), "moments");
        good = good && second < last && hypot(centre[0], centre[1]) <= options.tolerance + 1e-12;
        last = second;
        if (rank == 0) {
            printf("step %ld centre %.17g %.17g second moment %.17g\n", s, centre[0], centre[1], second);
        }
    }

    /* Exact along a particle's path: 1 / rho(t) = 1 / rho(0) - t. A hash of all bits (Fowler, Noll, Vo) compares runs. */
    uint64_t bits = 14695981039346656037u, word;
    gather(&mine->state[2], 1, densities);
    for (size_t i = 0; i < n; i++) {
        const double rho_0 = masses[i] / (h * h);
        error += h * h * fabs(densities[i] - rho_0 / (1.0 - rho_0 * t_end));
    }
    for (size_t i = 0; i < 4 * n; i++) {
        memcpy(&word, positions + i, sizeof word);
        bits = (bits ^ word) * 1099511628211u;
    }
    MPI_Reduce(seconds, slowest, 2, MPI_DOUBLE, MPI_MAX, 0, MPI_COMM_WORLD);
    if (rank == 0) {
        printf("error of the density %.17g\n", error);
        if (!(options.tolerance > 0.0)) {
            printf("bits %016llx\n", (unsigned long long)bits);
        }
        puts(good ? "the centre stays, the second moment falls" : "an invariant is broken");
        fprintf(stderr, "slowest of %d ranks: %.3f s in sums, %.3f s in exchange\n", ranks, slowest[0], slowest[1]);
    }
    free(mine);
    free(positions);
    free(counts);
    free(kernel);
    free(workspace);
    MPI_Finalize();
    return !good;
}
