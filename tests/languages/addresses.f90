! mollis_at has the address of the first element of scalars, arrays and sections, of any type and rank, where they are. The result is 0 if it does.
program addresses
  use mollis
  implicit none

  type :: star
    real(c_float) :: x(2), mass
  end type

  type(star), target :: stars(3)
  real(c_double), target :: one, x(2, 6), tide(2, 2, 4)
  real(c_double), allocatable, target :: field(:, :, :, :)
  integer(c_int64_t), target :: labels(5)
  integer :: failed
  failed = 0
  allocate(field(2, 3, 4, 5))
  call expect('a scalar', mollis_at(one), c_loc(one), 0)
  call expect('an element', mollis_at(x(2, 3)), c_loc(x), 5)
  call expect('points', mollis_at(x), c_loc(x), 0)
  call expect('one coordinate', mollis_at(x(2, :)), c_loc(x), 1)
  call expect('every second point', mollis_at(x(:, 2::2)), c_loc(x), 2)
  call expect('points backwards', mollis_at(x(:, 6:1:-1)), c_loc(x), 10)
  call expect('matrices', mollis_at(tide(:, :, 3:)), c_loc(tide), 8)
  call expect('an allocated array', mollis_at(field(:, :, :, 2:)), c_loc(field), 24)
  call expect('labels', mollis_at(labels(3:)), c_loc(labels), 2)
  call expect('structures', mollis_at(stars(3:)), c_loc(stars), 3)
  if (failed > 0) error stop 'addresses are wrong'
  print '(a)', 'mollis_at: as known'

contains

  ! Compares an address with one so many numbers of 8 bytes from another.
  subroutine expect(what, got, first, numbers)
    character(*), intent(in) :: what
    type(c_ptr), intent(in) :: got, first
    integer, intent(in) :: numbers
    if (transfer(got, 0_c_intptr_t) == transfer(first, 0_c_intptr_t) + 8 * numbers) return
    print '(2a)', 'mollis_at is wrong for ', what
    failed = failed + 1
  end subroutine
end program
