!> The invariants of a motion: the conserved quantities of a system, and their errors in a run.
module nutate_invariants
   use nutate_archive, only: archive_t
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: invariants_t, conserved_momentum, common_direction, follows_rotating_axes, parallel
   public :: NO_COMPONENT, ALONG_AXIS, ONLY_LENGTH, ALL_COMPONENTS

   !> Conserved components of the space momentum; only its length if the attitude is not known.
   integer, parameter :: NO_COMPONENT = 0, ALONG_AXIS = 1, ONLY_LENGTH = 2, ALL_COMPONENTS = 3

   !> Sine of an angle between two directions below which it is round-off of their input.
   real(wp), parameter :: parallel = 1e-14_wp

   !> The invariants of a run: their first values, and the largest departures so far.
   type :: invariants_t
      !> `NO_COMPONENT`, `ALONG_AXIS`, `ONLY_LENGTH` or `ALL_COMPONENTS`.
      integer :: components = ALL_COMPONENTS
      !> Unit vector along the conserved component, space axes; shape (3).
      real(wp) :: axis(3) = 0.0_wp
      !> H at the start, J; the Jacobi integral if the space axes rotate.
      real(wp) :: energy = 0.0_wp
      !> l at the start, space axes, N m s; shape (3).
      real(wp) :: momentum(3) = 0.0_wp
      !> Largest T + |V| and |l| so far, to which the errors are relative.
      real(wp) :: energy_scale = 0.0_wp, momentum_scale = 0.0_wp
      !> Largest |H - H(0) - work|, J.
      real(wp) :: worst_energy = 0.0_wp
      !> Largest error of the conserved components of l, N m s.
      real(wp) :: worst_momentum = 0.0_wp
      !> Largest |qᵀq - 1|, and |qᵀp|, kg m²/s: the constraints (2) and (5) of Nielsen & Krenk (2012).
      real(wp) :: norm_error = 0.0_wp, orthogonality = 0.0_wp
      !> 1/J0, kg⁻¹ m⁻².
      real(wp), private :: inverse_j0 = 0.0_wp
   contains
      !> Stores the first values.
      procedure, non_overridable :: start
      !> Compares a state with the first one.
      procedure, non_overridable :: measure
      !> Returns the largest energy residual over the energy scale.
      procedure, non_overridable :: energy_error
      !> Returns the largest momentum error over the momentum scale.
      procedure, non_overridable :: momentum_error
      !> Writes or reads its values in checkpoint data.
      procedure, non_overridable :: transfer => transfer_invariants
   end type invariants_t

   interface

      !> Stores the first values from a state.
      pure module subroutine start(self, system, state, inverse_j0, attitude)
         class(invariants_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(in) :: state
         !> 1/J0, kg⁻¹ m⁻²; default 0.
         real(wp), intent(in), optional :: inverse_j0
         !> The states have an attitude; default `.true.`.
         logical, intent(in), optional :: attitude
      end subroutine start

      !> Compares a state with the first and keeps the largest departures.
      pure module subroutine measure(self, system, state, work)
         class(invariants_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(in) :: state
         !> Work of all torques since the start, J; default 0.
         real(wp), intent(in), optional :: work
      end subroutine measure

      !> Returns the largest |H - H(0) - work| over the largest T + |V|.
      pure real(wp) module function energy_error(self)
         class(invariants_t), intent(in) :: self
      end function energy_error

      !> Returns the largest error of the conserved components over the largest |l|.
      pure real(wp) module function momentum_error(self)
         class(invariants_t), intent(in) :: self
      end function momentum_error

      !> Writes or reads the values in checkpoint data, except those that follow from the system.
      module subroutine transfer_invariants(self, archive)
         class(invariants_t), intent(inout) :: self
         class(archive_t), intent(inout) :: archive
      end subroutine transfer_invariants

      !> Finds the components of l that the effects conserve, on or off: all without torque; the one along n with
      !> potentials that share the direction n, since each is a function of R(q)ᵀn; none otherwise. If the space axes
      !> rotate, only the component along their axis can be conserved; with a time-dependent potential none is.
      pure module subroutine conserved_momentum(effects, components, axis)
         type(effect_list_t), intent(in) :: effects
         !> `NO_COMPONENT`, `ALONG_AXIS` or `ALL_COMPONENTS`.
         integer, intent(out) :: components
         !> Unit vector along the conserved component, space axes; zero unless exactly one is conserved; shape (3).
         real(wp), intent(out) :: axis(3)
      end subroutine conserved_momentum

      !> Finds the direction that all potentials share, on or off, whatever other effects there are: in axes that do not
      !> rotate, l·n is conserved without torques.
      pure module subroutine common_direction(effects, components, axis)
         type(effect_list_t), intent(in) :: effects
         !> `ALL_COMPONENTS` without potentials, `ALONG_AXIS` with one direction, `NO_COMPONENT` with several.
         integer, intent(out) :: components
         !> Unit vector, space axes; the first direction if there are several, zero if there is none; shape (3).
         real(wp), intent(out) :: axis(3)
      end subroutine common_direction

      !> Returns true if the space axes rotate and no effect depends on it, because each is symmetric about their rate,
      !> or there is none: the motion is that in non-rotating axes, rotated back by ω times the time. Wheels are left
      !> out, since their motors may depend on the rotation. False if a number of an effect is not one that a run
      !> accepts, or if the rate is too small to have a direction.
      pure logical module function follows_rotating_axes(effects) result(follows)
         type(effect_list_t), intent(in) :: effects
      end function follows_rotating_axes

   end interface

end module nutate_invariants
