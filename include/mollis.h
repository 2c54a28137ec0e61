/*
 * mollis: particles that interact through softened ("mollified") potentials.
 *
 * The caller owns all memory. Every function returns a status, MOLLIS_OK or one of MOLLIS_ERR_*, and hands results
 * back through pointers; a call that is refused leaves every output as it was, but for what tells why (a report, first_bad).
 * A null output means "not wanted". Outputs must overlap nothing else of the call. A pointer with a length may be null when the length is 0.
 * Coordinates of n points in D dimensions are an array `double x[n][D]`.
 * Functions with the suffix _f32 compute in float, those without one in double. What exists in several dimensions is documented for the plane and
 * double; below it stand the forms for float and for one and three dimensions, 1 and 3 in place of 2.
 *
 * Structures with a member `size` are filled by their _init function, which is told their sizeof: then a program built with
 * an older header gets the defaults of what it does not know. A size of 0 is refused with MOLLIS_ERR_NOT_INITIALISED,
 * one at which no member ends with MOLLIS_ERR_OPTIONS_SIZE.
 *
 * MOLLIS_ERR_NOT_FINITE: the first bad element is told through mollis_run.first_bad by functions that take a run, and found
 * by mollis_first_bad for the others.
 *
 * Functions of the host that the library calls (fill, evaluate, parallel_for, should_stop, after_step) must return. A C++
 * exception that leaves one, or a longjmp across a call of the library, is undefined behaviour: catch it, keep it, return a
 * status, and throw it again after the call, as examples_c/exceptions.cpp does. A status other than 0 that fill, evaluate or
 * parallel_for returns ends the call and comes back unchanged, whatever its number. Those of the library are 1 to 255.
 *
 * Made from the library's source by `cargo xtask header`: do not edit.
 */

#ifndef MOLLIS_H
#define MOLLIS_H

#include <stddef.h>
#include <stdint.h>

/** The version of the library that this header belongs to. */
#define MOLLIS_VERSION "0.1.0"
/** The version of the binary interface: mollis_abi_version() of a library that programs with this header may use. */
#define MOLLIS_ABI_VERSION 1
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
/** the options structure's size is none that this library knows. */
#define MOLLIS_ERR_OPTIONS_SIZE 11
/** the options structure was not filled by its _init function. */
#define MOLLIS_ERR_NOT_INITIALISED 12
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
/** a host's kernel is not met within its tolerance. */
#define MOLLIS_ERR_KERNEL_FIT 32
/** the reach of a host's kernel must be positive and finite. */
#define MOLLIS_ERR_KERNEL_REACH 33
/** knots must increase strictly between zero and the reach. */
#define MOLLIS_ERR_KERNEL_KNOTS 34
/** the arrays for the results are too short; how many there are is told. */
#define MOLLIS_ERR_NO_ROOM 35
/** the mollifier changes sign where a positive one is needed. */
#define MOLLIS_ERR_SIGN_CHANGE 36
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
/** an invariant of the library is broken. */
#define MOLLIS_ERR_INTERNAL 47
/** the iteration did not reach its tolerance. */
#define MOLLIS_ERR_NOT_CONVERGED 48
/** the communicator reported an error, or what the ranks were given differs. */
#define MOLLIS_ERR_COMMUNICATOR 49
/** How arrays in a workspace are aligned, and best prepared kernels. */
#define MOLLIS_ALIGN 64
/** `bytes`, rounded up to the alignment: what an array takes in a workspace. */
#define MOLLIS_PADDED(bytes) (((size_t)(bytes) + MOLLIS_ALIGN - 1) / MOLLIS_ALIGN * MOLLIS_ALIGN)
/** For static buffers: what `mollis_kernel2_bytes_f32` answers for one Newtonian term. */
#define MOLLIS_KERNEL2_NEWTONIAN_BYTES_F32 1216
/** For static buffers: a field sum over n sources in the plane, a part of the workspaces below. */
#define MOLLIS_SUM2_PART_F32(n) \
  (MOLLIS_PADDED(8 * (size_t)(n)) + 2 * MOLLIS_PADDED(4 * (size_t)(n)) + MOLLIS_PADDED(16 * ((size_t)(n) / 256 + 3)))
/**
 * For static buffers: what `mollis_blob2_workspace_bytes_f32` answers for n particles without gaps, with densities, no tracers, a
 * Newtonian kernel and default options.
 */
#define MOLLIS_BLOB2_WORKSPACE_BYTES_F32(n) \
  (4 * MOLLIS_PADDED(12 * (size_t)(n)) + MOLLIS_SUM2_PART_F32(n) + MOLLIS_ALIGN - 1)
/**
 * For static buffers: what `mollis_pks_workspace_bytes_f32` answers for n particles, a Newtonian kernel's sum as attraction
 * and default options.
 */
#define MOLLIS_PKS_WORKSPACE_BYTES_F32(n) \
  (4 * MOLLIS_PADDED(8 * ((size_t)(n) / 2)) + ((n) > 0 ? 1600 : 0) + MOLLIS_PADDED(20 * ((size_t)(n) / 2)) + \
   4 * MOLLIS_PADDED(8 * (size_t)(n)) + 2 * MOLLIS_PADDED(n) + MOLLIS_PADDED(4 * (((size_t)(n) + 255) / 256)) + \
   MOLLIS_PADDED(48) + \
   ((n) > 512 ? 2 * MOLLIS_PADDED(8 * (size_t)(n)) + 73792 * (((size_t)(n) + 32767) / 32768) + 204928 : 0) + \
   MOLLIS_SUM2_PART_F32(n) + MOLLIS_ALIGN - 1)

/** The plan chooses. */
#define MOLLIS_METHOD_AUTO 0
/** All pairs. */
#define MOLLIS_METHOD_DIRECT 1
/** No pair: moments of the sources (even powers). */
#define MOLLIS_METHOD_MOMENTS 2

/**
 * One dimension: one sort. All masses have one unit: those below 2^-126 (double: 2^-1022) of the largest lose digits, and count as zero in the end.
 */
#define MOLLIS_METHOD_SORTED 3
/** Pairs closer than delta alone (the Laplacian of a Newtonian kernel). */
#define MOLLIS_METHOD_NEIGHBOURS 4
/** Even powers from moments, the other terms over all pairs. */
#define MOLLIS_METHOD_SPLIT 5

/**
 * Newtonian kernels in the plane and in space, without a mollifier or with a compact or Gaussian one: the fast multipole method, to the tolerance (at least 1e-13, in space 1e-12, single precision 1e-5). In
 * space potentials, gradients, Laplacians; vector strengths; core radii of sources, where cells are no narrower than the largest core. Masses
 * below 2^-1022 of the largest (single precision: 2^-126) count as zero in the end.
 */
#define MOLLIS_METHOD_FMM 6

/**
 * Any kernel that is smooth away from zero, in one, two and three dimensions: cells, and the kernel interpolated between those that do not touch, to the tolerance (at least 1e-12,
 * single precision 1e-5). Potentials and gradients, and Laplacians of Newtonian kernels; vector strengths; core radii of sources under compact and Gaussian mollifiers, where cells are no narrower than the largest core. Where a kernel cannot be interpolated, as about
 * an edge of it, pairs are summed one by one. Masses below 2^-1022 of the largest (single precision: 2^-126) count as zero in the end.
 */
#define MOLLIS_METHOD_TREE 7
/** Terms are added up in blocks. */
#define MOLLIS_ACCUMULATION_BLOCKED 0
/** Each addition's error is carried along: for diagnostics. */
#define MOLLIS_ACCUMULATION_COMPENSATED 1
/** A pair's core radius is the source's. */
#define MOLLIS_PAIR_RADIUS_SOURCE 0
/** The larger one of the source's and the target's. */
#define MOLLIS_PAIR_RADIUS_MAXIMUM 1
/** Their mean. */
#define MOLLIS_PAIR_RADIUS_MEAN 2
/** The root of the mean of their squares. */
#define MOLLIS_PAIR_RADIUS_RMS 3
/** No element is bad. */
#define MOLLIS_NONE_BAD UINT64_MAX

/**
 * Free space: the field of all mass at its centre is prescribed on the mesh's border, and acts outside. Closer to the centre than half of
 * the smaller mesh width its potential is that at this distance, and its gradient falls linearly to 0.
 */
#define MOLLIS_WALLS_FREE 0
/** No flux through the border: particles outside act from, and are driven at, their mirror places. */
#define MOLLIS_WALLS_NO_FLUX 1

/**
 * Free space, with the second moments of the mass in that field as well: for long or divided mass. Without screening only.
 * Closer to the centre than sqrt(2 |Q| / |M|), Q = sum m (x + i y)^2 about it, where this expansion means nothing, their part grows no more.
 */
#define MOLLIS_WALLS_FREE_QUADRUPOLE 2
/** Laplacian K = +Dirac: |x|/2, log|x|/(2 pi), -1/(4 pi |x|) in 1, 2, 3 dimensions. No parameter. */
#define MOLLIS_KERNEL_NEWTONIAN 0
/** |x|^p/p, log|x| for p = 0; parameter[0] = p > 1 - d (and p = 0 in 1D). */
#define MOLLIS_KERNEL_POWER 1
/** e^{-|x|/l}, a Morse term; parameter[0] = l > 0. */
#define MOLLIS_KERNEL_EXPONENTIAL 2
/** (Laplacian - k^2) K = Dirac: -e^{-k|x|}/(2k), -K0(k|x|)/(2 pi), -e^{-k|x|}/(4 pi |x|); parameter[0] = k > 0. */
#define MOLLIS_KERNEL_SCREENED 3
/** The most terms of a sum, a host's own kernel included. */
#define MOLLIS_KERNEL_MAX_TERMS 8
/** The most knots of a host's own kernel. */
#define MOLLIS_KERNEL_MAX_KNOTS 8
/** No mollifier: the singular kernel of the particle method. Order, exponent and delta are not looked at. */
#define MOLLIS_MOLLIFIER_NONE 0
/** Compact polynomial (Anderson): order 2, 4, 6 or 8, exponent 1 to 9; delta is the radius of the support. */
#define MOLLIS_MOLLIFIER_COMPACT 1

/**
 * Sum of Gaussians: exp(-r^2 / delta^2) alone for order 2 (Lamb and Oseen's vortex in 2D); of order 4 and 6 Craig and Bertozzi's and alike. The exponent is not
 * looked at.
 */
#define MOLLIS_MOLLIFIER_GAUSSIAN 2

/**
 * Plummer's softening: the Newtonian kernel at the distance (r^2 + delta^2)^(1/2); in vortex methods the low-order algebraic kernel of Rosenhead and Moore. Of
 * Newtonian kernels only, as the next two. Order and exponent are not looked at.
 */
#define MOLLIS_MOLLIFIER_PLUMMER 3

/**
 * The high-order algebraic kernel of vortex methods (Winckelmans and Leonard): K'/r is (r^2 + (1 + D/2) delta^2) / (S_D (r^2 + delta^2)^(D/2 + 1)) in D dimensions.
 */
#define MOLLIS_MOLLIFIER_ALGEBRAIC 4
/** Vatistas' vortex with n = 2, in the plane: K'/r is 1 / (2 pi (r^4 + delta^4)^(1/2)). */
#define MOLLIS_MOLLIFIER_VATISTAS 5

/**
 * Richardson combination of order / 2 compact polynomials of order 2 (Anderson (8)): order 4 (9), of the radii delta and delta / 2 with the weights -1/3 and 4/3; order 6
 * (10), of delta, 2/3 delta and delta / 3 with 1/10, -3/5 and 3/2; order 8, of delta times 1, 3/4, 1/2 and 1/4. Exponent 1 to 9; beyond delta the field is exactly Newtonian.
 */
#define MOLLIS_MOLLIFIER_RICHARDSON 6
/** Collisions by the law of the hitting time of zero. */
#define MOLLIS_PKS_LAW_EXACT 0
/** Collisions by one Gaussian increment of the second moment, as Zhelezov & Fatkullin print it, (3.11). */
#define MOLLIS_PKS_LAW_PRINTED 1
/** Every collision merges: nu < 0. */
#define MOLLIS_PKS_MERGE_ALL 0
/** Only collisions that must happen merge: nu <= -1. */
#define MOLLIS_PKS_MERGE_HARD 1
/** Nothing merges. */
#define MOLLIS_PKS_MERGE_NEVER 2
/** Adaptive Euler-Maruyama sub-steps. */
#define MOLLIS_PKS_SCHEME_EULER_MARUYAMA 0
/** One RK4 step of the drift between two half steps of the noise. */
#define MOLLIS_PKS_SCHEME_STRANG_RK4 1
/** No attraction. */
#define MOLLIS_PKS_ATTRACTION_NONE 0
/** The field of a mesh, solved once a step. */
#define MOLLIS_PKS_ATTRACTION_MESH 1
/** The sum of a prepared kernel over all particles, in every sub-step. */
#define MOLLIS_PKS_ATTRACTION_SUM 2
/** The fastest instruction set of the machine. */
#define MOLLIS_LEVEL_BEST -1
/** Only + - * / and sqrt, in one stated order: the same bits on every machine. */
#define MOLLIS_LEVEL_PORTABLE 0
/** 128-bit vectors of every aarch64. */
#define MOLLIS_LEVEL_NEON 1
/** 256-bit vectors with fused multiply-add. */
#define MOLLIS_LEVEL_AVX2 2
/** 512-bit vectors. */
#define MOLLIS_LEVEL_AVX512 3
/** Sums modulo 2^64. */
#define MOLLIS_REDUCE_SUM 0
/** The largest. */
#define MOLLIS_REDUCE_MAX 1

/** What every function returns: `MOLLIS_OK` or one of `MOLLIS_ERR_*`. */
typedef int32_t mollis_status;

/** A mollifier without its length delta. A plain value without invariants: fill it and pass it. */
typedef struct mollis_mollifier {
  /** `MOLLIS_MOLLIFIER_...`. */
  int32_t kind;
  /** The order: moments 1 to order - 1 vanish. */
  int32_t order;
  /** The exponent M: M - 1 continuous derivatives. */
  int32_t exponent;
} mollis_mollifier;

