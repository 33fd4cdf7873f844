!> Quantities of reaction wheels and of inner spheres.
module nutate_wheel_quantities
   use nutate_kinds, only: wp
   use nutate_limits, only: most_spheres
   use nutate_motion, only: motion_t
   use nutate_motion_bounds, only: speed_bounds_t
   use nutate_quantity, only: quantity_t, unit, adds_up, NEEDS_SPHERE, NEEDS_WHEEL, OF_WHEELS, ORANGE, PINK
   use nutate_quaternion, only: cross, rotate_to_space
   use nutate_system, only: system_t
   implicit none
   private

   public :: wheel_fastest, wheel_rate, wheel_value
   public :: Q_WHEEL_SPEED, Q_SPHERE_RATE

   !> Kinds: one case evaluates all components of a kind.
   enum, bind(c)
      enumerator :: Q_WHEEL_SPEED = OF_WHEELS, Q_WHEEL_MOMENTUM, Q_WHEEL_WORK, Q_SPHERE_RATE, Q_SPHERE_MOMENTUM, &
         Q_SPHERE_ENERGY, Q_SPHERE_WORK
   end enum

   !> Index of the implied loops of entries.
   integer :: i

   !> Quantities of wheels and inner spheres, by their numbers.
   type(quantity_t), parameter, public :: wheel_quantities(*) = [ &
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
        i=1, most_spheres)]]

contains

   !> Returns the value of a component of a quantity; 0 if the wheel or the sphere does not exist.
   pure real(wp) function wheel_value(quantity, component, system, motion) result(x)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      associate (n => quantity%number)
         select case (quantity%kind)
         case (Q_WHEEL_SPEED, Q_WHEEL_MOMENTUM)
            x = 0.0_wp
            if (n > system%effects%n_reaction_wheels) return
            x = motion%state%wheel_momentum(n)
            if (quantity%kind == Q_WHEEL_SPEED) x = system%effects%wheels(n)%speed_of(x, motion%omega)
         case default
            x = sphere_value(quantity, component, system, motion)
         end select
      end associate
   end function wheel_value

   !> Returns the rate of `wheel_value` along the motion.
   pure real(wp) function wheel_rate(quantity, component, system, motion) result(x)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      associate (n => quantity%number)
         select case (quantity%kind)
         case (Q_WHEEL_SPEED, Q_WHEEL_MOMENTUM)
            x = 0.0_wp
            if (n > system%effects%n_reaction_wheels) return
            x = motion%wheel_rate(n)
            if (quantity%kind == Q_WHEEL_SPEED) x = system%effects%wheels(n)%speed_of(x, motion%acceleration)
         case default
            x = sphere_value_rate(quantity, component, system, motion)
         end select
      end associate
   end function wheel_rate

   !> Returns a bound of the rate of speed or momentum of a wheel; negative for inner spheres.
   pure real(wp) function wheel_fastest(quantity, speeds) result(rate)
      type(quantity_t), intent(in) :: quantity
      type(speed_bounds_t), intent(in) :: speeds
      rate = -1.0_wp
      if (quantity%kind == Q_WHEEL_SPEED) rate = speeds%wheel_rates(quantity%number)
      if (quantity%kind == Q_WHEEL_MOMENTUM) rate = speeds%drives(quantity%number)
   end function wheel_fastest

   !> Returns a component of the rate of an inner sphere relative to the body, rad/s, or of its momentum in space axes,
   !> N m s, its energy, or the work of its friction, J; 0 if the sphere does not exist.
   pure real(wp) function sphere_value(quantity, component, system, motion) result(x)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: v(3)
      integer :: last
      x = 0.0_wp
      if (quantity%number > system%effects%n_spheres) return
      last = system%effects%n_reaction_wheels + 3*quantity%number
      associate (h => motion%state%wheel_momentum(last - 2:last), inertia => system%effects%wheels(last)%inertia)
         v = h/inertia - motion%omega
         if (quantity%kind == Q_SPHERE_MOMENTUM) v = rotate_to_space(unit(motion%state%q), h)
         x = v(component)
         if (quantity%kind == Q_SPHERE_ENERGY) x = 0.5_wp*dot_product(h/inertia, h)
         if (quantity%kind == Q_SPHERE_WORK) x = sum(motion%state%wheel_work(2, last - 2:last))
      end associate
   end function sphere_value

   !> Returns the rate of `sphere_value` along the motion.
   pure real(wp) function sphere_value_rate(quantity, component, system, motion) result(x)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: v(3)
      integer :: last
      x = 0.0_wp
      if (quantity%number > system%effects%n_spheres) return
      last = system%effects%n_reaction_wheels + 3*quantity%number
      associate (h => motion%state%wheel_momentum(last - 2:last), rate => motion%wheel_rate(last - 2:last), &
                 inertia => system%effects%wheels(last)%inertia)
         v = rate/inertia - motion%acceleration
         if (quantity%kind == Q_SPHERE_MOMENTUM) &
            v = rotate_to_space(unit(motion%state%q), rate + cross(motion%relative, h))
         x = v(component)
         if (quantity%kind == Q_SPHERE_ENERGY) x = dot_product(h/inertia, rate)
      end associate
   end function sphere_value_rate

end module nutate_wheel_quantities
