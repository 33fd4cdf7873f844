!> The table of quantities: what histories, events, measurements, sweeps and pictures can show. Names, units, panels and
!> the reasons of errors are read from it. A new quantity is a kind, an entry of the table, and a case of
!> `quantity_value` in `nutate_quantity_motion`; a closed form of its rate and bounds are cases beside it.
module nutate_quantities
   use nutate_effect_list, only: effect_list_t
   use nutate_limits, only: most_spheres
   use nutate_propagated_columns, only: COVARIANCE, DEVIATIONS, FLI, LYAPUNOV, MEGNO, SENSITIVITIES
   implicit none
   private

   public :: quantity_t, quantities
   public :: component_of, depends_on_orbit, find_missing, find_quantity, find_set, headers_of, last_of_set, &
      names_for, numbered, reason_of, serves, set_headers, set_names, set_of, turns_to_degrees, width_of
   public :: Q_QUATERNION, Q_CONJUGATE_MOMENTUM, Q_RATE, Q_RATE_SPACE, Q_MOMENTUM, Q_MOMENTUM_SPACE, Q_EULER, Q_SPEED, &
      Q_LVLH_RATE, Q_ORBIT_SPEED, Q_SUN_ANGLE, Q_ENERGY, Q_BALANCE, Q_CONSTRAINTS, Q_SOLVER, Q_JACOBI, &
      Q_ROLL_PITCH_YAW, Q_LVLH_ATTITUDE, Q_ORBIT_POSITION, Q_ORBIT_RADIUS, Q_TRUE_ANOMALY, Q_ECLIPSE, Q_SHADOW_DEPTH, &
      Q_TIME_DEPENDENT_WORK, Q_WHEEL_SPEED, Q_WHEEL_MOMENTUM, Q_WHEEL_WORK, Q_SPHERE_RATE, Q_SPHERE_MOMENTUM, &
      Q_SPHERE_ENERGY, Q_SPHERE_WORK, Q_ENERGIES, Q_WORKS, Q_CONTROLLER, Q_POINTING_ERROR, Q_FIELD, Q_TUMBLING, &
      Q_FRAME_ATTITUDE, Q_FRAME_ANGLE, Q_PROPAGATED
   public :: AS_EVENT, AS_MEASUREMENT, NEEDS_CONTROLLER, NEEDS_TARGET

   !> Kinds: one procedure evaluates all components of a kind.
   enum, bind(c)
      enumerator :: Q_QUATERNION = 1, Q_CONJUGATE_MOMENTUM, Q_RATE, Q_RATE_SPACE, Q_MOMENTUM, Q_MOMENTUM_SPACE, &
         Q_EULER, Q_ENERGY, Q_BALANCE, Q_CONSTRAINTS, Q_SOLVER, Q_JACOBI, Q_ROLL_PITCH_YAW, Q_LVLH_ATTITUDE, &
         Q_ORBIT_POSITION, Q_ORBIT_RADIUS, Q_TRUE_ANOMALY, Q_ECLIPSE, Q_SHADOW_DEPTH, Q_TIME_DEPENDENT_WORK, &
         Q_WHEEL_SPEED, Q_WHEEL_MOMENTUM, Q_WHEEL_WORK, Q_SPHERE_RATE, Q_SPHERE_MOMENTUM, Q_SPHERE_ENERGY, &
         Q_SPHERE_WORK, Q_ENERGIES, Q_WORKS, Q_CONTROLLER, Q_POINTING_ERROR, Q_FIELD, Q_TUMBLING, &
         Q_FRAME_ATTITUDE, Q_FRAME_ANGLE, Q_SPEED, Q_LVLH_RATE, Q_ORBIT_SPEED, Q_SUN_ANGLE, Q_PROPAGATED
   end enum

   !> Requirements of quantities on the scene.
   enum, bind(c)
      enumerator :: NEEDS_NOTHING = 0, NEEDS_WHEEL, NEEDS_SPHERE, NEEDS_CONTROLLER, NEEDS_TARGET, NEEDS_FIELD, &
         NEEDS_ORBIT, NEEDS_SUN, NEEDS_NO_ROTOR, NEEDS_FRAME, NEEDS_POTENTIAL, NEEDS_WORK
   end enum

   !> Uses that not all quantities have.
   enum, bind(c)
      enumerator :: AS_EVENT = 1, AS_MEASUREMENT
   end enum

   !> One quantity, or the components of one.
   type :: quantity_t
      !> Set of columns; the quantities of a set stand next to each other. Here, in the names, the label and the
      !> symbols, `#` is the number or the sequence.
      character(len=24) :: set = ''
      !> Names of the components, comma separated; a pattern in capitals if they depend on the scene.
      character(len=72) :: names = ''
      integer :: kind = 0
      !> Unit, and title of the panel in pictures; quantities with the same title share a panel.
      character(len=16) :: unit = ''
      character(len=48) :: label = ''
      !> Position of the panel among all panels.
      integer :: panel = 0
      !> Colour of the curve; blank: the colour of the component.
      character(len=7) :: colour = ''
      !> Axes of a vector: `body`, `space` or `inertial`; blank: none.
      character(len=8) :: axes = ''
      !> Reasons why the quantity cannot be that of an event, and cannot be a measurement; blank: it can.
      character(len=56) :: no_event = '', no_measurement = ''
      !> True if the quantity has the period 2π; true if its value is nevertheless continuous, beyond a period.
      logical :: is_periodic = .false., is_continuous = .false.
      !> True for an angle from 0 to π without a derivative at these ends.
      logical :: is_folded = .false.
      !> True if events differentiate the quantity by differences; else `quantity_rate` has its rate in closed form.
      logical :: by_differences = .false.
      !> True if the value depends on the attitude; false for the potential energy, since potentials need the attitude
      !> anyway.
      logical :: attitude = .true.
      !> Requirement on the scene: `NEEDS_WHEEL`, ...
      integer :: needs = NEEDS_NOTHING
      !> Number of the wheel, inner sphere, controller or frame, in the order of the scene.
      integer :: number = 1
      !> Position of the first component among those of its kind.
      integer :: first = 1
      !> True for an angle or rate that is never written in degrees.
      logical :: in_radians = .false.
      !> Sequence of axes of Euler angles.
      character(len=3) :: sequence = ''
      !> Set of propagated columns: `SENSITIVITIES`, ... of `nutate_propagated_columns`; 0: none. These sets stand last.
      integer :: propagated = 0
      !> Pattern of names that depend on the scene: `#` is a digit, `*` the rest; blank: the names.
      character(len=24) :: pattern = ''
      !> Symbols of the components in legends, comma separated; the character after `_` is a subscript. Blank: names.
      character(len=56) :: symbols = ''
      !> True for what shows the errors of the integration: pictures have it only on request.
      logical :: is_residual = .false.
   end type quantity_t

   !> Colours of the components 1, 2, 3, or x, y, z, of the wheels and controllers 1 to 6, and of others.
   character(len=7), parameter :: VERMILION = '#d55e00', GREEN = '#009e73', NAVY = '#0b3c5d', ORANGE = '#e69f00', &
      SKY = '#56b4e9', PINK = '#cc79a7', BLACK = '#000000'
   character(len=7), parameter, public :: GREY = '#666666', &
      component_colours(6) = [VERMILION, GREEN, NAVY, ORANGE, SKY, PINK]

   !> Reasons why a quantity cannot be that of an event, or cannot be a measurement.
   character(len=*), parameter :: &
      counts = 'is a counter', &
      adds_up = 'adds up over the run', &
      of_step = 'belongs to the last step, not to the state', &
      is_round_off = 'is round-off', &
      two_values = 'has only two values', &
      is_followed = 'is followed from step to step', &
      of_effects = 'belongs to one of the effects', &
      is_sampled = 'can belong to the last sample, not to the state', &
      is_propagated = 'belongs to the run, not to the state', &
      other_angles = 'is measured as an attitude, q0 to q3', &
      still = 'does not depend on the motion of the body', &
      has_edges = 'has no derivative at a separatrix', &
      is_stored = 'is an auxiliary variable of the integration'

   !> Sequences of Euler angles beside 313.
   character(len=3), parameter :: sequences(11) = ['121', '123', '131', '132', '212', '213', '231', '232', '312', &
      '321', '323']
   !> Index of the implied loops of the table.
   integer :: i

   type(quantity_t), parameter :: table(*) = [ &
      quantity_t('quaternion', 'q0,q1,q2,q3', Q_QUATERNION, '', 'attitude quaternion q', 3, &
                 no_measurement=other_angles, symbols='q_0,q_1,q_2,q_3'), &
      quantity_t('conjugate_momentum', 'p0,p1,p2,p3', Q_CONJUGATE_MOMENTUM, 'N m s', 'conjugate momentum p', 20, &
                 no_measurement=is_stored, symbols='p_0,p_1,p_2,p_3'), &
      quantity_t('angular_velocity', 'omega1,omega2,omega3', Q_RATE, 'rad/s', 'angular velocity Ω', 1, axes='body', &
                 attitude=.false., symbols='Ω_1,Ω_2,Ω_3'), &
      quantity_t('angular_velocity_space', 'omega_x,omega_y,omega_z', Q_RATE_SPACE, 'rad/s', &
                 'angular velocity ω in space axes', 2, axes='space', symbols='ω_x,ω_y,ω_z'), &
      quantity_t('angular_speed', 'angular_speed', Q_SPEED, 'rad/s', 'angular speed', 2, NAVY, attitude=.false., &
                 symbols='|Ω|'), &
      quantity_t('angular_momentum', 'L1,L2,L3', Q_MOMENTUM, 'N m s', 'angular momentum L', 18, axes='body', &
                 attitude=.false., symbols='L_1,L_2,L_3'), &
      quantity_t('angular_momentum_space', 'l_x,l_y,l_z', Q_MOMENTUM_SPACE, 'N m s', &
                 'angular momentum l in space axes', 19, axes='space', symbols='l_x,l_y,l_z'), &
      quantity_t('euler', 'phi', Q_EULER, 'rad', 'precession angle φ', 6, VERMILION, is_periodic=.true., &
                 sequence='313', symbols='φ'), &
      quantity_t('euler', 'theta', Q_EULER, 'rad', 'nutation angle θ', 7, GREEN, first=2, sequence='313', &
                 symbols='θ'), &
      quantity_t('euler', 'psi', Q_EULER, 'rad', 'spin angle ψ', 8, NAVY, first=3, is_periodic=.true., &
                 sequence='313', symbols='ψ'), &
      quantity_t('energy', 'kinetic', Q_ENERGY, 'J', 'energy', 31, SKY, attitude=.false., symbols='T'), &
      quantity_t('energy', 'potential', Q_ENERGY, 'J', 'energy', 31, ORANGE, first=2, attitude=.false., symbols='V'), &
      quantity_t('energy', 'total', Q_ENERGY, 'J', 'energy', 31, BLACK, first=3, attitude=.false., symbols='T + V'), &
      quantity_t('energy', 'work', Q_BALANCE, 'J', 'energy', 31, PINK, '', adds_up, adds_up, attitude=.false., &
                 symbols='W'), &
      quantity_t('energy', 'energy_residual', Q_BALANCE, 'J', 'energy residual', 32, GREY, '', adds_up, adds_up, &
                 attitude=.false., is_residual=.true., symbols='residual'), &
      quantity_t('constraints', 'norm_error', Q_CONSTRAINTS, '', 'error of the norm', 37, GREY, '', is_round_off, &
                 is_round_off, is_residual=.true., symbols='q·q − 1'), &
      quantity_t('constraints', 'orthogonality', Q_CONSTRAINTS, 'N m s', 'orthogonality', 38, GREY, '', is_round_off, &
                 is_round_off, is_residual=.true., symbols='q·p'), &
      quantity_t('solver', 'iterations', Q_SOLVER, '', 'iterations', 39, GREY, '', counts, counts, attitude=.false., &
                 is_residual=.true.), &
      quantity_t('solver', 'step_residual', Q_SOLVER, '', 'residual of a step', 40, GREY, '', of_step, of_step, &
                 attitude=.false., is_residual=.true., symbols='residual'), &
      quantity_t('jacobi', 'jacobi', Q_JACOBI, 'J', 'Jacobi integral', 33, BLACK, symbols='H'), &
      quantity_t('lvlh_attitude', 'roll', Q_ROLL_PITCH_YAW, 'rad', 'roll, pitch, yaw', 5, VERMILION, &
                 is_periodic=.true., needs=NEEDS_ORBIT), &
      quantity_t('lvlh_attitude', 'pitch', Q_ROLL_PITCH_YAW, 'rad', 'roll, pitch, yaw', 5, GREEN, first=2, &
                 needs=NEEDS_ORBIT), &
      quantity_t('lvlh_attitude', 'yaw', Q_ROLL_PITCH_YAW, 'rad', 'roll, pitch, yaw', 5, NAVY, first=3, &
                 is_periodic=.true., needs=NEEDS_ORBIT), &
      quantity_t('lvlh_attitude', 'lvlh_q0,lvlh_q1,lvlh_q2,lvlh_q3', Q_LVLH_ATTITUDE, '', &
                 'attitude from the LVLH frame', 4, no_measurement=other_angles, needs=NEEDS_ORBIT, &
                 symbols='q_0,q_1,q_2,q_3'), &
      quantity_t('lvlh_angular_velocity', 'lvlh_omega1,lvlh_omega2,lvlh_omega3', Q_LVLH_RATE, 'rad/s', &
                 'angular velocity against the LVLH frame', 2, '', 'body', needs=NEEDS_ORBIT, by_differences=.true., &
                 symbols='Ω_1,Ω_2,Ω_3'), &
      quantity_t('orbit', 'orbit_x,orbit_y,orbit_z', Q_ORBIT_POSITION, 'm', 'position on the orbit', 21, '', &
                 'inertial', no_measurement=still, attitude=.false., needs=NEEDS_ORBIT, symbols='x,y,z'), &
      quantity_t('orbit', 'orbit_radius', Q_ORBIT_RADIUS, 'm', 'radius of the orbit', 22, NAVY, no_measurement=still, &
                 attitude=.false., needs=NEEDS_ORBIT, symbols='r'), &
      quantity_t('orbit', 'true_anomaly', Q_TRUE_ANOMALY, 'rad', 'true anomaly', 23, NAVY, no_measurement=still, &
                 is_periodic=.true., is_continuous=.true., attitude=.false., needs=NEEDS_ORBIT, symbols='ν'), &
      quantity_t('orbit_speed', 'orbit_speed', Q_ORBIT_SPEED, 'm/s', 'speed on the orbit', 22, NAVY, &
                 no_measurement=still, attitude=.false., needs=NEEDS_ORBIT, symbols='v'), &
      quantity_t('eclipse', 'eclipse', Q_ECLIPSE, '', 'eclipse', 24, NAVY, '', two_values, two_values, &
                 attitude=.false., needs=NEEDS_SUN), &
      quantity_t('eclipse', 'shadow_depth', Q_SHADOW_DEPTH, 'm', 'depth in the shadow', 25, NAVY, &
                 no_measurement=still, attitude=.false., needs=NEEDS_SUN, symbols='depth'), &
      quantity_t('sun_angle', 'sun_angle', Q_SUN_ANGLE, 'rad', 'angle to the sun', 11, NAVY, needs=NEEDS_SUN, &
                 is_folded=.true., symbols='angle'), &
      quantity_t('time_dependent_work', 'time_dependent_work', Q_TIME_DEPENDENT_WORK, 'J', 'works', 36, '', '', &
                 adds_up, adds_up, attitude=.false., symbols='W of potentials'), &
      [(quantity_t('wheel#', 'wheel#_speed', Q_WHEEL_SPEED, 'rad/s', 'wheel speed', 12, in_radians=.true., &
                   attitude=.false., needs=NEEDS_WHEEL, number=i, symbols='wheel #'), &
        quantity_t('wheel#', 'wheel#_momentum', Q_WHEEL_MOMENTUM, 'N m s', 'wheel momentum', 13, attitude=.false., &
                   needs=NEEDS_WHEEL, number=i, symbols='wheel #'), &
        quantity_t('wheel#', 'wheel#_motor_work', Q_WHEEL_WORK, 'J', 'works of wheel #', 36, ORANGE, '', adds_up, &
                   adds_up, attitude=.false., needs=NEEDS_WHEEL, number=i, symbols='motor'), &
        quantity_t('wheel#', 'wheel#_friction_work', Q_WHEEL_WORK, 'J', 'works of wheel #', 36, PINK, '', adds_up, &
                   adds_up, attitude=.false., needs=NEEDS_WHEEL, number=i, symbols='friction'), i=1, 6)], &
      [(quantity_t('sphere#', 'sphere#_rate1,sphere#_rate2,sphere#_rate3', Q_SPHERE_RATE, 'rad/s', &
                   'rate of inner sphere #', 12, axes='body', in_radians=.true., attitude=.false., &
                   needs=NEEDS_SPHERE, number=i, symbols='ω_1,ω_2,ω_3'), &
        quantity_t('sphere#', 'sphere#_momentum_x,sphere#_momentum_y,sphere#_momentum_z', Q_SPHERE_MOMENTUM, &
                   'N m s', 'momentum of inner sphere #', 13, axes='space', needs=NEEDS_SPHERE, number=i, &
                   symbols='l_x,l_y,l_z'), &
        quantity_t('sphere#', 'sphere#_energy', Q_SPHERE_ENERGY, 'J', 'energy of inner spheres', 34, &
                   attitude=.false., needs=NEEDS_SPHERE, number=i, symbols='sphere #'), &
        quantity_t('sphere#', 'sphere#_friction_work', Q_SPHERE_WORK, 'J', 'works of inner spheres', 36, '', '', &
                   adds_up, adds_up, attitude=.false., needs=NEEDS_SPHERE, number=i, symbols='sphere #'), &
        i=1, most_spheres)], &
      quantity_t('roll_pitch_yaw', 'roll', Q_ROLL_PITCH_YAW, 'rad', 'roll, pitch, yaw', 5, VERMILION, &
                 is_periodic=.true.), &
      quantity_t('roll_pitch_yaw', 'pitch', Q_ROLL_PITCH_YAW, 'rad', 'roll, pitch, yaw', 5, GREEN, first=2), &
      quantity_t('roll_pitch_yaw', 'yaw', Q_ROLL_PITCH_YAW, 'rad', 'roll, pitch, yaw', 5, NAVY, first=3, &
                 is_periodic=.true.), &
      [(quantity_t('euler_#', 'euler_#_1,euler_#_2,euler_#_3', Q_EULER, 'rad', 'Euler angles #', 8, &
                   no_event=is_followed, sequence=sequences(i), symbols='α_1,α_2,α_3'), i=1, size(sequences))], &
      quantity_t('energies', 'energy_EFFECT', Q_ENERGIES, 'J', 'potential energies', 34, '', '', of_effects, &
                 of_effects, attitude=.false., needs=NEEDS_POTENTIAL, pattern='energy_*'), &
      quantity_t('works', 'work_EFFECT', Q_WORKS, 'J', 'works', 35, '', '', adds_up, adds_up, attitude=.false., &
                 needs=NEEDS_WORK, pattern='work_*'), &
      [(quantity_t('controller#', 'controller#_commanded1,controller#_commanded2,controller#_commanded3', &
                   Q_CONTROLLER, 'N m or A m²', 'controller #, commanded', 14, '', 'body', is_sampled, is_sampled, &
                   needs=NEEDS_CONTROLLER, number=i, symbols='axis 1,axis 2,axis 3'), &
        quantity_t('controller#', 'controller#_applied1,controller#_applied2,controller#_applied3', Q_CONTROLLER, &
                   'N m or A m²', 'controller #, applied', 15, '', 'body', is_sampled, is_sampled, &
                   needs=NEEDS_CONTROLLER, number=i, first=4, symbols='axis 1,axis 2,axis 3'), &
        quantity_t('controller#', 'controller#_saturations', Q_CONTROLLER, '', 'saturations', 16, '', '', counts, &
                   counts, needs=NEEDS_CONTROLLER, number=i, first=7, symbols='controller #'), i=1, 6)], &
      [(quantity_t('pointing_error#', 'pointing_error#', Q_POINTING_ERROR, 'rad', 'pointing error', 9, &
                   needs=NEEDS_TARGET, number=i, by_differences=.true., symbols='controller #'), i=1, 6)], &
      quantity_t('magnetic_field', 'B1,B2,B3', Q_FIELD, 'T', 'magnetic field B', 17, '', 'body', needs=NEEDS_FIELD, &
                 by_differences=.true., symbols='B_1,B_2,B_3'), &
      quantity_t('tumbling', 'energy_ratio', Q_TUMBLING, '', 'E/E₀', 26, NAVY, no_measurement=has_edges, &
                 needs=NEEDS_NO_ROTOR, symbols='E/E_0'), &
      quantity_t('tumbling', 'short_axis_mode', Q_TUMBLING, '', 'short-axis mode', 27, NAVY, '', two_values, &
                 two_values, needs=NEEDS_NO_ROTOR, first=2, symbols='mode'), &
      quantity_t('tumbling', 'precession_period_short', Q_TUMBLING, 's', 'periods', 29, VERMILION, &
                 no_measurement=has_edges, needs=NEEDS_NO_ROTOR, first=3, symbols='precession of the short axis'), &
      quantity_t('tumbling', 'precession_period_long', Q_TUMBLING, 's', 'periods', 29, GREEN, &
                 no_measurement=has_edges, needs=NEEDS_NO_ROTOR, first=4, symbols='precession of the long axis'), &
      quantity_t('tumbling', 'rotation_period', Q_TUMBLING, 's', 'periods', 29, NAVY, no_measurement=has_edges, &
                 needs=NEEDS_NO_ROTOR, first=5, symbols='rotation'), &
      quantity_t('tumbling', 'pole_longitude', Q_TUMBLING, 'rad', 'pole', 30, VERMILION, no_measurement=has_edges, &
                 needs=NEEDS_NO_ROTOR, is_periodic=.true., first=6, symbols='longitude'), &
      quantity_t('tumbling', 'pole_latitude', Q_TUMBLING, 'rad', 'pole', 30, NAVY, no_measurement=has_edges, &
                 needs=NEEDS_NO_ROTOR, first=7, symbols='latitude'), &
      quantity_t('tumbling', 'sense', Q_TUMBLING, '', 'sense', 28, NAVY, '', two_values, two_values, &
                 needs=NEEDS_NO_ROTOR, first=8), &
      [(quantity_t('frame#', 'frame#_q0,frame#_q1,frame#_q2,frame#_q3', Q_FRAME_ATTITUDE, '', &
                   'attitude from frame #', 10, no_measurement=other_angles, needs=NEEDS_FRAME, number=i, &
                   symbols='q_0,q_1,q_2,q_3'), &
        quantity_t('frame#', 'frame#_angle', Q_FRAME_ANGLE, 'rad', 'angle from frame #', 11, NAVY, needs=NEEDS_FRAME, &
                   number=i, is_folded=.true., symbols='angle'), i=1, 3)], &
      quantity_t('sensitivities', 'd_COMPONENT/d_KEY', Q_PROPAGATED, 'rad per unit', 'rotation by *', 41, '', '', &
                 is_propagated, is_propagated, propagated=SENSITIVITIES, pattern='d_rotation#/d_*'), &
      quantity_t('sensitivities', '', Q_PROPAGATED, 'rad/s per unit', 'Ω by *', 42, propagated=SENSITIVITIES, &
                 pattern='d_omega#/d_*'), &
      quantity_t('sensitivities', '', Q_PROPAGATED, 'N m s per unit', 'wheel momentum by *', 43, &
                 propagated=SENSITIVITIES, pattern='d_wheel#_momentum/d_*'), &
      quantity_t('sensitivities', '', Q_PROPAGATED, 'N m s per unit', 'sphere momentum by *', 43, &
                 propagated=SENSITIVITIES, pattern='d_sphere#_momentum#/d_*'), &
      quantity_t('standard_deviations', 'sigma_COMPONENT', Q_PROPAGATED, 'rad', 'σ of the rotation', 44, '', '', &
                 is_propagated, is_propagated, propagated=DEVIATIONS, pattern='sigma_rotation#'), &
      quantity_t('standard_deviations', '', Q_PROPAGATED, 'rad/s', 'σ of Ω', 45, propagated=DEVIATIONS, &
                 pattern='sigma_omega#'), &
      quantity_t('covariance', 'covariance_COMPONENT_COMPONENT', Q_PROPAGATED, '', 'covariances', 46, '', '', &
                 is_propagated, is_propagated, propagated=COVARIANCE, pattern='covariance_*'), &
      quantity_t('lyapunov', 'lyapunovN', Q_PROPAGATED, '1/s', 'Lyapunov exponent', 47, NAVY, '', is_propagated, &
                 is_propagated, propagated=LYAPUNOV, pattern='lyapunov', symbols='λ_1'), &
      quantity_t('lyapunov', '', Q_PROPAGATED, '1/s', 'Lyapunov exponents', 48, propagated=LYAPUNOV, &
                 pattern='lyapunov#'), &
      quantity_t('megno', 'megno', Q_PROPAGATED, '', 'mean MEGNO', 49, NAVY, '', is_propagated, is_propagated, &
                 propagated=MEGNO), &
      quantity_t('fli', 'fli', Q_PROPAGATED, '', 'FLI', 50, NAVY, '', is_propagated, is_propagated, propagated=FLI)]
   !> All quantities, in the order in which they stand in a history, stored once: a constant would be copied into every
   !> expression with an index.
   type(quantity_t), protected :: quantities(size(table)) = table

   interface

      !> Returns a text of the table with the number, or the sequence, of a quantity.
      elemental module function numbered(text, quantity) result(full)
         character(len=*), intent(in) :: text
         type(quantity_t), intent(in) :: quantity
         character(len=len(text)) :: full
      end function numbered

      !> Returns the name of the set of a quantity.
      elemental module function set_of(quantity) result(set)
         type(quantity_t), intent(in) :: quantity
         character(len=24) :: set
      end function set_of

      !> Returns the names of all sets, in the order of the table.
      pure module function set_names() result(names)
         character(len=24), allocatable :: names(:)
      end function set_names

      !> Returns the position of the first quantity of a set by its name; 0 for an unknown name.
      pure integer module function find_set(name) result(first)
         character(len=*), intent(in) :: name
      end function find_set

      !> Returns true if `degrees` of a scene changes the unit of a quantity.
      elemental logical module function turns_to_degrees(quantity)
         type(quantity_t), intent(in) :: quantity
      end function turns_to_degrees

      !> Returns why a quantity cannot be an event or a measurement; blank if it can.
      pure module function reason_of(quantity, use) result(reason)
         type(quantity_t), intent(in) :: quantity
         !> `AS_EVENT` or `AS_MEASUREMENT`.
         integer, intent(in) :: use
         character(len=:), allocatable :: reason
      end function reason_of

      !> Returns true for a quantity that has a use.
      elemental logical module function serves(quantity, use)
         type(quantity_t), intent(in) :: quantity
         !> `AS_EVENT` or `AS_MEASUREMENT`.
         integer, intent(in) :: use
      end function serves

      !> Returns the position of a quantity in the table, of two of one name that which needs no orbit; 0 for an unknown
      !> name, or one without the use.
      pure integer module function find_quantity(name, use) result(at)
         character(len=*), intent(in) :: name
         !> `AS_EVENT` or `AS_MEASUREMENT`; default: any.
         integer, intent(in), optional :: use
      end function find_quantity

      !> Returns the position of a name among the components of the quantity's kind; 0: it has another name.
      pure integer module function component_of(quantity, name) result(component)
         type(quantity_t), intent(in) :: quantity
         character(len=*), intent(in) :: name
      end function component_of

      !> Returns the names of all components that have a use, comma separated.
      pure module function names_for(use) result(names)
         !> `AS_EVENT` or `AS_MEASUREMENT`.
         integer, intent(in) :: use
         character(len=:), allocatable :: names
      end function names_for

      !> Returns the position of the last quantity of a set.
      pure integer module function last_of_set(first) result(last)
         !> Position of a quantity of the set.
         integer, intent(in) :: first
      end function last_of_set

      !> Returns the number of components of a quantity.
      elemental integer module function width_of(quantity) result(width)
         type(quantity_t), intent(in) :: quantity
      end function width_of

      !> Returns the names of the columns of a quantity, comma separated.
      pure module function headers_of(quantity, degrees) result(headers)
         type(quantity_t), intent(in) :: quantity
         !> True if angles and rates are in degrees; their names then end in `_deg`.
         logical, intent(in) :: degrees
         character(len=:), allocatable :: headers
      end function headers_of

      !> Returns the names of the columns of a set, comma separated.
      pure module function set_headers(set) result(headers)
         character(len=*), intent(in) :: set
         character(len=:), allocatable :: headers
      end function set_headers

      !> Returns true for a quantity that does not exist without an orbit.
      elemental logical module function depends_on_orbit(quantity)
         type(quantity_t), intent(in) :: quantity
      end function depends_on_orbit

      !> Finds the requirement of a quantity that a system does not meet.
      module subroutine find_missing(quantity, effects, missing, expected)
         type(quantity_t), intent(in) :: quantity
         type(effect_list_t), intent(in) :: effects
         !> Predicate such as `need a potential`, and what to write; empty if nothing is missing.
         character(len=:), allocatable, intent(out) :: missing, expected
      end subroutine find_missing

   end interface

end module nutate_quantities
