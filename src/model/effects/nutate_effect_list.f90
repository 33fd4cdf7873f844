!> List of the active effects, sorted once by the terms that the equations need, so that absent terms are never
!> evaluated.
module nutate_effect_list
   use nutate_archive, only: archive_t
   use nutate_admissible, only: admits, fault_of, NON_NEGATIVE
   use nutate_earth_field, only: earth_field_t
   use nutate_effect, only: effect_t, given_bounds_t, potential_t, torque_t, rotor_t
   use nutate_effect_bounds, only: effect_bounds_t, linear_map_t
   use nutate_geomagnetic_field, only: geomagnetic_field_t
   use nutate_kinds, only: wp
   use nutate_moving_frame, only: moving_frame_t
   use nutate_orbit, only: orbit_t
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_wheel, only: wheel_t
   implicit none
   private

   public :: effect_list_t, potential_slot_t, torque_slot_t

   !> One potential, and its index in the order in which potentials were added.
   type :: potential_slot_t
      class(potential_t), allocatable :: item
      integer :: place = 0
   end type potential_slot_t

   !> One torque.
   type :: torque_slot_t
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
      !> Number of wheels, driven or not.
      integer :: n_wheels = 0
      type(potential_slot_t), allocatable :: potentials(:)
      type(torque_slot_t), allocatable :: torques(:)
      type(wheel_t), allocatable :: wheels(:)
      !> h: sum of the rotors' momenta, body axes, N m s; shape (3).
      real(wp) :: rotor_momentum(3) = 0.0_wp
      !> True if the space axes rotate, and their rate ω, in these axes, rad/s; shape (3).
      logical :: frame_turns = .false.
      real(wp) :: frame_rate(3) = 0.0_wp
      !> True if there is a time-dependent potential, on or off.
      logical :: moves = .false.
      !> True if the body moves on an orbit, and the orbit to which columns, initial states and controllers refer: the
      !> main one of several, or else the first; not allocated if there is none.
      logical :: on_orbit = .false.
      type(orbit_t), allocatable :: orbit
      !> All orbits, with different labels: one for each attracting body. Not allocated if there is none.
      type(orbit_t), allocatable :: orbits(:)
      !> True if the body is in the field of the Earth, on or off, and that field, which controllers use.
      logical :: in_earth_field = .false.
      type(geomagnetic_field_t), allocatable :: earth_field
      !> Number of frames to which columns and events refer, and these frames, which do not affect the motion. Not
      !> allocated if there is none.
      integer :: n_frames = 0
      type(moving_frame_t), allocatable :: frames(:)
   contains
      !> Adds a copy of an effect.
      procedure :: add
      !> Returns the number of works: one per torque, two per wheel (motor, friction), one for time-dependent
      !> potentials.
      procedure :: n_works
      !> Return the momentum of rotors and wheels in body axes, and the kinetic energy of the wheels.
      procedure :: inner_momentum, wheel_energy
      !> Sets bounds for the user-defined potential, or torque, that was added last.
      procedure :: bound_potential
      procedure :: bound_torque
      !> Adds to the rate of the space axes.
      procedure :: turn_frame
      !> Return the attitude of the space axes in inertial axes, and whether it is known.
      procedure :: space_axes, knows_space_axes
      !> Adds copies of all effects of another list, with the momentum of its rotors.
      procedure :: append
      !> Returns true if an effect that can be switched has a label.
      procedure :: has
      !> Switches the effects with a label on or off.
      procedure :: switch
      !> Writes or reads in checkpoint data which effects are on.
      procedure :: transfer_switches
      !> Returns true if the motion depends on the attitude.
      procedure :: needs_attitude
      !> Returns the next time on which a step must end.
      procedure :: next_break
      !> Returns the order of the interpolation of tables of orbits, the least of several; 0: there is no table.
      procedure :: table_order
      !> Leaves out every second line of the tables of orbits.
      procedure :: thin_tables
      !> Returns true if a controller drives a wheel continuously.
      procedure :: feeds_back_to_wheels
      !> Returns true if a controller drives the wheels, continuously or sampled.
      procedure :: controls_wheels
      !> Returns the torque that all sampled controllers command from the motor of a wheel.
      procedure :: command_of_wheel
   end type effect_list_t

