!> Variation by which a sensitivity is the derivative: a direction in the space of initial states and parameters. A key
!> of a scene that changes several parameters (the mass of a shape, say) is one sensitivity with all of them.
module nutate_variation
   use nutate_effect_base, only: effect_t, parameter_t
   use nutate_effect_list, only: effect_list_t
   use nutate_effect_traits, only: DRIVES_WHEELS, FOLLOWS_EARTH_FIELD, IS_EARTH_FIELD, LENDS_PARAMETERS
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: wp
   use nutate_orbit, only: frame_rate_change
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_wheel, only: axis_change
   implicit none
   private

   public :: variation_t, effect_change_t, window_change_t, attitude_variation, rate_variation, inertia_variation
   public :: added_inertia, change_at_start, reshaping_term
   public :: OF_POTENTIAL, OF_TORQUE, OF_WHEEL, OF_ORBIT

   !> List of the effects that contains an effect.
   integer, parameter :: OF_POTENTIAL = 1, OF_TORQUE = 2, OF_WHEEL = 3, OF_ORBIT = 4

   !> Names of the ends of a window.
   character(len=*), parameter :: edge_names(2) = [character(len=5) :: 'start', 'stop']

   !> A change of the parameters of one effect.
   type :: effect_change_t
      integer :: kind = 0
      !> The `place` of a potential, the index of a torque, wheel or orbit.
      integer :: place = 0
      !> Change, in the order of the effect's `parameters`.
      real(wp), allocatable :: change(:)
   end type effect_change_t

   !> A change of the times at which a torque, or the motor of a wheel, starts and stops.
   type :: window_change_t
      !> `OF_TORQUE` or `OF_WHEEL`, and the index in that list.
      integer :: kind = 0, place = 0
      !> Change of start and stop.
      real(wp) :: change(2) = 0.0_wp
   end type window_change_t

   !> Change of the initial state and of the parameters per unit of the sensitivity. If a parameter changes, the initial
   !> state keeps its rates, Ω0 and those of the wheels.
   type :: variation_t
      !> Name for messages and files.
      character(len=64) :: name = ''
      !> Initial state: rotation vector of the attitude, body axes, q → q∘exp(½θ); Ω0, body axes, 1/s; shape (3).
      real(wp) :: attitude(3) = 0.0_wp, angular_velocity(3) = 0.0_wp
      !> Body: J with its wheels locked, symmetric, kg m², shape (3,3); mass times centre of mass, kg m, shape (3);
      !> mass, kg, which multiplies motions of the centre of mass. All are those of t = 0. Effects that depend on them
      !> change too.
      real(wp) :: inertia(3, 3) = 0.0_wp, mass_moment(3) = 0.0_wp, mass = 0.0_wp
      !> Momentum of the rotors, body axes, N m s, and the rate of the space axes, in these, rad/s; shape (3).
      real(wp) :: rotor(3) = 0.0_wp, frame(3) = 0.0_wp
      !> Parameters of effects.
      type(effect_change_t), allocatable :: effects(:)
      !> Times at which torques and motors start and stop; true if changes of the inertia with time are among them.
      type(window_change_t), allocatable :: windows(:)
      logical :: moves_inertia = .false.
   contains
      !> Add a parameter of an effect, or of all effects that were made from a group of a scene.
      procedure, non_overridable :: add, add_of_group
      !> Add the changes of effects that follow from the body, and from orbits.
      procedure, non_overridable :: follow_body
      procedure, non_overridable :: follow_orbits
      !> Returns true if a parameter changes.
      procedure, non_overridable :: is_parametric
      !> Returns true if an element of an orbit changes.
      procedure, non_overridable :: changes_orbit
   end type variation_t

