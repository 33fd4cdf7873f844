!> Helpers that several test suites share: checks that report index, actual and expected, and reproducible random input.
!>
!> The first error of a test stands: a check after it does nothing, while those of test-drive would clear it. A test
!> therefore requires `if (allocated(error)) return` only if the code behind it would crash, and procedures that a test
!> calls declare `error` as `intent(inout)`.
module test_support
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_kinds, only: wp, pi
   use testdrive, only: error_type, fail => test_failed, new_unittest, skip_test, unittest_type, &
                        testdrive_check => check
   implicit none
   private

   public :: error_type, new_unittest, skip_test, unittest_type
   public :: check, check_close, check_below, test_failed
   public :: scene_names
   public :: draws_fewer, in_turn, is_slow_build, one_in, share_of, random_unit, random_vector, random_unit_quaternion

   !> Names of the scenes, but for those of ensembles and of events, of which one is the box again, and the switches of
   !> the other exclude an accuracy.
   character(len=26), parameter :: scene_names(13) = [character(len=26) :: &
                                                      'all_effects', 'box', 'compass', 'earth_pointing', 'fast_top', &
                                                      'gravity_gradient_satellite', 'gyrostat', 'heavy_top', &
                                                      'precessing_top', 'slowing_plate', 'spin_up', &
                                                      'spring_gyroscope', 'thrust_profile']

   !> |actual - expected| <= tolerance, element by element.
   interface check_close
      module procedure check_close_scalar
      module procedure check_close_vector
   end interface check_close

   !> Checks with the interface of test-drive.
   interface check
      module procedure check_true
      module procedure check_logical
      module procedure check_integer
      module procedure check_real
      module procedure check_character
   end interface check

