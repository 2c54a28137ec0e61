/* Bad input: the status codes of every function of the three other programs, one wrong argument at a time. */
#include "board.h"
#include "mollis.h"
#include "report.h"

enum { N = 5 };

static const float INFINITE = 1.0f / 0.0f;
static const double WIDE_INFINITE = 1.0 / 0.0;

static float r[N], values[N], positions[N][2], masses[N], density[N];
static uint64_t labels[N], absorbed[N];
static mollis_pks_event log_of_merges[N];
static _Alignas(MOLLIS_ALIGN) unsigned char kernel[MOLLIS_KERNEL2_NEWTONIAN_BYTES_F32];
static _Alignas(MOLLIS_ALIGN) unsigned char blob_workspace[MOLLIS_BLOB2_WORKSPACE_BYTES_F32(N) + 64];
static _Alignas(MOLLIS_ALIGN) unsigned char pks_workspace[MOLLIS_PKS_WORKSPACE_BYTES_F32(N)];
static const mollis_particles2_f32 blob = {.n = N, .positions = {&positions[0][0]}, .masses = masses, .density = density};
static const mollis_pks_particles_f32 coalescing = {N, positions, masses, labels, 0, 0};
static mollis_run portable;

static void good_arrays(void) {
  int k;
  for (k = 0; k < N; ++k) {
    r[k] = 0.25f * (float)k;
    positions[k][0] = 0.125f * (float)k;
    positions[k][1] = 0.5f - 0.0625f * (float)(k * k);
    masses[k] = 0.25f;
    density[k] = 1.0f;
    labels[k] = (uint64_t)k;
  }
}

static int32_t table(int32_t kind, int32_t order, int32_t exponent, float delta, size_t n, const float *at, float *out) {
  const mollis_mollifier mollifier = {kind, order, exponent};
  return mollis_mollifier2_eval_f32(mollifier, delta, n, at, out, 0, 0, 0, 0, 0);
}

static void mollifiers(void) {
  const int32_t compact = MOLLIS_MOLLIFIER_COMPACT;
  const float *askew = (const float *)(const void *)((const char *)r + 1);
  put_status("good", table(compact, 2, 3, 1.0f, N, r, values));
  put_status("order 5", table(compact, 5, 3, 1.0f, N, r, values));
  put_status("order -2", table(compact, -2, 3, 1.0f, N, r, values));
  put_status("exponent 0", table(compact, 2, 0, 1.0f, N, r, values));
  put_status("exponent 10", table(compact, 2, 10, 1.0f, N, r, values));
  put_status("kind 7", table(7, 2, 3, 1.0f, N, r, values));
  put_status("delta 0", table(compact, 2, 3, 0.0f, N, r, values));
  put_status("delta -1", table(compact, 2, 3, -1.0f, N, r, values));
  put_status("infinite delta", table(compact, 2, 3, INFINITE, N, r, values));
  put_status("delta no number", table(compact, 2, 3, INFINITE - INFINITE, N, r, values));
  put_status("null input", table(compact, 2, 3, 1.0f, N, 0, values));
  put_status("null input of none", table(compact, 2, 3, 1.0f, 0, 0, 0));
  put_status("overlap", table(compact, 2, 3, 1.0f, N, r, r + 1));
  put_status("misaligned", table(compact, 2, 3, 1.0f, N, askew, values));
  put_status("too many", table(compact, 2, 3, 1.0f, SIZE_MAX, r, values));
  r[N - 1] = INFINITE;
  put_status("infinite r", table(compact, 2, 3, 1.0f, N, r, values));
  good_arrays();
}

static int32_t prepare(int32_t kind, double coefficient, size_t terms, int32_t exponent, float delta, size_t bytes) {
  const mollis_mollifier mollifier = {MOLLIS_MOLLIFIER_COMPACT, 4, exponent};
  const mollis_kernel_term term = {kind, 0, coefficient, {0.0, 0.0}};
  return mollis_kernel2_prepare_f32(kernel, bytes, &term, terms, 0, mollifier, delta);
}

