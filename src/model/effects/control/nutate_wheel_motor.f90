!> Motor of a wheel: a torque harmonic in time, or tabulated against time. With limits of torque and speed the torque is
!> a straight line in each step, so that neither limit is passed inside of a step.
module nutate_wheel_motor
   use nutate_applied_torque, only: applied_torque_t
   use nutate_effect, only: torque_t
   use nutate_keys, only: group_t
   use nutate_kinds, only: wp
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_tabulated_torque, only: check_table, make_tabulated_torque, tabulated_torque_t
   implicit none
   private

   public :: build_motor, make_motor_table

contains

   !> Builds the motor of a scene's group; none if it names neither torque nor table. Component 1 of its torque is u.
   !>
   !> Errors: those of `make_motor_table`; `NUTATE_BAD_ARGUMENT` for keys that exclude each other, a window that is
   !> empty, a torque above its limit, and one that is no straight line beside a limit.
   subroutine build_motor(group, motor, status)
      !> Group `&wheel`, with its table read.
      type(group_t), intent(in) :: group
      class(torque_t), allocatable, intent(out) :: motor
      type(status_t), intent(out) :: status
      character(len=13), parameter :: of_table(2) = [character(len=13) :: 'interpolation', 'outside'], &
                                      of_waves(3) = [character(len=13) :: 'torque', 'frequency', 'phase']
      if (group%has('table')) then
         call exclude(group, of_waves, 'table and ', ' exclude each other (expected one of the two)', status)
         if (status%ok()) call build_table(group, motor, status)
      else
         call exclude(group, of_table, '', ' without table (expected table)', status)
         if (status%ok()) call build_wave(group, motor, status)
      end if
   end subroutine build_motor

   !> Rejects keys. Errors: `NUTATE_BAD_ARGUMENT` for the first of the keys that is there.
   subroutine exclude(group, keys, before, behind, status)
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: keys(:), before, behind
      type(status_t), intent(inout) :: status
      integer :: i
      do i = 1, size(keys)
         if (.not. group%has(trim(keys(i)))) cycle
         status = fail(NUTATE_BAD_ARGUMENT, before//trim(keys(i))//behind, keys(i))
         return
      end do
   end subroutine exclude

   !> Builds a motor of harmonic torque, if one is given.
   subroutine build_wave(group, motor, status)
      type(group_t), intent(in) :: group
      class(torque_t), allocatable, intent(out) :: motor
      type(status_t), intent(inout) :: status
      character(len=9), parameter :: of_torque(4) = ['frequency', 'phase    ', 'start    ', 'stop     ']
      type(applied_torque_t) :: wave
      if (.not. group%has('torque')) then
         call exclude(group, of_torque, '', ' without torque (expected torque)', status)
         return
      end if
      wave%name = 'motor'
      wave%amplitude(1) = group%number('torque', 0.0_wp)
      wave%frequency = group%number('frequency', wave%frequency)
      wave%phase = group%number('phase', wave%phase)
      wave%start = group%number('start', wave%start)
      wave%stop = group%number('stop', wave%stop)
      if (.not. wave%stop > wave%start) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the motor stops before it starts (expected stop > start)', 'stop')
      else if (abs(wave%amplitude(1)) > group%number('torque_limit', huge(1.0_wp))) then
         status = fail(NUTATE_BAD_ARGUMENT, 'torque is above torque_limit (expected one up to it, or a table, '// &
                       'which is cut off there)', 'torque')
      else if (group%has('speed_limit') .and. abs(wave%frequency) > 0.0_wp) then
         status = fail(NUTATE_BAD_ARGUMENT, 'frequency with speed_limit (expected a constant torque, or a table '// &
                       "with interpolation = 'linear')", 'frequency')
      else
         allocate (motor, source=wave)
      end if
   end subroutine build_wave

   !> Builds a motor from a table of two columns.
   subroutine build_table(group, motor, status)
      type(group_t), intent(in) :: group
      class(torque_t), allocatable, intent(out) :: motor
      type(status_t), intent(inout) :: status
      type(tabulated_torque_t) :: table
      integer :: at
      if (.not. allocated(group%table)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the table has not been read', 'table')
         return
      end if
      associate (numbers => group%table%numbers)
         call make_motor_table(numbers(1, :), numbers(2, :), table, status, at, &
                               spline=group%text('interpolation', 'linear') == 'cubic', &
                               periodic=group%text('outside', 'zero') == 'periodic', &
                               start=group%number('start', -huge(1.0_wp)), stop=group%number('stop', huge(1.0_wp)), &
                               torque_limit=group%number('torque_limit', huge(1.0_wp)), &
                               stops_at_a_speed=group%has('speed_limit'))
      end associate
      if (status%ok()) allocate (motor, source=table)
   end subroutine build_table

   !> Makes a motor that interpolates a table of times and torques. With `torque_limit` the torque is limited there;
   !> with a limit of speed, points are added where the torque passes zero.
   !>
   !> Errors: those of `make_tabulated_torque`; `NUTATE_BAD_ARGUMENT` for a limit that is not positive, and for a spline
   !> with a limit.
   subroutine make_motor_table(times, torques, motor, status, at, spline, periodic, start, stop, torque_limit, &
                               stops_at_a_speed)
      !> Times, s; shape (n).
      real(wp), intent(in) :: times(:)
      !> u, N m; shape (n).
      real(wp), intent(in) :: torques(:)
      type(tabulated_torque_t), intent(inout) :: motor
      type(status_t), intent(out) :: status
      !> The line with the error, 1 to n; 0 for none.
      integer, intent(out) :: at
      !> Arguments as for `make_tabulated_torque`.
      logical, intent(in), optional :: spline, periodic
      real(wp), intent(in), optional :: start, stop
      !> Limit of |u|, N m; default: none.
      real(wp), intent(in), optional :: torque_limit
      !> True if the wheel has a `speed_limit`.
      logical, intent(in), optional :: stops_at_a_speed
      real(wp), allocatable :: cut_times(:), cut(:, :)
      real(wp) :: limit
      logical :: smooth, round, is_cut
      smooth = .false.
      if (present(spline)) smooth = spline
      round = .false.
      if (present(periodic)) round = periodic
      limit = huge(1.0_wp)
      if (present(torque_limit)) limit = torque_limit
      is_cut = limit < huge(1.0_wp)
      if (present(stops_at_a_speed)) is_cut = is_cut .or. stops_at_a_speed
      at = 0
      if (.not. limit > 0.0_wp) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the limit of the torque is out of range (expected a number > 0)', &
                       'torque_limit')
         return
      end if
      if (smooth .and. is_cut) then
         status = fail(NUTATE_BAD_ARGUMENT, "interpolation = 'cubic' with torque_limit or speed_limit (expected "// &
                       "'linear')", 'interpolation')
         return
      end if
      if (is_cut) then
         call check_table(times, as_columns(torques), smooth, round, at, status)
         if (.not. status%ok()) return
         call cut_lines(times, torques, limit, cut_times, cut)
         call make_tabulated_torque(cut_times, cut, motor, status, at, smooth, round, start=start, stop=stop)
         at = 0
      else
         call make_tabulated_torque(times, as_columns(torques), motor, status, at, smooth, round, start=start, &
                                    stop=stop)
      end if
      motor%name = 'motor'
   end subroutine make_motor_table

   !> Returns torques about the axis as the columns of a table; shape (3, n).
   pure function as_columns(torques) result(columns)
      real(wp), intent(in) :: torques(:)
      real(wp) :: columns(3, size(torques))
      columns = 0.0_wp
      columns(1, :) = torques
   end function as_columns

   !> Finds the points of lines that are cut off at a limit, and the points where the lines pass zero.
   pure subroutine cut_lines(times, torques, limit, cut_times, cut)
      !> Times, s, and torques, N m, of a valid table; shape (n).
      real(wp), intent(in) :: times(:), torques(:)
      !> Limit, N m, positive.
      real(wp), intent(in) :: limit
      !> Times, s, and torques, N m, with the added points; shapes (any), (3, any).
      real(wp), allocatable, intent(out) :: cut_times(:), cut(:, :)
      real(wp) :: new_times(4*size(times)), new(4*size(times)), levels(3), t
      integer :: i, k, n
      n = 0
      do i = 1, size(times)
         if (i > 1) then
            levels = [-limit, 0.0_wp, limit]
            if (torques(i) < torques(i - 1)) levels = -levels
            do k = 1, 3
               if (levels(k) <= min(torques(i - 1), torques(i)) .or. levels(k) >= max(torques(i - 1), torques(i))) cycle
               t = times(i - 1) + (times(i) - times(i - 1))*((levels(k) - torques(i - 1))/(torques(i) - torques(i - 1)))
               ! Rounding may leave no time between two points.
               if (.not. (t > new_times(n) .and. t < times(i))) cycle
               n = n + 1
               new_times(n) = t
               new(n) = levels(k)
            end do
         end if
         n = n + 1
         new_times(n) = times(i)
         new(n) = max(-limit, min(limit, torques(i)))
      end do
      allocate (cut_times, source=new_times(:n))
      allocate (cut(3, n), source=0.0_wp)
      cut(1, :) = new(:n)
   end subroutine cut_lines

end module nutate_wheel_motor
