/*
 * The library in a program that traps floating-point exceptions: invalid, divide-by-zero and overflow stop it, as -ffpe-trap=invalid,zero,overflow
 * does in Fortran. Ordinary calls raise none of them, at distance zero, for a total mass of zero and without attraction either.
 *
 * Where the C library has no feenableexcept the calls run without traps.
 *
 * usage: traps
 */
#define _GNU_SOURCE
#include <fenv.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "mollis.h"

enum { N = 40, CELLS = 24, NODES = (CELLS + 1) * (CELLS + 1), RADII = 7 };

/* What is being called, for the handler. */
static const char *volatile now = "nothing";

static void trapped(int number) {
    (void)number;
    const char *const texts[] = {"trapped in ", now, "\n"};
    for (int i = 0; i < 3; ++i) {
        if (write(2, texts[i], strlen(texts[i])) < 0) {
            break;
        }
    }
    _exit(1);
}

static void check(mollis_status status) {
    if (status != 0) {
        fprintf(stderr, "%s: %s\n", now, mollis_status_text(status));
        exit(1);
    }
}

/* Calls a function and checks its status. */
#define CALL(function, ...) (now = #function, check(function(__VA_ARGS__)))

/* Aligned as the library needs it. */
static void *memory_of(size_t bytes) {
    void *memory = NULL;
    if (posix_memalign(&memory, 64, bytes + 64) != 0) {
        exit(1);
    }
    return memory;
}

static const mollis_mollifier mollifiers[] = {
    {MOLLIS_MOLLIFIER_NONE, 0, 0},
    {MOLLIS_MOLLIFIER_COMPACT, 2, 4},
    {MOLLIS_MOLLIFIER_COMPACT, 8, 2},
    {MOLLIS_MOLLIFIER_GAUSSIAN, 4, 0},
};

static const mollis_kernel_term sums[][2] = {
    {{MOLLIS_KERNEL_NEWTONIAN, 0, 1, {0, 0}}, {MOLLIS_KERNEL_POWER, 0, 1, {4, 0}}},
    {{MOLLIS_KERNEL_POWER, 0, 1, {1.5, 0}}, {MOLLIS_KERNEL_POWER, 0, -1, {3, 0}}},
    {{MOLLIS_KERNEL_EXPONENTIAL, 0, 1, {1, 0}}, {MOLLIS_KERNEL_SCREENED, 0, 1, {2, 0}}},
};

/* The origin, two places on the border of the mesh, one outside, pairs at one place. */
static double place(int k, int axis) {
    static const double first[4][2] = {{0, 0}, {1, 0.3}, {1, 1}, {1.5, -7}};
    return k < 4 ? first[k][axis % 2] : (k / 2 * (7 - 4 * axis) % 20 - 10) / 11.0;
}

static const int32_t levels[] = {MOLLIS_LEVEL_PORTABLE, MOLLIS_LEVEL_NEON, MOLLIS_LEVEL_AVX2, MOLLIS_LEVEL_AVX512};

/* The arguments of a sum over arrays without gaps, with every output. */
#define ARGUMENTS(D, _F32, COUNT, X, MASS, TO)                                                                              \
    const mollis_sources##D##_F32 sources = {.n = (COUNT), .positions = {&(X)[0][0]}, .masses = (MASS)};                    \
    const mollis_targets##D##_F32 targets = {.n = (COUNT), .positions = {&(TO)[0][0]}};                                     \
    const mollis_outputs##D##_F32 outputs = {.potential = out[0], .gradient = {&gradient[0][0]}, .laplacian = out[1]}

