/*
 * The blob method for the aggregation equation on the ranks of MPI; each rank calls the library as a program alone does.
 *
 *   mpirun -n 4 mpi_blob [n [steps [tolerance [delta]]]]       2000, 10, 0 and 4 h^0.9 if not given
 *
 * rho_0(x) = (1 - |x|^2)^2 on the about n points of the lattice h Z^2 in the unit disc, K the attractive Newtonian kernel
 * under the compact mollifier of order 4, to t = 0.5 by RK4. Each rank owns a slice of the particles, sums at those, and
 * advances them.
 *
 * With a tolerance (1e-6) a rank sends to each other one what is essential there of its own particles: those near the other's
 * bounding box, and a few masses in place of the others (mollis_field2_essential). What a rank holds and receives is its own
 * particles and some along its border. The slices are strips here and stay so, as the flow contracts; where particles mix,
 * hand them over from time to time, so that bounding boxes overlap little.
 *
 * A tolerance of 0 asks for sums over all pairs. Then every rank gathers all positions, 16 n bytes, in each of a step's four
 * stages. Cost and limits of both: docs/scaling.md.
 *
 * The lines printed are the same for any number of ranks: over all pairs bit for bit, else to the tolerance. For the former,
 * slices begin at multiples of 128 particles: the library sums blocks of 128 targets, and the order of a target's terms may
 * depend on others of its block. Exit status 1: the centre of mass has moved by more than the tolerance, or the second moment
 * has not fallen. Times go to stderr.
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
/* This rank's particles are `own` of all n, from `first` on. */
static particle *mine;
static size_t n, first, own, kernel_bytes;
/* The sources of this rank's sums: all, or its own and what it has received. */
static double *positions, *masses;
static size_t n_sources, target, room;
static void *kernel;
static mollis_field_options options;
/* In sums, in looking for what is essential, in exchange; and what was received in sums so far. */
static double seconds[3], received;

/* Memory that grows. */
typedef struct {
    void *start;
    size_t bytes;
} block;
static block workspace, search, outgoing;

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

static void *at_least(block *b, size_t bytes)
{
    if (b->bytes < bytes) {
        free(b->start);
        b->bytes = bytes + bytes / 4;
        b->start = memory(b->bytes);
    }
    return b->start;
}

/* Room for so many sources; what was there is lost. */
static void make_room(size_t sources)
{
    if (room < sources) {
        free(positions);
        room = sources + sources / 4;
        positions = memory(3 * room * sizeof *positions);
        masses = positions + 2 * room;
    }
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
    seconds[2] += MPI_Wtime() - start;
}

/* All particles become the sources. */
static void gather_all(void)
{
    make_room(n);
    gather(mine->stage, 2, positions);
    gather(&mine->mass, 1, masses);
    n_sources = n;
    target = first;
}

