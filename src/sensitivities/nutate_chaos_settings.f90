!> Settings of indicators of chaos.
module nutate_chaos_settings
   use nutate_kinds, only: wp
   implicit none
   private

   public :: chaos_settings_t

   !> Exponents at most: one for each number of a state.
   integer, parameter, public :: most_exponents = 6
   !> Longest interval between orthonormalisations, steps: sensitivities stay far from overflow.
   integer, parameter, public :: longest_interval = 100

   !> Settings of the indicators that a run follows.
   type :: chaos_settings_t
      !> Lyapunov exponents: 1, the largest, or 6; 0: nothing is followed.
      integer :: exponents = 0
      !> Direction of the first sensitivity at the start: a rotation vector in body axes, and a change of the momentum
      !> in body axes in units of the scale of momentum; shape (6).
      real(wp) :: vector(most_exponents) = 1.0_wp
      !> Momentum that is equivalent to 1 rad, N m s; 0: |L| of the initial state.
      real(wp) :: momentum_scale = 0.0_wp
      !> Steps from one orthonormalisation to the next, and from one sample of the sums to the next.
      integer :: every = 1
   end type chaos_settings_t

end module nutate_chaos_settings
