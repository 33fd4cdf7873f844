!> One effect of every kind, all inclined to each other, on a body without any symmetry; a simple body for one alone.
module test_effect_samples
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: diagonal, make_body
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_effect, only: potential_t, rotor_t
   use nutate_gravity, only: gravity_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_hamiltonian, only: make_state
   use nutate_kinds, only: wp
   use nutate_spring, only: spring_t
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   use test_problems, only: problem_t
   implicit none
   private

   public :: sample_body, add_sample, sample_names, n_samples, n_sample_potentials, quartic_t, spinner

   !> Kinds of effect; the potentials come first.
   integer, parameter :: n_samples = 7, n_sample_potentials = 4

   character(len=16), parameter :: sample_names(n_samples) = [character(len=16) :: &
                                                              'gravity', 'dipole', 'gravity_gradient', 'spring', &
                                                              'damping', 'torque', 'rotor']

   !> U = γ1⁴ - 2γ1γ2γ3 + 3γ2²: given by U and ∇U alone.
   type, extends(potential_t) :: quartic_t
   contains
      procedure :: energy => quartic_energy
      procedure :: gradient => quartic_gradient
   end type quartic_t

contains

   !> A full tensor with mass and an offset centre of mass, no effects yet.
   type(system_t) function sample_body() result(system)
      type(status_t) :: status
      call make_body(reshape([4.0_wp, 0.5_wp, -0.25_wp, 0.5_wp, 5.0_wp, 0.75_wp, -0.25_wp, 0.75_wp, 6.0_wp], [3, 3]), &
                     system%body, status, mass=2.0_wp, center_of_mass=[0.3_wp, -0.2_wp, 0.5_wp])
   end function sample_body

   !> A body of given principal moments that spins about its axis 3.
   type(problem_t) function spinner(moments, rate) result(problem)
      real(wp), intent(in) :: moments(3), rate
      type(status_t) :: status
      call make_body(diagonal(moments), problem%system%body, status)
      problem%start = make_state(problem%system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, rate])
   end function spinner

   !> Adds the effect of kind `k`; along `n` instead of its own direction, for a potential, where given.
   subroutine add_sample(system, k, n)
      type(system_t), intent(inout) :: system
      integer, intent(in) :: k
      !> Space axes; shape (3).
      real(wp), intent(in), optional :: n(3)
      real(wp) :: directions(3, n_sample_potentials)
      integer :: i
      directions = reshape([0.0_wp, 1.0_wp, -9.0_wp, 1.0_wp, 0.5_wp, -0.3_wp, 1.0_wp, 2.0_wp, -1.0_wp, &
                            0.5_wp, 1.0_wp, -0.8_wp], [3, n_sample_potentials])
      if (present(n)) then
         do i = 1, n_sample_potentials
            directions(:, i) = (-2)**i*n
         end do
      end if
      select case (k)
      case (1)
         call system%effects%add(gravity_t(system%body, directions(:, 1)))
      case (2)
         call system%effects%add(dipole_t([0.5_wp, -1.0_wp, 2.0_wp], directions(:, 2)))
      case (3)
         call system%effects%add(gravity_gradient_t(system%body, directions(:, 3), 0.4_wp))
      case (4)
         call system%effects%add(spring_t([0.4_wp, 0.1_wp, -0.6_wp], directions(:, 4), 5.0_wp, 0.7_wp))
      case (5)
         call system%effects%add(damping_t([0.3_wp, 0.1_wp, 0.2_wp]))
      case (6)
         call system%effects%add(applied_torque_t(name='torque', amplitude=[0.5_wp, -0.2_wp, 0.8_wp], in_space=.true., &
                                                  frequency=0.7_wp, phase=0.4_wp))
         call system%effects%add(applied_torque_t(name='torque', amplitude=[-0.3_wp, 0.6_wp, 0.1_wp]))
      case default
         call system%effects%add(rotor_t(name='rotor', momentum=[0.5_wp, -1.0_wp, 2.0_wp]))
      end select
   end subroutine add_sample

   pure real(wp) function quartic_energy(self, gamma)
      class(quartic_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      quartic_energy = gamma(1)**4 - 2*gamma(1)*gamma(2)*gamma(3) + 3*gamma(2)**2
   end function quartic_energy

   pure function quartic_gradient(self, gamma) result(gradient)
      class(quartic_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: gradient(3)
      gradient = [4*gamma(1)**3 - 2*gamma(2)*gamma(3), 6*gamma(2) - 2*gamma(1)*gamma(3), -2*gamma(1)*gamma(2)]
   end function quartic_gradient

end module test_effect_samples