/* What is essential of other ranks' particles joins this rank's as sources. */
static void exchange(void)
{
    typedef double corners[2][2];
    double now = MPI_Wtime();
    corners box = {{HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL}}, *boxes = memory((size_t)ranks * sizeof *boxes);
    uint64_t *begin = memory(((size_t)ranks + 1) * sizeof *begin);
    int *numbers = memory(4 * (size_t)ranks * sizeof *numbers), *to = numbers + ranks, *from = to + ranks, *at = from + ranks;
    for (const particle *p = mine; p < mine + own; p++) {
        for (int k = 0; k < 2; k++) {
            box[0][k] = fmin(box[0][k], p->stage[k]);
            box[1][k] = fmax(box[1][k], p->stage[k]);
        }
    }
    MPI_Allgather(box, 4, MPI_DOUBLE, boxes, 4, MPI_DOUBLE, MPI_COMM_WORLD);
    for (int r = 0; r < ranks; r++) {
        if (r == rank || !(boxes[r][0][0] <= boxes[r][1][0])) {
            /* No targets there: a lower corner above the upper one. */
            memcpy(boxes[r], ((corners){{1.0, 0.0}, {0.0, 0.0}}), sizeof boxes[r]);
        }
    }
    seconds[2] += MPI_Wtime() - now;

    now = MPI_Wtime();
    const mollis_sources2 all = {.n = own, .positions = {mine->stage}, .stride = STRIDE, .masses = &mine->mass,
                                 .mass_stride = STRIDE};
    size_t bytes, space = own / 4 + 1024;
    try(mollis_field2_essential_bytes(kernel, kernel_bytes, &all, options.tolerance, &bytes), "size");
    mollis_status status;
    double(*x)[2];
    do {
        x = at_least(&outgoing, space * 3 * sizeof(double));
        status = mollis_field2_essential(kernel, kernel_bytes, &all, options.tolerance, (size_t)ranks,
                                         (const double(*)[2][2])boxes, begin, space, x, (double *)(x + space), NULL, NULL,
                                         at_least(&search, bytes), bytes);
        if (status == MOLLIS_ERR_NO_ROOM) {
            space = (size_t)begin[ranks];
        } else {
            try(status, "essential sources");
        }
    } while (status != MOLLIS_OK);
    const double *m = (double *)(x + space);
    seconds[1] += MPI_Wtime() - now;

    now = MPI_Wtime();
    size_t others = 0;
    for (int r = 0; r < ranks; r++) {
        to[r] = (int)(begin[r + 1] - begin[r]);
        numbers[r] = (int)begin[r];
    }
    MPI_Alltoall(to, 1, MPI_INT, from, 1, MPI_INT, MPI_COMM_WORLD);
    for (int r = 0; r < ranks; r++) {
        at[r] = (int)others;
        others += (size_t)from[r];
    }
    n_sources = own + others;
    target = 0;
    make_room(n_sources);
    MPI_Datatype point;
    MPI_Type_contiguous(2, MPI_DOUBLE, &point);
    MPI_Type_commit(&point);
    MPI_Alltoallv(x, to, numbers, point, positions + 2 * own, from, at, point, MPI_COMM_WORLD);
    MPI_Alltoallv(m, to, numbers, MPI_DOUBLE, masses + own, from, at, MPI_DOUBLE, MPI_COMM_WORLD);
    MPI_Type_free(&point);
    received += (double)others;
    for (size_t i = 0; i < own; i++) {
        memcpy(positions + 2 * i, mine[i].stage, 2 * sizeof *positions);
        masses[i] = mine[i].mass;
    }
    seconds[2] += MPI_Wtime() - now;
    free(boxes);
    free(begin);
    free(numbers);
}