/** How a run of the blob method is done. Fill it with `mollis_blob_options_init`; null means the defaults. */
typedef struct mollis_blob_options {
  /** Bytes of this structure, as `mollis_blob_options_init` sets it. */
  uint32_t size;
  /**
   * Nonzero: watch the regularised energy, and stop with `MOLLIS_ERR_ENERGY_ROSE` when it rises beyond rounding. Its rate is -a sum_i m_i
   * |grad u(x_i)|^2, with a = 1 or of `combination`. So for a > 0 it falls if no mass is negative: one that is is refused with `MOLLIS_ERR_MASS`. For a <= 0 it is
   * only reported, for masses of any sign; for a = 0 it is constant, up to the error of the steps. Default 0.
   */
  int32_t watch_energy;
  /** The relative error that field sums may spend for speed; 0 (the default) asks for rounding alone. */
  double tolerance;
  /**
   * Called after each step with the number of steps completed in this call and arrays without gaps (`double (*)[D]`
   * or `float (*)[D]`; `density` is null if none is advanced), to be read through these pointers and not written.
   * Nonzero stops the run with `MOLLIS_ERR_STOPPED`. May be null.
   */
  int32_t (*after_step)(void *context, size_t steps, const void *positions, const void *density);
  /** Passed to `after_step`. */
  void *context;
  /**
   * (a, b), in 2D: the velocity is -(a grad u + b (grad u rotated by +90 degrees)). The default (1, 0) is the aggregation equation. (0, -1) with a positive Newtonian
   * kernel and circulations as masses is the vortex blob method: counter-clockwise about a positive circulation. (Sums return a grad u + b (...) without the minus sign, so
   * there the velocity of vortices is (0, 1).) Divergences and the rates of densities are a times those of (1, 0). In 1D and 3D, and in a library with the feature
   * `small`, any other value is refused with `MOLLIS_ERR_UNSUPPORTED`; in 2D one that is not finite with `MOLLIS_ERR_NOT_FINITE`. Divide steps of `mollis_stable_step2` by
   * 1.07 sqrt(a^2 + b^2).
   */
  double combination[2];
  /**
   * nu of the diffusion rho_t = nu Laplacian(rho^m) by blobs (Carrillo, Craig and Patacchini 2019), which is added to the velocity of particles and tracers:
   * -nu sum_j m_j (f'(rho_j) + f'(rho(x))) grad phi(x - x_j), with the density of blobs rho(x) = sum_j m_j phi(x - x_j) and f'(s) = s^(m-2). The watched energy then has
   * nu sum_i m_i f(rho_i) besides, and is only reported if `combination` is not (1, 0). Masses must not be negative (`MOLLIS_ERR_MASS`); densities and divergences are refused with
   * `MOLLIS_ERR_UNSUPPORTED`, as is all diffusion in a library with the feature `small`. The default 0 is none. Not finite: `MOLLIS_ERR_NOT_FINITE`; negative:
   * `MOLLIS_ERR_OUT_OF_DOMAIN`. The other three members are looked at only if it is not 0. The step has to be shorter than 0.8 w / (nu m p), with p the largest
   * rho^(m-1), and w = diffusion_length^2 for a Gaussian of order 2, 2 diffusion_length^2 / (2 exponent + D + 2) for a compact one. A kernel of Newtonian terms whose coefficients add up to 0 takes no sum: diffusion alone.
   */
  double diffusion;
  /**
   * m >= 1, else `MOLLIS_ERR_OUT_OF_DOMAIN`: 1 is the heat equation, above 1 a porous medium. m = 2 takes one sum an evaluation, any other two. Default 1.
   */
  double diffusion_exponent;
  /**
   * phi: Gaussian, or compact of exponent 2 or more (`MOLLIS_ERR_EXPONENT`). An order above 2 changes sign and is refused with `MOLLIS_ERR_SIGN_CHANGE`, unless m is 2, 3, ... or 64. Default Gaussian of
   * order 2. Sums of compact ones visit pairs closer than `diffusion_length` alone, but particles gather in pairs where that is several distances of neighbours (for exponent 4 on the line above 2.6, for
   * 9 above 4.4).
   */
  struct mollis_mollifier diffusion_mollifier;
  /** The length of phi, some distances of neighbours. It has no default: `MOLLIS_ERR_DELTA`. */
  double diffusion_length;
} mollis_blob_options;

/** How a sum is computed. Fill it with `mollis_field_options_init`, then change what you want; null means the defaults. */
typedef struct mollis_field_options {
  /** Bytes of this structure, as `mollis_field_options_init` sets it. */
  uint32_t size;
  /** `MOLLIS_METHOD_...`. */
  int32_t method;
  /** `MOLLIS_ACCUMULATION_...`. */
  int32_t accumulation;
  /**
   * `MOLLIS_PAIR_RADIUS_...`, with core radii of the sources. But for the first the targets need core radii too; then forces between two particles are equal and opposite.
   */
  int32_t pair_radius;
  /** (a, b): in 2D the gradient output is a grad u + b (grad u rotated by +90 degrees), of the rounded gradient; else (1, 0). */
  double combination[2];
  /**
   * The error that may be spent for speed (`MOLLIS_METHOD_FMM`, `MOLLIS_METHOD_TREE`): of each output, in the l2 norm over the targets, relative to that of sum_j |m_j| |K_j|; with
   * masses of one sign relative to the output itself. 0 asks for rounding alone, and so does any tolerance that is too
   * small for these methods, or where they serve no sum of this kind. Not negative.
   */
  double tolerance;
} mollis_field_options;

/**
 * The particles of the blob method in the plane, or massless points that follow their flow (tracers). Arrays as in mollis_sources2; null is not there.
 */
typedef struct mollis_particles2 {
  /** How many. */
  size_t n;
  /** Advanced in place. */
  double *positions[2];
  /** From one to the next. */
  size_t stride;
  /** Density times h^2, any sign; only read. Of tracers not looked at. */
  const double *masses;
  /** From one to the next; 0: 1. */
  size_t mass_stride;
  /** Advanced in place, or null; of tracers (if there are any) given if and only if it is of the particles. */
  double *density;
  /** From one to the next; 0: 1. */
  size_t density_stride;
  /** Overwritten with the velocity at the end, or null. */
  double *velocity[2];
  /** From one to the next. */
  size_t velocity_stride;
  /** Overwritten with the velocity's divergence at the end, or null; of tracers null. */
  double *divergence;
  /** From one to the next; 0: 1. */
  size_t divergence_stride;
} mollis_particles2;

/** One task of a call: `mollis` passes it to `parallel_for`, which calls it. */
typedef int32_t (*mollis_task)(void *data, size_t index, size_t worker);

/**
 * The host's way to run independent tasks, perhaps on several threads.
 *
 * `parallel_for` must call `task(data, index, worker)` once for every `index` in `0 .. tasks`, with `worker < workers` and never two calls
 * with the same `worker` at a time, and return after all have returned: 0, or another status, which ends the call and comes back
 * unchanged (a particle step that is already being written is completed first). Results do not depend on the order or on the
 * number of threads, bit for bit.
 */
typedef struct mollis_executor {
  /** Passed to `parallel_for`. */
  void *context;
  /**
   * How many tasks may run at a time: 1 to 256. Workspaces are sized for this number; others are refused (`MOLLIS_ERR_OUT_OF_DOMAIN`).
   */
  size_t workers;
  /** Runs the tasks. */
  int32_t (*parallel_for)(void *context, size_t tasks, mollis_task task, void *data);
} mollis_executor;

/**
 * The processes ("ranks") over which the host has spread the particles of a step, and its way to exchange words among them, for example by MPI
 * (`examples_c/mpi_pks.c` has it in forty lines). The library sends nothing by itself.
 *
 * All ranks make the same call with their own particles; what else they pass is the same, the room of arrays included. In it both functions are called in the same order on all of them, from
 * the thread of the call, and return when the rank has its results: 0, or another status, which ends the call and comes back unchanged. They then
 * have to fail on the other ranks, too, which wait for this one.
 *
 * An error of one rank ends the call on all: on the others with its status, or with MOLLIS_ERR_EXECUTOR if it is a status of that rank's executor. But a rank whose arguments are refused (null, size, overlap, an unknown value)
 * calls neither function. MOLLIS_ERR_COMMUNICATOR: ranks have different steps, time steps or room.
 */
typedef struct mollis_communicator {
  /** Passed to both functions. */
  void *context;
  /** The number of this rank, below `ranks`. */
  size_t rank;
  /** How many there are, the same on all of them. */
  size_t ranks;
  /**
   * Replaces each of the words by the sum (MOLLIS_REDUCE_SUM) or the largest (MOLLIS_REDUCE_MAX) of the words at its place on all ranks, which pass as many: MPI_Allreduce
   * with MPI_IN_PLACE and MPI_UINT64_T.
   */
  int32_t (*reduce)(void *context, int32_t operation, uint64_t *words, size_t count);
  /**
   * Sends `outgoing[starts[r]]` up to `outgoing[starts[r + 1]]` to each rank r, itself included, and receives what it sends to this one in `incoming[froms[r]]` up to
   * `incoming[froms[r + 1]]`: MPI_Alltoallv. Both have ranks + 1 elements.
   */
  int32_t (*exchange)(void *context,
                      const uint64_t *outgoing,
                      const size_t *starts,
                      uint64_t *incoming,
                      const size_t *froms);
} mollis_communicator;

/** How a call runs. Fill it with `mollis_run_init`, then change what you want; null means the defaults. */
typedef struct mollis_run {
  /** Bytes of this structure, as `mollis_run_init` sets it. */
  uint32_t size;
  /** The instruction set: `MOLLIS_LEVEL_*`. Default: the best of the machine. */
  int32_t level;
  /** Who runs the tasks; null (the default): the calling thread. */
  const struct mollis_executor *executor;
  /** Asked between tasks, perhaps from several threads; nonzero stops the call with `MOLLIS_ERR_STOPPED`. May be null. */
  int32_t (*should_stop)(void *context);
  /** Passed to `should_stop`. */
  void *stop_context;
  /**
   * Where a step or an evaluation that returns `MOLLIS_ERR_NOT_FINITE` writes the index of the first particle (source) with a
   * coordinate, mass or density that is not finite; targets, tracers count after them. `MOLLIS_NONE_BAD`: it is a parameter, or a sum
   * that overflows. Not written otherwise. May be null (the default).
   */
  uint64_t *first_bad;
  /**
   * Where a step or an evaluation that returns `MOLLIS_ERR_WORKSPACE_TOO_SMALL` writes the bytes of workspace that it needs; 0: it is a prepared
   * kernel whose buffer is too short (in builds for firmware also 0 from `mollis_pks_step`). Not written otherwise. May be null (the default).
   */
  size_t *bytes_needed;
  /**
   * The ranks over which the particles of `mollis_pks_step` are spread; other functions do not ask for it. Null (the default): this process has all.
   */
  const struct mollis_communicator *communicator;
} mollis_run;

typedef struct mollis_particles2_f32 {
  size_t n; float *positions[2]; size_t stride; const float *masses; size_t mass_stride; float *density; size_t density_stride;
  float *velocity[2]; size_t velocity_stride; float *divergence; size_t divergence_stride;
} mollis_particles2_f32;

typedef struct mollis_particles1 {
  size_t n; double *positions[1]; size_t stride; const double *masses; size_t mass_stride; double *density; size_t density_stride;
  double *velocity[1]; size_t velocity_stride; double *divergence; size_t divergence_stride;
} mollis_particles1;

typedef struct mollis_particles1_f32 {
  size_t n; float *positions[1]; size_t stride; const float *masses; size_t mass_stride; float *density; size_t density_stride;
  float *velocity[1]; size_t velocity_stride; float *divergence; size_t divergence_stride;
} mollis_particles1_f32;

typedef struct mollis_particles3 {
  size_t n; double *positions[3]; size_t stride; const double *masses; size_t mass_stride; double *density; size_t density_stride;
  double *velocity[3]; size_t velocity_stride; double *divergence; size_t divergence_stride;
} mollis_particles3;

typedef struct mollis_particles3_f32 {
  size_t n; float *positions[3]; size_t stride; const float *masses; size_t mass_stride; float *density; size_t density_stride;
  float *velocity[3]; size_t velocity_stride; float *divergence; size_t divergence_stride;
} mollis_particles3_f32;

/**
 * What a run says about itself. Written by every step that got as far as reading its arrays, also when it then refuses or
 * stops.
 */
typedef struct mollis_blob_report {
  /** Steps completed in this call: the state in the arrays is the one after them. */
  uint64_t steps;
  /**
   * With `MOLLIS_ERR_NOT_FINITE`: the index of the first particle with a coordinate, mass or density that is not finite
   * (tracers count after the particles); else `MOLLIS_NONE_BAD`.
   */
  uint64_t first_bad;
  /** The regularised energy before the first step; NaN if not watched. */
  double energy_first;
  /** The last energy computed; NaN if not watched. */
  double energy_last;
} mollis_blob_report;

/**
 * The sources of a sum in the plane, and their core radii.
 *
 * Coordinates: `positions[k]` points to coordinate k of the first source, and `stride` is the number of doubles from one source to the next. With `positions[1]` (and [2]) null
 * the coordinates of a source follow one another. A stride of 0 is that of arrays without gaps. So `{x}` is an array `double x[n][2]`; `{&p->x}` with the stride
 * `sizeof *p / sizeof(double)` is an array of structures; and `{x, y}` are arrays of their own.
 */
typedef struct mollis_sources2 {
  /** How many. */
  size_t n;
  /** Their coordinates. */
  const double *positions[2];
  /** From one to the next. */
  size_t stride;
  /** Masses of any sign; sources of mass 0 are dropped. Not looked at with vector strengths. */
  const double *masses;
  /** From one to the next; 0: 1. Masses in structures have the stride of their positions. */
  size_t mass_stride;
  /** Core radii, positive, in place of the kernel's delta: for Newtonian kernels with a mollifier. Null: the kernel's delta. */
  const double *radii;
  /** From one to the next; 0: 1. */
  size_t radius_stride;
  /**
   * In space: vector strengths instead of masses, or null. The gradient is then sum_j grad K_delta(x_i - x_j) x strength_j, the velocity of vortex elements by the law of Biot
   * and Savart for the coefficient 1, of Newtonian kernels. Else null.
   */
  const double *strengths[2];
  /** From one to the next. */
  size_t strength_stride;
} mollis_sources2;

/** Where a sum is evaluated, in the plane: coordinates as in mollis_sources2. */
typedef struct mollis_targets2 {
  /** How many. */
  size_t n;
  /** Their coordinates. */
  const double *positions[2];
  /** From one to the next. */
  size_t stride;
  /** Core radii, positive, if the option `pair_radius` asks for them; else null. Null `targets` have the sources'. */
  const double *radii;
  /** From one to the next; 0: 1. */
  size_t radius_stride;
} mollis_targets2;

/**
 * Where the results of a sum in the plane go: arrays as in mollis_sources2; null is not computed. All zero but the pointers: overwritten.
 */
