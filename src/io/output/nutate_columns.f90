!> The columns of a history: sets of the table of quantities, and their values.
module nutate_columns
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_quiet_nan, ieee_value
   use nutate_archive, only: archive_t
   use nutate_attitude, only: roll_pitch_yaw_from_quat
   use nutate_chaos, only: chaos_t
   use nutate_control_columns, only: controller_values, field_in_body
   use nutate_effect_columns, only: energies_of, energy_headers, work_headers, works_of
   use nutate_effect_list, only: effect_list_t
   use nutate_followed_angles, only: followed_angles_t
   use nutate_hamiltonian, only: angular_velocity, body_momentum, conserved_energy, kinetic_energy, potential_energy, &
      relative_rate, space_momentum
   use nutate_kinds, only: wp, pi
   use nutate_quantity_motion, only: attitude_in_lvlh, quantity_value
   use nutate_motion, only: find_motion, motion_t
   use nutate_quaternion, only: quat_normalized, quat_product, rotate_to_space
   use nutate_observer, only: run_record_t
   use nutate_orbit, only: orbit_t
   use nutate_propagated_columns, only: propagated_t, propagated_headers, propagated_values, &
      propagated_width, is_by_free, SENSITIVITIES
   use nutate_quantities, only: find_missing, find_set, headers_of, last_of_set, quantities, quantity_t, set_names, &
      set_of, turns_to_degrees, width_of, NEEDS_CONTROLLER, NEEDS_TARGET, Q_CONJUGATE_MOMENTUM, Q_CONSTRAINTS, &
      Q_CONTROLLER, Q_ECLIPSE, Q_ORBIT_POSITION, Q_ENERGIES, Q_ENERGY, Q_EULER, Q_FIELD, Q_FRAME_ATTITUDE, Q_JACOBI, &
      Q_MOMENTUM, Q_MOMENTUM_SPACE, Q_PROPAGATED, Q_QUATERNION, Q_RATE, Q_RATE_SPACE, Q_ROLL_PITCH_YAW, Q_SOLVER, &
      Q_TIME_DEPENDENT_WORK, Q_TUMBLING, Q_WHEEL_SPEED, Q_WORKS
   use nutate_spelling, only: comma_list, nearest_name, split_list
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_NOT_FINITE
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   use nutate_tumbling_columns, only: tumbling_values
   implicit none
   private

   public :: columns_t, need_attitude

   !> One radian in degrees.
   real(wp), parameter :: degree = 180.0_wp/pi

   !> Values that several sets share, and values kept from earlier states.
   type :: shared_t
      !> Ω, body axes, rad/s; shape (3). Set only if a set of columns needs it.
      real(wp) :: omega(3) = 0.0_wp
      !> H of the first state, J; the Jacobi integral if the space axes rotate. Set only if a set of columns needs it.
      real(wp) :: first_energy = 0.0_wp
      !> 1/J0, kg⁻¹ m⁻².
      real(wp) :: inverse_j0 = 0.0_wp
   end type shared_t

   !> The sets of columns of a history. Values that no set needs are never evaluated.
   type :: columns_t
      !> Position in the table of the first quantity of each requested set.
      integer, allocatable, private :: chosen(:)
      !> Number of all columns, including t, and of the columns of each chosen set; shape (that of `chosen`).
      integer :: width = 1
      integer, allocatable, private :: widths(:)
      !> Names of the columns for each effect, comma separated.
      character(len=:), allocatable, private :: energies, works
      !> True if records must have `works`.
      logical :: needs_works = .false.
      !> True if columns show values of the step that ends at a row: commands of controllers.
      logical :: shows_commands = .false.
      !> True if `follow` must be called with the state after every step.
      logical :: follows_steps = .false.
      !> True if columns show quantities that a run propagates: `evaluate` needs its sensitivities.
      logical :: differentiates = .false.
      !> Number of the chosen sets without propagated quantities, which come first, and of their columns, including t.
      integer, private :: n_plain = 0
      integer :: plain_width = 1
      type(propagated_t), allocatable, private :: propagated
      integer, private :: n_wheels = 0
      !> True for angles in degrees, rates in degrees per second.
      logical, private :: degrees = .false.
      logical, private :: needs_rate = .false.
      type(shared_t), private :: shared
      !> Euler angles of each chosen set that has some; shape (that of `chosen`) if there is one.
      type(followed_angles_t), allocatable, private :: followed(:)
      !> Numbers of the chosen sets that follow angles.
      integer, allocatable, private :: angle_sets(:)
   contains
      !> Selects the sets by name.
      procedure :: choose
      !> Returns the header row.
      procedure :: header
      !> Returns an error for a row with a value that is not finite, with the name of its column.
      procedure :: check_row
      !> Stores the first state.
      procedure :: start
      !> Follows angles that must not lose revolutions between rows.
      procedure :: follow
      !> Evaluates one row.
      procedure :: evaluate
      !> Writes or reads the values kept from earlier states in checkpoint data.
      procedure :: transfer => transfer_columns
   end type columns_t

