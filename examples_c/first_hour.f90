! An N-body code before and after: gravity in space with Plummer's softening by a plain loop and by mollis, a leapfrog loop around it, and the fast
! sum in the plane. It stops unless each agrees with a plain loop. docs/first-hour.md shows the parts; first_hour.c prints the same lines.
module nbody
  use mollis
  implicit none

  real(c_double), parameter :: pi = 3.14159265358979323846d0, G = 1

  type :: body
    real(c_double) :: x(3), v(3), a(3), mass
  end type

contains

  ! Overwrites the accelerations.
  subroutine plain(b, eps)
    type(body), intent(inout) :: b(:)
    real(c_double), intent(in) :: eps
    real(c_double) :: a(3), d(3), q
    integer :: i, j
    do i = 1, size(b)
      a = 0
      do j = 1, size(b)
        d = b(j)%x - b(i)%x
        q = sum(d**2) + eps**2
        a = a + G * b(j)%mass / (q * sqrt(q)) * d
      end do
      b(i)%a = a
    end do
  end subroutine

  ! Moves the bodies with the plain loop: kick, drift, kick.
  subroutine plain_leapfrog(b, eps, dt, steps)
    type(body), intent(inout) :: b(:)
    real(c_double), intent(in) :: eps, dt
    integer, intent(in) :: steps
    integer :: step, i
    call plain(b, eps)
    do step = 1, steps
      do i = 1, size(b)
        b(i)%v = b(i)%v + dt / 2 * b(i)%a
        b(i)%x = b(i)%x + dt * b(i)%v
      end do
      call plain(b, eps)
      do i = 1, size(b)
        b(i)%v = b(i)%v + dt / 2 * b(i)%a
      end do
    end do
  end subroutine

  ! The same by mollis. Without steps it computes the accelerations.
  subroutine leapfrog(b, eps, dt, steps)
    type(body), intent(inout), target, contiguous :: b(:)
    real(c_double), intent(in) :: eps, dt
    integer, intent(in) :: steps
    integer :: step, i
    type(mollis_kernel_term), parameter :: newtonian(1) = mollis_kernel_term(kind=MOLLIS_KERNEL_NEWTONIAN, coefficient=4 * pi * G)
    type(mollis_mollifier), parameter :: plummer = mollis_mollifier(kind=MOLLIS_MOLLIFIER_PLUMMER)
    type(mollis_sources3) :: bodies
    type(mollis_outputs3) :: outputs
    integer(c_int8_t), allocatable :: kernel(:), workspace(:)
    integer(c_size_t) :: bytes
    call kernel3_bytes(newtonian, 1, mollifier=plummer, bytes=bytes)
    allocate(kernel(bytes))
    call kernel3_prepare(kernel, newtonian, 1, mollifier=plummer, delta=eps)
    bodies%n = size(b)
    bodies%positions(1) = c_loc(b(1)%x)
    bodies%stride = storage_size(b) / storage_size(b%mass)
    bodies%masses = c_loc(b(1)%mass)
    bodies%mass_stride = bodies%stride
    outputs%gradient(1) = c_loc(b(1)%a)
    outputs%gradient_stride = bodies%stride
    outputs%factor = -1
    call field3_workspace_bytes(kernel, bodies, outputs=outputs, bytes=bytes)
    allocate(workspace(bytes))
    call field3_eval(kernel, bodies, outputs=outputs, workspace=workspace)
    ! Time stepping: kick, drift, kick. The structures point to the array, which the program moves.
    do step = 1, steps
      do i = 1, size(b)
        b(i)%v = b(i)%v + dt / 2 * b(i)%a
        b(i)%x = b(i)%x + dt * b(i)%v
      end do
      call field3_eval(kernel, bodies, outputs=outputs, workspace=workspace)
      do i = 1, size(b)
        b(i)%v = b(i)%v + dt / 2 * b(i)%a
      end do
    end do
  end subroutine

  ! Gravity in the plane, phi = G m log r, under the compact mollifier of order 2 and exponent 4.
  subroutine plain_plane(x, mass, delta, a)
    real(c_double), intent(in) :: x(:, :), mass(:), delta
    real(c_double), intent(out) :: a(:, :)
    real(c_double) :: d(2), rr, t
    integer :: i, j
    a = 0
    do i = 1, size(mass)
      do j = 1, size(mass)
        d = x(:, j) - x(:, i)
        rr = sum(d**2)
        t = max(1 - rr / delta**2, 0.0d0)
        if (rr > 0) a(:, i) = a(:, i) + G * mass(j) * (1 - t**5) / rr * d
      end do
    end do
  end subroutine

  ! The same by mollis; `text` gets the method. A tolerance of 0 asks for the sum over all pairs.
  subroutine plane(x, mass, delta, tolerance, a, text)
    real(c_double), intent(in), target, contiguous :: x(:, :), mass(:)
    real(c_double), intent(in) :: delta, tolerance
    real(c_double), intent(inout), target, contiguous :: a(:, :)
    character(len=512), intent(inout) :: text
    type(mollis_kernel_term), parameter :: newtonian(1) = mollis_kernel_term(kind=MOLLIS_KERNEL_NEWTONIAN, coefficient=2 * pi * G)
    type(mollis_mollifier), parameter :: compact = mollis_mollifier(MOLLIS_MOLLIFIER_COMPACT, 2, 4)
    type(mollis_sources2) :: bodies
    type(mollis_outputs2) :: outputs
    type(mollis_field_options) :: options
    integer(c_int8_t), allocatable, target :: kernel(:), workspace(:)
    integer(c_size_t) :: bytes
    call kernel2_bytes(newtonian, 1, mollifier=compact, bytes=bytes)
    allocate(kernel(bytes))
    call kernel2_prepare(kernel, newtonian, 1, mollifier=compact, delta=delta)
    call field_options_init(options)
    options%tolerance = tolerance
    bodies%n = size(mass)
    bodies%positions(1) = mollis_at(x)
    bodies%masses = mollis_at(mass)
    outputs%gradient(1) = mollis_at(a)
    outputs%factor = -1
    call field2_workspace_bytes(kernel, bodies, outputs=outputs, options=options, bytes=bytes)
    allocate(workspace(bytes))
    call field2_eval(kernel, bodies, outputs=outputs, options=options, workspace=workspace)
    call field2_text(kernel, bodies, outputs=outputs, options=options, text=text)
  end subroutine

  ! Stops unless numbers agree up to 10^exponent, in the l2 norm.
  subroutine check(what, got, want, exponent)
    character(*), intent(in) :: what
    real(c_double), intent(in) :: got(:, :), want(:, :)
    integer, intent(in) :: exponent
    real(c_double) :: apart
    apart = norm2(got - want) / norm2(want)
    if (.not. apart < 10.0d0**exponent) then
      print '(2a, es8.1)', what, ': differs by', apart
      error stop
    end if
    print '(2a, i0)', what, ': agrees to 1e', exponent
  end subroutine