/* Sums and steps with the kernel, on every level of instructions that the machine has. */
#define SUMS(D, REAL, _F32)                                                                                                 \
    for (int level = 0; level < 4; ++level) {                                                                               \
        mollis_run run;                                                                                                     \
        CALL(mollis_run_init, &run, sizeof run);                                                                            \
        run.level = levels[level];                                                                                          \
        size_t needed;                                                                                                      \
        now = "mollis_field" #D "_workspace_bytes" #_F32;                                                                   \
        ARGUMENTS(D, _F32, N, at, masses[0], at);                                                                           \
        if (mollis_field##D##_workspace_bytes##_F32(kernel, bytes, &sources, NULL, &outputs, NULL, &run, &needed) != 0) {   \
            continue; /* not on this machine */                                                                             \
        }                                                                                                                   \
        void *memory = memory_of(needed);                                                                                   \
        for (int i = 0; i < 3; ++i) {                                                                                       \
            mollis_sources##D##_F32 these = sources;                                                                        \
            these.masses = masses[i];                                                                                       \
            CALL(mollis_field##D##_eval##_F32, kernel, bytes, &these, &targets, &outputs, NULL, &run, memory, needed, NULL);\
        }                                                                                                                   \
        free(memory);                                                                                                       \
        if (psi.kind != MOLLIS_MOLLIFIER_NONE && psi.order == 4) {                                                          \
            REAL moving[N][D];                                                                                              \
            memcpy(moving, x, sizeof x);                                                                                    \
            const mollis_particles##D##_F32 particles = {.n = N, .positions = {&moving[0][0]}, .masses = mass};             \
            CALL(mollis_blob##D##_workspace_bytes##_F32, kernel, bytes, &particles, NULL, NULL, &run, &needed);             \
            void *scratch = memory_of(needed);                                                                              \
            CALL(mollis_blob##D##_step##_F32, kernel, bytes, &particles, NULL, 1e-3, 2, NULL, &run, scratch, needed, NULL); \
            free(scratch);                                                                                                  \
        }                                                                                                                   \
    }

/* Functions of distances and of points, kernels, moments, overlaps, norms, stable steps in one dimension and scalar. */
#define FUNCTIONS(NAME, D, REAL, _F32)                                                                                      \
    static void NAME(void) {                                                                                                \
        const REAL r[RADII] = {0, (REAL)1e-6, (REAL)0.1, (REAL)0.3, (REAL)0.31, 5, 300};                                    \
        REAL out[6][N], x[N][D], gradient[N][D], hessian[N][D][D], centre[D];                                               \
        REAL mass[N], opposite[N], zeros[N] = {0};                                                                          \
        for (int k = 0; k < N; ++k) {                                                                                       \
            for (int axis = 0; axis < D; ++axis) {                                                                          \
                x[k][axis] = (REAL)place(k, axis);                                                                          \
            }                                                                                                               \
            mass[k] = (REAL)0.25;                                                                                           \
            opposite[k] = (REAL)(k % 2 == 0 ? 0.25 : -0.25);                                                                \
        }                                                                                                                   \
        const REAL(*at)[D] = (const REAL(*)[D])x;                                                                           \
        const REAL *const masses[] = {mass, opposite, zeros};                                                               \
        for (size_t i = 0; i < sizeof mollifiers / sizeof *mollifiers - (D == 3); ++i) {                                    \
            const mollis_mollifier psi = mollifiers[i];                                                                     \
            const REAL delta = (REAL)0.3;                                                                                   \
            CALL(mollis_mollifier##D##_eval##_F32, psi, delta, RADII, r, out[0], out[1], out[2], out[3], out[4], out[5]);   \
            CALL(mollis_mollifier##D##_field##_F32, psi, delta, N, at, out[0], out[1], gradient, hessian);                  \
            for (size_t k = 0; k < sizeof sums / sizeof *sums; ++k) {                                                       \
                size_t bytes;                                                                                               \
                CALL(mollis_kernel##D##_bytes##_F32, sums[k], 2, NULL, psi, &bytes);                                        \
                void *kernel = memory_of(bytes);                                                                            \
                CALL(mollis_kernel##D##_prepare##_F32, kernel, bytes, sums[k], 2, NULL, psi, delta);                        \
                CALL(mollis_kernel##D##_eval##_F32, kernel, bytes, RADII, r, out[0], out[1], out[2]);                       \
                if (psi.kind != MOLLIS_MOLLIFIER_NONE) {                                                                    \
                    CALL(mollis_stable_step##D##_F32, kernel, bytes, N, at, mass, out[0]);                                  \
                    CALL(mollis_stable_step##D##_anywhere##_F32, kernel, bytes, 10, 3, out[0]);                             \
                }                                                                                                           \
                SUMS(D, REAL, _F32)                                                                                         \
                free(kernel);                                                                                               \
            }                                                                                                               \
        }                                                                                                                   \
        for (int i = 0; i < 3; ++i) {                                                                                       \
            CALL(mollis_moments##D##_F32, N, at, masses[i], out[0], out[1], &centre, out[2]);                               \
            CALL(mollis_overlap##D##_F32, N, (REAL)0.3, masses[i], mass, out[0]);                                           \
            CALL(mollis_overlap##D##_F32, N, (REAL)0.3, mass, masses[i], out[0]);                                           \
            CALL(mollis_norm##_F32, N, masses[i], (REAL)0.1, 2, out[0]);                                                    \
        }                                                                                                                   \
        CALL(mollis_distance_norm##D##_F32, N, at, at, (REAL)0.1, 2, out[0]);                                               \
    }

FUNCTIONS(line, 1, double, )
FUNCTIONS(plane, 2, double, )
FUNCTIONS(space, 3, double, )
FUNCTIONS(line_f32, 1, float, _f32)
FUNCTIONS(plane_f32, 2, float, _f32)
FUNCTIONS(space_f32, 3, float, _f32)

static const mollis_mesh2 mesh = {{-1, -1}, {1, 1}, {CELLS, CELLS}};

/* Mesh fields with all walls, by both schemes; steps on meshes with walls, without attraction, without noise. */
#define MESHES(NAME, REAL, _F32)                                                                                            \
    static void NAME(void) {                                                                                                \
        static REAL node_mass[NODES], potential[NODES], node_gradient[NODES][2];                                            \
        REAL x[N][2], gradient[N][2], total[3], mass[N], opposite[N], zeros[N] = {0};                                       \
        uint64_t outside, labels[N], absorbed[N];                                                                           \
        for (int k = 0; k < N; ++k) {                                                                                       \
            x[k][0] = (REAL)place(k, 0);                                                                                    \
            x[k][1] = (REAL)place(k, 1);                                                                                    \
            mass[k] = (REAL)0.25;                                                                                           \
            opposite[k] = (REAL)(k % 2 == 0 ? 0.25 : -0.25);                                                                \
            labels[k] = (uint64_t)k;                                                                                        \
        }                                                                                                                   \
        const REAL(*at)[2] = (const REAL(*)[2])x;                                                                           \
        const REAL *const masses[] = {mass, opposite, zeros};                                                               \
        mollis_grid2_options grid;                                                                                          \
        CALL(mollis_grid2_options_init, &grid, sizeof grid);                                                                \
        const int32_t walls[] = {MOLLIS_WALLS_FREE, MOLLIS_WALLS_NO_FLUX, MOLLIS_WALLS_FREE_QUADRUPOLE};                    \
        size_t bytes;                                                                                                       \
        for (int i = 0; i < 18; ++i) {                                                                                      \
            grid.walls = walls[i % 3];                                                                                      \
            grid.order = i < 9 ? 2 : 4;                                                                                     \
            const mollis_sources2##_F32 sources = {.n = N, .positions = {&at[0][0]}, .masses = masses[i / 3 % 3]};          \
            const mollis_grid2_outputs##_F32 outputs = {{&gradient[0][0]}, 0, node_mass, potential, node_gradient, &total, &outside};\
            CALL(mollis_grid2_workspace_bytes##_F32, &mesh, &sources, NULL, &outputs, &grid, NULL, &bytes);                 \
            void *memory = memory_of(bytes);                                                                                \
            CALL(mollis_grid2_eval##_F32, &mesh, &sources, NULL, &outputs, &grid, NULL, memory, bytes);                     \
            free(memory);                                                                                                   \
        }                                                                                                                   \
        grid.order = 2;                                                                                                     \
        for (int i = 0; i < 5; ++i) {                                                                                       \
            mollis_pks_options options;                                                                                     \
            CALL(mollis_pks_options_init, &options, sizeof options);                                                        \
            options.chi = i == 2 ? 0 : 20;                                                                                  \
            options.noise = i == 3 ? 0 : 0.02;                                                                              \
            options.law = i == 4 ? MOLLIS_PKS_LAW_PRINTED : MOLLIS_PKS_LAW_EXACT;                                           \
            grid.walls = i == 1 ? MOLLIS_WALLS_NO_FLUX : MOLLIS_WALLS_FREE;                                                 \
            mollis_pks_attraction attraction;                                                                               \
            memset(&attraction, 0, sizeof attraction);                                                                      \
            attraction.kind = MOLLIS_PKS_ATTRACTION_MESH;                                                                   \
            attraction.mesh = &mesh;                                                                                        \
            attraction.grid = &grid;                                                                                        \
            REAL moving[N][2], weights[N];                                                                                  \
            uint64_t names[N];                                                                                              \
            memcpy(moving, x, sizeof x);                                                                                    \
            memcpy(weights, mass, sizeof mass);                                                                             \
            memcpy(names, labels, sizeof labels);                                                                           \
            mollis_pks_event log[N];                                                                                        \
            mollis_pks_events events = {log, N, 0, absorbed, N, 0};                                                         \
            mollis_pks_progress progress = {0, 0, N, 0};                                                                    \
            const mollis_pks_particles##_F32 particles = {N, moving, weights, names, NULL, NULL};                              \
            options.seed = 7;                                                                                               \
            CALL(mollis_pks_workspace_bytes##_F32, N, &attraction, &options, NULL, &bytes);                                 \
            void *memory = memory_of(bytes);                                                                                \
            CALL(mollis_pks_step##_F32, &particles, &progress, &attraction, NULL, 1e-3, 5, &events, &options, NULL, memory, \
                 bytes, NULL);                                                                                              \
            free(memory);                                                                                                   \
        }                                                                                                                   \
    }

MESHES(meshes, double, )
MESHES(meshes_f32, float, _f32)

/* Newtonian sums at the sources themselves, with supports that few pairs reach and without, for sizes that leave lanes empty. */
#define NEWTONIAN(NAME, D, REAL, _F32)                                                                                      \
    static void NAME(void) {                                                                                                \
        static const mollis_kernel_term newtonian = {MOLLIS_KERNEL_NEWTONIAN, 0, 1, {0, 0}};                                \
        static const mollis_mollifier shapes[] = {                                                                          \
            {MOLLIS_MOLLIFIER_NONE, 0, 0},                                                                                  \
            {MOLLIS_MOLLIFIER_COMPACT, 4, 4},                                                                               \
            {MOLLIS_MOLLIFIER_COMPACT, 4, 8},                                                                               \
            {MOLLIS_MOLLIFIER_COMPACT, 2, 9},                                                                               \
        };                                                                                                                  \
        static const REAL deltas[] = {(REAL)1e-3, (REAL)0.05, 3};                                                           \
        REAL x[N][D], mass[N], out[2][N], gradient[N][D];                                                                   \
        for (int k = 0; k < N; ++k) {                                                                                       \
            for (int axis = 0; axis < D; ++axis) {                                                                          \
                x[k][axis] = (REAL)place(k + 4, axis);                                                                      \
            }                                                                                                               \
            mass[k] = 1;                                                                                                    \
        }                                                                                                                   \
        const REAL(*at)[D] = (const REAL(*)[D])x;                                                                           \
        for (int i = 0; i < 12; ++i) {                                                                                      \
            size_t bytes, needed;                                                                                           \
            CALL(mollis_kernel##D##_bytes##_F32, &newtonian, 1, NULL, shapes[i / 3], &bytes);                               \
            void *kernel = memory_of(bytes);                                                                                \
            CALL(mollis_kernel##D##_prepare##_F32, kernel, bytes, &newtonian, 1, NULL, shapes[i / 3], deltas[i % 3]);       \
            for (int level = 0; level < 4; ++level) {                                                                       \
                mollis_run run;                                                                                             \
                CALL(mollis_run_init, &run, sizeof run);                                                                    \
                run.level = levels[level];                                                                                  \
                for (size_t n = 0; n <= N; ++n) {                                                                           \
                    ARGUMENTS(D, _F32, n, at, mass, at);                                                                    \
                    if (mollis_field##D##_workspace_bytes##_F32(kernel, bytes, &sources, NULL, &outputs, NULL, &run, &needed)) {\
                        continue; /* not on this machine */                                                                 \
                    }                                                                                                       \
                    void *memory = memory_of(needed);                                                                       \
                    CALL(mollis_field##D##_eval##_F32, kernel, bytes, &sources, &targets, &outputs, NULL, &run, memory,     \
                         needed, NULL);                                                                                     \
                    free(memory);                                                                                           \
                }                                                                                                           \
            }                                                                                                               \
            free(kernel);                                                                                                   \
        }                                                                                                                   \
    }

NEWTONIAN(newtonian_line, 1, double, )
NEWTONIAN(newtonian_plane, 2, double, )
NEWTONIAN(newtonian_space, 3, double, )
NEWTONIAN(newtonian_line_f32, 1, float, _f32)
NEWTONIAN(newtonian_plane_f32, 2, float, _f32)
NEWTONIAN(newtonian_space_f32, 3, float, _f32)

/* Sums in order of position, on a line, where all positions are the same. */
#define SORTED(NAME, REAL, _F32)                                                                                            \
    static void NAME(void) {                                                                                                \
        static const mollis_kernel_term newtonian = {MOLLIS_KERNEL_NEWTONIAN, 0, 1, {0, 0}};                                \
        static const mollis_mollifier shape = {MOLLIS_MOLLIFIER_COMPACT, 2, 4};                                             \
        REAL x[N][1], apart[N][1], mass[N], out[2][N], gradient[N][1];                                                      \
        for (int k = 0; k < N; ++k) {                                                                                       \
            x[k][0] = (REAL)0.7;                                                                                            \
            apart[k][0] = (REAL)place(k, 0);                                                                                \
            mass[k] = 1;                                                                                                    \
        }                                                                                                                   \
        mollis_field_options options;                                                                                       \
        CALL(mollis_field_options_init, &options, sizeof options);                                                          \
        options.method = MOLLIS_METHOD_SORTED;                                                                              \
        size_t bytes, needed;                                                                                               \
        CALL(mollis_kernel1_bytes##_F32, &newtonian, 1, NULL, shape, &bytes);                                               \
        void *kernel = memory_of(bytes);                                                                                    \
        CALL(mollis_kernel1_prepare##_F32, kernel, bytes, &newtonian, 1, NULL, shape, (REAL)0.1);                           \
        void *memory = NULL;                                                                                                \
        for (int i = 0; i < 4; ++i) {                                                                                       \
            const REAL(*from)[1] = (const REAL(*)[1])(i % 2 == 0 ? x : apart);                                              \
            const REAL(*to)[1] = (const REAL(*)[1])(i / 2 == 0 ? x : apart);                                                \
            ARGUMENTS(1, _F32, N, from, mass, to);                                                                          \
            CALL(mollis_field1_workspace_bytes##_F32, kernel, bytes, &sources, &targets, &outputs, &options, NULL, &needed);\
            memory = memory ? memory : memory_of(needed);                                                                   \
            CALL(mollis_field1_eval##_F32, kernel, bytes, &sources, &targets, &outputs, &options, NULL, memory, needed, NULL);\
        }                                                                                                                   \
        free(memory);                                                                                                       \
        free(kernel);                                                                                                       \
    }

SORTED(sorted, double, )
SORTED(sorted_f32, float, _f32)

/* Steps under the sum over all pairs: with and without noise, with close pairs, in a column, of no particle. */
#define PAIRS(NAME, REAL, _F32)                                                                                             \
    static void NAME(void) {                                                                                                \
        static const mollis_kernel_term newtonian = {MOLLIS_KERNEL_NEWTONIAN, 0, 1, {0, 0}};                                \
        static const mollis_mollifier shape = {MOLLIS_MOLLIFIER_COMPACT, 4, 4};                                             \
        size_t bytes, needed;                                                                                               \
        CALL(mollis_kernel2_bytes##_F32, &newtonian, 1, NULL, shape, &bytes);                                               \
        void *kernel = memory_of(bytes);                                                                                    \
        CALL(mollis_kernel2_prepare##_F32, kernel, bytes, &newtonian, 1, NULL, shape, (REAL)0.05);                          \
        mollis_pks_attraction attraction;                                                                                   \
        memset(&attraction, 0, sizeof attraction);                                                                          \
        attraction.kind = MOLLIS_PKS_ATTRACTION_SUM;                                                                        \
        attraction.kernel = kernel;                                                                                         \
        attraction.kernel_bytes = bytes;                                                                                    \
        static const int32_t merging[] = {MOLLIS_PKS_MERGE_ALL, MOLLIS_PKS_MERGE_HARD, MOLLIS_PKS_MERGE_NEVER};             \
        for (int i = 0; i < 18; ++i) {                                                                                      \
            mollis_pks_options options;                                                                                     \
            CALL(mollis_pks_options_init, &options, sizeof options);                                                        \
            options.chi = 5;                                                                                                \
            options.noise = i % 2 == 0 ? 0 : 1;                                                                             \
            options.merging = merging[i / 2 % 3];                                                                           \
            for (size_t n = 0; n <= N; n += n < 9 ? 1 : 31) {                                                               \
                REAL x[N][2], mass[N];                                                                                      \
                uint64_t labels[N], absorbed[N];                                                                            \
                for (int k = 0; k < N; ++k) {                                                                               \
                    const double size = i / 6 == 2 ? 1e-4 : 1;                                                              \
                    x[k][0] = (REAL)(i / 6 == 1 ? 0.25 : size * place(k, 0));                                               \
                    x[k][1] = (REAL)(size * place(k, 1));                                                                   \
                    mass[k] = 1;                                                                                            \
                    labels[k] = (uint64_t)k;                                                                                \
                }                                                                                                           \
                mollis_pks_event log[N];                                                                                    \
                mollis_pks_events events = {log, N, 0, absorbed, N, 0};                                                     \
                mollis_pks_progress progress = {0, 0, n, 0};                                                                \
                const mollis_pks_particles##_F32 particles = {n, x, mass, labels, NULL, NULL};                               \
                options.seed = 7;                                                                                           \
                CALL(mollis_pks_workspace_bytes##_F32, n, &attraction, &options, NULL, &needed);                            \
                void *memory = memory_of(needed);                                                                           \
                CALL(mollis_pks_step##_F32, &particles, &progress, &attraction, NULL, 1e-3, 3, &events, &options, NULL, memory,\
                     needed, NULL);                                                                                         \
                free(memory);                                                                                               \
            }                                                                                                               \
        }                                                                                                                   \
        free(kernel);                                                                                                       \
    }

PAIRS(pairs, double, )
PAIRS(pairs_f32, float, _f32)

static void closed_forms(void) {
    const double masses[] = {2, 3};
    double index[3];
    mollis_pks_prediction known;
    for (int chi = -1; chi < 2; ++chi) {
        for (int noise = 0; noise < 2; ++noise) {
            CALL(mollis_pks_predict, 20, noise, chi, 7, 2, masses, &known);
            CALL(mollis_pks_index, 2, masses, chi, noise, 0.16, index);
        }
    }
}

int main(void) {
    signal(SIGFPE, trapped);
#ifdef __GLIBC__
    feenableexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);
#endif
    line();
    plane();
    space();
    line_f32();
    plane_f32();
    space_f32();
    newtonian_line();
    newtonian_plane();
    newtonian_space();
    newtonian_line_f32();
    newtonian_plane_f32();
    newtonian_space_f32();
    sorted();
    sorted_f32();
    meshes();
    meshes_f32();
    pairs();
    pairs_f32();
    closed_forms();
    printf("no floating-point exception was trapped\n");
    return 0;
}
