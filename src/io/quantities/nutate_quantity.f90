!> The entries of the table of quantities: names, units, panels, and the reasons of errors.
module nutate_quantity
   use nutate_kinds, only: wp
   use nutate_quaternion, only: quat_norm
   implicit none
   private

   public :: quantity_t, family_of, unit
   public :: OF_MOTION, OF_ENERGY, OF_ORBIT, OF_WHEELS, OF_CONTROL, OF_TUMBLING, OF_FRAMES, OF_RUN
   public :: NEEDS_CONTROLLER, NEEDS_FIELD, NEEDS_FRAME, NEEDS_NO_ROTOR, NEEDS_ORBIT, NEEDS_POTENTIAL, NEEDS_SPHERE, &
      NEEDS_SUN, NEEDS_TARGET, NEEDS_WHEEL, NEEDS_WORK
   public :: AS_EVENT, AS_MEASUREMENT

   !> Families of quantities: one file has the entries, values and rates of each.
   enum, bind(c)
      enumerator :: OF_MOTION = 100, OF_ENERGY = 200, OF_ORBIT = 300, OF_WHEELS = 400, OF_CONTROL = 500, &
         OF_TUMBLING = 600, OF_FRAMES = 700, OF_RUN = 800
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
      !> Kind, `Q_QUATERNION`, ...: a number of the family of quantities, `OF_MOTION`, ..., plus a position.
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
      !> True if events differentiate the quantity by differences; else its family has its rate in closed form.
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

   !> Margin of bounds of quantities over those of the exact motion.
   real(wp), parameter, public :: bound_margin = 1.01_wp

   !> Colours of the components 1, 2, 3, or x, y, z, of the wheels and controllers 1 to 6, and of others.
   character(len=7), parameter, public :: VERMILION = '#d55e00', GREEN = '#009e73', NAVY = '#0b3c5d', &
      ORANGE = '#e69f00', SKY = '#56b4e9', PINK = '#cc79a7', BLACK = '#000000', GREY = '#666666', &
      component_colours(6) = [VERMILION, GREEN, NAVY, ORANGE, SKY, PINK]

   !> Reasons why a quantity cannot be that of an event, or cannot be a measurement.
   character(len=*), parameter, public :: &
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

contains

   !> Returns the family of a quantity, `OF_MOTION`, ...
   pure integer function family_of(quantity)
      type(quantity_t), intent(in) :: quantity
      family_of = 100*(quantity%kind/100)
   end function family_of

   !> Returns the unit quaternion of an attitude of any length; shape (4).
   pure function unit(q)
      real(wp), intent(in) :: q(4)
      real(wp) :: unit(4)
      unit = (1/quat_norm(q))*q
   end function unit

end module nutate_quantity