typedef struct mollis_outputs2 {
  /** u. */
  double *potential;
  /** From one to the next; 0: 1. */
  size_t potential_stride;
  /** grad u, or what `combination` makes of it. */
  double *gradient[2];
  /** From one to the next. */
  size_t gradient_stride;
  /** The Laplacian of u: the density of the blobs of a Newtonian kernel of coefficient 1. */
  double *laplacian;
  /** From one to the next; 0: 1. */
  size_t laplacian_stride;
  /**
   * The second derivatives of u, `[2][2]` for each target, symmetric; `combination` makes nothing of them. (On the line the second derivative is the Laplacian.)
   */
  double *hessian;
  /** From one matrix to the next; 0: 4, without gaps. */
  size_t hessian_stride;
  /** What all results are multiplied by. 0, a member that was left alone, means 1. */
  double factor;
  /** 1: results are added to what is there; 0: overwritten. */
  int32_t add;
  /** 0. */
  int32_t reserved;
} mollis_outputs2;

typedef struct mollis_sources2_f32 {
  size_t n; const float *positions[2]; size_t stride; const float *masses; size_t mass_stride; const float *radii;
  size_t radius_stride; const float *strengths[2]; size_t strength_stride;
} mollis_sources2_f32;

typedef struct mollis_targets2_f32 {
  size_t n; const float *positions[2]; size_t stride; const float *radii; size_t radius_stride;
} mollis_targets2_f32;

typedef struct mollis_outputs2_f32 {
  float *potential; size_t potential_stride; float *gradient[2]; size_t gradient_stride; float *laplacian;
  size_t laplacian_stride; float *hessian; size_t hessian_stride; double factor; int32_t add; int32_t reserved;
} mollis_outputs2_f32;

typedef struct mollis_sources1 {
  size_t n; const double *positions[1]; size_t stride; const double *masses; size_t mass_stride; const double *radii;
  size_t radius_stride; const double *strengths[1]; size_t strength_stride;
} mollis_sources1;

typedef struct mollis_targets1 {
  size_t n; const double *positions[1]; size_t stride; const double *radii; size_t radius_stride;
} mollis_targets1;

typedef struct mollis_outputs1 {
  double *potential; size_t potential_stride; double *gradient[1]; size_t gradient_stride; double *laplacian;
  size_t laplacian_stride; double *hessian; size_t hessian_stride; double factor; int32_t add; int32_t reserved;
} mollis_outputs1;

typedef struct mollis_sources1_f32 {
  size_t n; const float *positions[1]; size_t stride; const float *masses; size_t mass_stride; const float *radii;
  size_t radius_stride; const float *strengths[1]; size_t strength_stride;
} mollis_sources1_f32;

typedef struct mollis_targets1_f32 {
  size_t n; const float *positions[1]; size_t stride; const float *radii; size_t radius_stride;
} mollis_targets1_f32;

typedef struct mollis_outputs1_f32 {
  float *potential; size_t potential_stride; float *gradient[1]; size_t gradient_stride; float *laplacian;
  size_t laplacian_stride; float *hessian; size_t hessian_stride; double factor; int32_t add; int32_t reserved;
} mollis_outputs1_f32;

typedef struct mollis_sources3 {
  size_t n; const double *positions[3]; size_t stride; const double *masses; size_t mass_stride; const double *radii;
  size_t radius_stride; const double *strengths[3]; size_t strength_stride;
} mollis_sources3;

typedef struct mollis_targets3 {
  size_t n; const double *positions[3]; size_t stride; const double *radii; size_t radius_stride;
} mollis_targets3;

typedef struct mollis_outputs3 {
  double *potential; size_t potential_stride; double *gradient[3]; size_t gradient_stride; double *laplacian;
  size_t laplacian_stride; double *hessian; size_t hessian_stride; double factor; int32_t add; int32_t reserved;
} mollis_outputs3;

typedef struct mollis_sources3_f32 {
  size_t n; const float *positions[3]; size_t stride; const float *masses; size_t mass_stride; const float *radii;
  size_t radius_stride; const float *strengths[3]; size_t strength_stride;
} mollis_sources3_f32;

typedef struct mollis_targets3_f32 {
  size_t n; const float *positions[3]; size_t stride; const float *radii; size_t radius_stride;
} mollis_targets3_f32;

typedef struct mollis_outputs3_f32 {
  float *potential; size_t potential_stride; float *gradient[3]; size_t gradient_stride; float *laplacian;
  size_t laplacian_stride; float *hessian; size_t hessian_stride; double factor; int32_t add; int32_t reserved;
} mollis_outputs3_f32;

/** What a sum did. Added to, when the call succeeds. */
typedef struct mollis_field_counts {
  /** Pairs of a target and a source with mass; by the fast multipole method and the tree those that are summed one by one. */
  uint64_t pairs;
  /** Of these, pairs closer than delta. */
  uint64_t near_pairs;
  /** Blocks (a source against a block of targets) that evaluated the mollifier's polynomial. */
  uint64_t polynomial_blocks;
  /** Of these, blocks with every target near, where nothing was divided. */
  uint64_t all_near_blocks;
  /**
   * Pairs outside the range of the fast path. Newtonian ones, without core radii and algebraic mollifiers, closer than 2^-28 of the largest coordinate (double: 2^-60) are summed in lanes in
   * closer units, at about 3 times the usual cost. Those closer than 2^-84 (2^-180), coincident ones, and those of other kernels beyond the
   * ends of their table are computed one by one: some 200 ns each.
   */
  uint64_t scaled_pairs;
  /** Sources without mass that were dropped. */
  uint64_t massless_sources;
  /** Pairs at least as far apart as the reach of a host's own kernel, which gives them nothing. */
  uint64_t beyond_reach;
} mollis_field_counts;

/**
 * A rectangle cut into cells[0] by cells[1] equal cells, at least 2 each way. It has (cells[0] + 1) (cells[1] + 1) nodes; arrays over
 * the nodes run along x first.
 */
typedef struct mollis_mesh2 {
  /** The lower left corner. */
  double lower[2];
  /** The upper right corner. */
  double upper[2];
  /** Cells along x and y. */
  size_t cells[2];
} mollis_mesh2;

/**
 * Where the results of a field on a mesh go; each is overwritten, null is not computed. Arrays over the nodes run along x first.
 */
typedef struct mollis_grid2_outputs {
  /** grad u at the targets, as in mollis_outputs2; outside the mesh that of all mass at its centre. */
  double *gradient[2];
  /** From one to the next. */
  size_t gradient_stride;
  /** The mass at each node. */
  double *node_mass;
  /** u at the nodes; with order 4 sharpened for interpolation. */
  double *node_potential;
  /** Its differences, [nodes][2]. */
  double (*node_gradient)[2];
  /** Total mass and its centre: three numbers. */
  double (*total)[3];
  /** One number: sources outside the mesh (on its border they are inside); they act through the total mass only. */
  uint64_t *outside;
} mollis_grid2_outputs;

/**
 * A medium: G and k^2 of div(G grad u) - k^2 u = density at the nodes of a mesh, in double precision for both scalars, and when the iteration ends that solves for u.
 *
 * Nodes stand for the cells around them, and faces between them have the harmonic mean of G. The error is of second order in the mesh width where G and k^2 are smooth or jump along
 * lines midway between nodes, of first order where a jump crosses the mesh elsewhere. About 25 iterations for jumps of 10 and a tolerance of 1e-10, on every mesh.
 */
typedef struct mollis_medium2 {
  /**
   * G > 0 at the nodes, in any unit, the least at least 2.2e-16 (single precision: 1.2e-7) of the largest. In free space the same everywhere on the border.
   */
  const double *diffusivity;
  /**
   * k^2 >= 0 at the nodes, in the unit of G over length^2; null: 0 everywhere. In free space the same everywhere on the border, and 0 there only if it is everywhere.
   */
  const double *decay;
  /**
   * The relative residual to be reached, positive: 1e-10, say. If k^2 / G is the same everywhere, sqrt(max G / min G) times it bounds the relative error of the solve in the energy norm. Rounding keeps it above 2e-16
   * (single precision: 2e-7) times the square root of the number of nodes.
   */
  double tolerance;
  /** The most iterations: 100, say. If they do not suffice, the call ends with MOLLIS_ERR_NOT_CONVERGED. */
  uint64_t iterations;
  /**
   * Two numbers, overwritten by the iterations that were made and the residual that was reached, also with MOLLIS_ERR_NOT_CONVERGED; null: not wanted.
   */
  double (*report)[2];
} mollis_medium2;

/**
 * An attractant with a memory: c of epsilon c_t = Laplacian(c) - k^2 c + density, k being the options' screening; u = -c. Its time scale epsilon and its values, in double precision for both
 * scalars. The values are the state: a checkpoint saves them, and a run that is given them again goes on bit for bit.
 *
 * A step in time is exact while the particles rest, and stable for every length. As epsilon goes to 0 it gives the field without a memory. With MOLLIS_WALLS_FREE c is 0 on the mesh's border
 * and outside, which is free space until a time of epsilon R^2 / 4 and some for a border at distance R from the masses. With MOLLIS_WALLS_NO_FLUX and k = 0 the mean of c grows for ever.
 *
 * mollis_pks_step advances c with the particles where they are, then moves them in the field of the new c (first order in dt; not MOLLIS_PKS_SCHEME_STRANG_RK4, no heavy particles, one
 * rank). Collisions are decided by the law of the model without a memory, which is right to leading order in epsilon noise / m. mollis_grid2_eval advances c by `time`.
 */
typedef struct mollis_parabolic2 {
  /** epsilon > 0, a time over the square of a length. */
  double time_scale;
  /** mollis_grid2_eval: how long the density acts before the field is taken, positive. mollis_pks_step takes its own dt. */
  double time;
  /**
   * c at the nodes, node (i, j) at j (cells[0] + 1) + i: before the call and, if it succeeds, after it. 0 on the border with MOLLIS_WALLS_FREE, else MOLLIS_ERR_OUT_OF_DOMAIN.
   * A call of several steps that fails leaves it as it is after the last step that moved the particles, also if that ended with MOLLIS_ERR_EVENTS_FULL.
   */
  double *attractant;
} mollis_parabolic2;

/** Which field a grid solves for. Fill it with `mollis_grid2_options_init`; null means the defaults. */
typedef struct mollis_grid2_options {
  /** Bytes of this structure, as `mollis_grid2_options_init` sets it. */
  uint32_t size;
  /** `MOLLIS_WALLS_*`. Default: free space. */
  int32_t walls;
  /** k >= 0 of Laplacian(u) - k^2 u = density. Default: 0. */
  double screening;
  /**
   * How fast the error of the particles' attraction, summed over many, falls with the mesh width where their density is smooth: 2 (five points; the
   * default) or 4 (nine points, a density sharpened by what deposit and interpolation smooth it; for cells whose sides are within a factor of
   * 1.25 and at most 1/k).
   */
  int32_t order;
  /** Ignored. */
  int32_t reserved;
  /**
   * The medium; null (the default): the same everywhere. With one, screening is 0, the order 2, and the walls are not MOLLIS_WALLS_FREE_QUADRUPOLE, else
   * MOLLIS_ERR_UNSUPPORTED.
   */
  const struct mollis_medium2 *medium;
  /**
   * An attractant with a memory; null (the default): the field is that of the moment. With one, the order is 2, there is no medium, and the walls are not
   * MOLLIS_WALLS_FREE_QUADRUPOLE, else MOLLIS_ERR_UNSUPPORTED.
   */
  const struct mollis_parabolic2 *parabolic;
} mollis_grid2_options;

typedef struct mollis_grid2_outputs_f32 {
  float *gradient[2]; size_t gradient_stride; float *node_mass; float *node_potential; float (*node_gradient)[2];
  float (*total)[3]; uint64_t *outside;
} mollis_grid2_outputs_f32;

/** One term of a kernel sum: coefficient (+1 attracts where K grows, -1 repels) times K. */
typedef struct mollis_kernel_term {
  /** `MOLLIS_KERNEL_...`. */
  int32_t kind;
  /** 0. */
  int32_t reserved;
  /** The factor. */
  double coefficient;
  /** As the kind says; the others are not looked at. */
  double parameter[2];
} mollis_kernel_term;

/**
 * A host's own radial kernel. Called only while a sum is prepared.
 *
 * Its functions are fitted, and the fits compared with them between their nodes. Members after `reach` may be zero.
 */
typedef struct mollis_radial_kernel {
  /** Passed to `evaluate`. */
  void *context;
  /**
   * Writes K(r), K'(r)/r and the Laplacian of K to out[0..2], for r > 0; returns 0, or a status that ends the call and
   * comes back unchanged. r^(d-1) K and r^d K' must be integrable at 0. A value that is not finite is an error. The three must belong together,
   * and be accurate at every r up to the reach (what is computed as 1 - exp(-r*r) is not at small r, -expm1(-r*r) is).
   */
  mollis_status (*evaluate)(void *context, double r, double *out);
  /** The factor. */
  double coefficient;
  /**
   * Pairs further apart get nothing from it, and are counted (`mollis_field_counts.beyond_reach`). Under a mollifier r goes a little further. From 1e-150 to 1e150.
   */
  double reach;
  /**
   * The largest error with which it is accepted, else MOLLIS_ERR_KERNEL_FIT. 0: 1e-10, in single precision 1e-5. Infinity accepts any.
   */
  double tolerance;
  /**
   * Without a mollifier: for smaller r, K continues with the power of r that K'/r has here. 0: 2^-52 of the reach, and
   * the kernel is compared with it; otherwise between that and half the reach, and the kernel is not called for smaller r.
   */
  double least;
  /** The number of knots, at most MOLLIS_KERNEL_MAX_KNOTS. */
  size_t n_knots;
  /**
   * Radii at which the kernel is not smooth (where the pieces of a spline meet), increasing by more than a relative 1e-10, between `least` and the reach. K is
   * continuous there. Null if there are none.
   */
  const double *knots;
  /**
   * If not null, errors[0..2] get the errors of K, K'/r and the Laplacian when the kernel is prepared, or refused with MOLLIS_ERR_KERNEL_FIT: sums miss
   * the kernel by no more, relative to the largest |K| (or r^2 |K'/r|), |K'/r|, and |Laplacian| or d |K'/r| over all distances from r/2 to r, and to
   * delta from 0 where r < delta (to `least` where r is less), but for the sum's own rounding. Within some roundings of a knot either side's value counts.
   */
  double *errors;
} mollis_radial_kernel;

