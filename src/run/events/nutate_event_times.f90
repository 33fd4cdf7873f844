!> Effect of the times of events on sensitivities. With g the quantity that crosses its level (for an extremum, the rate
!> of the quantity along the motion), X a sensitivity and f⁻, f⁺ the rates of the motion before and after a switch,
!>
!>     dt/dp = -(g·X + ∂g/∂p)/ġ,   X⁺ = X⁻ - (f⁺ - f⁻) dt/dp
!>
!> Attitude and rates are continuous in a switch, so θ does not jump, δL and δh do.
module nutate_event_times
   use nutate_variation, only: OF_ORBIT, OF_WHEEL
   use nutate_event, only: CROSSING, event_t, most_parts, part_t, second_rate, time_scale
   use nutate_kepler_orbit, only: kepler_orbit_t, axes_change, position_change
   use nutate_kinds, only: wp, eps
   use nutate_motion, only: find_motion, find_rates, motion_t
   use nutate_moved_system, only: move_system
   use nutate_quaternion, only: quat_exp, quat_product, quat_vector_product
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: crossing_t, find_time_change

   !> Differences of sixth order along a sensitivity: over so much of a radian, or of the momentum, inertia or wheel
   !> that it changes most, ε^(1/7), where truncation error and round-off are alike, 1e-13.
   real(wp), parameter :: wide = 5.8e-3_wp, weights(3) = [45.0_wp/60, -9.0_wp/60, 1.0_wp/60]

   !> A quantity that changes by no more than this part of its variation in the time of a radian only touches its level:
   !> where its extremum is as near as round-off, the slope of a root is √ε; of a slope of this size three digits hold.
   real(wp), parameter :: tangency = 32*sqrt(eps)

   !> Sensitivities that are moved over switches at one time.
   type :: crossing_t
      private
      !> Motion after the last switch.
      type(motion_t) :: motion = motion_t()
      !> Energy rows of the sensitivities before the first switch, J; shape (n).
      real(wp), allocatable :: energy(:)
   contains
      !> Notes the motion and the sensitivities before the first switch.
      procedure :: begin
      !> Moves the sensitivities over a switch.
      procedure :: pass
      !> Counts the change of the sensitivities' energy as work, after the last switch.
      procedure :: finish
   end type crossing_t

