!> The analytic Jacobian of a step against differences, for the suites that bring effects along.
module test_jacobian
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_hamiltonian, only: make_state, system_t
   use nutate_kinds, only: wp, eps
   use nutate_state, only: state_t
   use nutate_eight_equations, only: eight_equations_t
   use test_support, only: check_close, error_type, random_unit_quaternion, random_vector
   implicit none
   private

   public :: check_jacobian

contains

   !> Analytic Jacobian against central differences of the residual, at a point that is no solution. The differences err
   !> by h² of third derivatives and ε/h, h = ε^(1/3).
   subroutine check_jacobian(error, system, inverse_j0, projection)
      type(error_type), allocatable, intent(inout) :: error
      type(system_t), intent(in) :: system
      !> 1/J0, kg⁻¹ m⁻².
      real(wp), intent(in) :: inverse_j0
      logical, intent(in) :: projection
      type(eight_equations_t) :: equations
      type(state_t) :: state
      integer(int64) :: seed
      real(wp) :: z(8), shift(8), above(8), below(8), matrix(8, 8), h
      integer :: i
      seed = 271828_int64
      state = make_state(system, random_unit_quaternion(seed), 2*random_vector(seed))
      state%q = 1.05_wp*state%q
      state%p = state%p + 0.5_wp*random_unit_quaternion(seed)
      call equations%forces%prepare(system%effects, projection)
      call equations%set_momentum_unit(system, inverse_j0, 8.0_wp)
      call equations%start(system, state, 0.2_wp)
      z = 0.2_wp*[random_unit_quaternion(seed), random_unit_quaternion(seed)]
      call equations%jacobian(system, z, matrix)
      h = eps**(1.0_wp/3)
      do i = 1, 8
         shift = 0.0_wp
         shift(i) = h
         call equations%residual(system, z + shift, above)
         call equations%residual(system, z - shift, below)
         call check_close(error, matrix(:, i), (above - below)/(2*h), 2e-9_wp, "column")
      end do
   end subroutine check_jacobian

end module test_jacobian
