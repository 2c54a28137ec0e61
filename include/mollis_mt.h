/* A ready thread pool for mollis: link libmollis_mt instead of libmollis (pkg-config mollis_mt), and make the same calls.
 *
 *     mollis_pool *pool;
 *     mollis_executor executor;
 *     mollis_run run;
 *     mollis_pool_init(0, &pool);
 *     mollis_pool_executor(pool, &executor);
 *     mollis_run_init(&run, sizeof run);
 *     run.executor = &executor;
 *     ... calls with &run ...
 *     mollis_pool_free(pool);
 */
#ifndef MOLLIS_MT_H
#define MOLLIS_MT_H

#include "mollis.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A pool of threads. */
typedef struct mollis_pool mollis_pool;

/* Starts a pool of `threads` threads (0: as many as the machine has, at most 256) and sets *pool. */
mollis_status mollis_pool_init(size_t threads, mollis_pool **pool);

/* Sets *executor to run tasks on the pool: put its address into a mollis_run. Valid as long as the pool. */
mollis_status mollis_pool_executor(const mollis_pool *pool, mollis_executor *executor);

/* Ends the pool's threads. Null is ignored. No call may be using it. */
void mollis_pool_free(mollis_pool *pool);

#ifdef __cplusplus
}
#endif
#endif