static void kernels(void) {
  put_status("no term", prepare(MOLLIS_KERNEL_NEWTONIAN, 1.0, 0, 5, 0.5f, sizeof kernel));
  put_status("kind 4", prepare(4, 1.0, 1, 5, 0.5f, sizeof kernel));
  put_status("infinite coefficient", prepare(MOLLIS_KERNEL_NEWTONIAN, WIDE_INFINITE, 1, 5, 0.5f, sizeof kernel));
  put_status("coefficient 1e300", prepare(MOLLIS_KERNEL_NEWTONIAN, 1e300, 1, 5, 0.5f, sizeof kernel));
  put_status("exponent 11", prepare(MOLLIS_KERNEL_NEWTONIAN, 1.0, 1, 11, 0.5f, sizeof kernel));
  put_status("delta 0", prepare(MOLLIS_KERNEL_NEWTONIAN, 1.0, 1, 5, 0.0f, sizeof kernel));
  put_status("a byte too few", prepare(MOLLIS_KERNEL_NEWTONIAN, 1.0, 1, 5, 0.5f, sizeof kernel - 1));
  put_status("good", prepare(MOLLIS_KERNEL_NEWTONIAN, -1.0, 1, 5, 0.5f, sizeof kernel));
}

static int32_t advance(const void *with, double dt, void *workspace, size_t bytes, const mollis_blob_options *options) {
  return mollis_blob2_step_f32(with, sizeof kernel, &blob, 0, dt, 1, options, &portable, workspace, bytes, 0);
}

static void blobs(void) {
  const size_t bytes = MOLLIS_BLOB2_WORKSPACE_BYTES_F32(N);
  static mollis_blob_options options;
  float *before = &positions[0][0];
  mollis_particles2_f32 changed;
  put_status("options of no size", mollis_blob_options_init(&options, 0));
  put_status("options too large", mollis_blob_options_init(&options, sizeof options + 1));
  put_status("null options", mollis_blob_options_init(0, sizeof options));
  mollis_blob_options_init(&options, sizeof options);
  put_status("good", advance(kernel, 0.125, blob_workspace, bytes, &options));
  put_status("no kernel", advance(pks_workspace, 0.125, blob_workspace, bytes, 0));
  put_status("null kernel", advance(0, 0.125, blob_workspace, bytes, 0));
  put_status("dt 0", advance(kernel, 0.0, blob_workspace, bytes, 0));
  put_status("dt -1", advance(kernel, -1.0, blob_workspace, bytes, 0));
  put_status("infinite dt", advance(kernel, WIDE_INFINITE, blob_workspace, bytes, 0));
  put_status("null workspace", advance(kernel, 0.125, 0, bytes, 0));
  put_status("a byte too few", advance(kernel, 0.125, blob_workspace, bytes - 1, 0));
  put_status("workspace anywhere", advance(kernel, 0.125, blob_workspace + 4, bytes, 0));
  good_arrays();
  put_status("workspace in the way", advance(blob_workspace, 0.125, blob_workspace, bytes, 0));
  put_status("kernel of a byte too few",
             mollis_blob2_step_f32(kernel, 63, &blob, 0, 0.125, 1, 0, &portable, blob_workspace, bytes, 0));
  put_status("null particles",
             mollis_blob2_step_f32(kernel, sizeof kernel, 0, 0, 0.125, 1, 0, &portable, blob_workspace, bytes, 0));
  changed = blob;
  changed.positions[0] = 0;
  put_status("null positions",
             mollis_blob2_step_f32(kernel, sizeof kernel, &changed, 0, 0.125, 1, 0, &portable, blob_workspace, bytes, 0));
  options.tolerance = -1.0;
  put_status("negative tolerance", advance(kernel, 0.125, blob_workspace, bytes, &options));
  options.tolerance = WIDE_INFINITE;
  put_status("infinite tolerance", advance(kernel, 0.125, blob_workspace, bytes, &options));
  options.size = 3;
  put_status("options of three bytes", advance(kernel, 0.125, blob_workspace, bytes, &options));
  portable.level = 77;
  put_status("level 77", advance(kernel, 0.125, blob_workspace, bytes, 0));
  portable.level = MOLLIS_LEVEL_PORTABLE;
  positions[2][1] = INFINITE;
  put_status("infinite position", advance(kernel, 0.125, blob_workspace, bytes, 0));
  good_arrays();
  masses[1] = INFINITE - INFINITE;
  put_status("mass no number", advance(kernel, 0.125, blob_workspace, bytes, 0));
  good_arrays();
  density[4] = -INFINITE;
  put_status("infinite density", advance(kernel, 0.125, blob_workspace, bytes, 0));
  good_arrays();
  masses[0] = 3e38f;
  put_status("becomes infinite", advance(kernel, 1e30, blob_workspace, bytes, 0));
  good_arrays();
  put_float(*before);
  put_line();
}