contains

   !> Computes the derivative of the time of an event with respect to the parameter of each sensitivity; not allocated
   !> if the quantity only touches its level: the time then has no derivative.
   subroutine find_time_change(event, system, window_time, state, scale, tangent, change)
      class(event_t), intent(in) :: event
      type(system_t), intent(in) :: system
      !> Time that decides which torques act, s.
      real(wp), intent(in) :: window_time
      !> State at the event.
      type(state_t), intent(in) :: state
      !> Variation of g, or of its rate for an extremum.
      real(wp), intent(in) :: scale
      !> Sensitivities at the event.
      type(tangent_t), intent(in) :: tangent
      !> Derivative of the time, s a unit of the sensitivity's parameter; shape (n).
      real(wp), allocatable, intent(out) :: change(:)
      type(motion_t) :: motion
      type(part_t) :: parts(most_parts)
      real(wp) :: slope
      integer :: k, m
      call find_motion(system, state, motion)
      call find_rates(system, window_time, motion)
      if (event%kind == CROSSING) then
         call event%parts(system, motion, parts)
         slope = sum(parts%rate)
      else
         slope = second_rate(event, system, window_time, motion)
      end if
      if (.not. abs(slope)*time_scale(motion) > tangency*scale) return
      allocate (change(tangent%n))
      do k = 1, tangent%n
         m = findloc(tangent%parametric, k, dim=1)
         change(k) = -change_along(event, system, window_time, motion, tangent, k, m)/slope
      end do
   end subroutine find_time_change

   !> Computes the derivative of g, or of its rate for an extremum, along a sensitivity.
   real(wp) function change_along(event, system, window_time, motion, tangent, k, m) result(change)
      class(event_t), intent(in) :: event
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: window_time
      !> Motion with its rates.
      type(motion_t), intent(in) :: motion
      type(tangent_t), intent(in) :: tangent
      !> Index of the sensitivity; its index among the parametric ones, or 0.
      integer, intent(in) :: k, m
      type(part_t) :: ahead(most_parts), behind(most_parts)
      real(wp) :: difference(most_parts), size_of, h
      integer :: i
      change = 0.0_wp
      size_of = size_of_variation(system, motion, tangent, k, m)
      if (.not. size_of > 0.0_wp) then
         if (m == 0) return
         size_of = 1.0_wp
      end if
      h = wide/size_of
      do i = 1, 3
         call evaluate_along(event, system, window_time, motion, tangent, k, m, i*h, ahead)
         call evaluate_along(event, system, window_time, motion, tangent, k, m, -i*h, behind)
         difference = ahead%value - behind%value
         where (ahead%wrap > 0.0_wp) difference = difference - ahead%wrap*anint(difference/ahead%wrap)
         change = change + weights(i)*sum(difference)
      end do
      change = change/h
   end function change_along

   !> Returns the size of a unit of a sensitivity: in radians, or in parts of the momentum, the inertia or a wheel,
   !> whichever is largest.
   pure real(wp) function size_of_variation(system, motion, tangent, k, m) result(size_of)
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      type(tangent_t), intent(in) :: tangent
      integer, intent(in) :: k, m
      real(wp) :: momentum, change
      integer :: i
      momentum = max(norm2(motion%momentum), &
                     time_scale(motion)*norm2(matmul(system%body%inertia, motion%acceleration)))
      change = norm2(tangent%momentum(k, :))
      do i = 1, size(tangent%wheels, 2)
         momentum = max(momentum, abs(motion%state%wheel_momentum(i)))
         change = max(change, abs(tangent%wheels(k, i)))
      end do
      if (m > 0) change = max(change, norm2(tangent%variations(k)%rotor))
      size_of = norm2(tangent%theta(k, :))
      if (momentum > 0.0_wp) size_of = max(size_of, change/momentum)
      if (m == 0) return
      size_of = max(size_of, maxval(abs(tangent%inertia(:, :, m)))/minval(system%body%moments))
      if (.not. allocated(tangent%variations(k)%effects)) return
      do i = 1, size(tangent%variations(k)%effects)
         associate (item => tangent%variations(k)%effects(i))
            if (item%kind == OF_WHEEL) &
               size_of = max(size_of, abs(item%change(4))/system%effects%wheels(item%place)%inertia)
            if (item%kind == OF_ORBIT) &
               size_of = max(size_of, &
                             turn_of_orbit(system%effects%orbits(item%place)%path, item%change, motion%state%t))
         end associate
      end do
   end function size_of_variation

   !> Returns by how much a unit of a sensitivity changes an orbit, in radians and parts of the distance.
   pure real(wp) function turn_of_orbit(path, change, t) result(turn)
      type(kepler_orbit_t), intent(in) :: path
      real(wp), intent(in) :: change(:), t
      turn = max(norm2(axes_change(path, change, t)), norm2(position_change(path, change, t))/path%radius(t), &
                 abs(change(7))/path%mu)
   end function turn_of_orbit

   !> Evaluates g by its parts, or its rate for an extremum, at a position along a sensitivity.
   subroutine evaluate_along(event, system, window_time, motion, tangent, k, m, part, parts)
      class(event_t), intent(in) :: event
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: window_time
      type(motion_t), intent(in) :: motion
      type(tangent_t), intent(in) :: tangent
      integer, intent(in) :: k, m
      !> Position, in units of the sensitivity's parameter.
      real(wp), intent(in) :: part
      type(part_t), intent(out) :: parts(most_parts)
      type(system_t) :: moved
      if (m == 0) then
         call evaluate(system)
      else
         call move_system(system, tangent, m, part, moved)
         call evaluate(moved)
      end if

   contains

      subroutine evaluate(there)
         type(system_t), intent(in) :: there
         type(motion_t) :: place
         type(state_t) :: state
         integer :: n
         state = motion%state
         state%q = quat_product(state%q, quat_exp((0.5_wp*part)*tangent%theta(k, :)))
         state%p = quat_vector_product(state%q, 2*(motion%momentum + part*tangent%momentum(k, :)))
         n = size(tangent%wheels, 2)
         state%wheel_momentum(:n) = state%wheel_momentum(:n) + part*tangent%wheels(k, :)
         call find_motion(there, state, place)
         call find_rates(there, window_time, place)
         if (event%kind == CROSSING) then
            call event%parts(there, place, parts)
         else
            parts(1)%value = event%rate(there, place)
         end if
      end subroutine evaluate

   end subroutine evaluate_along

   !> Notes the motion and the sensitivities before the first switch.
   subroutine begin(self, system, state, tangent)
      class(crossing_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(tangent_t), intent(in) :: tangent
      self%energy = tangent%energy_row(system, state)
      call find_motion(system, state, self%motion)
      call find_rates(system, state%t, self%motion)
   end subroutine begin

   !> Moves the sensitivities over a switch. Errors: `NUTATE_BAD_ARGUMENT` if the rates of the motion jump and the time
   !> of the event has no derivative.
   subroutine pass(self, system, state, words, change, tangent, status)
      class(crossing_t), intent(inout) :: self
      !> System after the switch.
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Description of the event for messages.
      character(len=*), intent(in) :: words
      !> Derivative of the event's time; not allocated: there is none.
      real(wp), allocatable, intent(in) :: change(:)
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      type(motion_t) :: motion
      real(wp) :: torque(3), size_of
      integer :: i
      call find_motion(system, state, motion)
      call find_rates(system, state%t, motion)
      torque = (motion%potential_torque - self%motion%potential_torque) + (motion%torque - self%motion%torque)
      associate (wheels => motion%wheel_rate - self%motion%wheel_rate)
         if (allocated(change)) then
            do i = 1, 3
               tangent%momentum(:, i) = tangent%momentum(:, i) - torque(i)*change
            end do
            do i = 1, size(tangent%wheels, 2)
               tangent%wheels(:, i) = tangent%wheels(:, i) - wheels(i)*change
            end do
         else
            size_of = norm2(motion%potential_torque) + norm2(motion%torque) + norm2(motion%wheel_rate)
            if (norm2(torque) + norm2(wheels) > tangency*size_of) &
               status = fail(NUTATE_BAD_ARGUMENT, 'sensitivities end where '//words//' only touches its level '// &
                             '(expected a switch where the quantity passes it)')
         end if
      end associate
      self%motion = motion
   end subroutine pass

   !> Counts the change of the sensitivities' energy as work, and sets the momentum that is conserved from here on.
   subroutine finish(self, system, state, renewed, tangent)
      class(crossing_t), intent(in) :: self
      !> System after the last switch.
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Other components of l may be conserved than before.
      logical, intent(in) :: renewed
      type(tangent_t), intent(inout) :: tangent
      tangent%work = tangent%work + (tangent%energy_row(system, state) - self%energy)
      if (renewed) tangent%space_momentum = tangent%momentum_row(state)
   end subroutine finish

end module nutate_event_times
