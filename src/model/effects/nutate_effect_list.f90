!> List of the active effects, sorted once by the terms that the equations need, so that absent terms are never
!> evaluated.
module nutate_effect_list
   use nutate_archive, only: archive_t
   use nutate_effect, only: effect_t, potential_t, torque_t
   use nutate_kinds, only: wp
   use nutate_moving_frame, only: moving_frame_t
   use nutate_orbit, only: orbit_t
   use nutate_status, only: status_t
   use nutate_wheel, only: wheel_t
   implicit none
   private

   public :: effect_list_t
   public :: command_of_wheel, table_order

   !> One potential, and its index in the order in which potentials were added.
   type, private :: potential_slot_t
      class(potential_t), allocatable :: item
      integer :: place = 0
   end type potential_slot_t

   !> One torque.
   type, private :: torque_slot_t
      class(torque_t), allocatable :: item
   end type torque_slot_t

   !> All active effects. Several of a kind add up.
   type :: effect_list_t
      !> Number of potentials that are on: they come first.
      integer :: n_potentials = 0
      !> Number of potentials that are off, behind them.
      integer :: n_off = 0
      !> Number of torques, on or off.
      integer :: n_torques = 0
      !> Number of rotors added, wheels among them.
      integer :: n_rotors = 0
      !> Number of momenta inside of the body: one of each reaction wheel, driven or not, then three of each inner
      !> sphere.
      integer :: n_wheels = 0
      !> Number of reaction wheels, and of inner spheres.
      integer :: n_reaction_wheels = 0, n_spheres = 0
      type(potential_slot_t), allocatable :: potentials(:)
      type(torque_slot_t), allocatable :: torques(:)
      type(wheel_t), allocatable :: wheels(:)
      !> h: sum of the rotors' momenta, body axes, N m s; shape (3).
      real(wp) :: rotor_momentum(3) = 0.0_wp
      !> True if the space axes rotate, and their rate ω, in these axes, rad/s; shape (3).
      logical :: frame_turns = .false.
      real(wp) :: frame_rate(3) = 0.0_wp
      !> True if there is a time-dependent potential, on or off: its direction moves, or it varies with the body.
      logical :: moves = .false.
      !> True if an effect changes the inertia of the body with time, and true if energies depend on time: by that or by
      !> a time-dependent potential.
      logical :: varies = .false., depends_on_time = .false.
      !> True if the centre of mass moves in the body, and true if a potential, on or off, varies by that or by the
      !> inertia.
      logical :: moves_center = .false., reshapes = .false.
      !> True if the body moves on an orbit, and the orbit to which columns, initial states and controllers refer: the
      !> main one of several, or else the first; not allocated if there is none.
      logical :: on_orbit = .false.
      type(orbit_t), allocatable :: orbit
      !> All orbits, with different labels: one for each attracting body. Not allocated if there is none.
      type(orbit_t), allocatable :: orbits(:)
      !> True if the body is in the field of the Earth, on or off, and the effect of that field, which controllers use:
      !> its direction is the field in space axes, T.
      logical :: in_earth_field = .false.
      class(potential_t), allocatable :: earth_field
      !> Number of frames to which columns and events refer, and these frames, which do not affect the motion. Not
      !> allocated if there is none.
      integer :: n_frames = 0
      type(moving_frame_t), allocatable :: frames(:)
   contains
      !> Adds a copy of an effect.
      procedure, non_overridable :: add
      !> Returns the number of works: one per torque, two per wheel (motor, friction), one for the dependence on time.
      procedure, non_overridable :: n_works
      !> Returns a coefficient of the power series of the change of the body's inertia since t = 0.
      procedure, non_overridable :: inertia_term
      !> Return the momentum of rotors and wheels in body axes, and the kinetic energy of the wheels.
      procedure, non_overridable :: inner_momentum, wheel_energy
      !> Sets bounds for the user-defined potential, or torque, that was added last.
      procedure, non_overridable :: bound_potential
      procedure, non_overridable :: bound_torque
      !> Adds to the rate of the space axes.
      procedure, non_overridable :: turn_frame
      !> Return the attitude of the space axes in inertial axes, and whether it is known.
      procedure, non_overridable :: space_axes, knows_space_axes
      !> Adds copies of all effects of another list, with the momentum of its rotors.
      procedure, non_overridable :: append
      !> Returns true if an effect that can be switched has a label.
      procedure, non_overridable :: has
      !> Switches the effects with a label on or off.
      procedure, non_overridable :: switch
      !> Writes or reads in checkpoint data which effects are on.
      procedure, non_overridable :: transfer_switches
      !> Returns true if the motion depends on the attitude.
      procedure, non_overridable :: needs_attitude
      !> Returns the next time on which a step must end.
      procedure, non_overridable :: next_break
      !> Leaves out every second line of the tables of orbits.
      procedure, non_overridable :: thin_tables
      !> Returns true if a controller drives a wheel continuously.
      procedure, non_overridable :: feeds_back_to_wheels
      !> Returns true if a controller drives the wheels, continuously or sampled.
      procedure, non_overridable :: controls_wheels
   end type effect_list_t

   interface

      !> Adds a copy of an effect: a `potential_t`, `torque_t`, `rotor_t` or `rotating_frame_t`, or any extension of
      !> these; a further orbit replaces one with the same label. Wheels are added by `add_wheel`, since they change the
      !> inertia of the body.
      module subroutine add(self, effect)
         class(effect_list_t), intent(inout) :: self
         class(effect_t), intent(in) :: effect
      end subroutine add

      !> Adds to the rate of the space axes.
      pure module subroutine turn_frame(self, rate)
         class(effect_list_t), intent(inout) :: self
         !> Change of the rate, rad/s; shape (3).
         real(wp), intent(in) :: rate(3)
      end subroutine turn_frame

      !> Returns true unless the space axes are those of a rotating frame, whose attitude is not known.
      pure logical module function knows_space_axes(self)
         class(effect_list_t), intent(in) :: self
      end function knows_space_axes

      !> Returns the attitude of the space axes in inertial axes at a time, a unit quaternion, space→inertial; shape
      !> (4): the attitude of the LVLH frame, or the identity for inertial axes and for a rotating frame.
      pure module function space_axes(self, t) result(q)
         class(effect_list_t), intent(in) :: self
         !> Time, s.
         real(wp), intent(in) :: t
         real(wp) :: q(4)
      end function space_axes

      !> Returns coefficient j of the power series of the change of the body's inertia since t = 0: the j-th derivative
      !> times unitʲ/j!, body axes, kg m²; shape (3,3).
      pure module function inertia_term(self, j, t, moment, unit) result(term)
         class(effect_list_t), intent(in) :: self
         integer, intent(in) :: j
         !> Time, a time inside of the step that begins, ends or contains it, and unit of time, s.
         real(wp), intent(in) :: t, moment, unit
         real(wp) :: term(3, 3)
      end function inertia_term

      !> Returns the number of works that a state records, in this order: the torques, then motor and friction of each
      !> wheel, last the dependence on time, if there is one.
      pure integer module function n_works(self)
         class(effect_list_t), intent(in) :: self
      end function n_works

      !> Returns the momentum of rotors and wheels, body axes, N m s; shape (3).
      pure module function inner_momentum(self, momenta) result(momentum)
         class(effect_list_t), intent(in) :: self
         !> Absolute momentum of each wheel about its axis, N m s; shape (n_wheels or more).
         real(wp), intent(in) :: momenta(:)
         real(wp) :: momentum(3)
      end function inner_momentum

      !> Returns the kinetic energy of the wheels, Σ h²/2Jw, J.
      pure real(wp) module function wheel_energy(self, momenta) result(energy)
         class(effect_list_t), intent(in) :: self
         !> Absolute momentum of each wheel about its axis, N m s; shape (n_wheels or more).
         real(wp), intent(in) :: momenta(:)
      end function wheel_energy

      !> Adds copies of all effects of another list, with the momentum of its rotors; its frames, if it has any, replace
      !> those of this list.
      module subroutine append(self, other)
         class(effect_list_t), intent(inout) :: self
         type(effect_list_t), intent(in) :: other
      end subroutine append

      !> Returns true if a potential, a torque or a wheel has a label.
      pure logical module function has(self, label)
         class(effect_list_t), intent(in) :: self
         character(len=*), intent(in) :: label
      end function has

      !> Switches the effects with a label on or off. Steppers must be prepared again afterwards.
      module subroutine switch(self, label, on)
         class(effect_list_t), intent(inout) :: self
         character(len=*), intent(in) :: label
         !> True for on, false for off; absent: toggles each effect.
         logical, intent(in), optional :: on
      end subroutine switch

      !> Writes or reads in checkpoint data which effects are on, which wheels are at a limit, and what controllers
      !> hold.
      module subroutine transfer_switches(self, archive)
         !> List with the same effects, in the same order, as when the data were written.
         class(effect_list_t), intent(inout) :: self
         class(archive_t), intent(inout) :: archive
      end subroutine transfer_switches

      !> Returns true if a controller drives a wheel continuously, by feedback of the motion.
      pure logical module function feeds_back_to_wheels(self)
         class(effect_list_t), intent(in) :: self
      end function feeds_back_to_wheels

      !> Returns true if a controller drives the wheels, continuously or sampled.
      pure logical module function controls_wheels(self)
         class(effect_list_t), intent(in) :: self
      end function controls_wheels

      !> Returns the torque that all sampled controllers command from the motor of a wheel, N m.
      pure real(wp) module function command_of_wheel(self, wheel) result(command)
         type(effect_list_t), intent(in) :: self
         integer, intent(in) :: wheel
      end function command_of_wheel

      !> Sets bounds for the user-defined potential that was added last: with them the root of a step can be certified.
      !> They must hold for all |γ| ≤ |n|; a later call replaces them.
      !>
      !> Errors: `NUTATE_BAD_ARGUMENT`, and the list unchanged, for a bound that is not finite, negative or above 1e100,
      !> and if the list has no user-defined potential: potentials of the library have their own bounds.
      pure module subroutine bound_potential(self, gradient, hessian, third, status)
         class(effect_list_t), intent(inout) :: self
         !> Bounds of |∇U|, of ‖∇²U‖ and of the norm of the third derivative by γ, J over powers of the unit of γ.
         real(wp), intent(in) :: gradient, hessian, third
         type(status_t), intent(out) :: status
      end subroutine bound_potential

      !> Sets bounds for the user-defined torque that was added last, which must depend on attitude and time alone. They
      !> must hold at all attitudes and times; a later call replaces them. Errors as for `bound_potential`.
      pure module subroutine bound_torque(self, torque, by_rotation, second, rate, status)
         class(effect_list_t), intent(inout) :: self
         !> Bounds of |τ|, of ‖∂τ/∂θ‖ (θ a small rotation) and of the norm of the second derivative along a rotation, N
         !> m.
         real(wp), intent(in) :: torque, by_rotation, second
         !> Rate, 1/s: `rate` times a quantity bounds the time derivative of that quantity; 0: constant in time.
         real(wp), intent(in) :: rate
         type(status_t), intent(out) :: status
      end subroutine bound_torque

      !> Returns true if the space axes rotate, or if there is a potential or an attitude-dependent torque, on or off.
      pure logical module function needs_attitude(self)
         class(effect_list_t), intent(in) :: self
      end function needs_attitude

      !> Returns the next time at which a torque or a motor starts, stops or changes from one smooth piece to the next,
      !> s; beyond all times if there is none.
      pure real(wp) module function next_break(self, t, sense) result(next)
         class(effect_list_t), intent(in) :: self
         !> Time, s, and direction of time: 1 or -1.
         real(wp), intent(in) :: t, sense
      end function next_break

      !> Returns the order of the interpolation of tables of orbits, the least of several; 0: there is no table.
      pure integer module function table_order(self) result(order)
         type(effect_list_t), intent(in) :: self
      end function table_order

      !> Leaves out every second line of the tables of orbits, in every effect that has a copy.
      module subroutine thin_tables(self)
         class(effect_list_t), intent(inout) :: self
      end subroutine thin_tables

   end interface

end module nutate_effect_list