/** Where the attraction comes from; the members of the other kinds are not looked at. */
typedef struct mollis_pks_attraction {
  /** `MOLLIS_PKS_ATTRACTION_*`. */
  int32_t kind;
  /** 0. */
  int32_t reserved;
  /** MESH: its rectangle and cells. */
  const struct mollis_mesh2 *mesh;
  /**
   * MESH: walls, screening, medium, memory; null for free space without screening. In a medium clusters have the index (4.30) of the paper, with gamma / G at their centres.
   */
  const struct mollis_grid2_options *grid;
  /**
   * SUM, and MESH with heavy particles: a kernel prepared by mollis_kernel2_prepare (or its _f32); its mollifier bounds the speed.
   */
  const void *kernel;
  /** The bytes of its buffer. */
  size_t kernel_bytes;
  /** SUM: the relative error that may be spent for speed; 0 for rounding alone. */
  double tolerance;
  /**
   * MESH: particles of at least this mass, the 64 heaviest at most (of equal masses those that come first in the arrays), act by `kernel` pair
   * by pair, both ways and at every distance, and not through the mesh, which is wrong within some widths of a particle, and on which a mass below
   * 4.4e-16 of the total adds nothing (see mollis_grid2_eval). The kernel is V of the mesh's equation, mollified over
   * a part of a mesh width (a quarter, say); sub-steps become short near them. Not with no-flux walls, nor in a medium, nor with a memory, nor with a singular kernel. 0: none.
   */
  double heavy;
} mollis_pks_attraction;

/** What a run is made with. Fill it with `mollis_pks_options_init`, then set at least chi and noise. */
typedef struct mollis_pks_options {
  /** Bytes of this structure, as `mollis_pks_options_init` sets it. */
  uint32_t size;
  /** `MOLLIS_PKS_LAW_*`. Default: exact. */
  int32_t law;
  /**
   * `MOLLIS_PKS_MERGE_*`. Default: all.
   *
   * With HARD and NEVER there are pairs that collide and do not merge. Under MOLLIS_PKS_ATTRACTION_SUM, with noise, both schemes then move close
   * pairs so that their mean squared distance is exact, whatever delta is, in no more sub-steps: five equal particles of index -1.8,
   * Y_0 = 1, mu~ = m = 1, collapse at a median within 2.5% of the law's for dt = 1e-3 and within 8% for dt = 1e-2. A pair is close if its attraction
   * moves it by more than a sixteenth of what the noise does; steps without a close pair are as they would be with ALL. With NEVER,
   * pairs of an index of -1 or less stay together once they have met. The law of collisions is that of a logarithm: take delta below
   * sqrt(noise dt / m), as particles within delta of one another attract each other less.
   */
  int32_t merging;
  /** `MOLLIS_PKS_SCHEME_*`. Default: Euler-Maruyama. */
  int32_t scheme;
  /** chi of (1.3), any sign; 0 solves no field. Default: 0. */
  double chi;
  /** mu~ of (1.3), at least 0: a particle of mass m diffuses with noise / m. 0 draws no random number. Default: 0. */
  double noise;
  /** The potential is gamma log r near zero. Default: 1 / (2 pi). */
  double gamma;
  /** eta of (3.1), between 0 and 1. Default: 0.1. */
  double separation;
  /** p of (3.2), between 0 and 1: clusters that collide with a smaller probability are left alone. Default: 1e-4. */
  double probability;
  /** The expected jump of a sub-step stays below this length; 0: no limit but the mesh width. Default: 0. */
  double width;
  /** At least so many sub-steps a step. Default: 1. */
  uint32_t at_least;
  /** More sub-steps than this are refused with MOLLIS_ERR_TOO_MANY_SUBSTEPS. Default: 100,000. */
  uint32_t at_most;
  /** Cells of the coarse mesh in which clusters are searched for. Default: 1, 1. */
  uint32_t mesh[2];
  /**
   * The box that this mesh covers, beside all particles: lower and upper corner. All 0: the mesh's rectangle, or twice the particles'
   * bounding box. Default: 0.
   */
  double domain[4];
  /**
   * Nonzero: the coarse mesh is shifted from step to step, so that no cluster lies across the same border for long. Default: 1.
   */
  int32_t shifted;
  /** 0. */
  int32_t reserved;
  /** The seed of the built-in generator. Default: 0. */
  uint64_t seed;
} mollis_pks_options;

/** The arrays of coalescing particles, each with room for as many; the first progress->count are alive. */
typedef struct mollis_pks_particles {
  /** Elements of each array. */
  size_t room;
  /** [room][2]; read and written. */
  double (*positions)[2];
  /** Positive; a merged particle has the sum. */
  double *masses;
  /** All different; a merged particle keeps its lowest. */
  uint64_t *labels;
  /** Travels with the particles; may be null. */
  uint32_t *species;
  /**
   * w_i = m_i / chi_i, positive, for particles of different sensitivities; a merged particle has the sum. Null: all chi_i are 1.
   */
  double *weights;
} mollis_pks_particles;

/** Time, and what a run counts. Zero it, then set `count`; it belongs to the state that a checkpoint saves. */
typedef struct mollis_pks_progress {
  /** The time reached. */
  double time;
  /** Steps made. */
  uint64_t step;
  /** Particles alive: the first so many elements of the arrays. */
  uint64_t count;
  /** Merges of the current step that wait for room in the event buffer; 0 between steps. */
  uint64_t pending;
} mollis_pks_progress;

/**
 * A host's random generator: one stream of uniform bits, drawn serially in the order of the arrays.
 *
 * `fill` overwrites out[0 .. n] with uniform 64-bit words and returns 0; another status ends the call and comes back unchanged. A
 * run continues bit for bit when the host saves its state with the buffers.
 */
typedef struct mollis_generator {
  /** Passed to `fill`. */
  void *state;
  /** Draws the next n words. */
  int32_t (*fill)(void *state, uint64_t *out, size_t n);
} mollis_generator;

/** One merge. */
typedef struct mollis_pks_event {
  /** When it happened, inside the step. */
  double time;
  /** The label that goes on: the lowest. */
  uint64_t label;
  /**
   * The mass of the merged particle: the sum of the kept one's mass and the absorbed ones' in the order of their labels, rounded once.
   *
   * To the bit, in the run's scalar: s = the kept mass, c = 0; for each absorbed mass m: t = s + m, b = t - s,
   * e = (s - (t - b)) + (m - b) + c, s = t + e, c = e - (s - t); the mass is s. What is rounded off is lost: a particle lighter than the
   * last bit of the kept one may add nothing.
   */
  double mass;
  /** The index nu of the cluster (2.7). */
  double index;
  /** Where its absorbed labels begin in the label buffer. */
  uint64_t first;
  /** How many labels were absorbed, at least 1; ascending. */
  uint64_t absorbed;
} mollis_pks_event;

/** Where events go. The host empties the buffers by setting `written` and `labels_written` to 0. */
typedef struct mollis_pks_events {
  /** The events; appended to. */
  struct mollis_pks_event *events;
  /** Room for events. */
  size_t room;
  /** Events written so far. */
  size_t written;
  /** The labels absorbed, event by event; appended to. */
  uint64_t *labels;
  /** Room for labels. */
  size_t labels_room;
  /** Labels written so far. */
  size_t labels_written;
} mollis_pks_events;

/** What steps did; added to. What was skipped is not counted. */
typedef struct mollis_pks_report {
  /** Sub-steps of single particles. */
  uint64_t substeps;
  /** Pairs of normals drawn. */
  uint64_t normals;
  /** Fields solved or summed. */
  uint64_t fields;
  /** Cluster searches made. */
  uint64_t searches;
  /** Clusters that were decided. */
  uint64_t clusters;
  /** Merges. */
  uint64_t merges;
  /** Particles that ended in another one. */
  uint64_t absorbed;
} mollis_pks_report;

typedef struct mollis_pks_particles_f32 {
  size_t room; float (*positions)[2]; float *masses; uint64_t *labels; uint32_t *species; float *weights;
} mollis_pks_particles_f32;

/** What is known in closed form of one kind of particles with total mass `mass`, diffusivity mu and sensitivity chi. */
typedef struct mollis_pks_prediction {
  /** 8 pi mu / chi (1.6); infinite for chi = 0. */
  double critical_mass;
  /** The bound on the time of blow-up (1.8), infinite for a subcritical mass. */
  double blow_up_bound;
  /** The rate of the second moment divided by the mass, heavy point masses beside the regular part (4.12). */
  double second_moment_rate;
} mollis_pks_prediction;

/** One species: its total mass, diffusivity and sensitivity. */
typedef struct mollis_pks_species {
  /** Total mass M_i. */
  double mass;
  /** Diffusivity mu_i. */
  double mu;
  /**
   * Sensitivity chi_i in units of chi, positive; 0 stands for 1. Particles of this species have the weight mass / sensitivity.
   */
  double sensitivity;
} mollis_pks_species;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/** Fills `options` with the defaults. `size` is `sizeof *options`. */
mollis_status mollis_blob_options_init(struct mollis_blob_options *options, size_t size);

/** Fills `options` with the defaults. `size` is `sizeof *options`. */
mollis_status mollis_field_options_init(struct mollis_field_options *options, size_t size);

/**
 * Bytes of workspace that mollis_blob2_step needs for the same arguments, wherever the workspace begins. Of the arrays only counts, strides and which pointers are null or beside
 * each other are looked at. Overwrites `bytes`.
 */
mollis_status mollis_blob2_workspace_bytes(const void *kernel, size_t kernel_bytes, const struct mollis_particles2 *particles,
    const struct mollis_particles2 *tracers, const struct mollis_blob_options *options, const struct mollis_run *run,
    size_t *bytes);
mollis_status mollis_blob2_workspace_bytes_f32(const void *kernel, size_t kernel_bytes,
    const struct mollis_particles2_f32 *particles, const struct mollis_particles2_f32 *tracers,
    const struct mollis_blob_options *options, const struct mollis_run *run, size_t *bytes);
mollis_status mollis_blob1_workspace_bytes(const void *kernel, size_t kernel_bytes, const struct mollis_particles1 *particles,
    const struct mollis_particles1 *tracers, const struct mollis_blob_options *options, const struct mollis_run *run,
    size_t *bytes);
mollis_status mollis_blob1_workspace_bytes_f32(const void *kernel, size_t kernel_bytes,
    const struct mollis_particles1_f32 *particles, const struct mollis_particles1_f32 *tracers,
    const struct mollis_blob_options *options, const struct mollis_run *run, size_t *bytes);
mollis_status mollis_blob3_workspace_bytes(const void *kernel, size_t kernel_bytes, const struct mollis_particles3 *particles,
    const struct mollis_particles3 *tracers, const struct mollis_blob_options *options, const struct mollis_run *run,
    size_t *bytes);
mollis_status mollis_blob3_workspace_bytes_f32(const void *kernel, size_t kernel_bytes,
    const struct mollis_particles3_f32 *particles, const struct mollis_particles3_f32 *tracers,
    const struct mollis_blob_options *options, const struct mollis_run *run, size_t *bytes);

/**
 * Advances a solution of the aggregation equation by `steps` steps of length `dt` of the classical Runge-Kutta method
 * (Craig & Bertozzi, Definitions 2.2 and 2.3; without a mollifier: the particle method).
 *
 * The velocity at x is `-sum_j masses[j] grad K(x - positions[j])`, in 2D or what `options->combination` makes of it: vortices, for example. With `options->diffusion` that of diffusion is added. `tracers`, `options`, `run` and `report` may be null. `steps` may be 0 (then `dt` is not looked at): the
 * velocities and divergences of the state as it is. The workspace is garbage afterwards. Cost: four field evaluations a step, one more if velocity, divergence or energy are
 * wanted; diffusion takes one or two sums more an evaluation; arrays with gaps are copied once a call.
 *
 * A refused call writes nothing but `report` (and what `run` asks for). A run that stops (MOLLIS_ERR_BECAME_NOT_FINITE, also where only velocity, divergence or
 * energy overflow, MOLLIS_ERR_STOPPED, MOLLIS_ERR_ENERGY_ROSE, the executor's own status) leaves positions and densities as they were after the last
 * completed step, and velocity and divergence unwritten.
 */
mollis_status mollis_blob2_step(const void *kernel, size_t kernel_bytes, const struct mollis_particles2 *particles,
    const struct mollis_particles2 *tracers, double dt, size_t steps, const struct mollis_blob_options *options,
    const struct mollis_run *run, void *workspace, size_t workspace_bytes, struct mollis_blob_report *report);
mollis_status mollis_blob2_step_f32(const void *kernel, size_t kernel_bytes, const struct mollis_particles2_f32 *particles,
    const struct mollis_particles2_f32 *tracers, double dt, size_t steps, const struct mollis_blob_options *options,
    const struct mollis_run *run, void *workspace, size_t workspace_bytes, struct mollis_blob_report *report);
mollis_status mollis_blob1_step(const void *kernel, size_t kernel_bytes, const struct mollis_particles1 *particles,
    const struct mollis_particles1 *tracers, double dt, size_t steps, const struct mollis_blob_options *options,
    const struct mollis_run *run, void *workspace, size_t workspace_bytes, struct mollis_blob_report *report);
mollis_status mollis_blob1_step_f32(const void *kernel, size_t kernel_bytes, const struct mollis_particles1_f32 *particles,
    const struct mollis_particles1_f32 *tracers, double dt, size_t steps, const struct mollis_blob_options *options,
    const struct mollis_run *run, void *workspace, size_t workspace_bytes, struct mollis_blob_report *report);
mollis_status mollis_blob3_step(const void *kernel, size_t kernel_bytes, const struct mollis_particles3 *particles,
    const struct mollis_particles3 *tracers, double dt, size_t steps, const struct mollis_blob_options *options,
    const struct mollis_run *run, void *workspace, size_t workspace_bytes, struct mollis_blob_report *report);
mollis_status mollis_blob3_step_f32(const void *kernel, size_t kernel_bytes, const struct mollis_particles3_f32 *particles,
    const struct mollis_particles3_f32 *tracers, double dt, size_t steps, const struct mollis_blob_options *options,
    const struct mollis_run *run, void *workspace, size_t workspace_bytes, struct mollis_blob_report *report);

/**
 * Writes total mass, sum of |m|, centre of mass (one point; 0 where the total mass is 0) and second moment about it,
 * sum m |x - centre|^2, of n particles in two dimensions.
 *
 * `positions` [n][2], `masses` [n], of any sign. Null outputs are not wanted; the others are overwritten. Compensated sums in double
 * precision: a few roundings whatever n. A result is infinite only where the true one is beyond the range. Values that are not finite give results
 * that are not.
 *
 * Refused: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP.
 */
mollis_status mollis_moments2(size_t n, const double (*positions)[2], const double *masses, double *mass, double *absolute_mass,
    double (*centre)[2], double *second);
mollis_status mollis_moments2_f32(size_t n, const float (*positions)[2], const float *masses, float *mass, float *absolute_mass,
    float (*centre)[2], float *second);
mollis_status mollis_moments1(size_t n, const double (*positions)[1], const double *masses, double *mass, double *absolute_mass,
    double (*centre)[1], double *second);
mollis_status mollis_moments1_f32(size_t n, const float (*positions)[1], const float *masses, float *mass, float *absolute_mass,
    float (*centre)[1], float *second);
