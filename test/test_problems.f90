!> The problems that several suites integrate, with their published data, and a loop of steps.
module test_problems
   use nutate_hamiltonian, only: angular_velocity, bilinear_form, body_momentum, conserved_energy, frame_rate_of, &
      inertia_at, kinetic_energy, make_state, potential_energy, potential_torque, space_momentum, system_t, &
      time_dependent_power, total_energy
   use nutate_kinds, only: wp
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: stepper_t
   implicit none
   private

   public :: problem_t, new_problem, new_system, box, precessing_top, fast_top, bruls_top, simo_top, free_body, &
      forced_body, march, solve, wheeled_body
   !> Procedures of the library by which tests make and read states.
   public :: angular_velocity, bilinear_form, body_momentum, conserved_energy, frame_rate_of, inertia_at, &
      kinetic_energy, make_state, potential_energy, potential_torque, space_momentum, system_t, &
      time_dependent_power, total_energy

   !> A system with the state it starts from.
   type :: problem_t
      type(system_t) :: system
      type(state_t) :: start
   contains
      final :: end_problem
   end type problem_t

   real(wp), parameter :: identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]

   interface

      !> Does nothing, and lets gfortran free the components in one place, not wherever such a variable ends.
      impure elemental module subroutine end_problem(self)
         type(problem_t), intent(inout) :: self
      end subroutine end_problem

      !> A problem without body and effects. It stays to the end of the program, like all problems that functions
      !> make: code that makes and frees such a variable would be most of what gfortran has to compile.
      module function new_problem() result(problem)
         type(problem_t), pointer :: problem
      end function new_problem

      !> The system of such a problem.
      module function new_system() result(system)
         type(system_t), pointer :: system
      end function new_system

      !> The paper's box: edges 4, 1, 2 m, 12 kg, spinning about its intermediate axis 3.
      module function box() result(problem)
         type(problem_t), pointer :: problem
      end function box

      !> θ = π/3, precession 10 rad/s, spin 135.6 rad/s: steady.
      module function precessing_top() result(problem)
         type(problem_t), pointer :: problem
      end function precessing_top

      !> θ = π/3, pure spin 200 rad/s: nutates.
      module function fast_top() result(problem)
         type(problem_t), pointer :: problem
      end function fast_top

      !> Heavy top of Brüls, Cardona and Arnold.
      module function bruls_top() result(problem)
         type(problem_t), pointer :: problem
      end function bruls_top

      !> Heavy top of Simo and Wong.
      module function simo_top() result(problem)
         type(problem_t), pointer :: problem
      end function simo_top

      !> A free body of given moments (triangle rule not tested) and body angular momentum.
      module function free_body(moments, momentum) result(problem)
         real(wp), intent(in) :: moments(3), momentum(3)
         type(problem_t), pointer :: problem
      end function free_body

      !> A full tensor under potentials, torques and a rotor.
      module function forced_body() result(problem)
         type(problem_t), pointer :: problem
      end function forced_body

      !> Returns the forced body with two wheels: one that a motor drives from 0.103 to 0.257 s, and one that friction
      !> stops.
      module function wheeled_body() result(problem)
         type(problem_t), pointer :: problem
      end function wheeled_body

      !> Performs `n` steps; on failure `status` says why and `state` is the last one reached.
      module subroutine march(system, stepper, state, dt, n, status)
         type(system_t), intent(in) :: system
         class(stepper_t), intent(inout) :: stepper
         type(state_t), intent(inout) :: state
         real(wp), intent(in) :: dt
         integer, intent(in) :: n
         type(status_t), intent(out) :: status
      end subroutine march

      !> The state of a problem after `n` steps of the conserving scheme.
      module subroutine solve(problem, dt, n, state, status, inverse_j0)
         type(problem_t), intent(in) :: problem
         real(wp), intent(in) :: dt
         integer, intent(in) :: n
         type(state_t), intent(out) :: state
         type(status_t), intent(out) :: status
         real(wp), intent(in), optional :: inverse_j0
      end subroutine solve

   end interface

end module test_problems
