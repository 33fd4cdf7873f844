!> Estimated errors of a step.
module nutate_step_error
   use nutate_kinds, only: wp
   use nutate_limits, only: most_inner
   implicit none
   private

   public :: step_error_t

   !> Estimated error of a step, from its method; zero if the method has no estimate.
   type :: step_error_t
      !> Rotation vector of the attitude, rad; momentum, N m s, both body axes; shape (3).
      real(wp) :: rotation(3) = 0.0_wp, momentum(3) = 0.0_wp
      !> Sizes of the errors of attitude, rad, and momentum, N m s, if no direction is known, as for a series.
      real(wp) :: angle = 0.0_wp, of_momentum = 0.0_wp
      !> Momentum of each wheel, N m s; shape (most_inner).
      real(wp) :: wheels(most_inner) = 0.0_wp
      !> All works together, J.
      real(wp) :: work = 0.0_wp
      !> There is a balance of l; its excess over the state at the end of the step, and the possible error of the
      !> balance, body axes, N m s; shape (3).
      logical :: balances = .false.
      real(wp) :: balance(3) = 0.0_wp, of_balance(3) = 0.0_wp
      !> Size of the momentum, N m s, and the square of its possible error in space over the square of that size;
      !> negative if it is not known.
      real(wp) :: size = 0.0_wp, square = -1.0_wp
   end type step_error_t

end module nutate_step_error
