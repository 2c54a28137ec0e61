! Four uses of mollis from Fortran: the velocities of vortices that are an array of derived types, steps of vortices and of blobs that attract
! each other, and coalescing particles with a random generator of the host's own. The result is 0 if what is known of each holds.
!
! At the portable level every machine computes the same bits, and particles.c, particles.cpp and this program print the same lines.
module host
  use, intrinsic :: iso_c_binding
  implicit none

  type :: vortex
    real(c_double) :: x(2), circulation, core, velocity(2)
  end type

  integer(c_int64_t), target :: state = 88172645463325252_c_int64_t

contains

  ! Marsaglia's xorshift, as a stream of words.
  function xorshift(context, words, n) result(status) bind(c)
    type(c_ptr), value :: context
    integer(c_size_t), value :: n
    integer(c_int64_t), intent(out) :: words(n)
    integer(c_int32_t) :: status
    integer(c_int64_t), pointer :: x
    integer(c_size_t) :: k
    call c_f_pointer(context, x)
    do k = 1, n
      x = ieor(x, ishft(x, 13))
      x = ieor(x, ishft(x, -7))
      x = ieor(x, ishft(x, 17))
      words(k) = x
    end do
    status = 0
  end function
end module

program particles
  use mollis
  use host
  implicit none
  type(mollis_run) :: run
  logical :: good
  good = .true.
  call run_init(run)
  run%level = MOLLIS_LEVEL_PORTABLE
  call vortices()
  call turning()
  call blobs()
  call coalescence()
  if (.not. good) error stop 'not as known'

