!> The limits of what is computed with, each once and with its reason, and the predicates that ask them. Numbers are in
!> SI units. Keys (`nutate_keys`), states and steps (`nutate_range`) refer to them, and thereby scene files, C,
!> FORTRAN 77 and Python.
module nutate_limits
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_kinds, only: wp
   implicit none
   private

   public :: greatest_number, least_number, least_size, greatest_length, least_length, greatest_step, least_step, &
      greatest_turn, most_steps, same_time, whole_tolerance, attitude_tolerance, manifold_tolerance, greatest_norm, &
      least_norm, least_momentum, greatest_power, least_power, most_wheels
   public :: is_moderate, is_direction, is_unit, is_step, is_same_time, is_countable, in_words

   !> Any number that is given, and the momentum, energy and torque that follow: the square of such a number and the
   !> product of three stay finite. The power of ten is for those who read decimals.
   real(wp), parameter :: greatest_number = 1e100_wp
   integer, parameter :: greatest_power = 100
   !> What is set once is zero or at least this: one next to the denormal numbers, below 2.2e-308, would lose digits as
   !> soon as it is multiplied.
   real(wp), parameter :: least_number = 1e-300_wp
   integer, parameter :: least_power = -300
   !> What is divided by (moments, masses, tolerances, the longest component of a direction): its reciprocal is a number
   !> within the limit, its square no denormal one.
   real(wp), parameter :: least_size = 1/greatest_number
   !> Lengths of a shape, m: its volume is a number of 1e-90 to 1e90.
   real(wp), parameter :: least_length = 1e-30_wp, greatest_length = 1e30_wp
   !> Steps, s: their squares are numbers of 1e-100 to 1e100.
   real(wp), parameter :: least_step = 1e-50_wp, greatest_step = 1e50_wp
   !> Angle that the body turns in a step, rad: beyond it less than half of the digits of its direction are left.
   real(wp), parameter :: greatest_turn = 1e8_wp
   !> Steps, or rows, of a run: a double counts them one by one up to here.
   real(wp), parameter :: most_steps = 2.0_wp**53
   !> How far a time may be from the end of a step, in steps, or from a row, in intervals, and be meant to be the same:
   !> far above what rounding leaves of times that were meant to be whole numbers of them, far below any part of a step
   !> that makes a difference.
   real(wp), parameter :: same_time = 1e-9_wp
   !> The same for the time of a state that a run put to the end of a step, t0 + kΔt, and that to which the step came by
   !> its own sum: rounding tells them apart by 1e-6 of a step a thousand million steps away from t0.
   real(wp), parameter :: same_end = 1e-6_wp
   !> How far a quotient of two times may be from the whole number that is meant, relative to it: both are given with
   !> ten digits.
   real(wp), parameter :: whole_tolerance = 1e-9_wp
   !> How far |q| of a quaternion that is given may be from 1, q·p over |p| from 0, and a matrix from an orthogonal one:
   !> numbers typed with seven digits.
   real(wp), parameter :: attitude_tolerance = 1e-6_wp
   !> How far qᵀq of a state may be from 1 and q·p over |p| from 0 that is taken as it is, without being normalised, by
   !> methods that have no equations for them: a state that steps have led to is nearer by far, one that was typed not.
   real(wp), parameter :: manifold_tolerance = 1e-9_wp
   !> |q| of a state in mid-run of the eight equations, which carry |q| as it comes: with a q·p that is not zero it
   !> grows, but a factor of two is no growth that steps have led to.
   real(wp), parameter :: least_norm = 0.5_wp, greatest_norm = 2.0_wp
   !> Largest component of a momentum that is not zero, N m s: below it all of them are denormal and have lost digits.
   real(wp), parameter :: least_momentum = tiny(1.0_wp)
   !> Wheels of a body: every state has room for so many, since nothing is allocated in a step. Spacecraft have three to
   !> six.
   integer, parameter :: most_wheels = 6

contains

   !> Finite, and not larger than can be computed with.
   elemental logical function is_moderate(x)
      real(wp), intent(in) :: x
      is_moderate = ieee_is_finite(x)
      if (is_moderate) is_moderate = abs(x) <= greatest_number
   end function is_moderate

   !> True for two times of the end of one step that only rounding tells apart.
   pure logical function is_same_time(t, other, step)
      !> s, the step of either sign.
      real(wp), intent(in) :: t, other, step
      is_same_time = abs(t - other) <= same_end*abs(step) + 4*spacing(other)
   end function is_same_time

   !> A vector long enough to have a direction.
   pure logical function is_direction(v)
      !> Shape (any).
      real(wp), intent(in) :: v(:)
      is_direction = all(is_moderate(v))
      if (is_direction) is_direction = any(abs(v) >= least_size)
   end function is_direction

   !> A quaternion of unit length, | |q| - 1 | <= tolerance.
   pure logical function is_unit(q, tolerance)
      !> Shape (4).
      real(wp), intent(in) :: q(4), tolerance
      is_unit = all(is_moderate(q))
      ! No component of a unit quaternion is longer: the sum of squares below is harmless.
      if (is_unit) is_unit = all(abs(q) <= 2.0_wp)
      if (is_unit) is_unit = abs(sqrt(q(1)**2 + q(2)**2 + q(3)**2 + q(4)**2) - 1) <= tolerance
   end function is_unit

   !> A step that is not zero and within the limits.
   elemental logical function is_step(dt)
      !> s; negative: back in time.
      real(wp), intent(in) :: dt
      is_step = ieee_is_finite(dt)
      if (is_step) is_step = abs(dt) >= least_step .and. abs(dt) <= greatest_step
   end function is_step

   !> A time has no more steps, or rows, than can be counted.
   elemental logical function is_countable(time, step)
      !> s, finite, of either sign.
      real(wp), intent(in) :: time, step
      is_countable = abs(time)/most_steps <= abs(step)
   end function is_countable

   !> A limit that is a power of ten, or two of them, as messages have it: `1e100`, `1e-50 to 1e50`.
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