mollis_status mollis_moments3(size_t n, const double (*positions)[3], const double *masses, double *mass, double *absolute_mass,
    double (*centre)[3], double *second);
mollis_status mollis_moments3_f32(size_t n, const float (*positions)[3], const float *masses, float *mass, float *absolute_mass,
    float (*centre)[3], float *second);

/**
 * Writes a time step with which the classical Runge-Kutta method is stable at this state of n particles in two dimensions: 2.785
 * over a bound of the Jacobian's spectral radius; infinity where nothing moves. Ask again when particles have moved by a
 * good part of delta. Cost: n (n - 1) kernel evaluations. With `combination` (a, b) of mollis_blob_options divide it by 1.07 sqrt(a^2 + b^2): then no mode grows that does not
 * grow in the exact solution, as those of vortices do where they strain each other.
 *
 * Without a mollifier a pair at one place has such a step only if each term of the kernel is a power with p >= 2.
 *
 * Refused, with `step` as it was: MOLLIS_ERR_NOT_FINITE (a position, a mass, or the bound itself; a pair at one place, or whose distance,
 * or the kernel's second derivatives at it, are beyond the scalar's range, however small the masses), the codes of an unprepared kernel (see `mollis_kernel2_eval`), MOLLIS_ERR_NULL_POINTER,
 * MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP.
 */
mollis_status mollis_stable_step2(const void *kernel, size_t kernel_bytes, size_t n, const double (*positions)[2],
    const double *masses, double *step);
mollis_status mollis_stable_step2_f32(const void *kernel, size_t kernel_bytes, size_t n, const float (*positions)[2],
    const float *masses, float *step);
mollis_status mollis_stable_step1(const void *kernel, size_t kernel_bytes, size_t n, const double (*positions)[1],
    const double *masses, double *step);
mollis_status mollis_stable_step1_f32(const void *kernel, size_t kernel_bytes, size_t n, const float (*positions)[1],
    const float *masses, float *step);
mollis_status mollis_stable_step3(const void *kernel, size_t kernel_bytes, size_t n, const double (*positions)[3],
    const double *masses, double *step);
mollis_status mollis_stable_step3_f32(const void *kernel, size_t kernel_bytes, size_t n, const float (*positions)[3],
    const float *masses, float *step);

/**
 * Writes a time step with which the Runge-Kutta method is stable at every state of this total |mass| in which no two
 * particles are farther apart than `diameter`, in two dimensions: shorter than `mollis_stable_step2`'s, but good for a whole run. With
 * `combination` (a, b) divide it by 1.07 sqrt(a^2 + b^2) too.
 *
 * Refused, with `step` as it was: MOLLIS_ERR_NOT_FINITE (an argument, or no such step: a kernel without a mollifier, unless each of its
 * terms is a power with p >= 2; a host's own kernel is not known to be one; or the kernel's second derivatives leave the scalar's range within
 * `diameter`, however small the mass),
 * MOLLIS_ERR_OUT_OF_DOMAIN (a negative argument), the codes of an unprepared kernel, MOLLIS_ERR_NULL_POINTER,
 * MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_OVERLAP.
 */
mollis_status mollis_stable_step2_anywhere(const void *kernel, size_t kernel_bytes, double absolute_mass, double diameter,
    double *step);
mollis_status mollis_stable_step2_anywhere_f32(const void *kernel, size_t kernel_bytes, float absolute_mass, float diameter,
    float *step);
mollis_status mollis_stable_step1_anywhere(const void *kernel, size_t kernel_bytes, double absolute_mass, double diameter,
    double *step);
mollis_status mollis_stable_step1_anywhere_f32(const void *kernel, size_t kernel_bytes, float absolute_mass, float diameter,
    float *step);
mollis_status mollis_stable_step3_anywhere(const void *kernel, size_t kernel_bytes, double absolute_mass, double diameter,
    double *step);
mollis_status mollis_stable_step3_anywhere_f32(const void *kernel, size_t kernel_bytes, float absolute_mass, float diameter,
    float *step);

/**
 * Writes the smallest overlap of n blobs in two dimensions: delta over the spacing (m/density)^(1/2), which is what the sum of blobs
 * samples the density with. A Gaussian's sampling error is exp(-(pi overlap)^2) of the density: 5e-9 at 1.4, 5e-5 at 1. Particles
 * without mass or density are not counted; NaN if all are such.
 *
 * Refused, with `smallest` as it was: MOLLIS_ERR_DELTA, MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE,
 * MOLLIS_ERR_OVERLAP.
 */
mollis_status mollis_overlap2(size_t n, double delta, const double *masses, const double *densities, double *smallest);
mollis_status mollis_overlap2_f32(size_t n, float delta, const float *masses, const float *densities, float *smallest);
mollis_status mollis_overlap1(size_t n, double delta, const double *masses, const double *densities, double *smallest);
mollis_status mollis_overlap1_f32(size_t n, float delta, const float *masses, const float *densities, float *smallest);
mollis_status mollis_overlap3(size_t n, double delta, const double *masses, const double *densities, double *smallest);
mollis_status mollis_overlap3_f32(size_t n, float delta, const float *masses, const float *densities, float *smallest);

/**
 * Bytes of workspace that mollis_field2_eval needs for the same arguments, wherever the workspace begins. Only counts, strides and which pointers are null or beside each other are looked
 * at.
 */
mollis_status mollis_field2_workspace_bytes(const void *kernel, size_t kernel_bytes, const struct mollis_sources2 *sources,
    const struct mollis_targets2 *targets, const struct mollis_outputs2 *outputs, const struct mollis_field_options *options,
    const struct mollis_run *run, size_t *bytes);
mollis_status mollis_field2_workspace_bytes_f32(const void *kernel, size_t kernel_bytes,
    const struct mollis_sources2_f32 *sources, const struct mollis_targets2_f32 *targets,
    const struct mollis_outputs2_f32 *outputs, const struct mollis_field_options *options, const struct mollis_run *run,
    size_t *bytes);
mollis_status mollis_field1_workspace_bytes(const void *kernel, size_t kernel_bytes, const struct mollis_sources1 *sources,
    const struct mollis_targets1 *targets, const struct mollis_outputs1 *outputs, const struct mollis_field_options *options,
    const struct mollis_run *run, size_t *bytes);
mollis_status mollis_field1_workspace_bytes_f32(const void *kernel, size_t kernel_bytes,
    const struct mollis_sources1_f32 *sources, const struct mollis_targets1_f32 *targets,
    const struct mollis_outputs1_f32 *outputs, const struct mollis_field_options *options, const struct mollis_run *run,
    size_t *bytes);
mollis_status mollis_field3_workspace_bytes(const void *kernel, size_t kernel_bytes, const struct mollis_sources3 *sources,
    const struct mollis_targets3 *targets, const struct mollis_outputs3 *outputs, const struct mollis_field_options *options,
    const struct mollis_run *run, size_t *bytes);
mollis_status mollis_field3_workspace_bytes_f32(const void *kernel, size_t kernel_bytes,
    const struct mollis_sources3_f32 *sources, const struct mollis_targets3_f32 *targets,
    const struct mollis_outputs3_f32 *outputs, const struct mollis_field_options *options, const struct mollis_run *run,
    size_t *bytes);

/**
 * Writes a sentence that says which method will run, why, and what is skipped: at most `text_bytes` with the zero at its end. `length` (may be null): the whole
 * sentence's length, without the zero.
 */
mollis_status mollis_field2_text(const void *kernel, size_t kernel_bytes, const struct mollis_sources2 *sources,
    const struct mollis_targets2 *targets, const struct mollis_outputs2 *outputs, const struct mollis_field_options *options,
    char *text, size_t text_bytes, size_t *length);
mollis_status mollis_field2_text_f32(const void *kernel, size_t kernel_bytes, const struct mollis_sources2_f32 *sources,
    const struct mollis_targets2_f32 *targets, const struct mollis_outputs2_f32 *outputs,
    const struct mollis_field_options *options, char *text, size_t text_bytes, size_t *length);
mollis_status mollis_field1_text(const void *kernel, size_t kernel_bytes, const struct mollis_sources1 *sources,
    const struct mollis_targets1 *targets, const struct mollis_outputs1 *outputs, const struct mollis_field_options *options,
    char *text, size_t text_bytes, size_t *length);
mollis_status mollis_field1_text_f32(const void *kernel, size_t kernel_bytes, const struct mollis_sources1_f32 *sources,
    const struct mollis_targets1_f32 *targets, const struct mollis_outputs1_f32 *outputs,
    const struct mollis_field_options *options, char *text, size_t text_bytes, size_t *length);
mollis_status mollis_field3_text(const void *kernel, size_t kernel_bytes, const struct mollis_sources3 *sources,
    const struct mollis_targets3 *targets, const struct mollis_outputs3 *outputs, const struct mollis_field_options *options,
    char *text, size_t text_bytes, size_t *length);
mollis_status mollis_field3_text_f32(const void *kernel, size_t kernel_bytes, const struct mollis_sources3_f32 *sources,
    const struct mollis_targets3_f32 *targets, const struct mollis_outputs3_f32 *outputs,
    const struct mollis_field_options *options, char *text, size_t text_bytes, size_t *length);

/**
 * Sums over sources: u(x_i) = sum_j m_j K_delta(x_i - x_j) at every target, its gradient, Laplacian and second derivatives.
 *
 * `kernel`: a block that mollis_kernel2_prepare filled. Null `targets`: at the sources. A mollified kernel counts every pair, a target on a source included; without a
 * mollifier coincident pairs contribute nothing. `workspace` is garbage afterwards. `options`, `run`, `counters` may be null. With core radii psi and K_delta are those of
 * each source's radius; the kernel has to be Newtonian with a mollifier (MOLLIS_ERR_UNSUPPORTED).
 *
 * Arrays of equal strides may lie within each other like the members of structures. Where they are no arrays without gaps, or results are added or multiplied, the workspace holds a copy of
 * each: some nanoseconds a particle.
 *
 * By the fast multipole method and the tree (MOLLIS_METHOD_FMM, MOLLIS_METHOD_TREE, or chosen for a tolerance) the error is the tolerance, see mollis_field_options. Else it
 * is at most (c + 256 + n/256) u S, u the unit roundoff; with MOLLIS_ACCUMULATION_COMPENSATED (c + 12) u S + (n/4) u^2 S. S is the
 * sum of |m_j| s_j, componentwise for gradients. With K the kernel that mollis_kernel2_eval returns, r = |x_i - x_j|:
 *
 * * Newtonian, mollifier compact or none: s = |K| (in 2D plus 1/(2 pi)), |grad K|, and the mollifier's largest value for a Laplacian; c = 16,
 *   and up to 112 with mollifiers of order 6 or 8, whose coefficients have both signs; for Laplacians 250 at order 6 and 2000 at order 8.
 *   By MOLLIS_METHOD_SORTED c is half as much again.
 * * Other kernels, Gaussian mollifiers, and Newtonian terms beside these: s = A, |x_i - x_j| B (the gradient's components: theirs of
 *   x_i - x_j), and L for a Laplacian, where A, B, L are the largest |K| and r^2 |K'/r|, |K'/r|, |Laplacian| and d |K'/r| at distances from
 *   r/2 to r; where r < delta from 0 to delta; for exponential and screened kernels under Gaussian mollifiers from 0 to r. c = 32 in single
 *   precision; in double 128, and 1000 for Laplacians; 400 and 3000 for exponential and screened kernels whose delta is from 5 to 100
 *   lengths l or 1/k. Of several terms s is the sum of theirs.
 * * Even powers, by MOLLIS_METHOD_MOMENTS and MOLLIS_METHOD_SPLIT: the same, but s = |x_i - x_j| B for each component of a gradient.
 *
 * All of this where neither a result nor K itself is below the normal range. Coordinates below 2^-126 (in double 2^-1022) of the largest
 * one count as zero; by MOLLIS_METHOD_SORTED what is below 2^-120 (2^-1000) of the powers of the largest coordinate may be lost.
 *
 * * Algebraic mollifiers (Plummer's and the like): c = 32, and s is the bare kernel's at the distance (r^2 + delta^2)^(1/2), for Laplacians |Laplacian|, where delta^4
 *   of the largest coordinate is a normal number (delta above 2^-31 of it in single precision).
 *
 * * Second derivatives: s is d |K'/r| and the Laplacian's s together; c = 128, and 1500 in double where a Laplacian's is 1000.
 *
 * Results do not depend on the number of threads, bit for bit. At other levels than portable the last bits of a target's may depend on the other targets of its block of 128: two targets in one place may differ there. A refused call writes nothing (but `run->first_bad`, with
 * MOLLIS_ERR_NOT_FINITE: sources, then targets); a stopped one has written some outputs, if these are arrays without gaps that are overwritten. Refused:
 * MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP, MOLLIS_ERR_NOT_FINITE, MOLLIS_ERR_DELTA (a core radius that is not positive), MOLLIS_ERR_LENGTH_MISMATCH (targets without the core radii that `pair_radius` asks for),
 * MOLLIS_ERR_OUT_OF_DOMAIN (a negative tolerance), MOLLIS_ERR_UNSUPPORTED, MOLLIS_ERR_UNKNOWN_VALUE, MOLLIS_ERR_WORKSPACE_TOO_SMALL, MOLLIS_ERR_NOT_PREPARED and those of an unprepared kernel.
 */
mollis_status mollis_field2_eval(const void *kernel, size_t kernel_bytes, const struct mollis_sources2 *sources,
    const struct mollis_targets2 *targets, const struct mollis_outputs2 *outputs, const struct mollis_field_options *options,
    const struct mollis_run *run, void *workspace, size_t workspace_bytes, struct mollis_field_counts *counters);
mollis_status mollis_field2_eval_f32(const void *kernel, size_t kernel_bytes, const struct mollis_sources2_f32 *sources,
    const struct mollis_targets2_f32 *targets, const struct mollis_outputs2_f32 *outputs,
    const struct mollis_field_options *options, const struct mollis_run *run, void *workspace, size_t workspace_bytes,
    struct mollis_field_counts *counters);
mollis_status mollis_field1_eval(const void *kernel, size_t kernel_bytes, const struct mollis_sources1 *sources,
    const struct mollis_targets1 *targets, const struct mollis_outputs1 *outputs, const struct mollis_field_options *options,
    const struct mollis_run *run, void *workspace, size_t workspace_bytes, struct mollis_field_counts *counters);
mollis_status mollis_field1_eval_f32(const void *kernel, size_t kernel_bytes, const struct mollis_sources1_f32 *sources,
    const struct mollis_targets1_f32 *targets, const struct mollis_outputs1_f32 *outputs,
    const struct mollis_field_options *options, const struct mollis_run *run, void *workspace, size_t workspace_bytes,
    struct mollis_field_counts *counters);