contains

   !> Returns true if one of the named sets depends on the attitude.
   pure logical function need_attitude(names)
      character(len=*), intent(in) :: names(:)
      integer :: i
      need_attitude = any([(any(names == set_of(quantities(i))) .and. quantities(i)%attitude, i=1, size(quantities))])
   end function need_attitude

   !> Selects sets by name, in any order. Errors: `NUTATE_BAD_ARGUMENT` for a name that is not in the table, for
   !> a wheel, an orbit or a sun that does not exist, for two sets with the same columns, and for sets of quantities
   !> that the run does not propagate.
   subroutine choose(self, names, status, degrees, effects, propagated)
      class(columns_t), intent(inout) :: self
      character(len=*), intent(in) :: names(:)
      type(status_t), intent(out) :: status
      !> Angles in degrees, rates in degrees per second, which the names of their columns say; default `.false.`.
      logical, intent(in), optional :: degrees
      !> Effects of the system; default: everything that columns need exists, and no effect has separate columns.
      type(effect_list_t), intent(in), optional :: effects
      !> Quantities that the run propagates; default: none.
      type(propagated_t), intent(in), optional :: propagated
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
   end subroutine choose

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
         if (present(effects)) then
            if (any(kinds == Q_ENERGIES)) self%energies = energy_headers(effects)
            if (self%needs_works) self%works = work_headers(effects)
            self%n_wheels = effects%n_wheels
         end if
         self%n_plain = count(kinds /= Q_PROPAGATED)
         self%differentiates = self%n_plain < size(kinds)
         if (self%differentiates) self%propagated = propagated
         self%widths = spread(0, 1, size(kinds))
         do i = 1, self%n_plain
            do k = self%chosen(i), last_of_set(self%chosen(i))
               self%widths(i) = self%widths(i) + size(split_list(set_header(self, k)))
            end do
         end do
         do i = self%n_plain + 1, size(kinds)
            self%widths(i) = propagated_width(quantities(self%chosen(i))%propagated, propagated, self%n_wheels)
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

   !> Returns the header row: the names of all columns, comma separated.
   pure function header(self, plain) result(line)
      class(columns_t), intent(in) :: self
      !> True to leave out the columns of derivatives; default false.
      logical, intent(in), optional :: plain
      character(len=:), allocatable :: line
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
                                              self%degrees)
      end do
   end function header

   !> Checks a row. Errors: `NUTATE_NOT_FINITE` for a value that is not finite, with the name of its column.
   subroutine check_row(self, values, status)
      class(columns_t), intent(in) :: self
      !> A row, t first.
      real(wp), intent(in) :: values(:)
      type(status_t), intent(inout) :: status
      character(len=:), allocatable :: names
      integer :: i, k
      k = findloc(ieee_is_finite(values), .false., dim=1)
      if (k == 0) return
      names = self%header()//','
      do i = 2, k
         names = names(index(names, ',') + 1:)
      end do
      status = fail(NUTATE_NOT_FINITE, 'a value of the history, '//names(:index(names, ',') - 1)//', is not finite')
   end subroutine check_row

   !> Stores the first state.
   pure subroutine start(self, system, state, inverse_j0, backward)
      class(columns_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> 1/J0, kg⁻¹ m⁻².
      real(wp), intent(in) :: inverse_j0
      !> True if the run goes backward in time; default false.
      logical, intent(in), optional :: backward
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
         associate (set => self%angle_sets(i))
            call self%followed(set)%start(quantities(self%chosen(set))%sequence, state%q, omega)
         end associate
      end do
   end subroutine start

   !> Follows angles that must not lose revolutions between rows. Call it after every step if `follows_steps`.
   pure subroutine follow(self, state)
      class(columns_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      integer :: i
      do i = 1, size(self%angle_sets)
         call self%followed(self%angle_sets(i))%follow(state%q)
      end do
   end subroutine follow

   !> Evaluates one row: t, then the values of the sets.
   pure subroutine evaluate(self, system, state, record, values, tangent, chaos)
      class(columns_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      !> Values of the row; shape (width), or shape (plain_width) without sensitivities.
      real(wp), intent(out) :: values(:)
      !> Sensitivities: one for each parameter, then others; needed only if `differentiates`.
      type(tangent_t), intent(in), optional :: tangent
      !> Indicators of chaos; needed only by their columns.
      type(chaos_t), intent(in), optional :: chaos
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
   end subroutine evaluate

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

   !> Computes the values of a set of a wheel, of a controller, of the field, of tumbling elements, of an orbit or of a
   !> frame, or of one quantity as events evaluate it.
   pure subroutine write_part(first, system, state, values)
      !> Position of the first quantity of the set.
      integer, intent(in) :: first
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Values of the set; shape (width of the set).
      real(wp), intent(out) :: values(:)
      type(motion_t) :: motion
      integer :: k
      associate (number => quantities(first)%number)
         select case (quantities(first)%kind)
         case (Q_ORBIT_POSITION)
            values = 0.0_wp
            if (system%effects%on_orbit) values = place_on_orbit(system%effects%orbit, state%t)
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
            do k = 1, size(values)
               values(k) = quantity_value(quantities(first), k, system, motion)
            end do
         end select
      end associate
   end subroutine write_part

   !> Returns the position on an orbit, inertial axes, m, the distance, m, and the true anomaly, rad; shape (5).
   pure function place_on_orbit(orbit, t) result(values)
      type(orbit_t), intent(in) :: orbit
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: values(5)
      values = [orbit%path%position(t), orbit%path%radius(t), orbit%path%true_anomaly(t)]
   end function place_on_orbit

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
         if (frame%contains_time(state%t)) call frame%relative( &
            state%t, quat_product(system%effects%space_axes(state%t), state%q), values(:4), values(5))
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
      if (i > system%effects%n_wheels) return
      values(1) = system%effects%wheels(i)%speed_of(state%wheel_momentum(i), angular_velocity(system, state))
      values(2) = state%wheel_momentum(i)
      values(3:4) = state%wheel_work(:, i)
   end function of_wheel

   !> Writes or reads the values kept from earlier states in checkpoint data.
   subroutine transfer_columns(self, archive)
      class(columns_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      integer :: i
      do i = 1, size(self%angle_sets)
         call self%followed(self%angle_sets(i))%transfer(archive)
      end do
      call archive%transfer(self%shared%first_energy)
   end subroutine transfer_columns

end module nutate_columns