contains

   subroutine check_true(error, expression, message)
      type(error_type), allocatable, intent(inout) :: error
      logical, intent(in) :: expression
      character(len=*), intent(in), optional :: message
      if (.not. allocated(error)) call testdrive_check(error, expression, message)
   end subroutine check_true

   subroutine check_logical(error, actual, expected, message)
      type(error_type), allocatable, intent(inout) :: error
      logical, intent(in) :: actual, expected
      character(len=*), intent(in), optional :: message
      if (.not. allocated(error)) call testdrive_check(error, actual, expected, message)
   end subroutine check_logical

   subroutine check_integer(error, actual, expected, message)
      type(error_type), allocatable, intent(inout) :: error
      integer, intent(in) :: actual, expected
      character(len=*), intent(in), optional :: message
      if (.not. allocated(error)) call testdrive_check(error, actual, expected, message)
   end subroutine check_integer

   !> Checks that reals agree to round-off.
   subroutine check_real(error, actual, expected, message)
      type(error_type), allocatable, intent(inout) :: error
      real(wp), intent(in) :: actual, expected
      character(len=*), intent(in), optional :: message
      if (.not. allocated(error)) call testdrive_check(error, actual, expected, message)
   end subroutine check_real

   subroutine check_character(error, actual, expected, message)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: actual, expected
      character(len=*), intent(in), optional :: message
      if (.not. allocated(error)) call testdrive_check(error, actual, expected, message)
   end subroutine check_character

   !> Fails the test, where it has not failed yet.
   subroutine test_failed(error, message, more)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: message
      character(len=*), intent(in), optional :: more
      if (.not. allocated(error)) call fail(error, message, more)
   end subroutine test_failed

   subroutine check_close_scalar(error, actual, expected, tolerance, label)
      type(error_type), allocatable, intent(inout) :: error
      real(wp), intent(in) :: actual, expected, tolerance
      character(len=*), intent(in), optional :: label
      call check_close_vector(error, [actual], [expected], tolerance, label)
   end subroutine check_close_scalar

   subroutine check_close_vector(error, actual, expected, tolerance, label)
      type(error_type), allocatable, intent(inout) :: error
      real(wp), intent(in) :: actual(:), expected(:), tolerance
      character(len=*), intent(in), optional :: label
      character(len=160) :: text
      integer :: i
      if (allocated(error)) return
      if (size(actual) /= size(expected)) then
         call test_failed(error, prefix(label)//"arrays of different length")
         return
      end if
      do i = 1, size(actual)
         ! Written so that a NaN on either side fails.
         if (.not. abs(actual(i) - expected(i)) <= tolerance) then
            write (text, '("index ",i0,": actual ",es23.16,", expected ",es23.16,", difference ",es9.2," > ",es9.2)') &
               i, actual(i), expected(i), actual(i) - expected(i), tolerance
            call test_failed(error, prefix(label)//trim(text))
            return
         end if
      end do
   end subroutine check_close_vector

   !> value <= bound; a NaN fails.
   subroutine check_below(error, value, bound, label)
      type(error_type), allocatable, intent(inout) :: error
      real(wp), intent(in) :: value, bound
      character(len=*), intent(in), optional :: label
      character(len=80) :: text
      if (value <= bound) return
      write (text, '(es12.5," is not below ",es12.5)') value, bound
      call test_failed(error, prefix(label)//trim(text))
   end subroutine check_below

   !> True under sanitizers, valgrind and flang, whose builds are slow: NUTATE_SLOW_BUILD is set in the environment.
   logical function is_slow_build()
      is_slow_build = is_set('NUTATE_SLOW_BUILD')
   end function is_slow_build

   !> One case in how many is tried, by the environment variable NUTATE_ONE_IN: 1 in `make stress`, 3 in `.ci/run`, and
   !> 18 without it, in `make test`. Slow builds try one in 3 at most.
   integer function one_in()
      character(len=12) :: text
      integer :: status
      call get_environment_variable('NUTATE_ONE_IN', text)
      read (text, *, iostat=status) one_in
      if (status /= 0) one_in = 18
      one_in = max(1, one_in)
      if (is_slow_build()) one_in = max(3, one_in)
   end function one_in

   !> The part of n cases that is tried, at least one.
   integer function share_of(n)
      integer, intent(in) :: n
      share_of = 1 + (n - 1)/one_in()
   end function share_of

   !> True for one in three successive numbers in `make test`, and for all numbers elsewhere: for loops over methods and
   !> scenes that all mean the same test.
   logical function in_turn(number)
      integer, intent(in) :: number
      in_turn = one_in() <= 3
      if (.not. in_turn) in_turn = mod(number, 3) == 0
   end function in_turn

   !> True where a part of the cases is enough: everywhere but in `make stress`.
   logical function draws_fewer()
      draws_fewer = one_in() > 1
   end function draws_fewer

   logical function is_set(name)
      character(len=*), intent(in) :: name
      integer :: length
      call get_environment_variable(name, length=length)
      is_set = length > 0
   end function is_set

   pure function prefix(label) result(text)
      character(len=*), intent(in), optional :: label
      character(len=:), allocatable :: text
      text = ""
      if (present(label)) text = label//": "
   end function prefix

   !> Uniform in (0, 1): a 64-bit xorshift generator, the same on every compiler.
   real(wp) function random_unit(seed)
      integer(int64), intent(inout) :: seed
      seed = ieor(seed, ishft(seed, 13))
      seed = ieor(seed, ishft(seed, -7))
      seed = ieor(seed, ishft(seed, 17))
      random_unit = (real(ishft(seed, -11), wp) + 0.5_wp)*2.0_wp**(-53)
   end function random_unit

   !> Returns a vector with each component uniform in (-1, 1).
   function random_vector(seed) result(v)
      integer(int64), intent(inout) :: seed
      real(wp) :: v(3)
      integer :: i
      do i = 1, 3
         v(i) = 2.0_wp*random_unit(seed) - 1.0_wp
      end do
   end function random_vector

   !> Uniform over the rotations (Shoemake 1992).
   function random_unit_quaternion(seed) result(q)
      integer(int64), intent(inout) :: seed
      real(wp) :: q(4), u, a, b
      u = random_unit(seed)
      a = 2*pi*random_unit(seed)
      b = 2*pi*random_unit(seed)
      q = [sqrt(1 - u)*sin(a), sqrt(1 - u)*cos(a), sqrt(u)*sin(b), sqrt(u)*cos(b)]
   end function random_unit_quaternion

end module test_support