mollis_status mollis_field3_eval(const void *kernel, size_t kernel_bytes, const struct mollis_sources3 *sources,
    const struct mollis_targets3 *targets, const struct mollis_outputs3 *outputs, const struct mollis_field_options *options,
    const struct mollis_run *run, void *workspace, size_t workspace_bytes, struct mollis_field_counts *counters);
mollis_status mollis_field3_eval_f32(const void *kernel, size_t kernel_bytes, const struct mollis_sources3_f32 *sources,
    const struct mollis_targets3_f32 *targets, const struct mollis_outputs3_f32 *outputs,
    const struct mollis_field_options *options, const struct mollis_run *run, void *workspace, size_t workspace_bytes,
    struct mollis_field_counts *counters);

/**
 * Bytes of workspace that mollis_field2_essential needs for the same kernel, sources and tolerance, wherever the workspace begins.
 */
mollis_status mollis_field2_essential_bytes(const void *kernel, size_t kernel_bytes, const struct mollis_sources2 *sources,
    double tolerance, size_t *bytes);
mollis_status mollis_field2_essential_bytes_f32(const void *kernel, size_t kernel_bytes,
    const struct mollis_sources2_f32 *sources, double tolerance, size_t *bytes);
mollis_status mollis_field1_essential_bytes(const void *kernel, size_t kernel_bytes, const struct mollis_sources1 *sources,
    double tolerance, size_t *bytes);
mollis_status mollis_field1_essential_bytes_f32(const void *kernel, size_t kernel_bytes,
    const struct mollis_sources1_f32 *sources, double tolerance, size_t *bytes);
mollis_status mollis_field3_essential_bytes(const void *kernel, size_t kernel_bytes, const struct mollis_sources3 *sources,
    double tolerance, size_t *bytes);
mollis_status mollis_field3_essential_bytes_f32(const void *kernel, size_t kernel_bytes,
    const struct mollis_sources3_f32 *sources, double tolerance, size_t *bytes);

/**
 * Finds fewer sources that act as these do on all targets in a box: what a process sends to those that own the targets there, which add them to their own sources in any sum of the kernel, by
 * whatever method. A tree's cells that are far from the box become proxies: masses at a few points (of a locally essential tree, Warren & Salmon 1992, the expansions).
 * examples_c/mpi_blob.c exchanges particles so.
 *
 * `boxes` [n_boxes]: lower and upper corner. A box whose lower corner is above the upper one along any axis has no targets, and nothing is essential for it. `starts` [n_boxes + 1] is overwritten with where those
 * for each box begin in `positions`, `masses` and `origins` [room], and their number at its end. These are overwritten; `origins` (may be null) says which source each is, 2^64 - 1 for a proxy.
 * With `positions` null and `room` 0 only `starts` is written. Never are there more for a box than sources.
 *
 * Sources with core radii: those of a cell whose largest possible core reaches the box are kept. A source that was kept has its own radius (by its origin), a proxy may have any that sources have.
 *
 * `tolerance`: of what is left out, in the l2 norm over targets in a box relative to that of sum_j |m_j| |K_j|, and the same of gradients; at least 1e-12, in single precision 1e-5. Whatever sum follows adds its own
 * error.
 *
 * Cost: a sort, the moments of the cells that are replaced, each once, and for each box a time proportional to what comes out; on one thread.
 *
 * Refused: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP, MOLLIS_ERR_NOT_FINITE, MOLLIS_ERR_DELTA (a core radius that is not positive), MOLLIS_ERR_OUT_OF_DOMAIN (the tolerance),
 * MOLLIS_ERR_UNSUPPORTED (vector strengths; a kernel of the host's; core radii under an algebraic mollifier or of another kernel than the Newtonian), MOLLIS_ERR_WORKSPACE_TOO_SMALL, MOLLIS_ERR_NOT_PREPARED and those of an unprepared kernel.
 * MOLLIS_ERR_NO_ROOM: `room` is less than starts[n_boxes]; so much is written. MOLLIS_ERR_STOPPED.
 */
mollis_status mollis_field2_essential(const void *kernel, size_t kernel_bytes, const struct mollis_sources2 *sources,
    double tolerance, size_t n_boxes, const double (*boxes)[2][2], uint64_t *starts, size_t room, double (*positions)[2],
    double *masses, uint64_t *origins, const struct mollis_run *run, void *workspace, size_t workspace_bytes);
mollis_status mollis_field2_essential_f32(const void *kernel, size_t kernel_bytes, const struct mollis_sources2_f32 *sources,
    double tolerance, size_t n_boxes, const float (*boxes)[2][2], uint64_t *starts, size_t room, float (*positions)[2],
    float *masses, uint64_t *origins, const struct mollis_run *run, void *workspace, size_t workspace_bytes);
mollis_status mollis_field1_essential(const void *kernel, size_t kernel_bytes, const struct mollis_sources1 *sources,
    double tolerance, size_t n_boxes, const double (*boxes)[2][1], uint64_t *starts, size_t room, double (*positions)[1],
    double *masses, uint64_t *origins, const struct mollis_run *run, void *workspace, size_t workspace_bytes);
mollis_status mollis_field1_essential_f32(const void *kernel, size_t kernel_bytes, const struct mollis_sources1_f32 *sources,
    double tolerance, size_t n_boxes, const float (*boxes)[2][1], uint64_t *starts, size_t room, float (*positions)[1],
    float *masses, uint64_t *origins, const struct mollis_run *run, void *workspace, size_t workspace_bytes);
mollis_status mollis_field3_essential(const void *kernel, size_t kernel_bytes, const struct mollis_sources3 *sources,
    double tolerance, size_t n_boxes, const double (*boxes)[2][3], uint64_t *starts, size_t room, double (*positions)[3],
    double *masses, uint64_t *origins, const struct mollis_run *run, void *workspace, size_t workspace_bytes);
mollis_status mollis_field3_essential_f32(const void *kernel, size_t kernel_bytes, const struct mollis_sources3_f32 *sources,
    double tolerance, size_t n_boxes, const float (*boxes)[2][3], uint64_t *starts, size_t room, float (*positions)[3],
    float *masses, uint64_t *origins, const struct mollis_run *run, void *workspace, size_t workspace_bytes);

/**
 * Bytes of workspace that mollis_grid2_eval needs for the same arguments, wherever it begins, with this run's executor. Of the arrays only counts, strides and which
 * pointers are null or beside each other are looked at.
 *
 * Refused: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_NOT_FINITE, MOLLIS_ERR_OUT_OF_DOMAIN (an empty rectangle, fewer than 2 cells, a corner beyond
 * 2^-13 of the scalar's largest number, a mesh width below its normal range, cells more than 2^40 times as long as wide),
 * MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_UNKNOWN_VALUE (walls, order), MOLLIS_ERR_KERNEL_PARAMETER (screening), MOLLIS_ERR_UNSUPPORTED (second
 * moments with screening; order 4 with long or coarse cells; a medium with screening, order 4 or second moments; a memory with those or a medium), MOLLIS_ERR_OPTIONS_SIZE,
 * MOLLIS_ERR_NOT_INITIALISED.
 */
mollis_status mollis_grid2_workspace_bytes(const struct mollis_mesh2 *mesh, const struct mollis_sources2 *sources,
    const struct mollis_targets2 *targets, const struct mollis_grid2_outputs *outputs, const struct mollis_grid2_options *options,
    const struct mollis_run *run, size_t *bytes);
mollis_status mollis_grid2_workspace_bytes_f32(const struct mollis_mesh2 *mesh, const struct mollis_sources2_f32 *sources,
    const struct mollis_targets2_f32 *targets, const struct mollis_grid2_outputs_f32 *outputs,
    const struct mollis_grid2_options *options, const struct mollis_run *run, size_t *bytes);

/**
 * The field of masses of any sign on a mesh: u(x) = sum_j masses[j] V(x - x_j), V = log r / (2 pi), or -K0(k r) / (2 pi) with
 * screening k. Cloud-in-cell deposit in 64-bit fixed point, the five-point scheme solved exactly, bilinear interpolation of its centred
 * differences (Zhelezov & Fatkullin, (3.6) to (3.10), whose c is -u); or the scheme of fourth order, see mollis_grid2_options.
 *
 * With a medium V is the solution of div(G grad V) - k^2 V = Dirac, see mollis_medium2; MOLLIS_ERR_NOT_CONVERGED: the iteration did not reach its tolerance, and the outputs are those of the last
 * iterate. Refused beside what is below: MOLLIS_ERR_OUT_OF_DOMAIN (G <= 0, k^2 < 0, a G too far below the largest, a tolerance that is not positive), MOLLIS_ERR_UNSUPPORTED (free space
 * with coefficients that differ on the border), MOLLIS_ERR_NOT_FINITE (first_bad is not set).
 *
 * With an attractant with a memory u is -c after the density has acted for its `time`, and c is written, whatever outputs there are; see mollis_parabolic2. The monopole acts nowhere then: total
 * and outside are as ever. Refused beside what is below: MOLLIS_ERR_OUT_OF_DOMAIN (a time scale that is not positive, values on a free border), MOLLIS_ERR_TIME_STEP, MOLLIS_ERR_NOT_FINITE
 * (first_bad is not set).
 *
 * Masses are rounded to a unit between 2^-50 and 2^-49 of the sum of |masses|, four shares each: beside the others a mass below 2^-51 =
 * 4.4e-16 of that sum adds nothing, and one of 1e-12 has three digits. Of a source outside, the distance from the mesh's middle counts up to 1024 widths
 * of the mesh in the centre of mass.
 *
 * Range: the sum of |masses| over a cell's width, and over the distance of a target outside, has to be in range; where it is not, gradients are infinite
 * or NaN.
 *
 * What no output needs is not computed. Sources have masses alone (MOLLIS_ERR_UNSUPPORTED: core radii, vector strengths); null targets are the sources. The bits do not depend on the order of the
 * sources, on the executor or on the level. The workspace is scratch, of mollis_grid2_workspace_bytes.
 *
 * Refused, with nothing written: the errors of mollis_grid2_workspace_bytes, MOLLIS_ERR_WORKSPACE_TOO_SMALL, MOLLIS_ERR_MISALIGNED,
 * MOLLIS_ERR_OVERLAP, MOLLIS_ERR_NOT_FINITE (run->first_bad: sources, then targets). MOLLIS_ERR_STOPPED, MOLLIS_ERR_EXECUTOR, the executor's
 * own: outputs are then undefined.
 */
mollis_status mollis_grid2_eval(const struct mollis_mesh2 *mesh, const struct mollis_sources2 *sources,
    const struct mollis_targets2 *targets, const struct mollis_grid2_outputs *outputs, const struct mollis_grid2_options *options,
    const struct mollis_run *run, void *workspace, size_t workspace_bytes);
mollis_status mollis_grid2_eval_f32(const struct mollis_mesh2 *mesh, const struct mollis_sources2_f32 *sources,
    const struct mollis_targets2_f32 *targets, const struct mollis_grid2_outputs_f32 *outputs,
    const struct mollis_grid2_options *options, const struct mollis_run *run, void *workspace, size_t workspace_bytes);

/**
 * Writes the exact size in bytes of a prepared kernel in two dimensions: the sum of n_terms terms (at most
 * MOLLIS_KERNEL_MAX_TERMS) and, if not null, a host's own kernel, under a mollifier. It does not depend on delta.
 *
 * Under MOLLIS_MOLLIFIER_RICHARDSON a term that is not Newtonian counts for as many as there are radii, and a host's own kernel is refused (MOLLIS_ERR_UNSUPPORTED).
 *
 * Refused: MOLLIS_ERR_KERNEL_TERMS (none or too many), MOLLIS_ERR_KERNEL_PARAMETER, MOLLIS_ERR_NOT_FINITE,
 * MOLLIS_ERR_UNKNOWN_VALUE, MOLLIS_ERR_ORDER, MOLLIS_ERR_EXPONENT, MOLLIS_ERR_DIMENSION (Vatistas' mollifier but in the plane),
 * MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_OVERLAP.
 */
mollis_status mollis_kernel2_bytes(const struct mollis_kernel_term *terms, size_t n_terms, const struct mollis_radial_kernel *own,
    struct mollis_mollifier mollifier, size_t *bytes);
mollis_status mollis_kernel2_bytes_f32(const struct mollis_kernel_term *terms, size_t n_terms,
    const struct mollis_radial_kernel *own, struct mollis_mollifier mollifier, size_t *bytes);
mollis_status mollis_kernel1_bytes(const struct mollis_kernel_term *terms, size_t n_terms, const struct mollis_radial_kernel *own,
    struct mollis_mollifier mollifier, size_t *bytes);
mollis_status mollis_kernel1_bytes_f32(const struct mollis_kernel_term *terms, size_t n_terms,
    const struct mollis_radial_kernel *own, struct mollis_mollifier mollifier, size_t *bytes);
mollis_status mollis_kernel3_bytes(const struct mollis_kernel_term *terms, size_t n_terms, const struct mollis_radial_kernel *own,
    struct mollis_mollifier mollifier, size_t *bytes);
mollis_status mollis_kernel3_bytes_f32(const struct mollis_kernel_term *terms, size_t n_terms,
    const struct mollis_radial_kernel *own, struct mollis_mollifier mollifier, size_t *bytes);

/**
 * Prepares the sum of n_terms terms and, if not null, a host's own kernel, mollified over the length delta, in two dimensions.
 *
 * `kernel` holds as many `bytes` as the size query asked, at a multiple of 8 (sums are a little faster at a multiple of 64); it is overwritten. The prepared block holds no
 * pointers: it may be copied, moved, saved, and read by several threads at a time. Closed forms take microseconds, fits
 * milliseconds to tens of them. delta is not looked at without a mollifier.
 *
 * Refused: as by the size query, and MOLLIS_ERR_WORKSPACE_TOO_SMALL, MOLLIS_ERR_DELTA, MOLLIS_ERR_UNSUPPORTED (delta is many times
 * a length l or 1/k: about 600 times, 13 to 26 under a Gaussian mollifier; or exponent M = 1 with a power 0 < p + d - 1 < 0.08, whose
 * Laplacian is all but infinite at delta; or a mollified power above about 20, whose fits do not converge), MOLLIS_ERR_KERNEL_REACH, MOLLIS_ERR_KERNEL_KNOTS, MOLLIS_ERR_KERNEL_FIT (the own kernel),
 * MOLLIS_ERR_OUT_OF_DOMAIN (its `least` or tolerance; or a coefficient leaves the scalar's range, in
 * single precision at some 90 lengths, 4.7 to 13 under a Gaussian mollifier; or K'/r of a kernel that isn't Newtonian leaves double precision at
 * distances of about delta, without a mollifier of about its length), MOLLIS_ERR_NOT_FINITE (the own kernel returned such a value), or the status
 * that the own kernel returned. After an error the block is not prepared, unless it was before and the size query or MOLLIS_ERR_DELTA refused.
 */
