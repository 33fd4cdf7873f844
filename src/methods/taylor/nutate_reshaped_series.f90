!> Power series of what changes of the body, of its inertia and its centre of mass, add to the torque of potentials, and
!> of the power of a change of the inertia.
module nutate_reshaped_series
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp
   use nutate_power_series, only: highest_order
   use nutate_quaternion, only: cross
   use nutate_small_products, only: deviator, skew, times_columns, times_vector
   implicit none
   private

   public :: reshaped_series_t, degree, inertia_push, transported_power

   !> Degree of the polynomials by which a body changes.
   integer, parameter :: degree = 3

   !> The changes of all potentials in one series.
   type :: reshaped_series_t
      !> Coefficients of E, without its isotropic part, and of -e; shapes (3,3, 0:degree, number of potentials) and (3,
      !> 0:degree, number of potentials).
      real(wp), allocatable :: stiffness(:, :, :, :), push(:, :, :)
      !> Series of Eγ - e, body axes; shape (3, 0:highest_order, number of potentials).
      real(wp), allocatable, private :: gradient(:, :, :)
   contains
      !> Allocates for the effects of a system.
      procedure :: prepare
      !> Computes the coefficients of E and e.
      procedure :: expand
      !> Computes a coefficient of the torque, and of its derivative with respect to γ.
      procedure :: get_torque
      procedure :: derivative
   end type reshaped_series_t

contains

   !> Allocates for the effects of a system; called once.
   pure subroutine prepare(self, effects)
      class(reshaped_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      associate (n => effects%n_potentials)
         allocate (self%stiffness(3, 3, 0:degree, n), self%push(3, 0:degree, n), &
                   self%gradient(3, 0:highest_order, n), source=0.0_wp)
      end associate
   end subroutine prepare

   !> Computes the coefficients of E and e of one potential.
   pure subroutine expand(self, effects, i, t, moment, time_unit)
      use nutate_reshaped_potential, only: potential_term
      class(reshaped_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> Index of the potential.
      integer, intent(in) :: i
      !> Start of the series, a time inside of the step, and unit of time, s.
      real(wp), intent(in) :: t, moment, time_unit
      integer :: j
      do j = 0, degree
         call potential_term(effects, i, j, t, moment, time_unit, self%stiffness(:, :, j, i), self%push(:, j, i))
         self%stiffness(:, :, j, i) = deviator(self%stiffness(:, :, j, i))
      end do
   end subroutine expand

   !> Computes coefficient k of γ×(Eγ - e) of one potential from those of γ.
   pure subroutine get_torque(self, i, k, gamma, tau)
      class(reshaped_series_t), intent(inout) :: self
      !> Index of the potential; coefficient: 0 first, then one after the other.
      integer, intent(in) :: i, k
      !> γ, body axes; shape (3, 0:k).
      real(wp), intent(in) :: gamma(3, 0:k)
      !> Body axes, N m; shape (3).
      real(wp), intent(out) :: tau(3)
      integer :: j
      self%gradient(:, k, i) = 0.0_wp
      if (k <= degree) self%gradient(:, k, i) = self%push(:, k, i)
      do j = 0, min(degree, k)
         self%gradient(:, k, i) = self%gradient(:, k, i) + times_vector(self%stiffness(:, :, j, i), gamma(:, k - j))
      end do
      tau = 0.0_wp
      do j = 0, k
         tau = tau + cross(gamma(:, j), self%gradient(:, k - j, i))
      end do
   end subroutine get_torque

   !> Returns coefficient k of the derivative of γ×(Eγ - e) by γ, [γ]×E - [Eγ - e]×; shape (3,3). Called after
   !> `get_torque`.
   pure function derivative(self, i, k, gamma)
      class(reshaped_series_t), intent(in) :: self
      !> Index of the potential; coefficient.
      integer, intent(in) :: i, k
      !> γ, body axes; shape (3, 0:k).
      real(wp), intent(in) :: gamma(3, 0:k)
      real(wp) :: derivative(3, 3)
      integer :: j
      derivative = -skew(self%gradient(:, k, i))
      do j = 0, min(degree, k)
         derivative = derivative + times_columns(skew(gamma(:, k - j)), self%stiffness(:, :, j, i))
      end do
   end function derivative

   !> Returns coefficient k of -½(dJ/dt)Ω, body axes, N m; shape (3): its product with Ω is the power of the change.
   pure function inertia_push(k, time_unit, inertia, omega) result(push)
      integer, intent(in) :: k
      !> s.
      real(wp), intent(in) :: time_unit
      !> Coefficients of the inertia from the first on, kg m², and of the absolute Ω, rad/s; shapes (3,3, 1:degree), (3,
      !> 0:highest_order).
      real(wp), intent(in) :: inertia(3, 3, degree), omega(3, 0:highest_order)
      real(wp) :: push(3)
      integer :: i
      push = 0.0_wp
      do i = 1, min(degree, k + 1)
         push = push - times_vector((0.5_wp*i/time_unit)*inertia(:, :, i), omega(:, k + 1 - i))
      end do
   end function inertia_push

   !> Returns coefficient k of the part of this power that belongs to the rate of the space axes, W.
   pure real(wp) function transported_power(k, time_unit, inertia, omega, relative) result(power)
      integer, intent(in) :: k
      !> s.
      real(wp), intent(in) :: time_unit
      !> As for `inertia_push`, and Ω relative to the space axes, rad/s; shape (3, 0:highest_order).
      real(wp), intent(in) :: inertia(3, 3, degree), omega(3, 0:highest_order), relative(3, 0:highest_order)
      integer :: j
      power = 0.0_wp
      do j = 0, k
         power = power + dot_product(omega(:, k - j) - relative(:, k - j), inertia_push(j, time_unit, inertia, omega))
      end do
   end function transported_power

end module nutate_reshaped_series
