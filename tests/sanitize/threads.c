/* A host with threads of its own, for `cargo xtask sanitize`: an executor, and calls that run at the same time. Results equal those of one thread, bit for bit. */
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mollis.h"

enum { N = 3000, THREADS = 4, ROOM = 200 };
static double x[N][2], mass[N], serial[N][2], parallel[N][2], fast[2][N][2], gradients[THREADS][N][2];
static void *kernel;
static size_t kernel_bytes;

#define TRY(call)                                                                        \
    do {                                                                                 \
        mollis_status code = (call);                                                     \
        if (code != 0) {                                                                 \
            fprintf(stderr, "%d: %s: %s\n", __LINE__, #call, mollis_status_text(code)); \
            exit(1);                                                                     \
        }                                                                                \
    } while (0)

/* Tasks that threads take in turn. */
struct queue {
    pthread_mutex_t lock;
    size_t next, tasks;
    mollis_task task;
    void *data;
    int32_t first;
};

struct worker {
    struct queue *queue;
    size_t index;
    pthread_t thread;
};

static void *work(void *argument)
{
    struct worker *worker = argument;
    struct queue *queue = worker->queue;
    for (;;) {
        pthread_mutex_lock(&queue->lock);
        size_t index = queue->next++;
        pthread_mutex_unlock(&queue->lock);
        if (index >= queue->tasks) return NULL;
        int32_t code = queue->task(queue->data, index, worker->index);
        if (code != 0) {
            pthread_mutex_lock(&queue->lock);
            queue->first = code;
            pthread_mutex_unlock(&queue->lock);
        }
    }
}

static int32_t parallel_for(void *context, size_t tasks, mollis_task task, void *data)
{
    struct queue queue = {.next = 0, .tasks = tasks, .task = task, .data = data, .first = 0};
    struct worker workers[THREADS];
    (void)context;
    pthread_mutex_init(&queue.lock, NULL);
    for (size_t k = 0; k < THREADS; k++) {
        workers[k].queue = &queue;
        workers[k].index = k;
        if (pthread_create(&workers[k].thread, NULL, work, &workers[k]) != 0) abort();
    }
    for (size_t k = 0; k < THREADS; k++) pthread_join(workers[k].thread, NULL);
    pthread_mutex_destroy(&queue.lock);
    return queue.first;
}

static int32_t never(void *context)
{
    (void)context;
    return 0;
}

static mollis_run on(const mollis_executor *executor)
{
    mollis_run run;
    TRY(mollis_run_init(&run, sizeof run));
    run.executor = executor;
    run.should_stop = never;
    return run;
}

static void sum(const mollis_run *run, double tolerance, double (*gradient)[2])
{
    const mollis_sources2 sources = {.n = N, .positions = {&x[0][0]}, .masses = mass};
    const mollis_outputs2 outputs = {.gradient = {&gradient[0][0]}};
    mollis_field_options options;
    size_t bytes;
    TRY(mollis_field_options_init(&options, sizeof options));
    options.tolerance = tolerance;
    options.method = tolerance > 0 ? MOLLIS_METHOD_FMM : MOLLIS_METHOD_AUTO;
    TRY(mollis_field2_workspace_bytes(kernel, kernel_bytes, &sources, NULL, &outputs, &options, run, &bytes));
    void *workspace = malloc(bytes);
    TRY(mollis_field2_eval(kernel, kernel_bytes, &sources, NULL, &outputs, &options, run, workspace, bytes, NULL));
    free(workspace);
}

static double blob(const mollis_run *run)
{
    double(*y)[2] = malloc(sizeof x), total = 0;
    memcpy(y, x, sizeof x);
    const mollis_particles2 particles = {.n = N, .positions = {&y[0][0]}, .masses = mass};
    size_t bytes;
    TRY(mollis_blob2_workspace_bytes(kernel, kernel_bytes, &particles, NULL, NULL, run, &bytes));
    void *workspace = malloc(bytes);
    TRY(mollis_blob2_step(kernel, kernel_bytes, &particles, NULL, 0.01, 2, NULL, run, workspace, bytes, NULL));
    for (int i = 0; i < N; i++) total += y[i][0] * (i + 1) + y[i][1];
    free(workspace);
    free(y);
    return total;
}

static double mesh(const mollis_run *run)
{
    const mollis_mesh2 rectangle = {{-0.5, -0.5}, {1.5, 1.5}, {32, 32}};
    const mollis_sources2 sources = {.n = N, .positions = {&x[0][0]}, .masses = mass};
    double(*gradient)[2] = malloc(sizeof x), total = 0;
    const mollis_grid2_outputs outputs = {.gradient = {&gradient[0][0]}};
    size_t bytes;
    TRY(mollis_grid2_workspace_bytes(&rectangle, &sources, NULL, &outputs, NULL, run, &bytes));
    void *workspace = malloc(bytes);
    TRY(mollis_grid2_eval(&rectangle, &sources, NULL, &outputs, NULL, run, workspace, bytes));
    for (int i = 0; i < N; i++) total += gradient[i][0] * (i + 1) + gradient[i][1];
    free(workspace);
    free(gradient);
    return total;
}

static double coalescing(const mollis_run *run)
{
    double(*y)[2] = malloc(ROOM * sizeof *y), *m = malloc(ROOM * sizeof *m), total = 0;
    uint64_t *labels = malloc(ROOM * sizeof *labels), absorbed[ROOM];
    mollis_pks_event log[ROOM];
    for (int i = 0; i < ROOM; i++) {
        y[i][0] = x[i][0];
        y[i][1] = x[i][1];
        m[i] = 100.0 / ROOM;
        labels[i] = (uint64_t)i;
    }
    const mollis_pks_particles particles = {ROOM, y, m, labels, NULL};
    mollis_pks_progress progress = {.count = ROOM};
    const mollis_pks_attraction attraction = {
        .kind = MOLLIS_PKS_ATTRACTION_SUM, .kernel = kernel, .kernel_bytes = kernel_bytes};
    mollis_pks_events events = {log, ROOM, 0, absorbed, ROOM, 0};
    mollis_pks_options options;
    size_t bytes;
    TRY(mollis_pks_options_init(&options, sizeof options));
    options.chi = 1;
    options.noise = 0.5;
    TRY(mollis_pks_workspace_bytes(ROOM, &attraction, &options, run, &bytes));
    void *workspace = malloc(bytes);
    TRY(mollis_pks_step(&particles, &progress, &attraction, NULL, 1e-4, 10, &events, &options, run, workspace, bytes, NULL));
    for (uint64_t i = 0; i < progress.count; i++) total += y[i][0] * (double)(labels[i] + 1) + y[i][1];
    free(workspace);
    free(labels);
    free(m);
    free(y);
    return total;
}

/* One of several calls that run at the same time on one kernel and the same sources. */
static void *alone(void *argument)
{
    sum(NULL, 0, argument);
    return NULL;
}

int main(void)
{
    const mollis_kernel_term term = {MOLLIS_KERNEL_NEWTONIAN, 0, 1.0, {0.0, 0.0}};
    const mollis_mollifier mollifier = {MOLLIS_MOLLIFIER_COMPACT, 4, 4};
    pthread_t threads[THREADS];
    TRY(mollis_kernel2_bytes(&term, 1, NULL, mollifier, &kernel_bytes));
    kernel = malloc(kernel_bytes);
    TRY(mollis_kernel2_prepare(kernel, kernel_bytes, &term, 1, NULL, mollifier, 0.05));
    for (int i = 0; i < N; i++) {
        x[i][0] = fmod(0.754877666 * (i + 1), 1.0);
        x[i][1] = fmod(0.569840291 * (i + 1), 1.0);
        mass[i] = 1.0 / N;
    }

    /* The first sums of the process run at the same time: each asks for the machine's instructions. */
    for (int k = 0; k < THREADS; k++)
        if (pthread_create(&threads[k], NULL, alone, gradients[k]) != 0) abort();
    for (int k = 0; k < THREADS; k++) pthread_join(threads[k], NULL);
    sum(NULL, 0, serial);
    for (int k = 0; k < THREADS; k++)
        if (memcmp(gradients[k], serial, sizeof x) != 0) return 6;

    const mollis_executor executor = {NULL, THREADS, parallel_for};
    const mollis_run run = on(&executor), one = on(NULL);
    sum(&run, 0, parallel);
    if (memcmp(parallel, serial, sizeof x) != 0) return 1;
    sum(&one, 1e-6, fast[0]);
    sum(&run, 1e-6, fast[1]);
    if (memcmp(fast[0], fast[1], sizeof x) != 0) return 2;
    if (blob(&one) != blob(&run)) return 3;
    if (mesh(&one) != mesh(&run)) return 4;
    if (coalescing(&one) != coalescing(&run)) return 5;
    free(kernel);
    puts("threads: the same bits");
    return 0;
}