contains

   !> Returns the sensitivity of a rotation of the initial state about a body axis.
   pure type(variation_t) function attitude_variation(axis) result(variation)
      !> Body axis: 1, 2 or 3; any other makes a variation that no run accepts.
      integer, intent(in) :: axis
      variation%name = 'initial.attitude.'//decimal(axis)
      if (axis >= 1 .and. axis <= 3) then
         variation%attitude(axis) = 1.0_wp
      else
         variation%attitude = huge(1.0_wp)
      end if
   end function attitude_variation

   !> Returns the sensitivity of a component of Ω0.
   pure type(variation_t) function rate_variation(axis) result(variation)
      !> Body axis: 1, 2 or 3; any other makes a variation that no run accepts.
      integer, intent(in) :: axis
      variation%name = 'initial.angular_velocity.'//decimal(axis)
      if (axis >= 1 .and. axis <= 3) then
         variation%angular_velocity(axis) = 1.0_wp
      else
         variation%angular_velocity = huge(1.0_wp)
      end if
   end function rate_variation

   !> Returns the sensitivity of a component of the inertia, of both if it is off the diagonal.
   pure type(variation_t) function inertia_variation(i, j) result(variation)
      !> Row and column: 1, 2 or 3; any other makes a variation that no run accepts.
      integer, intent(in) :: i, j
      variation%name = 'body.inertia.'//decimal(i)//decimal(j)
      if (min(i, j) >= 1 .and. max(i, j) <= 3) then
         variation%inertia(i, j) = 1.0_wp
         variation%inertia(j, i) = 1.0_wp
      else
         variation%inertia = huge(1.0_wp)
      end if
   end function inertia_variation

   pure function decimal(i) result(digits)
      integer, intent(in) :: i
      character(len=:), allocatable :: digits
      character(len=12) :: room
      write (room, '(i0)') i
      digits = trim(room)
   end function decimal

   !> Adds a change of a parameter of an effect. Errors: `NUTATE_BAD_ARGUMENT` if there is no such effect, and if it has
   !> no parameter of that name and size.
   subroutine add(self, effects, effect, number, parameter, change, status)
      class(variation_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> Name of the effect.
      character(len=*), intent(in) :: effect
      !> Number among the effects of that name: potentials in the order in which they were added, then torques, wheels,
      !> orbits.
      integer, intent(in) :: number
      !> Name of the parameter.
      character(len=*), intent(in) :: parameter
      !> Change of the parameter, with as many numbers as it has.
      real(wp), intent(in) :: change(:)
      type(status_t), intent(out) :: status
      call add_where(self, effects, effect, number, 0, parameter, change, status)
   end subroutine add

   !> Adds a change of a parameter of all effects that were made from one group of a scene. Errors: those of `add`.
   subroutine add_of_group(self, effects, group, parameter, change, status)
      class(variation_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> Index of the group in the scene.
      integer, intent(in) :: group
      !> Name of the parameter and its change, as in `add`.
      character(len=*), intent(in) :: parameter
      real(wp), intent(in) :: change(:)
      type(status_t), intent(out) :: status
      call add_where(self, effects, '', 0, group, parameter, change, status)
   end subroutine add_of_group

   !> Adds a change of a parameter of the effect of a name and number, or of all effects of a group.
   subroutine add_where(self, effects, effect, number, group, parameter, change, status)
      class(variation_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      character(len=*), intent(in) :: effect, parameter
      integer, intent(in) :: number
      !> Index of the group; 0: none.
      integer, intent(in) :: group
      real(wp), intent(in) :: change(:)
      type(status_t), intent(out) :: status
      integer :: i, place, same_name
      logical :: found
      same_name = 0
      found = .false.
      do place = 1, effects%n_potentials + effects%n_off
         do i = 1, effects%n_potentials + effects%n_off
            if (effects%potentials(i)%place == place) call visit(effects%potentials(i)%item, OF_POTENTIAL, place)
         end do
      end do
      do i = 1, effects%n_torques
         call visit(effects%torques(i)%item, OF_TORQUE, i)
      end do
      do i = 1, effects%n_wheels
         ! The three components of an inner sphere are one effect.
         if (effects%wheels(i)%component > 1 .and. effects%wheels(i)%name == effect) same_name = same_name - 1
         call visit(effects%wheels(i), OF_WHEEL, i)
      end do
      if (allocated(effects%orbits)) then
         do i = 1, size(effects%orbits)
            call visit(effects%orbits(i), OF_ORBIT, i)
         end do
      end if
      if (.not. found) status = fail(NUTATE_BAD_ARGUMENT, 'there is no effect '//trim(effect)//' to differentiate by')

   contains

      subroutine visit(item, kind, place)
         class(effect_t), intent(in) :: item
         integer, intent(in) :: kind, place
         integer :: k
         logical :: there
         if (item%name == effect) same_name = same_name + 1
         if (group > 0) then
            if (item%group /= group) return
         else
            if (item%name /= effect .or. same_name /= number) return
         end if
         found = .true.
         if (.not. changes(self, item, kind, place, parameter, change)) then
            if (moves_edge(self, effects, item, kind, place, parameter, change)) return
            status = fail(NUTATE_BAD_ARGUMENT, 'the effect '//trim(item%name)//' has no derivative with respect '// &
                          'to '//parameter//' (expected '//trim(names_of(item))//')')
         end if
         if (item%has(LENDS_PARAMETERS)) then
            do k = 1, effects%n_wheels
               if (.not. changes(self, effects%wheels(k), OF_WHEEL, k, parameter, change)) return
            end do
         else if (item%has(IS_EARTH_FIELD)) then
            ! Magnetorquers do not have the moment of the field.
            do k = 1, effects%n_torques
               associate (torque => effects%torques(k)%item)
                  if (torque%has(FOLLOWS_EARTH_FIELD)) there = changes(self, torque, OF_TORQUE, k, parameter, change)
               end associate
            end do
         end if
      end subroutine visit

   end subroutine add_where

   !> Adds a change of the time at which a torque or a motor starts or stops; false for an end of a window that lies
   !> before or after all times. A controller of wheels acts by their motors.
   logical function moves_edge(self, effects, item, kind, place, edge, change) result(moves)
      type(variation_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      class(effect_t), intent(in) :: item
      integer, intent(in) :: kind, place
      !> Name of the parameter, and its change.
      character(len=*), intent(in) :: edge
      real(wp), intent(in) :: change(:)
      real(wp) :: times(2)
      integer :: side, k
      side = findloc(edge_names == edge, .true., dim=1)
      moves = side > 0 .and. size(change) == 1
      if (.not. moves) return
      call item%own_window(times(1), times(2))
      moves = abs(times(side)) < huge(1.0_wp)
      if (.not. moves) return
      if (item%has(DRIVES_WHEELS)) then
         do k = 1, effects%n_wheels
            if (effects%wheels(k)%has_law()) call append_edge(self, OF_WHEEL, k, side, change(1))
         end do
      else
         call append_edge(self, kind, place, side, change(1))
         if (kind == OF_TORQUE) self%moves_inertia = self%moves_inertia .or. effects%torques(place)%item%changes_inertia
      end if
   end function moves_edge

   !> Adds a change of one end of a window.
   subroutine append_edge(self, kind, place, side, change)
      type(variation_t), intent(inout) :: self
      integer, intent(in) :: kind, place
      !> 1: start; 2: stop.
      integer, intent(in) :: side
      real(wp), intent(in) :: change
      type(window_change_t) :: one
      integer :: i
      if (.not. allocated(self%windows)) allocate (self%windows(0))
      do i = 1, size(self%windows)
         if (self%windows(i)%kind == kind .and. self%windows(i)%place == place) exit
      end do
      one = window_change_t(kind=kind, place=place)
      if (i > size(self%windows)) self%windows = [self%windows, one]
      self%windows(i)%change(side) = self%windows(i)%change(side) + change
   end subroutine append_edge

   !> Adds a change to those of an effect; false if the effect has no derivative with respect to that name.
   logical function changes(self, effect, kind, place, parameter, change)
      type(variation_t), intent(inout) :: self
      class(effect_t), intent(in) :: effect
      integer, intent(in) :: kind, place
      character(len=*), intent(in) :: parameter
      real(wp), intent(in) :: change(:)
      type(parameter_t), allocatable :: list(:)
      type(effect_change_t) :: one
      integer :: i, first
      changes = .false.
      list = effect%parameters()
      first = 1
      do i = 1, size(list)
         if (list(i)%name /= '' .and. list(i)%name == parameter .and. list(i)%size == size(change)) then
            one%kind = kind
            one%place = place
            allocate (one%change(sum(list%size)), source=0.0_wp)
            one%change(first:first + size(change) - 1) = change
            call append(self, one)
            changes = .true.
            return
         end if
         first = first + list(i)%size
      end do
   end function changes

   !> Returns the parameters of an effect with their sizes, for messages.
   function names_of(effect) result(names)
      class(effect_t), intent(in) :: effect
      character(len=160) :: names
      type(parameter_t), allocatable :: list(:)
      real(wp) :: times(2)
      integer :: i
      names = ''
      list = effect%parameters()
      do i = 1, size(list)
         if (list(i)%name == '') cycle
         if (names /= '') names = trim(names)//','
         names = trim(names)//' '//list(i)%name
         if (list(i)%size > 1) names = trim(names)//'('//decimal(list(i)%size)//')'
      end do
      call effect%own_window(times(1), times(2))
      do i = 1, 2
         if (.not. abs(times(i)) < huge(1.0_wp)) cycle
         if (names /= '') names = trim(names)//','
         names = trim(names)//' '//edge_names(i)
      end do
      names = adjustl(names)
      if (names == '') names = 'another effect'
   end function names_of

   subroutine append(self, one)
      type(variation_t), intent(inout) :: self
      type(effect_change_t), intent(in) :: one
      type(effect_change_t), allocatable :: grown(:)
      integer :: i, n
      n = 0
      if (allocated(self%effects)) n = size(self%effects)
      do i = 1, n
         if (self%effects(i)%kind /= one%kind .or. self%effects(i)%place /= one%place) cycle
         self%effects(i)%change = self%effects(i)%change + one%change
         return
      end do
      allocate (grown(n + 1))
      do i = 1, n
         grown(i) = self%effects(i)
      end do
      grown(n + 1) = one
      call move_alloc(grown, self%effects)
   end subroutine append

   !> Adds the changes of effects that follow from those of the body.
   subroutine follow_body(self, effects, inertia)
      class(variation_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> Change of J with its wheels locked, which effects may add to, kg m²; shape (3,3).
      real(wp), intent(in) :: inertia(3, 3)
      integer :: i
      logical :: there
      do i = 1, effects%n_potentials + effects%n_off
         associate (slot => effects%potentials(i))
            if (any(abs(inertia) > 0.0_wp)) &
               there = changes(self, slot%item, OF_POTENTIAL, slot%place, 'inertia', reshape(inertia, [9]))
            if (any(abs(self%mass_moment) > 0.0_wp)) &
               there = changes(self, slot%item, OF_POTENTIAL, slot%place, 'mass_moment', self%mass_moment)
            if (abs(self%mass) > 0.0_wp) there = changes(self, slot%item, OF_POTENTIAL, slot%place, 'mass', [self%mass])
         end associate
      end do
   end subroutine follow_body

   !> Returns the change of Jᵣ = J - Σ Jw ssᵀ, without freely rotating parts, at t = 0; shape (3,3).
   pure function change_at_start(effects, variation) result(change)
      type(effect_list_t), intent(in) :: effects
      type(variation_t), intent(in) :: variation
      real(wp) :: change(3, 3)
      real(wp) :: axis(3)
      integer :: i, j
      change = variation%inertia + added_inertia(variation, effects, 0, 0.0_wp, 0.0_wp, 1.0_wp)
      if (.not. allocated(variation%effects)) return
      do i = 1, size(variation%effects)
         if (variation%effects(i)%kind /= OF_WHEEL) cycle
         associate (wheel => effects%wheels(variation%effects(i)%place), c => variation%effects(i)%change)
            if (wheel%component > 0) cycle
            axis = axis_change(wheel, c)
            do j = 1, 3
               change(:, j) = change(:, j) - (c(4)*wheel%axis(j) + wheel%inertia*axis(j))*wheel%axis &
                              - (wheel%inertia*wheel%axis(j))*axis
            end do
         end associate
      end do
   end function change_at_start

   !> Returns the change of coefficient j of the power series of the inertia that effects add, kg m²; shape (3,3).
   pure function added_inertia(variation, effects, j, t, moment, unit) result(change)
      type(variation_t), intent(in) :: variation
      type(effect_list_t), intent(in) :: effects
      integer, intent(in) :: j
      !> Time, a time inside of the step that begins, ends or contains it, and unit of time, s.
      real(wp), intent(in) :: t, moment, unit
      real(wp) :: change(3, 3)
      integer :: i
      change = 0.0_wp
      if (.not. (effects%varies .and. allocated(variation%effects))) return
      do i = 1, size(variation%effects)
         associate (item => variation%effects(i))
            if (item%kind == OF_TORQUE) &
               change = change + effects%torques(item%place)%item%inertia_derivative(item%change, j, t, moment, unit)
         end associate
      end do
   end function added_inertia

   !> Adds the changes of effects, and of the rate of the space axes, that follow from those of orbits. Errors:
   !> `NUTATE_BAD_ARGUMENT` if two orbits are equal, since effects identify their orbit by its elements.
   subroutine follow_orbits(self, effects, status)
      class(variation_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      type(status_t), intent(inout) :: status
      real(wp), allocatable :: change(:)
      integer :: i, m
      if (.not. allocated(self%effects)) return
      do m = 1, size(self%effects)
         if (self%effects(m)%kind /= OF_ORBIT) cycle
         change = self%effects(m)%change
         associate (orbit => effects%orbits(self%effects(m)%place))
            if (count([(orbit%path%equals(effects%orbits(i)%path), i=1, size(effects%orbits))]) > 1) &
               status = fail(NUTATE_BAD_ARGUMENT, 'orbits that are equal have no derivatives (expected different ones)')
            self%frame = self%frame + frame_rate_change(orbit, change)
            call follow_path(self, effects, orbit%path, change)
         end associate
      end do
   end subroutine follow_orbits

   !> Adds the changes of the effects that follow a path.
   subroutine follow_path(self, effects, path, change)
      class(variation_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      type(kepler_orbit_t), intent(in) :: path
      !> Change of the elements of the path.
      real(wp), intent(in) :: change(:)
      integer :: i
      logical :: there
      do i = 1, effects%n_potentials + effects%n_off
         associate (slot => effects%potentials(i))
            if (slot%item%follows(path)) there = changes(self, slot%item, OF_POTENTIAL, slot%place, 'orbit', change)
         end associate
      end do
      do i = 1, effects%n_torques
         if (effects%torques(i)%item%follows(path)) &
            there = changes(self, effects%torques(i)%item, OF_TORQUE, i, 'orbit', change)
      end do
      do i = 1, effects%n_wheels
         if (effects%wheels(i)%follows(path)) &
            there = changes(self, effects%wheels(i), OF_WHEEL, i, 'orbit', change)
      end do
   end subroutine follow_path

   !> Computes the change of coefficient j of the power series of E and -e of a potential (`nutate_reshaped_potential`).
   pure subroutine reshaping_term(variation, effects, i, j, t, moment, unit, inertia, stiffness, slope)
      use nutate_reshaped_potential, only: potential_term
      type(variation_t), intent(in) :: variation
      type(effect_list_t), intent(in) :: effects
      !> Index of the potential; coefficient.
      integer, intent(in) :: i, j
      !> Time, a time inside of the step that begins, ends or contains it, and unit of time, s.
      real(wp), intent(in) :: t, moment, unit
      !> Change of J at that time, `inertia_of` of the sensitivity, kg m²; shape (3,3).
      real(wp), intent(in) :: inertia(3, 3)
      !> δE, shape (3,3), and -δe, shape (3), body axes.
      real(wp), intent(out) :: stiffness(3, 3), slope(3)
      real(wp) :: factors(2), added(3, 3)
      integer :: n
      factors = 0.0_wp
      associate (slot => effects%potentials(i))
         if (allocated(variation%effects)) then
            do n = 1, size(variation%effects)
               if (variation%effects(n)%kind == OF_POTENTIAL .and. variation%effects(n)%place == slot%place) &
                  factors = factors + slot%item%factor_change(variation%effects(n)%change)
            end do
         end if
         call potential_term(effects, i, j, t, moment, unit, stiffness, slope, factors)
         if (j == 0) then
            added = inertia - change_at_start(effects, variation)
         else
            added = added_inertia(variation, effects, j, t, moment, unit)
         end if
         stiffness = stiffness + slot%item%by_inertia*added
      end associate
   end subroutine reshaping_term

   !> Returns true for a sensitivity that changes more than the initial state.
   pure logical function is_parametric(self)
      class(variation_t), intent(in) :: self
      is_parametric = any(abs(self%inertia) > 0.0_wp) .or. any(abs(self%rotor) > 0.0_wp) .or. &
                      any(abs(self%frame) > 0.0_wp) .or. allocated(self%effects) .or. self%moves_inertia
   end function is_parametric

   !> Returns true if an element of an orbit changes.
   pure logical function changes_orbit(self)
      class(variation_t), intent(in) :: self
      changes_orbit = .false.
      if (allocated(self%effects)) changes_orbit = any(self%effects%kind == OF_ORBIT)
   end function changes_orbit

end module nutate_variation