static int32_t draw(void *state, uint64_t *out, size_t n) {
  while (n-- > 0) *out++ = (*(uint64_t *)state += 0x9e3779b97f4a7c15u);
  return 0;
}

static int32_t fail(void *state, uint64_t *out, size_t n) {
  (void)state, (void)out, (void)n;
  return MOLLIS_ERR_GENERATOR;
}

static uint64_t state;
static mollis_generator generator;
static mollis_pks_options options;
static mollis_pks_attraction attraction;
static mollis_pks_progress progress;
static mollis_pks_events events;

static void good_run(void) {
  const mollis_generator drawing = {&state, draw};
  const mollis_pks_progress start = {0.0, 0, N, 0};
  const mollis_pks_events empty = {log_of_merges, N, 0, absorbed, N, 0};
  good_arrays();
  mollis_pks_options_init(&options, sizeof options);
  options.chi = 3.0;
  options.noise = 0.125;
  attraction.kind = MOLLIS_PKS_ATTRACTION_SUM;
  attraction.kernel = kernel;
  attraction.kernel_bytes = sizeof kernel;
  attraction.tolerance = 0.0;
  generator = drawing;
  progress = start;
  events = empty;
}

/* One step with the current arguments, which are then reset to valid ones. */
static void step(const char *name, double dt, size_t bytes) {
  put_status(name, mollis_pks_step_f32(&coalescing, &progress, &attraction, &generator, dt, 1, &events, &options, &portable,
                                       pks_workspace, bytes, 0));
  good_run();
}

static void coalescence(void) {
  const size_t all = sizeof pks_workspace;
  const double dt = 0.0078125;
  good_run();
  step("good", dt, all);
  step("dt 0", 0.0, all);
  step("infinite dt", WIDE_INFINITE, all);
  step("a byte too few", dt, all - 1);
  options.size = 2;
  step("options of two bytes", dt, all);
  options.law = 9;
  step("law 9", dt, all);
  options.merging = -1;
  step("merging -1", dt, all);
  options.scheme = 2;
  step("scheme 2", dt, all);
  options.noise = -1.0;
  step("negative noise", dt, all);
  options.chi = WIDE_INFINITE;
  step("infinite chi", dt, all);
  options.separation = 1.0;
  step("separation 1", dt, all);
  options.probability = 0.0;
  step("probability 0", dt, all);
  options.width = -1.0;
  step("width -1", dt, all);
  options.mesh[1] = 0;
  step("mesh of no cell", dt, all);
  options.domain[0] = 1.0;
  step("empty domain", dt, all);
  options.at_least = 9;
  options.at_most = 8;
  step("at least 9, at most 8", dt, all);
  attraction.kind = 5;
  step("attraction 5", dt, all);
  attraction.kernel = 0;
  step("null kernel", dt, all);
  attraction.tolerance = WIDE_INFINITE;
  step("infinite tolerance", dt, all);
  generator.fill = 0;
  step("null generator", dt, all);
  generator.fill = fail;
  step("generator that fails", dt, all);
  progress.count = N + 1;
  step("more than there is room for", dt, all);
  progress.pending = 1;
  step("pending merges that are not there", dt, all);
  progress.step = (uint64_t)1 << 32;
  step("too many steps", dt, all);
  events.written = N + 1;
  step("more events than room", dt, all);
  events.events = 0;
  step("null events", dt, all);
  events.labels = &labels[1];
  step("overlap", dt, all);
  masses[3] = 0.0f;
  step("mass 0", dt, all);
  masses[3] = -1.0f;
  step("negative mass", dt, all);
  masses[3] = INFINITE;
  step("infinite mass", dt, all);
  positions[3][0] = INFINITE - INFINITE;
  step("position no number", dt, all);
  options.width = 1e-6;
  options.at_most = 10;
  step("too many sub-steps", 1.0, all);
}

int run(void) {
  mollis_run_init(&portable, sizeof portable);
  portable.level = MOLLIS_LEVEL_PORTABLE;
  good_arrays();
  mollifiers();
  kernels();
  blobs();
  coalescence();
  put_measure("stack", board_stack());
  return 0;
}
