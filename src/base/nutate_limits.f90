!> Limits of the numbers that can be computed with, each with its reason, and the predicates that check them. Numbers
!> are in SI units. Keys (`nutate_keys`), states and steps (`nutate_range`) use them, and thereby scene files, C,
!> FORTRAN 77 and Python.
module nutate_limits
   use nutate_finite, only: is_finite
   use nutate_kinds, only: wp, pi
   implicit none
   private

   public :: greatest_number, least_number, least_size, greatest_length, least_length, greatest_step, least_step, &
      greatest_turn, most_steps, same_time, whole_tolerance, attitude_tolerance, manifold_tolerance, greatest_norm, &
      least_norm, least_momentum, greatest_power, least_power, most_rows, most_wheels, &
      most_spheres, most_inner, half_turn
   public :: is_moderate, is_direction, is_unit, is_step, is_same_time, is_countable, in_words

   !> Largest size of a number that is given, and of the momentum, energy and torque that follow: its square and the
   !> product of three such numbers stay finite. It is a power of ten for those who read decimals.
   real(wp), parameter :: greatest_number = 1e100_wp
   integer, parameter :: greatest_power = 100
   !> Smallest size of a number that is set once and is not zero: a number next to the denormal ones, below 2.2e-308,
   !> would lose digits in its first multiplication.
   real(wp), parameter :: least_number = 1e-300_wp
   integer, parameter :: least_power = -300
   !> Smallest size of a divisor (moments, masses, tolerances, the longest component of a direction): its reciprocal is
   !> within the limit, and its square is not denormal.
   real(wp), parameter :: least_size = 1/greatest_number
   !> Range of the lengths of a shape, m: its volume is a number of 1e-90 to 1e90.
   real(wp), parameter :: least_length = 1e-30_wp, greatest_length = 1e30_wp
   !> Range of the steps, s: their squares are numbers of 1e-100 to 1e100.
   real(wp), parameter :: least_step = 1e-50_wp, greatest_step = 1e50_wp
   !> Largest rotation of the body in a step, rad: beyond it less than half of the digits of its direction are left.
   real(wp), parameter :: greatest_turn = 1e8_wp
   !> Largest number of steps, or output points, of a run: a double counts them one by one up to here.
   real(wp), parameter :: most_steps = 2.0_wp**53
   !> Tolerance within which a time is the end of a step, in steps, or an output point, in intervals: far above the
   !> rounding of times that are meant as integer multiples, far below any part of a step that makes a difference.
   real(wp), parameter :: same_time = 1e-9_wp
   !> Tolerance, in steps, for the end of a step as a run sets it, t0 + kΔt, and as the step sums it: their rounding
   !> differs by 1e-6 of a step a thousand million steps away from t0.
   real(wp), parameter :: same_end = 1e-6_wp
   !> Tolerance for the quotient of two times to be an integer, relative to it: both times are given with ten digits.
   real(wp), parameter :: whole_tolerance = 1e-9_wp
   !> Tolerance for |q| = 1 of a quaternion that is given, for q·p over |p| = 0, and for a matrix to be orthogonal:
   !> numbers typed with seven digits.
   real(wp), parameter :: attitude_tolerance = 1e-6_wp
   !> Tolerance for qᵀq = 1 and q·p over |p| = 0 of a state that methods without equations for them use without
   !> normalising it: a state after a step is far closer, one that was typed is not.
   real(wp), parameter :: manifold_tolerance = 1e-9_wp
   !> Rotation from one attitude to the next from which its sense is not known, rad: half a turn, up to the rounding of
   !> attitudes in files.
   real(wp), parameter :: half_turn = pi - 1e-6_wp
   !> Range of |q| of a state in mid-run of the eight equations, which do not correct |q|: it grows if q·p is not zero,
   !> but steps do not change it by a factor of two.
   real(wp), parameter :: least_norm = 0.5_wp, greatest_norm = 2.0_wp
   !> Smallest size of the largest component of a momentum that is not zero, N m s: below it all components are denormal
   !> and have lost digits.
   real(wp), parameter :: least_momentum = tiny(1.0_wp)
   !> Largest number of wheels of a body: every state has room for so many, since no step allocates memory. Spacecraft
   !> have three to six.
   integer, parameter :: most_wheels = 6
   !> Largest number of inner spheres of a body, and of momenta inside of it, which every state has room for: one of
   !> each wheel, three of each sphere.
   integer, parameter :: most_spheres = 4, most_inner = 12

   !> Largest number of rows of a table that C passes; more are treated as an error of the caller.
   integer, parameter :: most_rows = 2**28

contains

   !> Returns true if a number is finite and not larger than `greatest_number`.
   elemental logical function is_moderate(x)
      real(wp), intent(in) :: x
      is_moderate = is_finite(x)
      if (is_moderate) is_moderate = abs(x) <= greatest_number
   end function is_moderate

   !> Returns true if two times of the end of one step differ only by rounding.
   pure logical function is_same_time(t, other, step)
      !> s, the step of either sign.
      real(wp), intent(in) :: t, other, step
      is_same_time = abs(t - other) <= same_end*abs(step) + 4*spacing(other)
   end function is_same_time

   !> Returns true if a vector is long enough to have a direction.
   pure logical function is_direction(v)
      !> Shape (any).
      real(wp), intent(in) :: v(:)
      is_direction = all(is_moderate(v))
      if (is_direction) is_direction = any(abs(v) >= least_size)
   end function is_direction

   !> Returns true if a quaternion has unit length, | |q| - 1 | <= tolerance.
   pure logical function is_unit(q, tolerance)
      !> Shape (4).
      real(wp), intent(in) :: q(4), tolerance
      is_unit = all(is_moderate(q))
      ! No component of a unit quaternion is longer: the sum of squares below is harmless.
      if (is_unit) is_unit = all(abs(q) <= 2.0_wp)
      if (is_unit) is_unit = abs(sqrt(q(1)**2 + q(2)**2 + q(3)**2 + q(4)**2) - 1) <= tolerance
   end function is_unit

   !> Returns true if a step is not zero and within the limits.
   elemental logical function is_step(dt)
      !> s; negative: back in time.
      real(wp), intent(in) :: dt
      is_step = is_finite(dt)
      if (is_step) is_step = abs(dt) >= least_step .and. abs(dt) <= greatest_step
   end function is_step

   !> Returns true if a time has no more steps, or output points, than can be counted.
   elemental logical function is_countable(time, step)
      !> s, finite, of either sign.
      real(wp), intent(in) :: time, step
      is_countable = abs(time)/most_steps <= abs(step)
   end function is_countable

   !> Returns a limit that is a power of ten, or two of them, as messages print it: `1e100`, `1e-50 to 1e50`.
   pure function in_words(limit, upper) result(words)
      real(wp), intent(in) :: limit
      real(wp), intent(in), optional :: upper
      character(len=:), allocatable :: words
      character(len=8) :: digits
      write (digits, '("1e",i0)') nint(log10(limit))
      words = trim(digits)
      if (.not. present(upper)) return
      write (digits, '("1e",i0)') nint(log10(upper))
      words = words//' to '//trim(digits)
   end function in_words

end module nutate_limits
