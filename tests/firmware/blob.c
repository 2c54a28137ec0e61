/* 64 particles of the blob method in the plane, advanced by RK4, in static buffers of the smallest size. */
#include "board.h"
#include "mollis.h"
#include "report.h"

enum { SIDE = 8, N = SIDE * SIDE, STEPS = 4 };

static float positions[N][2], masses[N], density[N];
static _Alignas(MOLLIS_ALIGN) unsigned char kernel[MOLLIS_KERNEL2_NEWTONIAN_BYTES_F32];
static _Alignas(MOLLIS_ALIGN) unsigned char workspace[MOLLIS_BLOB2_WORKSPACE_BYTES_F32(N)];
static const mollis_particles2_f32 particles = {.n = N, .positions = {&positions[0][0]}, .masses = masses, .density = density};
static mollis_run portable;

static void start(void) {
  const float h = 0.25f;
  int i, j, k = 0;
  for (j = 0; j < SIDE; ++j) {
    for (i = 0; i < SIDE; ++i, ++k) {
      const float x = h * ((float)i - 3.5f), y = h * ((float)j - 3.5f), s = 1.0f - x * x - y * y;
      positions[k][0] = x;
      positions[k][1] = y;
      density[k] = s > 0.0f ? s * s : 0.0f;
      masses[k] = h * h * density[k];
    }
  }
}

static int32_t step(double dt, size_t steps, size_t bytes) {
  return mollis_blob2_step_f32(kernel, sizeof kernel, &particles, 0, dt, steps, 0, &portable, workspace, bytes, 0);
}

int run(void) {
  const mollis_mollifier mollifier = {MOLLIS_MOLLIFIER_COMPACT, 4, 5};
  const mollis_kernel_term newtonian = {MOLLIS_KERNEL_NEWTONIAN, 0, 1.0, {0.0, 0.0}};
  uint32_t before, one, all;
  int k;
  mollis_run_init(&portable, sizeof portable);
  portable.level = MOLLIS_LEVEL_PORTABLE;
  put_status("prepare", mollis_kernel2_prepare_f32(kernel, sizeof kernel, &newtonian, 1, 0, mollifier, 0.6f));
  start();
  before = board_instructions();
  put_status("step", step(0.05, 1, sizeof workspace));
  one = board_instructions() - before;
  before = board_instructions();
  put_status("steps", step(0.05, 1 + STEPS, sizeof workspace));
  all = board_instructions() - before;
  for (k = 0; k < N; ++k) {
    put_float(positions[k][0]);
    put_float(positions[k][1]);
    put_float(density[k]);
    put_line();
  }
  put_measure("step", (all - one) / STEPS);
  put_measure("pair", (all - one) / STEPS / (4 * N * N));
  put_status("a byte too few", step(0.05, 1, sizeof workspace - 1));
  put_measure("stack", board_stack());
  return 0;
}
