/*
 * mollis: particles that interact through softened ("mollified") potentials.
 *
 * The caller owns all memory. Every function returns a status, MOLLIS_OK or one of MOLLIS_ERR_*, and hands results
 * back through pointers; a call that is refused leaves every output as it was. A null output means "not wanted".
 * Outputs must overlap nothing else of the call. A pointer with a length may be null when the length is 0.
 * Coordinates of n points in D dimensions are an array `double x[n][D]`.
 * Functions with the suffix _f32 compute in float, those without one in double.
 *
 * Made from the library's source by `cargo xtask header`: do not edit.
 */

#ifndef MOLLIS_H
#define MOLLIS_H

#include <stddef.h>
#include <stdint.h>

/** Success. */
#define MOLLIS_OK 0
/** a required pointer is null. */
#define MOLLIS_ERR_NULL_POINTER 1
/** a pointer is not aligned as its type or the workspace needs. */
#define MOLLIS_ERR_MISALIGNED 2
/** the workspace is smaller than its size query asked. */
#define MOLLIS_ERR_WORKSPACE_TOO_SMALL 3
/** a size overflows. */
#define MOLLIS_ERR_TOO_LARGE 4
/** arrays that belong together have different lengths. */
#define MOLLIS_ERR_LENGTH_MISMATCH 5
/** an output overlaps another buffer. */
#define MOLLIS_ERR_OVERLAP 6
/** the buffer holds no prepared object of this kind. */
#define MOLLIS_ERR_NOT_PREPARED 7
/** the prepared object was made by another version of the library. */
#define MOLLIS_ERR_WRONG_VERSION 8
/** the prepared object is for the other scalar type. */
#define MOLLIS_ERR_WRONG_SCALAR 9
/** the prepared object was made on a machine of other byte order. */
#define MOLLIS_ERR_WRONG_BYTE_ORDER 10
/** the options structure is larger than this library knows. */
#define MOLLIS_ERR_OPTIONS_SIZE 11
/** an input value is not finite. */
#define MOLLIS_ERR_NOT_FINITE 20
/** delta must be positive and finite. */
#define MOLLIS_ERR_DELTA 21
/** the dimension must be 1, 2 or 3. */
#define MOLLIS_ERR_DIMENSION 22
/** the mollifier's exponent M must be 1 to 9. */
#define MOLLIS_ERR_EXPONENT 23
/** the mollifier has no such order in this dimension. */
#define MOLLIS_ERR_ORDER 24
/** an enumerated value is unknown. */
#define MOLLIS_ERR_UNKNOWN_VALUE 25
/** the time step must be positive and finite. */
#define MOLLIS_ERR_TIME_STEP 26
/** a kernel parameter is outside its range. */
#define MOLLIS_ERR_KERNEL_PARAMETER 27
/** a kernel sum has no term or too many. */
#define MOLLIS_ERR_KERNEL_TERMS 28
/** masses must be positive here. */
#define MOLLIS_ERR_MASS 29
/** a parameter is outside its documented range. */
#define MOLLIS_ERR_OUT_OF_DOMAIN 30
/** this combination is not offered. */
#define MOLLIS_ERR_UNSUPPORTED 31
/** a value became non-finite; the state is that of the last completed step. */
#define MOLLIS_ERR_BECAME_NOT_FINITE 40
/** stopped at the host's request. */
#define MOLLIS_ERR_STOPPED 41
/** the event buffer is full; no event was lost. */
#define MOLLIS_ERR_EVENTS_FULL 42
/** a particle needs more sub-steps than allowed. */
#define MOLLIS_ERR_TOO_MANY_SUBSTEPS 43
/** the energy rose beyond rounding. */
#define MOLLIS_ERR_ENERGY_ROSE 44
/** the random generator reported an error. */
#define MOLLIS_ERR_GENERATOR 45
/** the executor did not run every task. */
#define MOLLIS_ERR_EXECUTOR 46

/** What a workspace must be aligned to, in bytes. */
#define MOLLIS_WORKSPACE_ALIGN 64


/**
 * The fastest instruction set of the machine.
 */
#define MOLLIS_LEVEL_BEST -1

/**
 * Only + - * / and sqrt, in one stated order: the same bits on every machine.
 */
#define MOLLIS_LEVEL_PORTABLE 0

/**
 * 128-bit vectors of every aarch64.
 */
#define MOLLIS_LEVEL_NEON 1

/**
 * 256-bit vectors with fused multiply-add.
 */
#define MOLLIS_LEVEL_AVX2 2

/**
 * 512-bit vectors.
 */
#define MOLLIS_LEVEL_AVX512 3

/**
 * What every function returns: `MOLLIS_OK` or one of `MOLLIS_ERR_*`.
 */
typedef int32_t mollis_status;

/**
 * One task of a call: `mollis` passes it to `parallel_for`, which calls it.
 */
typedef int32_t (*mollis_task)(void *data, size_t index, size_t worker);

/**
 * The host's way to run independent tasks, perhaps on several threads.
 *
 * `parallel_for` must call `task(data, index, worker)` once for every `index` in `0 .. tasks`, with `worker < workers` and never two calls
 * with the same `worker` at a time, and return after all have returned: 0, or a status that ends the call. Results do not
 * depend on the order or on the number of threads, bit for bit.
 */
typedef struct mollis_executor {
  /**
   * Passed to `parallel_for`.
   */
  void *context;
  /**
   * How many tasks may run at a time: 1 to 64. Workspaces are sized for this number.
   */
  size_t workers;
  /**
   * Runs the tasks.
   */
  int32_t (*parallel_for)(void *context, size_t tasks, mollis_task task, void *data);
} mollis_executor;

/**
 * How a call runs. Fill it with `mollis_run_init`, then change what you want; null means the defaults.
 */
typedef struct mollis_run {
  /**
   * Bytes of this structure, as `mollis_run_init` sets it.
   */
  uint32_t size;
  /**
   * The instruction set: `MOLLIS_LEVEL_*`. Default: the best of the machine.
   */
  int32_t level;
  /**
   * Who runs the tasks; null (the default): the calling thread.
   */
  const struct mollis_executor *executor;
  /**
   * Asked between tasks, perhaps from several threads; nonzero stops the call with `MOLLIS_ERR_STOPPED`. May be null.
   */
  int32_t (*should_stop)(void *context);
  /**
   * Passed to `should_stop`.
   */
  void *stop_context;
} mollis_run;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Fills `run` with the defaults. `size` is `sizeof *run`.
 *
 * # Safety
 * The contract of this header.
 */
mollis_status mollis_run_init(struct mollis_run *run, size_t size);

/**
 * A sentence that explains a status. Static text, never null; any value is accepted.
 */
const char *mollis_status_text(mollis_status status);

/**
 * The version of the binary interface: it changes when a program built with an older header may break.
 */
uint32_t mollis_abi_version(void);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* MOLLIS_H */