end module

program first_hour
  use nbody
  implicit none
  integer, parameter :: n = 500, many = 2000
  type(body) :: one(n), two(n)
  real(c_double) :: x(2, many), mass(many), want(2, many), a(2, many)
  character(len=512) :: text
  integer :: i, k
  do i = 1, n
    do k = 1, 3
      one(i)%x(k) = mod(i * (0.8191725134d0 - 0.148d0 * (k - 1)), 1.0d0)
    end do
    one(i)%v = 0
    one(i)%mass = 1.0d0 / n
  end do
  two = one
  call plain(one, 0.05d0)
  call leapfrog(two, 0.05d0, 0.01d0, 0)
  call check('acceleration', columns(two%a(1), two%a(2), two%a(3)), columns(one%a(1), one%a(2), one%a(3)), -13)
  call plain_leapfrog(one, 0.05d0, 0.01d0, 20)
  call leapfrog(two, 0.05d0, 0.01d0, 20)
  call check('position after 20 steps', columns(two%x(1), two%x(2), two%x(3)), columns(one%x(1), one%x(2), one%x(3)), -13)
  call check('velocity after 20 steps', columns(two%v(1), two%v(2), two%v(3)), columns(one%v(1), one%v(2), one%v(3)), -13)

  do i = 1, many
    x(:, i) = mod(i * [0.7548776662d0, 0.5698402910d0], 1.0d0)
    mass(i) = 1.0d0 / many
  end do
  call plain_plane(x, mass, 0.02d0, want)
  call plane(x, mass, 0.02d0, 0.0d0, a, text)
  call check(text(:index(text, ' (') - 1), a, want, -13)
  call plane(x, mass, 0.02d0, 1d-6, a, text)
  call check(text(:index(text, ' (') - 1), a, want, -6)

contains

  ! Three columns beside each other.
  function columns(x, y, z) result(all)
    real(c_double), intent(in) :: x(:), y(:), z(:)
    real(c_double) :: all(size(x), 3)
    all(:, 1) = x
    all(:, 2) = y
    all(:, 3) = z
  end function
end program
