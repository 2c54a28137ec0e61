/* 200 coalescing particles of the Patlak-Keller-Segel model without a grid, with a random generator defined here, in static
 * buffers of the smallest size. */
#include "board.h"
#include "mollis.h"
#include "report.h"

enum { N = 200, STEPS = 8 };

static float positions[N][2], masses[N];
static uint64_t labels[N], absorbed[N];
static mollis_pks_event log_of_merges[N];
static _Alignas(MOLLIS_ALIGN) unsigned char kernel[MOLLIS_KERNEL2_NEWTONIAN_BYTES_F32];
static _Alignas(MOLLIS_ALIGN) unsigned char workspace[MOLLIS_PKS_WORKSPACE_BYTES_F32(N)];
static mollis_pks_events events = {log_of_merges, N, 0, absorbed, N, 0};
static const mollis_pks_particles_f32 particles = {N, positions, masses, labels, 0, 0};
static mollis_pks_progress progress = {0.0, 0, N, 0};
static mollis_pks_options options;
static mollis_pks_attraction attraction;
static mollis_run portable;

/* Marsaglia's xorshift with Vigna's multiplier. */
static int32_t xorshift(void *state, uint64_t *out, size_t n) {
  uint64_t x = *(uint64_t *)state;
  if (x == 0) return MOLLIS_ERR_GENERATOR;
  while (n-- > 0) {
    x ^= x >> 12;
    x ^= x << 25;
    x ^= x >> 27;
    *out++ = x * 0x2545f4914f6cdd1du;
  }
  *(uint64_t *)state = x;
  return 0;
}

static uint64_t state = 88172645463325252u;
static mollis_generator generator = {&state, xorshift};

static void start(void) {
  int k;
  for (k = 0; k < N; ++k) {
    uint64_t bits;
    xorshift(&state, &bits, 1);
    /* A square of side 1/2 about the origin; multiples of 2^-17. */
    positions[k][0] = (float)((int32_t)(bits & 0xffff) - 0x8000) * (1.0f / 131072.0f);
    positions[k][1] = (float)((int32_t)(bits >> 16 & 0xffff) - 0x8000) * (1.0f / 131072.0f);
    masses[k] = 0.125f;
    labels[k] = (uint64_t)k;
  }
}

static int32_t step(double dt, size_t steps, size_t bytes) {
  return mollis_pks_step_f32(&particles, &progress, &attraction, &generator, dt, steps, &events, &options, &portable, workspace,
                             bytes, 0);
}

static void put_double(double value) {
  union {
    double value;
    uint32_t bits[2];
  } raw;
  raw.value = value;
  put_hex(raw.bits[1]);
  put_hex(raw.bits[0]);
}

int run(void) {
  const mollis_mollifier mollifier = {MOLLIS_MOLLIFIER_COMPACT, 2, 4};
  const mollis_kernel_term newtonian = {MOLLIS_KERNEL_NEWTONIAN, 0, 1.0, {0.0, 0.0}};
  uint32_t before, all;
  size_t k;
  mollis_run_init(&portable, sizeof portable);
  portable.level = MOLLIS_LEVEL_PORTABLE;
  mollis_pks_options_init(&options, sizeof options);
  options.chi = 3.0;
  options.noise = 0.125;
  attraction.kind = MOLLIS_PKS_ATTRACTION_SUM;
  attraction.kernel = kernel;
  attraction.kernel_bytes = sizeof kernel;
  put_status("prepare", mollis_kernel2_prepare_f32(kernel, sizeof kernel, &newtonian, 1, 0, mollifier, 0.0625f));
  start();
  before = board_instructions();
  put_status("step", step(0.0009765625, 1, sizeof workspace));
  all = board_instructions() - before;
  put_measure("step", all);
  put_measure("pair", all / (N * N));
  put_status("steps", step(0.0009765625, STEPS - 1, sizeof workspace));
  put_number((uint32_t)progress.step);
  put_number((uint32_t)progress.count);
  put_double(progress.time);
  put_line();
  for (k = 0; k < progress.count; ++k) {
    put_number((uint32_t)labels[k]);
    put_float(positions[k][0]);
    put_float(positions[k][1]);
    put_float(masses[k]);
    put_line();
  }
  for (k = 0; k < events.written; ++k) {
    const mollis_pks_event *event = &log_of_merges[k];
    put_text("merge");
    put_number((uint32_t)event->label);
    put_number((uint32_t)event->first);
    put_number((uint32_t)event->absorbed);
    put_double(event->time);
    put_double(event->mass);
    put_double(event->index);
    put_line();
  }
  for (k = 0; k < events.labels_written; ++k) put_number((uint32_t)absorbed[k]);
  put_line();
  put_status("a byte too few", step(0.1, 1, sizeof workspace - 1));
  put_measure("stack", board_stack());
  return 0;
}
