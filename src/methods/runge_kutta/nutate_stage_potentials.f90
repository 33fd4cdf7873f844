!> The torque of all potentials with fixed directions, at a stage of a Runge-Kutta method.
!>
!> Potentials linear in their direction n, U = -m·γ, γ = Rᵀn, exert m×γ: the sum over any number of them follows from
!> one matrix, Σ n mᵀ. Only the others are evaluated one by one. `prepare` sorts the potentials.
module nutate_stage_potentials
   use nutate_effect_list, only: effect_list_t
   use nutate_indices, only: find_indices
   use nutate_kinds, only: wp
   use nutate_small_products, only: times_vector
   implicit none
   private

   public :: stage_potentials_t

   !> The potentials of a system, sorted.
   type :: stage_potentials_t
      private
      !> There are linear potentials; their Σ n mᵀ, J; shape (3,3).
      logical :: has_linear = .false.
      real(wp) :: linear(3, 3) = 0.0_wp
      !> Indices of the potentials that are not linear.
      integer, allocatable :: others(:)
   contains
      !> Sorts the potentials of a system; to be called again after every change of the system.
      procedure :: prepare
      !> Adds the torque of the potentials.
      procedure :: add_torque
   end type stage_potentials_t

contains

   !> Sorts the potentials of a system.
   pure subroutine prepare(self, effects)
      class(stage_potentials_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      logical :: is_other(effects%n_potentials)
      real(wp) :: moment(3)
      integer :: i, j
      self%linear = 0.0_wp
      do i = 1, effects%n_potentials
         associate (potential => effects%potentials(i)%item)
            is_other(i) = .not. potential%is_linear()
            if (is_other(i)) cycle
            moment = potential%series_moment()
            do j = 1, 3
               self%linear(:, j) = self%linear(:, j) + moment(j)*potential%direction
            end do
         end associate
      end do
      self%has_linear = .not. all(is_other)
      call find_indices(is_other, self%others)
   end subroutine prepare

   !> Adds γ×∇U of every potential, γ = R(q)ᵀn/|q|².
   pure subroutine add_torque(self, effects, q, square, tau)
      class(stage_potentials_t), intent(in) :: self
      !> Effects of the system that `prepare` received.
      type(effect_list_t), intent(in) :: effects
      !> q, |q| not quite 1, shape (4), and |q|².
      real(wp), intent(in) :: q(4), square
      !> Body axes, N m; shape (3).
      real(wp), intent(inout) :: tau(3)
      real(wp) :: rows(3, 3), gamma(3), slope(3), double
      integer :: i
      double = 2/square
      rows(1, 1) = 1 - double*(q(3)*q(3) + q(4)*q(4))
      rows(2, 2) = 1 - double*(q(2)*q(2) + q(4)*q(4))
      rows(3, 3) = 1 - double*(q(2)*q(2) + q(3)*q(3))
      rows(1, 2) = double*(q(2)*q(3) + q(1)*q(4))
      rows(2, 1) = double*(q(2)*q(3) - q(1)*q(4))
      rows(1, 3) = double*(q(2)*q(4) - q(1)*q(3))
      rows(3, 1) = double*(q(2)*q(4) + q(1)*q(3))
      rows(2, 3) = double*(q(3)*q(4) + q(1)*q(2))
      rows(3, 2) = double*(q(3)*q(4) - q(1)*q(2))
      if (self%has_linear) then
         tau(1) = tau(1) + along(rows, 3, self%linear(:, 2)) - along(rows, 2, self%linear(:, 3))
         tau(2) = tau(2) + along(rows, 1, self%linear(:, 3)) - along(rows, 3, self%linear(:, 1))
         tau(3) = tau(3) + along(rows, 2, self%linear(:, 1)) - along(rows, 1, self%linear(:, 2))
      end if
      do i = 1, size(self%others)
         associate (potential => effects%potentials(self%others(i))%item)
            gamma = times_vector(rows, potential%direction)
            slope = potential%gradient(gamma)
         end associate
         tau(1) = tau(1) + gamma(2)*slope(3) - gamma(3)*slope(2)
         tau(2) = tau(2) + gamma(3)*slope(1) - gamma(1)*slope(3)
         tau(3) = tau(3) + gamma(1)*slope(2) - gamma(2)*slope(1)
      end do
   end subroutine add_torque

   !> Returns component i of Rᵀv.
   pure real(wp) function along(rows, i, v)
      real(wp), intent(in) :: rows(3, 3), v(3)
      integer, intent(in) :: i
      along = rows(i, 1)*v(1) + rows(i, 2)*v(2) + rows(i, 3)*v(3)
   end function along

end module nutate_stage_potentials
