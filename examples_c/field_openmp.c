/* Sums over 2000 particles on the host's own threads: OpenMP as the executor. The same bits come out for any number of
 * threads. Build: cc -fopenmp field_openmp.c -lmollis -lm */
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mollis.h"

enum { N = 2000 };
static double x[N][2], mass[N], gradient[2][N][2];

#define TRY(call)                                                          \
    do {                                                                   \
        mollis_status code = (call);                                       \
        if (code != 0) {                                                   \
            fprintf(stderr, "%s: %s\n", #call, mollis_status_text(code)); \
            return 1;                                                      \
        }                                                                  \
    } while (0)

/* mollis asks for `tasks` independent tasks; each worker index runs one at a time. */
static int32_t parallel_for(void *context, size_t tasks, mollis_task task, void *data)
{
    const int threads = *(const int *)context;
    int32_t first = 0;
#pragma omp parallel for num_threads(threads) schedule(dynamic)
    for (long long i = 0; i < (long long)tasks; i++) {
        const int32_t code = task(data, (size_t)i, (size_t)omp_get_thread_num());
        if (code != 0) {
#pragma omp critical
            first = code;
        }
    }
    return first;
}

int main(void)
{
    for (int i = 0; i < N; i++) {
        x[i][0] = fmod(0.754877666 * (i + 1), 1.0);
        x[i][1] = fmod(0.569840291 * (i + 1), 1.0);
        mass[i] = 1.0 / N;
    }

    /* The kernel: Newtonian, softened by the compact mollifier of order 2, M = 4, delta = 0.1. */
    const mollis_kernel_term term = {MOLLIS_KERNEL_NEWTONIAN, 0, 1.0, {0.0, 0.0}};
    const mollis_mollifier mollifier = {MOLLIS_MOLLIFIER_COMPACT, 2, 4};
    size_t kernel_bytes, bytes;
    TRY(mollis_kernel2_bytes(&term, 1, NULL, mollifier, &kernel_bytes));
    void *kernel = malloc(kernel_bytes);
    if (!kernel) abort();
    TRY(mollis_kernel2_prepare(kernel, kernel_bytes, &term, 1, NULL, mollifier, 0.1));

    char text[512];
    /* The gradient, at the sources themselves. */
    const mollis_sources2 sources = {.n = N, .positions = {&x[0][0]}, .masses = mass};
    mollis_outputs2 outputs = {.gradient = {&gradient[0][0][0]}};
    TRY(mollis_field2_text(kernel, kernel_bytes, &sources, NULL, &outputs, NULL, text, sizeof text, NULL));
    puts(text);

    int threads = 1;
    mollis_executor executor = {&threads, 1, parallel_for};
    mollis_run run;
    TRY(mollis_run_init(&run, sizeof run));
    run.executor = &executor;
    mollis_field_counts counters = {0};
    for (int k = 0; k < 2; k++) {
        threads = k + 1;
        executor.workers = (size_t)threads;
        outputs.gradient[0] = &gradient[k][0][0];
        TRY(mollis_field2_workspace_bytes(kernel, kernel_bytes, &sources, NULL, &outputs, NULL, &run, &bytes));
        void *workspace = malloc(bytes);
        TRY(mollis_field2_eval(kernel, kernel_bytes, &sources, NULL, &outputs, NULL, &run, workspace, bytes, &counters));
        free(workspace);
    }
    free(kernel);

    printf("pairs: %llu\n", (unsigned long long)counters.pairs);
    printf("1 and 2 threads: %s\n", memcmp(gradient[0], gradient[1], sizeof gradient[0]) == 0 ? "same bits" : "differ");
    return memcmp(gradient[0], gradient[1], sizeof gradient[0]) != 0;
}
