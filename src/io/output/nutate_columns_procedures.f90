!> Bodies of the procedures whose interfaces are in `nutate_columns`.
submodule(nutate_columns) nutate_columns_procedures
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_quiet_nan, ieee_value
   use nutate_attitude, only: roll_pitch_yaw_from_quat
   use nutate_control_quantities, only: controller_values, field_in_body, Q_CONTROLLER, Q_FIELD
   use nutate_effect_columns, only: energies_of, energy_headers, work_headers, works_of
   use nutate_energy_quantities, only: Q_CONSTRAINTS, Q_ENERGIES, Q_ENERGY, Q_JACOBI, Q_SOLVER, &
      Q_TIME_DEPENDENT_WORK, Q_WORKS
   use nutate_frame_quantities, only: Q_FRAME_ATTITUDE
   use nutate_hamiltonian, only: angular_velocity, body_momentum, conserved_energy, kinetic_energy, &
      potential_energy, relative_rate, space_momentum
   use nutate_motion, only: find_motion, motion_t
   use nutate_motion_quantities, only: Q_CONJUGATE_MOMENTUM, Q_EULER, Q_MOMENTUM, Q_MOMENTUM_SPACE, Q_QUATERNION, &
      Q_RATE, Q_RATE_SPACE
   use nutate_moving_frame, only: has_time, see_from_frame
   use nutate_orbit_quantities, only: attitude_in_lvlh, Q_ECLIPSE, Q_ORBIT_POSITION, Q_ROLL_PITCH_YAW
   use nutate_propagated_columns, only: propagated_headers, propagated_values, propagated_width, is_by_free, &
      Q_PROPAGATED, SENSITIVITIES
   use nutate_quantities, only: find_missing, find_set, headers_of, last_of_set, quantities, set_names, set_of, &
      turns_to_degrees, width_of
   use nutate_quantity, only: quantity_t, NEEDS_CONTROLLER, NEEDS_TARGET
   use nutate_quantity_motion, only: quantity_value
   use nutate_quaternion, only: quat_normalized, quat_product, rotate_to_space
   use nutate_spelling, only: comma_list, nearest_name, split_list
   use nutate_status, only: fail, NUTATE_BAD_ARGUMENT, NUTATE_NOT_FINITE
   use nutate_tumbling_quantities, only: tumbling_values, Q_TUMBLING
   use nutate_wheel_quantities, only: Q_WHEEL_SPEED
   implicit none

