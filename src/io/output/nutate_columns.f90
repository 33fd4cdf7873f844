!> The columns of a history: which sets there are, and what stands in them. A new set is a line of the table and a
!> case of `write_set`.
module nutate_columns
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_quiet_nan, ieee_value
   use nutate_archive, only: archive_t
   use nutate_attitude, only: roll_pitch_yaw_from_quat
   use nutate_chaos, only: chaos_t
   use nutate_control_columns, only: controller_values, field_in_body, has_controller, has_field, pointing_error
   use nutate_effect_columns, only: energies_of, energy_headers, work_headers, works_of
   use nutate_effect_list, only: effect_list_t
   use nutate_followed_angles, only: followed_angles_t
   use nutate_hamiltonian, only: angular_velocity, body_momentum, conserved_energy, kinetic_energy, potential_energy, &
      relative_rate, space_momentum
   use nutate_kinds, only: wp, pi
   use nutate_quaternion, only: quat_conjugate, quat_normalized, quat_product, rotate_to_space
   use nutate_observer, only: run_record_t
   use nutate_orbit, only: orbit_t
   use nutate_propagated_columns, only: propagated_t, propagated_headers, propagated_values, &
      propagated_width, is_by_free, COVARIANCE, DEVIATIONS, FLI, LYAPUNOV, MEGNO, SENSITIVITIES
   use nutate_spelling, only: comma_list, nearest_name, split_list
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_NOT_FINITE
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   use nutate_tumbling_columns, only: tumbling_values, tumbling_width
   implicit none
   private

   public :: columns_t, column_set_t, column_sets, need_attitude

   !> One set of columns.
   type :: column_set_t
      character(len=24) :: name = ''
      !> Number of its columns; 0: it depends on the effects of the system, or on what runs of the scene propagate.
      integer :: width = 0
      !> Their names, comma separated; where their number depends on the scene, the pattern of them.
      character(len=160) :: headers = ''
      !> Its values depend on the attitude; the potential energy does not count, since potentials need the attitude
      !> anyway.
      logical :: attitude = .true.
      !> Which of its columns are angles, or their rates: from one to another; none where the last is 0.
      integer :: first_angle = 1, last_angle = 0
      !> The wheel that it shows, 1 or more; 0: it is no wheel's.
      integer :: wheel = 0
      !> The controller that it shows, 1 or more; 0: it is no controller's. It shows that controller's pointing error.
      integer :: controller = 0
      logical :: points = .false.
      !> It shows the magnetic field.
      logical :: field = .false.
      !> It shows an orbit; the sun of an orbit.
      logical :: orbit = .false., sun = .false.
      !> It shows tumbling elements.
      logical :: tumbling = .false.
      !> The frame relative to which it shows the attitude, 1 or more; 0: none.
      integer :: frame = 0
      !> Its columns are the Euler angles of this sequence of axes.
      character(len=3) :: sequence = ''
      !> `SENSITIVITIES`, ... of `nutate_propagated_columns`; 0: the run need not carry anything. These sets stand last.
      integer :: propagated = 0
   end type column_set_t

   !> Positions in the table.
   integer, parameter :: QUATERNION = 1, CONJUGATE_MOMENTUM = 2, RATE = 3, RATE_SPACE = 4, MOMENTUM = 5, &
      MOMENTUM_SPACE = 6, ENERGY = 8, CONSTRAINTS = 9, SOLVER = 10, JACOBI = 11, &
      LVLH_ATTITUDE = 12, ORBIT = 13, ECLIPSE = 14, TIME_DEPENDENT_WORK = 15, ROLL_PITCH_YAW = 22, &
      ENERGIES = 34, WORKS = 35

   !> All sets of columns, in the order in which they stand in a history.
   type(column_set_t), parameter :: column_sets(*) = [ &
      column_set_t('quaternion', 4, 'q0,q1,q2,q3'), &
      column_set_t('conjugate_momentum', 4, 'p0,p1,p2,p3'), &
      column_set_t('angular_velocity', 3, 'omega1,omega2,omega3', attitude=.false., last_angle=3), &
      column_set_t('angular_velocity_space', 3, 'omega_x,omega_y,omega_z', last_angle=3), &
      column_set_t('angular_momentum', 3, 'L1,L2,L3', attitude=.false.), &
      column_set_t('angular_momentum_space', 3, 'l_x,l_y,l_z'), &
      column_set_t('euler', 3, 'phi,theta,psi', last_angle=3, sequence='313'), &
      column_set_t('energy', 5, 'kinetic,potential,total,work,energy_residual', attitude=.false.), &
      column_set_t('constraints', 2, 'norm_error,orthogonality'), &
      column_set_t('solver', 2, 'iterations,step_residual', attitude=.false.), &
      column_set_t('jacobi', 1, 'jacobi'), &
      column_set_t('lvlh_attitude', 7, 'roll,pitch,yaw,lvlh_q0,lvlh_q1,lvlh_q2,lvlh_q3', last_angle=3, &
                   orbit=.true.), &
      column_set_t('orbit', 5, 'orbit_x,orbit_y,orbit_z,orbit_radius,true_anomaly', attitude=.false., &
                   first_angle=5, last_angle=5, orbit=.true.), &
      column_set_t('eclipse', 2, 'eclipse,shadow_depth', attitude=.false., orbit=.true., sun=.true.), &
      column_set_t('time_dependent_work', 1, 'time_dependent_work', attitude=.false.), &
      column_set_t('wheel1', 4, 'wheel1_speed,wheel1_momentum,wheel1_motor_work,wheel1_friction_work', &
                   attitude=.false., wheel=1), &
      column_set_t('wheel2', 4, 'wheel2_speed,wheel2_momentum,wheel2_motor_work,wheel2_friction_work', &
                   attitude=.false., wheel=2), &
      column_set_t('wheel3', 4, 'wheel3_speed,wheel3_momentum,wheel3_motor_work,wheel3_friction_work', &
                   attitude=.false., wheel=3), &
      column_set_t('wheel4', 4, 'wheel4_speed,wheel4_momentum,wheel4_motor_work,wheel4_friction_work', &
                   attitude=.false., wheel=4), &
      column_set_t('wheel5', 4, 'wheel5_speed,wheel5_momentum,wheel5_motor_work,wheel5_friction_work', &
                   attitude=.false., wheel=5), &
      column_set_t('wheel6', 4, 'wheel6_speed,wheel6_momentum,wheel6_motor_work,wheel6_friction_work', &
                   attitude=.false., wheel=6), &
      column_set_t('roll_pitch_yaw', 3, 'roll,pitch,yaw', last_angle=3), &
      column_set_t('euler_121', 3, 'euler_121_1,euler_121_2,euler_121_3', last_angle=3, sequence='121'), &
      column_set_t('euler_123', 3, 'euler_123_1,euler_123_2,euler_123_3', last_angle=3, sequence='123'), &
      column_set_t('euler_131', 3, 'euler_131_1,euler_131_2,euler_131_3', last_angle=3, sequence='131'), &
      column_set_t('euler_132', 3, 'euler_132_1,euler_132_2,euler_132_3', last_angle=3, sequence='132'), &
      column_set_t('euler_212', 3, 'euler_212_1,euler_212_2,euler_212_3', last_angle=3, sequence='212'), &
      column_set_t('euler_213', 3, 'euler_213_1,euler_213_2,euler_213_3', last_angle=3, sequence='213'), &
      column_set_t('euler_231', 3, 'euler_231_1,euler_231_2,euler_231_3', last_angle=3, sequence='231'), &
      column_set_t('euler_232', 3, 'euler_232_1,euler_232_2,euler_232_3', last_angle=3, sequence='232'), &
      column_set_t('euler_312', 3, 'euler_312_1,euler_312_2,euler_312_3', last_angle=3, sequence='312'), &
      column_set_t('euler_321', 3, 'euler_321_1,euler_321_2,euler_321_3', last_angle=3, sequence='321'), &
      column_set_t('euler_323', 3, 'euler_323_1,euler_323_2,euler_323_3', last_angle=3, sequence='323'), &
      column_set_t('energies', 0, 'energy_EFFECT', attitude=.false.), &
      column_set_t('works', 0, 'work_EFFECT', attitude=.false.), &
      column_set_t('controller1', 7, 'controller1_commanded1,controller1_commanded2,controller1_commanded3,'// &
                   'controller1_applied1,controller1_applied2,controller1_applied3,controller1_saturations', &
                   controller=1), &
      column_set_t('controller2', 7, 'controller2_commanded1,controller2_commanded2,controller2_commanded3,'// &
                   'controller2_applied1,controller2_applied2,controller2_applied3,controller2_saturations', &
                   controller=2), &
      column_set_t('controller3', 7, 'controller3_commanded1,controller3_commanded2,controller3_commanded3,'// &
                   'controller3_applied1,controller3_applied2,controller3_applied3,controller3_saturations', &
                   controller=3), &
      column_set_t('controller4', 7, 'controller4_commanded1,controller4_commanded2,controller4_commanded3,'// &
                   'controller4_applied1,controller4_applied2,controller4_applied3,controller4_saturations', &
                   controller=4), &
      column_set_t('controller5', 7, 'controller5_commanded1,controller5_commanded2,controller5_commanded3,'// &
                   'controller5_applied1,controller5_applied2,controller5_applied3,controller5_saturations', &
                   controller=5), &
      column_set_t('controller6', 7, 'controller6_commanded1,controller6_commanded2,controller6_commanded3,'// &
                   'controller6_applied1,controller6_applied2,controller6_applied3,controller6_saturations', &
                   controller=6), &
      column_set_t('pointing_error1', 1, 'pointing_error1', last_angle=1, controller=1, points=.true.), &
      column_set_t('pointing_error2', 1, 'pointing_error2', last_angle=1, controller=2, points=.true.), &
      column_set_t('pointing_error3', 1, 'pointing_error3', last_angle=1, controller=3, points=.true.), &
      column_set_t('pointing_error4', 1, 'pointing_error4', last_angle=1, controller=4, points=.true.), &
      column_set_t('pointing_error5', 1, 'pointing_error5', last_angle=1, controller=5, points=.true.), &
      column_set_t('pointing_error6', 1, 'pointing_error6', last_angle=1, controller=6, points=.true.), &
      column_set_t('magnetic_field', 3, 'B1,B2,B3', field=.true.), &
      column_set_t('tumbling', tumbling_width, 'energy_ratio,short_axis_mode,precession_period_short,'// &
                   'precession_period_long,rotation_period,pole_longitude,pole_latitude,sense', first_angle=6, &
                   last_angle=7, tumbling=.true.), &
      column_set_t('frame1', 5, 'frame1_q0,frame1_q1,frame1_q2,frame1_q3,frame1_angle', first_angle=5, last_angle=5, &
                   frame=1), &
      column_set_t('frame2', 5, 'frame2_q0,frame2_q1,frame2_q2,frame2_q3,frame2_angle', first_angle=5, last_angle=5, &
                   frame=2), &
      column_set_t('frame3', 5, 'frame3_q0,frame3_q1,frame3_q2,frame3_q3,frame3_angle', first_angle=5, last_angle=5, &
                   frame=3), &
      column_set_t('sensitivities', 0, 'd_COMPONENT/d_KEY', propagated=SENSITIVITIES), &
      column_set_t('standard_deviations', 0, 'sigma_COMPONENT', propagated=DEVIATIONS), &
      column_set_t('covariance', 0, 'covariance_COMPONENT_COMPONENT', propagated=COVARIANCE), &
      column_set_t('lyapunov', 0, 'lyapunovN', propagated=LYAPUNOV), &
      column_set_t('megno', 1, 'megno', propagated=MEGNO), &
      column_set_t('fli', 1, 'fli', propagated=FLI)]

   !> A radian.
   real(wp), parameter :: degree = 180.0_wp/pi

   !> What several sets share, and what is remembered from earlier states.
   type :: shared_t
      !> Ω, body axes, rad/s; shape (3). Only where a set needs it.
      real(wp) :: omega(3) = 0.0_wp
      !> H of the first state, J; the Jacobi integral where the space axes turn. Only where a set needs it.
      real(wp) :: first_energy = 0.0_wp
      !> 1/J0, kg⁻¹ m⁻².
      real(wp) :: inverse_j0 = 0.0_wp
   end type shared_t

   !> The sets of a history. What no set asks for is never evaluated.
   type :: columns_t
      !> The sets asked for, as positions in the table.
      integer, allocatable :: chosen(:)
      !> Number of columns, that of t included, and of each chosen set; shape (that of `chosen`).
      integer :: width = 1
      integer, allocatable, private :: widths(:)
      !> Names of the columns for each effect, comma separated.
      character(len=:), allocatable, private :: energies, works
      !> Records must have `works`.
      logical :: needs_works = .false.
      !> They show what holds in the step that ends there: commands of controllers.
      logical :: shows_commands = .false.
      !> The state must be shown to `follow` after every step.
      logical :: follows_steps = .false.
      !> They show what a run propagates: `evaluate` needs its sensitivities.
      logical :: differentiates = .false.
      !> Number of the chosen sets that need none, which come first, and of their columns, that of t included.
      integer, private :: n_plain = 0
      integer :: plain_width = 1
      type(propagated_t), allocatable, private :: propagated
      integer, private :: n_wheels = 0
      !> Angles in degrees, rates in degrees per second.
      logical, private :: degrees = .false.
      logical, private :: needs_rate = .false.
      type(shared_t), private :: shared
      !> Euler angles of each chosen set that has some; shape (that of `chosen`) where there is one.
      type(followed_angles_t), allocatable, private :: followed(:)
      !> The chosen sets that follow angles, by number.
      integer, allocatable, private :: angle_sets(:)
   contains
      !> Selects the sets by name.
      procedure :: choose
      !> The header row.
      procedure :: header
      !> Fails for a row with a value that is not finite, with the name of its column.
      procedure :: check_row
      !> Stores the first state.
      procedure :: start
      !> Follows angles that must not lose turns between rows.
      procedure :: follow
      !> One row.
      procedure :: evaluate
      !> Shows to an archive what is remembered from earlier states.
      procedure :: transfer => transfer_columns
   end type columns_t

