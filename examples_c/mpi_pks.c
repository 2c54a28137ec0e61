/*
 * Coalescing particles of the Patlak-Keller-Segel model on the ranks of MPI, bit for bit what one process computes.
 *
 *   mpirun -n 4 mpi_pks [n [steps [dt [cells]]]]       20,000, 20, 1e-4 and 64 if not given
 *
 * A bump of eight critical masses in the unit disc, on a mesh over [-1.5, 1.5]^2. Each rank owns a slice of the particles. The library
 * asks for two functions, a reduction and an exchange (mollis_communicator), and for no other code of MPI. With them the ranks sum the density
 * of the mesh, in integers, share out the search for clusters, and decide together which collapse, so that all of them have all events. A
 * particle's noise depends on its label and the step alone. A merged particle stays on the rank of the one that absorbs the others.
 *
 * The lines printed are the same for any number of ranks. They end with hashes of the bits of all events and of all particles. Times go
 * to stderr. Exit status 1: mass or labels are lost. Cost and limits: docs/scaling.md.
 */
#include <limits.h>
#include <math.h>
#include <mpi.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mollis.h"

static const double pi = 3.14159265358979323846;
static int rank, ranks;

/* Of this rank: seconds in the two functions, and words that they send. */
typedef struct {
    double seconds, words;
    int *counts;
} traffic;

/* Every call of the library returns a status; the text explains it. Errors of MPI end the program by themselves. */
static void try(mollis_status status, const char *what)
{
    if (status != MOLLIS_OK) {
        fprintf(stderr, "rank %d: %s: %s\n", rank, what, mollis_status_text(status));
        MPI_Abort(MPI_COMM_WORLD, 1);
    }
}

static void *memory(size_t count, size_t each)
{
    void *start = malloc(count > 0 ? count * each : 1);
    if (start == NULL) {
        fprintf(stderr, "rank %d: out of memory\n", rank);
        MPI_Abort(MPI_COMM_WORLD, 1);
    }
    return start;
}

/* The words of all ranks become their sum or the largest. */
static int32_t reduce(void *context, int32_t operation, uint64_t *words, size_t count)
{
    traffic *t = context;
    const MPI_Op op = operation == MOLLIS_REDUCE_SUM ? MPI_SUM : MPI_MAX;
    const double start = MPI_Wtime();
    t->words += (double)count;
    while (count > 0) {
        const int part = count < INT_MAX ? (int)count : INT_MAX;
        MPI_Allreduce(MPI_IN_PLACE, words, part, MPI_UINT64_T, op, MPI_COMM_WORLD);
        words += part;
        count -= (size_t)part;
    }
    t->seconds += MPI_Wtime() - start;
    return 0;
}

/* Each rank sends words to each. */
static int32_t exchange(void *context, const uint64_t *outgoing, const size_t *starts, uint64_t *incoming,
                        const size_t *froms)
{
    traffic *t = context;
    const double start = MPI_Wtime();
    if (starts[ranks] > INT_MAX || froms[ranks] > INT_MAX) {
        return 1000; /* a status of our own: the step returns it */
    }
    for (int r = 0; r < ranks; r++) {
        t->counts[r] = (int)(starts[r + 1] - starts[r]);
        t->counts[ranks + r] = (int)starts[r];
        t->counts[2 * ranks + r] = (int)(froms[r + 1] - froms[r]);
        t->counts[3 * ranks + r] = (int)froms[r];
    }
    MPI_Alltoallv(outgoing, t->counts, t->counts + ranks, MPI_UINT64_T, incoming, t->counts + 2 * ranks,
                  t->counts + 3 * ranks, MPI_UINT64_T, MPI_COMM_WORLD);
    t->words += (double)starts[ranks];
    t->seconds += MPI_Wtime() - start;
    return 0;
}

/* A number from 0 to 1 for each label and place in its sequence (the finalizer of Vigna's splitmix64). */
static double uniform(uint64_t label, uint64_t place)
{
    uint64_t z = (label << 20 | place) * UINT64_C(0x9E3779B97F4A7C15);
    z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
    return (double)((z ^ (z >> 31)) >> 11) / 9007199254740992.0;
}

/* A point of the unit disc with density exp(1 / (|x|^2 - 1)). */
static void bump(uint64_t label, double x[2])
{
    double square;
    uint64_t place = 0;
    do {
        x[0] = 2 * uniform(label, place++) - 1;
        x[1] = 2 * uniform(label, place++) - 1;
        square = x[0] * x[0] + x[1] * x[1];
    } while (square >= 1 || uniform(label, place++) >= exp(1 + 1 / (square - 1)));
}

/* A hash of bits (Fowler, Noll, Vo, by words). */
static void hash(uint64_t *bits, const void *start, size_t words)
{
    uint64_t word;
    for (size_t i = 0; i < words; i++) {
        memcpy(&word, (const char *)start + 8 * i, sizeof word);
        *bits = (*bits ^ word) * UINT64_C(1099511628211);
    }
}