mollis_status mollis_kernel2_prepare(void *kernel, size_t bytes, const struct mollis_kernel_term *terms, size_t n_terms,
    const struct mollis_radial_kernel *own, struct mollis_mollifier mollifier, double delta);
mollis_status mollis_kernel2_prepare_f32(void *kernel, size_t bytes, const struct mollis_kernel_term *terms, size_t n_terms,
    const struct mollis_radial_kernel *own, struct mollis_mollifier mollifier, float delta);
mollis_status mollis_kernel1_prepare(void *kernel, size_t bytes, const struct mollis_kernel_term *terms, size_t n_terms,
    const struct mollis_radial_kernel *own, struct mollis_mollifier mollifier, double delta);
mollis_status mollis_kernel1_prepare_f32(void *kernel, size_t bytes, const struct mollis_kernel_term *terms, size_t n_terms,
    const struct mollis_radial_kernel *own, struct mollis_mollifier mollifier, float delta);
mollis_status mollis_kernel3_prepare(void *kernel, size_t bytes, const struct mollis_kernel_term *terms, size_t n_terms,
    const struct mollis_radial_kernel *own, struct mollis_mollifier mollifier, double delta);
mollis_status mollis_kernel3_prepare_f32(void *kernel, size_t bytes, const struct mollis_kernel_term *terms, size_t n_terms,
    const struct mollis_radial_kernel *own, struct mollis_mollifier mollifier, float delta);

/**
 * Writes K_delta(r), K_delta'(r)/r and the Laplacian of K_delta at n distances (their magnitudes), of a kernel prepared in
 * two dimensions. Null outputs are not wanted; the others are overwritten. Without a mollifier all are 0 at r = 0.
 *
 * Either precision computes in double and rounds once. Errors of a term are below 8 ulp of |value| for closed forms (powers 2, 4, 6, ...;
 * in one and three dimensions and without a Gaussian mollifier 1, 3, 5, ... too), and else below 1e-13 of the larger of |value| and the term's
 * scale at delta: the magnitude that it has there without a mollifier (for a logarithm at least 1; for the Laplacian at least that of the
 * gradient factor). Where delta is more than 5 times a length l or 1/k, the scale is |K| * |psi_delta| at r, if that is larger. (Beyond some 100 lengths, and beyond power 12 under a
 * Gaussian mollifier, errors are up to 2e-12.) Results are
 * infinite or zero only where the true ones leave the range; K_delta'(r)/r may, where the gradient does not.
 * From 10 (closed forms) to some hundred nanoseconds a term and distance.
 *
 * Refused, with every output as it was: MOLLIS_ERR_NOT_PREPARED, MOLLIS_ERR_WRONG_VERSION, MOLLIS_ERR_WRONG_SCALAR,
 * MOLLIS_ERR_WRONG_BYTE_ORDER, MOLLIS_ERR_WORKSPACE_TOO_SMALL, MOLLIS_ERR_NOT_FINITE (some r), MOLLIS_ERR_NULL_POINTER,
 * MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP.
 */
mollis_status mollis_kernel2_eval(const void *kernel, size_t bytes, size_t n, const double *r, double *value,
    double *gradient_factor, double *laplacian);
mollis_status mollis_kernel2_eval_f32(const void *kernel, size_t bytes, size_t n, const float *r, float *value,
    float *gradient_factor, float *laplacian);
mollis_status mollis_kernel1_eval(const void *kernel, size_t bytes, size_t n, const double *r, double *value,
    double *gradient_factor, double *laplacian);
mollis_status mollis_kernel1_eval_f32(const void *kernel, size_t bytes, size_t n, const float *r, float *value,
    float *gradient_factor, float *laplacian);
mollis_status mollis_kernel3_eval(const void *kernel, size_t bytes, size_t n, const double *r, double *value,
    double *gradient_factor, double *laplacian);
mollis_status mollis_kernel3_eval_f32(const void *kernel, size_t bytes, size_t n, const float *r, float *value,
    float *gradient_factor, float *laplacian);

/**
 * A mollifier and its Newtonian field in two dimensions, as functions of n distances r[n] (their magnitudes).
 *
 * With psi_delta(x) = delta^-2 psi(x/delta) and phi = K * psi_delta, K = log|x|/(2 pi), writes density = psi_delta(r), density_slope
 * = psi_delta'(r)/r, potential = phi(r), gradient_factor g = phi'(r)/r (grad phi = g x), hessian_factor h = g'(r)/r
 * (Hess phi = g I + h x x^T) and enclosed_mass, the integral of psi_delta over |x| < r: n values each, overwritten.
 * A null output is not wanted and not computed. Without a mollifier all are 0 at r = 0, the density everywhere.
 *
 * Values are within 1 ulp, the density of orders above 2 (it has zeros) too; they overflow and underflow only where the
 * true value does. Half a microsecond each (compact; the potential in 2D 2), 5 to 50 (Gaussian): not for sums over particles.
 *
 * Refused, with every output as it was: MOLLIS_ERR_DELTA, MOLLIS_ERR_ORDER, MOLLIS_ERR_EXPONENT, MOLLIS_ERR_UNKNOWN_VALUE,
 * MOLLIS_ERR_NOT_FINITE (some r), MOLLIS_ERR_NULL_POINTER (r, with n > 0), MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE,
 * MOLLIS_ERR_OVERLAP.
 */
mollis_status mollis_mollifier2_eval(struct mollis_mollifier mollifier, double delta, size_t n, const double *r, double *density,
    double *density_slope, double *potential, double *gradient_factor, double *hessian_factor, double *enclosed_mass);
mollis_status mollis_mollifier2_eval_f32(struct mollis_mollifier mollifier, float delta, size_t n, const float *r, float *density,
    float *density_slope, float *potential, float *gradient_factor, float *hessian_factor, float *enclosed_mass);
mollis_status mollis_mollifier1_eval(struct mollis_mollifier mollifier, double delta, size_t n, const double *r, double *density,
    double *density_slope, double *potential, double *gradient_factor, double *hessian_factor, double *enclosed_mass);
mollis_status mollis_mollifier1_eval_f32(struct mollis_mollifier mollifier, float delta, size_t n, const float *r, float *density,
    float *density_slope, float *potential, float *gradient_factor, float *hessian_factor, float *enclosed_mass);
mollis_status mollis_mollifier3_eval(struct mollis_mollifier mollifier, double delta, size_t n, const double *r, double *density,
    double *density_slope, double *potential, double *gradient_factor, double *hessian_factor, double *enclosed_mass);
mollis_status mollis_mollifier3_eval_f32(struct mollis_mollifier mollifier, float delta, size_t n, const float *r, float *density,
    float *density_slope, float *potential, float *gradient_factor, float *hessian_factor, float *enclosed_mass);

/**
 * The smooth Heaviside function of a mollifier in one dimension at n places x[n]: the integral of psi_delta from -infinity
 * to x, written to values[n]. 0 left and 1 right of a compact support; without a mollifier the step, 1/2 at 0.
 *
 * Refused as mollis_mollifier1_eval does; values must not be null for n > 0.
 */
mollis_status mollis_mollifier1_heaviside(struct mollis_mollifier mollifier, double delta, size_t n, const double *x,
    double *values);
mollis_status mollis_mollifier1_heaviside_f32(struct mollis_mollifier mollifier, float delta, size_t n, const float *x,
    float *values);

/**
 * The moment of order k of a mollifier in two dimensions: the integral of |x|^k psi_delta(x), written to *value.
 * Exactly 0 for even k above 0 and below the mollifier's order.
 *
 * Refused: MOLLIS_ERR_OUT_OF_DOMAIN (k > 64), MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_DELTA, MOLLIS_ERR_ORDER, MOLLIS_ERR_EXPONENT,
 * MOLLIS_ERR_UNKNOWN_VALUE.
 */
mollis_status mollis_mollifier2_moment(struct mollis_mollifier mollifier, double delta, uint32_t k, double *value);
mollis_status mollis_mollifier2_moment_f32(struct mollis_mollifier mollifier, float delta, uint32_t k, float *value);
mollis_status mollis_mollifier1_moment(struct mollis_mollifier mollifier, double delta, uint32_t k, double *value);
mollis_status mollis_mollifier1_moment_f32(struct mollis_mollifier mollifier, float delta, uint32_t k, float *value);
mollis_status mollis_mollifier3_moment(struct mollis_mollifier mollifier, double delta, uint32_t k, double *value);
mollis_status mollis_mollifier3_moment_f32(struct mollis_mollifier mollifier, float delta, uint32_t k, float *value);

/**
 * A mollifier's Newtonian field about a particle of unit mass at the origin, at n points x[n][2] of the plane: density[n],
 * potential[n], gradient[n][2], hessian[n][2][2] (symmetric, its trace the density), overwritten; null ones are not computed.
 *
 * Of compact mollifiers values are within 1 ulp, but for the density at points closer to the edge of the support than rounding of
 * x can tell. Gaussians are evaluated plainly, in tens of nanoseconds (their Hessian in tens of microseconds): to a few ulp, the
 * density of its maximum, the potential in 2D of 1 + |log delta|. Without a mollifier everything is 0 at x = 0.
 *
 * Refused as mollis_mollifier2_eval does; MOLLIS_ERR_NOT_FINITE for any coordinate.
 */
mollis_status mollis_mollifier2_field(struct mollis_mollifier mollifier, double delta, size_t n, const double (*x)[2],
    double *density, double *potential, double (*gradient)[2], double (*hessian)[2][2]);
mollis_status mollis_mollifier2_field_f32(struct mollis_mollifier mollifier, float delta, size_t n, const float (*x)[2],
    float *density, float *potential, float (*gradient)[2], float (*hessian)[2][2]);
mollis_status mollis_mollifier1_field(struct mollis_mollifier mollifier, double delta, size_t n, const double (*x)[1],
    double *density, double *potential, double (*gradient)[1], double (*hessian)[1][1]);
mollis_status mollis_mollifier1_field_f32(struct mollis_mollifier mollifier, float delta, size_t n, const float (*x)[1],
    float *density, float *potential, float (*gradient)[1], float (*hessian)[1][1]);
mollis_status mollis_mollifier3_field(struct mollis_mollifier mollifier, double delta, size_t n, const double (*x)[3],
    double *density, double *potential, double (*gradient)[3], double (*hessian)[3][3]);
mollis_status mollis_mollifier3_field_f32(struct mollis_mollifier mollifier, float delta, size_t n, const float (*x)[3],
    float *density, float *potential, float (*gradient)[3], float (*hessian)[3][3]);

/**
 * A Richardson combination in two dimensions (Anderson (8) to (10)): the sum over j of weight[j] B_gamma, gamma = radii[j], of one
 * mollifier at lengths radii[j] * delta, 1 to 4 different radii in (0, 1]. Of order p + 2 (n_radii - 1) for a mollifier of order p.
 *
 * weights[n_radii] is written if not null; the functions of n distances r[n] are those of mollis_mollifier2_eval.
 *
 * Errors are below 1 ulp where the parts do not cancel, for lengths radii[j] * delta as they are rounded to the scalar. (The rounding of
 * that product moves each part by up to half an ulp of its length; it is exact for powers of two.)
 *
 * Refused as there; also MOLLIS_ERR_LENGTH_MISMATCH (no radius or more than 4), MOLLIS_ERR_OUT_OF_DOMAIN (a radius outside (0, 1] or
 * two equal ones), MOLLIS_ERR_UNSUPPORTED (no mollifier).
 */
mollis_status mollis_mollifier2_richardson(struct mollis_mollifier mollifier, double delta, size_t n_radii, const double *radii,
    double *weights, size_t n, const double *r, double *density, double *density_slope, double *potential,
    double *gradient_factor, double *hessian_factor, double *enclosed_mass);
mollis_status mollis_mollifier2_richardson_f32(struct mollis_mollifier mollifier, float delta, size_t n_radii, const float *radii,
    float *weights, size_t n, const float *r, float *density, float *density_slope, float *potential, float *gradient_factor,
    float *hessian_factor, float *enclosed_mass);
mollis_status mollis_mollifier1_richardson(struct mollis_mollifier mollifier, double delta, size_t n_radii, const double *radii,
    double *weights, size_t n, const double *r, double *density, double *density_slope, double *potential,
    double *gradient_factor, double *hessian_factor, double *enclosed_mass);
mollis_status mollis_mollifier1_richardson_f32(struct mollis_mollifier mollifier, float delta, size_t n_radii, const float *radii,
    float *weights, size_t n, const float *r, float *density, float *density_slope, float *potential, float *gradient_factor,
    float *hessian_factor, float *enclosed_mass);
mollis_status mollis_mollifier3_richardson(struct mollis_mollifier mollifier, double delta, size_t n_radii, const double *radii,
    double *weights, size_t n, const double *r, double *density, double *density_slope, double *potential,
    double *gradient_factor, double *hessian_factor, double *enclosed_mass);
mollis_status mollis_mollifier3_richardson_f32(struct mollis_mollifier mollifier, float delta, size_t n_radii, const float *radii,
    float *weights, size_t n, const float *r, float *density, float *density_slope, float *potential, float *gradient_factor,
    float *hessian_factor, float *enclosed_mass);

/**
 * Writes the L^p_h norm (sum |v_i|^p cell)^(1/p) of n values, cell = h^d, 1 <= p; the largest |v_i| for infinite p. The sum is
 * compensated and in double precision: a few roundings whatever n.
 *
 * Refused, with `norm` as it was: MOLLIS_ERR_OUT_OF_DOMAIN (p or cell), MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED,
 * MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP. NaN gives NaN.
 */
mollis_status mollis_norm(size_t n, const double *values, double cell, double p, double *norm);
mollis_status mollis_norm_f32(size_t n, const float *values, float cell, float p, float *norm);

/**
 * Writes the L^p_h norm of the distances |a_i - b_i| of n pairs of points in two dimensions: the error of trajectories.
 *
 * Refused as by `mollis_norm`.
 */
mollis_status mollis_distance_norm2(size_t n, const double (*a)[2], const double (*b)[2], double cell, double p, double *norm);
mollis_status mollis_distance_norm2_f32(size_t n, const float (*a)[2], const float (*b)[2], float cell, float p, float *norm);
mollis_status mollis_distance_norm1(size_t n, const double (*a)[1], const double (*b)[1], double cell, double p, double *norm);
mollis_status mollis_distance_norm1_f32(size_t n, const float (*a)[1], const float (*b)[1], float cell, float p, float *norm);
mollis_status mollis_distance_norm3(size_t n, const double (*a)[3], const double (*b)[3], double cell, double p, double *norm);
mollis_status mollis_distance_norm3_f32(size_t n, const float (*a)[3], const float (*b)[3], float cell, float p, float *norm);

