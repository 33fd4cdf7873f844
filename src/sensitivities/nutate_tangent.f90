!> Sensitivities: the derivative of a motion by its initial state and by parameters, propagated along a run.
!>
!> Sensitivity k is the change (θ, δL), and δh of each wheel, of the state per unit of `variations(k)`, in the chart
!>
!>     q → q∘exp(½θ),   L → L + δL,
!>
!> θ and δL in body axes. It is the derivative of the map that the method computes, not a second method for the
!> variational equations: differences of two runs converge to it, and what a step conserves its tangent conserves too
!> (`nutate_tangent_rows`). The first index of all arrays is the sensitivity.
!>
!> **Calls.** A program describes sensitivities (`nutate_variation`) and gives them to a run, `run%differentiate` after
!> `begin`; `begin` here makes the tangent of the first state. When the run accepts a step of the method,
!> `policy%propagate` calls `stepper%propagate` for each `advance` of the step; output points inside steps use a copy.
!> States depend on sensitivities only if these shorten adaptive steps (`nutate_error_control`).
!>
!> **Requirements of an override of `stepper_t%propagate_step`**: move `theta`, `momentum` and `wheels` from the state
!> `before` to the state `after`, which `advance` has just computed from it: the data that `advance` left in the stepper
!> may be used, and must not change. For parametric sensitivities (`parametric` holds their indices) add the effect of
!> their changes in the step: `inertia` is the change of the body without freely rotating parts, `variations(k)%rotor`,
!> `%frame`, `%effects` are the others; effects supply their own derivatives (`direction_change`, `gradient_change`,
!> `torque_change`), and `reshaping_term` those of potentials that vary with the body. `work` gains the change of the
!> work of torques, motors and friction. Methods that project move the sensitivities to the targets `energy` and
!> `space_momentum`, the values of the rows at the start. For methods that conserve by themselves, and report it
!> (`conserves`), `propagate` removes round-off of these rows every so many steps (`nutate_sensitivity_projection`).
module nutate_tangent
   use nutate_archive, only: archive_t
   use nutate_variation, only: variation_t
   use nutate_effect_list, only: effect_list_t
   use nutate_hamiltonian, only: space_momentum, system_t
   use nutate_kinds, only: wp
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   implicit none
   private

   public :: tangent_t, check_effects

   !> Sensitivities at a state of a run.
   type :: tangent_t
      !> Number of sensitivities.
      integer :: n = 0
      !> Change by which each sensitivity is the derivative; shape (n).
      type(variation_t), allocatable :: variations(:)
      !> θ, rad, and δL, N m s, body axes, per unit of the sensitivity's parameter; shape (n, 3).
      real(wp), allocatable :: theta(:, :), momentum(:, :)
      !> δh of each wheel, N m s; shape (n, n_wheels).
      real(wp), allocatable :: wheels(:, :)
      !> Change of all works since the start, J; shape (n).
      real(wp), allocatable :: work(:)
      !> The rows of the energy and of l, with the parameters' own part, at the start: J, N m s, space axes; shape (n),
      !> (n, 3).
      real(wp), allocatable :: energy(:), space_momentum(:, :)
      !> Indices of the sensitivities that change a parameter; shape (n_parametric). Change of J without freely rotating
      !> parts by each of them, kg m², shape (3, 3, n_parametric): at t = 0, and by starts and stops until the state.
      integer, allocatable :: parametric(:)
      real(wp), allocatable :: inertia(:, :, :)
      !> Steps since round-off was last removed from what the sensitivities conserve (`stepper_t%propagate`).
      integer :: steps = 0
      !> True if sensitivities change the times at which torques or motors start or stop: `nutate_window_edges` moves
      !> sensitivities over these times.
      logical :: moves_windows = .false.
      !> Estimated error of the last step of a method that has an estimate, of the sensitivity for which it is largest
      !> and relative to it (`relative`); else zero. Not in checkpoint data.
      real(wp) :: error = 0.0_wp
      !> Work space of steps; shape (n, 3).
      real(wp), allocatable :: mid(:, :), turn(:, :), change(:, :), mean(:, :), shift(:, :)
      !> Work space of steps, for an even number of sensitivities; shape (n, 6) or (n + 1, 6).
      real(wp), allocatable :: even(:, :)
      !> Work space of steps, for wheels; shape (n, n_wheels).
      real(wp), allocatable :: inner(:, :)
   contains
      !> Makes the sensitivities of an initial state.
      procedure, non_overridable :: begin
      !> Sets the sensitivities at a later state.
      procedure, non_overridable :: resume
      !> Returns the change of the rates.
      procedure, non_overridable :: rates
      !> Returns the change of J at a time by a sensitivity that changes a parameter.
      procedure, non_overridable :: inertia_of
      !> Returns the size of a change of the sensitivities, relative to them.
      procedure, non_overridable :: relative
      !> Return the change of the energy, which potentials conserve, and of l.
      procedure, non_overridable :: energy_row
      procedure, non_overridable :: momentum_row
      !> Writes or reads its values in checkpoint data.
      procedure, non_overridable :: transfer
   end type tangent_t

   interface

      !> Makes the sensitivities of an initial state. Errors: `NUTATE_BAD_ARGUMENT` if there are none, and for effects
      !> without a derivative.
      module subroutine begin(self, system, state, variations, status)
         class(tangent_t), intent(out) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(in) :: state
         !> Variations of the sensitivities; shape (n).
         type(variation_t), intent(in) :: variations(:)
         type(status_t), intent(out) :: status
      end subroutine begin

      !> Returns the change of J without freely rotating parts, body axes, kg m²; shape (3,3).
      pure module function inertia_of(self, effects, m, t) result(change)
         class(tangent_t), intent(in) :: self
         type(effect_list_t), intent(in) :: effects
         !> Index among the sensitivities that change a parameter.
         integer, intent(in) :: m
         !> Time, s.
         real(wp), intent(in) :: t
         real(wp) :: change(3, 3)
      end function inertia_of

      !> Sets the sensitivities at a later state of a motion without wheels, from `theta` and `rates` there. The targets
      !> of the conserved rows are set to their values at this state.
      module subroutine resume(self, system, state, theta, rates)
         !> Tangent after `begin`.
         class(tangent_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(in) :: state
         !> θ, rad, and δΩ, rad/s, body axes, per unit of the sensitivity's parameter; shape (n, 3).
         real(wp), intent(in) :: theta(:, :), rates(:, :)
      end subroutine resume

      !> Returns the change of the momentum of rotors and wheels in the body, axes of wheels included, N m s, body axes;
      !> shape (3).
      pure module function inner_change(self, effects, state, k) result(change)
         type(tangent_t), intent(in) :: self
         type(effect_list_t), intent(in) :: effects
         type(state_t), intent(in) :: state
         !> Index of the sensitivity.
         integer, intent(in) :: k
         real(wp) :: change(3)
      end function inner_change

      !> Returns δΩ = J⁻¹(δL - δh - δJΩ), body axes; shape (n, 3).
      pure module function rates(self, system, state) result(change)
         class(tangent_t), intent(in) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(in) :: state
         real(wp) :: change(self%n, 3)
      end function rates

      !> Returns by how much sensitivities change, each relative to its own size, √(θ² + δL²/|L|²); the largest of all.
      pure real(wp) module function relative(self, theta, momentum, scale)
         class(tangent_t), intent(in) :: self
         !> Changes of θ, rad, and of δL, N m s; shape (n, 3).
         real(wp), intent(in) :: theta(:, :), momentum(:, :)
         !> |L|, N m s.
         real(wp), intent(in) :: scale
      end function relative

      !> Returns dH·X with the change of H by the parameters at fixed q, L and h, J; of H - ω·l if the space axes
      !> rotate. Potentials conserve this row, torques change it by `work`; shape (n). Nothing uses it for potentials
      !> that depend on time: the changes of orbital gradients with |n|, and with what changes the body, are left out.
      pure module function energy_row(self, system, state) result(change)
         class(tangent_t), intent(in) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(in) :: state
         real(wp) :: change(self%n)
      end function energy_row

      !> Returns δl = R(δL + θ×L), space axes, N m s: conserved without forces; in a field along n, its component along
      !> n is conserved; shape (n, 3).
      pure module function momentum_row(self, state) result(change)
         class(tangent_t), intent(in) :: self
         type(state_t), intent(in) :: state
         real(wp) :: change(self%n, 3)
      end function momentum_row

      !> Checks that the effects have derivatives by the state. Errors: `NUTATE_BAD_ARGUMENT` for effects that have
      !> none.
      module subroutine check_effects(effects, status)
         type(effect_list_t), intent(in) :: effects
         type(status_t), intent(out) :: status
      end subroutine check_effects

      !> Writes or reads its values in checkpoint data.
      module subroutine transfer(self, archive)
         !> Tangent begun with the same sensitivities.
         class(tangent_t), intent(inout) :: self
         class(archive_t), intent(inout) :: archive
      end subroutine transfer

   end interface

end module nutate_tangent
