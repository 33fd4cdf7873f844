!> Sensitivities by the times at which torques and motors start and stop. At such a time tₑ the rates of the motion
!> jump from f⁻ to f⁺, and with X a sensitivity
!>
!>     X⁺ = X⁻ - (f⁺ - f⁻) dtₑ/dp
!>
!> tₑ does not depend on the motion: sensitivities by anything else do not change at tₑ. Attitude and rates are
!> continuous, so θ does not jump; δL and δh do, each by the torque of the one effect at tₑ.
module nutate_window_edges
   use nutate_variation, only: window_change_t, OF_TORQUE
   use nutate_kinds, only: wp
   use nutate_motion, only: find_motion, motion_t
   use nutate_quaternion, only: quat_normalized
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: cross_window_edges

   !> A time that lies this many floating-point spacings from the end of a window is inside of it: beyond the rounding
   !> of the times of a table.
   real(wp), parameter :: inside = 32.0_wp

contains

   !> Moves sensitivities over the starts and stops in an interval of time, at a state at its end.
   subroutine cross_window_edges(system, state, interval, sense, tangent, change)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Start and end of the interval, s; the start does not belong to it, the end does.
      real(wp), intent(in) :: interval(2)
      !> Direction of time: 1 or -1.
      real(wp), intent(in) :: sense
      type(tangent_t), intent(inout) :: tangent
      !> dtₑ/dp of the last start or stop, s per unit of the sensitivity's parameter, shape (n); not allocated if there
      !> is none.
      real(wp), allocatable, intent(out) :: change(:)
      type(motion_t) :: motion
      real(wp) :: energy(tangent%n)
      integer :: k, m
      do k = 1, tangent%n
         associate (variation => tangent%variations(k))
            if (.not. allocated(variation%windows)) cycle
            do m = 1, size(variation%windows)
               call cross_one(variation%windows(m))
            end do
         end associate
      end do
      if (allocated(change)) tangent%work = tangent%work + (tangent%energy_row(system, state) - energy)

   contains

      !> Moves sensitivity k over the ends of one window.
      subroutine cross_one(window)
         type(window_change_t), intent(in) :: window
         real(wp) :: times(2), torque(3), drive
         logical :: own(2)
         integer :: side
         call find_window(system, window, times, own)
         do side = 1, 2
            if (.not. own(side) .or. .not. abs(window%change(side)) > 0.0_wp) cycle
            if (sense*times(side) <= sense*interval(1) .or. sense*times(side) > sense*interval(2)) cycle
            if (.not. allocated(change)) then
               energy = tangent%energy_row(system, state)
               call find_motion(system, state, motion)
               allocate (change(tangent%n), source=0.0_wp)
            end if
            call find_force(system, motion, window, times, side, torque, drive)
            associate (jump => merge(sense, -sense, side == 1)*window%change(side))
               change(k) = window%change(side)
               tangent%momentum(k, :) = tangent%momentum(k, :) - jump*torque
               call change_inertia(window, jump, times(side))
               if (window%kind /= OF_TORQUE) &
                  tangent%wheels(k, window%place) = tangent%wheels(k, window%place) - jump*drive
            end associate
         end do
      end subroutine cross_one

      !> Takes from δJ of sensitivity k what the moved end of a rate of the inertia adds to J from now on.
      subroutine change_inertia(window, jump, time)
         type(window_change_t), intent(in) :: window
         real(wp), intent(in) :: jump
         !> Time of the end, s.
         real(wp), intent(in) :: time
         integer :: m
         if (window%kind /= OF_TORQUE) return
         associate (item => system%effects%torques(window%place)%item)
            if (.not. item%changes_inertia) return
            m = findloc(tangent%parametric, k, dim=1)
            tangent%inertia(:, :, m) = tangent%inertia(:, :, m) - jump*item%inertia_term(1, time, time, 1.0_wp)
         end associate
      end subroutine change_inertia

   end subroutine cross_window_edges

   !> Finds start and stop of a window, s, and which of them are its own parameters; shape (2).
   subroutine find_window(system, window, times, own)
      type(system_t), intent(in) :: system
      type(window_change_t), intent(in) :: window
      real(wp), intent(out) :: times(2)
      logical, intent(out) :: own(2)
      if (window%kind == OF_TORQUE) then
         associate (torque => system%effects%torques(window%place)%item)
            call torque%window(times(1), times(2))
            own = torque%own_ends()
         end associate
      else
         associate (motor => system%effects%wheels(window%place)%motor)
            call motor%window(times(1), times(2))
            own = motor%own_ends()
         end associate
      end if
   end subroutine find_window

   !> Finds the torque of an effect inside its window at one of its ends: on the body, body axes, N m, shape (3), or of
   !> a motor, N m; zero if the effect is off.
   subroutine find_force(system, motion, window, times, side, torque, drive)
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      type(window_change_t), intent(in) :: window
      !> Start and stop of the window, s; shape (2).
      real(wp), intent(in) :: times(2)
      integer, intent(in) :: side
      real(wp), intent(out) :: torque(3), drive
      real(wp) :: moment, piece(2), q(4)
      torque = 0.0_wp
      drive = 0.0_wp
      q = quat_normalized(motion%state%q)
      moment = times(side) + merge(inside, -inside, side == 1)*spacing(times(side))
      if (window%kind == OF_TORQUE) then
         associate (item => system%effects%torques(window%place)%item)
            if (.not. item%acts_at(times(side))) return
            call item%piece(moment, piece(1), piece(2))
            torque = item%torque(min(max(times(side), piece(1)), piece(2)), q, motion%relative)
         end associate
      else
         associate (wheel => system%effects%wheels(window%place))
            if (.not. wheel%is_driven(times(side))) return
            piece = wheel%drive_window(moment)
            drive = wheel%drive(min(max(times(side), piece(1)), piece(2)), q, motion%relative)
         end associate
      end if
   end subroutine find_force

end module nutate_window_edges