/**
 * Writes the W^{1,p}_h norm of a function on a box of the lattice h Z^2: (|v|^p + sum_j |D_j v|^p)^(1/p) in L^p_h, with forward differences D_j over
 * h; for infinite p the largest of all. Outside the box the function is zero, so differences at its border count.
 *
 * `values` holds points[0] * points[1] numbers, the first axis fastest; `spacing` is h; 1 <= p.
 *
 * Refused, with `norm` as it was: MOLLIS_ERR_OUT_OF_DOMAIN (p, or h or h^2 out of range), MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_NULL_POINTER,
 * MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_OVERLAP. NaN gives NaN.
 */
mollis_status mollis_sobolev_norm2(const size_t (*points)[2], double spacing, double p, const double *values, double *norm);
mollis_status mollis_sobolev_norm2_f32(const size_t (*points)[2], float spacing, float p, const float *values, float *norm);
mollis_status mollis_sobolev_norm1(const size_t (*points)[1], double spacing, double p, const double *values, double *norm);
mollis_status mollis_sobolev_norm1_f32(const size_t (*points)[1], float spacing, float p, const float *values, float *norm);
mollis_status mollis_sobolev_norm3(const size_t (*points)[3], double spacing, double p, const double *values, double *norm);
mollis_status mollis_sobolev_norm3_f32(const size_t (*points)[3], float spacing, float p, const float *values, float *norm);

/**
 * Writes the bytes of workspace that `mollis_dual_norm2` needs for a box of points[0] x points[1] lattice points (one
 * array of two sizes) and this margin.
 *
 * Refused: MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_OVERLAP.
 */
mollis_status mollis_dual_norm2_workspace_bytes(const size_t (*points)[2], size_t margin, size_t *bytes);
mollis_status mollis_dual_norm2_workspace_bytes_f32(const size_t (*points)[2], size_t margin, size_t *bytes);
mollis_status mollis_dual_norm1_workspace_bytes(const size_t (*points)[1], size_t margin, size_t *bytes);
mollis_status mollis_dual_norm1_workspace_bytes_f32(const size_t (*points)[1], size_t margin, size_t *bytes);
mollis_status mollis_dual_norm3_workspace_bytes(const size_t (*points)[3], size_t margin, size_t *bytes);
mollis_status mollis_dual_norm3_workspace_bytes_f32(const size_t (*points)[3], size_t margin, size_t *bytes);

/**
 * Writes the W^{-1,2}_h norm of a function on a box of the lattice h Z^2, in which the density of the blob method converges.
 *
 * `values` holds points[0] * points[1] numbers, the first axis fastest; `spacing` is h; `margin` points of zeros on each side
 * stand for the rest of the lattice, and cut off about e^{-2 margin h} of the norm. A discrete Poisson problem by conjugate
 * gradients: about 10 sqrt(1 + 8/h^2) sweeps over box and margin.
 *
 * Refused, with `norm` as it was: MOLLIS_ERR_NOT_FINITE (a value), MOLLIS_ERR_OUT_OF_DOMAIN (the spacing), MOLLIS_ERR_TOO_LARGE,
 * MOLLIS_ERR_WORKSPACE_TOO_SMALL, MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_OVERLAP.
 */
mollis_status mollis_dual_norm2(const size_t (*points)[2], double spacing, size_t margin, const double *values, double *norm,
    void *workspace, size_t workspace_bytes);
mollis_status mollis_dual_norm2_f32(const size_t (*points)[2], float spacing, size_t margin, const float *values, float *norm,
    void *workspace, size_t workspace_bytes);
mollis_status mollis_dual_norm1(const size_t (*points)[1], double spacing, size_t margin, const double *values, double *norm,
    void *workspace, size_t workspace_bytes);
mollis_status mollis_dual_norm1_f32(const size_t (*points)[1], float spacing, size_t margin, const float *values, float *norm,
    void *workspace, size_t workspace_bytes);
mollis_status mollis_dual_norm3(const size_t (*points)[3], double spacing, size_t margin, const double *values, double *norm,
    void *workspace, size_t workspace_bytes);
mollis_status mollis_dual_norm3_f32(const size_t (*points)[3], float spacing, size_t margin, const float *values, float *norm,
    void *workspace, size_t workspace_bytes);

/**
 * Writes the index of the first of n elements of `each` numbers (n points in D dimensions: `each` is D) that holds one that is not finite, or
 * `MOLLIS_NONE_BAD`: which element a function meant that returned `MOLLIS_ERR_NOT_FINITE` and takes no `mollis_run` to tell it.
 *
 * Refused, with `first` as it was: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP.
 */
mollis_status mollis_first_bad(size_t n, size_t each, const double *values, uint64_t *first);
mollis_status mollis_first_bad_f32(size_t n, size_t each, const float *values, uint64_t *first);

/**
 * Bytes of the workspace that mollis_pks_step needs for arrays with room for so many particles, wherever it begins, with this run's executor and communicator: on
 * ranks each has so much room.
 *
 * Refused: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_OVERLAP, MOLLIS_ERR_OPTIONS_SIZE, MOLLIS_ERR_NOT_INITIALISED, MOLLIS_ERR_UNKNOWN_VALUE, MOLLIS_ERR_NOT_FINITE,
 * MOLLIS_ERR_OUT_OF_DOMAIN (a negative noise, separation or probability not between 0 and 1, an empty mesh),
 * MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_UNSUPPORTED (heavy particles in a box, or by a singular kernel), and those of an unprepared kernel.
 */
mollis_status mollis_pks_workspace_bytes(size_t room, const struct mollis_pks_attraction *attraction,
    const struct mollis_pks_options *options, const struct mollis_run *run, size_t *bytes);
mollis_status mollis_pks_workspace_bytes_f32(size_t room, const struct mollis_pks_attraction *attraction,
    const struct mollis_pks_options *options, const struct mollis_run *run, size_t *bytes);

/**
 * Advances coalescing particles by `steps` steps of length dt (Zhelezov & Fatkullin, Section 3.2): finds the clusters that may collide, moves
 * every particle by chi times the attraction and its own noise, decides the collisions and merges at the centre of mass.
 *
 * Events are appended: every merge. `generator`: the host's stream, drawn in array order, then for heavy particles; null: the built-in one with options->seed, a
 * stream a label. The report is added to, and may be null, as `run` may.
 *
 * Merging lowers progress->count; the particles that are left keep their order. Arrays, progress and the generator's state are all that a
 * run is: copied away and back between calls it continues bit for bit. With the built-in generator the result does not
 * depend on the executor.
 *
 * Sensitivities (Section 4.5): with weights particle i drifts by chi_i = m_i / w_i times chi times the attraction, which masses alone make, and diffuses with noise / w_i. With these a pair's forces are mutual, so
 * that the centre of the weights rests but for noise; clusters merge there, and have the index (2.7) of their masses. MOLLIS_ERR_MASS: a weight is not positive. MOLLIS_ERR_OUT_OF_DOMAIN: a sensitivity out of range.
 * MOLLIS_ERR_UNSUPPORTED with heavy particles, on more than one rank, for a sum with noise and another merging than MOLLIS_PKS_MERGE_ALL, and in firmware.
 *
 * Range: the result does not depend on the units, up to rounding; a mesh in free space loses digits by the logarithm of its size. Masses, and chi, noise and gamma where they are not 0, have to be normal
 * numbers of the scalar (MOLLIS_ERR_OUT_OF_DOMAIN), and the gradient (mass / length) and chi times it have to be
 * in range, as must mass / length^2 for heavy particles; what leaves the range ends in MOLLIS_ERR_BECAME_NOT_FINITE or MOLLIS_ERR_TOO_MANY_SUBSTEPS. An attraction so strong against
 * a positive noise that indices are out of range (chi M^2 / noise above 1e38 for f32, M being the mass of all particles) is MOLLIS_ERR_OUT_OF_DOMAIN.
 * Masses below 1e-19 of M (f32; 1e-154 for f64) do not collide with one another.
 *
 * On ranks (`run->communicator`) the particles are those of all ranks, and each passes its own. Results are bit for bit those of one process whose arrays are the ranks' one after the
 * other. All ranks get all events; a merged particle stays where the one with its lowest label was, and any rank may be left without particles. Give all of them arrays of the same room, and
 * buffers of events of the same room. The report's sub-steps and normals are the rank's own, its other numbers those of all. An attraction by a sum, heavy particles, a medium, an attractant with a memory, and noise from the host's generator
 * are MOLLIS_ERR_UNSUPPORTED with more than one rank.
 *
 * MOLLIS_ERR_EVENTS_FULL: the step stopped before a merge that has no room; empty the buffers (or give larger ones) and call again with the
 * same workspace (or its bytes at an address that is equal modulo MOLLIS_ALIGN): it goes on with progress->pending merges. Any other status leaves the state of the last completed step:
 * MOLLIS_ERR_TOO_MANY_SUBSTEPS, MOLLIS_ERR_BECAME_NOT_FINITE, MOLLIS_ERR_STOPPED, the generator's or executor's own, as they returned it. Refused with nothing
 * written: MOLLIS_ERR_NOT_FINITE (run->first_bad: the particle), MOLLIS_ERR_MASS, MOLLIS_ERR_TIME_STEP, MOLLIS_ERR_OUT_OF_DOMAIN, MOLLIS_ERR_LENGTH_MISMATCH (count > room),
 * MOLLIS_ERR_OVERLAP, MOLLIS_ERR_UNSUPPORTED (heavy particles in a box, or by a singular kernel), MOLLIS_ERR_WORKSPACE_TOO_SMALL, MOLLIS_ERR_NOT_PREPARED (pending merges that the workspace does not hold).
 */
mollis_status mollis_pks_step(const struct mollis_pks_particles *particles, struct mollis_pks_progress *progress,
    const struct mollis_pks_attraction *attraction, const struct mollis_generator *generator, double dt, size_t steps,
    struct mollis_pks_events *events, const struct mollis_pks_options *options, const struct mollis_run *run, void *workspace,
    size_t workspace_bytes, struct mollis_pks_report *report);
mollis_status mollis_pks_step_f32(const struct mollis_pks_particles_f32 *particles, struct mollis_pks_progress *progress,
    const struct mollis_pks_attraction *attraction, const struct mollis_generator *generator, double dt, size_t steps,
    struct mollis_pks_events *events, const struct mollis_pks_options *options, const struct mollis_run *run, void *workspace,
    size_t workspace_bytes, struct mollis_pks_report *report);

/**
 * Overwrites normals[i] with two independent standard normal numbers for the particle labels[i], i < n: what mollis_normals
 * makes of words 0 and 1 of mollis_philox_words, many particles at a time. The bits are the same on every machine.
 *
 * Refused: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP.
 */
mollis_status mollis_philox_normals(uint64_t seed, size_t n, const uint64_t *labels, uint32_t step, uint32_t substep,
    double (*normals)[2]);
mollis_status mollis_philox_normals_f32(uint64_t seed, size_t n, const uint64_t *labels, uint32_t step, uint32_t substep,
    float (*normals)[2]);

/**
 * Overwrites out[0 .. n] with independent standard normal numbers from uniform 64-bit words (Box & Muller 1958). `words` holds n
 * words, n + 1 if n is odd. The bits are the same on every machine; |out| <= 8.58.
 *
 * Refused: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE, MOLLIS_ERR_OVERLAP.
 */
mollis_status mollis_normals(size_t n, const uint64_t *words, double *out);
mollis_status mollis_normals_f32(size_t n, const uint64_t *words, float *out);

/** Fills `options` with the defaults. `size` is `sizeof *options`. */
mollis_status mollis_grid2_options_init(struct mollis_grid2_options *options, size_t size);

/** Fills `options` with the defaults. `size` is `sizeof *options`. */
mollis_status mollis_pks_options_init(struct mollis_pks_options *options, size_t size);

/**
 * Overwrites `out` with what is known of a mass: `second_moment` is the integral of |x|^2 rho about its centre, `heavy` the n_heavy masses that
 * have become points (their sum at most the mass). The rate of no mass is 0. MOLLIS_ERR_NOT_FINITE: some number is not.
 */
mollis_status mollis_pks_predict(double mass, double mu, double chi, double second_moment, size_t n_heavy, const double *heavy,
    struct mollis_pks_prediction *out);

/**
 * Overwrites index[0] with nu of (2.7), (4.30) for n particles of these masses, and index[1], index[2] with alpha and beta^2 of (2.4).
 *
 * gamma: the potential is gamma log r near zero, 1 / (2 pi) for the logarithmic and the screened one. Without mass alpha and beta^2 are 0.
 */
mollis_status mollis_pks_index(size_t n, const double *masses, double chi, double noise, double gamma, double *index);

/**
 * What represents n species by `particles` particles with one noise: overwrites share[i] with eta_i, the share of the particles that species i
 * gets, noise with mu~ for the step's options, and rate with the rate of the second moment of all species together (4.28), the integral of |x|^2 sum rho_i / chi_i. Each output may be null.
 *
 * From (4.25), mu_i = M eta_i chi_i mu / M_i.
 */
mollis_status mollis_pks_represent_species(size_t n, const struct mollis_pks_species *species, double chi, size_t particles,
    double *share, double *noise, double *rate);

/**
 * Overwrites out[0 .. n] with uniform 64-bit words of the built-in generator for the particle `label` at time step `step`,
 * sub-step `substep`.
 *
 * Words 0 and 1 are Philox4x32-10 (Salmon et al. 2011) with key = (low, high half of the seed) and counter = (low, high half of the
 * label, step, substep), its 32-bit results w0..w3 joined as w0 + 2^32 w1 and w2 + 2^32 w3. Later pairs b = 1, 2, ... have
 * the same counter and as key the first 64-bit word of label b, step = substep = 2^32 - 1 under the seed. No state.
 *
 * Refused: MOLLIS_ERR_NULL_POINTER, MOLLIS_ERR_MISALIGNED, MOLLIS_ERR_TOO_LARGE.
 */
mollis_status mollis_philox_words(uint64_t seed, uint64_t label, uint32_t step, uint32_t substep, size_t n, uint64_t *out);

/** Fills `run` with the defaults. `size` is `sizeof *run`. */
mollis_status mollis_run_init(struct mollis_run *run, size_t size);

/** A sentence that explains a status. Static text, never null; any value is accepted. */
const char *mollis_status_text(mollis_status status);

/** The version of the binary interface: it changes when a program built with an older header may break. */
uint32_t mollis_abi_version(void);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* MOLLIS_H */
