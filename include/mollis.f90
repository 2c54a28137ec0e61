! mollis: particles that interact through softened potentials.
!
! The rules and the documentation of every function are those of mollis.h. Here
! * constants and types have their names in C; members have defaults of 0 and null, which mean "not there";
! * mollis_... are the C functions. Pointers that may be null are optional arguments; arrays are what they are in C, so that
!   `double (*x)[2]` is `x(2, n)`;
! * without the prefix the same as subroutines, over both kinds of reals where their arguments tell them apart: sizes are
!   default integers, a prepared kernel or a workspace is an array of bytes, a text is a character variable, padded with blanks,
!   ..._init needs no size, and a status that nobody asks for stops the program where it is not MOLLIS_OK;
! * status_text(status) says what a status means;
! * mollis_at(x) is the address of the first element of a variable with the attribute target, of any type, for members of
!   structures.
!
! Made from include/mollis.h by `cargo xtask header`: do not edit.
module mollis
  use, intrinsic :: iso_c_binding
  implicit none
  public
  private :: tell, fill, address_of

  character(*), parameter :: MOLLIS_VERSION = '0.1.0'
  integer(c_int32_t), parameter :: MOLLIS_ABI_VERSION_HERE = 1
  integer(c_int32_t), parameter :: MOLLIS_OK = 0
  integer(c_int32_t), parameter :: MOLLIS_ERR_NULL_POINTER = 1
  integer(c_int32_t), parameter :: MOLLIS_ERR_MISALIGNED = 2
  integer(c_int32_t), parameter :: MOLLIS_ERR_WORKSPACE_TOO_SMALL = 3
  integer(c_int32_t), parameter :: MOLLIS_ERR_TOO_LARGE = 4
  integer(c_int32_t), parameter :: MOLLIS_ERR_LENGTH_MISMATCH = 5
  integer(c_int32_t), parameter :: MOLLIS_ERR_OVERLAP = 6
  integer(c_int32_t), parameter :: MOLLIS_ERR_NOT_PREPARED = 7
  integer(c_int32_t), parameter :: MOLLIS_ERR_WRONG_VERSION = 8
  integer(c_int32_t), parameter :: MOLLIS_ERR_WRONG_SCALAR = 9
  integer(c_int32_t), parameter :: MOLLIS_ERR_WRONG_BYTE_ORDER = 10
  integer(c_int32_t), parameter :: MOLLIS_ERR_OPTIONS_SIZE = 11
  integer(c_int32_t), parameter :: MOLLIS_ERR_NOT_INITIALISED = 12
  integer(c_int32_t), parameter :: MOLLIS_ERR_NOT_FINITE = 20
  integer(c_int32_t), parameter :: MOLLIS_ERR_DELTA = 21
  integer(c_int32_t), parameter :: MOLLIS_ERR_DIMENSION = 22
  integer(c_int32_t), parameter :: MOLLIS_ERR_EXPONENT = 23
  integer(c_int32_t), parameter :: MOLLIS_ERR_ORDER = 24
  integer(c_int32_t), parameter :: MOLLIS_ERR_UNKNOWN_VALUE = 25
  integer(c_int32_t), parameter :: MOLLIS_ERR_TIME_STEP = 26
  integer(c_int32_t), parameter :: MOLLIS_ERR_KERNEL_PARAMETER = 27
  integer(c_int32_t), parameter :: MOLLIS_ERR_KERNEL_TERMS = 28
  integer(c_int32_t), parameter :: MOLLIS_ERR_MASS = 29
  integer(c_int32_t), parameter :: MOLLIS_ERR_OUT_OF_DOMAIN = 30
  integer(c_int32_t), parameter :: MOLLIS_ERR_UNSUPPORTED = 31
  integer(c_int32_t), parameter :: MOLLIS_ERR_KERNEL_FIT = 32
  integer(c_int32_t), parameter :: MOLLIS_ERR_KERNEL_REACH = 33
  integer(c_int32_t), parameter :: MOLLIS_ERR_KERNEL_KNOTS = 34
  integer(c_int32_t), parameter :: MOLLIS_ERR_NO_ROOM = 35
  integer(c_int32_t), parameter :: MOLLIS_ERR_SIGN_CHANGE = 36
  integer(c_int32_t), parameter :: MOLLIS_ERR_BECAME_NOT_FINITE = 40
  integer(c_int32_t), parameter :: MOLLIS_ERR_STOPPED = 41
  integer(c_int32_t), parameter :: MOLLIS_ERR_EVENTS_FULL = 42
  integer(c_int32_t), parameter :: MOLLIS_ERR_TOO_MANY_SUBSTEPS = 43
  integer(c_int32_t), parameter :: MOLLIS_ERR_ENERGY_ROSE = 44
  integer(c_int32_t), parameter :: MOLLIS_ERR_GENERATOR = 45
  integer(c_int32_t), parameter :: MOLLIS_ERR_EXECUTOR = 46
  integer(c_int32_t), parameter :: MOLLIS_ERR_INTERNAL = 47
  integer(c_int32_t), parameter :: MOLLIS_ERR_NOT_CONVERGED = 48
  integer(c_int32_t), parameter :: MOLLIS_ERR_COMMUNICATOR = 49
  integer(c_int32_t), parameter :: MOLLIS_ALIGN = 64
  integer(c_int32_t), parameter :: MOLLIS_KERNEL2_NEWTONIAN_BYTES_F32 = 1216
  integer(c_int32_t), parameter :: MOLLIS_METHOD_AUTO = 0
  integer(c_int32_t), parameter :: MOLLIS_METHOD_DIRECT = 1
  integer(c_int32_t), parameter :: MOLLIS_METHOD_MOMENTS = 2
  integer(c_int32_t), parameter :: MOLLIS_METHOD_SORTED = 3
  integer(c_int32_t), parameter :: MOLLIS_METHOD_NEIGHBOURS = 4
  integer(c_int32_t), parameter :: MOLLIS_METHOD_SPLIT = 5
  integer(c_int32_t), parameter :: MOLLIS_METHOD_FMM = 6
  integer(c_int32_t), parameter :: MOLLIS_METHOD_TREE = 7
  integer(c_int32_t), parameter :: MOLLIS_ACCUMULATION_BLOCKED = 0
  integer(c_int32_t), parameter :: MOLLIS_ACCUMULATION_COMPENSATED = 1
  integer(c_int32_t), parameter :: MOLLIS_PAIR_RADIUS_SOURCE = 0
  integer(c_int32_t), parameter :: MOLLIS_PAIR_RADIUS_MAXIMUM = 1
  integer(c_int32_t), parameter :: MOLLIS_PAIR_RADIUS_MEAN = 2
  integer(c_int32_t), parameter :: MOLLIS_PAIR_RADIUS_RMS = 3
  integer(c_int64_t), parameter :: MOLLIS_NONE_BAD = -1_c_int64_t
  integer(c_int32_t), parameter :: MOLLIS_WALLS_FREE = 0
  integer(c_int32_t), parameter :: MOLLIS_WALLS_NO_FLUX = 1
  integer(c_int32_t), parameter :: MOLLIS_WALLS_FREE_QUADRUPOLE = 2
  integer(c_int32_t), parameter :: MOLLIS_KERNEL_NEWTONIAN = 0
  integer(c_int32_t), parameter :: MOLLIS_KERNEL_POWER = 1
  integer(c_int32_t), parameter :: MOLLIS_KERNEL_EXPONENTIAL = 2
  integer(c_int32_t), parameter :: MOLLIS_KERNEL_SCREENED = 3
  integer(c_int32_t), parameter :: MOLLIS_KERNEL_MAX_TERMS = 8
  integer(c_int32_t), parameter :: MOLLIS_KERNEL_MAX_KNOTS = 8
  integer(c_int32_t), parameter :: MOLLIS_MOLLIFIER_NONE = 0
  integer(c_int32_t), parameter :: MOLLIS_MOLLIFIER_COMPACT = 1
  integer(c_int32_t), parameter :: MOLLIS_MOLLIFIER_GAUSSIAN = 2
  integer(c_int32_t), parameter :: MOLLIS_MOLLIFIER_PLUMMER = 3
  integer(c_int32_t), parameter :: MOLLIS_MOLLIFIER_ALGEBRAIC = 4
  integer(c_int32_t), parameter :: MOLLIS_MOLLIFIER_VATISTAS = 5
  integer(c_int32_t), parameter :: MOLLIS_MOLLIFIER_RICHARDSON = 6
  integer(c_int32_t), parameter :: MOLLIS_PKS_LAW_EXACT = 0
  integer(c_int32_t), parameter :: MOLLIS_PKS_LAW_PRINTED = 1
  integer(c_int32_t), parameter :: MOLLIS_PKS_MERGE_ALL = 0
  integer(c_int32_t), parameter :: MOLLIS_PKS_MERGE_HARD = 1
  integer(c_int32_t), parameter :: MOLLIS_PKS_MERGE_NEVER = 2
  integer(c_int32_t), parameter :: MOLLIS_PKS_SCHEME_EULER_MARUYAMA = 0
  integer(c_int32_t), parameter :: MOLLIS_PKS_SCHEME_STRANG_RK4 = 1
  integer(c_int32_t), parameter :: MOLLIS_PKS_ATTRACTION_NONE = 0
  integer(c_int32_t), parameter :: MOLLIS_PKS_ATTRACTION_MESH = 1
  integer(c_int32_t), parameter :: MOLLIS_PKS_ATTRACTION_SUM = 2
  integer(c_int32_t), parameter :: MOLLIS_LEVEL_BEST = -1
  integer(c_int32_t), parameter :: MOLLIS_LEVEL_PORTABLE = 0
  integer(c_int32_t), parameter :: MOLLIS_LEVEL_NEON = 1
  integer(c_int32_t), parameter :: MOLLIS_LEVEL_AVX2 = 2
  integer(c_int32_t), parameter :: MOLLIS_LEVEL_AVX512 = 3
  integer(c_int32_t), parameter :: MOLLIS_REDUCE_SUM = 0
  integer(c_int32_t), parameter :: MOLLIS_REDUCE_MAX = 1

  type, bind(c) :: mollis_mollifier
    integer(c_int32_t) :: kind = 0
    integer(c_int32_t) :: order = 0
    integer(c_int32_t) :: exponent = 0
  end type

  type, bind(c) :: mollis_blob_options
    integer(c_int32_t) :: size = 0
    integer(c_int32_t) :: watch_energy = 0
    real(c_double) :: tolerance = 0
    type(c_funptr) :: after_step = c_null_funptr
    type(c_ptr) :: context = c_null_ptr
    real(c_double) :: combination(2) = 0
    real(c_double) :: diffusion = 0
    real(c_double) :: diffusion_exponent = 0
    type(mollis_mollifier) :: diffusion_mollifier
    real(c_double) :: diffusion_length = 0
  end type

  type, bind(c) :: mollis_field_options
    integer(c_int32_t) :: size = 0
    integer(c_int32_t) :: method = 0
    integer(c_int32_t) :: accumulation = 0
    integer(c_int32_t) :: pair_radius = 0
    real(c_double) :: combination(2) = 0
    real(c_double) :: tolerance = 0
  end type

  type, bind(c) :: mollis_particles2
    integer(c_size_t) :: n = 0
    type(c_ptr) :: positions(2) = c_null_ptr
    integer(c_size_t) :: stride = 0
    type(c_ptr) :: masses = c_null_ptr
    integer(c_size_t) :: mass_stride = 0
    type(c_ptr) :: density = c_null_ptr
    integer(c_size_t) :: density_stride = 0
    type(c_ptr) :: velocity(2) = c_null_ptr
    integer(c_size_t) :: velocity_stride = 0
    type(c_ptr) :: divergence = c_null_ptr
    integer(c_size_t) :: divergence_stride = 0
  end type

  type, bind(c) :: mollis_executor
    type(c_ptr) :: context = c_null_ptr
    integer(c_size_t) :: workers = 0
    type(c_funptr) :: parallel_for = c_null_funptr
  end type

  type, bind(c) :: mollis_communicator
    type(c_ptr) :: context = c_null_ptr
    integer(c_size_t) :: rank = 0
    integer(c_size_t) :: ranks = 0
    type(c_funptr) :: reduce = c_null_funptr
    type(c_funptr) :: exchange = c_null_funptr
  end type

  type, bind(c) :: mollis_run
    integer(c_int32_t) :: size = 0
    integer(c_int32_t) :: level = 0
    type(c_ptr) :: executor = c_null_ptr
    type(c_funptr) :: should_stop = c_null_funptr
    type(c_ptr) :: stop_context = c_null_ptr
    type(c_ptr) :: first_bad = c_null_ptr
    type(c_ptr) :: bytes_needed = c_null_ptr
    type(c_ptr) :: communicator = c_null_ptr
  end type

  type, bind(c) :: mollis_particles2_f32
    integer(c_size_t) :: n = 0
    type(c_ptr) :: positions(2) = c_null_ptr
    integer(c_size_t) :: stride = 0
    type(c_ptr) :: masses = c_null_ptr
    integer(c_size_t) :: mass_stride = 0
    type(c_ptr) :: density = c_null_ptr
    integer(c_size_t) :: density_stride = 0
    type(c_ptr) :: velocity(2) = c_null_ptr
    integer(c_size_t) :: velocity_stride = 0
    type(c_ptr) :: divergence = c_null_ptr
    integer(c_size_t) :: divergence_stride = 0
  end type

  type, bind(c) :: mollis_particles1
    integer(c_size_t) :: n = 0
    type(c_ptr) :: positions(1) = c_null_ptr
    integer(c_size_t) :: stride = 0
    type(c_ptr) :: masses = c_null_ptr
    integer(c_size_t) :: mass_stride = 0
    type(c_ptr) :: density = c_null_ptr
    integer(c_size_t) :: density_stride = 0
    type(c_ptr) :: velocity(1) = c_null_ptr
    integer(c_size_t) :: velocity_stride = 0
    type(c_ptr) :: divergence = c_null_ptr
    integer(c_size_t) :: divergence_stride = 0
  end type

  type, bind(c) :: mollis_particles1_f32
    integer(c_size_t) :: n = 0
    type(c_ptr) :: positions(1) = c_null_ptr
    integer(c_size_t) :: stride = 0
    type(c_ptr) :: masses = c_null_ptr
    integer(c_size_t) :: mass_stride = 0
    type(c_ptr) :: density = c_null_ptr
    integer(c_size_t) :: density_stride = 0
    type(c_ptr) :: velocity(1) = c_null_ptr
    integer(c_size_t) :: velocity_stride = 0
    type(c_ptr) :: divergence = c_null_ptr
    integer(c_size_t) :: divergence_stride = 0
  end type

  type, bind(c) :: mollis_particles3
    integer(c_size_t) :: n = 0
    type(c_ptr) :: positions(3) = c_null_ptr
    integer(c_size_t) :: stride = 0
    type(c_ptr) :: masses = c_null_ptr
    integer(c_size_t) :: mass_stride = 0
    type(c_ptr) :: density = c_null_ptr
    integer(c_size_t) :: density_stride = 0
    type(c_ptr) :: velocity(3) = c_null_ptr
    integer(c_size_t) :: velocity_stride = 0
    type(c_ptr) :: divergence = c_null_ptr
    integer(c_size_t) :: divergence_stride = 0
  end type

  type, bind(c) :: mollis_particles3_f32
    integer(c_size_t) :: n = 0
    type(c_ptr) :: positions(3) = c_null_ptr
    integer(c_size_t) :: stride = 0
    type(c_ptr) :: masses = c_null_ptr
    integer(c_size_t) :: mass_stride = 0
    type(c_ptr) :: density = c_null_ptr
    integer(c_size_t) :: density_stride = 0
    type(c_ptr) :: velocity(3) = c_null_ptr
    integer(c_size_t) :: velocity_stride = 0
    type(c_ptr) :: divergence = c_null_ptr
    integer(c_size_t) :: divergence_stride = 0
  end type

  type, bind(c) :: mollis_blob_report
    integer(c_int64_t) :: steps = 0
    integer(c_int64_t) :: first_bad = 0
    real(c_double) :: energy_first = 0
    real(c_double) :: energy_last = 0
  end type

  type, bind(c) :: mollis_sources2
    integer(c_size_t) :: n = 0
    type(c_ptr) :: positions(2) = c_null_ptr
    integer(c_size_t) :: stride = 0
    type(c_ptr) :: masses = c_null_ptr
    integer(c_size_t) :: mass_stride = 0
    type(c_ptr) :: radii = c_null_ptr
    integer(c_size_t) :: radius_stride = 0
    type(c_ptr) :: strengths(2) = c_null_ptr
    integer(c_size_t) :: strength_stride = 0
  end type

  type, bind(c) :: mollis_targets2
    integer(c_size_t) :: n = 0
    type(c_ptr) :: positions(2) = c_null_ptr
    integer(c_size_t) :: stride = 0
    type(c_ptr) :: radii = c_null_ptr
    integer(c_size_t) :: radius_stride = 0
  end type

  type, bind(c) :: mollis_outputs2
    type(c_ptr) :: potential = c_null_ptr
    integer(c_size_t) :: potential_stride = 0
    type(c_ptr) :: gradient(2) = c_null_ptr
    integer(c_size_t) :: gradient_stride = 0
    type(c_ptr) :: laplacian = c_null_ptr
    integer(c_size_t) :: laplacian_stride = 0
    type(c_ptr) :: hessian = c_null_ptr
    integer(c_size_t) :: hessian_stride = 0
    real(c_double) :: factor = 0
    integer(c_int32_t) :: add = 0
    integer(c_int32_t) :: reserved = 0
  end type

  type, bind(c) :: mollis_sources2_f32
    integer(c_size_t) :: n = 0
    type(c_ptr) :: positions(2) = c_null_ptr
    integer(c_size_t) :: stride = 0
    type(c_ptr) :: masses = c_null_ptr
    integer(c_size_t) :: mass_stride = 0
    type(c_ptr) :: radii = c_null_ptr
    integer(c_size_t) :: radius_stride = 0
    type(c_ptr) :: strengths(2) = c_null_ptr
    integer(c_size_t) :: strength_stride = 0
  end type

  type, bind(c) :: mollis_targets2_f32
    integer(c_size_t) :: n = 0
    type(c_ptr) :: positions(2) = c_null_ptr
    integer(c_size_t) :: stride = 0
    type(c_ptr) :: radii = c_null_ptr
    integer(c_size_t) :: radius_stride = 0
  end type

  type, bind(c) :: mollis_outputs2_f32
    type(c_ptr) :: potential = c_null_ptr
    integer(c_size_t) :: potential_stride = 0
    type(c_ptr) :: gradient(2) = c_null_ptr
    integer(c_size_t) :: gradient_stride = 0
    type(c_ptr) :: laplacian = c_null_ptr
    integer(c_size_t) :: laplacian_stride = 0
    type(c_ptr) :: hessian = c_null_ptr
    integer(c_size_t) :: hessian_stride = 0
    real(c_double) :: factor = 0
    integer(c_int32_t) :: add = 0
    integer(c_int32_t) :: reserved = 0
  end type

  type, bind(c) :: mollis_sources1
    integer(c_size_t) :: n = 0
    type(c_ptr) :: positions(1) = c_null_ptr
    integer(c_size_t) :: stride = 0
    type(c_ptr) :: masses = c_null_ptr
    integer(c_size_t) :: mass_stride = 0
    type(c_ptr) :: radii = c_null_ptr
    integer(c_size_t) :: radius_stride = 0
    type(c_ptr) :: strengths(1) = c_null_ptr
    integer(c_size_t) :: strength_stride = 0
  end type

  type, bind(c) :: mollis_targets1
    integer(c_size_t) :: n = 0
    type(c_ptr) :: positions(1) = c_null_ptr
    integer(c_size_t) :: stride = 0
    type(c_ptr) :: radii = c_null_ptr
    integer(c_size_t) :: radius_stride = 0
  end type

  type, bind(c) :: mollis_outputs1
    type(c_ptr) :: potential = c_null_ptr
    integer(c_size_t) :: potential_stride = 0
    type(c_ptr) :: gradient(1) = c_null_ptr
    integer(c_size_t) :: gradient_stride = 0
    type(c_ptr) :: laplacian = c_null_ptr
    integer(c_size_t) :: laplacian_stride = 0
    type(c_ptr) :: hessian = c_null_ptr
    integer(c_size_t) :: hessian_stride = 0
    real(c_double) :: factor = 0
    integer(c_int32_t) :: add = 0
    integer(c_int32_t) :: reserved = 0
  end type

  type, bind(c) :: mollis_sources1_f32
    integer(c_size_t) :: n = 0
    type(c_ptr) :: positions(1) = c_null_ptr
    integer(c_size_t) :: stride = 0
    type(c_ptr) :: masses = c_null_ptr
    integer(c_size_t) :: mass_stride = 0
    type(c_ptr) :: radii = c_null_ptr
    integer(c_size_t) :: radius_stride = 0
    type(c_ptr) :: strengths(1) = c_null_ptr
    integer(c_size_t) :: strength_stride = 0
  end type

  type, bind(c) :: mollis_targets1_f32
    integer(c_size_t) :: n = 0
    type(c_ptr) :: positions(1) = c_null_ptr
    integer(c_size_t) :: stride = 0
    type(c_ptr) :: radii = c_null_ptr
    integer(c_size_t) :: radius_stride = 0
  end type

  type, bind(c) :: mollis_outputs1_f32
    type(c_ptr) :: potential = c_null_ptr
    integer(c_size_t) :: potential_stride = 0
    type(c_ptr) :: gradient(1) = c_null_ptr
    integer(c_size_t) :: gradient_stride = 0
    type(c_ptr) :: laplacian = c_null_ptr
    integer(c_size_t) :: laplacian_stride = 0
    type(c_ptr) :: hessian = c_null_ptr
    integer(c_size_t) :: hessian_stride = 0
    real(c_double) :: factor = 0
    integer(c_int32_t) :: add = 0
    integer(c_int32_t) :: reserved = 0
  end type

  type, bind(c) :: mollis_sources3
    integer(c_size_t) :: n = 0
    type(c_ptr) :: positions(3) = c_null_ptr
    integer(c_size_t) :: stride = 0
    type(c_ptr) :: masses = c_null_ptr
    integer(c_size_t) :: mass_stride = 0
    type(c_ptr) :: radii = c_null_ptr
    integer(c_size_t) :: radius_stride = 0
    type(c_ptr) :: strengths(3) = c_null_ptr
    integer(c_size_t) :: strength_stride = 0
  end type

  type, bind(c) :: mollis_targets3
    integer(c_size_t) :: n = 0
    type(c_ptr) :: positions(3) = c_null_ptr
    integer(c_size_t) :: stride = 0
    type(c_ptr) :: radii = c_null_ptr
    integer(c_size_t) :: radius_stride = 0
  end type

  type, bind(c) :: mollis_outputs3
    type(c_ptr) :: potential = c_null_ptr
    integer(c_size_t) :: potential_stride = 0
    type(c_ptr) :: gradient(3) = c_null_ptr
    integer(c_size_t) :: gradient_stride = 0
    type(c_ptr) :: laplacian = c_null_ptr
    integer(c_size_t) :: laplacian_stride = 0
    type(c_ptr) :: hessian = c_null_ptr
    integer(c_size_t) :: hessian_stride = 0
    real(c_double) :: factor = 0
    integer(c_int32_t) :: add = 0
    integer(c_int32_t) :: reserved = 0
  end type

  type, bind(c) :: mollis_sources3_f32
    integer(c_size_t) :: n = 0
    type(c_ptr) :: positions(3) = c_null_ptr
    integer(c_size_t) :: stride = 0
    type(c_ptr) :: masses = c_null_ptr
    integer(c_size_t) :: mass_stride = 0
    type(c_ptr) :: radii = c_null_ptr
    integer(c_size_t) :: radius_stride = 0
    type(c_ptr) :: strengths(3) = c_null_ptr
    integer(c_size_t) :: strength_stride = 0
  end type

  type, bind(c) :: mollis_targets3_f32
    integer(c_size_t) :: n = 0
    type(c_ptr) :: positions(3) = c_null_ptr
    integer(c_size_t) :: stride = 0
    type(c_ptr) :: radii = c_null_ptr
    integer(c_size_t) :: radius_stride = 0
  end type

  type, bind(c) :: mollis_outputs3_f32
    type(c_ptr) :: potential = c_null_ptr
    integer(c_size_t) :: potential_stride = 0
    type(c_ptr) :: gradient(3) = c_null_ptr
    integer(c_size_t) :: gradient_stride = 0
    type(c_ptr) :: laplacian = c_null_ptr
    integer(c_size_t) :: laplacian_stride = 0
    type(c_ptr) :: hessian = c_null_ptr
    integer(c_size_t) :: hessian_stride = 0
    real(c_double) :: factor = 0
    integer(c_int32_t) :: add = 0
    integer(c_int32_t) :: reserved = 0
  end type

  type, bind(c) :: mollis_field_counts
    integer(c_int64_t) :: pairs = 0
    integer(c_int64_t) :: near_pairs = 0
    integer(c_int64_t) :: polynomial_blocks = 0
    integer(c_int64_t) :: all_near_blocks = 0
    integer(c_int64_t) :: scaled_pairs = 0
    integer(c_int64_t) :: massless_sources = 0
    integer(c_int64_t) :: beyond_reach = 0
  end type

  type, bind(c) :: mollis_mesh2
    real(c_double) :: lower(2) = 0
    real(c_double) :: upper(2) = 0
    integer(c_size_t) :: cells(2) = 0
  end type

  type, bind(c) :: mollis_grid2_outputs
    type(c_ptr) :: gradient(2) = c_null_ptr
    integer(c_size_t) :: gradient_stride = 0
    type(c_ptr) :: node_mass = c_null_ptr
    type(c_ptr) :: node_potential = c_null_ptr
    type(c_ptr) :: node_gradient = c_null_ptr
    type(c_ptr) :: total = c_null_ptr
    type(c_ptr) :: outside = c_null_ptr
  end type

  type, bind(c) :: mollis_medium2
    type(c_ptr) :: diffusivity = c_null_ptr
    type(c_ptr) :: decay = c_null_ptr
    real(c_double) :: tolerance = 0
    integer(c_int64_t) :: iterations = 0
    type(c_ptr) :: report = c_null_ptr
  end type

  type, bind(c) :: mollis_parabolic2
    real(c_double) :: time_scale = 0
    real(c_double) :: time = 0
    type(c_ptr) :: attractant = c_null_ptr
  end type

  type, bind(c) :: mollis_grid2_options
    integer(c_int32_t) :: size = 0
    integer(c_int32_t) :: walls = 0
    real(c_double) :: screening = 0
    integer(c_int32_t) :: order = 0
    integer(c_int32_t) :: reserved = 0
    type(c_ptr) :: medium = c_null_ptr
    type(c_ptr) :: parabolic = c_null_ptr
  end type

  type, bind(c) :: mollis_grid2_outputs_f32
    type(c_ptr) :: gradient(2) = c_null_ptr
    integer(c_size_t) :: gradient_stride = 0
    type(c_ptr) :: node_mass = c_null_ptr
    type(c_ptr) :: node_potential = c_null_ptr
    type(c_ptr) :: node_gradient = c_null_ptr
    type(c_ptr) :: total = c_null_ptr
    type(c_ptr) :: outside = c_null_ptr
  end type

  type, bind(c) :: mollis_kernel_term
    integer(c_int32_t) :: kind = 0
    integer(c_int32_t) :: reserved = 0
    real(c_double) :: coefficient = 0
    real(c_double) :: parameter(2) = 0
  end type

  type, bind(c) :: mollis_radial_kernel
    type(c_ptr) :: context = c_null_ptr
    type(c_funptr) :: evaluate = c_null_funptr
    real(c_double) :: coefficient = 0
    real(c_double) :: reach = 0
    real(c_double) :: tolerance = 0
    real(c_double) :: least = 0
    integer(c_size_t) :: n_knots = 0
    type(c_ptr) :: knots = c_null_ptr
    type(c_ptr) :: errors = c_null_ptr
  end type

  type, bind(c) :: mollis_pks_attraction
    integer(c_int32_t) :: kind = 0
    integer(c_int32_t) :: reserved = 0
    type(c_ptr) :: mesh = c_null_ptr
    type(c_ptr) :: grid = c_null_ptr
    type(c_ptr) :: kernel = c_null_ptr
    integer(c_size_t) :: kernel_bytes = 0
    real(c_double) :: tolerance = 0
    real(c_double) :: heavy = 0
  end type

  type, bind(c) :: mollis_pks_options
    integer(c_int32_t) :: size = 0
    integer(c_int32_t) :: law = 0
    integer(c_int32_t) :: merging = 0
    integer(c_int32_t) :: scheme = 0
    real(c_double) :: chi = 0
    real(c_double) :: noise = 0
    real(c_double) :: gamma = 0
    real(c_double) :: separation = 0
    real(c_double) :: probability = 0
    real(c_double) :: width = 0
    integer(c_int32_t) :: at_least = 0
    integer(c_int32_t) :: at_most = 0
    integer(c_int32_t) :: mesh(2) = 0
    real(c_double) :: domain(4) = 0
    integer(c_int32_t) :: shifted = 0
    integer(c_int32_t) :: reserved = 0
    integer(c_int64_t) :: seed = 0
  end type

  type, bind(c) :: mollis_pks_particles
    integer(c_size_t) :: room = 0
    type(c_ptr) :: positions = c_null_ptr
    type(c_ptr) :: masses = c_null_ptr
    type(c_ptr) :: labels = c_null_ptr
    type(c_ptr) :: species = c_null_ptr
    type(c_ptr) :: weights = c_null_ptr
  end type

  type, bind(c) :: mollis_pks_progress
    real(c_double) :: time = 0
    integer(c_int64_t) :: step = 0
    integer(c_int64_t) :: count = 0
    integer(c_int64_t) :: pending = 0
  end type

  type, bind(c) :: mollis_generator
    type(c_ptr) :: state = c_null_ptr
    type(c_funptr) :: fill = c_null_funptr
  end type

  type, bind(c) :: mollis_pks_event
    real(c_double) :: time = 0
    integer(c_int64_t) :: label = 0
    real(c_double) :: mass = 0
    real(c_double) :: index = 0
    integer(c_int64_t) :: first = 0
    integer(c_int64_t) :: absorbed = 0
  end type

  type, bind(c) :: mollis_pks_events
    type(c_ptr) :: events = c_null_ptr
    integer(c_size_t) :: room = 0
    integer(c_size_t) :: written = 0
    type(c_ptr) :: labels = c_null_ptr
    integer(c_size_t) :: labels_room = 0
    integer(c_size_t) :: labels_written = 0
  end type

  type, bind(c) :: mollis_pks_report
    integer(c_int64_t) :: substeps = 0
    integer(c_int64_t) :: normals = 0
    integer(c_int64_t) :: fields = 0
    integer(c_int64_t) :: searches = 0
    integer(c_int64_t) :: clusters = 0
    integer(c_int64_t) :: merges = 0
    integer(c_int64_t) :: absorbed = 0
  end type

  type, bind(c) :: mollis_pks_particles_f32
    integer(c_size_t) :: room = 0
    type(c_ptr) :: positions = c_null_ptr
    type(c_ptr) :: masses = c_null_ptr
    type(c_ptr) :: labels = c_null_ptr
    type(c_ptr) :: species = c_null_ptr
    type(c_ptr) :: weights = c_null_ptr
  end type

  type, bind(c) :: mollis_pks_prediction
    real(c_double) :: critical_mass = 0
    real(c_double) :: blow_up_bound = 0
    real(c_double) :: second_moment_rate = 0
  end type

  type, bind(c) :: mollis_pks_species
    real(c_double) :: mass = 0
    real(c_double) :: mu = 0
    real(c_double) :: sensitivity = 0
  end type

  interface
    function mollis_blob_options_init(options, size) bind(c) result(answer)
      import
      type(mollis_blob_options), intent(inout), target :: options
      integer(c_size_t), value :: size
      integer(c_int32_t) :: answer
    end function
    function mollis_field_options_init(options, size) bind(c) result(answer)
      import
      type(mollis_field_options), intent(inout), target :: options
      integer(c_size_t), value :: size
      integer(c_int32_t) :: answer
    end function
    function mollis_blob2_workspace_bytes(kernel, kernel_bytes, particles, tracers, options, run, bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_particles2), intent(in), target :: particles
      type(mollis_particles2), intent(in), target, optional :: tracers
      type(mollis_blob_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_blob2_workspace_bytes_f32(kernel, kernel_bytes, particles, tracers, options, run, &
        bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_particles2_f32), intent(in), target :: particles
      type(mollis_particles2_f32), intent(in), target, optional :: tracers
      type(mollis_blob_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_blob1_workspace_bytes(kernel, kernel_bytes, particles, tracers, options, run, bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_particles1), intent(in), target :: particles
      type(mollis_particles1), intent(in), target, optional :: tracers
      type(mollis_blob_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_blob1_workspace_bytes_f32(kernel, kernel_bytes, particles, tracers, options, run, &
        bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_particles1_f32), intent(in), target :: particles
      type(mollis_particles1_f32), intent(in), target, optional :: tracers
      type(mollis_blob_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_blob3_workspace_bytes(kernel, kernel_bytes, particles, tracers, options, run, bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_particles3), intent(in), target :: particles
      type(mollis_particles3), intent(in), target, optional :: tracers
      type(mollis_blob_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_blob3_workspace_bytes_f32(kernel, kernel_bytes, particles, tracers, options, run, &
        bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_particles3_f32), intent(in), target :: particles
      type(mollis_particles3_f32), intent(in), target, optional :: tracers
      type(mollis_blob_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_blob2_step(kernel, kernel_bytes, particles, tracers, dt, steps, options, run, workspace, workspace_bytes, &
        report) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_particles2), intent(in), target :: particles
      type(mollis_particles2), intent(in), target, optional :: tracers
      real(c_double), value :: dt
      integer(c_size_t), value :: steps
      type(mollis_blob_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      type(mollis_blob_report), intent(inout), target, optional :: report
      integer(c_int32_t) :: answer
    end function
    function mollis_blob2_step_f32(kernel, kernel_bytes, particles, tracers, dt, steps, options, run, workspace, workspace_bytes, &
        report) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_particles2_f32), intent(in), target :: particles
      type(mollis_particles2_f32), intent(in), target, optional :: tracers
      real(c_double), value :: dt
      integer(c_size_t), value :: steps
      type(mollis_blob_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      type(mollis_blob_report), intent(inout), target, optional :: report
      integer(c_int32_t) :: answer
    end function
    function mollis_blob1_step(kernel, kernel_bytes, particles, tracers, dt, steps, options, run, workspace, workspace_bytes, &
        report) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_particles1), intent(in), target :: particles
      type(mollis_particles1), intent(in), target, optional :: tracers
      real(c_double), value :: dt
      integer(c_size_t), value :: steps
      type(mollis_blob_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      type(mollis_blob_report), intent(inout), target, optional :: report
      integer(c_int32_t) :: answer
    end function
    function mollis_blob1_step_f32(kernel, kernel_bytes, particles, tracers, dt, steps, options, run, workspace, workspace_bytes, &
        report) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_particles1_f32), intent(in), target :: particles
      type(mollis_particles1_f32), intent(in), target, optional :: tracers
      real(c_double), value :: dt
      integer(c_size_t), value :: steps
      type(mollis_blob_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      type(mollis_blob_report), intent(inout), target, optional :: report
      integer(c_int32_t) :: answer
    end function
    function mollis_blob3_step(kernel, kernel_bytes, particles, tracers, dt, steps, options, run, workspace, workspace_bytes, &
        report) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_particles3), intent(in), target :: particles
      type(mollis_particles3), intent(in), target, optional :: tracers
      real(c_double), value :: dt
      integer(c_size_t), value :: steps
      type(mollis_blob_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      type(mollis_blob_report), intent(inout), target, optional :: report
      integer(c_int32_t) :: answer
    end function
    function mollis_blob3_step_f32(kernel, kernel_bytes, particles, tracers, dt, steps, options, run, workspace, workspace_bytes, &
        report) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_particles3_f32), intent(in), target :: particles
      type(mollis_particles3_f32), intent(in), target, optional :: tracers
      real(c_double), value :: dt
      integer(c_size_t), value :: steps
      type(mollis_blob_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      type(mollis_blob_report), intent(inout), target, optional :: report
      integer(c_int32_t) :: answer
    end function
    function mollis_moments2(n, positions, masses, mass, absolute_mass, centre, second) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: positions(2,*)
      real(c_double), intent(in) :: masses(*)
      real(c_double), intent(inout), optional :: mass
      real(c_double), intent(inout), optional :: absolute_mass
      real(c_double), intent(inout), optional :: centre(2)
      real(c_double), intent(inout), optional :: second
      integer(c_int32_t) :: answer
    end function
    function mollis_moments2_f32(n, positions, masses, mass, absolute_mass, centre, second) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: positions(2,*)
      real(c_float), intent(in) :: masses(*)
      real(c_float), intent(inout), optional :: mass
      real(c_float), intent(inout), optional :: absolute_mass
      real(c_float), intent(inout), optional :: centre(2)
      real(c_float), intent(inout), optional :: second
      integer(c_int32_t) :: answer
    end function
    function mollis_moments1(n, positions, masses, mass, absolute_mass, centre, second) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: positions(1,*)
      real(c_double), intent(in) :: masses(*)
      real(c_double), intent(inout), optional :: mass
      real(c_double), intent(inout), optional :: absolute_mass
      real(c_double), intent(inout), optional :: centre(1)
      real(c_double), intent(inout), optional :: second
      integer(c_int32_t) :: answer
    end function
    function mollis_moments1_f32(n, positions, masses, mass, absolute_mass, centre, second) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: positions(1,*)
      real(c_float), intent(in) :: masses(*)
      real(c_float), intent(inout), optional :: mass
      real(c_float), intent(inout), optional :: absolute_mass
      real(c_float), intent(inout), optional :: centre(1)
      real(c_float), intent(inout), optional :: second
      integer(c_int32_t) :: answer
    end function
    function mollis_moments3(n, positions, masses, mass, absolute_mass, centre, second) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: positions(3,*)
      real(c_double), intent(in) :: masses(*)
      real(c_double), intent(inout), optional :: mass
      real(c_double), intent(inout), optional :: absolute_mass
      real(c_double), intent(inout), optional :: centre(3)
      real(c_double), intent(inout), optional :: second
      integer(c_int32_t) :: answer
    end function
    function mollis_moments3_f32(n, positions, masses, mass, absolute_mass, centre, second) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: positions(3,*)
      real(c_float), intent(in) :: masses(*)
      real(c_float), intent(inout), optional :: mass
      real(c_float), intent(inout), optional :: absolute_mass
      real(c_float), intent(inout), optional :: centre(3)
      real(c_float), intent(inout), optional :: second
      integer(c_int32_t) :: answer
    end function
    function mollis_stable_step2(kernel, kernel_bytes, n, positions, masses, step) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: positions(2,*)
      real(c_double), intent(in) :: masses(*)
      real(c_double), intent(inout), optional :: step
      integer(c_int32_t) :: answer
    end function
    function mollis_stable_step2_f32(kernel, kernel_bytes, n, positions, masses, step) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: positions(2,*)
      real(c_float), intent(in) :: masses(*)
      real(c_float), intent(inout), optional :: step
      integer(c_int32_t) :: answer
    end function
    function mollis_stable_step1(kernel, kernel_bytes, n, positions, masses, step) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: positions(1,*)
      real(c_double), intent(in) :: masses(*)
      real(c_double), intent(inout), optional :: step
      integer(c_int32_t) :: answer
    end function
    function mollis_stable_step1_f32(kernel, kernel_bytes, n, positions, masses, step) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: positions(1,*)
      real(c_float), intent(in) :: masses(*)
      real(c_float), intent(inout), optional :: step
      integer(c_int32_t) :: answer
    end function
    function mollis_stable_step3(kernel, kernel_bytes, n, positions, masses, step) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: positions(3,*)
      real(c_double), intent(in) :: masses(*)
      real(c_double), intent(inout), optional :: step
      integer(c_int32_t) :: answer
    end function
    function mollis_stable_step3_f32(kernel, kernel_bytes, n, positions, masses, step) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: positions(3,*)
      real(c_float), intent(in) :: masses(*)
      real(c_float), intent(inout), optional :: step
      integer(c_int32_t) :: answer
    end function
    function mollis_stable_step2_anywhere(kernel, kernel_bytes, absolute_mass, diameter, step) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      real(c_double), value :: absolute_mass
      real(c_double), value :: diameter
      real(c_double), intent(inout), optional :: step
      integer(c_int32_t) :: answer
    end function
    function mollis_stable_step2_anywhere_f32(kernel, kernel_bytes, absolute_mass, diameter, step) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      real(c_float), value :: absolute_mass
      real(c_float), value :: diameter
      real(c_float), intent(inout), optional :: step
      integer(c_int32_t) :: answer
    end function
    function mollis_stable_step1_anywhere(kernel, kernel_bytes, absolute_mass, diameter, step) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      real(c_double), value :: absolute_mass
      real(c_double), value :: diameter
      real(c_double), intent(inout), optional :: step
      integer(c_int32_t) :: answer
    end function
    function mollis_stable_step1_anywhere_f32(kernel, kernel_bytes, absolute_mass, diameter, step) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      real(c_float), value :: absolute_mass
      real(c_float), value :: diameter
      real(c_float), intent(inout), optional :: step
      integer(c_int32_t) :: answer
    end function
    function mollis_stable_step3_anywhere(kernel, kernel_bytes, absolute_mass, diameter, step) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      real(c_double), value :: absolute_mass
      real(c_double), value :: diameter
      real(c_double), intent(inout), optional :: step
      integer(c_int32_t) :: answer
    end function
    function mollis_stable_step3_anywhere_f32(kernel, kernel_bytes, absolute_mass, diameter, step) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      real(c_float), value :: absolute_mass
      real(c_float), value :: diameter
      real(c_float), intent(inout), optional :: step
      integer(c_int32_t) :: answer
    end function
    function mollis_overlap2(n, delta, masses, densities, smallest) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_double), value :: delta
      real(c_double), intent(in) :: masses(*)
      real(c_double), intent(in) :: densities(*)
      real(c_double), intent(inout), optional :: smallest
      integer(c_int32_t) :: answer
    end function
    function mollis_overlap2_f32(n, delta, masses, densities, smallest) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_float), value :: delta
      real(c_float), intent(in) :: masses(*)
      real(c_float), intent(in) :: densities(*)
      real(c_float), intent(inout), optional :: smallest
      integer(c_int32_t) :: answer
    end function
    function mollis_overlap1(n, delta, masses, densities, smallest) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_double), value :: delta
      real(c_double), intent(in) :: masses(*)
      real(c_double), intent(in) :: densities(*)
      real(c_double), intent(inout), optional :: smallest
      integer(c_int32_t) :: answer
    end function
    function mollis_overlap1_f32(n, delta, masses, densities, smallest) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_float), value :: delta
      real(c_float), intent(in) :: masses(*)
      real(c_float), intent(in) :: densities(*)
      real(c_float), intent(inout), optional :: smallest
      integer(c_int32_t) :: answer
    end function
    function mollis_overlap3(n, delta, masses, densities, smallest) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_double), value :: delta
      real(c_double), intent(in) :: masses(*)
      real(c_double), intent(in) :: densities(*)
      real(c_double), intent(inout), optional :: smallest
      integer(c_int32_t) :: answer
    end function
    function mollis_overlap3_f32(n, delta, masses, densities, smallest) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_float), value :: delta
      real(c_float), intent(in) :: masses(*)
      real(c_float), intent(in) :: densities(*)
      real(c_float), intent(inout), optional :: smallest
      integer(c_int32_t) :: answer
    end function
    function mollis_field2_workspace_bytes(kernel, kernel_bytes, sources, targets, outputs, options, run, &
        bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources2), intent(in), target :: sources
      type(mollis_targets2), intent(in), target, optional :: targets
      type(mollis_outputs2), intent(in), target :: outputs
      type(mollis_field_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_field2_workspace_bytes_f32(kernel, kernel_bytes, sources, targets, outputs, options, run, &
        bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources2_f32), intent(in), target :: sources
      type(mollis_targets2_f32), intent(in), target, optional :: targets
      type(mollis_outputs2_f32), intent(in), target :: outputs
      type(mollis_field_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_field1_workspace_bytes(kernel, kernel_bytes, sources, targets, outputs, options, run, &
        bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources1), intent(in), target :: sources
      type(mollis_targets1), intent(in), target, optional :: targets
      type(mollis_outputs1), intent(in), target :: outputs
      type(mollis_field_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_field1_workspace_bytes_f32(kernel, kernel_bytes, sources, targets, outputs, options, run, &
        bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources1_f32), intent(in), target :: sources
      type(mollis_targets1_f32), intent(in), target, optional :: targets
      type(mollis_outputs1_f32), intent(in), target :: outputs
      type(mollis_field_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_field3_workspace_bytes(kernel, kernel_bytes, sources, targets, outputs, options, run, &
        bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources3), intent(in), target :: sources
      type(mollis_targets3), intent(in), target, optional :: targets
      type(mollis_outputs3), intent(in), target :: outputs
      type(mollis_field_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_field3_workspace_bytes_f32(kernel, kernel_bytes, sources, targets, outputs, options, run, &
        bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources3_f32), intent(in), target :: sources
      type(mollis_targets3_f32), intent(in), target, optional :: targets
      type(mollis_outputs3_f32), intent(in), target :: outputs
      type(mollis_field_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_field2_text(kernel, kernel_bytes, sources, targets, outputs, options, text, text_bytes, &
        length) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources2), intent(in), target :: sources
      type(mollis_targets2), intent(in), target, optional :: targets
      type(mollis_outputs2), intent(in), target :: outputs
      type(mollis_field_options), intent(in), target, optional :: options
      character(kind=c_char), intent(inout), optional :: text(*)
      integer(c_size_t), value :: text_bytes
      integer(c_size_t), intent(inout), optional :: length
      integer(c_int32_t) :: answer
    end function
    function mollis_field2_text_f32(kernel, kernel_bytes, sources, targets, outputs, options, text, text_bytes, &
        length) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources2_f32), intent(in), target :: sources
      type(mollis_targets2_f32), intent(in), target, optional :: targets
      type(mollis_outputs2_f32), intent(in), target :: outputs
      type(mollis_field_options), intent(in), target, optional :: options
      character(kind=c_char), intent(inout), optional :: text(*)
      integer(c_size_t), value :: text_bytes
      integer(c_size_t), intent(inout), optional :: length
      integer(c_int32_t) :: answer
    end function
    function mollis_field1_text(kernel, kernel_bytes, sources, targets, outputs, options, text, text_bytes, &
        length) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources1), intent(in), target :: sources
      type(mollis_targets1), intent(in), target, optional :: targets
      type(mollis_outputs1), intent(in), target :: outputs
      type(mollis_field_options), intent(in), target, optional :: options
      character(kind=c_char), intent(inout), optional :: text(*)
      integer(c_size_t), value :: text_bytes
      integer(c_size_t), intent(inout), optional :: length
      integer(c_int32_t) :: answer
    end function
    function mollis_field1_text_f32(kernel, kernel_bytes, sources, targets, outputs, options, text, text_bytes, &
        length) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources1_f32), intent(in), target :: sources
      type(mollis_targets1_f32), intent(in), target, optional :: targets
      type(mollis_outputs1_f32), intent(in), target :: outputs
      type(mollis_field_options), intent(in), target, optional :: options
      character(kind=c_char), intent(inout), optional :: text(*)
      integer(c_size_t), value :: text_bytes
      integer(c_size_t), intent(inout), optional :: length
      integer(c_int32_t) :: answer
    end function
    function mollis_field3_text(kernel, kernel_bytes, sources, targets, outputs, options, text, text_bytes, &
        length) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources3), intent(in), target :: sources
      type(mollis_targets3), intent(in), target, optional :: targets
      type(mollis_outputs3), intent(in), target :: outputs
      type(mollis_field_options), intent(in), target, optional :: options
      character(kind=c_char), intent(inout), optional :: text(*)
      integer(c_size_t), value :: text_bytes
      integer(c_size_t), intent(inout), optional :: length
      integer(c_int32_t) :: answer
    end function
    function mollis_field3_text_f32(kernel, kernel_bytes, sources, targets, outputs, options, text, text_bytes, &
        length) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources3_f32), intent(in), target :: sources
      type(mollis_targets3_f32), intent(in), target, optional :: targets
      type(mollis_outputs3_f32), intent(in), target :: outputs
      type(mollis_field_options), intent(in), target, optional :: options
      character(kind=c_char), intent(inout), optional :: text(*)
      integer(c_size_t), value :: text_bytes
      integer(c_size_t), intent(inout), optional :: length
      integer(c_int32_t) :: answer
    end function
    function mollis_field2_eval(kernel, kernel_bytes, sources, targets, outputs, options, run, workspace, workspace_bytes, &
        counters) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources2), intent(in), target :: sources
      type(mollis_targets2), intent(in), target, optional :: targets
      type(mollis_outputs2), intent(in), target :: outputs
      type(mollis_field_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      type(mollis_field_counts), intent(inout), target, optional :: counters
      integer(c_int32_t) :: answer
    end function
    function mollis_field2_eval_f32(kernel, kernel_bytes, sources, targets, outputs, options, run, workspace, workspace_bytes, &
        counters) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources2_f32), intent(in), target :: sources
      type(mollis_targets2_f32), intent(in), target, optional :: targets
      type(mollis_outputs2_f32), intent(in), target :: outputs
      type(mollis_field_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      type(mollis_field_counts), intent(inout), target, optional :: counters
      integer(c_int32_t) :: answer
    end function
    function mollis_field1_eval(kernel, kernel_bytes, sources, targets, outputs, options, run, workspace, workspace_bytes, &
        counters) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources1), intent(in), target :: sources
      type(mollis_targets1), intent(in), target, optional :: targets
      type(mollis_outputs1), intent(in), target :: outputs
      type(mollis_field_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      type(mollis_field_counts), intent(inout), target, optional :: counters
      integer(c_int32_t) :: answer
    end function
    function mollis_field1_eval_f32(kernel, kernel_bytes, sources, targets, outputs, options, run, workspace, workspace_bytes, &
        counters) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources1_f32), intent(in), target :: sources
      type(mollis_targets1_f32), intent(in), target, optional :: targets
      type(mollis_outputs1_f32), intent(in), target :: outputs
      type(mollis_field_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      type(mollis_field_counts), intent(inout), target, optional :: counters
      integer(c_int32_t) :: answer
    end function
    function mollis_field3_eval(kernel, kernel_bytes, sources, targets, outputs, options, run, workspace, workspace_bytes, &
        counters) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources3), intent(in), target :: sources
      type(mollis_targets3), intent(in), target, optional :: targets
      type(mollis_outputs3), intent(in), target :: outputs
      type(mollis_field_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      type(mollis_field_counts), intent(inout), target, optional :: counters
      integer(c_int32_t) :: answer
    end function
    function mollis_field3_eval_f32(kernel, kernel_bytes, sources, targets, outputs, options, run, workspace, workspace_bytes, &
        counters) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources3_f32), intent(in), target :: sources
      type(mollis_targets3_f32), intent(in), target, optional :: targets
      type(mollis_outputs3_f32), intent(in), target :: outputs
      type(mollis_field_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      type(mollis_field_counts), intent(inout), target, optional :: counters
      integer(c_int32_t) :: answer
    end function
    function mollis_field2_essential_bytes(kernel, kernel_bytes, sources, tolerance, bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources2), intent(in), target :: sources
      real(c_double), value :: tolerance
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_field2_essential_bytes_f32(kernel, kernel_bytes, sources, tolerance, bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources2_f32), intent(in), target :: sources
      real(c_double), value :: tolerance
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_field1_essential_bytes(kernel, kernel_bytes, sources, tolerance, bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources1), intent(in), target :: sources
      real(c_double), value :: tolerance
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_field1_essential_bytes_f32(kernel, kernel_bytes, sources, tolerance, bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources1_f32), intent(in), target :: sources
      real(c_double), value :: tolerance
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_field3_essential_bytes(kernel, kernel_bytes, sources, tolerance, bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources3), intent(in), target :: sources
      real(c_double), value :: tolerance
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_field3_essential_bytes_f32(kernel, kernel_bytes, sources, tolerance, bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources3_f32), intent(in), target :: sources
      real(c_double), value :: tolerance
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_field2_essential(kernel, kernel_bytes, sources, tolerance, n_boxes, boxes, starts, room, positions, masses, &
        origins, run, workspace, workspace_bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources2), intent(in), target :: sources
      real(c_double), value :: tolerance
      integer(c_size_t), value :: n_boxes
      real(c_double), intent(in) :: boxes(2,2,*)
      integer(c_int64_t), intent(inout), optional :: starts(*)
      integer(c_size_t), value :: room
      real(c_double), intent(inout), optional :: positions(2,*)
      real(c_double), intent(inout), optional :: masses(*)
      integer(c_int64_t), intent(inout), optional :: origins(*)
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_field2_essential_f32(kernel, kernel_bytes, sources, tolerance, n_boxes, boxes, starts, room, positions, &
        masses, origins, run, workspace, workspace_bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources2_f32), intent(in), target :: sources
      real(c_double), value :: tolerance
      integer(c_size_t), value :: n_boxes
      real(c_float), intent(in) :: boxes(2,2,*)
      integer(c_int64_t), intent(inout), optional :: starts(*)
      integer(c_size_t), value :: room
      real(c_float), intent(inout), optional :: positions(2,*)
      real(c_float), intent(inout), optional :: masses(*)
      integer(c_int64_t), intent(inout), optional :: origins(*)
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_field1_essential(kernel, kernel_bytes, sources, tolerance, n_boxes, boxes, starts, room, positions, masses, &
        origins, run, workspace, workspace_bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources1), intent(in), target :: sources
      real(c_double), value :: tolerance
      integer(c_size_t), value :: n_boxes
      real(c_double), intent(in) :: boxes(1,2,*)
      integer(c_int64_t), intent(inout), optional :: starts(*)
      integer(c_size_t), value :: room
      real(c_double), intent(inout), optional :: positions(1,*)
      real(c_double), intent(inout), optional :: masses(*)
      integer(c_int64_t), intent(inout), optional :: origins(*)
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_field1_essential_f32(kernel, kernel_bytes, sources, tolerance, n_boxes, boxes, starts, room, positions, &
        masses, origins, run, workspace, workspace_bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources1_f32), intent(in), target :: sources
      real(c_double), value :: tolerance
      integer(c_size_t), value :: n_boxes
      real(c_float), intent(in) :: boxes(1,2,*)
      integer(c_int64_t), intent(inout), optional :: starts(*)
      integer(c_size_t), value :: room
      real(c_float), intent(inout), optional :: positions(1,*)
      real(c_float), intent(inout), optional :: masses(*)
      integer(c_int64_t), intent(inout), optional :: origins(*)
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_field3_essential(kernel, kernel_bytes, sources, tolerance, n_boxes, boxes, starts, room, positions, masses, &
        origins, run, workspace, workspace_bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources3), intent(in), target :: sources
      real(c_double), value :: tolerance
      integer(c_size_t), value :: n_boxes
      real(c_double), intent(in) :: boxes(3,2,*)
      integer(c_int64_t), intent(inout), optional :: starts(*)
      integer(c_size_t), value :: room
      real(c_double), intent(inout), optional :: positions(3,*)
      real(c_double), intent(inout), optional :: masses(*)
      integer(c_int64_t), intent(inout), optional :: origins(*)
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_field3_essential_f32(kernel, kernel_bytes, sources, tolerance, n_boxes, boxes, starts, room, positions, &
        masses, origins, run, workspace, workspace_bytes) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: kernel_bytes
      type(mollis_sources3_f32), intent(in), target :: sources
      real(c_double), value :: tolerance
      integer(c_size_t), value :: n_boxes
      real(c_float), intent(in) :: boxes(3,2,*)
      integer(c_int64_t), intent(inout), optional :: starts(*)
      integer(c_size_t), value :: room
      real(c_float), intent(inout), optional :: positions(3,*)
      real(c_float), intent(inout), optional :: masses(*)
      integer(c_int64_t), intent(inout), optional :: origins(*)
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_grid2_workspace_bytes(mesh, sources, targets, outputs, options, run, bytes) bind(c) result(answer)
      import
      type(mollis_mesh2), intent(in), target :: mesh
      type(mollis_sources2), intent(in), target :: sources
      type(mollis_targets2), intent(in), target, optional :: targets
      type(mollis_grid2_outputs), intent(in), target :: outputs
      type(mollis_grid2_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_grid2_workspace_bytes_f32(mesh, sources, targets, outputs, options, run, bytes) bind(c) result(answer)
      import
      type(mollis_mesh2), intent(in), target :: mesh
      type(mollis_sources2_f32), intent(in), target :: sources
      type(mollis_targets2_f32), intent(in), target, optional :: targets
      type(mollis_grid2_outputs_f32), intent(in), target :: outputs
      type(mollis_grid2_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_grid2_eval(mesh, sources, targets, outputs, options, run, workspace, workspace_bytes) bind(c) result(answer)
      import
      type(mollis_mesh2), intent(in), target :: mesh
      type(mollis_sources2), intent(in), target :: sources
      type(mollis_targets2), intent(in), target, optional :: targets
      type(mollis_grid2_outputs), intent(in), target :: outputs
      type(mollis_grid2_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_grid2_eval_f32(mesh, sources, targets, outputs, options, run, workspace, &
        workspace_bytes) bind(c) result(answer)
      import
      type(mollis_mesh2), intent(in), target :: mesh
      type(mollis_sources2_f32), intent(in), target :: sources
      type(mollis_targets2_f32), intent(in), target, optional :: targets
      type(mollis_grid2_outputs_f32), intent(in), target :: outputs
      type(mollis_grid2_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_kernel2_bytes(terms, n_terms, own, mollifier, bytes) bind(c) result(answer)
      import
      type(mollis_kernel_term), intent(in), target :: terms(*)
      integer(c_size_t), value :: n_terms
      type(mollis_radial_kernel), intent(in), target, optional :: own
      type(mollis_mollifier), value :: mollifier
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_kernel2_bytes_f32(terms, n_terms, own, mollifier, bytes) bind(c) result(answer)
      import
      type(mollis_kernel_term), intent(in), target :: terms(*)
      integer(c_size_t), value :: n_terms
      type(mollis_radial_kernel), intent(in), target, optional :: own
      type(mollis_mollifier), value :: mollifier
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_kernel1_bytes(terms, n_terms, own, mollifier, bytes) bind(c) result(answer)
      import
      type(mollis_kernel_term), intent(in), target :: terms(*)
      integer(c_size_t), value :: n_terms
      type(mollis_radial_kernel), intent(in), target, optional :: own
      type(mollis_mollifier), value :: mollifier
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_kernel1_bytes_f32(terms, n_terms, own, mollifier, bytes) bind(c) result(answer)
      import
      type(mollis_kernel_term), intent(in), target :: terms(*)
      integer(c_size_t), value :: n_terms
      type(mollis_radial_kernel), intent(in), target, optional :: own
      type(mollis_mollifier), value :: mollifier
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_kernel3_bytes(terms, n_terms, own, mollifier, bytes) bind(c) result(answer)
      import
      type(mollis_kernel_term), intent(in), target :: terms(*)
      integer(c_size_t), value :: n_terms
      type(mollis_radial_kernel), intent(in), target, optional :: own
      type(mollis_mollifier), value :: mollifier
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_kernel3_bytes_f32(terms, n_terms, own, mollifier, bytes) bind(c) result(answer)
      import
      type(mollis_kernel_term), intent(in), target :: terms(*)
      integer(c_size_t), value :: n_terms
      type(mollis_radial_kernel), intent(in), target, optional :: own
      type(mollis_mollifier), value :: mollifier
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_kernel2_prepare(kernel, bytes, terms, n_terms, own, mollifier, delta) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: bytes
      type(mollis_kernel_term), intent(in), target :: terms(*)
      integer(c_size_t), value :: n_terms
      type(mollis_radial_kernel), intent(in), target, optional :: own
      type(mollis_mollifier), value :: mollifier
      real(c_double), value :: delta
      integer(c_int32_t) :: answer
    end function
    function mollis_kernel2_prepare_f32(kernel, bytes, terms, n_terms, own, mollifier, delta) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: bytes
      type(mollis_kernel_term), intent(in), target :: terms(*)
      integer(c_size_t), value :: n_terms
      type(mollis_radial_kernel), intent(in), target, optional :: own
      type(mollis_mollifier), value :: mollifier
      real(c_float), value :: delta
      integer(c_int32_t) :: answer
    end function
    function mollis_kernel1_prepare(kernel, bytes, terms, n_terms, own, mollifier, delta) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: bytes
      type(mollis_kernel_term), intent(in), target :: terms(*)
      integer(c_size_t), value :: n_terms
      type(mollis_radial_kernel), intent(in), target, optional :: own
      type(mollis_mollifier), value :: mollifier
      real(c_double), value :: delta
      integer(c_int32_t) :: answer
    end function
    function mollis_kernel1_prepare_f32(kernel, bytes, terms, n_terms, own, mollifier, delta) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: bytes
      type(mollis_kernel_term), intent(in), target :: terms(*)
      integer(c_size_t), value :: n_terms
      type(mollis_radial_kernel), intent(in), target, optional :: own
      type(mollis_mollifier), value :: mollifier
      real(c_float), value :: delta
      integer(c_int32_t) :: answer
    end function
    function mollis_kernel3_prepare(kernel, bytes, terms, n_terms, own, mollifier, delta) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: bytes
      type(mollis_kernel_term), intent(in), target :: terms(*)
      integer(c_size_t), value :: n_terms
      type(mollis_radial_kernel), intent(in), target, optional :: own
      type(mollis_mollifier), value :: mollifier
      real(c_double), value :: delta
      integer(c_int32_t) :: answer
    end function
    function mollis_kernel3_prepare_f32(kernel, bytes, terms, n_terms, own, mollifier, delta) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: bytes
      type(mollis_kernel_term), intent(in), target :: terms(*)
      integer(c_size_t), value :: n_terms
      type(mollis_radial_kernel), intent(in), target, optional :: own
      type(mollis_mollifier), value :: mollifier
      real(c_float), value :: delta
      integer(c_int32_t) :: answer
    end function
    function mollis_kernel2_eval(kernel, bytes, n, r, value, gradient_factor, laplacian) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: bytes
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: r(*)
      real(c_double), intent(inout), optional :: value(*)
      real(c_double), intent(inout), optional :: gradient_factor(*)
      real(c_double), intent(inout), optional :: laplacian(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_kernel2_eval_f32(kernel, bytes, n, r, value, gradient_factor, laplacian) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: bytes
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: r(*)
      real(c_float), intent(inout), optional :: value(*)
      real(c_float), intent(inout), optional :: gradient_factor(*)
      real(c_float), intent(inout), optional :: laplacian(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_kernel1_eval(kernel, bytes, n, r, value, gradient_factor, laplacian) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: bytes
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: r(*)
      real(c_double), intent(inout), optional :: value(*)
      real(c_double), intent(inout), optional :: gradient_factor(*)
      real(c_double), intent(inout), optional :: laplacian(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_kernel1_eval_f32(kernel, bytes, n, r, value, gradient_factor, laplacian) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: bytes
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: r(*)
      real(c_float), intent(inout), optional :: value(*)
      real(c_float), intent(inout), optional :: gradient_factor(*)
      real(c_float), intent(inout), optional :: laplacian(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_kernel3_eval(kernel, bytes, n, r, value, gradient_factor, laplacian) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: bytes
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: r(*)
      real(c_double), intent(inout), optional :: value(*)
      real(c_double), intent(inout), optional :: gradient_factor(*)
      real(c_double), intent(inout), optional :: laplacian(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_kernel3_eval_f32(kernel, bytes, n, r, value, gradient_factor, laplacian) bind(c) result(answer)
      import
      type(c_ptr), value :: kernel
      integer(c_size_t), value :: bytes
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: r(*)
      real(c_float), intent(inout), optional :: value(*)
      real(c_float), intent(inout), optional :: gradient_factor(*)
      real(c_float), intent(inout), optional :: laplacian(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier2_eval(mollifier, delta, n, r, density, density_slope, potential, gradient_factor, hessian_factor, &
        enclosed_mass) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_double), value :: delta
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: r(*)
      real(c_double), intent(inout), optional :: density(*)
      real(c_double), intent(inout), optional :: density_slope(*)
      real(c_double), intent(inout), optional :: potential(*)
      real(c_double), intent(inout), optional :: gradient_factor(*)
      real(c_double), intent(inout), optional :: hessian_factor(*)
      real(c_double), intent(inout), optional :: enclosed_mass(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier2_eval_f32(mollifier, delta, n, r, density, density_slope, potential, gradient_factor, &
        hessian_factor, enclosed_mass) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_float), value :: delta
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: r(*)
      real(c_float), intent(inout), optional :: density(*)
      real(c_float), intent(inout), optional :: density_slope(*)
      real(c_float), intent(inout), optional :: potential(*)
      real(c_float), intent(inout), optional :: gradient_factor(*)
      real(c_float), intent(inout), optional :: hessian_factor(*)
      real(c_float), intent(inout), optional :: enclosed_mass(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier1_eval(mollifier, delta, n, r, density, density_slope, potential, gradient_factor, hessian_factor, &
        enclosed_mass) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_double), value :: delta
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: r(*)
      real(c_double), intent(inout), optional :: density(*)
      real(c_double), intent(inout), optional :: density_slope(*)
      real(c_double), intent(inout), optional :: potential(*)
      real(c_double), intent(inout), optional :: gradient_factor(*)
      real(c_double), intent(inout), optional :: hessian_factor(*)
      real(c_double), intent(inout), optional :: enclosed_mass(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier1_eval_f32(mollifier, delta, n, r, density, density_slope, potential, gradient_factor, &
        hessian_factor, enclosed_mass) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_float), value :: delta
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: r(*)
      real(c_float), intent(inout), optional :: density(*)
      real(c_float), intent(inout), optional :: density_slope(*)
      real(c_float), intent(inout), optional :: potential(*)
      real(c_float), intent(inout), optional :: gradient_factor(*)
      real(c_float), intent(inout), optional :: hessian_factor(*)
      real(c_float), intent(inout), optional :: enclosed_mass(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier3_eval(mollifier, delta, n, r, density, density_slope, potential, gradient_factor, hessian_factor, &
        enclosed_mass) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_double), value :: delta
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: r(*)
      real(c_double), intent(inout), optional :: density(*)
      real(c_double), intent(inout), optional :: density_slope(*)
      real(c_double), intent(inout), optional :: potential(*)
      real(c_double), intent(inout), optional :: gradient_factor(*)
      real(c_double), intent(inout), optional :: hessian_factor(*)
      real(c_double), intent(inout), optional :: enclosed_mass(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier3_eval_f32(mollifier, delta, n, r, density, density_slope, potential, gradient_factor, &
        hessian_factor, enclosed_mass) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_float), value :: delta
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: r(*)
      real(c_float), intent(inout), optional :: density(*)
      real(c_float), intent(inout), optional :: density_slope(*)
      real(c_float), intent(inout), optional :: potential(*)
      real(c_float), intent(inout), optional :: gradient_factor(*)
      real(c_float), intent(inout), optional :: hessian_factor(*)
      real(c_float), intent(inout), optional :: enclosed_mass(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier1_heaviside(mollifier, delta, n, x, values) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_double), value :: delta
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: x(*)
      real(c_double), intent(inout), optional :: values(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier1_heaviside_f32(mollifier, delta, n, x, values) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_float), value :: delta
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: x(*)
      real(c_float), intent(inout), optional :: values(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier2_moment(mollifier, delta, k, value) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_double), value :: delta
      integer(c_int32_t), value :: k
      real(c_double), intent(inout), optional :: value(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier2_moment_f32(mollifier, delta, k, value) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_float), value :: delta
      integer(c_int32_t), value :: k
      real(c_float), intent(inout), optional :: value(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier1_moment(mollifier, delta, k, value) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_double), value :: delta
      integer(c_int32_t), value :: k
      real(c_double), intent(inout), optional :: value(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier1_moment_f32(mollifier, delta, k, value) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_float), value :: delta
      integer(c_int32_t), value :: k
      real(c_float), intent(inout), optional :: value(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier3_moment(mollifier, delta, k, value) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_double), value :: delta
      integer(c_int32_t), value :: k
      real(c_double), intent(inout), optional :: value(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier3_moment_f32(mollifier, delta, k, value) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_float), value :: delta
      integer(c_int32_t), value :: k
      real(c_float), intent(inout), optional :: value(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier2_field(mollifier, delta, n, x, density, potential, gradient, hessian) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_double), value :: delta
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: x(2,*)
      real(c_double), intent(inout), optional :: density(*)
      real(c_double), intent(inout), optional :: potential(*)
      real(c_double), intent(inout), optional :: gradient(2,*)
      real(c_double), intent(inout), optional :: hessian(2,2,*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier2_field_f32(mollifier, delta, n, x, density, potential, gradient, hessian) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_float), value :: delta
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: x(2,*)
      real(c_float), intent(inout), optional :: density(*)
      real(c_float), intent(inout), optional :: potential(*)
      real(c_float), intent(inout), optional :: gradient(2,*)
      real(c_float), intent(inout), optional :: hessian(2,2,*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier1_field(mollifier, delta, n, x, density, potential, gradient, hessian) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_double), value :: delta
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: x(1,*)
      real(c_double), intent(inout), optional :: density(*)
      real(c_double), intent(inout), optional :: potential(*)
      real(c_double), intent(inout), optional :: gradient(1,*)
      real(c_double), intent(inout), optional :: hessian(1,1,*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier1_field_f32(mollifier, delta, n, x, density, potential, gradient, hessian) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_float), value :: delta
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: x(1,*)
      real(c_float), intent(inout), optional :: density(*)
      real(c_float), intent(inout), optional :: potential(*)
      real(c_float), intent(inout), optional :: gradient(1,*)
      real(c_float), intent(inout), optional :: hessian(1,1,*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier3_field(mollifier, delta, n, x, density, potential, gradient, hessian) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_double), value :: delta
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: x(3,*)
      real(c_double), intent(inout), optional :: density(*)
      real(c_double), intent(inout), optional :: potential(*)
      real(c_double), intent(inout), optional :: gradient(3,*)
      real(c_double), intent(inout), optional :: hessian(3,3,*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier3_field_f32(mollifier, delta, n, x, density, potential, gradient, hessian) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_float), value :: delta
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: x(3,*)
      real(c_float), intent(inout), optional :: density(*)
      real(c_float), intent(inout), optional :: potential(*)
      real(c_float), intent(inout), optional :: gradient(3,*)
      real(c_float), intent(inout), optional :: hessian(3,3,*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier2_richardson(mollifier, delta, n_radii, radii, weights, n, r, density, density_slope, potential, &
        gradient_factor, hessian_factor, enclosed_mass) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_double), value :: delta
      integer(c_size_t), value :: n_radii
      real(c_double), intent(in) :: radii(*)
      real(c_double), intent(inout), optional :: weights(*)
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: r(*)
      real(c_double), intent(inout), optional :: density(*)
      real(c_double), intent(inout), optional :: density_slope(*)
      real(c_double), intent(inout), optional :: potential(*)
      real(c_double), intent(inout), optional :: gradient_factor(*)
      real(c_double), intent(inout), optional :: hessian_factor(*)
      real(c_double), intent(inout), optional :: enclosed_mass(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier2_richardson_f32(mollifier, delta, n_radii, radii, weights, n, r, density, density_slope, potential, &
        gradient_factor, hessian_factor, enclosed_mass) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_float), value :: delta
      integer(c_size_t), value :: n_radii
      real(c_float), intent(in) :: radii(*)
      real(c_float), intent(inout), optional :: weights(*)
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: r(*)
      real(c_float), intent(inout), optional :: density(*)
      real(c_float), intent(inout), optional :: density_slope(*)
      real(c_float), intent(inout), optional :: potential(*)
      real(c_float), intent(inout), optional :: gradient_factor(*)
      real(c_float), intent(inout), optional :: hessian_factor(*)
      real(c_float), intent(inout), optional :: enclosed_mass(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier1_richardson(mollifier, delta, n_radii, radii, weights, n, r, density, density_slope, potential, &
        gradient_factor, hessian_factor, enclosed_mass) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_double), value :: delta
      integer(c_size_t), value :: n_radii
      real(c_double), intent(in) :: radii(*)
      real(c_double), intent(inout), optional :: weights(*)
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: r(*)
      real(c_double), intent(inout), optional :: density(*)
      real(c_double), intent(inout), optional :: density_slope(*)
      real(c_double), intent(inout), optional :: potential(*)
      real(c_double), intent(inout), optional :: gradient_factor(*)
      real(c_double), intent(inout), optional :: hessian_factor(*)
      real(c_double), intent(inout), optional :: enclosed_mass(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier1_richardson_f32(mollifier, delta, n_radii, radii, weights, n, r, density, density_slope, potential, &
        gradient_factor, hessian_factor, enclosed_mass) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_float), value :: delta
      integer(c_size_t), value :: n_radii
      real(c_float), intent(in) :: radii(*)
      real(c_float), intent(inout), optional :: weights(*)
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: r(*)
      real(c_float), intent(inout), optional :: density(*)
      real(c_float), intent(inout), optional :: density_slope(*)
      real(c_float), intent(inout), optional :: potential(*)
      real(c_float), intent(inout), optional :: gradient_factor(*)
      real(c_float), intent(inout), optional :: hessian_factor(*)
      real(c_float), intent(inout), optional :: enclosed_mass(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier3_richardson(mollifier, delta, n_radii, radii, weights, n, r, density, density_slope, potential, &
        gradient_factor, hessian_factor, enclosed_mass) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_double), value :: delta
      integer(c_size_t), value :: n_radii
      real(c_double), intent(in) :: radii(*)
      real(c_double), intent(inout), optional :: weights(*)
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: r(*)
      real(c_double), intent(inout), optional :: density(*)
      real(c_double), intent(inout), optional :: density_slope(*)
      real(c_double), intent(inout), optional :: potential(*)
      real(c_double), intent(inout), optional :: gradient_factor(*)
      real(c_double), intent(inout), optional :: hessian_factor(*)
      real(c_double), intent(inout), optional :: enclosed_mass(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_mollifier3_richardson_f32(mollifier, delta, n_radii, radii, weights, n, r, density, density_slope, potential, &
        gradient_factor, hessian_factor, enclosed_mass) bind(c) result(answer)
      import
      type(mollis_mollifier), value :: mollifier
      real(c_float), value :: delta
      integer(c_size_t), value :: n_radii
      real(c_float), intent(in) :: radii(*)
      real(c_float), intent(inout), optional :: weights(*)
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: r(*)
      real(c_float), intent(inout), optional :: density(*)
      real(c_float), intent(inout), optional :: density_slope(*)
      real(c_float), intent(inout), optional :: potential(*)
      real(c_float), intent(inout), optional :: gradient_factor(*)
      real(c_float), intent(inout), optional :: hessian_factor(*)
      real(c_float), intent(inout), optional :: enclosed_mass(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_norm(n, values, cell, p, norm) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: values(*)
      real(c_double), value :: cell
      real(c_double), value :: p
      real(c_double), intent(inout), optional :: norm
      integer(c_int32_t) :: answer
    end function
    function mollis_norm_f32(n, values, cell, p, norm) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: values(*)
      real(c_float), value :: cell
      real(c_float), value :: p
      real(c_float), intent(inout), optional :: norm
      integer(c_int32_t) :: answer
    end function
    function mollis_distance_norm2(n, a, b, cell, p, norm) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: a(2,*)
      real(c_double), intent(in) :: b(2,*)
      real(c_double), value :: cell
      real(c_double), value :: p
      real(c_double), intent(inout), optional :: norm
      integer(c_int32_t) :: answer
    end function
    function mollis_distance_norm2_f32(n, a, b, cell, p, norm) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: a(2,*)
      real(c_float), intent(in) :: b(2,*)
      real(c_float), value :: cell
      real(c_float), value :: p
      real(c_float), intent(inout), optional :: norm
      integer(c_int32_t) :: answer
    end function
    function mollis_distance_norm1(n, a, b, cell, p, norm) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: a(1,*)
      real(c_double), intent(in) :: b(1,*)
      real(c_double), value :: cell
      real(c_double), value :: p
      real(c_double), intent(inout), optional :: norm
      integer(c_int32_t) :: answer
    end function
    function mollis_distance_norm1_f32(n, a, b, cell, p, norm) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: a(1,*)
      real(c_float), intent(in) :: b(1,*)
      real(c_float), value :: cell
      real(c_float), value :: p
      real(c_float), intent(inout), optional :: norm
      integer(c_int32_t) :: answer
    end function
    function mollis_distance_norm3(n, a, b, cell, p, norm) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: a(3,*)
      real(c_double), intent(in) :: b(3,*)
      real(c_double), value :: cell
      real(c_double), value :: p
      real(c_double), intent(inout), optional :: norm
      integer(c_int32_t) :: answer
    end function
    function mollis_distance_norm3_f32(n, a, b, cell, p, norm) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_float), intent(in) :: a(3,*)
      real(c_float), intent(in) :: b(3,*)
      real(c_float), value :: cell
      real(c_float), value :: p
      real(c_float), intent(inout), optional :: norm
      integer(c_int32_t) :: answer
    end function
    function mollis_sobolev_norm2(points, spacing, p, values, norm) bind(c) result(answer)
      import
      integer(c_size_t), intent(in) :: points(2)
      real(c_double), value :: spacing
      real(c_double), value :: p
      real(c_double), intent(in) :: values(*)
      real(c_double), intent(inout), optional :: norm
      integer(c_int32_t) :: answer
    end function
    function mollis_sobolev_norm2_f32(points, spacing, p, values, norm) bind(c) result(answer)
      import
      integer(c_size_t), intent(in) :: points(2)
      real(c_float), value :: spacing
      real(c_float), value :: p
      real(c_float), intent(in) :: values(*)
      real(c_float), intent(inout), optional :: norm
      integer(c_int32_t) :: answer
    end function
    function mollis_sobolev_norm1(points, spacing, p, values, norm) bind(c) result(answer)
      import
      integer(c_size_t), intent(in) :: points(1)
      real(c_double), value :: spacing
      real(c_double), value :: p
      real(c_double), intent(in) :: values(*)
      real(c_double), intent(inout), optional :: norm
      integer(c_int32_t) :: answer
    end function
    function mollis_sobolev_norm1_f32(points, spacing, p, values, norm) bind(c) result(answer)
      import
      integer(c_size_t), intent(in) :: points(1)
      real(c_float), value :: spacing
      real(c_float), value :: p
      real(c_float), intent(in) :: values(*)
      real(c_float), intent(inout), optional :: norm
      integer(c_int32_t) :: answer
    end function
    function mollis_sobolev_norm3(points, spacing, p, values, norm) bind(c) result(answer)
      import
      integer(c_size_t), intent(in) :: points(3)
      real(c_double), value :: spacing
      real(c_double), value :: p
      real(c_double), intent(in) :: values(*)
      real(c_double), intent(inout), optional :: norm
      integer(c_int32_t) :: answer
    end function
    function mollis_sobolev_norm3_f32(points, spacing, p, values, norm) bind(c) result(answer)
      import
      integer(c_size_t), intent(in) :: points(3)
      real(c_float), value :: spacing
      real(c_float), value :: p
      real(c_float), intent(in) :: values(*)
      real(c_float), intent(inout), optional :: norm
      integer(c_int32_t) :: answer
    end function
    function mollis_dual_norm2_workspace_bytes(points, margin, bytes) bind(c) result(answer)
      import
      integer(c_size_t), intent(in) :: points(2)
      integer(c_size_t), value :: margin
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_dual_norm2_workspace_bytes_f32(points, margin, bytes) bind(c) result(answer)
      import
      integer(c_size_t), intent(in) :: points(2)
      integer(c_size_t), value :: margin
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_dual_norm1_workspace_bytes(points, margin, bytes) bind(c) result(answer)
      import
      integer(c_size_t), intent(in) :: points(1)
      integer(c_size_t), value :: margin
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_dual_norm1_workspace_bytes_f32(points, margin, bytes) bind(c) result(answer)
      import
      integer(c_size_t), intent(in) :: points(1)
      integer(c_size_t), value :: margin
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_dual_norm3_workspace_bytes(points, margin, bytes) bind(c) result(answer)
      import
      integer(c_size_t), intent(in) :: points(3)
      integer(c_size_t), value :: margin
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_dual_norm3_workspace_bytes_f32(points, margin, bytes) bind(c) result(answer)
      import
      integer(c_size_t), intent(in) :: points(3)
      integer(c_size_t), value :: margin
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_dual_norm2(points, spacing, margin, values, norm, workspace, workspace_bytes) bind(c) result(answer)
      import
      integer(c_size_t), intent(in) :: points(2)
      real(c_double), value :: spacing
      integer(c_size_t), value :: margin
      real(c_double), intent(in) :: values(*)
      real(c_double), intent(inout), optional :: norm
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_dual_norm2_f32(points, spacing, margin, values, norm, workspace, workspace_bytes) bind(c) result(answer)
      import
      integer(c_size_t), intent(in) :: points(2)
      real(c_float), value :: spacing
      integer(c_size_t), value :: margin
      real(c_float), intent(in) :: values(*)
      real(c_float), intent(inout), optional :: norm
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_dual_norm1(points, spacing, margin, values, norm, workspace, workspace_bytes) bind(c) result(answer)
      import
      integer(c_size_t), intent(in) :: points(1)
      real(c_double), value :: spacing
      integer(c_size_t), value :: margin
      real(c_double), intent(in) :: values(*)
      real(c_double), intent(inout), optional :: norm
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_dual_norm1_f32(points, spacing, margin, values, norm, workspace, workspace_bytes) bind(c) result(answer)
      import
      integer(c_size_t), intent(in) :: points(1)
      real(c_float), value :: spacing
      integer(c_size_t), value :: margin
      real(c_float), intent(in) :: values(*)
      real(c_float), intent(inout), optional :: norm
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_dual_norm3(points, spacing, margin, values, norm, workspace, workspace_bytes) bind(c) result(answer)
      import
      integer(c_size_t), intent(in) :: points(3)
      real(c_double), value :: spacing
      integer(c_size_t), value :: margin
      real(c_double), intent(in) :: values(*)
      real(c_double), intent(inout), optional :: norm
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_dual_norm3_f32(points, spacing, margin, values, norm, workspace, workspace_bytes) bind(c) result(answer)
      import
      integer(c_size_t), intent(in) :: points(3)
      real(c_float), value :: spacing
      integer(c_size_t), value :: margin
      real(c_float), intent(in) :: values(*)
      real(c_float), intent(inout), optional :: norm
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_first_bad(n, each, values, first) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      integer(c_size_t), value :: each
      real(c_double), intent(in) :: values(*)
      integer(c_int64_t), intent(inout), optional :: first
      integer(c_int32_t) :: answer
    end function
    function mollis_first_bad_f32(n, each, values, first) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      integer(c_size_t), value :: each
      real(c_float), intent(in) :: values(*)
      integer(c_int64_t), intent(inout), optional :: first
      integer(c_int32_t) :: answer
    end function
    function mollis_pks_workspace_bytes(room, attraction, options, run, bytes) bind(c) result(answer)
      import
      integer(c_size_t), value :: room
      type(mollis_pks_attraction), intent(in), target :: attraction
      type(mollis_pks_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_pks_workspace_bytes_f32(room, attraction, options, run, bytes) bind(c) result(answer)
      import
      integer(c_size_t), value :: room
      type(mollis_pks_attraction), intent(in), target :: attraction
      type(mollis_pks_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      integer(c_size_t), intent(inout) :: bytes
      integer(c_int32_t) :: answer
    end function
    function mollis_pks_step(particles, progress, attraction, generator, dt, steps, events, options, run, workspace, &
        workspace_bytes, report) bind(c) result(answer)
      import
      type(mollis_pks_particles), intent(in), target :: particles
      type(mollis_pks_progress), intent(inout), target :: progress
      type(mollis_pks_attraction), intent(in), target :: attraction
      type(mollis_generator), intent(in), target, optional :: generator
      real(c_double), value :: dt
      integer(c_size_t), value :: steps
      type(mollis_pks_events), intent(inout), target :: events
      type(mollis_pks_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      type(mollis_pks_report), intent(inout), target, optional :: report
      integer(c_int32_t) :: answer
    end function
    function mollis_pks_step_f32(particles, progress, attraction, generator, dt, steps, events, options, run, workspace, &
        workspace_bytes, report) bind(c) result(answer)
      import
      type(mollis_pks_particles_f32), intent(in), target :: particles
      type(mollis_pks_progress), intent(inout), target :: progress
      type(mollis_pks_attraction), intent(in), target :: attraction
      type(mollis_generator), intent(in), target, optional :: generator
      real(c_double), value :: dt
      integer(c_size_t), value :: steps
      type(mollis_pks_events), intent(inout), target :: events
      type(mollis_pks_options), intent(in), target, optional :: options
      type(mollis_run), intent(in), target, optional :: run
      type(c_ptr), value :: workspace
      integer(c_size_t), value :: workspace_bytes
      type(mollis_pks_report), intent(inout), target, optional :: report
      integer(c_int32_t) :: answer
    end function
    function mollis_philox_normals(seed, n, labels, step, substep, normals) bind(c) result(answer)
      import
      integer(c_int64_t), value :: seed
      integer(c_size_t), value :: n
      integer(c_int64_t), intent(in) :: labels(*)
      integer(c_int32_t), value :: step
      integer(c_int32_t), value :: substep
      real(c_double), intent(inout), optional :: normals(2,*)
      integer(c_int32_t) :: answer
    end function
    function mollis_philox_normals_f32(seed, n, labels, step, substep, normals) bind(c) result(answer)
      import
      integer(c_int64_t), value :: seed
      integer(c_size_t), value :: n
      integer(c_int64_t), intent(in) :: labels(*)
      integer(c_int32_t), value :: step
      integer(c_int32_t), value :: substep
      real(c_float), intent(inout), optional :: normals(2,*)
      integer(c_int32_t) :: answer
    end function
    function mollis_normals(n, words, out) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      integer(c_int64_t), intent(in) :: words(*)
      real(c_double), intent(inout), optional :: out(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_normals_f32(n, words, out) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      integer(c_int64_t), intent(in) :: words(*)
      real(c_float), intent(inout), optional :: out(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_grid2_options_init(options, size) bind(c) result(answer)
      import
      type(mollis_grid2_options), intent(inout), target :: options
      integer(c_size_t), value :: size
      integer(c_int32_t) :: answer
    end function
    function mollis_pks_options_init(options, size) bind(c) result(answer)
      import
      type(mollis_pks_options), intent(inout), target :: options
      integer(c_size_t), value :: size
      integer(c_int32_t) :: answer
    end function
    function mollis_pks_predict(mass, mu, chi, second_moment, n_heavy, heavy, out) bind(c) result(answer)
      import
      real(c_double), value :: mass
      real(c_double), value :: mu
      real(c_double), value :: chi
      real(c_double), value :: second_moment
      integer(c_size_t), value :: n_heavy
      real(c_double), intent(in) :: heavy(*)
      type(mollis_pks_prediction), intent(inout), target :: out
      integer(c_int32_t) :: answer
    end function
    function mollis_pks_index(n, masses, chi, noise, gamma, index) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      real(c_double), intent(in) :: masses(*)
      real(c_double), value :: chi
      real(c_double), value :: noise
      real(c_double), value :: gamma
      real(c_double), intent(inout), optional :: index(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_pks_represent_species(n, species, chi, particles, share, noise, rate) bind(c) result(answer)
      import
      integer(c_size_t), value :: n
      type(mollis_pks_species), intent(in), target :: species(*)
      real(c_double), value :: chi
      integer(c_size_t), value :: particles
      real(c_double), intent(inout), optional :: share(*)
      real(c_double), intent(inout), optional :: noise
      real(c_double), intent(inout), optional :: rate
      integer(c_int32_t) :: answer
    end function
    function mollis_philox_words(seed, label, step, substep, n, out) bind(c) result(answer)
      import
      integer(c_int64_t), value :: seed
      integer(c_int64_t), value :: label
      integer(c_int32_t), value :: step
      integer(c_int32_t), value :: substep
      integer(c_size_t), value :: n
      integer(c_int64_t), intent(inout), optional :: out(*)
      integer(c_int32_t) :: answer
    end function
    function mollis_run_init(run, size) bind(c) result(answer)
      import
      type(mollis_run), intent(inout), target :: run
      integer(c_size_t), value :: size
      integer(c_int32_t) :: answer
    end function
    function mollis_status_text(status) bind(c) result(answer)
      import
      integer(c_int32_t), value :: status
      type(c_ptr) :: answer
    end function
    function mollis_abi_version() bind(c) result(answer)
      import
      integer(c_int32_t) :: answer
    end function
  end interface

  interface blob_options_init
    module procedure thin_blob_options_init
  end interface

  interface field_options_init
    module procedure thin_field_options_init
  end interface

  interface blob2_workspace_bytes
    module procedure thin_blob2_workspace_bytes, thin_blob2_workspace_bytes_f32
  end interface

  interface blob1_workspace_bytes
    module procedure thin_blob1_workspace_bytes, thin_blob1_workspace_bytes_f32
  end interface

  interface blob3_workspace_bytes
    module procedure thin_blob3_workspace_bytes, thin_blob3_workspace_bytes_f32
  end interface

  interface blob2_step
    module procedure thin_blob2_step, thin_blob2_step_f32
  end interface

  interface blob1_step
    module procedure thin_blob1_step, thin_blob1_step_f32
  end interface

  interface blob3_step
    module procedure thin_blob3_step, thin_blob3_step_f32
  end interface

  interface moments2
    module procedure thin_moments2, thin_moments2_f32
  end interface

  interface moments1
    module procedure thin_moments1, thin_moments1_f32
  end interface

  interface moments3
    module procedure thin_moments3, thin_moments3_f32
  end interface

  interface stable_step2
    module procedure thin_stable_step2, thin_stable_step2_f32
  end interface

  interface stable_step1
    module procedure thin_stable_step1, thin_stable_step1_f32
  end interface

  interface stable_step3
    module procedure thin_stable_step3, thin_stable_step3_f32
  end interface

  interface stable_step2_anywhere
    module procedure thin_stable_step2_anywhere, thin_stable_step2_anywhere_f32
  end interface

  interface stable_step1_anywhere
    module procedure thin_stable_step1_anywhere, thin_stable_step1_anywhere_f32
  end interface

  interface stable_step3_anywhere
    module procedure thin_stable_step3_anywhere, thin_stable_step3_anywhere_f32
  end interface

  interface overlap2
    module procedure thin_overlap2, thin_overlap2_f32
  end interface

  interface overlap1
    module procedure thin_overlap1, thin_overlap1_f32
  end interface

  interface overlap3
    module procedure thin_overlap3, thin_overlap3_f32
  end interface

  interface field2_workspace_bytes
    module procedure thin_field2_workspace_bytes, thin_field2_workspace_bytes_f32
  end interface

  interface field1_workspace_bytes
    module procedure thin_field1_workspace_bytes, thin_field1_workspace_bytes_f32
  end interface

  interface field3_workspace_bytes
    module procedure thin_field3_workspace_bytes, thin_field3_workspace_bytes_f32
  end interface

  interface field2_text
    module procedure thin_field2_text, thin_field2_text_f32
  end interface

  interface field1_text
    module procedure thin_field1_text, thin_field1_text_f32
  end interface

  interface field3_text
    module procedure thin_field3_text, thin_field3_text_f32
  end interface

  interface field2_eval
    module procedure thin_field2_eval, thin_field2_eval_f32
  end interface

  interface field1_eval
    module procedure thin_field1_eval, thin_field1_eval_f32
  end interface

  interface field3_eval
    module procedure thin_field3_eval, thin_field3_eval_f32
  end interface

  interface field2_essential_bytes
    module procedure thin_field2_essential_bytes, thin_field2_essential_bytes_f32
  end interface

  interface field1_essential_bytes
    module procedure thin_field1_essential_bytes, thin_field1_essential_bytes_f32
  end interface

  interface field3_essential_bytes
    module procedure thin_field3_essential_bytes, thin_field3_essential_bytes_f32
  end interface

  interface field2_essential
    module procedure thin_field2_essential, thin_field2_essential_f32
  end interface

  interface field1_essential
    module procedure thin_field1_essential, thin_field1_essential_f32
  end interface

  interface field3_essential
    module procedure thin_field3_essential, thin_field3_essential_f32
  end interface

  interface grid2_workspace_bytes
    module procedure thin_grid2_workspace_bytes, thin_grid2_workspace_bytes_f32
  end interface

  interface grid2_eval
    module procedure thin_grid2_eval, thin_grid2_eval_f32
  end interface

  interface kernel2_bytes
    module procedure thin_kernel2_bytes
  end interface

  interface kernel2_bytes_f32
    module procedure thin_kernel2_bytes_f32
  end interface

  interface kernel1_bytes
    module procedure thin_kernel1_bytes
  end interface

  interface kernel1_bytes_f32
    module procedure thin_kernel1_bytes_f32
  end interface

  interface kernel3_bytes
    module procedure thin_kernel3_bytes
  end interface

  interface kernel3_bytes_f32
    module procedure thin_kernel3_bytes_f32
  end interface

  interface kernel2_prepare
    module procedure thin_kernel2_prepare, thin_kernel2_prepare_f32
  end interface

  interface kernel1_prepare
    module procedure thin_kernel1_prepare, thin_kernel1_prepare_f32
  end interface

  interface kernel3_prepare
    module procedure thin_kernel3_prepare, thin_kernel3_prepare_f32
  end interface

  interface kernel2_eval
    module procedure thin_kernel2_eval, thin_kernel2_eval_f32
  end interface

  interface kernel1_eval
    module procedure thin_kernel1_eval, thin_kernel1_eval_f32
  end interface

  interface kernel3_eval
    module procedure thin_kernel3_eval, thin_kernel3_eval_f32
  end interface

  interface mollifier2_eval
    module procedure thin_mollifier2_eval, thin_mollifier2_eval_f32
  end interface

  interface mollifier1_eval
    module procedure thin_mollifier1_eval, thin_mollifier1_eval_f32
  end interface

  interface mollifier3_eval
    module procedure thin_mollifier3_eval, thin_mollifier3_eval_f32
  end interface

  interface mollifier1_heaviside
    module procedure thin_mollifier1_heaviside, thin_mollifier1_heaviside_f32
  end interface

  interface mollifier2_moment
    module procedure thin_mollifier2_moment, thin_mollifier2_moment_f32
  end interface

  interface mollifier1_moment
    module procedure thin_mollifier1_moment, thin_mollifier1_moment_f32
  end interface

  interface mollifier3_moment
    module procedure thin_mollifier3_moment, thin_mollifier3_moment_f32
  end interface

  interface mollifier2_field
    module procedure thin_mollifier2_field, thin_mollifier2_field_f32
  end interface

  interface mollifier1_field
    module procedure thin_mollifier1_field, thin_mollifier1_field_f32
  end interface

  interface mollifier3_field
    module procedure thin_mollifier3_field, thin_mollifier3_field_f32
  end interface

  interface mollifier2_richardson
    module procedure thin_mollifier2_richardson, thin_mollifier2_richardson_f32
  end interface

  interface mollifier1_richardson
    module procedure thin_mollifier1_richardson, thin_mollifier1_richardson_f32
  end interface

  interface mollifier3_richardson
    module procedure thin_mollifier3_richardson, thin_mollifier3_richardson_f32
  end interface

  interface norm
    module procedure thin_norm, thin_norm_f32
  end interface

  interface distance_norm2
    module procedure thin_distance_norm2, thin_distance_norm2_f32
  end interface

  interface distance_norm1
    module procedure thin_distance_norm1, thin_distance_norm1_f32
  end interface

  interface distance_norm3
    module procedure thin_distance_norm3, thin_distance_norm3_f32
  end interface

  interface sobolev_norm2
    module procedure thin_sobolev_norm2, thin_sobolev_norm2_f32
  end interface

  interface sobolev_norm1
    module procedure thin_sobolev_norm1, thin_sobolev_norm1_f32
  end interface

  interface sobolev_norm3
    module procedure thin_sobolev_norm3, thin_sobolev_norm3_f32
  end interface

  interface dual_norm2_workspace_bytes
    module procedure thin_dual_norm2_workspace_bytes
  end interface

  interface dual_norm2_workspace_bytes_f32
    module procedure thin_dual_norm2_workspace_bytes_f32
  end interface

  interface dual_norm1_workspace_bytes
    module procedure thin_dual_norm1_workspace_bytes
  end interface

  interface dual_norm1_workspace_bytes_f32
    module procedure thin_dual_norm1_workspace_bytes_f32
  end interface

  interface dual_norm3_workspace_bytes
    module procedure thin_dual_norm3_workspace_bytes
  end interface

  interface dual_norm3_workspace_bytes_f32
    module procedure thin_dual_norm3_workspace_bytes_f32
  end interface

  interface dual_norm2
    module procedure thin_dual_norm2, thin_dual_norm2_f32
  end interface

  interface dual_norm1
    module procedure thin_dual_norm1, thin_dual_norm1_f32
  end interface

  interface dual_norm3
    module procedure thin_dual_norm3, thin_dual_norm3_f32
  end interface

  interface first_bad
    module procedure thin_first_bad, thin_first_bad_f32
  end interface

  interface pks_workspace_bytes
    module procedure thin_pks_workspace_bytes
  end interface

  interface pks_workspace_bytes_f32
    module procedure thin_pks_workspace_bytes_f32
  end interface

  interface pks_step
    module procedure thin_pks_step, thin_pks_step_f32
  end interface

  interface philox_normals
    module procedure thin_philox_normals
  end interface

  interface philox_normals_f32
    module procedure thin_philox_normals_f32
  end interface

  interface normals
    module procedure thin_normals
  end interface

  interface normals_f32
    module procedure thin_normals_f32
  end interface

  interface grid2_options_init
    module procedure thin_grid2_options_init
  end interface

  interface pks_options_init
    module procedure thin_pks_options_init
  end interface

  interface pks_predict
    module procedure thin_pks_predict
  end interface

  interface pks_index
    module procedure thin_pks_index
  end interface

  interface pks_represent_species
    module procedure thin_pks_represent_species
  end interface

  interface philox_words
    module procedure thin_philox_words
  end interface

  interface run_init
    module procedure thin_run_init
  end interface

  private :: at_0, at_1, at_2, at_3, at_4, at_5, at_6, at_7

  ! The address of the first element of a variable of any type.
  interface mollis_at
    module procedure at_0, at_1, at_2, at_3, at_4, at_5, at_6, at_7
  end interface

contains

  function at_0(x) result(address)
    type(*), target :: x
    type(c_ptr) :: address
    address = c_loc(x)
  end function

  function at_1(x) result(address)
    type(*), target :: x(:)
    type(c_ptr) :: address
    address = c_loc(x)
  end function

  function at_2(x) result(address)
    type(*), target :: x(:,:)
    type(c_ptr) :: address
    address = c_loc(x)
  end function

  function at_3(x) result(address)
    type(*), target :: x(:,:,:)
    type(c_ptr) :: address
    address = c_loc(x)
  end function

  function at_4(x) result(address)
    type(*), target :: x(:,:,:,:)
    type(c_ptr) :: address
    address = c_loc(x)
  end function

  function at_5(x) result(address)
    type(*), target :: x(:,:,:,:,:)
    type(c_ptr) :: address
    address = c_loc(x)
  end function

  function at_6(x) result(address)
    type(*), target :: x(:,:,:,:,:,:)
    type(c_ptr) :: address
    address = c_loc(x)
  end function

  function at_7(x) result(address)
    type(*), target :: x(:,:,:,:,:,:,:)
    type(c_ptr) :: address
    address = c_loc(x)
  end function

  ! The address of bytes; null if there are none.
  function address_of(bytes) result(address)
    integer(c_int8_t), intent(in), target, contiguous :: bytes(:)
    type(c_ptr) :: address
    address = c_null_ptr
    if (size(bytes) > 0) address = c_loc(bytes)
  end function

  ! A text of C, up to its end or that of its array; blanks follow.
  subroutine fill(text, letters)
    character(*), intent(out) :: text
    character(kind=c_char), intent(in) :: letters(:)
    integer :: k
    text = ' '
    do k = 1, min(len(text), size(letters))
      if (letters(k) == c_null_char) exit
      text(k:k) = letters(k)
    end do
  end subroutine

  ! What a status means.
  function status_text(status) result(text)
    integer(c_int32_t), intent(in) :: status
    character(:), allocatable :: text
    character(kind=c_char), pointer :: letters(:)
    integer :: n
    call c_f_pointer(mollis_status_text(status), letters, [200])
    n = 1
    do while (letters(n) /= c_null_char)
      n = n + 1
    end do
    allocate(character(n - 1) :: text)
    call fill(text, letters)
  end function

  ! Hands a status to the caller, or stops where it is an error.
  subroutine tell(code, status)
    integer(c_int32_t), intent(in) :: code
    integer(c_int32_t), intent(out), optional :: status
    if (present(status)) then
      status = code
    else if (code /= MOLLIS_OK) then
      print '(2a)', 'mollis: ', status_text(code)
      error stop
    end if
  end subroutine

  subroutine thin_blob_options_init(options, status)
    type(mollis_blob_options), intent(inout), target :: options
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_blob_options_init(options, c_sizeof(options)), status)
  end subroutine

  subroutine thin_field_options_init(options, status)
    type(mollis_field_options), intent(inout), target :: options
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field_options_init(options, c_sizeof(options)), status)
  end subroutine

  subroutine thin_blob2_workspace_bytes(kernel, particles, tracers, options, run, bytes, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_particles2), intent(in), target :: particles
    type(mollis_particles2), intent(in), target, optional :: tracers
    type(mollis_blob_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_blob2_workspace_bytes(address_of(kernel), size(kernel, kind=c_size_t), particles, tracers, options, run, &
        bytes), status)
  end subroutine

  subroutine thin_blob2_workspace_bytes_f32(kernel, particles, tracers, options, run, bytes, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_particles2_f32), intent(in), target :: particles
    type(mollis_particles2_f32), intent(in), target, optional :: tracers
    type(mollis_blob_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_blob2_workspace_bytes_f32(address_of(kernel), size(kernel, kind=c_size_t), particles, tracers, options, run, &
        bytes), status)
  end subroutine

  subroutine thin_blob1_workspace_bytes(kernel, particles, tracers, options, run, bytes, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_particles1), intent(in), target :: particles
    type(mollis_particles1), intent(in), target, optional :: tracers
    type(mollis_blob_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_blob1_workspace_bytes(address_of(kernel), size(kernel, kind=c_size_t), particles, tracers, options, run, &
        bytes), status)
  end subroutine

  subroutine thin_blob1_workspace_bytes_f32(kernel, particles, tracers, options, run, bytes, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_particles1_f32), intent(in), target :: particles
    type(mollis_particles1_f32), intent(in), target, optional :: tracers
    type(mollis_blob_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_blob1_workspace_bytes_f32(address_of(kernel), size(kernel, kind=c_size_t), particles, tracers, options, run, &
        bytes), status)
  end subroutine

  subroutine thin_blob3_workspace_bytes(kernel, particles, tracers, options, run, bytes, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_particles3), intent(in), target :: particles
    type(mollis_particles3), intent(in), target, optional :: tracers
    type(mollis_blob_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_blob3_workspace_bytes(address_of(kernel), size(kernel, kind=c_size_t), particles, tracers, options, run, &
        bytes), status)
  end subroutine

  subroutine thin_blob3_workspace_bytes_f32(kernel, particles, tracers, options, run, bytes, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_particles3_f32), intent(in), target :: particles
    type(mollis_particles3_f32), intent(in), target, optional :: tracers
    type(mollis_blob_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_blob3_workspace_bytes_f32(address_of(kernel), size(kernel, kind=c_size_t), particles, tracers, options, run, &
        bytes), status)
  end subroutine

  subroutine thin_blob2_step(kernel, particles, tracers, dt, steps, options, run, workspace, report, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_particles2), intent(in), target :: particles
    type(mollis_particles2), intent(in), target, optional :: tracers
    real(c_double), value :: dt
    integer, intent(in) :: steps
    type(mollis_blob_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    type(mollis_blob_report), intent(inout), target, optional :: report
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_blob2_step(address_of(kernel), size(kernel, kind=c_size_t), particles, tracers, dt, int(steps, c_size_t), &
        options, run, address_of(workspace), size(workspace, kind=c_size_t), report), status)
  end subroutine

  subroutine thin_blob2_step_f32(kernel, particles, tracers, dt, steps, options, run, workspace, report, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_particles2_f32), intent(in), target :: particles
    type(mollis_particles2_f32), intent(in), target, optional :: tracers
    real(c_double), value :: dt
    integer, intent(in) :: steps
    type(mollis_blob_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    type(mollis_blob_report), intent(inout), target, optional :: report
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_blob2_step_f32(address_of(kernel), size(kernel, kind=c_size_t), particles, tracers, dt, int(steps, &
        c_size_t), options, run, address_of(workspace), size(workspace, kind=c_size_t), report), status)
  end subroutine

  subroutine thin_blob1_step(kernel, particles, tracers, dt, steps, options, run, workspace, report, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_particles1), intent(in), target :: particles
    type(mollis_particles1), intent(in), target, optional :: tracers
    real(c_double), value :: dt
    integer, intent(in) :: steps
    type(mollis_blob_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    type(mollis_blob_report), intent(inout), target, optional :: report
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_blob1_step(address_of(kernel), size(kernel, kind=c_size_t), particles, tracers, dt, int(steps, c_size_t), &
        options, run, address_of(workspace), size(workspace, kind=c_size_t), report), status)
  end subroutine

  subroutine thin_blob1_step_f32(kernel, particles, tracers, dt, steps, options, run, workspace, report, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_particles1_f32), intent(in), target :: particles
    type(mollis_particles1_f32), intent(in), target, optional :: tracers
    real(c_double), value :: dt
    integer, intent(in) :: steps
    type(mollis_blob_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    type(mollis_blob_report), intent(inout), target, optional :: report
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_blob1_step_f32(address_of(kernel), size(kernel, kind=c_size_t), particles, tracers, dt, int(steps, &
        c_size_t), options, run, address_of(workspace), size(workspace, kind=c_size_t), report), status)
  end subroutine

  subroutine thin_blob3_step(kernel, particles, tracers, dt, steps, options, run, workspace, report, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_particles3), intent(in), target :: particles
    type(mollis_particles3), intent(in), target, optional :: tracers
    real(c_double), value :: dt
    integer, intent(in) :: steps
    type(mollis_blob_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    type(mollis_blob_report), intent(inout), target, optional :: report
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_blob3_step(address_of(kernel), size(kernel, kind=c_size_t), particles, tracers, dt, int(steps, c_size_t), &
        options, run, address_of(workspace), size(workspace, kind=c_size_t), report), status)
  end subroutine

  subroutine thin_blob3_step_f32(kernel, particles, tracers, dt, steps, options, run, workspace, report, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_particles3_f32), intent(in), target :: particles
    type(mollis_particles3_f32), intent(in), target, optional :: tracers
    real(c_double), value :: dt
    integer, intent(in) :: steps
    type(mollis_blob_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    type(mollis_blob_report), intent(inout), target, optional :: report
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_blob3_step_f32(address_of(kernel), size(kernel, kind=c_size_t), particles, tracers, dt, int(steps, &
        c_size_t), options, run, address_of(workspace), size(workspace, kind=c_size_t), report), status)
  end subroutine

  subroutine thin_moments2(n, positions, masses, mass, absolute_mass, centre, second, status)
    integer, intent(in) :: n
    real(c_double), intent(in) :: positions(2,*)
    real(c_double), intent(in) :: masses(*)
    real(c_double), intent(inout), optional :: mass
    real(c_double), intent(inout), optional :: absolute_mass
    real(c_double), intent(inout), optional :: centre(2)
    real(c_double), intent(inout), optional :: second
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_moments2(int(n, c_size_t), positions, masses, mass, absolute_mass, centre, second), status)
  end subroutine

  subroutine thin_moments2_f32(n, positions, masses, mass, absolute_mass, centre, second, status)
    integer, intent(in) :: n
    real(c_float), intent(in) :: positions(2,*)
    real(c_float), intent(in) :: masses(*)
    real(c_float), intent(inout), optional :: mass
    real(c_float), intent(inout), optional :: absolute_mass
    real(c_float), intent(inout), optional :: centre(2)
    real(c_float), intent(inout), optional :: second
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_moments2_f32(int(n, c_size_t), positions, masses, mass, absolute_mass, centre, second), status)
  end subroutine

  subroutine thin_moments1(n, positions, masses, mass, absolute_mass, centre, second, status)
    integer, intent(in) :: n
    real(c_double), intent(in) :: positions(1,*)
    real(c_double), intent(in) :: masses(*)
    real(c_double), intent(inout), optional :: mass
    real(c_double), intent(inout), optional :: absolute_mass
    real(c_double), intent(inout), optional :: centre(1)
    real(c_double), intent(inout), optional :: second
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_moments1(int(n, c_size_t), positions, masses, mass, absolute_mass, centre, second), status)
  end subroutine

  subroutine thin_moments1_f32(n, positions, masses, mass, absolute_mass, centre, second, status)
    integer, intent(in) :: n
    real(c_float), intent(in) :: positions(1,*)
    real(c_float), intent(in) :: masses(*)
    real(c_float), intent(inout), optional :: mass
    real(c_float), intent(inout), optional :: absolute_mass
    real(c_float), intent(inout), optional :: centre(1)
    real(c_float), intent(inout), optional :: second
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_moments1_f32(int(n, c_size_t), positions, masses, mass, absolute_mass, centre, second), status)
  end subroutine

  subroutine thin_moments3(n, positions, masses, mass, absolute_mass, centre, second, status)
    integer, intent(in) :: n
    real(c_double), intent(in) :: positions(3,*)
    real(c_double), intent(in) :: masses(*)
    real(c_double), intent(inout), optional :: mass
    real(c_double), intent(inout), optional :: absolute_mass
    real(c_double), intent(inout), optional :: centre(3)
    real(c_double), intent(inout), optional :: second
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_moments3(int(n, c_size_t), positions, masses, mass, absolute_mass, centre, second), status)
  end subroutine

  subroutine thin_moments3_f32(n, positions, masses, mass, absolute_mass, centre, second, status)
    integer, intent(in) :: n
    real(c_float), intent(in) :: positions(3,*)
    real(c_float), intent(in) :: masses(*)
    real(c_float), intent(inout), optional :: mass
    real(c_float), intent(inout), optional :: absolute_mass
    real(c_float), intent(inout), optional :: centre(3)
    real(c_float), intent(inout), optional :: second
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_moments3_f32(int(n, c_size_t), positions, masses, mass, absolute_mass, centre, second), status)
  end subroutine

  subroutine thin_stable_step2(kernel, n, positions, masses, step, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    integer, intent(in) :: n
    real(c_double), intent(in) :: positions(2,*)
    real(c_double), intent(in) :: masses(*)
    real(c_double), intent(inout), optional :: step
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_stable_step2(address_of(kernel), size(kernel, kind=c_size_t), int(n, c_size_t), positions, masses, step), &
        status)
  end subroutine

  subroutine thin_stable_step2_f32(kernel, n, positions, masses, step, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    integer, intent(in) :: n
    real(c_float), intent(in) :: positions(2,*)
    real(c_float), intent(in) :: masses(*)
    real(c_float), intent(inout), optional :: step
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_stable_step2_f32(address_of(kernel), size(kernel, kind=c_size_t), int(n, c_size_t), positions, masses, &
        step), status)
  end subroutine

  subroutine thin_stable_step1(kernel, n, positions, masses, step, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    integer, intent(in) :: n
    real(c_double), intent(in) :: positions(1,*)
    real(c_double), intent(in) :: masses(*)
    real(c_double), intent(inout), optional :: step
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_stable_step1(address_of(kernel), size(kernel, kind=c_size_t), int(n, c_size_t), positions, masses, step), &
        status)
  end subroutine

  subroutine thin_stable_step1_f32(kernel, n, positions, masses, step, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    integer, intent(in) :: n
    real(c_float), intent(in) :: positions(1,*)
    real(c_float), intent(in) :: masses(*)
    real(c_float), intent(inout), optional :: step
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_stable_step1_f32(address_of(kernel), size(kernel, kind=c_size_t), int(n, c_size_t), positions, masses, &
        step), status)
  end subroutine

  subroutine thin_stable_step3(kernel, n, positions, masses, step, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    integer, intent(in) :: n
    real(c_double), intent(in) :: positions(3,*)
    real(c_double), intent(in) :: masses(*)
    real(c_double), intent(inout), optional :: step
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_stable_step3(address_of(kernel), size(kernel, kind=c_size_t), int(n, c_size_t), positions, masses, step), &
        status)
  end subroutine

  subroutine thin_stable_step3_f32(kernel, n, positions, masses, step, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    integer, intent(in) :: n
    real(c_float), intent(in) :: positions(3,*)
    real(c_float), intent(in) :: masses(*)
    real(c_float), intent(inout), optional :: step
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_stable_step3_f32(address_of(kernel), size(kernel, kind=c_size_t), int(n, c_size_t), positions, masses, &
        step), status)
  end subroutine

  subroutine thin_stable_step2_anywhere(kernel, absolute_mass, diameter, step, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    real(c_double), value :: absolute_mass
    real(c_double), value :: diameter
    real(c_double), intent(inout), optional :: step
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_stable_step2_anywhere(address_of(kernel), size(kernel, kind=c_size_t), absolute_mass, diameter, step), &
        status)
  end subroutine

  subroutine thin_stable_step2_anywhere_f32(kernel, absolute_mass, diameter, step, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    real(c_float), value :: absolute_mass
    real(c_float), value :: diameter
    real(c_float), intent(inout), optional :: step
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_stable_step2_anywhere_f32(address_of(kernel), size(kernel, kind=c_size_t), absolute_mass, diameter, step), &
        status)
  end subroutine

  subroutine thin_stable_step1_anywhere(kernel, absolute_mass, diameter, step, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    real(c_double), value :: absolute_mass
    real(c_double), value :: diameter
    real(c_double), intent(inout), optional :: step
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_stable_step1_anywhere(address_of(kernel), size(kernel, kind=c_size_t), absolute_mass, diameter, step), &
        status)
  end subroutine

  subroutine thin_stable_step1_anywhere_f32(kernel, absolute_mass, diameter, step, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    real(c_float), value :: absolute_mass
    real(c_float), value :: diameter
    real(c_float), intent(inout), optional :: step
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_stable_step1_anywhere_f32(address_of(kernel), size(kernel, kind=c_size_t), absolute_mass, diameter, step), &
        status)
  end subroutine

  subroutine thin_stable_step3_anywhere(kernel, absolute_mass, diameter, step, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    real(c_double), value :: absolute_mass
    real(c_double), value :: diameter
    real(c_double), intent(inout), optional :: step
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_stable_step3_anywhere(address_of(kernel), size(kernel, kind=c_size_t), absolute_mass, diameter, step), &
        status)
  end subroutine

  subroutine thin_stable_step3_anywhere_f32(kernel, absolute_mass, diameter, step, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    real(c_float), value :: absolute_mass
    real(c_float), value :: diameter
    real(c_float), intent(inout), optional :: step
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_stable_step3_anywhere_f32(address_of(kernel), size(kernel, kind=c_size_t), absolute_mass, diameter, step), &
        status)
  end subroutine

  subroutine thin_overlap2(n, delta, masses, densities, smallest, status)
    integer, intent(in) :: n
    real(c_double), value :: delta
    real(c_double), intent(in) :: masses(*)
    real(c_double), intent(in) :: densities(*)
    real(c_double), intent(inout), optional :: smallest
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_overlap2(int(n, c_size_t), delta, masses, densities, smallest), status)
  end subroutine

  subroutine thin_overlap2_f32(n, delta, masses, densities, smallest, status)
    integer, intent(in) :: n
    real(c_float), value :: delta
    real(c_float), intent(in) :: masses(*)
    real(c_float), intent(in) :: densities(*)
    real(c_float), intent(inout), optional :: smallest
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_overlap2_f32(int(n, c_size_t), delta, masses, densities, smallest), status)
  end subroutine

  subroutine thin_overlap1(n, delta, masses, densities, smallest, status)
    integer, intent(in) :: n
    real(c_double), value :: delta
    real(c_double), intent(in) :: masses(*)
    real(c_double), intent(in) :: densities(*)
    real(c_double), intent(inout), optional :: smallest
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_overlap1(int(n, c_size_t), delta, masses, densities, smallest), status)
  end subroutine

  subroutine thin_overlap1_f32(n, delta, masses, densities, smallest, status)
    integer, intent(in) :: n
    real(c_float), value :: delta
    real(c_float), intent(in) :: masses(*)
    real(c_float), intent(in) :: densities(*)
    real(c_float), intent(inout), optional :: smallest
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_overlap1_f32(int(n, c_size_t), delta, masses, densities, smallest), status)
  end subroutine

  subroutine thin_overlap3(n, delta, masses, densities, smallest, status)
    integer, intent(in) :: n
    real(c_double), value :: delta
    real(c_double), intent(in) :: masses(*)
    real(c_double), intent(in) :: densities(*)
    real(c_double), intent(inout), optional :: smallest
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_overlap3(int(n, c_size_t), delta, masses, densities, smallest), status)
  end subroutine

  subroutine thin_overlap3_f32(n, delta, masses, densities, smallest, status)
    integer, intent(in) :: n
    real(c_float), value :: delta
    real(c_float), intent(in) :: masses(*)
    real(c_float), intent(in) :: densities(*)
    real(c_float), intent(inout), optional :: smallest
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_overlap3_f32(int(n, c_size_t), delta, masses, densities, smallest), status)
  end subroutine

  subroutine thin_field2_workspace_bytes(kernel, sources, targets, outputs, options, run, bytes, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources2), intent(in), target :: sources
    type(mollis_targets2), intent(in), target, optional :: targets
    type(mollis_outputs2), intent(in), target :: outputs
    type(mollis_field_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field2_workspace_bytes(address_of(kernel), size(kernel, kind=c_size_t), sources, targets, outputs, options, &
        run, bytes), status)
  end subroutine

  subroutine thin_field2_workspace_bytes_f32(kernel, sources, targets, outputs, options, run, bytes, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources2_f32), intent(in), target :: sources
    type(mollis_targets2_f32), intent(in), target, optional :: targets
    type(mollis_outputs2_f32), intent(in), target :: outputs
    type(mollis_field_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field2_workspace_bytes_f32(address_of(kernel), size(kernel, kind=c_size_t), sources, targets, outputs, &
        options, run, bytes), status)
  end subroutine

  subroutine thin_field1_workspace_bytes(kernel, sources, targets, outputs, options, run, bytes, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources1), intent(in), target :: sources
    type(mollis_targets1), intent(in), target, optional :: targets
    type(mollis_outputs1), intent(in), target :: outputs
    type(mollis_field_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field1_workspace_bytes(address_of(kernel), size(kernel, kind=c_size_t), sources, targets, outputs, options, &
        run, bytes), status)
  end subroutine

  subroutine thin_field1_workspace_bytes_f32(kernel, sources, targets, outputs, options, run, bytes, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources1_f32), intent(in), target :: sources
    type(mollis_targets1_f32), intent(in), target, optional :: targets
    type(mollis_outputs1_f32), intent(in), target :: outputs
    type(mollis_field_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field1_workspace_bytes_f32(address_of(kernel), size(kernel, kind=c_size_t), sources, targets, outputs, &
        options, run, bytes), status)
  end subroutine

  subroutine thin_field3_workspace_bytes(kernel, sources, targets, outputs, options, run, bytes, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources3), intent(in), target :: sources
    type(mollis_targets3), intent(in), target, optional :: targets
    type(mollis_outputs3), intent(in), target :: outputs
    type(mollis_field_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field3_workspace_bytes(address_of(kernel), size(kernel, kind=c_size_t), sources, targets, outputs, options, &
        run, bytes), status)
  end subroutine

  subroutine thin_field3_workspace_bytes_f32(kernel, sources, targets, outputs, options, run, bytes, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources3_f32), intent(in), target :: sources
    type(mollis_targets3_f32), intent(in), target, optional :: targets
    type(mollis_outputs3_f32), intent(in), target :: outputs
    type(mollis_field_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field3_workspace_bytes_f32(address_of(kernel), size(kernel, kind=c_size_t), sources, targets, outputs, &
        options, run, bytes), status)
  end subroutine

  subroutine thin_field2_text(kernel, sources, targets, outputs, options, text, length, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources2), intent(in), target :: sources
    type(mollis_targets2), intent(in), target, optional :: targets
    type(mollis_outputs2), intent(in), target :: outputs
    type(mollis_field_options), intent(in), target, optional :: options
    character(*), intent(out) :: text
    character(kind=c_char) :: c_text(len(text) + 1)
    integer(c_size_t), intent(inout), optional :: length
    integer(c_int32_t), intent(out), optional :: status
    c_text = c_null_char
    call tell(mollis_field2_text(address_of(kernel), size(kernel, kind=c_size_t), sources, targets, outputs, options, c_text, &
        size(c_text, kind=c_size_t), length), status)
    call fill(text, c_text)
  end subroutine

  subroutine thin_field2_text_f32(kernel, sources, targets, outputs, options, text, length, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources2_f32), intent(in), target :: sources
    type(mollis_targets2_f32), intent(in), target, optional :: targets
    type(mollis_outputs2_f32), intent(in), target :: outputs
    type(mollis_field_options), intent(in), target, optional :: options
    character(*), intent(out) :: text
    character(kind=c_char) :: c_text(len(text) + 1)
    integer(c_size_t), intent(inout), optional :: length
    integer(c_int32_t), intent(out), optional :: status
    c_text = c_null_char
    call tell(mollis_field2_text_f32(address_of(kernel), size(kernel, kind=c_size_t), sources, targets, outputs, options, c_text, &
        size(c_text, kind=c_size_t), length), status)
    call fill(text, c_text)
  end subroutine

  subroutine thin_field1_text(kernel, sources, targets, outputs, options, text, length, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources1), intent(in), target :: sources
    type(mollis_targets1), intent(in), target, optional :: targets
    type(mollis_outputs1), intent(in), target :: outputs
    type(mollis_field_options), intent(in), target, optional :: options
    character(*), intent(out) :: text
    character(kind=c_char) :: c_text(len(text) + 1)
    integer(c_size_t), intent(inout), optional :: length
    integer(c_int32_t), intent(out), optional :: status
    c_text = c_null_char
    call tell(mollis_field1_text(address_of(kernel), size(kernel, kind=c_size_t), sources, targets, outputs, options, c_text, &
        size(c_text, kind=c_size_t), length), status)
    call fill(text, c_text)
  end subroutine

  subroutine thin_field1_text_f32(kernel, sources, targets, outputs, options, text, length, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources1_f32), intent(in), target :: sources
    type(mollis_targets1_f32), intent(in), target, optional :: targets
    type(mollis_outputs1_f32), intent(in), target :: outputs
    type(mollis_field_options), intent(in), target, optional :: options
    character(*), intent(out) :: text
    character(kind=c_char) :: c_text(len(text) + 1)
    integer(c_size_t), intent(inout), optional :: length
    integer(c_int32_t), intent(out), optional :: status
    c_text = c_null_char
    call tell(mollis_field1_text_f32(address_of(kernel), size(kernel, kind=c_size_t), sources, targets, outputs, options, c_text, &
        size(c_text, kind=c_size_t), length), status)
    call fill(text, c_text)
  end subroutine

  subroutine thin_field3_text(kernel, sources, targets, outputs, options, text, length, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources3), intent(in), target :: sources
    type(mollis_targets3), intent(in), target, optional :: targets
    type(mollis_outputs3), intent(in), target :: outputs
    type(mollis_field_options), intent(in), target, optional :: options
    character(*), intent(out) :: text
    character(kind=c_char) :: c_text(len(text) + 1)
    integer(c_size_t), intent(inout), optional :: length
    integer(c_int32_t), intent(out), optional :: status
    c_text = c_null_char
    call tell(mollis_field3_text(address_of(kernel), size(kernel, kind=c_size_t), sources, targets, outputs, options, c_text, &
        size(c_text, kind=c_size_t), length), status)
    call fill(text, c_text)
  end subroutine

  subroutine thin_field3_text_f32(kernel, sources, targets, outputs, options, text, length, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources3_f32), intent(in), target :: sources
    type(mollis_targets3_f32), intent(in), target, optional :: targets
    type(mollis_outputs3_f32), intent(in), target :: outputs
    type(mollis_field_options), intent(in), target, optional :: options
    character(*), intent(out) :: text
    character(kind=c_char) :: c_text(len(text) + 1)
    integer(c_size_t), intent(inout), optional :: length
    integer(c_int32_t), intent(out), optional :: status
    c_text = c_null_char
    call tell(mollis_field3_text_f32(address_of(kernel), size(kernel, kind=c_size_t), sources, targets, outputs, options, c_text, &
        size(c_text, kind=c_size_t), length), status)
    call fill(text, c_text)
  end subroutine

  subroutine thin_field2_eval(kernel, sources, targets, outputs, options, run, workspace, counters, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources2), intent(in), target :: sources
    type(mollis_targets2), intent(in), target, optional :: targets
    type(mollis_outputs2), intent(in), target :: outputs
    type(mollis_field_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    type(mollis_field_counts), intent(inout), target, optional :: counters
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field2_eval(address_of(kernel), size(kernel, kind=c_size_t), sources, targets, outputs, options, run, &
        address_of(workspace), size(workspace, kind=c_size_t), counters), status)
  end subroutine

  subroutine thin_field2_eval_f32(kernel, sources, targets, outputs, options, run, workspace, counters, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources2_f32), intent(in), target :: sources
    type(mollis_targets2_f32), intent(in), target, optional :: targets
    type(mollis_outputs2_f32), intent(in), target :: outputs
    type(mollis_field_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    type(mollis_field_counts), intent(inout), target, optional :: counters
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field2_eval_f32(address_of(kernel), size(kernel, kind=c_size_t), sources, targets, outputs, options, run, &
        address_of(workspace), size(workspace, kind=c_size_t), counters), status)
  end subroutine

  subroutine thin_field1_eval(kernel, sources, targets, outputs, options, run, workspace, counters, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources1), intent(in), target :: sources
    type(mollis_targets1), intent(in), target, optional :: targets
    type(mollis_outputs1), intent(in), target :: outputs
    type(mollis_field_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    type(mollis_field_counts), intent(inout), target, optional :: counters
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field1_eval(address_of(kernel), size(kernel, kind=c_size_t), sources, targets, outputs, options, run, &
        address_of(workspace), size(workspace, kind=c_size_t), counters), status)
  end subroutine

  subroutine thin_field1_eval_f32(kernel, sources, targets, outputs, options, run, workspace, counters, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources1_f32), intent(in), target :: sources
    type(mollis_targets1_f32), intent(in), target, optional :: targets
    type(mollis_outputs1_f32), intent(in), target :: outputs
    type(mollis_field_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    type(mollis_field_counts), intent(inout), target, optional :: counters
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field1_eval_f32(address_of(kernel), size(kernel, kind=c_size_t), sources, targets, outputs, options, run, &
        address_of(workspace), size(workspace, kind=c_size_t), counters), status)
  end subroutine

  subroutine thin_field3_eval(kernel, sources, targets, outputs, options, run, workspace, counters, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources3), intent(in), target :: sources
    type(mollis_targets3), intent(in), target, optional :: targets
    type(mollis_outputs3), intent(in), target :: outputs
    type(mollis_field_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    type(mollis_field_counts), intent(inout), target, optional :: counters
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field3_eval(address_of(kernel), size(kernel, kind=c_size_t), sources, targets, outputs, options, run, &
        address_of(workspace), size(workspace, kind=c_size_t), counters), status)
  end subroutine

  subroutine thin_field3_eval_f32(kernel, sources, targets, outputs, options, run, workspace, counters, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources3_f32), intent(in), target :: sources
    type(mollis_targets3_f32), intent(in), target, optional :: targets
    type(mollis_outputs3_f32), intent(in), target :: outputs
    type(mollis_field_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    type(mollis_field_counts), intent(inout), target, optional :: counters
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field3_eval_f32(address_of(kernel), size(kernel, kind=c_size_t), sources, targets, outputs, options, run, &
        address_of(workspace), size(workspace, kind=c_size_t), counters), status)
  end subroutine

  subroutine thin_field2_essential_bytes(kernel, sources, tolerance, bytes, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources2), intent(in), target :: sources
    real(c_double), value :: tolerance
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field2_essential_bytes(address_of(kernel), size(kernel, kind=c_size_t), sources, tolerance, bytes), status)
  end subroutine

  subroutine thin_field2_essential_bytes_f32(kernel, sources, tolerance, bytes, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources2_f32), intent(in), target :: sources
    real(c_double), value :: tolerance
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field2_essential_bytes_f32(address_of(kernel), size(kernel, kind=c_size_t), sources, tolerance, bytes), &
        status)
  end subroutine

  subroutine thin_field1_essential_bytes(kernel, sources, tolerance, bytes, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources1), intent(in), target :: sources
    real(c_double), value :: tolerance
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field1_essential_bytes(address_of(kernel), size(kernel, kind=c_size_t), sources, tolerance, bytes), status)
  end subroutine

  subroutine thin_field1_essential_bytes_f32(kernel, sources, tolerance, bytes, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources1_f32), intent(in), target :: sources
    real(c_double), value :: tolerance
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field1_essential_bytes_f32(address_of(kernel), size(kernel, kind=c_size_t), sources, tolerance, bytes), &
        status)
  end subroutine

  subroutine thin_field3_essential_bytes(kernel, sources, tolerance, bytes, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources3), intent(in), target :: sources
    real(c_double), value :: tolerance
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field3_essential_bytes(address_of(kernel), size(kernel, kind=c_size_t), sources, tolerance, bytes), status)
  end subroutine

  subroutine thin_field3_essential_bytes_f32(kernel, sources, tolerance, bytes, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources3_f32), intent(in), target :: sources
    real(c_double), value :: tolerance
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field3_essential_bytes_f32(address_of(kernel), size(kernel, kind=c_size_t), sources, tolerance, bytes), &
        status)
  end subroutine

  subroutine thin_field2_essential(kernel, sources, tolerance, n_boxes, boxes, starts, room, positions, masses, origins, run, &
      workspace, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources2), intent(in), target :: sources
    real(c_double), value :: tolerance
    integer, intent(in) :: n_boxes
    real(c_double), intent(in) :: boxes(2,2,*)
    integer(c_int64_t), intent(inout), optional :: starts(*)
    integer, intent(in) :: room
    real(c_double), intent(inout), optional :: positions(2,*)
    real(c_double), intent(inout), optional :: masses(*)
    integer(c_int64_t), intent(inout), optional :: origins(*)
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field2_essential(address_of(kernel), size(kernel, kind=c_size_t), sources, tolerance, int(n_boxes, &
        c_size_t), boxes, starts, int(room, c_size_t), positions, masses, origins, run, address_of(workspace), size(workspace, &
        kind=c_size_t)), status)
  end subroutine

  subroutine thin_field2_essential_f32(kernel, sources, tolerance, n_boxes, boxes, starts, room, positions, masses, origins, run, &
      workspace, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources2_f32), intent(in), target :: sources
    real(c_double), value :: tolerance
    integer, intent(in) :: n_boxes
    real(c_float), intent(in) :: boxes(2,2,*)
    integer(c_int64_t), intent(inout), optional :: starts(*)
    integer, intent(in) :: room
    real(c_float), intent(inout), optional :: positions(2,*)
    real(c_float), intent(inout), optional :: masses(*)
    integer(c_int64_t), intent(inout), optional :: origins(*)
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field2_essential_f32(address_of(kernel), size(kernel, kind=c_size_t), sources, tolerance, int(n_boxes, &
        c_size_t), boxes, starts, int(room, c_size_t), positions, masses, origins, run, address_of(workspace), size(workspace, &
        kind=c_size_t)), status)
  end subroutine

  subroutine thin_field1_essential(kernel, sources, tolerance, n_boxes, boxes, starts, room, positions, masses, origins, run, &
      workspace, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources1), intent(in), target :: sources
    real(c_double), value :: tolerance
    integer, intent(in) :: n_boxes
    real(c_double), intent(in) :: boxes(1,2,*)
    integer(c_int64_t), intent(inout), optional :: starts(*)
    integer, intent(in) :: room
    real(c_double), intent(inout), optional :: positions(1,*)
    real(c_double), intent(inout), optional :: masses(*)
    integer(c_int64_t), intent(inout), optional :: origins(*)
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field1_essential(address_of(kernel), size(kernel, kind=c_size_t), sources, tolerance, int(n_boxes, &
        c_size_t), boxes, starts, int(room, c_size_t), positions, masses, origins, run, address_of(workspace), size(workspace, &
        kind=c_size_t)), status)
  end subroutine

  subroutine thin_field1_essential_f32(kernel, sources, tolerance, n_boxes, boxes, starts, room, positions, masses, origins, run, &
      workspace, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources1_f32), intent(in), target :: sources
    real(c_double), value :: tolerance
    integer, intent(in) :: n_boxes
    real(c_float), intent(in) :: boxes(1,2,*)
    integer(c_int64_t), intent(inout), optional :: starts(*)
    integer, intent(in) :: room
    real(c_float), intent(inout), optional :: positions(1,*)
    real(c_float), intent(inout), optional :: masses(*)
    integer(c_int64_t), intent(inout), optional :: origins(*)
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field1_essential_f32(address_of(kernel), size(kernel, kind=c_size_t), sources, tolerance, int(n_boxes, &
        c_size_t), boxes, starts, int(room, c_size_t), positions, masses, origins, run, address_of(workspace), size(workspace, &
        kind=c_size_t)), status)
  end subroutine

  subroutine thin_field3_essential(kernel, sources, tolerance, n_boxes, boxes, starts, room, positions, masses, origins, run, &
      workspace, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources3), intent(in), target :: sources
    real(c_double), value :: tolerance
    integer, intent(in) :: n_boxes
    real(c_double), intent(in) :: boxes(3,2,*)
    integer(c_int64_t), intent(inout), optional :: starts(*)
    integer, intent(in) :: room
    real(c_double), intent(inout), optional :: positions(3,*)
    real(c_double), intent(inout), optional :: masses(*)
    integer(c_int64_t), intent(inout), optional :: origins(*)
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field3_essential(address_of(kernel), size(kernel, kind=c_size_t), sources, tolerance, int(n_boxes, &
        c_size_t), boxes, starts, int(room, c_size_t), positions, masses, origins, run, address_of(workspace), size(workspace, &
        kind=c_size_t)), status)
  end subroutine

  subroutine thin_field3_essential_f32(kernel, sources, tolerance, n_boxes, boxes, starts, room, positions, masses, origins, run, &
      workspace, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    type(mollis_sources3_f32), intent(in), target :: sources
    real(c_double), value :: tolerance
    integer, intent(in) :: n_boxes
    real(c_float), intent(in) :: boxes(3,2,*)
    integer(c_int64_t), intent(inout), optional :: starts(*)
    integer, intent(in) :: room
    real(c_float), intent(inout), optional :: positions(3,*)
    real(c_float), intent(inout), optional :: masses(*)
    integer(c_int64_t), intent(inout), optional :: origins(*)
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_field3_essential_f32(address_of(kernel), size(kernel, kind=c_size_t), sources, tolerance, int(n_boxes, &
        c_size_t), boxes, starts, int(room, c_size_t), positions, masses, origins, run, address_of(workspace), size(workspace, &
        kind=c_size_t)), status)
  end subroutine

  subroutine thin_grid2_workspace_bytes(mesh, sources, targets, outputs, options, run, bytes, status)
    type(mollis_mesh2), intent(in), target :: mesh
    type(mollis_sources2), intent(in), target :: sources
    type(mollis_targets2), intent(in), target, optional :: targets
    type(mollis_grid2_outputs), intent(in), target :: outputs
    type(mollis_grid2_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_grid2_workspace_bytes(mesh, sources, targets, outputs, options, run, bytes), status)
  end subroutine

  subroutine thin_grid2_workspace_bytes_f32(mesh, sources, targets, outputs, options, run, bytes, status)
    type(mollis_mesh2), intent(in), target :: mesh
    type(mollis_sources2_f32), intent(in), target :: sources
    type(mollis_targets2_f32), intent(in), target, optional :: targets
    type(mollis_grid2_outputs_f32), intent(in), target :: outputs
    type(mollis_grid2_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_grid2_workspace_bytes_f32(mesh, sources, targets, outputs, options, run, bytes), status)
  end subroutine

  subroutine thin_grid2_eval(mesh, sources, targets, outputs, options, run, workspace, status)
    type(mollis_mesh2), intent(in), target :: mesh
    type(mollis_sources2), intent(in), target :: sources
    type(mollis_targets2), intent(in), target, optional :: targets
    type(mollis_grid2_outputs), intent(in), target :: outputs
    type(mollis_grid2_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_grid2_eval(mesh, sources, targets, outputs, options, run, address_of(workspace), size(workspace, &
        kind=c_size_t)), status)
  end subroutine

  subroutine thin_grid2_eval_f32(mesh, sources, targets, outputs, options, run, workspace, status)
    type(mollis_mesh2), intent(in), target :: mesh
    type(mollis_sources2_f32), intent(in), target :: sources
    type(mollis_targets2_f32), intent(in), target, optional :: targets
    type(mollis_grid2_outputs_f32), intent(in), target :: outputs
    type(mollis_grid2_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_grid2_eval_f32(mesh, sources, targets, outputs, options, run, address_of(workspace), size(workspace, &
        kind=c_size_t)), status)
  end subroutine

  subroutine thin_kernel2_bytes(terms, n_terms, own, mollifier, bytes, status)
    type(mollis_kernel_term), intent(in), target :: terms(*)
    integer, intent(in) :: n_terms
    type(mollis_radial_kernel), intent(in), target, optional :: own
    type(mollis_mollifier), value :: mollifier
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_kernel2_bytes(terms, int(n_terms, c_size_t), own, mollifier, bytes), status)
  end subroutine

  subroutine thin_kernel2_bytes_f32(terms, n_terms, own, mollifier, bytes, status)
    type(mollis_kernel_term), intent(in), target :: terms(*)
    integer, intent(in) :: n_terms
    type(mollis_radial_kernel), intent(in), target, optional :: own
    type(mollis_mollifier), value :: mollifier
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_kernel2_bytes_f32(terms, int(n_terms, c_size_t), own, mollifier, bytes), status)
  end subroutine

  subroutine thin_kernel1_bytes(terms, n_terms, own, mollifier, bytes, status)
    type(mollis_kernel_term), intent(in), target :: terms(*)
    integer, intent(in) :: n_terms
    type(mollis_radial_kernel), intent(in), target, optional :: own
    type(mollis_mollifier), value :: mollifier
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_kernel1_bytes(terms, int(n_terms, c_size_t), own, mollifier, bytes), status)
  end subroutine

  subroutine thin_kernel1_bytes_f32(terms, n_terms, own, mollifier, bytes, status)
    type(mollis_kernel_term), intent(in), target :: terms(*)
    integer, intent(in) :: n_terms
    type(mollis_radial_kernel), intent(in), target, optional :: own
    type(mollis_mollifier), value :: mollifier
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_kernel1_bytes_f32(terms, int(n_terms, c_size_t), own, mollifier, bytes), status)
  end subroutine

  subroutine thin_kernel3_bytes(terms, n_terms, own, mollifier, bytes, status)
    type(mollis_kernel_term), intent(in), target :: terms(*)
    integer, intent(in) :: n_terms
    type(mollis_radial_kernel), intent(in), target, optional :: own
    type(mollis_mollifier), value :: mollifier
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_kernel3_bytes(terms, int(n_terms, c_size_t), own, mollifier, bytes), status)
  end subroutine

  subroutine thin_kernel3_bytes_f32(terms, n_terms, own, mollifier, bytes, status)
    type(mollis_kernel_term), intent(in), target :: terms(*)
    integer, intent(in) :: n_terms
    type(mollis_radial_kernel), intent(in), target, optional :: own
    type(mollis_mollifier), value :: mollifier
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_kernel3_bytes_f32(terms, int(n_terms, c_size_t), own, mollifier, bytes), status)
  end subroutine

  subroutine thin_kernel2_prepare(kernel, terms, n_terms, own, mollifier, delta, status)
    integer(c_int8_t), intent(inout), target, contiguous :: kernel(:)
    type(mollis_kernel_term), intent(in), target :: terms(*)
    integer, intent(in) :: n_terms
    type(mollis_radial_kernel), intent(in), target, optional :: own
    type(mollis_mollifier), value :: mollifier
    real(c_double), value :: delta
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_kernel2_prepare(address_of(kernel), size(kernel, kind=c_size_t), terms, int(n_terms, c_size_t), own, &
        mollifier, delta), status)
  end subroutine

  subroutine thin_kernel2_prepare_f32(kernel, terms, n_terms, own, mollifier, delta, status)
    integer(c_int8_t), intent(inout), target, contiguous :: kernel(:)
    type(mollis_kernel_term), intent(in), target :: terms(*)
    integer, intent(in) :: n_terms
    type(mollis_radial_kernel), intent(in), target, optional :: own
    type(mollis_mollifier), value :: mollifier
    real(c_float), value :: delta
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_kernel2_prepare_f32(address_of(kernel), size(kernel, kind=c_size_t), terms, int(n_terms, c_size_t), own, &
        mollifier, delta), status)
  end subroutine

  subroutine thin_kernel1_prepare(kernel, terms, n_terms, own, mollifier, delta, status)
    integer(c_int8_t), intent(inout), target, contiguous :: kernel(:)
    type(mollis_kernel_term), intent(in), target :: terms(*)
    integer, intent(in) :: n_terms
    type(mollis_radial_kernel), intent(in), target, optional :: own
    type(mollis_mollifier), value :: mollifier
    real(c_double), value :: delta
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_kernel1_prepare(address_of(kernel), size(kernel, kind=c_size_t), terms, int(n_terms, c_size_t), own, &
        mollifier, delta), status)
  end subroutine

  subroutine thin_kernel1_prepare_f32(kernel, terms, n_terms, own, mollifier, delta, status)
    integer(c_int8_t), intent(inout), target, contiguous :: kernel(:)
    type(mollis_kernel_term), intent(in), target :: terms(*)
    integer, intent(in) :: n_terms
    type(mollis_radial_kernel), intent(in), target, optional :: own
    type(mollis_mollifier), value :: mollifier
    real(c_float), value :: delta
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_kernel1_prepare_f32(address_of(kernel), size(kernel, kind=c_size_t), terms, int(n_terms, c_size_t), own, &
        mollifier, delta), status)
  end subroutine

  subroutine thin_kernel3_prepare(kernel, terms, n_terms, own, mollifier, delta, status)
    integer(c_int8_t), intent(inout), target, contiguous :: kernel(:)
    type(mollis_kernel_term), intent(in), target :: terms(*)
    integer, intent(in) :: n_terms
    type(mollis_radial_kernel), intent(in), target, optional :: own
    type(mollis_mollifier), value :: mollifier
    real(c_double), value :: delta
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_kernel3_prepare(address_of(kernel), size(kernel, kind=c_size_t), terms, int(n_terms, c_size_t), own, &
        mollifier, delta), status)
  end subroutine

  subroutine thin_kernel3_prepare_f32(kernel, terms, n_terms, own, mollifier, delta, status)
    integer(c_int8_t), intent(inout), target, contiguous :: kernel(:)
    type(mollis_kernel_term), intent(in), target :: terms(*)
    integer, intent(in) :: n_terms
    type(mollis_radial_kernel), intent(in), target, optional :: own
    type(mollis_mollifier), value :: mollifier
    real(c_float), value :: delta
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_kernel3_prepare_f32(address_of(kernel), size(kernel, kind=c_size_t), terms, int(n_terms, c_size_t), own, &
        mollifier, delta), status)
  end subroutine

  subroutine thin_kernel2_eval(kernel, n, r, value, gradient_factor, laplacian, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    integer, intent(in) :: n
    real(c_double), intent(in) :: r(*)
    real(c_double), intent(inout), optional :: value(*)
    real(c_double), intent(inout), optional :: gradient_factor(*)
    real(c_double), intent(inout), optional :: laplacian(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_kernel2_eval(address_of(kernel), size(kernel, kind=c_size_t), int(n, c_size_t), r, value, gradient_factor, &
        laplacian), status)
  end subroutine

  subroutine thin_kernel2_eval_f32(kernel, n, r, value, gradient_factor, laplacian, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    integer, intent(in) :: n
    real(c_float), intent(in) :: r(*)
    real(c_float), intent(inout), optional :: value(*)
    real(c_float), intent(inout), optional :: gradient_factor(*)
    real(c_float), intent(inout), optional :: laplacian(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_kernel2_eval_f32(address_of(kernel), size(kernel, kind=c_size_t), int(n, c_size_t), r, value, &
        gradient_factor, laplacian), status)
  end subroutine

  subroutine thin_kernel1_eval(kernel, n, r, value, gradient_factor, laplacian, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    integer, intent(in) :: n
    real(c_double), intent(in) :: r(*)
    real(c_double), intent(inout), optional :: value(*)
    real(c_double), intent(inout), optional :: gradient_factor(*)
    real(c_double), intent(inout), optional :: laplacian(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_kernel1_eval(address_of(kernel), size(kernel, kind=c_size_t), int(n, c_size_t), r, value, gradient_factor, &
        laplacian), status)
  end subroutine

  subroutine thin_kernel1_eval_f32(kernel, n, r, value, gradient_factor, laplacian, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    integer, intent(in) :: n
    real(c_float), intent(in) :: r(*)
    real(c_float), intent(inout), optional :: value(*)
    real(c_float), intent(inout), optional :: gradient_factor(*)
    real(c_float), intent(inout), optional :: laplacian(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_kernel1_eval_f32(address_of(kernel), size(kernel, kind=c_size_t), int(n, c_size_t), r, value, &
        gradient_factor, laplacian), status)
  end subroutine

  subroutine thin_kernel3_eval(kernel, n, r, value, gradient_factor, laplacian, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    integer, intent(in) :: n
    real(c_double), intent(in) :: r(*)
    real(c_double), intent(inout), optional :: value(*)
    real(c_double), intent(inout), optional :: gradient_factor(*)
    real(c_double), intent(inout), optional :: laplacian(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_kernel3_eval(address_of(kernel), size(kernel, kind=c_size_t), int(n, c_size_t), r, value, gradient_factor, &
        laplacian), status)
  end subroutine

  subroutine thin_kernel3_eval_f32(kernel, n, r, value, gradient_factor, laplacian, status)
    integer(c_int8_t), intent(in), target, contiguous :: kernel(:)
    integer, intent(in) :: n
    real(c_float), intent(in) :: r(*)
    real(c_float), intent(inout), optional :: value(*)
    real(c_float), intent(inout), optional :: gradient_factor(*)
    real(c_float), intent(inout), optional :: laplacian(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_kernel3_eval_f32(address_of(kernel), size(kernel, kind=c_size_t), int(n, c_size_t), r, value, &
        gradient_factor, laplacian), status)
  end subroutine

  subroutine thin_mollifier2_eval(mollifier, delta, n, r, density, density_slope, potential, gradient_factor, hessian_factor, &
      enclosed_mass, status)
    type(mollis_mollifier), value :: mollifier
    real(c_double), value :: delta
    integer, intent(in) :: n
    real(c_double), intent(in) :: r(*)
    real(c_double), intent(inout), optional :: density(*)
    real(c_double), intent(inout), optional :: density_slope(*)
    real(c_double), intent(inout), optional :: potential(*)
    real(c_double), intent(inout), optional :: gradient_factor(*)
    real(c_double), intent(inout), optional :: hessian_factor(*)
    real(c_double), intent(inout), optional :: enclosed_mass(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier2_eval(mollifier, delta, int(n, c_size_t), r, density, density_slope, potential, gradient_factor, &
        hessian_factor, enclosed_mass), status)
  end subroutine

  subroutine thin_mollifier2_eval_f32(mollifier, delta, n, r, density, density_slope, potential, gradient_factor, hessian_factor, &
      enclosed_mass, status)
    type(mollis_mollifier), value :: mollifier
    real(c_float), value :: delta
    integer, intent(in) :: n
    real(c_float), intent(in) :: r(*)
    real(c_float), intent(inout), optional :: density(*)
    real(c_float), intent(inout), optional :: density_slope(*)
    real(c_float), intent(inout), optional :: potential(*)
    real(c_float), intent(inout), optional :: gradient_factor(*)
    real(c_float), intent(inout), optional :: hessian_factor(*)
    real(c_float), intent(inout), optional :: enclosed_mass(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier2_eval_f32(mollifier, delta, int(n, c_size_t), r, density, density_slope, potential, &
        gradient_factor, hessian_factor, enclosed_mass), status)
  end subroutine

  subroutine thin_mollifier1_eval(mollifier, delta, n, r, density, density_slope, potential, gradient_factor, hessian_factor, &
      enclosed_mass, status)
    type(mollis_mollifier), value :: mollifier
    real(c_double), value :: delta
    integer, intent(in) :: n
    real(c_double), intent(in) :: r(*)
    real(c_double), intent(inout), optional :: density(*)
    real(c_double), intent(inout), optional :: density_slope(*)
    real(c_double), intent(inout), optional :: potential(*)
    real(c_double), intent(inout), optional :: gradient_factor(*)
    real(c_double), intent(inout), optional :: hessian_factor(*)
    real(c_double), intent(inout), optional :: enclosed_mass(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier1_eval(mollifier, delta, int(n, c_size_t), r, density, density_slope, potential, gradient_factor, &
        hessian_factor, enclosed_mass), status)
  end subroutine

  subroutine thin_mollifier1_eval_f32(mollifier, delta, n, r, density, density_slope, potential, gradient_factor, hessian_factor, &
      enclosed_mass, status)
    type(mollis_mollifier), value :: mollifier
    real(c_float), value :: delta
    integer, intent(in) :: n
    real(c_float), intent(in) :: r(*)
    real(c_float), intent(inout), optional :: density(*)
    real(c_float), intent(inout), optional :: density_slope(*)
    real(c_float), intent(inout), optional :: potential(*)
    real(c_float), intent(inout), optional :: gradient_factor(*)
    real(c_float), intent(inout), optional :: hessian_factor(*)
    real(c_float), intent(inout), optional :: enclosed_mass(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier1_eval_f32(mollifier, delta, int(n, c_size_t), r, density, density_slope, potential, &
        gradient_factor, hessian_factor, enclosed_mass), status)
  end subroutine

  subroutine thin_mollifier3_eval(mollifier, delta, n, r, density, density_slope, potential, gradient_factor, hessian_factor, &
      enclosed_mass, status)
    type(mollis_mollifier), value :: mollifier
    real(c_double), value :: delta
    integer, intent(in) :: n
    real(c_double), intent(in) :: r(*)
    real(c_double), intent(inout), optional :: density(*)
    real(c_double), intent(inout), optional :: density_slope(*)
    real(c_double), intent(inout), optional :: potential(*)
    real(c_double), intent(inout), optional :: gradient_factor(*)
    real(c_double), intent(inout), optional :: hessian_factor(*)
    real(c_double), intent(inout), optional :: enclosed_mass(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier3_eval(mollifier, delta, int(n, c_size_t), r, density, density_slope, potential, gradient_factor, &
        hessian_factor, enclosed_mass), status)
  end subroutine

  subroutine thin_mollifier3_eval_f32(mollifier, delta, n, r, density, density_slope, potential, gradient_factor, hessian_factor, &
      enclosed_mass, status)
    type(mollis_mollifier), value :: mollifier
    real(c_float), value :: delta
    integer, intent(in) :: n
    real(c_float), intent(in) :: r(*)
    real(c_float), intent(inout), optional :: density(*)
    real(c_float), intent(inout), optional :: density_slope(*)
    real(c_float), intent(inout), optional :: potential(*)
    real(c_float), intent(inout), optional :: gradient_factor(*)
    real(c_float), intent(inout), optional :: hessian_factor(*)
    real(c_float), intent(inout), optional :: enclosed_mass(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier3_eval_f32(mollifier, delta, int(n, c_size_t), r, density, density_slope, potential, &
        gradient_factor, hessian_factor, enclosed_mass), status)
  end subroutine

  subroutine thin_mollifier1_heaviside(mollifier, delta, n, x, values, status)
    type(mollis_mollifier), value :: mollifier
    real(c_double), value :: delta
    integer, intent(in) :: n
    real(c_double), intent(in) :: x(*)
    real(c_double), intent(inout), optional :: values(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier1_heaviside(mollifier, delta, int(n, c_size_t), x, values), status)
  end subroutine

  subroutine thin_mollifier1_heaviside_f32(mollifier, delta, n, x, values, status)
    type(mollis_mollifier), value :: mollifier
    real(c_float), value :: delta
    integer, intent(in) :: n
    real(c_float), intent(in) :: x(*)
    real(c_float), intent(inout), optional :: values(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier1_heaviside_f32(mollifier, delta, int(n, c_size_t), x, values), status)
  end subroutine

  subroutine thin_mollifier2_moment(mollifier, delta, k, value, status)
    type(mollis_mollifier), value :: mollifier
    real(c_double), value :: delta
    integer(c_int32_t), value :: k
    real(c_double), intent(inout), optional :: value(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier2_moment(mollifier, delta, k, value), status)
  end subroutine

  subroutine thin_mollifier2_moment_f32(mollifier, delta, k, value, status)
    type(mollis_mollifier), value :: mollifier
    real(c_float), value :: delta
    integer(c_int32_t), value :: k
    real(c_float), intent(inout), optional :: value(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier2_moment_f32(mollifier, delta, k, value), status)
  end subroutine

  subroutine thin_mollifier1_moment(mollifier, delta, k, value, status)
    type(mollis_mollifier), value :: mollifier
    real(c_double), value :: delta
    integer(c_int32_t), value :: k
    real(c_double), intent(inout), optional :: value(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier1_moment(mollifier, delta, k, value), status)
  end subroutine

  subroutine thin_mollifier1_moment_f32(mollifier, delta, k, value, status)
    type(mollis_mollifier), value :: mollifier
    real(c_float), value :: delta
    integer(c_int32_t), value :: k
    real(c_float), intent(inout), optional :: value(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier1_moment_f32(mollifier, delta, k, value), status)
  end subroutine

  subroutine thin_mollifier3_moment(mollifier, delta, k, value, status)
    type(mollis_mollifier), value :: mollifier
    real(c_double), value :: delta
    integer(c_int32_t), value :: k
    real(c_double), intent(inout), optional :: value(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier3_moment(mollifier, delta, k, value), status)
  end subroutine

  subroutine thin_mollifier3_moment_f32(mollifier, delta, k, value, status)
    type(mollis_mollifier), value :: mollifier
    real(c_float), value :: delta
    integer(c_int32_t), value :: k
    real(c_float), intent(inout), optional :: value(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier3_moment_f32(mollifier, delta, k, value), status)
  end subroutine

  subroutine thin_mollifier2_field(mollifier, delta, n, x, density, potential, gradient, hessian, status)
    type(mollis_mollifier), value :: mollifier
    real(c_double), value :: delta
    integer, intent(in) :: n
    real(c_double), intent(in) :: x(2,*)
    real(c_double), intent(inout), optional :: density(*)
    real(c_double), intent(inout), optional :: potential(*)
    real(c_double), intent(inout), optional :: gradient(2,*)
    real(c_double), intent(inout), optional :: hessian(2,2,*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier2_field(mollifier, delta, int(n, c_size_t), x, density, potential, gradient, hessian), status)
  end subroutine

  subroutine thin_mollifier2_field_f32(mollifier, delta, n, x, density, potential, gradient, hessian, status)
    type(mollis_mollifier), value :: mollifier
    real(c_float), value :: delta
    integer, intent(in) :: n
    real(c_float), intent(in) :: x(2,*)
    real(c_float), intent(inout), optional :: density(*)
    real(c_float), intent(inout), optional :: potential(*)
    real(c_float), intent(inout), optional :: gradient(2,*)
    real(c_float), intent(inout), optional :: hessian(2,2,*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier2_field_f32(mollifier, delta, int(n, c_size_t), x, density, potential, gradient, hessian), status)
  end subroutine

  subroutine thin_mollifier1_field(mollifier, delta, n, x, density, potential, gradient, hessian, status)
    type(mollis_mollifier), value :: mollifier
    real(c_double), value :: delta
    integer, intent(in) :: n
    real(c_double), intent(in) :: x(1,*)
    real(c_double), intent(inout), optional :: density(*)
    real(c_double), intent(inout), optional :: potential(*)
    real(c_double), intent(inout), optional :: gradient(1,*)
    real(c_double), intent(inout), optional :: hessian(1,1,*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier1_field(mollifier, delta, int(n, c_size_t), x, density, potential, gradient, hessian), status)
  end subroutine

  subroutine thin_mollifier1_field_f32(mollifier, delta, n, x, density, potential, gradient, hessian, status)
    type(mollis_mollifier), value :: mollifier
    real(c_float), value :: delta
    integer, intent(in) :: n
    real(c_float), intent(in) :: x(1,*)
    real(c_float), intent(inout), optional :: density(*)
    real(c_float), intent(inout), optional :: potential(*)
    real(c_float), intent(inout), optional :: gradient(1,*)
    real(c_float), intent(inout), optional :: hessian(1,1,*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier1_field_f32(mollifier, delta, int(n, c_size_t), x, density, potential, gradient, hessian), status)
  end subroutine

  subroutine thin_mollifier3_field(mollifier, delta, n, x, density, potential, gradient, hessian, status)
    type(mollis_mollifier), value :: mollifier
    real(c_double), value :: delta
    integer, intent(in) :: n
    real(c_double), intent(in) :: x(3,*)
    real(c_double), intent(inout), optional :: density(*)
    real(c_double), intent(inout), optional :: potential(*)
    real(c_double), intent(inout), optional :: gradient(3,*)
    real(c_double), intent(inout), optional :: hessian(3,3,*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier3_field(mollifier, delta, int(n, c_size_t), x, density, potential, gradient, hessian), status)
  end subroutine

  subroutine thin_mollifier3_field_f32(mollifier, delta, n, x, density, potential, gradient, hessian, status)
    type(mollis_mollifier), value :: mollifier
    real(c_float), value :: delta
    integer, intent(in) :: n
    real(c_float), intent(in) :: x(3,*)
    real(c_float), intent(inout), optional :: density(*)
    real(c_float), intent(inout), optional :: potential(*)
    real(c_float), intent(inout), optional :: gradient(3,*)
    real(c_float), intent(inout), optional :: hessian(3,3,*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier3_field_f32(mollifier, delta, int(n, c_size_t), x, density, potential, gradient, hessian), status)
  end subroutine

  subroutine thin_mollifier2_richardson(mollifier, delta, n_radii, radii, weights, n, r, density, density_slope, potential, &
      gradient_factor, hessian_factor, enclosed_mass, status)
    type(mollis_mollifier), value :: mollifier
    real(c_double), value :: delta
    integer, intent(in) :: n_radii
    real(c_double), intent(in) :: radii(*)
    real(c_double), intent(inout), optional :: weights(*)
    integer, intent(in) :: n
    real(c_double), intent(in) :: r(*)
    real(c_double), intent(inout), optional :: density(*)
    real(c_double), intent(inout), optional :: density_slope(*)
    real(c_double), intent(inout), optional :: potential(*)
    real(c_double), intent(inout), optional :: gradient_factor(*)
    real(c_double), intent(inout), optional :: hessian_factor(*)
    real(c_double), intent(inout), optional :: enclosed_mass(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier2_richardson(mollifier, delta, int(n_radii, c_size_t), radii, weights, int(n, c_size_t), r, &
        density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass), status)
  end subroutine

  subroutine thin_mollifier2_richardson_f32(mollifier, delta, n_radii, radii, weights, n, r, density, density_slope, potential, &
      gradient_factor, hessian_factor, enclosed_mass, status)
    type(mollis_mollifier), value :: mollifier
    real(c_float), value :: delta
    integer, intent(in) :: n_radii
    real(c_float), intent(in) :: radii(*)
    real(c_float), intent(inout), optional :: weights(*)
    integer, intent(in) :: n
    real(c_float), intent(in) :: r(*)
    real(c_float), intent(inout), optional :: density(*)
    real(c_float), intent(inout), optional :: density_slope(*)
    real(c_float), intent(inout), optional :: potential(*)
    real(c_float), intent(inout), optional :: gradient_factor(*)
    real(c_float), intent(inout), optional :: hessian_factor(*)
    real(c_float), intent(inout), optional :: enclosed_mass(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier2_richardson_f32(mollifier, delta, int(n_radii, c_size_t), radii, weights, int(n, c_size_t), r, &
        density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass), status)
  end subroutine

  subroutine thin_mollifier1_richardson(mollifier, delta, n_radii, radii, weights, n, r, density, density_slope, potential, &
      gradient_factor, hessian_factor, enclosed_mass, status)
    type(mollis_mollifier), value :: mollifier
    real(c_double), value :: delta
    integer, intent(in) :: n_radii
    real(c_double), intent(in) :: radii(*)
    real(c_double), intent(inout), optional :: weights(*)
    integer, intent(in) :: n
    real(c_double), intent(in) :: r(*)
    real(c_double), intent(inout), optional :: density(*)
    real(c_double), intent(inout), optional :: density_slope(*)
    real(c_double), intent(inout), optional :: potential(*)
    real(c_double), intent(inout), optional :: gradient_factor(*)
    real(c_double), intent(inout), optional :: hessian_factor(*)
    real(c_double), intent(inout), optional :: enclosed_mass(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier1_richardson(mollifier, delta, int(n_radii, c_size_t), radii, weights, int(n, c_size_t), r, &
        density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass), status)
  end subroutine

  subroutine thin_mollifier1_richardson_f32(mollifier, delta, n_radii, radii, weights, n, r, density, density_slope, potential, &
      gradient_factor, hessian_factor, enclosed_mass, status)
    type(mollis_mollifier), value :: mollifier
    real(c_float), value :: delta
    integer, intent(in) :: n_radii
    real(c_float), intent(in) :: radii(*)
    real(c_float), intent(inout), optional :: weights(*)
    integer, intent(in) :: n
    real(c_float), intent(in) :: r(*)
    real(c_float), intent(inout), optional :: density(*)
    real(c_float), intent(inout), optional :: density_slope(*)
    real(c_float), intent(inout), optional :: potential(*)
    real(c_float), intent(inout), optional :: gradient_factor(*)
    real(c_float), intent(inout), optional :: hessian_factor(*)
    real(c_float), intent(inout), optional :: enclosed_mass(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier1_richardson_f32(mollifier, delta, int(n_radii, c_size_t), radii, weights, int(n, c_size_t), r, &
        density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass), status)
  end subroutine

  subroutine thin_mollifier3_richardson(mollifier, delta, n_radii, radii, weights, n, r, density, density_slope, potential, &
      gradient_factor, hessian_factor, enclosed_mass, status)
    type(mollis_mollifier), value :: mollifier
    real(c_double), value :: delta
    integer, intent(in) :: n_radii
    real(c_double), intent(in) :: radii(*)
    real(c_double), intent(inout), optional :: weights(*)
    integer, intent(in) :: n
    real(c_double), intent(in) :: r(*)
    real(c_double), intent(inout), optional :: density(*)
    real(c_double), intent(inout), optional :: density_slope(*)
    real(c_double), intent(inout), optional :: potential(*)
    real(c_double), intent(inout), optional :: gradient_factor(*)
    real(c_double), intent(inout), optional :: hessian_factor(*)
    real(c_double), intent(inout), optional :: enclosed_mass(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier3_richardson(mollifier, delta, int(n_radii, c_size_t), radii, weights, int(n, c_size_t), r, &
        density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass), status)
  end subroutine

  subroutine thin_mollifier3_richardson_f32(mollifier, delta, n_radii, radii, weights, n, r, density, density_slope, potential, &
      gradient_factor, hessian_factor, enclosed_mass, status)
    type(mollis_mollifier), value :: mollifier
    real(c_float), value :: delta
    integer, intent(in) :: n_radii
    real(c_float), intent(in) :: radii(*)
    real(c_float), intent(inout), optional :: weights(*)
    integer, intent(in) :: n
    real(c_float), intent(in) :: r(*)
    real(c_float), intent(inout), optional :: density(*)
    real(c_float), intent(inout), optional :: density_slope(*)
    real(c_float), intent(inout), optional :: potential(*)
    real(c_float), intent(inout), optional :: gradient_factor(*)
    real(c_float), intent(inout), optional :: hessian_factor(*)
    real(c_float), intent(inout), optional :: enclosed_mass(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_mollifier3_richardson_f32(mollifier, delta, int(n_radii, c_size_t), radii, weights, int(n, c_size_t), r, &
        density, density_slope, potential, gradient_factor, hessian_factor, enclosed_mass), status)
  end subroutine

  subroutine thin_norm(n, values, cell, p, norm, status)
    integer, intent(in) :: n
    real(c_double), intent(in) :: values(*)
    real(c_double), value :: cell
    real(c_double), value :: p
    real(c_double), intent(inout), optional :: norm
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_norm(int(n, c_size_t), values, cell, p, norm), status)
  end subroutine

  subroutine thin_norm_f32(n, values, cell, p, norm, status)
    integer, intent(in) :: n
    real(c_float), intent(in) :: values(*)
    real(c_float), value :: cell
    real(c_float), value :: p
    real(c_float), intent(inout), optional :: norm
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_norm_f32(int(n, c_size_t), values, cell, p, norm), status)
  end subroutine

  subroutine thin_distance_norm2(n, a, b, cell, p, norm, status)
    integer, intent(in) :: n
    real(c_double), intent(in) :: a(2,*)
    real(c_double), intent(in) :: b(2,*)
    real(c_double), value :: cell
    real(c_double), value :: p
    real(c_double), intent(inout), optional :: norm
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_distance_norm2(int(n, c_size_t), a, b, cell, p, norm), status)
  end subroutine

  subroutine thin_distance_norm2_f32(n, a, b, cell, p, norm, status)
    integer, intent(in) :: n
    real(c_float), intent(in) :: a(2,*)
    real(c_float), intent(in) :: b(2,*)
    real(c_float), value :: cell
    real(c_float), value :: p
    real(c_float), intent(inout), optional :: norm
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_distance_norm2_f32(int(n, c_size_t), a, b, cell, p, norm), status)
  end subroutine

  subroutine thin_distance_norm1(n, a, b, cell, p, norm, status)
    integer, intent(in) :: n
    real(c_double), intent(in) :: a(1,*)
    real(c_double), intent(in) :: b(1,*)
    real(c_double), value :: cell
    real(c_double), value :: p
    real(c_double), intent(inout), optional :: norm
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_distance_norm1(int(n, c_size_t), a, b, cell, p, norm), status)
  end subroutine

  subroutine thin_distance_norm1_f32(n, a, b, cell, p, norm, status)
    integer, intent(in) :: n
    real(c_float), intent(in) :: a(1,*)
    real(c_float), intent(in) :: b(1,*)
    real(c_float), value :: cell
    real(c_float), value :: p
    real(c_float), intent(inout), optional :: norm
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_distance_norm1_f32(int(n, c_size_t), a, b, cell, p, norm), status)
  end subroutine

  subroutine thin_distance_norm3(n, a, b, cell, p, norm, status)
    integer, intent(in) :: n
    real(c_double), intent(in) :: a(3,*)
    real(c_double), intent(in) :: b(3,*)
    real(c_double), value :: cell
    real(c_double), value :: p
    real(c_double), intent(inout), optional :: norm
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_distance_norm3(int(n, c_size_t), a, b, cell, p, norm), status)
  end subroutine

  subroutine thin_distance_norm3_f32(n, a, b, cell, p, norm, status)
    integer, intent(in) :: n
    real(c_float), intent(in) :: a(3,*)
    real(c_float), intent(in) :: b(3,*)
    real(c_float), value :: cell
    real(c_float), value :: p
    real(c_float), intent(inout), optional :: norm
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_distance_norm3_f32(int(n, c_size_t), a, b, cell, p, norm), status)
  end subroutine

  subroutine thin_sobolev_norm2(points, spacing, p, values, norm, status)
    integer(c_size_t), intent(in) :: points(2)
    real(c_double), value :: spacing
    real(c_double), value :: p
    real(c_double), intent(in) :: values(*)
    real(c_double), intent(inout), optional :: norm
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_sobolev_norm2(points, spacing, p, values, norm), status)
  end subroutine

  subroutine thin_sobolev_norm2_f32(points, spacing, p, values, norm, status)
    integer(c_size_t), intent(in) :: points(2)
    real(c_float), value :: spacing
    real(c_float), value :: p
    real(c_float), intent(in) :: values(*)
    real(c_float), intent(inout), optional :: norm
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_sobolev_norm2_f32(points, spacing, p, values, norm), status)
  end subroutine

  subroutine thin_sobolev_norm1(points, spacing, p, values, norm, status)
    integer(c_size_t), intent(in) :: points(1)
    real(c_double), value :: spacing
    real(c_double), value :: p
    real(c_double), intent(in) :: values(*)
    real(c_double), intent(inout), optional :: norm
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_sobolev_norm1(points, spacing, p, values, norm), status)
  end subroutine

  subroutine thin_sobolev_norm1_f32(points, spacing, p, values, norm, status)
    integer(c_size_t), intent(in) :: points(1)
    real(c_float), value :: spacing
    real(c_float), value :: p
    real(c_float), intent(in) :: values(*)
    real(c_float), intent(inout), optional :: norm
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_sobolev_norm1_f32(points, spacing, p, values, norm), status)
  end subroutine

  subroutine thin_sobolev_norm3(points, spacing, p, values, norm, status)
    integer(c_size_t), intent(in) :: points(3)
    real(c_double), value :: spacing
    real(c_double), value :: p
    real(c_double), intent(in) :: values(*)
    real(c_double), intent(inout), optional :: norm
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_sobolev_norm3(points, spacing, p, values, norm), status)
  end subroutine

  subroutine thin_sobolev_norm3_f32(points, spacing, p, values, norm, status)
    integer(c_size_t), intent(in) :: points(3)
    real(c_float), value :: spacing
    real(c_float), value :: p
    real(c_float), intent(in) :: values(*)
    real(c_float), intent(inout), optional :: norm
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_sobolev_norm3_f32(points, spacing, p, values, norm), status)
  end subroutine

  subroutine thin_dual_norm2_workspace_bytes(points, margin, bytes, status)
    integer(c_size_t), intent(in) :: points(2)
    integer, intent(in) :: margin
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_dual_norm2_workspace_bytes(points, int(margin, c_size_t), bytes), status)
  end subroutine

  subroutine thin_dual_norm2_workspace_bytes_f32(points, margin, bytes, status)
    integer(c_size_t), intent(in) :: points(2)
    integer, intent(in) :: margin
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_dual_norm2_workspace_bytes_f32(points, int(margin, c_size_t), bytes), status)
  end subroutine

  subroutine thin_dual_norm1_workspace_bytes(points, margin, bytes, status)
    integer(c_size_t), intent(in) :: points(1)
    integer, intent(in) :: margin
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_dual_norm1_workspace_bytes(points, int(margin, c_size_t), bytes), status)
  end subroutine

  subroutine thin_dual_norm1_workspace_bytes_f32(points, margin, bytes, status)
    integer(c_size_t), intent(in) :: points(1)
    integer, intent(in) :: margin
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_dual_norm1_workspace_bytes_f32(points, int(margin, c_size_t), bytes), status)
  end subroutine

  subroutine thin_dual_norm3_workspace_bytes(points, margin, bytes, status)
    integer(c_size_t), intent(in) :: points(3)
    integer, intent(in) :: margin
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_dual_norm3_workspace_bytes(points, int(margin, c_size_t), bytes), status)
  end subroutine

  subroutine thin_dual_norm3_workspace_bytes_f32(points, margin, bytes, status)
    integer(c_size_t), intent(in) :: points(3)
    integer, intent(in) :: margin
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_dual_norm3_workspace_bytes_f32(points, int(margin, c_size_t), bytes), status)
  end subroutine

  subroutine thin_dual_norm2(points, spacing, margin, values, norm, workspace, status)
    integer(c_size_t), intent(in) :: points(2)
    real(c_double), value :: spacing
    integer, intent(in) :: margin
    real(c_double), intent(in) :: values(*)
    real(c_double), intent(inout), optional :: norm
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_dual_norm2(points, spacing, int(margin, c_size_t), values, norm, address_of(workspace), size(workspace, &
        kind=c_size_t)), status)
  end subroutine

  subroutine thin_dual_norm2_f32(points, spacing, margin, values, norm, workspace, status)
    integer(c_size_t), intent(in) :: points(2)
    real(c_float), value :: spacing
    integer, intent(in) :: margin
    real(c_float), intent(in) :: values(*)
    real(c_float), intent(inout), optional :: norm
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_dual_norm2_f32(points, spacing, int(margin, c_size_t), values, norm, address_of(workspace), size(workspace, &
        kind=c_size_t)), status)
  end subroutine

  subroutine thin_dual_norm1(points, spacing, margin, values, norm, workspace, status)
    integer(c_size_t), intent(in) :: points(1)
    real(c_double), value :: spacing
    integer, intent(in) :: margin
    real(c_double), intent(in) :: values(*)
    real(c_double), intent(inout), optional :: norm
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_dual_norm1(points, spacing, int(margin, c_size_t), values, norm, address_of(workspace), size(workspace, &
        kind=c_size_t)), status)
  end subroutine

  subroutine thin_dual_norm1_f32(points, spacing, margin, values, norm, workspace, status)
    integer(c_size_t), intent(in) :: points(1)
    real(c_float), value :: spacing
    integer, intent(in) :: margin
    real(c_float), intent(in) :: values(*)
    real(c_float), intent(inout), optional :: norm
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_dual_norm1_f32(points, spacing, int(margin, c_size_t), values, norm, address_of(workspace), size(workspace, &
        kind=c_size_t)), status)
  end subroutine

  subroutine thin_dual_norm3(points, spacing, margin, values, norm, workspace, status)
    integer(c_size_t), intent(in) :: points(3)
    real(c_double), value :: spacing
    integer, intent(in) :: margin
    real(c_double), intent(in) :: values(*)
    real(c_double), intent(inout), optional :: norm
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_dual_norm3(points, spacing, int(margin, c_size_t), values, norm, address_of(workspace), size(workspace, &
        kind=c_size_t)), status)
  end subroutine

  subroutine thin_dual_norm3_f32(points, spacing, margin, values, norm, workspace, status)
    integer(c_size_t), intent(in) :: points(3)
    real(c_float), value :: spacing
    integer, intent(in) :: margin
    real(c_float), intent(in) :: values(*)
    real(c_float), intent(inout), optional :: norm
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_dual_norm3_f32(points, spacing, int(margin, c_size_t), values, norm, address_of(workspace), size(workspace, &
        kind=c_size_t)), status)
  end subroutine

  subroutine thin_first_bad(n, each, values, first, status)
    integer, intent(in) :: n
    integer, intent(in) :: each
    real(c_double), intent(in) :: values(*)
    integer(c_int64_t), intent(inout), optional :: first
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_first_bad(int(n, c_size_t), int(each, c_size_t), values, first), status)
  end subroutine

  subroutine thin_first_bad_f32(n, each, values, first, status)
    integer, intent(in) :: n
    integer, intent(in) :: each
    real(c_float), intent(in) :: values(*)
    integer(c_int64_t), intent(inout), optional :: first
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_first_bad_f32(int(n, c_size_t), int(each, c_size_t), values, first), status)
  end subroutine

  subroutine thin_pks_workspace_bytes(room, attraction, options, run, bytes, status)
    integer, intent(in) :: room
    type(mollis_pks_attraction), intent(in), target :: attraction
    type(mollis_pks_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_pks_workspace_bytes(int(room, c_size_t), attraction, options, run, bytes), status)
  end subroutine

  subroutine thin_pks_workspace_bytes_f32(room, attraction, options, run, bytes, status)
    integer, intent(in) :: room
    type(mollis_pks_attraction), intent(in), target :: attraction
    type(mollis_pks_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_size_t), intent(inout) :: bytes
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_pks_workspace_bytes_f32(int(room, c_size_t), attraction, options, run, bytes), status)
  end subroutine

  subroutine thin_pks_step(particles, progress, attraction, generator, dt, steps, events, options, run, workspace, report, status)
    type(mollis_pks_particles), intent(in), target :: particles
    type(mollis_pks_progress), intent(inout), target :: progress
    type(mollis_pks_attraction), intent(in), target :: attraction
    type(mollis_generator), intent(in), target, optional :: generator
    real(c_double), value :: dt
    integer, intent(in) :: steps
    type(mollis_pks_events), intent(inout), target :: events
    type(mollis_pks_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    type(mollis_pks_report), intent(inout), target, optional :: report
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_pks_step(particles, progress, attraction, generator, dt, int(steps, c_size_t), events, options, run, &
        address_of(workspace), size(workspace, kind=c_size_t), report), status)
  end subroutine

  subroutine thin_pks_step_f32(particles, progress, attraction, generator, dt, steps, events, options, run, workspace, report, &
      status)
    type(mollis_pks_particles_f32), intent(in), target :: particles
    type(mollis_pks_progress), intent(inout), target :: progress
    type(mollis_pks_attraction), intent(in), target :: attraction
    type(mollis_generator), intent(in), target, optional :: generator
    real(c_double), value :: dt
    integer, intent(in) :: steps
    type(mollis_pks_events), intent(inout), target :: events
    type(mollis_pks_options), intent(in), target, optional :: options
    type(mollis_run), intent(in), target, optional :: run
    integer(c_int8_t), intent(inout), target, contiguous :: workspace(:)
    type(mollis_pks_report), intent(inout), target, optional :: report
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_pks_step_f32(particles, progress, attraction, generator, dt, int(steps, c_size_t), events, options, run, &
        address_of(workspace), size(workspace, kind=c_size_t), report), status)
  end subroutine

  subroutine thin_philox_normals(seed, n, labels, step, substep, normals, status)
    integer(c_int64_t), value :: seed
    integer, intent(in) :: n
    integer(c_int64_t), intent(in) :: labels(*)
    integer(c_int32_t), value :: step
    integer(c_int32_t), value :: substep
    real(c_double), intent(inout), optional :: normals(2,*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_philox_normals(seed, int(n, c_size_t), labels, step, substep, normals), status)
  end subroutine

  subroutine thin_philox_normals_f32(seed, n, labels, step, substep, normals, status)
    integer(c_int64_t), value :: seed
    integer, intent(in) :: n
    integer(c_int64_t), intent(in) :: labels(*)
    integer(c_int32_t), value :: step
    integer(c_int32_t), value :: substep
    real(c_float), intent(inout), optional :: normals(2,*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_philox_normals_f32(seed, int(n, c_size_t), labels, step, substep, normals), status)
  end subroutine

  subroutine thin_normals(n, words, out, status)
    integer, intent(in) :: n
    integer(c_int64_t), intent(in) :: words(*)
    real(c_double), intent(inout), optional :: out(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_normals(int(n, c_size_t), words, out), status)
  end subroutine

  subroutine thin_normals_f32(n, words, out, status)
    integer, intent(in) :: n
    integer(c_int64_t), intent(in) :: words(*)
    real(c_float), intent(inout), optional :: out(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_normals_f32(int(n, c_size_t), words, out), status)
  end subroutine

  subroutine thin_grid2_options_init(options, status)
    type(mollis_grid2_options), intent(inout), target :: options
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_grid2_options_init(options, c_sizeof(options)), status)
  end subroutine

  subroutine thin_pks_options_init(options, status)
    type(mollis_pks_options), intent(inout), target :: options
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_pks_options_init(options, c_sizeof(options)), status)
  end subroutine

  subroutine thin_pks_predict(mass, mu, chi, second_moment, n_heavy, heavy, out, status)
    real(c_double), value :: mass
    real(c_double), value :: mu
    real(c_double), value :: chi
    real(c_double), value :: second_moment
    integer, intent(in) :: n_heavy
    real(c_double), intent(in) :: heavy(*)
    type(mollis_pks_prediction), intent(inout), target :: out
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_pks_predict(mass, mu, chi, second_moment, int(n_heavy, c_size_t), heavy, out), status)
  end subroutine

  subroutine thin_pks_index(n, masses, chi, noise, gamma, index, status)
    integer, intent(in) :: n
    real(c_double), intent(in) :: masses(*)
    real(c_double), value :: chi
    real(c_double), value :: noise
    real(c_double), value :: gamma
    real(c_double), intent(inout), optional :: index(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_pks_index(int(n, c_size_t), masses, chi, noise, gamma, index), status)
  end subroutine

  subroutine thin_pks_represent_species(n, species, chi, particles, share, noise, rate, status)
    integer, intent(in) :: n
    type(mollis_pks_species), intent(in), target :: species(*)
    real(c_double), value :: chi
    integer, intent(in) :: particles
    real(c_double), intent(inout), optional :: share(*)
    real(c_double), intent(inout), optional :: noise
    real(c_double), intent(inout), optional :: rate
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_pks_represent_species(int(n, c_size_t), species, chi, int(particles, c_size_t), share, noise, rate), status)
  end subroutine

  subroutine thin_philox_words(seed, label, step, substep, n, out, status)
    integer(c_int64_t), value :: seed
    integer(c_int64_t), value :: label
    integer(c_int32_t), value :: step
    integer(c_int32_t), value :: substep
    integer, intent(in) :: n
    integer(c_int64_t), intent(inout), optional :: out(*)
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_philox_words(seed, label, step, substep, int(n, c_size_t), out), status)
  end subroutine

  subroutine thin_run_init(run, status)
    type(mollis_run), intent(inout), target :: run
    integer(c_int32_t), intent(out), optional :: status
    call tell(mollis_run_init(run, c_sizeof(run)), status)
  end subroutine
end module
