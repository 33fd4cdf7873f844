!> Quantities of the frames of a scene: attitude of the body relative to each, and its angle.
module nutate_frame_quantities
   use nutate_kinds, only: wp
   use nutate_motion, only: motion_t
   use nutate_moving_frame, only: angle_rate, quaternion_rate, see_from_frame
   use nutate_quantity, only: quantity_t, other_angles, NAVY, NEEDS_FRAME, OF_FRAMES
   use nutate_quaternion, only: quat_product
   use nutate_system, only: system_t
   implicit none
   private

   public :: frame_rate, frame_value
   public :: Q_FRAME_ATTITUDE

   !> Kinds: one case evaluates all components of a kind.
   enum, bind(c)
      enumerator :: Q_FRAME_ATTITUDE = OF_FRAMES, Q_FRAME_ANGLE
   end enum

   !> Index of the implied loop of entries.
   integer :: i

   !> Quantities of the frames, by their numbers.
   type(quantity_t), parameter, public :: frame_quantities(*) = [ &
      [(quantity_t('frame#', 'frame#_q0,frame#_q1,frame#_q2,frame#_q3', Q_FRAME_ATTITUDE, '', &
                   'attitude from frame #', 10, no_measurement=other_angles, needs=NEEDS_FRAME, number=i, &
                   symbols='q_0,q_1,q_2,q_3'), &
        quantity_t('frame#', 'frame#_angle', Q_FRAME_ANGLE, 'rad', 'angle from frame #', 11, NAVY, needs=NEEDS_FRAME, &
                   number=i, is_folded=.true., symbols='angle'), i=1, 3)]]

contains

   !> Returns a component of the attitude relative to a frame, or its angle, rad; 0 if the frame does not exist.
   pure real(wp) function frame_value(quantity, component, system, motion) result(x)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: q(4), angle
      x = 0.0_wp
      if (quantity%number > system%effects%n_frames) return
      call see_from_frame(system%effects%frames(quantity%number), motion%state%t, &
                          quat_product(system%effects%space_axes(motion%state%t), motion%state%q), q, angle)
      x = merge(angle, q(component), quantity%kind == Q_FRAME_ANGLE)
   end function frame_value

   !> Returns the rate of `frame_value` along the motion.
   pure real(wp) function frame_rate(quantity, component, system, motion) result(x)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: rates(4), q(4), omega(3)
      x = 0.0_wp
      if (quantity%number > system%effects%n_frames) return
      associate (frame => system%effects%frames(quantity%number), t => motion%state%t)
         q = quat_product(system%effects%space_axes(t), motion%state%q)
         omega = motion%relative
         if (system%effects%knows_space_axes()) omega = motion%omega
         if (quantity%kind == Q_FRAME_ANGLE) then
            x = angle_rate(frame, t, q, omega)
         else
            rates = quaternion_rate(frame, t, q, omega)
            x = rates(component)
         end if
      end associate
   end function frame_rate

end module nutate_frame_quantities
