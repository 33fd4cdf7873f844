!> Base type of all effects: names, switches, and the procedures that an effect may override.
module nutate_effect_base
   use nutate_archive, only: archive_t
   use nutate_effect_bounds, only: effect_bounds_t, linear_map_t
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: wp
   implicit none
   private

   public :: effect_t, parameter_t
   public :: NO_SERIES, LINEAR_SERIES, GENERAL_SERIES, SPACE_SERIES, TIME_SERIES

   !> How an effect supplies the power series in time of its torque: not at all; as a constant times the series of γ or
   !> Ω; coefficient by coefficient; coefficient by coefficient in space axes, for a torque that depends on time alone
   !> there.
   integer, parameter :: NO_SERIES = 0, LINEAR_SERIES = 1, GENERAL_SERIES = 2, SPACE_SERIES = 3, &
                         TIME_SERIES = 4

   !> A parameter of one or more numbers by which an effect can be differentiated.
   type :: parameter_t
      !> Name of the parameter: that of the scene's key if there is one.
      character(len=24) :: name = ''
      integer :: size = 1
   end type parameter_t

   !> Anything that a scene can contain apart from the body: potentials, torques, rotors, wheels, frames.
   type, abstract :: effect_t
      !> Name of the effect: the scene's group name for the built-in ones.
      character(len=24) :: name = ''
      !> Label by which switches name the effect; blank: none.
      character(len=24) :: label = ''
      !> Index in the scene of the group from which the effect was made; 0: none.
      integer :: group = 0
      !> True if the effect acts; an effect that is off costs nothing. A rotor always acts.
      logical :: on = .true.
      !> Bounds from the user, for effects that do not override `bound`; negative: none. For a potential the largest
      !> |∇U|, ‖∇²U‖ and norm of the third derivative for all γ up to |n| long; for a torque that depends on attitude
      !> and time alone the largest |τ|, ‖∂τ/∂θ‖ (θ a small rotation) and norm of the second derivative along a
      !> rotation, N m, at all times, and a rate, 1/s: the rate times a quantity bounds the time derivative of that
      !> quantity.
      real(wp) :: given(4) = -1.0_wp
   contains
      !> Returns how the effect supplies its power series: `NO_SERIES` (default), `LINEAR_SERIES`, `GENERAL_SERIES`, or,
      !> for a torque, `SPACE_SERIES` or `TIME_SERIES`.
      procedure :: series_kind => no_kind
      !> Returns the number of scalar auxiliary series from which a general series is computed; default 0.
      procedure :: auxiliary_series => no_auxiliary
      !> Returns true if the effect's parameters, its energy (J), torque (N m) and momentum (N m s) are finite and of a
      !> size that can be computed with, at every attitude; default `.true.`.
      procedure :: is_valid => not_checked
      !> Bounds the torque in a step and its derivatives; default: the bounds from the user.
      procedure :: bound => not_bounded
      !> Returns true if a body axis is exactly an axis of symmetry of the effect; default `.false.`.
      procedure :: has_axis => no_axis
      !> Returns the parameters by which the effect can be differentiated; none unless overridden. A *change* of the
      !> parameters is a vector of all their numbers in this order. Four names have a special meaning: `inertia`, nine
      !> numbers, is J of the body with its wheels locked; `mass_moment`, three numbers, is the mass of the body times
      !> its centre of mass at t = 0; `mass` is that mass; `orbit` is the elements of the orbit that the effect follows.
      procedure :: parameters => no_parameters
      !> Returns true if the effect follows an orbit of this path; default `.false.`.
      procedure :: follows => no_orbit
      !> Leaves out every second line of the table of an orbit that the effect follows; nothing unless overridden.
      procedure :: thin_table => no_table
      !> Returns the window, s, that the effect's own parameters define; all times unless overridden.
      procedure :: own_window => all_times
      !> Returns a magnetic field of the effect's own, fixed in space axes, T; none unless overridden.
      procedure :: own_field => no_field
      !> Returns true if the effect has a trait of `nutate_effect_traits`; `.false.` unless overridden.
      procedure :: has => no_trait
      !> Writes or reads in checkpoint data the values that runs set; `on` unless extended.
      procedure :: transfer => transfer_switch
   end type effect_t

contains

   !> Returns true: the parameters of a user-defined effect are not checked.
   pure logical function not_checked(self)
      class(effect_t), intent(in) :: self
      not_checked = .true.
   end function not_checked

   pure function no_parameters(self) result(list)
      class(effect_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      allocate (list(0))
   end function no_parameters

   pure logical function no_orbit(self, path)
      class(effect_t), intent(in) :: self
      type(kepler_orbit_t), intent(in) :: path
      no_orbit = .false.
   end function no_orbit

   !> Does nothing: there is no table.
   subroutine no_table(self)
      class(effect_t), intent(inout) :: self
   end subroutine no_table

   !> Returns all times.
   pure subroutine all_times(self, start, stop)
      class(effect_t), intent(in) :: self
      !> Times between which the effect acts, s.
      real(wp), intent(out) :: start, stop
      start = -huge(1.0_wp)
      stop = huge(1.0_wp)
   end subroutine all_times

   !> Finds no magnetic field.
   pure subroutine no_field(self, field, found)
      class(effect_t), intent(in) :: self
      !> Magnetic field, space axes, T; zero if there is none; shape (3).
      real(wp), intent(out) :: field(3)
      logical, intent(out) :: found
      field = 0.0_wp
      found = .false.
   end subroutine no_field

   !> Returns false: the effect has no traits.
   pure logical function no_trait(self, trait)
      class(effect_t), intent(in) :: self
      integer, intent(in) :: trait
      no_trait = .false.
   end function no_trait

   !> Writes or reads whether the effect is on.
   subroutine transfer_switch(self, archive)
      class(effect_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%on)
   end subroutine transfer_switch

   !> Returns true if the effect is symmetric about a body axis: its torque in axes that rotate with the body is the
   !> same function of γ, Ω and t in all axes that differ from them by a rotation about that axis, and its potential the
   !> same function of γ. Here: false.
   pure logical function no_axis(self, axis)
      class(effect_t), intent(in) :: self
      !> Body axis: 1, 2 or 3.
      integer, intent(in) :: axis
      no_axis = .false.
   end function no_axis

   !> Bounds the torque in a step and its derivatives. Here: no bounds are known.
   pure subroutine not_bounded(self, map, radius, gamma, slack, bounds)
      class(effect_t), intent(in) :: self
      !> Linear map A of body components.
      type(linear_map_t), intent(in) :: map
      !> ρ: the bounds hold for |b| ≤ ρ.
      real(wp), intent(in) :: radius
      !> γ = Rᵀn of a potential at the start of the step, body axes; shape (3). The bounds hold if γ at the start is no
      !> farther from it than `slack` times |n|: at every attitude for a slack of 2.
      real(wp), intent(in) :: gamma(3), slack
      type(effect_bounds_t), intent(out) :: bounds
      bounds%known = .false.
   end subroutine not_bounded

   !> Returns `NO_SERIES`: the effect has no power series.
   pure integer function no_kind(self)
      class(effect_t), intent(in) :: self
      no_kind = NO_SERIES
   end function no_kind

   !> Returns 0: no auxiliary series.
   pure integer function no_auxiliary(self)
      class(effect_t), intent(in) :: self
      no_auxiliary = 0
   end function no_auxiliary

end module nutate_effect_base
