!> Values of the table of quantities along a motion, their rates, and bounds of both, each from the file of its family.
module nutate_quantity_motion
   use nutate_control_quantities, only: control_value
   use nutate_energy_quantities, only: energy_fastest, energy_greatest, energy_rate, energy_size, energy_value
   use nutate_frame_quantities, only: frame_rate, frame_value
   use nutate_kinds, only: wp
   use nutate_motion, only: motion_t
   use nutate_motion_bounds, only: speed_bounds_t
   use nutate_motion_quantities, only: motion_fastest, motion_greatest, motion_rate, motion_size, motion_value
   use nutate_orbit_quantities, only: orbit_rate, orbit_size, orbit_value
   use nutate_quantity, only: quantity_t, family_of, OF_CONTROL, OF_ENERGY, OF_FRAMES, OF_MOTION, OF_ORBIT, &
      OF_TUMBLING, OF_WHEELS
   use nutate_system, only: system_t
   use nutate_tumbling_quantities, only: tumbling_rate, tumbling_value
   use nutate_wheel_quantities, only: wheel_fastest, wheel_rate, wheel_value
   implicit none
   private

   public :: quantity_value, quantity_rate, quantity_size, fastest_rate, greatest_value

contains

   !> Returns the value of a component of a quantity; 0 for one that only a run knows.
   pure real(wp) function quantity_value(quantity, component, system, motion) result(x)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      select case (family_of(quantity))
      case (OF_MOTION)
         x = motion_value(quantity%kind, component, motion)
      case (OF_ENERGY)
         x = energy_value(quantity%kind, component, system, motion)
      case (OF_ORBIT)
         x = orbit_value(quantity%kind, component, system, motion)
      case (OF_WHEELS)
         x = wheel_value(quantity, component, system, motion)
      case (OF_CONTROL)
         x = control_value(quantity, component, system, motion)
      case (OF_TUMBLING)
         x = tumbling_value(component, system, motion)
      case (OF_FRAMES)
         x = frame_value(quantity, component, system, motion)
      case default
         x = 0.0_wp
      end select
   end function quantity_value

   !> Returns the rate of a component of a quantity along the motion; 0 where the table asks for differences.
   pure real(wp) function quantity_rate(quantity, component, system, motion) result(x)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(system_t), intent(in) :: system
      !> Motion with its rates.
      type(motion_t), intent(in) :: motion
      select case (family_of(quantity))
      case (OF_MOTION)
         x = motion_rate(quantity%kind, component, motion)
      case (OF_ENERGY)
         x = energy_rate(quantity%kind, component, system, motion)
      case (OF_ORBIT)
         x = orbit_rate(quantity%kind, component, system, motion)
      case (OF_WHEELS)
         x = wheel_rate(quantity, component, system, motion)
      case (OF_TUMBLING)
         x = tumbling_rate(component, system, motion)
      case (OF_FRAMES)
         x = frame_rate(quantity, component, system, motion)
      case default
         x = 0.0_wp
      end select
   end function quantity_rate

   !> Returns the size of the vector or sum that a component belongs to, to which its round-off is relative.
   pure real(wp) function quantity_size(quantity, component, system, motion) result(x)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      select case (family_of(quantity))
      case (OF_MOTION)
         x = motion_size(quantity%kind, motion)
      case (OF_ENERGY)
         x = energy_size(quantity%kind, component, system, motion)
      case (OF_ORBIT)
         x = orbit_size(quantity%kind, component, system, motion)
      case (OF_FRAMES)
         x = 1.0_wp
      case default
         x = 1.0_wp
         if (quantity%unit /= 'rad') x = abs(quantity_value(quantity, component, system, motion))
      end select
   end function quantity_size

   !> Returns a bound of the rate of a component; negative if none is known.
   pure real(wp) function fastest_rate(quantity, component, speeds) result(rate)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(speed_bounds_t), intent(in) :: speeds
      select case (family_of(quantity))
      case (OF_MOTION)
         rate = motion_fastest(quantity%kind, component, speeds)
      case (OF_ENERGY)
         rate = energy_fastest(quantity%kind, component, speeds)
      case (OF_WHEELS)
         rate = wheel_fastest(quantity, speeds)
      case default
         rate = -1.0_wp
      end select
   end function fastest_rate

   !> Returns a bound of a component; negative if none is known.
   pure real(wp) function greatest_value(quantity, component, speeds) result(value)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(speed_bounds_t), intent(in) :: speeds
      value = -1.0_wp
      if (family_of(quantity) == OF_MOTION) value = motion_greatest(quantity%kind, component, speeds)
      if (family_of(quantity) == OF_ENERGY) value = energy_greatest(quantity%kind, component, speeds)
   end function greatest_value

end module nutate_quantity_motion
