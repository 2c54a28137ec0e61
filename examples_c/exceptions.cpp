/*
 * C++ exceptions and mollis: no exception may leave a function that the library calls. The function catches it, keeps it and returns a
 * status; the wrapper around the call throws it again. The same way a longjmp is replaced by a status.
 *
 * Three functions of the host throw here: the executor, the generator of random numbers, and what is called after each step.
 */
#include <cstdint>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include "mollis.h"

namespace {

/* What the functions of this program return for "an exception is kept". The library's own statuses are 1 to 255. */
const mollis_status THROWN = 1000;

/* The exception on its way around the library. */
std::exception_ptr kept;

/* Calls a body that may throw, and says with a status whether it did. */
template <typename Body> mollis_status guarded(Body body) {
  try {
    body();
    return MOLLIS_OK;
  } catch (...) {
    kept = std::current_exception();
    return THROWN;
  }
}

/* Throws what was kept during a call, or an error of its own for another status. */
void check(mollis_status status) {
  if (kept) {
    std::exception_ptr thrown = kept;
    kept = nullptr;
    std::rethrow_exception(thrown);
  }
  if (status != MOLLIS_OK) throw std::runtime_error(mollis_status_text(status));
}

/* Memory that frees itself. */
class Memory {
public:
  explicit Memory(std::size_t bytes) : bytes_((bytes + sizeof(double) - 1) / sizeof(double)) {}
  void *get() { return bytes_.data(); }

private:
  std::vector<double> bytes_;
};

} // namespace

extern "C" {

static std::int32_t no_tasks(void *, std::size_t, mollis_task, void *) {
  return guarded([] { throw std::runtime_error("from the executor"); });
}

static std::int32_t no_numbers(void *, std::uint64_t *, std::size_t) {
  return guarded([] { throw std::runtime_error("from the generator"); });
}

static std::int32_t after_two_steps(void *, std::size_t steps, const void *, const void *) {
  return guarded([steps] {
    if (steps == 2) throw std::runtime_error("after two steps");
  });
}
}

namespace {

/* The blob method, with an executor or a function after each step that throws. */
void blobs(bool executor_throws) {
  const mollis_mollifier mollifier = {MOLLIS_MOLLIFIER_COMPACT, 4, 4};
  const mollis_kernel_term newtonian = {MOLLIS_KERNEL_NEWTONIAN, 0, 1.0, {0.0, 0.0}};
  std::size_t bytes = 0;
  check(mollis_kernel2_bytes(&newtonian, 1, nullptr, mollifier, &bytes));
  Memory kernel(bytes);
  const std::size_t kernel_bytes = bytes;
  check(mollis_kernel2_prepare(kernel.get(), kernel_bytes, &newtonian, 1, nullptr, mollifier, 0.5));

  double positions[3][2] = {{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}};
  const double masses[3] = {1.0, 1.0, 1.0};
  mollis_blob_options options;
  mollis_run run;
  check(mollis_blob_options_init(&options, sizeof options));
  check(mollis_run_init(&run, sizeof run));
  const mollis_executor executor = {nullptr, 1, no_tasks};
  if (executor_throws) {
    run.executor = &executor;
  } else {
    options.after_step = after_two_steps;
  }
  mollis_particles2 blob = {};
  blob.n = 3;
  blob.positions[0] = positions[0];
  blob.masses = masses;
  check(mollis_blob2_workspace_bytes(kernel.get(), kernel_bytes, &blob, nullptr, &options, &run, &bytes));
  Memory workspace(bytes);
  check(mollis_blob2_step(kernel.get(), kernel_bytes, &blob, nullptr, 0.01, 5, &options, &run, workspace.get(), bytes, nullptr));
}

/* Diffusing particles, with a generator that throws. */
void particles() {
  double positions[2][2] = {{0.0, 0.0}, {1.0, 0.0}}, masses[2] = {1.0, 1.0};
  std::uint64_t labels[2] = {0, 1};
  mollis_pks_options options;
  check(mollis_pks_options_init(&options, sizeof options));
  options.noise = 1.0;
  mollis_pks_attraction attraction = {};
  const mollis_pks_particles pair = {2, positions, masses, labels, nullptr, nullptr};
  mollis_pks_progress progress = {};
  mollis_pks_events events = {};
  progress.count = 2;
  std::size_t bytes = 0;
  check(mollis_pks_workspace_bytes(2, &attraction, &options, nullptr, &bytes));
  Memory workspace(bytes);
  const mollis_generator generator = {nullptr, no_numbers};
  check(mollis_pks_step(&pair, &progress, &attraction, &generator, 0.1, 1, &events, &options, nullptr, workspace.get(), bytes,
                        nullptr));
}

/* Whether the body throws just this. */
template <typename Body> bool throws(const char *what, Body body) {
  try {
    body();
  } catch (const std::runtime_error &error) {
    std::printf("caught: %s\n", error.what());
    return std::string(error.what()) == what;
  }
  return false;
}

} // namespace

int main() {
  const bool executor = throws("from the executor", [] { blobs(true); });
  const bool step = throws("after two steps", [] { blobs(false); });
  const bool generator = throws("from the generator", [] { particles(); });
  return executor && step && generator ? 0 : 1;
}