contains

   module procedure need_attitude
      integer :: i
      need_attitude = .false.
      do i = 1, size(quantities)
         if (quantities(i)%attitude .and. .not. need_attitude) need_attitude = any(names == set_of(quantities(i)))
      end do
   end procedure need_attitude

   module procedure choose
      integer :: i, first
      logical :: is_chosen(size(quantities))

      is_chosen = .false.
      do i = 1, size(names)
         first = find_set(names(i))
         if (first == 0) then
            status = fail(NUTATE_BAD_ARGUMENT, "no set of columns is called '"//trim(names(i))//"' ("// &
                          hint(nearest_name(names(i), set_names()))//')', 'columns')
         else
            if (present(effects)) call check_available(quantities(first), effects, status)
            if (status%ok()) call check_propagated(quantities(first), status, propagated)
            is_chosen(first) = .true.
         end if
         if (.not. status%ok()) return
      end do
      if (present(effects) .and. any(names == 'roll_pitch_yaw') .and. any(names == 'lvlh_attitude')) then
         status = fail(NUTATE_BAD_ARGUMENT, "columns 'lvlh_attitude' include 'roll_pitch_yaw' (expected one of "// &
                       'them)', 'columns')
         return
      end if
      self%chosen = pack([(i, i=1, size(quantities))], is_chosen)
      self%degrees = .false.
      if (present(degrees)) self%degrees = degrees
      call find_widths(self, effects, propagated)
      associate (kinds => quantities(self%chosen)%kind, needs => quantities(self%chosen)%needs)
         self%needs_rate = any(kinds == Q_RATE .or. kinds == Q_RATE_SPACE)
         self%angle_sets = pack([(i, i=1, size(kinds))], kinds == Q_EULER)
         self%follows_steps = size(self%angle_sets) > 0
         self%shows_commands = any(needs == NEEDS_CONTROLLER .or. needs == NEEDS_TARGET)
      end associate
   end procedure choose

   !> Finds the number of columns of each chosen set.
   pure subroutine find_widths(self, effects, propagated)
      class(columns_t), intent(inout) :: self
      type(effect_list_t), intent(in), optional :: effects
      type(propagated_t), intent(in), optional :: propagated
      integer :: i, k
      associate (kinds => quantities(self%chosen)%kind)
         self%needs_works = any(kinds == Q_WORKS)
         self%energies = ''
         self%works = ''
         self%n_wheels = 0
         self%n_spheres = 0
         if (present(effects)) then
            if (any(kinds == Q_ENERGIES)) self%energies = energy_headers(effects)
            if (self%needs_works) self%works = work_headers(effects)
            self%n_wheels = effects%n_reaction_wheels
            self%n_spheres = effects%n_spheres
         end if
         self%n_plain = count(kinds /= Q_PROPAGATED)
         self%differentiates = self%n_plain < size(kinds)
         if (self%differentiates) self%propagated = propagated
         self%widths = spread(0, 1, size(kinds))
         do i = 1, self%n_plain
            do k = self%chosen(i), last_of_set(self%chosen(i))
               if (any(quantities(k)%kind == [Q_ENERGIES, Q_WORKS])) then
                  self%widths(i) = self%widths(i) + size(split_list(set_header(self, k)))
               else
                  self%widths(i) = self%widths(i) + width_of(quantities(k))
               end if
            end do
         end do
         do i = self%n_plain + 1, size(kinds)
            self%widths(i) = propagated_width(quantities(self%chosen(i))%propagated, propagated, &
                                               self%n_wheels + 3*self%n_spheres)
         end do
      end associate
      self%plain_width = 1 + sum(self%widths(:self%n_plain))
      self%width = 1 + sum(self%widths)
   end subroutine find_widths

   !> Returns the names of the columns of a quantity that no run propagates, comma separated.
   pure function set_header(self, at) result(names)
      class(columns_t), intent(in) :: self
      !> Position in the table.
      integer, intent(in) :: at
      character(len=:), allocatable :: names
      select case (quantities(at)%kind)
      case (Q_ENERGIES)
         names = self%energies
      case (Q_WORKS)
         names = self%works
      case default
         names = headers_of(quantities(at), self%degrees)
      end select
   end function set_header

   !> Checks that a run propagates a quantity. Errors: `NUTATE_BAD_ARGUMENT` for derivatives without parameters, for
   !> standard deviations if no parameter has one, and for indicators of chaos that the run does not follow.
   subroutine check_propagated(quantity, status, propagated)
      type(quantity_t), intent(in) :: quantity
      type(status_t), intent(inout) :: status
      type(propagated_t), intent(in), optional :: propagated
      character(len=:), allocatable :: need
      if (quantity%kind /= Q_PROPAGATED) return
      if (.not. present(propagated)) then
         status = fail(NUTATE_BAD_ARGUMENT, "only nutate run writes the columns '"//trim(set_of(quantity))// &
                       "' (expected others)", 'columns')
         return
      end if
      need = ''
      if (.not. is_by_free(quantity%propagated)) then
         if (propagated%exponents == 0) need = 'indicators of chaos (expected &chaos)'
      else if (size(propagated%names) == 0) then
         need = 'free parameters (expected &free)'
      else if (quantity%propagated /= SENSITIVITIES .and. .not. any(propagated%sigma > 0.0_wp)) then
         need = 'standard deviations (expected sigma in &free)'
      end if
      if (need /= '') status = fail(NUTATE_BAD_ARGUMENT, "columns '"//trim(set_of(quantity))//"' need "//need, &
                                    'columns')
   end subroutine check_propagated

   !> Returns a hint what to write instead of an unknown name.
   pure function hint(nearest) result(text)
      !> Nearest name; blank if there is none.
      character(len=*), intent(in) :: nearest
      character(len=:), allocatable :: text
      text = 'nearest: '//nearest
      if (nearest == '') text = 'expected a set such as '//comma_list(quantities(1:3)%set)
   end function hint

   !> Checks that a quantity is available. Errors: `NUTATE_BAD_ARGUMENT` for a set of a wheel, a controller, a field, an
   !> orbit or a sun that does not exist.
   subroutine check_available(quantity, effects, status)
      type(quantity_t), intent(in) :: quantity
      type(effect_list_t), intent(in) :: effects
      type(status_t), intent(out) :: status
      character(len=:), allocatable :: missing, expected
      call find_missing(quantity, effects, missing, expected)
      if (missing /= '') status = fail(NUTATE_BAD_ARGUMENT, "columns '"//trim(set_of(quantity))//"' "//missing// &
                                       ' (expected '//expected//')', 'columns')
   end subroutine check_available

   module procedure header
      integer :: i, k
      line = 't'
      do i = 1, self%n_plain
         do k = self%chosen(i), last_of_set(self%chosen(i))
            line = line//','//set_header(self, k)
         end do
      end do
      if (present(plain)) then
         if (plain) return
      end if
      do i = self%n_plain + 1, size(self%chosen)
         line = line//','//propagated_headers(quantities(self%chosen(i))%propagated, self%propagated, self%n_wheels, &
                                              self%n_spheres, self%degrees)
      end do
   end procedure header

   module procedure check_row
      character(len=:), allocatable :: names
      integer :: i, k
      k = findloc(ieee_is_finite(values), .false., dim=1)
      if (k == 0) return
      names = self%header()//','
      do i = 2, k
         names = names(index(names, ',') + 1:)
      end do
      status = fail(NUTATE_NOT_FINITE, 'a value of the history, '//names(:index(names, ',') - 1)//', is not finite')
   end procedure check_row

   module procedure start
      real(wp) :: omega(3)
      integer :: i
      self%shared%inverse_j0 = inverse_j0
      if (any(quantities(self%chosen)%kind == Q_ENERGY)) &
         self%shared%first_energy = conserved_energy(system, state, inverse_j0)
      if (.not. self%follows_steps) return
      omega = relative_rate(system, state)
      if (present(backward)) omega = merge(-omega, omega, backward)
      if (allocated(self%followed)) deallocate (self%followed)
      allocate (self%followed(size(self%chosen)))
      do i = 1, size(self%angle_sets)
         call self%followed(self%angle_sets(i))%start(quantities(self%chosen(self%angle_sets(i)))%sequence, &
                                                      state%q, omega)
      end do
   end procedure start

   module procedure follow
      integer :: i
      do i = 1, size(self%angle_sets)
         call self%followed(self%angle_sets(i))%follow(state%q)
      end do
   end procedure follow

   module procedure evaluate
      integer :: i, first, last

      if (self%needs_rate) self%shared%omega = angular_velocity(system, state)
      values(1) = state%t
      first = 2
      do i = 1, self%n_plain
         last = first + self%widths(i) - 1
         if (quantities(self%chosen(i))%kind == Q_EULER) then
            values(first:last) = self%followed(i)%angles()
         else
            call write_set(self%chosen(i), system, state, record, self%shared, values(first:last))
         end if
         if (self%degrees) call turn_to_degrees(self%chosen(i), values(first:last))
         first = last + 1
      end do
      if (.not. present(tangent)) return
      do i = self%n_plain + 1, size(self%chosen)
         last = first + self%widths(i) - 1
         call propagated_values(quantities(self%chosen(i))%propagated, self%propagated, system, state, tangent, &
                                chaos, merge(degree, 1.0_wp, self%degrees), values(first:last))
         first = last + 1
      end do
   end procedure evaluate

   !> Converts the angles and rates of a set to degrees.
   pure subroutine turn_to_degrees(first, values)
      !> Position of the first quantity of the set.
      integer, intent(in) :: first
      !> Values of the set; shape (width of the set).
      real(wp), intent(inout) :: values(:)
      integer :: k, at, width
      at = 0
      do k = first, last_of_set(first)
         width = width_of(quantities(k))
         if (turns_to_degrees(quantities(k))) values(at + 1:at + width) = values(at + 1:at + width)*degree
         at = at + width
      end do
   end subroutine turn_to_degrees

   !> Computes the values of one set.
   pure subroutine write_set(first, system, state, record, shared, values)
      !> Position of the first quantity of the set.
      integer, intent(in) :: first
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(shared_t), intent(in) :: shared
      !> Values of the set; shape (width of the set).
      real(wp), intent(out) :: values(:)
      real(wp) :: q(4)

      select case (quantities(first)%kind)
      case (Q_QUATERNION)
         values = state%q
      case (Q_CONJUGATE_MOMENTUM)
         values = state%p
      case (Q_RATE)
         values = shared%omega
      case (Q_RATE_SPACE)
         ! The quaternion is normalised, since a rotation keeps the length of Ω.
         values = rotate_to_space(quat_normalized(state%q), shared%omega)
      case (Q_MOMENTUM)
         values = body_momentum(state)
      case (Q_MOMENTUM_SPACE)
         values = space_momentum(state)
      case (Q_ENERGY)
         values(1) = kinetic_energy(system, state, shared%inverse_j0)
         values(2) = potential_energy(system%effects, state%q, state%t)
         values(3) = values(1) + values(2)
         values(4) = record%work - state%time_dependent_work
         values(5) = values(3) - shared%first_energy - record%work
         if (system%effects%frame_turns) values(5) = conserved_energy(system, state, shared%inverse_j0) &
                                                     - shared%first_energy - record%work
      case (Q_CONSTRAINTS)
         values = [dot_product(state%q, state%q) - 1, dot_product(state%q, state%p)]
      case (Q_SOLVER)
         values = [real(record%iterations, wp), record%residual]
      case (Q_JACOBI)
         values = conserved_energy(system, state, shared%inverse_j0)
      case (Q_ROLL_PITCH_YAW)
         q = attitude_in_lvlh(system, state%q, state%t)
         values(1:3) = roll_pitch_yaw_from_quat(q)
         values(4:) = q(:size(values) - 3)
      case (Q_TIME_DEPENDENT_WORK)
         values = state%time_dependent_work
      case (Q_ENERGIES)
         values = energies_of(system%effects, state, size(values))
      case (Q_WORKS)
         values = works_of(system%effects, record, size(values))
      case default
         call write_part(first, system, state, values)
      end select
   end subroutine write_set

   !> Computes the values of a set whose quantities share work, or of one as events evaluate its quantities.
   pure subroutine write_part(first, system, state, values)
      !> Position of the first quantity of the set.
      integer, intent(in) :: first
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Values of the set; shape (width of the set).
      real(wp), intent(out) :: values(:)
      type(motion_t) :: motion
      integer :: at, i, k
      associate (number => quantities(first)%number)
         select case (quantities(first)%kind)
         case (Q_ORBIT_POSITION)
            values = 0.0_wp
            if (system%effects%on_orbit) values = [system%effects%orbit%path%position(state%t), &
               system%effects%orbit%path%radius(state%t), system%effects%orbit%path%true_anomaly(state%t)]
         case (Q_ECLIPSE)
            values = 0.0_wp
            if (system%effects%on_orbit) values(2) = system%effects%orbit%shadow_depth(state%t)
            values(1) = merge(1.0_wp, 0.0_wp, values(2) > 0.0_wp)
         case (Q_WHEEL_SPEED)
            values = of_wheel(number, system, state)
         case (Q_TUMBLING)
            values = tumbling_values(system, state)
         case (Q_FRAME_ATTITUDE)
            values = seen_from_frame(number, system, state)
         case (Q_FIELD)
            values = field_in_body(system%effects, state)
         case (Q_CONTROLLER)
            values = controller_values(number, system, state)
         case default
            call find_motion(system, state, motion)
            at = 0
            do k = first, last_of_set(first)
               do i = 1, width_of(quantities(k))
                  at = at + 1
                  values(at) = quantity_value(quantities(k), quantities(k)%first + i - 1, system, motion)
               end do
            end do
         end select
      end associate
   end subroutine write_part

   !> Returns the attitude relative to a frame, and its angle, rad; not finite if the attitude of the frame is not
   !> known, which ends a run. Shape (5).
   pure function seen_from_frame(i, system, state) result(values)
      integer, intent(in) :: i
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp) :: values(5)
      values = ieee_value(values, ieee_quiet_nan)
      if (i > system%effects%n_frames) return
      associate (frame => system%effects%frames(i))
         if (has_time(frame, state%t)) call see_from_frame( &
            frame, state%t, quat_product(system%effects%space_axes(state%t), state%q), values(:4), values(5))
      end associate
   end function seen_from_frame

   !> Returns the speed of a wheel relative to the body, rad/s, its absolute momentum about the axis, N m s, and the
   !> work of motor and of friction so far, J; zeros if the wheel does not exist. Shape (4).
   pure function of_wheel(i, system, state) result(values)
      integer, intent(in) :: i
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp) :: values(4)
      values = 0.0_wp
      if (i > system%effects%n_reaction_wheels) return
      values(1) = system%effects%wheels(i)%speed_of(state%wheel_momentum(i), angular_velocity(system, state))
      values(2) = state%wheel_momentum(i)
      values(3:4) = state%wheel_work(:, i)
   end function of_wheel

   module procedure transfer_columns
      integer :: i
      do i = 1, size(self%angle_sets)
         call self%followed(self%angle_sets(i))%transfer(archive)
      end do
      call archive%transfer(self%shared%first_energy)
   end procedure transfer_columns

end submodule nutate_columns_procedures
