/* A program that knows an installed mollis only: the total mass and the centre of 5000 equal points on a line, from a mesh, with a pool of threads
 * if POOL is defined. The result is 0 if they are 1250 and the middle. */
#ifdef POOL
#include "mollis_mt.h"
#else
#include "mollis.h"
#endif
#include <stdlib.h>
#include <string.h>

enum { N = 5000 };
static double x[N][2], m[N], gradient[N][2];

int main(void) {
  const mollis_mesh2 mesh = {{0.0, 0.0}, {1.0, 1.0}, {16, 16}};
  mollis_run run;
  mollis_sources2 sources;
  mollis_grid2_outputs outputs;
  size_t bytes, k;
  void *memory;
  double total[3];
  mollis_run_init(&run, sizeof run);
#ifdef POOL
  mollis_pool *pool;
  mollis_executor executor;
  if (mollis_pool_init(2, &pool) || mollis_pool_executor(pool, &executor)) return 1;
  run.executor = &executor;
#endif
  for (k = 0; k < N; ++k) {
    x[k][0] = ((double)k + 0.5) / N;
    x[k][1] = 0.5;
    m[k] = 0.25;
  }
  memset(&sources, 0, sizeof sources);
  memset(&outputs, 0, sizeof outputs);
  sources.n = N;
  sources.positions[0] = &x[0][0];
  sources.masses = m;
  outputs.gradient[0] = &gradient[0][0];
  outputs.total = &total;
  if (mollis_grid2_workspace_bytes(&mesh, &sources, 0, &outputs, 0, &run, &bytes)) return 2;
  memory = malloc(bytes);
  if (memory == 0) return 3;
  if (mollis_grid2_eval(&mesh, &sources, 0, &outputs, 0, &run, memory, bytes)) return 4;
  free(memory);
#ifdef POOL
  mollis_pool_free(pool);
#endif
  /* Each mass is rounded by at most 2^-50 of the whole: 6e-9 for all. */
  return total[0] - 1250.0 > 1e-8 || total[0] - 1250.0 < -1e-8 || total[1] < 0.499999 || total[1] > 0.500001;
}