/* The velocities -grad u and their divergences at this rank's particles. */
static void sums(void)
{
    const double start = MPI_Wtime();
    static int told = 0;
    size_t bytes;
    const mollis_sources2 from = {.n = n_sources, .positions = {positions}, .masses = masses};
    const mollis_targets2 at = {.n = own, .positions = {positions + 2 * target}};
    const mollis_outputs2 to = {.gradient = {mine->slope}, .gradient_stride = STRIDE, .laplacian = mine->slope + 2,
                                .laplacian_stride = STRIDE, .factor = -1.0};
    try(mollis_field2_workspace_bytes(kernel, kernel_bytes, &from, &at, &to, &options, NULL, &bytes), "size");
    if (!told++) {
        char text[512];
        try(mollis_field2_text(kernel, kernel_bytes, &from, &at, &to, &options, text, sizeof text, NULL), "text");
        if (rank == 0) {
            printf("%lu particles, %.*s\n", (unsigned long)n, (int)strcspn(text, ":"), text);
        }
    }
    void *space = at_least(&workspace, bytes);
    try(mollis_field2_eval(kernel, kernel_bytes, &from, &at, &to, &options, NULL, space, bytes, NULL), "sums");
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
        if (options.tolerance > 0.0) {
            exchange();
        } else {
            gather_all();
        }
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

/* Centre and second moment of all particles, the same on every rank; over all pairs from all positions, so that they are the
   same for any number of ranks. */
static void moments(double centre[2], double *second)
{
    if (options.tolerance > 0.0) {
        double sums[4] = {0.0}, all[4];
        for (const particle *p = mine; p < mine + own; p++) {
            const double x = p->state[0], y = p->state[1], terms[4] = {1.0, x, y, x * x + y * y};
            for (int k = 0; k < 4; k++) {
                sums[k] += p->mass * terms[k];
            }
        }
        MPI_Allreduce(sums, all, 4, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
        centre[0] = all[1] / all[0];
        centre[1] = all[2] / all[0];
        *second = all[3];
        return;
    }
    double whole[2];
    make_room(n);
    gather(mine->state, 2, positions);
    gather(&mine->mass, 1, masses);
    try(mollis_moments2(n, (const double(*)[2])positions, masses, NULL, NULL, &whole, second), "moments");
    memcpy(centre, whole, sizeof whole);
}

/* The error of the density: exact along a particle's path is 1 / rho(t) = 1 / rho(0) - t. Over all pairs also a hash of all bits
   (Fowler, Noll, Vo), which compares runs. */
static void report(double h)
{
    double error = 0.0, all;
    for (const particle *p = mine; p < mine + own; p++) {
        const double rho_0 = p->mass / (h * h);
        error += h * h * fabs(p->state[2] - rho_0 / (1.0 - rho_0 * t_end));
    }
    if (options.tolerance > 0.0) {
        MPI_Reduce(&error, &all, 1, MPI_DOUBLE, MPI_SUM, 0, MPI_COMM_WORLD);
    } else {
        double *states = memory(3 * n * sizeof *states);
        uint64_t bits = 14695981039346656037u, word;
        gather(mine->state, 3, states);
        gather(&mine->mass, 1, masses);
        all = 0.0;
        for (size_t i = 0; i < n; i++) {
            const double rho_0 = masses[i] / (h * h);
            all += h * h * fabs(states[3 * i + 2] - rho_0 / (1.0 - rho_0 * t_end));
        }
        for (size_t i = 0; i < 3 * n; i++) {
            memcpy(&word, states + i, sizeof word);
            bits = (bits ^ word) * 1099511628211u;
        }
        if (rank == 0) {
            printf("bits %016llx\n", (unsigned long long)bits);
        }
        free(states);
    }
    if (rank == 0) {
        printf("error of the density %.17g\n", all);
    }
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
    lattice(h);

    const mollis_kernel_term newtonian = {MOLLIS_KERNEL_NEWTONIAN, 0, 1.0, {0.0, 0.0}};
    const mollis_mollifier mollifier = {MOLLIS_MOLLIFIER_COMPACT, 4, 9};
    try(mollis_kernel2_bytes(&newtonian, 1, NULL, mollifier, &kernel_bytes), "kernel's size");
    kernel = memory(kernel_bytes);
    try(mollis_kernel2_prepare(kernel, kernel_bytes, &newtonian, 1, NULL, mollifier, delta), "kernel");

    /* The lattice's centre is at 0. */
    double centre[2], second, last = HUGE_VAL, slowest[3], most;
    int good = 1;
    for (long s = 0; s <= steps; s++) {
        if (s > 0) {
            step(t_end / (double)steps);
        }
        moments(centre, &second);
        good = good && second < last && hypot(centre[0], centre[1]) <= options.tolerance + 1e-12;
        last = second;
        if (rank == 0) {
            printf("step %ld centre %.17g %.17g second moment %.17g\n", s, centre[0], centre[1], second);
        }
    }
    report(h);
    MPI_Reduce(seconds, slowest, 3, MPI_DOUBLE, MPI_MAX, 0, MPI_COMM_WORLD);
    MPI_Reduce(&received, &most, 1, MPI_DOUBLE, MPI_MAX, 0, MPI_COMM_WORLD);
    if (rank == 0) {
        puts(good ? "the centre stays, the second moment falls" : "an invariant is broken");
        fprintf(stderr, "slowest of %d ranks: %.3f s in sums, %.3f s in looking for what is essential, %.3f s in exchange", ranks,
                slowest[0], slowest[1], slowest[2]);
        fprintf(stderr, "; most sources received for a sum: %.0f\n", most / (4.0 * (double)steps));
    }
    free(mine);
    free(positions);
    free(counts);
    free(kernel);
    free(workspace.start);
    free(search.start);
    free(outgoing.start);
    MPI_Finalize();
    return !good;
}