contains

   !> True if one of the named sets depends on the attitude.
   pure logical function need_attitude(names)
      character(len=*), intent(in) :: names(:)
      integer :: i
      need_attitude = any([(any(names == column_sets(i)%name) .and. column_sets(i)%attitude, i=1, size(column_sets))])
   end function need_attitude

   !> Selects sets by name, in any order. Errors: `NUTATE_BAD_ARGUMENT` for a name that is not in the table, for
   !> a wheel, an orbit or a sun that does not exist, for two sets with the same columns, and for those of what the run
   !> does not propagate.
   subroutine choose(self, names, status, degrees, effects, propagated)
      class(columns_t), intent(inout) :: self
      character(len=*), intent(in) :: names(:)
      type(status_t), intent(out) :: status
      !> Angles in degrees, rates in degrees per second, which the names of their columns say; default `.false.`.
      logical, intent(in), optional :: degrees
      !> Those of the system; default: there is all that columns ask for, and no effect that has columns of its own.
      type(effect_list_t), intent(in), optional :: effects
      !> What the run propagates; default: nothing.
      type(propagated_t), intent(in), optional :: propagated
      integer :: i

      do i = 1, size(names)
         if (any(column_sets%name == names(i))) then
            if (present(effects)) call check_available( &
               column_sets(findloc(column_sets%name, names(i), dim=1)), effects, status)
            if (status%ok()) call check_propagated(column_sets(findloc(column_sets%name, names(i), dim=1)), status, &
                                                    propagated)
            if (.not. status%ok()) return
            cycle
         end if
         status = fail(NUTATE_BAD_ARGUMENT, "no set of columns is called '"//trim(names(i))//"' ("// &
                       hint(nearest_name(names(i), column_sets%name))//')', 'columns')
         return
      end do
      if (present(effects) .and. any(names == 'roll_pitch_yaw') .and. any(names == 'lvlh_attitude')) then
         status = fail(NUTATE_BAD_ARGUMENT, "columns 'lvlh_attitude' include 'roll_pitch_yaw' (expected one of "// &
                       'them)', 'columns')
         return
      end if
      self%chosen = pack([(i, i=1, size(column_sets))], [(any(names == column_sets(i)%name), i=1, size(column_sets))])
      self%degrees = .false.
      if (present(degrees)) self%degrees = degrees
      self%energies = ''
      self%works = ''
      self%needs_works = any(self%chosen == WORKS)
      if (present(effects)) then
         if (any(self%chosen == ENERGIES)) self%energies = energy_headers(effects)
         if (self%needs_works) self%works = work_headers(effects)
      end if
      self%widths = column_sets(self%chosen)%width
      where (self%chosen == ENERGIES) self%widths = size(split_list(self%energies))
      where (self%chosen == WORKS) self%widths = size(split_list(self%works))
      self%n_plain = count(column_sets(self%chosen)%propagated == 0)
      self%differentiates = self%n_plain < size(self%chosen)
      if (self%differentiates) then
         self%propagated = propagated
         self%n_wheels = 0
         if (present(effects)) self%n_wheels = effects%n_wheels
         do i = self%n_plain + 1, size(self%chosen)
            self%widths(i) = propagated_width(column_sets(self%chosen(i))%propagated, propagated, self%n_wheels)
         end do
      end if
      self%plain_width = 1 + sum(self%widths(:self%n_plain))
      self%width = 1 + sum(self%widths)
      self%needs_rate = any(self%chosen == RATE .or. self%chosen == RATE_SPACE)
      self%angle_sets = pack([(i, i=1, size(self%chosen))], column_sets(self%chosen)%sequence /= '')
      self%follows_steps = size(self%angle_sets) > 0
      self%shows_commands = any(column_sets(self%chosen)%controller > 0)
   end subroutine choose

   !> Errors: `NUTATE_BAD_ARGUMENT` for a set of derivatives where nothing is free, for one of standard deviations where
   !> no free number has one, and for indicators of chaos that nothing follows.
   subroutine check_propagated(set, status, propagated)
      type(column_set_t), intent(in) :: set
      type(status_t), intent(inout) :: status
      type(propagated_t), intent(in), optional :: propagated
      if (set%propagated == 0) return
      if (.not. present(propagated)) then
         status = fail(NUTATE_BAD_ARGUMENT, "only nutate run writes the columns '"//trim(set%name)// &
                       "' (expected others)", 'columns')
      else if (.not. is_by_free(set%propagated)) then
         if (propagated%exponents == 0) status = fail(NUTATE_BAD_ARGUMENT, "columns '"//trim(set%name)//"' need "// &
                                                   'indicators of chaos (expected &chaos)', 'columns')
      else if (size(propagated%names) == 0) then
         status = fail(NUTATE_BAD_ARGUMENT, "columns '"//trim(set%name)//"' need free numbers (expected &free)", &
                       'columns')
      else if (set%propagated /= SENSITIVITIES .and. .not. any(propagated%sigma > 0.0_wp)) then
         status = fail(NUTATE_BAD_ARGUMENT, "columns '"//trim(set%name)//"' need standard deviations (expected "// &
                       'sigma in &free)', 'columns')
      end if
   end subroutine check_propagated

   !> What to write in the place of an unknown name.
   pure function hint(nearest) result(text)
      !> Blank if there is none.
      character(len=*), intent(in) :: nearest
      character(len=:), allocatable :: text
      text = 'nearest: '//nearest
      if (nearest == '') text = 'expected a set such as '//comma_list(column_sets(1:3)%name)
   end function hint

   !> Errors: `NUTATE_BAD_ARGUMENT` for a set of a wheel, a controller, a field, an orbit or a sun that does not exist.
   subroutine check_available(set, effects, status)
      type(column_set_t), intent(in) :: set
      type(effect_list_t), intent(in) :: effects
      type(status_t), intent(out) :: status
      if (set%wheel > effects%n_wheels) then
         status = fail(NUTATE_BAD_ARGUMENT, "columns '"//trim(set%name)//"' refer to a wheel that does not exist "// &
                       '(expected one group &wheel for each)', 'columns')
      else if (set%controller > 0 .and. .not. has_controller(set%controller, set%points, effects)) then
         status = fail(NUTATE_BAD_ARGUMENT, "columns '"// &
                       trim(set%name)//"' refer to a controller that does not exist "// &
                       '(expected one group &controller for each'//trim(merge(', which points', '              ', &
                                                                             set%points))//')', 'columns')
      else if (set%field .and. .not. has_field(effects)) then
         status = fail(NUTATE_BAD_ARGUMENT, "columns '"//trim(set%name)//"' refer to a field that does not exist "// &
                       '(expected &earth_field, or field in &controller or &dipole)', 'columns')
      else if (set%orbit .and. .not. effects%on_orbit) then
         status = fail(NUTATE_BAD_ARGUMENT, "columns '"//trim(set%name)//"' refer to an orbit that does not exist "// &
                       '(expected &orbit)', 'columns')
      else if (set%tumbling .and. effects%n_rotors > 0) then
         status = fail(NUTATE_BAD_ARGUMENT, "columns 'tumbling' need a body without rotors and wheels "// &
                       '(expected no &rotor and no &wheel)', 'columns')
      else if (set%frame > effects%n_frames) then
         status = fail(NUTATE_BAD_ARGUMENT, "columns '"//trim(set%name)//"' refer to a frame that does not exist "// &
                       '(expected one group &frame for each)', 'columns')
      else if (set%sun .and. .not. has_sun(effects)) then
         status = fail(NUTATE_BAD_ARGUMENT, "columns '"//trim(set%name)//"' refer to a sun that does not exist "// &
                       '(expected sun in &orbit)', 'columns')
      else if (set%name == 'energies' .and. energy_headers(effects) == '') then
         status = fail(NUTATE_BAD_ARGUMENT, "columns 'energies' need a potential "// &
                       '(expected one, such as &gravity)', 'columns')
      else if (set%name == 'works' .and. work_headers(effects) == '') then
         status = fail(NUTATE_BAD_ARGUMENT, "columns 'works' need an effect that does work "// &
                       '(expected one, such as &torque)', 'columns')
      end if
   end subroutine check_available

   !> The header row: the names of all columns, comma separated.
   pure function header(self, plain) result(line)
      class(columns_t), intent(in) :: self
      !> Leave out those of derivatives; default false.
      logical, intent(in), optional :: plain
      character(len=:), allocatable :: line
      integer :: i
      line = 't'
      do i = 1, self%n_plain
         if (self%chosen(i) == ENERGIES) then
            line = line//','//self%energies
         else if (self%chosen(i) == WORKS) then
            line = line//','//self%works
         else if (self%degrees) then
            line = line//','//in_degrees(column_sets(self%chosen(i)))
         else
            line = line//','//trim(column_sets(self%chosen(i))%headers)
         end if
      end do
      if (present(plain)) then
         if (plain) return
      end if
      do i = self%n_plain + 1, size(self%chosen)
         line = line//','//propagated_headers(column_sets(self%chosen(i))%propagated, self%propagated, self%n_wheels, &
                                           self%degrees)
      end do
   end function header

   !> Errors: `NUTATE_NOT_FINITE` for a row with a value that is not finite, with the name of its column.
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

   !> `phi_deg,theta_deg` for `phi,theta`.
   pure function in_degrees(set) result(names)
      type(column_set_t), intent(in) :: set
      character(len=:), allocatable :: names, headers
      integer :: i, place
      headers = trim(set%headers)//','
      names = ''
      place = 1
      do i = 1, len(headers)
         if (headers(i:i) == ',') then
            if (place >= set%first_angle .and. place <= set%last_angle) names = names//'_deg'
            place = place + 1
         end if
         if (i < len(headers)) names = names//headers(i:i)
      end do
   end function in_degrees

   !> Stores the first state.
   pure subroutine start(self, system, state, inverse_j0, backward)
      class(columns_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> 1/J0, kg⁻¹ m⁻².
      real(wp), intent(in) :: inverse_j0
      !> The run goes back in time; default false.
      logical, intent(in), optional :: backward
      real(wp) :: omega(3)
      integer :: i
      self%shared%inverse_j0 = inverse_j0
      if (any(self%chosen == ENERGY)) self%shared%first_energy = conserved_energy(system, state, inverse_j0)
      if (.not. self%follows_steps) return
      omega = relative_rate(system, state)
      if (present(backward)) omega = merge(-omega, omega, backward)
      if (allocated(self%followed)) deallocate (self%followed)
      allocate (self%followed(size(self%chosen)))
      do i = 1, size(self%chosen)
         associate (sequence => column_sets(self%chosen(i))%sequence)
            if (sequence /= '') call self%followed(i)%start(sequence, state%q, omega)
         end associate
      end do
   end subroutine start

   !> Follows angles that must not lose turns between rows: to be called after every step if `follows_steps`.
   pure subroutine follow(self, state)
      class(columns_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      integer :: i
      do i = 1, size(self%angle_sets)
         call self%followed(self%angle_sets(i))%follow(state%q)
      end do
   end subroutine follow

   !> One row: t, then the values of the sets.
   pure subroutine evaluate(self, system, state, record, values, tangent, chaos)
      class(columns_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      !> Shape (width); shape (plain_width) without sensitivities.
      real(wp), intent(out) :: values(:)
      !> A column for each free number, then others; needed only if `differentiates`.
      type(tangent_t), intent(in), optional :: tangent
      !> Needed only by columns of chaos.
      type(chaos_t), intent(in), optional :: chaos
      integer :: i, first, last

      if (self%needs_rate) self%shared%omega = angular_velocity(system, state)
      values(1) = state%t
      first = 2
      do i = 1, self%n_plain
         last = first + self%widths(i) - 1
         if (column_sets(self%chosen(i))%sequence /= '') then
            values(first:last) = self%followed(i)%angles()
         else
            call write_set(self%chosen(i), system, state, record, self%shared, values(first:last))
         end if
         if (self%degrees) call turn_to_degrees(column_sets(self%chosen(i)), values(first:last))
         first = last + 1
      end do
      if (.not. present(tangent)) return
      do i = self%n_plain + 1, size(self%chosen)
         last = first + self%widths(i) - 1
         call propagated_values(column_sets(self%chosen(i))%propagated, self%propagated, system, state, tangent, &
                             chaos, merge(degree, 1.0_wp, self%degrees), values(first:last))
         first = last + 1
      end do
   end subroutine evaluate

   !> The angles of a set in degrees.
   pure subroutine turn_to_degrees(set, values)
      type(column_set_t), intent(in) :: set
      !> Shape (width of the set).
      real(wp), intent(inout) :: values(:)
      values(set%first_angle:set%last_angle) = values(set%first_angle:set%last_angle)*degree
   end subroutine turn_to_degrees

   !> The values of one set.
   pure subroutine write_set(set, system, state, record, shared, values)
      !> Position in the table.
      integer, intent(in) :: set
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(shared_t), intent(in) :: shared
      !> Shape (width of the set).
      real(wp), intent(out) :: values(:)

      select case (set)
      case (QUATERNION)
         values = state%q
      case (CONJUGATE_MOMENTUM)
         values = state%p
      case (RATE)
         values = shared%omega
      case (RATE_SPACE)
         ! Normalised, since a rotation keeps the length of Ω.
         values = rotate_to_space(quat_normalized(state%q), shared%omega)
      case (MOMENTUM)
         values = body_momentum(state)
      case (MOMENTUM_SPACE)
         values = space_momentum(state)
      case (ENERGY)
         values(1) = kinetic_energy(system, state, shared%inverse_j0)
         values(2) = potential_energy(system%effects, state%q, state%t)
         values(3) = values(1) + values(2)
         values(4) = record%work - state%time_dependent_work
         values(5) = values(3) - shared%first_energy - record%work
         if (system%effects%frame_turns) values(5) = conserved_energy(system, state, shared%inverse_j0) &
                                                     - shared%first_energy - record%work
      case (CONSTRAINTS)
         values = [dot_product(state%q, state%q) - 1, dot_product(state%q, state%p)]
      case (SOLVER)
         values = [real(record%iterations, wp), record%residual]
      case (JACOBI)
         values = conserved_energy(system, state, shared%inverse_j0)
      case (LVLH_ATTITUDE)
         values(4:7) = attitude_in_lvlh(system, state)
         values(1:3) = roll_pitch_yaw_from_quat(values(4:7))
      case (ORBIT, ECLIPSE)
         values = 0.0_wp
         if (system%effects%on_orbit) call write_orbit(set, system%effects%orbit, state%t, values)
      case (TIME_DEPENDENT_WORK)
         values = state%time_dependent_work
      case (ENERGIES)
         values = energies_of(system%effects, state, size(values))
      case (WORKS)
         values = works_of(system%effects, record, size(values))
      case (ROLL_PITCH_YAW)
         values = roll_pitch_yaw_from_quat(attitude_in_lvlh(system, state))
      case default
         call write_part(column_sets(set), system, state, values)
      end select
   end subroutine write_set

   !> The values of the sets `orbit` and `eclipse`.
   pure subroutine write_orbit(set, orbit, t, values)
      integer, intent(in) :: set
      type(orbit_t), intent(in) :: orbit
      !> s.
      real(wp), intent(in) :: t
      !> Shape (width of the set).
      real(wp), intent(inout) :: values(:)
      if (set == ECLIPSE) then
         values(2) = orbit%shadow_depth(t)
         values(1) = merge(1.0_wp, 0.0_wp, values(2) > 0.0_wp)
      else
         values = [orbit%path%position(t), orbit%path%radius(t), orbit%path%true_anomaly(t)]
      end if
   end subroutine write_orbit

   !> The values of a set of a wheel, of a controller, of the field, of tumbling elements or of a frame.
   pure subroutine write_part(set, system, state, values)
      type(column_set_t), intent(in) :: set
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Shape (width of the set).
      real(wp), intent(out) :: values(:)
      if (set%wheel > 0) then
         values = of_wheel(set%wheel, system, state)
      else if (set%tumbling) then
         values = tumbling_values(system, state)
      else if (set%frame > 0) then
         values = seen_from_frame(set%frame, system, state)
      else if (set%field) then
         values = field_in_body(system%effects, state)
      else if (set%points) then
         values = pointing_error(set%controller, system, state)
      else
         values = controller_values(set%controller, system, state)
      end if
   end subroutine write_part

   !> True for an orbit with a sun.
   pure logical function has_sun(effects)
      type(effect_list_t), intent(in) :: effects
      has_sun = .false.
      if (effects%on_orbit) has_sun = effects%orbit%has_sun()
   end function has_sun

   !> The attitude from the body to the LVLH frame, or to the space axes where there is no orbit; shape (4).
   pure function attitude_in_lvlh(system, state) result(q)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp) :: q(4)
      q = state%q
      if (system%effects%on_orbit) q = quat_product(quat_conjugate(system%effects%orbit%axes(state%t)), q)
   end function attitude_in_lvlh

   !> Attitude relative to a frame, and its angle, rad; not finite where that of the frame is not known, which ends a
   !> run. Shape (5).
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

   !> Speed relative to the body, rad/s, absolute momentum about the axis, N m s, work of the motor and of the friction
   !> so far, J; zeros for a wheel that does not exist. Shape (4).
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

   !> Shows to an archive what is remembered from earlier states.
   subroutine transfer_columns(self, archive)
      class(columns_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      integer :: i
      do i = 1, size(self%chosen)
         if (column_sets(self%chosen(i))%sequence /= '') call self%followed(i)%transfer(archive)
      end do
      call archive%transfer(self%shared%first_energy)
   end subroutine transfer_columns

end module nutate_columns