contains

  ! Point k of a set without a pattern.
  function place(k) result(x)
    integer, intent(in) :: k
    real(c_double) :: x(2)
    x = [mod(37 * k, 101) - 50, mod(53 * k, 103) - 51] / 64.0d0
  end function

  ! A prepared Newtonian kernel.
  subroutine newtonian(coefficient, mollifier, delta, kernel)
    real(c_double), intent(in) :: coefficient, delta
    type(mollis_mollifier), intent(in) :: mollifier
    integer(c_int8_t), allocatable, intent(out) :: kernel(:)
    type(mollis_kernel_term) :: term(1)
    integer(c_size_t) :: bytes
    term(1)%coefficient = coefficient
    call kernel2_bytes(term, 1, mollifier=mollifier, bytes=bytes)
    allocate(kernel(bytes))
    call kernel2_prepare(kernel, term, 1, mollifier=mollifier, delta=delta)
  end subroutine

  ! Two equal vortices with the core of Vatistas turn about each other with speed g d / (2 pi (d^4 + core^4)^(1/2)), d being their distance. The array
  ! is read and written where it is.
  subroutine vortices()
    type(vortex), target :: v(2)
    integer(c_int8_t), allocatable :: kernel(:), workspace(:)
    integer(c_size_t) :: bytes
    type(mollis_sources2) :: sources
    type(mollis_outputs2) :: outputs
    type(mollis_field_options) :: options
    real(c_double) :: known
    v = [vortex([0.0d0, 0.0d0], 2.0d0, 0.1d0, 0.0d0), vortex([0.5d0, 0.0d0], 2.0d0, 0.2d0, 0.0d0)]
    call newtonian(1.0d0, mollis_mollifier(kind=MOLLIS_MOLLIFIER_VATISTAS), 0.1d0, kernel)
    sources%n = size(v)
    sources%positions(1) = c_loc(v(1)%x)
    sources%stride = storage_size(v) / storage_size(v(1)%core)
    sources%masses = c_loc(v(1)%circulation)
    sources%mass_stride = sources%stride
    sources%radii = c_loc(v(1)%core)
    sources%radius_stride = sources%stride
    outputs%gradient(1) = c_loc(v(1)%velocity)
    outputs%gradient_stride = sources%stride
    call field_options_init(options)
    options%combination = [0.0d0, 1.0d0]
    call field2_workspace_bytes(kernel, sources, outputs=outputs, options=options, run=run, bytes=bytes)
    allocate(workspace(bytes))
    call field2_eval(kernel, sources, outputs=outputs, options=options, run=run, workspace=workspace)
    known = 2.0d0 * 0.5d0 / (2 * acos(-1.0d0) * sqrt(0.5d0**4 + 0.1d0**4))
    print '(a, 2es24.16)', 'vortices: velocity', v(2)%velocity
    good = good .and. abs(v(2)%velocity(2) - known) < 1d-15 .and. abs(v(2)%velocity(1)) < 1d-15
  end subroutine

  ! Two equal vortices at the distance d turn about their centre at the rate g / (pi d^2), counter-clockwise, in steps of the blob method. Its velocity
  ! is minus the gradient output of a sum, so the combination is (0, -1).
  subroutine turning()
    real(c_double), target :: x(2, 2), circulation(2)
    integer(c_int8_t), allocatable :: kernel(:), workspace(:)
    integer(c_size_t) :: bytes
    type(mollis_particles2) :: particles
    type(mollis_blob_options) :: options
    type(mollis_blob_report) :: report
    real(c_double) :: quarter
    x = reshape([0.25d0, 0.0d0, -0.25d0, 0.0d0], [2, 2])
    circulation = 2.0d0
    quarter = acos(-1.0d0) * acos(-1.0d0) / 16
    call newtonian(1.0d0, mollis_mollifier(MOLLIS_MOLLIFIER_COMPACT, 4, 5), 0.1d0, kernel)
    particles%n = 2
    particles%positions(1) = mollis_at(x)
    particles%masses = mollis_at(circulation)
    call blob_options_init(options)
    options%combination = [0.0d0, -1.0d0]
    call blob2_workspace_bytes(kernel, particles, options=options, run=run, bytes=bytes)
    allocate(workspace(bytes))
    call blob2_step(kernel, particles, dt=quarter / 50, steps=50, options=options, run=run, workspace=workspace, report=report)
    print '(a, 2es24.16)', 'a quarter of a turn: the first at', x(:, 1)
    good = good .and. report%steps == 50 .and. all(abs(x(:, 1) - [0.0d0, 0.25d0]) < 1d-7)
  end subroutine

  ! Blobs that attract each other keep their centre of mass.
  subroutine blobs()
    integer, parameter :: n = 128
    real(c_double), target :: x(2, n), mass(n)
    real(c_double) :: before(2), after(2)
    integer(c_int8_t), allocatable :: kernel(:), workspace(:)
    integer(c_size_t) :: bytes
    type(mollis_particles2) :: particles
    type(mollis_blob_report) :: report
    integer :: k
    do k = 1, n
      x(:, k) = place(k)
      mass(k) = 1.0d0 / n
    end do
    before = matmul(x, mass)
    call newtonian(1.0d0, mollis_mollifier(MOLLIS_MOLLIFIER_COMPACT, 4, 5), 0.3d0, kernel)
    particles%n = n
    particles%positions(1) = mollis_at(x)
    particles%masses = mollis_at(mass)
    call blob2_workspace_bytes(kernel, particles, run=run, bytes=bytes)
    allocate(workspace(bytes))
    call blob2_step(kernel, particles, dt=0.01d0, steps=20, run=run, workspace=workspace, report=report)
    after = matmul(x, mass)
    print '(a, i0, a, 2es24.16)', 'blobs after ', report%steps, ' steps: the last at', x(:, n)
    good = good .and. report%steps == 20 .and. all(abs(after - before) < 1d-15)
  end subroutine

  ! Particles merge, and mass is lost by rounding alone.
  subroutine coalescence()
    integer, parameter :: n = 200
    real(c_double), target :: x(2, n), mass(n)
    integer(c_int64_t), target :: labels(n), absorbed(n)
    type(mollis_pks_event), target :: log_of_merges(n)
    integer(c_int8_t), allocatable, target :: kernel(:)
    integer(c_int8_t), allocatable :: workspace(:)
    integer(c_size_t) :: bytes
    type(mollis_pks_particles) :: particles
    type(mollis_pks_progress) :: progress
    type(mollis_pks_attraction) :: attraction
    type(mollis_pks_events) :: events
    type(mollis_pks_options) :: options
    type(mollis_generator) :: generator
    real(c_double) :: total
    integer :: k
    do k = 1, n
      x(:, k) = place(k)
      mass(k) = 0.125d0
      labels(k) = k
    end do
    call newtonian(1.0d0, mollis_mollifier(MOLLIS_MOLLIFIER_COMPACT, 2, 4), 0.01d0, kernel)
    particles%room = n
    particles%positions = mollis_at(x)
    particles%masses = mollis_at(mass)
    particles%labels = c_loc(labels)
    progress%count = n
    attraction%kind = MOLLIS_PKS_ATTRACTION_SUM
    attraction%kernel = c_loc(kernel)
    attraction%kernel_bytes = size(kernel, kind=c_size_t)
    events%events = c_loc(log_of_merges)
    events%room = n
    events%labels = c_loc(absorbed)
    events%labels_room = n
    generator%state = c_loc(state)
    generator%fill = c_funloc(xorshift)
    call pks_options_init(options)
    options%chi = 3
    options%noise = 0.125d0
    call pks_workspace_bytes(n, attraction, options, run, bytes)
    allocate(workspace(bytes))
    call pks_step(particles, progress, attraction, generator, 1d-3, 20, events, options, run, workspace)
    total = sum(mass(:progress%count))
    print '(a, i0, a, i0, a, f12.9, a, 2es24.16)', 'coalescing: ', progress%count, ' particles left after ', events%written, &
        ' merges, mass ', total, ', the last at', x(:, progress%count)
    good = good .and. progress%count + events%labels_written == n .and. abs(total - 0.125d0 * n) < 1d-12 .and. events%written > 0
  end subroutine
end program
