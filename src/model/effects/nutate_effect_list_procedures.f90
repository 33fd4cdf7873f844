!> Bodies of the procedures whose interfaces are in `nutate_effect_list`.
submodule(nutate_effect_list) nutate_effect_list_procedures
   use nutate_admissible, only: admits, fault_of, NON_NEGATIVE
   use nutate_effect_bounds, only: effect_bounds_t, linear_map_t
   use nutate_effect_traits, only: DRIVES_WHEELS, IS_EARTH_FIELD
   use nutate_inner_sphere, only: inner_sphere_t
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_rotor, only: rotor_t
   use nutate_status, only: fail, NUTATE_BAD_ARGUMENT
   use nutate_track, only: next_track_break, track_order
   use nutate_wheel, only: follow_switch
   implicit none

contains

   module procedure add
      integer :: i
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
      type is (inner_sphere_t)
         do i = 1, 3
            call add_wheel(self, effect%component(i))
         end do
      end select
   end procedure add

   module procedure turn_frame
      integer :: i
      self%frame_rate = self%frame_rate + rate
      self%frame_turns = any(abs(self%frame_rate) > 0.0_wp)
      do i = 1, self%n_torques
         self%torques(i)%item%frame_rate = self%frame_rate
      end do
   end procedure turn_frame

   module procedure knows_space_axes
      knows_space_axes = .not. self%frame_turns
      if (self%on_orbit) knows_space_axes = knows_space_axes .or. self%orbit%is_frame
   end procedure knows_space_axes

   module procedure space_axes
      q = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      if (.not. self%on_orbit) return
      if (self%orbit%is_frame) q = self%orbit%path%axes(t)
   end procedure space_axes

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

   module procedure n_works
      n_works = self%n_torques + 2*self%n_wheels
      if (self%depends_on_time) n_works = n_works + 1
   end procedure n_works

   module procedure inertia_term
      integer :: i
      term = 0.0_wp
      do i = 1, self%n_torques
         associate (item => self%torques(i)%item)
            if (item%changes_inertia) term = term + item%inertia_term(j, t, moment, unit)
         end associate
      end do
   end procedure inertia_term

   module procedure inner_momentum
      integer :: i
      momentum = self%rotor_momentum
      do i = 1, self%n_wheels
         momentum = momentum + momenta(i)*self%wheels(i)%axis
      end do
   end procedure inner_momentum

   module procedure wheel_energy
      integer :: i
      energy = 0.0_wp
      do i = 1, self%n_wheels
         energy = energy + 0.5_wp*(momenta(i)/self%wheels(i)%inertia)*momenta(i)
      end do
   end procedure wheel_energy

   module procedure append
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
   end procedure append

   module procedure has
      integer :: i
      ! A change of the inertia cannot be switched.
      has = any([(self%torques(i)%item%label == label .and. .not. self%torques(i)%item%changes_inertia, &
                  i=1, self%n_torques)]) .or. &
            any([(self%potentials(i)%item%label == label, i=1, self%n_potentials + self%n_off)]) .or. &
            any([(self%wheels(i)%label == label, i=1, self%n_wheels)])
   end procedure has

   module procedure switch
      logical :: was_off
      integer :: i
      do i = 1, self%n_torques
         associate (torque => self%torques(i)%item)
            was_off = .not. torque%on
            if (.not. torque%changes_inertia) call switch_one(torque, label, on)
            ! A law that is switched off and on at one time begins again.
            if (was_off .and. torque%on) torque%was_on = .false.
         end associate
      end do
      do i = 1, self%n_potentials + self%n_off
         call switch_one(self%potentials(i)%item, label, on)
      end do
      do i = 1, self%n_wheels
         call switch_one(self%wheels(i), label, on)
         call follow_switch(self%wheels(i))
         if (allocated(self%wheels(i)%motor)) call switch_one(self%wheels(i)%motor, label, on)
      end do
      if (self%n_potentials + self%n_off > 0) call sort_potentials(self)
   end procedure switch

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

   module procedure transfer_switches
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
   end procedure transfer_switches

   module procedure feeds_back_to_wheels
      integer :: i
      feeds_back_to_wheels = any([(self%wheels(i)%has_law(), i=1, self%n_wheels)])
   end procedure feeds_back_to_wheels

   module procedure controls_wheels
      integer :: i
      controls_wheels = any([(self%torques(i)%item%has(DRIVES_WHEELS), i=1, self%n_torques)])
   end procedure controls_wheels

   module procedure command_of_wheel
      integer :: i
      command = 0.0_wp
      do i = 1, self%n_torques
         command = command + self%torques(i)%item%wheel_command(wheel)
      end do
   end procedure command_of_wheel

   module procedure bound_potential
      integer :: i
      logical :: taken
      call check_bounds(['gradient', 'hessian ', 'third   '], [gradient, hessian, third], status)
      if (.not. status%ok()) return
      do i = self%n_potentials, 1, -1
         call give_bounds(self%potentials(i)%item, [gradient, hessian, third, 0.0_wp], taken)
         if (taken) return
      end do
      status = fail(NUTATE_BAD_ARGUMENT, 'there is no user-defined potential to bound')
   end procedure bound_potential

   module procedure bound_torque
      integer :: i
      logical :: taken
      call check_bounds(['torque     ', 'by_rotation', 'second     ', 'rate       '], &
                        [torque, by_rotation, second, rate], status)
      if (.not. status%ok()) return
      do i = self%n_torques, 1, -1
         call give_bounds(self%torques(i)%item, [torque, by_rotation, second, rate], taken)
         if (taken) return
      end do
      status = fail(NUTATE_BAD_ARGUMENT, 'there is no user-defined torque to bound')
   end procedure bound_torque

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
      real(wp), intent(in) :: given(4)
      logical, intent(out) :: taken
      real(wp) :: kept(4)
      type(effect_bounds_t) :: with, without
      real(wp), parameter :: origin(3) = 0.0_wp
      kept = effect%given
      effect%given = -1.0_wp
      call effect%bound(linear_map_t(), 0.1_wp, origin, 2.0_wp, without)
      effect%given = given
      call effect%bound(linear_map_t(), 0.1_wp, origin, 2.0_wp, with)
      taken = with%known .and. .not. without%known
      if (.not. taken) effect%given = kept
   end subroutine give_bounds

   module procedure needs_attitude
      integer :: i
      needs_attitude = self%n_potentials + self%n_off > 0 .or. self%frame_turns .or. &
                       any([(self%torques(i)%item%needs_attitude(), i=1, self%n_torques)])
   end procedure needs_attitude

   module procedure next_break
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
         one = next_track_break(self%orbits(i)%path%track, t, sense)
         if (sense*one < sense*next) next = one
      end do
   end procedure next_break

   module procedure table_order
      integer :: i
      order = 0
      if (.not. self%on_orbit) return
      do i = 1, size(self%orbits)
         if (.not. allocated(self%orbits(i)%path%track)) cycle
         associate (track => self%orbits(i)%path%track)
            if (order == 0 .or. track_order(track) < order) order = track_order(track)
         end associate
      end do
   end procedure table_order

   module procedure thin_tables
      integer :: i
      if (.not. self%on_orbit) return
      do i = 1, size(self%orbits)
         call self%orbits(i)%path%thin_table()
      end do
      call self%orbit%path%thin_table()
      if (allocated(self%earth_field)) call self%earth_field%thin_table()
      do i = 1, self%n_potentials + self%n_off
         call self%potentials(i)%item%thin_table()
      end do
      do i = 1, self%n_torques
         call self%torques(i)%item%thin_table()
      end do
      do i = 1, self%n_wheels
         if (allocated(self%wheels(i)%motor)) call self%wheels(i)%motor%thin_table()
      end do
   end procedure thin_tables

   subroutine add_potential(self, effect)
      class(effect_list_t), intent(inout) :: self
      class(potential_t), intent(in) :: effect
      type(potential_slot_t), allocatable :: grown(:)
      integer :: i, n
      n = self%n_potentials + self%n_off
      self%moves = self%moves .or. effect%moves
      self%depends_on_time = self%depends_on_time .or. effect%moves
      if (effect%has(IS_EARTH_FIELD)) then
         self%in_earth_field = .true.
         if (allocated(self%earth_field)) deallocate (self%earth_field)
         allocate (self%earth_field, source=effect)
      end if
      allocate (grown(n + 1))
      do i = 1, n
         grown(i)%place = self%potentials(i)%place
         call move_alloc(self%potentials(i)%item, grown(i)%item)
      end do
      allocate (grown(n + 1)%item, source=effect)
      grown(n + 1)%place = n + 1
      call move_alloc(grown, self%potentials)
      call sort_potentials(self)
      call mark_potentials(self)
   end subroutine add_potential

   !> Adds a copy of a wheel to the list, on or off, before the components of inner spheres, or such a component behind
   !> them; `add_wheel` of a system also changes the inertia of the body.
   subroutine add_wheel(self, wheel)
      class(effect_list_t), intent(inout) :: self
      type(wheel_t), intent(in) :: wheel
      type(wheel_t), allocatable :: grown(:)
      integer :: i, place
      place = self%n_wheels + 1
      if (wheel%component == 0) place = self%n_reaction_wheels + 1
      allocate (grown(self%n_wheels + 1))
      do i = 1, self%n_wheels
         grown(merge(i, i + 1, i < place)) = self%wheels(i)
      end do
      grown(place) = wheel
      call move_alloc(grown, self%wheels)
      if (wheel%component == 0) self%n_reaction_wheels = self%n_reaction_wheels + 1
      if (wheel%component == 3) self%n_spheres = self%n_spheres + 1
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
      self%varies = self%varies .or. effect%changes_inertia
      self%depends_on_time = self%depends_on_time .or. effect%changes_inertia
      self%moves_center = self%moves_center .or. effect%moves_center
      call move_alloc(grown, self%torques)
      self%n_torques = self%n_torques + 1
      call mark_potentials(self)
   end subroutine add_torque

   !> Marks the potentials that vary with the body.
   subroutine mark_potentials(self)
      class(effect_list_t), intent(inout) :: self
      integer :: i
      self%reshapes = .false.
      do i = 1, self%n_potentials + self%n_off
         associate (item => self%potentials(i)%item)
            item%varies = self%varies .and. abs(item%by_inertia) > 0.0_wp .or. &
                          self%moves_center .and. abs(item%by_center) > 0.0_wp
            self%reshapes = self%reshapes .or. item%varies
         end associate
      end do
      self%moves = self%moves .or. self%reshapes
      self%depends_on_time = self%depends_on_time .or. self%reshapes
   end subroutine mark_potentials

end submodule nutate_effect_list_procedures