contains

   !> Adds a copy of an effect: a `potential_t`, `torque_t`, `rotor_t` or `rotating_frame_t`, or any extension of these;
   !> a further orbit replaces one with the same label. Wheels are added by `add_wheel`, since they change the inertia
   !> of the body.
   subroutine add(self, effect)
      class(effect_list_t), intent(inout) :: self
      class(effect_t), intent(in) :: effect
      select type (effect)
      class is (potential_t)
         call add_potential(self, effect)
      class is (torque_t)
         call add_torque(self, effect)
      class is (rotor_t)
         self%n_rotors = self%n_rotors + 1
         self%rotor_momentum = self%rotor_momentum + effect%momentum
      type is (orbit_t)
         call follow_orbit(self, effect)
      class is (rotating_frame_t)
         call self%turn_frame(effect%rate)
      type is (wheel_t)
         call add_wheel(self, effect)
      end select
   end subroutine add

   !> Adds to the rate of the space axes.
   pure subroutine turn_frame(self, rate)
      class(effect_list_t), intent(inout) :: self
      !> Change of the rate, rad/s; shape (3).
      real(wp), intent(in) :: rate(3)
      integer :: i
      self%frame_rate = self%frame_rate + rate
      self%frame_turns = any(abs(self%frame_rate) > 0.0_wp)
      do i = 1, self%n_torques
         self%torques(i)%item%frame_rate = self%frame_rate
      end do
   end subroutine turn_frame

   !> Returns true unless the space axes are those of a rotating frame, whose attitude is not known.
   pure logical function knows_space_axes(self)
      class(effect_list_t), intent(in) :: self
      knows_space_axes = .not. self%frame_turns
      if (self%on_orbit) knows_space_axes = knows_space_axes .or. self%orbit%is_frame
   end function knows_space_axes

   !> Returns the attitude of the space axes in inertial axes at a time, a unit quaternion, space→inertial; shape (4):
   !> the attitude of the LVLH frame, or the identity for inertial axes and for a rotating frame.
   pure function space_axes(self, t) result(q)
      class(effect_list_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: q(4)
      q = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      if (.not. self%on_orbit) return
      if (self%orbit%is_frame) q = self%orbit%path%axes(t)
   end function space_axes

   !> Adds an orbit, or replaces one with the same label; its rate becomes part of that of the space axes.
   pure subroutine follow_orbit(self, orbit)
      class(effect_list_t), intent(inout) :: self
      type(orbit_t), intent(in) :: orbit
      type(orbit_t), allocatable :: grown(:)
      integer :: i, n
      n = 0
      if (allocated(self%orbits)) n = size(self%orbits)
      do i = 1, n
         if (self%orbits(i)%label == orbit%label) exit
      end do
      if (i > n) then
         allocate (grown(n + 1))
         if (n > 0) grown(:n) = self%orbits
         call move_alloc(grown, self%orbits)
      end if
      call self%turn_frame(orbit%rate - self%orbits(i)%rate)
      self%orbits(i) = orbit
      self%on_orbit = .true.
      self%orbit = self%orbits(max(1, findloc(self%orbits%is_main, .true., dim=1)))
   end subroutine follow_orbit

   !> Returns the number of works that a state records, in this order: the torques, then motor and friction of each
   !> wheel, last time-dependent potentials, if there is one.
   pure integer function n_works(self)
      class(effect_list_t), intent(in) :: self
      n_works = self%n_torques + 2*self%n_wheels
      if (self%moves) n_works = n_works + 1
   end function n_works

   !> Returns the momentum of rotors and wheels, body axes, N m s; shape (3).
   pure function inner_momentum(self, momenta) result(momentum)
      class(effect_list_t), intent(in) :: self
      !> Absolute momentum of each wheel about its axis, N m s; shape (n_wheels or more).
      real(wp), intent(in) :: momenta(:)
      real(wp) :: momentum(3)
      integer :: i
      momentum = self%rotor_momentum
      do i = 1, self%n_wheels
         momentum = momentum + momenta(i)*self%wheels(i)%axis
      end do
   end function inner_momentum

   !> Returns the kinetic energy of the wheels, Σ h²/2Jw, J.
   pure real(wp) function wheel_energy(self, momenta) result(energy)
      class(effect_list_t), intent(in) :: self
      !> Absolute momentum of each wheel about its axis, N m s; shape (n_wheels or more).
      real(wp), intent(in) :: momenta(:)
      integer :: i
      energy = 0.0_wp
      do i = 1, self%n_wheels
         energy = energy + 0.5_wp*(momenta(i)/self%wheels(i)%inertia)*momenta(i)
      end do
   end function wheel_energy

   !> Adds copies of all effects of another list, with the momentum of its rotors; its frames, if it has any, replace
   !> those of this list.
   subroutine append(self, other)
      class(effect_list_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: other
      integer :: i, place
      do place = 1, other%n_potentials + other%n_off
         do i = 1, other%n_potentials + other%n_off
            if (other%potentials(i)%place == place) call self%add(other%potentials(i)%item)
         end do
      end do
      do i = 1, other%n_torques
         call self%add(other%torques(i)%item)
      end do
      do i = 1, other%n_wheels
         call self%add(other%wheels(i))
      end do
      self%n_rotors = self%n_rotors + (other%n_rotors - other%n_wheels)
      self%rotor_momentum = self%rotor_momentum + other%rotor_momentum
      call self%turn_frame(other%frame_rate)
      if (other%n_frames > 0) then
         self%n_frames = other%n_frames
         self%frames = other%frames
      end if
      if (.not. other%on_orbit) return
      do i = 1, size(other%orbits)
         call self%turn_frame(-other%orbits(i)%rate)
         call follow_orbit(self, other%orbits(i))
      end do
   end subroutine append

   !> Returns true if a potential, a torque or a wheel has a label.
   pure logical function has(self, label)
      class(effect_list_t), intent(in) :: self
      character(len=*), intent(in) :: label
      integer :: i
      has = .false.
      do i = 1, self%n_torques
         has = has .or. self%torques(i)%item%label == label
      end do
      do i = 1, self%n_potentials + self%n_off
         has = has .or. self%potentials(i)%item%label == label
      end do
      do i = 1, self%n_wheels
         has = has .or. self%wheels(i)%label == label
      end do
   end function has

   !> Switches the effects with a label on or off. Steppers must be prepared again afterwards.
   subroutine switch(self, label, on)
      class(effect_list_t), intent(inout) :: self
      character(len=*), intent(in) :: label
      !> True for on, false for off; absent: toggles each effect.
      logical, intent(in), optional :: on
      integer :: i
      do i = 1, self%n_torques
         call switch_one(self%torques(i)%item, label, on)
      end do
      do i = 1, self%n_potentials + self%n_off
         call switch_one(self%potentials(i)%item, label, on)
      end do
      do i = 1, self%n_wheels
         call switch_one(self%wheels(i), label, on)
         if (allocated(self%wheels(i)%motor)) call switch_one(self%wheels(i)%motor, label, on)
      end do
      if (self%n_potentials + self%n_off > 0) call sort_potentials(self)
   end subroutine switch

   subroutine switch_one(effect, label, on)
      class(effect_t), intent(inout) :: effect
      character(len=*), intent(in) :: label
      logical, intent(in), optional :: on
      if (effect%label /= label) return
      effect%on = .not. effect%on
      if (present(on)) effect%on = on
   end subroutine switch_one

   !> Puts the potentials that are on first, and each part in the order in which they were added.
   subroutine sort_potentials(self)
      class(effect_list_t), intent(inout) :: self
      type(potential_slot_t), allocatable :: sorted(:)
      integer :: pass, place, i, n
      allocate (sorted(size(self%potentials)))
      n = 0
      do pass = 1, 2
         do place = 1, size(sorted)
            do i = 1, size(sorted)
               if (.not. allocated(self%potentials(i)%item) .or. self%potentials(i)%place /= place) cycle
               if (self%potentials(i)%item%on .neqv. pass == 1) cycle
               n = n + 1
               sorted(n)%place = place
               call move_alloc(self%potentials(i)%item, sorted(n)%item)
            end do
         end do
         if (pass == 1) self%n_potentials = n
      end do
      self%n_off = n - self%n_potentials
      call move_alloc(sorted, self%potentials)
   end subroutine sort_potentials

   !> Writes or reads in checkpoint data which effects are on, which wheels are at a limit, and what controllers hold.
   subroutine transfer_switches(self, archive)
      !> List with the same effects, in the same order, as when the data were written.
      class(effect_list_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      integer :: i, place
      do i = 1, self%n_torques
         call self%torques(i)%item%transfer(archive)
      end do
      do i = 1, self%n_wheels
         call self%wheels(i)%transfer(archive)
      end do
      if (self%n_potentials + self%n_off == 0) return
      do place = 1, size(self%potentials)
         do i = 1, size(self%potentials)
            if (self%potentials(i)%place == place) call self%potentials(i)%item%transfer(archive)
         end do
      end do
      if (archive%is_reading()) call sort_potentials(self)
   end subroutine transfer_switches

   !> Returns true if a controller drives a wheel continuously, by feedback of the motion.
   pure logical function feeds_back_to_wheels(self)
      class(effect_list_t), intent(in) :: self
      integer :: i
      feeds_back_to_wheels = any([(self%wheels(i)%has_law(), i=1, self%n_wheels)])
   end function feeds_back_to_wheels

   !> Returns true if a controller drives the wheels, continuously or sampled.
   pure logical function controls_wheels(self)
      class(effect_list_t), intent(in) :: self
      integer :: i
      controls_wheels = any([(self%torques(i)%item%drives_wheels(), i=1, self%n_torques)])
   end function controls_wheels

   !> Returns the torque that all sampled controllers command from the motor of a wheel, N m.
   pure real(wp) function command_of_wheel(self, wheel) result(command)
      class(effect_list_t), intent(in) :: self
      integer, intent(in) :: wheel
      integer :: i
      command = 0.0_wp
      do i = 1, self%n_torques
         command = command + self%torques(i)%item%wheel_command(wheel)
      end do
   end function command_of_wheel

   !> Sets bounds for the user-defined potential that was added last: with them the root of a step can be certified.
   !> They must hold for all |γ| ≤ |n|; a later call replaces them.
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT`, and the list unchanged, for a bound that is not finite, negative or above 1e100,
   !> and if the list has no user-defined potential: potentials of the library have their own bounds.
   pure subroutine bound_potential(self, gradient, hessian, third, status)
      class(effect_list_t), intent(inout) :: self
      !> Bounds of |∇U|, of ‖∇²U‖ and of the norm of the third derivative by γ, J over powers of the unit of γ.
      real(wp), intent(in) :: gradient, hessian, third
      type(status_t), intent(out) :: status
      type(given_bounds_t) :: given
      integer :: i
      logical :: taken
      call check_bounds(['gradient', 'hessian ', 'third   '], [gradient, hessian, third], status)
      if (.not. status%ok()) return
      given = given_bounds_t(known=.true., first=gradient, second=hessian, third=third)
      do i = self%n_potentials, 1, -1
         call give_bounds(self%potentials(i)%item, given, taken)
         if (taken) return
      end do
      status = fail(NUTATE_BAD_ARGUMENT, 'there is no user-defined potential to bound')
   end subroutine bound_potential

   !> Sets bounds for the user-defined torque that was added last, which must depend on attitude and time alone. They
   !> must hold at all attitudes and times; a later call replaces them. Errors as for `bound_potential`.
   pure subroutine bound_torque(self, torque, by_rotation, second, rate, status)
      class(effect_list_t), intent(inout) :: self
      !> Bounds of |τ|, of ‖∂τ/∂θ‖ (θ a small rotation) and of the norm of the second derivative along a rotation, N m.
      real(wp), intent(in) :: torque, by_rotation, second
      !> Rate, 1/s: `rate` times a quantity bounds the time derivative of that quantity; 0: constant in time.
      real(wp), intent(in) :: rate
      type(status_t), intent(out) :: status
      type(given_bounds_t) :: given
      integer :: i
      logical :: taken
      call check_bounds(['torque     ', 'by_rotation', 'second     ', 'rate       '], &
                        [torque, by_rotation, second, rate], status)
      if (.not. status%ok()) return
      given = given_bounds_t(known=.true., first=torque, second=by_rotation, third=second, rate=rate)
      do i = self%n_torques, 1, -1
         call give_bounds(self%torques(i)%item, given, taken)
         if (taken) return
      end do
      status = fail(NUTATE_BAD_ARGUMENT, 'there is no user-defined torque to bound')
   end subroutine bound_torque

   !> Checks that bounds are zero or 1e-300 to 1e100. Errors: `NUTATE_BAD_ARGUMENT` with the name of the first that is
   !> not.
   pure subroutine check_bounds(names, bounds, status)
      !> Names of the bounds; shape (n).
      character(len=*), intent(in) :: names(:)
      real(wp), intent(in) :: bounds(:)
      type(status_t), intent(out) :: status
      integer :: i
      do i = 1, size(bounds)
         if (admits(NON_NEGATIVE, bounds(i:i))) cycle
         status = fail(NUTATE_BAD_ARGUMENT, 'the bound '//trim(names(i))//' '// &
                       fault_of(NON_NEGATIVE, bounds(i), 'a number >= 0')//')', names(i))
         return
      end do
   end subroutine check_bounds

   !> Gives bounds to an effect if its bounds in a step depend on them. Effects of the library have bounds without given
   !> ones, or none with them.
   pure subroutine give_bounds(effect, given, taken)
      class(effect_t), intent(inout) :: effect
      type(given_bounds_t), intent(in) :: given
      logical, intent(out) :: taken
      type(given_bounds_t) :: kept
      type(effect_bounds_t) :: with, without
      real(wp), parameter :: origin(3) = 0.0_wp
      kept = effect%given
      effect%given = given_bounds_t()
      call effect%bound(linear_map_t(), 0.1_wp, origin, 2.0_wp, without)
      effect%given = given
      call effect%bound(linear_map_t(), 0.1_wp, origin, 2.0_wp, with)
      taken = with%known .and. .not. without%known
      if (.not. taken) effect%given = kept
   end subroutine give_bounds

   !> Returns true if the space axes rotate, or if there is a potential or an attitude-dependent torque, on or off.
   pure logical function needs_attitude(self)
      class(effect_list_t), intent(in) :: self
      integer :: i
      needs_attitude = self%n_potentials + self%n_off > 0 .or. self%frame_turns
      do i = 1, self%n_torques
         if (self%torques(i)%item%needs_attitude()) needs_attitude = .true.
      end do
   end function needs_attitude

   !> Returns the next time at which a torque or a motor starts, stops or changes from one smooth piece to the next, s;
   !> beyond all times if there is none.
   pure real(wp) function next_break(self, t, sense) result(next)
      class(effect_list_t), intent(in) :: self
      !> Time, s, and direction of time: 1 or -1.
      real(wp), intent(in) :: t, sense
      real(wp) :: one
      integer :: i
      next = sense*huge(next)
      do i = 1, self%n_torques
         one = self%torques(i)%item%next_break(t, sense)
         if (sense*one < sense*next) next = one
      end do
      do i = 1, self%n_wheels
         if (.not. allocated(self%wheels(i)%motor)) cycle
         one = self%wheels(i)%motor%next_break(t, sense)
         if (sense*one < sense*next) next = one
      end do
      if (.not. self%on_orbit) return
      do i = 1, size(self%orbits)
         if (.not. allocated(self%orbits(i)%path%track)) cycle
         one = self%orbits(i)%path%track%next_break(t, sense)
         if (sense*one < sense*next) next = one
      end do
   end function next_break

   !> Returns the order of the interpolation of tables of orbits, the least of several; 0: there is no table.
   pure integer function table_order(self) result(order)
      class(effect_list_t), intent(in) :: self
      integer :: i
      order = 0
      if (.not. self%on_orbit) return
      do i = 1, size(self%orbits)
         if (.not. allocated(self%orbits(i)%path%track)) cycle
         associate (track => self%orbits(i)%path%track)
            if (order == 0 .or. track%order() < order) order = track%order()
         end associate
      end do
   end function table_order

   !> Leaves out every second line of the tables of orbits, in every effect that has a copy.
   subroutine thin_tables(self)
      class(effect_list_t), intent(inout) :: self
      integer :: i
      if (.not. self%on_orbit) return
      do i = 1, size(self%orbits)
         call self%orbits(i)%path%thin_table()
      end do
      call self%orbit%path%thin_table()
      if (allocated(self%earth_field)) call self%earth_field%path%thin_table()
      do i = 1, self%n_potentials + self%n_off
         call self%potentials(i)%item%thin_table()
      end do
      do i = 1, self%n_torques
         call self%torques(i)%item%thin_table()
      end do
      do i = 1, self%n_wheels
         if (allocated(self%wheels(i)%motor)) call self%wheels(i)%motor%thin_table()
      end do
   end subroutine thin_tables

   subroutine add_potential(self, effect)
      class(effect_list_t), intent(inout) :: self
      class(potential_t), intent(in) :: effect
      type(potential_slot_t), allocatable :: grown(:)
      integer :: i, n
      n = self%n_potentials + self%n_off
      self%moves = self%moves .or. effect%moves
      select type (effect)
      type is (earth_field_t)
         self%in_earth_field = .true.
         self%earth_field = effect%field()
      end select
      allocate (grown(n + 1))
      do i = 1, n
         grown(i)%place = self%potentials(i)%place
         call move_alloc(self%potentials(i)%item, grown(i)%item)
      end do
      allocate (grown(n + 1)%item, source=effect)
      grown(n + 1)%place = n + 1
      call move_alloc(grown, self%potentials)
      call sort_potentials(self)
   end subroutine add_potential

   !> Adds a copy of a wheel to the list, on or off; `add_wheel` of a system also changes the inertia of the body.
   subroutine add_wheel(self, wheel)
      class(effect_list_t), intent(inout) :: self
      type(wheel_t), intent(in) :: wheel
      type(wheel_t), allocatable :: grown(:)
      integer :: i
      allocate (grown(self%n_wheels + 1))
      do i = 1, self%n_wheels
         grown(i) = self%wheels(i)
      end do
      grown(self%n_wheels + 1) = wheel
      call move_alloc(grown, self%wheels)
      self%n_wheels = self%n_wheels + 1
      self%n_rotors = self%n_rotors + 1
   end subroutine add_wheel

   subroutine add_torque(self, effect)
      class(effect_list_t), intent(inout) :: self
      class(torque_t), intent(in) :: effect
      type(torque_slot_t), allocatable :: grown(:)
      integer :: i
      allocate (grown(self%n_torques + 1))
      do i = 1, self%n_torques
         call move_alloc(self%torques(i)%item, grown(i)%item)
      end do
      allocate (grown(self%n_torques + 1)%item, source=effect)
      grown(self%n_torques + 1)%item%frame_rate = self%frame_rate
      call move_alloc(grown, self%torques)
      self%n_torques = self%n_torques + 1
   end subroutine add_torque

end module nutate_effect_list