int main(int argc, char **argv)
{
    MPI_Init(&argc, &argv);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    const size_t n = argc > 1 ? strtoul(argv[1], NULL, 10) : 20000;
    const long steps = argc > 2 ? atol(argv[2]) : 20;
    const double dt = argc > 3 ? atof(argv[3]) : 1e-4;
    const size_t cells = argc > 4 ? strtoul(argv[4], NULL, 10) : 64;
    const double mass = 8 * 8 * pi;
    if (n < 1 || n > UINT32_MAX / 2 || steps < 1) {
        fprintf(stderr, "usage: mpi_pks [n [steps [dt [cells]]]]\n");
        MPI_Abort(MPI_COMM_WORLD, 2);
    }

    /* The slices; the room is the same on all ranks. */
    const size_t first = n * (size_t)rank / (size_t)ranks, own = n * ((size_t)rank + 1) / (size_t)ranks - first;
    const size_t room = (n + (size_t)ranks - 1) / (size_t)ranks;
    double(*x)[2] = memory(room, sizeof *x);
    double *m = memory(room, sizeof *m);
    uint64_t *labels = memory(room, sizeof *labels);
    for (size_t i = 0; i < own; i++) {
        labels[i] = first + i;
        bump(labels[i], x[i]);
        m[i] = mass / (double)n;
    }
    const mollis_pks_particles particles = {room, x, m, labels, NULL, NULL};
    mollis_pks_progress progress = {.count = own};
    mollis_pks_event log[256];
    uint64_t *absorbed = memory(n, sizeof *absorbed); /* one merge may absorb all */
    mollis_pks_events events = {.events = log, .room = 256, .labels = absorbed, .labels_room = n};

    /* Who they are, and how they exchange words. */
    traffic sent = {0, 0, memory(4 * (size_t)ranks, sizeof(int))};
    const mollis_communicator communicator = {&sent, (size_t)rank, (size_t)ranks, reduce, exchange};
    mollis_run run;
    try(mollis_run_init(&run, sizeof run), "run");
    run.communicator = &communicator;

    mollis_pks_options options;
    try(mollis_pks_options_init(&options, sizeof options), "options");
    options.chi = 1;
    options.noise = mass / (double)n; /* mu~ = mu M / n, mu = 1 */
    const mollis_mesh2 mesh = {{-1.5, -1.5}, {1.5, 1.5}, {cells, cells}};
    const mollis_pks_attraction attraction = {.kind = MOLLIS_PKS_ATTRACTION_MESH, .mesh = &mesh};
    size_t bytes;
    try(mollis_pks_workspace_bytes(room, &attraction, &options, &run, &bytes), "size");
    void *workspace = memory(bytes, 1);

    /* All ranks have the same events. A step that fills the buffers goes on once they are empty. */
    double seconds = 0;
    uint64_t history = UINT64_C(14695981039346656037), bits = history, merges = 0, lost = 0, left;
    for (long s = 1; s <= steps; s++) {
        mollis_status status;
        MPI_Barrier(MPI_COMM_WORLD);
        const double start = MPI_Wtime();
        do {
            status = mollis_pks_step(&particles, &progress, &attraction, NULL, dt, 1, &events, &options, &run, workspace, bytes,
                                     NULL);
            for (size_t i = 0; i < events.written; i++) {
                hash(&history, &log[i], 4);
            }
            hash(&history, absorbed, events.labels_written);
            merges += events.written;
            lost += events.labels_written;
            events.written = events.labels_written = 0;
        } while (status == MOLLIS_ERR_EVENTS_FULL);
        try(status, "step");
        /* The first step touches memory for the first time. */
        seconds = s == 1 ? 0 : seconds + MPI_Wtime() - start;
        if (s == 1) {
            sent.seconds = sent.words = 0;
        }
        if (s % ((steps + 4) / 5) == 0 || s == steps) {
            MPI_Reduce(&progress.count, &left, 1, MPI_UINT64_T, MPI_SUM, 0, MPI_COMM_WORLD);
            if (rank == 0) {
                printf("t %.9g: %lu particles, %lu merges\n", progress.time, (unsigned long)left, (unsigned long)merges);
            }
        }
    }

    /* The particles in the order of the ranks, which is that of one process. */
    double total = 0, all = 0;
    if (rank > 0) {
        MPI_Recv(&bits, 1, MPI_UINT64_T, rank - 1, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    }
    for (size_t i = 0; i < progress.count; i++) {
        hash(&bits, x[i], 2);
        hash(&bits, &m[i], 1);
        hash(&bits, &labels[i], 1);
        total += m[i];
    }
    if (rank + 1 < ranks) {
        MPI_Send(&bits, 1, MPI_UINT64_T, rank + 1, 0, MPI_COMM_WORLD);
    } else if (rank > 0) {
        MPI_Send(&bits, 1, MPI_UINT64_T, 0, 1, MPI_COMM_WORLD);
    }
    if (rank == 0 && ranks > 1) {
        MPI_Recv(&bits, 1, MPI_UINT64_T, ranks - 1, 1, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    }
    MPI_Reduce(&total, &all, 1, MPI_DOUBLE, MPI_SUM, 0, MPI_COMM_WORLD);
    double times[2] = {seconds, sent.seconds}, slowest[2], most;
    MPI_Reduce(times, slowest, 2, MPI_DOUBLE, MPI_MAX, 0, MPI_COMM_WORLD);
    MPI_Reduce(&sent.words, &most, 1, MPI_DOUBLE, MPI_MAX, 0, MPI_COMM_WORLD);
    int good = 1;
    if (rank == 0) {
        good = left + lost == n && fabs(all / mass - 1) < 1e-9;
        printf("events %016llx, particles %016llx\n", (unsigned long long)history, (unsigned long long)bits);
        printf("%s\n", good ? "mass and labels are conserved" : "LOST");
        if (steps > 1) {
            const double each = (double)(steps - 1);
            fprintf(stderr, "%d ranks: %.2f ms a step, %.2f of them in reductions and exchanges of %.0f bytes a rank\n", ranks,
                    1e3 * slowest[0] / each, 1e3 * slowest[1] / each, 8 * most / each);
        }
    }
    MPI_Bcast(&good, 1, MPI_INT, 0, MPI_COMM_WORLD);
    free(x);
    free(m);
    free(labels);
    free(absorbed);
    free(workspace);
    free(sent.counts);
    MPI_Finalize();
    return good ? 0 : 1;
}
