!> Calendar time, and what lies between rows of attitudes.
submodule(suites_of_interfaces) test_exchange
   use nutate_attitude_between, only: constant_rate
   use nutate_attitude_rows, only: attitude_rows_t, between_rows, put_in_order, turn_rates
   use nutate_calendar, only: date_of, day_of, seconds_of_day, tai_minus_utc
   use nutate_epoch, only: epoch_t, read_epoch
   use nutate_exact_free, only: free_body_t
   use nutate_kinds, only: eps, pi, wp
   use nutate_moving_frame, only: find_frame, has_time, make_frame, moving_frame_t, see_from_frame
   use nutate_quaternion, only: attitude_distance, quat_product
   use nutate_resampling, only: resample
   use nutate_status, only: status_t
   use nutate_surface, only: surface_of, surface_t
   use nutate_body, only: body_t, make_body
   use test_support, only: check, error_type, new_unittest
   implicit none

   !> Sampled motion: moments, kg m², initial angular velocity, rad/s.
   real(wp), parameter :: moments(3) = [0.64_wp, 0.97_wp, 1.0_wp], start(3) = [1.2_wp, 0.1_wp, 5.6_wp]
   real(wp), parameter :: unit(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]

contains

   module procedure collect_exchange
      testsuite = [ &
                  new_unittest("every day from 1583 to 9999 has its date", days), &
                  new_unittest("UTC is 37 s behind TAI from 2017; the last day of 2016 has 86401 s", leap_seconds), &
                  new_unittest("a time later and the time since are inverse, over leap seconds too", inverse), &
                  new_unittest("instants keep 1e-15 s, and times their decimal digits", digits), &
                  new_unittest("between rows attitudes have an error of order 4, rates of order 3", order_of_curve), &
                  new_unittest("a spin of many turns between rows is followed", many_turns), &
                  new_unittest("chosen rows keep to the error, and are not many more than it needs", chosen_rows), &
                  new_unittest("rows too far apart or too few are refused", refused_rows), &
                  new_unittest("rows backward in time are reversed; rates of a frame are taken off", order_and_rates), &
                  new_unittest("a frame is what lies between its rows, and its sign does not jump", frames), &
                  new_unittest("a frame stands still 1e-6 s beyond its ends", ends_of_frames), &
                  new_unittest("a frame says where its rows are too far apart", far_rows), &
                  new_unittest("the box of inertia has the moments of the body", inertia_box)]
   end procedure collect_exchange

   subroutine days(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: mjd, year, month, day, last(3)
      last = [1582, 12, 31]
      do mjd = day_of(1583, 1, 1), day_of(9999, 12, 31)
         call date_of(mjd, year, month, day)
         if (day_of(year, month, day) /= mjd .or. .not. follows(last, [year, month, day])) then
            call check(error, .false., 'a day has the wrong date')
            return
         end if
         last = [year, month, day]
      end do
      call check(error, all(last == [9999, 12, 31]))
      ! J2000 is at noon of MJD 51544; Apophis passes on MJD 62239.
      call check(error, day_of(2000, 1, 1), 51544)
      call check(error, day_of(2029, 4, 13), 62239)
   end subroutine days

   !> A date is that of the day after another one, by its last component or the turn of a month or year.
   pure logical function follows(before, after)
      integer, intent(in) :: before(3), after(3)
      follows = all(after == before + [0, 0, 1]) .or. (after(3) == 1 .and. before(3) >= 28 .and. &
                                                       (all(after(:2) == before(:2) + [0, 1]) .or. &
                                                        (all(after(:2) == [before(1) + 1, 1]) .and. before(2) == 12)))
   end function follows

   subroutine leap_seconds(error)
      type(error_type), allocatable, intent(out) :: error
      call check(error, tai_minus_utc(day_of(2017, 1, 1)), 37)
      call check(error, tai_minus_utc(day_of(2016, 12, 31)), 36)
      call check(error, tai_minus_utc(day_of(1972, 1, 1)), 10)
      call check(error, tai_minus_utc(day_of(1999, 1, 1)), 32)
      call check(error, seconds_of_day(day_of(2016, 12, 31)), 86401)
      call check(error, seconds_of_day(day_of(2015, 6, 30)), 86401)
      call check(error, seconds_of_day(day_of(2016, 6, 30)), 86400)
   end subroutine leap_seconds

   subroutine inverse(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=3), parameter :: systems(4) = ['TDB', 'TT ', 'TAI', 'UTC']
      real(wp), parameter :: times(6) = [0.0_wp, 1e-7_wp, 86400.125_wp, -86401.5_wp, 1.5e9_wp, -1.2345e9_wp]
      type(epoch_t) :: epoch, later, again
      character(len=:), allocatable :: problem
      integer :: i, k
      do i = 1, size(systems)
         call read_epoch('2016-12-31T23:59:59.75', trim(systems(i)), epoch, problem)
         call check(error, problem == '', problem)
         do k = 1, size(times)
            later = epoch%after(times(k))
            call check(error, abs(later%since(epoch) - times(k)) <= 2*eps*abs(times(k)), 'the time since is another')
            call read_epoch(later%text(), trim(systems(i)), again, problem)
            call check(error, problem == '' .and. again%text() == later%text(), 'a date is not read back')
         end do
      end do
   end subroutine inverse

   subroutine digits(error)
      type(error_type), allocatable, intent(out) :: error
      type(epoch_t) :: epoch, later
      character(len=:), allocatable :: problem
      call read_epoch('2029-04-13T21:46:12.700000000000001', 'TDB', epoch, problem)
      later = epoch%after(1000.1_wp)
      call check(error, later%text() == '2029-04-13T22:02:52.800000000000001', later%text())
      later = epoch%after(-1e-15_wp)
      call check(error, later%text(6) == '2029-04-13T21:46:12.700000', later%text(6))
      later = epoch%after(1e20_wp)
      call check(error, .not. later%is_set())
      call check(error, later%text() == '')
   end subroutine digits

   !> Rows of the exact motion of a free body.
   subroutine sample(n, duration, rows)
      integer, intent(in) :: n
      !> s.
      real(wp), intent(in) :: duration
      type(attitude_rows_t), intent(out) :: rows
      integer :: i
      allocate (rows%t(n), rows%q(4, n), rows%omega(3, n))
      do i = 1, n
         rows%t(i) = duration*(i - 1)/(n - 1)
         call exact(rows%t(i), rows%q(:, i), rows%omega(:, i))
      end do
   end subroutine sample

   !> The exact motion.
   subroutine exact(t, q, omega)
      real(wp), intent(in) :: t
      real(wp), intent(out) :: q(4), omega(3)
      type(free_body_t) :: body
      type(status_t) :: status
      real(wp) :: momentum(3)
      call body%prepare(moments, unit, moments*start, status)
      call body%evaluate(t, q, momentum)
      omega = momentum/moments
   end subroutine exact

   subroutine order_of_curve(error)
      type(error_type), allocatable, intent(out) :: error
      type(attitude_rows_t) :: rows
      real(wp) :: q(4), omega(3), q_exact(4), omega_exact(3), t, errors(2, 2)
      integer :: k, i, j
      errors = 0.0_wp
      do k = 1, 2
         call sample(20*k + 1, 1.0_wp, rows)
         do i = 1, 20*k
            do j = 1, 7
               t = rows%t(i) + j*(rows%t(i + 1) - rows%t(i))/8
               call between_rows(rows, i, i + 1, t, q, omega)
               call exact(t, q_exact, omega_exact)
               errors(:, k) = max(errors(:, k), [attitude_distance(q, q_exact), norm2(omega - omega_exact)])
            end do
         end do
      end do
      call check(error, errors(1, 1) < 1e-4_wp .and. errors(1, 1) > 1e-8_wp)
      call check(error, abs(errors(1, 1)/errors(1, 2) - 16) < 2.0_wp, 'the attitude is not of order 4')
      call check(error, abs(errors(2, 1)/errors(2, 2) - 8) < 1.5_wp, 'the rate is not of order 3')
   end subroutine order_of_curve

   subroutine many_turns(error)
      type(error_type), allocatable, intent(out) :: error
      type(attitude_rows_t) :: rows
      real(wp) :: q(4), omega(3)
      real(wp), parameter :: rate = 100.0_wp
      rows%t = [0.0_wp, 1.0_wp]
      rows%q = reshape([unit, cos(0.5_wp*rate), 0.0_wp, sin(0.5_wp*rate), 0.0_wp], [4, 2])
      rows%omega = reshape([0.0_wp, rate, 0.0_wp, 0.0_wp, rate, 0.0_wp], [3, 2])
      call between_rows(rows, 1, 2, 0.37_wp, q, omega)
      call check(error, attitude_distance(q, [cos(0.185_wp*rate), 0.0_wp, sin(0.185_wp*rate), 0.0_wp]) < 100*rate*eps)
      call check(error, norm2(omega - [0.0_wp, rate, 0.0_wp]) < 100*rate*eps)
   end subroutine many_turns

   subroutine chosen_rows(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: limits(2) = [1e-3_wp, 1e-4_wp]
      type(attitude_rows_t) :: rows, chosen
      character(len=:), allocatable :: problem
      real(wp) :: worst, q(4), omega(3), s
      integer :: k, i, j, counts(2)
      call sample(2001, 20.0_wp, rows)
      do k = 1, 2
         call resample(rows, limits(k), chosen, problem)
         call check(error, problem == '', problem)
         if (allocated(error)) return
         counts(k) = chosen%count()
         worst = 0.0_wp
         do i = 1, chosen%count() - 1
            do j = 1, 19
               s = j/20.0_wp
               call exact(chosen%t(i) + s*(chosen%t(i + 1) - chosen%t(i)), q, omega)
               worst = max(worst, attitude_distance(q, constant_rate(chosen%q(:, i), chosen%q(:, i + 1), s)))
            end do
         end do
         call check(error, worst <= limits(k), 'the error is larger')
         call check(error, worst >= limits(k)/5, 'the error is much smaller: rows are wasted')
      end do
      call check(error, abs(chosen%t(1)) <= 0.0_wp .and. abs(chosen%t(counts(2)) - 20.0_wp) <= 0.0_wp)
      ! The count grows as the root of the error, up to a factor that the halving may add.
      call check(error, counts(2) > 2*counts(1) .and. counts(2) < 5*counts(1))
   end subroutine chosen_rows

   subroutine refused_rows(error)
      type(error_type), allocatable, intent(out) :: error
      type(attitude_rows_t) :: rows, chosen
      character(len=:), allocatable :: problem
      call sample(81, 20.0_wp, rows)
      call resample(rows, 1e-3_wp, chosen, problem)
      call check(error, index(problem, 'the rows are too far apart') == 1, problem)
      call sample(2, 0.1_wp, rows)
      call resample(rows, 1e-3_wp, chosen, problem)
      call check(error, index(problem, 'there are too few rows') == 1, problem)
      deallocate (rows%omega)
      call resample(rows, 1e-3_wp, chosen, problem)
      call check(error, index(problem, 'there are no angular velocities') == 1, problem)
   end subroutine refused_rows

   subroutine order_and_rates(error)
      type(error_type), allocatable, intent(out) :: error
      type(attitude_rows_t) :: rows
      real(wp), parameter :: half = sqrt(0.5_wp)
      rows%t = [0.0_wp, -1.0_wp]
      rows%q = reshape([unit, half, half, 0.0_wp, 0.0_wp], [4, 2])
      rows%omega = reshape([0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 2.0_wp], [3, 2])
      call put_in_order(rows)
      call check(error, all(abs(rows%t - [-1.0_wp, 0.0_wp]) <= 0.0_wp))
      call check(error, rows%q(2, 1) > 0.5_wp .and. abs(rows%omega(3, 1) - 2) <= 0.0_wp)
      ! A quarter turn about x takes the body's y to z: a frame's rate about z is along the body's y.
      call turn_rates(rows, [0.0_wp, 0.0_wp, 0.5_wp])
      call check(error, norm2(rows%omega(:, 1) - [0.0_wp, -0.5_wp, 2.0_wp]) < 4*eps)
      call check(error, norm2(rows%omega(:, 2) - [0.0_wp, 0.0_wp, 0.5_wp]) < 4*eps)
   end subroutine order_and_rates

   !> The rows as a frame.
   subroutine make_frame_of(rows, frame, far)
      type(attitude_rows_t), intent(in) :: rows
      type(moving_frame_t), intent(out) :: frame
      integer, intent(out) :: far
      real(wp) :: numbers(8, rows%count())
      numbers(1, :) = rows%t
      numbers(2:5, :) = rows%q
      if (allocated(rows%omega)) numbers(6:, :) = rows%omega
      call make_frame(numbers(:merge(8, 5, allocated(rows%omega)), :), frame, far)
   end subroutine make_frame_of

   subroutine frames(error)
      type(error_type), allocatable, intent(out) :: error
      type(attitude_rows_t) :: rows
      type(moving_frame_t) :: frame
      real(wp) :: q(4), omega(3), q_rows(4), omega_rows(3), before(4), t, seen(4), angle
      integer :: i, k, n, far
      call sample(41, 2.0_wp, rows)
      n = rows%count()
      ! Signs and lengths of a file are of no account.
      rows%q(:, 2:n:3) = -rows%q(:, 2:n:3)
      rows%q(:, 7) = 1.0005_wp*rows%q(:, 7)
      do k = 1, 2
         if (k == 2) deallocate (rows%omega)
         call make_frame_of(rows, frame, far)
         call check(error, far, 0)
         call check(error, frame%fastest > 5.6_wp .and. frame%fastest < 5.8_wp, 'the greatest rate')
         before = rows%q(:, 1)
         do i = 0, 400
            t = i*0.005_wp
            call find_frame(frame, t, q, omega)
            call check(error, dot_product(q, before) > 0.99_wp, 'the sign jumps')
            before = q
            associate (place => min(1 + i/10, n - 1))
               if (k == 1) then
                  call between_rows(rows, place, place + 1, t, q_rows, omega_rows)
                  call check(error, norm2(omega - omega_rows) < 1e3_wp*eps, 'rate')
               else
                  q_rows = constant_rate(rows%q(:, place), rows%q(:, place + 1), (t - rows%t(place))/0.05_wp)
               end if
            end associate
            call check(error, attitude_distance(q, q_rows) < 64*eps, 'attitude')
            call see_from_frame(frame, t, quat_product(q, [0.0_wp, 0.6_wp, 0.0_wp, 0.8_wp]), seen, angle)
            call check(error, norm2(seen - [0.0_wp, 0.6_wp, 0.0_wp, 0.8_wp]) < 8*eps .and. abs(angle - pi) < 8*eps)
            if (allocated(error)) return
         end do
      end do
   end subroutine frames

   subroutine ends_of_frames(error)
      type(error_type), allocatable, intent(out) :: error
      type(attitude_rows_t) :: rows
      type(moving_frame_t) :: frame
      real(wp) :: q(4), omega(3), last(4)
      integer :: far
      call sample(41, 2.0_wp, rows)
      call make_frame_of(rows, frame, far)
      call check(error, has_time(frame, -1e-6_wp) .and. has_time(frame, 2.0_wp + 0.9e-6_wp), 'near')
      call check(error, .not. (has_time(frame, -1.1e-6_wp) .or. has_time(frame, 2.0_wp + 1.1e-6_wp)), 'far')
      call find_frame(frame, 2.0_wp + 0.9e-6_wp, last, omega)
      call check(error, abs(attitude_distance(last, rows%q(:, 41)) - 0.9e-6_wp*norm2(rows%omega(:, 41))) < 1e-10_wp)
      call check(error, norm2(omega - rows%omega(:, 41)) < 1e-4_wp)
      call find_frame(frame, 2.0_wp + 1e-6_wp, last, omega)
      call find_frame(frame, 1e300_wp, q, omega)
      call check(error, attitude_distance(q, last) < 1e-12_wp .and. norm2(omega) <= 0.0_wp, 'it moves on')
      call find_frame(frame, -1e300_wp, q, omega)
      call check(error, attitude_distance(q, rows%q(:, 1)) < 1e-5_wp .and. norm2(omega) <= 0.0_wp, 'it moved before')
   end subroutine ends_of_frames

   subroutine far_rows(error)
      type(error_type), allocatable, intent(out) :: error
      type(moving_frame_t) :: frame
      real(wp) :: numbers(8, 3)
      integer :: far
      ! A tenth of a turn about z, by the attitudes; three half turns by the rate of the last row, then of the first.
      numbers(:, 1) = [0.0_wp, unit, 0.0_wp, 0.0_wp, 1.0_wp]
      numbers(:, 2) = [1.0_wp, cos(0.1_wp*pi), 0.0_wp, 0.0_wp, sin(0.1_wp*pi), 0.0_wp, 0.0_wp, 1.0_wp]
      numbers(:, 3) = [2.0_wp, cos(0.2_wp*pi), 0.0_wp, 0.0_wp, sin(0.2_wp*pi), 0.0_wp, 0.0_wp, 3*pi]
      call make_frame(numbers, frame, far)
      call check(error, far, 2)
      numbers(8, 1) = 3*pi
      call make_frame(numbers, frame, far)
      call check(error, far, 1)
      call make_frame(numbers(:5, :), frame, far)
      call check(error, far, 0)
      numbers(2:5, 2) = [0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp]
      call make_frame(numbers(:5, :), frame, far)
      call check(error, far, 1)
   end subroutine far_rows

   subroutine inertia_box(error)
      type(error_type), allocatable, intent(out) :: error
      type(body_t) :: body
      type(status_t) :: status
      type(surface_t) :: surface
      real(wp) :: spread_of(3, 3), tensor(3, 3), c(3)
      real(wp), parameter :: mass = 3.0_wp
      integer :: i, k
      tensor = reshape([2.0_wp, 0.3_wp, -0.2_wp, 0.3_wp, 2.5_wp, 0.4_wp, -0.2_wp, 0.4_wp, 3.0_wp], [3, 3])
      c = [0.1_wp, -0.2_wp, 0.3_wp]
      call make_body(tensor, body, status, mass, c, about_center_of_mass=.true.)
      call check(error, status%ok(), trim(status%message))
      surface = surface_of(body, '', [real(wp) ::])
      ! The corners of a box: their second moments are three times those of the box.
      spread_of = 0.0_wp
      do k = 1, 8
         do i = 1, 3
            spread_of(:, i) = spread_of(:, i) + (surface%points(:, k) - c)*(surface%points(i, k) - c(i))*mass/8/3
         end do
      end do
      do i = 1, 3
         do k = 1, 3
            tensor(i, k) = tensor(i, k) + spread_of(i, k)
         end do
         tensor(i, i) = tensor(i, i) - (spread_of(1, 1) + spread_of(2, 2) + spread_of(3, 3))
      end do
      call check(error, maxval(abs(tensor)) < 100*eps, 'the box has another inertia')
   end subroutine inertia_box

end submodule test_exchange
