!> Instants of calendar time, to 1e-15 s: the date of t = 0, and the date of any t.
!>
!> Seconds of t are counted in the time system of the epoch; seconds of UTC, TAI and TT have one length. Dates follow
!> CCSDS 301.0-B, format A (`2029-04-13T21:46:12.7`) and B (`2029-103T21:46:12.7`).
module nutate_epoch
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_calendar, only: date_of, day_of, days_in_month, first_utc_day, first_year, is_leap_year, last_known_day, &
      last_year, seconds_of_day, tai_minus_utc
   use nutate_decimal, only: exact_text
   use nutate_kinds, only: wp, long
   implicit none
   private

   public :: epoch_t, read_epoch, time_systems

   !> Time systems: barycentric dynamical, terrestrial, atomic, and coordinated universal time.
   character(len=*), parameter :: time_systems = 'TDB,TT,TAI,UTC'
   !> Digits after the decimal point of a second, and its parts, 1e-15 s.
   integer, parameter :: digits = 15
   integer(long), parameter :: parts = 10_long**digits
   integer, parameter :: seconds_in_day = 86400
   !> Longest time from an epoch: more than all years, s.
   real(wp), parameter :: longest_time = 4e11_wp
   !> TT - TAI, s, in parts of a second; 2000-01-01, at whose noon J2000 is (MJD).
   integer(long), parameter :: tt_minus_tai = 32184*(parts/1000)
   integer, parameter :: j2000_day = 51544
   character(len=*), parameter :: example = '2029-04-13T21:46:12.7'

   !> An instant.
   type :: epoch_t
      !> Modified Julian Day, second of it (86400 is a leap second), and the rest, 1e-15 s.
      integer :: day = 0, second = 0
      integer(long) :: part = 0
      !> `TDB`, `TT`, `TAI` or `UTC`; blank: no instant.
      character(len=3) :: system = ''
   contains
      !> Returns true if the epoch is an instant.
      procedure, non_overridable :: is_set
      !> Returns the instant after a time.
      procedure, non_overridable :: after
      !> Returns the date as text.
      procedure, non_overridable :: text => date_text
      !> Returns the time since another instant, s.
      procedure, non_overridable :: since
      !> Returns barycentric dynamical time past J2000, s.
      procedure, non_overridable :: tdb
      !> Returns true for an instant of UTC after the last day up to which leap seconds are known.
      procedure, non_overridable :: is_uncertain
   end type epoch_t

contains

   !> Returns true if the epoch is an instant.
   pure logical function is_set(self)
      class(epoch_t), intent(in) :: self
      is_set = self%system /= ''
   end function is_set

   !> Reads a date.
   pure subroutine read_epoch(text, system, epoch, problem, in_message)
      !> Format A or B, without time of day, or with it and up to 15 digits of a fraction; a `Z` at the end stands for
      !> UTC.
      character(len=*), intent(in) :: text
      !> One of `time_systems`.
      character(len=*), intent(in) :: system
      type(epoch_t), intent(out) :: epoch
      !> Message to follow the text: the fault, and what is expected; empty on success.
      character(len=:), allocatable, intent(out) :: problem
      !> True for a date of a message, which may end in `Z` in every time system.
      logical, intent(in), optional :: in_message
      character(len=:), allocatable :: date, time
      logical :: z_is_utc
      integer :: t

      problem = ''
      z_is_utc = .true.
      if (present(in_message)) z_is_utc = .not. in_message
      date = trim(text)
      if (len(date) > 1 .and. index(date, 'T') > 0 .and. index(date, 'Z') == len(date)) date = date(:len(date) - 1)
      t = index(date, 'T')
      time = '00:00:00'
      if (t > 0) then
         time = date(t + 1:)
         date = date(:t - 1)
      end if
      call read_day(date, epoch%day, problem)
      if (problem == '') call read_time(time, epoch, problem)
      if (problem == '' .and. system == 'UTC' .and. epoch%day < first_utc_day) &
         problem = 'is before 1972, when UTC had no leap seconds (expected TAI, TT or TDB)'
      if (problem == '' .and. epoch%second == seconds_in_day) then
         if (system /= 'UTC' .or. seconds_of_day(epoch%day) == seconds_in_day) &
            problem = 'is no leap second of UTC (expected seconds below 60)'
      end if
      if (problem == '' .and. z_is_utc .and. system /= 'UTC' .and. index(text, 'Z') > 0) &
         problem = "ends in Z, which stands for UTC (expected time_system = 'UTC', or a date without Z)"
      if (problem == '') epoch%system = system
   end subroutine read_epoch

   !> Reads `YYYY-MM-DD` or `YYYY-DDD`.
   pure subroutine read_day(date, mjd, problem)
      character(len=*), intent(in) :: date
      integer, intent(out) :: mjd
      character(len=:), allocatable, intent(inout) :: problem
      integer :: year, month, day, longest
      mjd = 0
      month = 1
      problem = 'is not a date (expected one such as '//example//')'
      if (len(date) /= 10 .and. len(date) /= 8) return
      year = number(date(:4))
      if (len(date) == 10) month = number(date(6:7))
      day = number(date(len(date) - merge(1, 2, len(date) == 10):))
      if (min(year, month, day) < 0 .or. date(5:5) /= '-') return
      if (len(date) == 10) then
         if (date(8:8) /= '-') return
      end if
      if (year < first_year .or. month < 1 .or. month > 12) then
         problem = 'is no date of the Gregorian calendar (expected years 1583 to 9999, months 01 to 12)'
         return
      end if
      longest = merge(366, 365, is_leap_year(year))
      if (len(date) == 10) longest = days_in_month(year, month)
      problem = ''
      if (day < 1 .or. day > longest) problem = 'is no date of the Gregorian calendar (no such day)'
      mjd = day_of(year, month, day)
   end subroutine read_day

   !> Reads `hh:mm:ss.ddd`.
   pure subroutine read_time(time, epoch, problem)
      character(len=*), intent(in) :: time
      type(epoch_t), intent(inout) :: epoch
      character(len=:), allocatable, intent(inout) :: problem
      integer :: hour, minute, second, i
      problem = 'has no time of day (expected hh:mm:ss, such as '//example//')'
      if (len(time) < 8) return
      hour = number(time(1:2))
      minute = number(time(4:5))
      second = number(time(7:8))
      if (min(hour, minute, second) < 0 .or. time(3:3) /= ':' .or. time(6:6) /= ':') return
      if (len(time) > 8) then
         if (time(9:9) /= '.' .or. len(time) == 9 .or. verify(time(10:), '0123456789') > 0) return
      end if
      problem = ''
      if (hour > 23 .or. minute > 59 .or. second > 60 .or. (second == 60 .and. (hour /= 23 .or. minute /= 59))) then
         problem = 'has an impossible time of day (expected 00:00:00 to 23:59:59)'
         return
      end if
      epoch%second = 3600*hour + 60*minute + second
      epoch%part = 0
      do i = 10, min(len(time), 9 + digits)
         epoch%part = epoch%part + number(time(i:i))*10_long**(digits - (i - 9))
      end do
   end subroutine read_time

   !> Returns the value of a text of digits; -1 for any other.
   pure integer function number(text)
      character(len=*), intent(in) :: text
      integer :: i
      number = -1
      if (verify(text, '0123456789') > 0) return
      number = 0
      do i = 1, len(text)
         number = 10*number + iachar(text(i:i)) - iachar('0')
      end do
   end function number

   !> Returns the instant t seconds later; no instant if its year does not have four digits, or is before 1583, or if
   !> UTC is not defined then.
   pure type(epoch_t) function after(self, t) result(later)
      class(epoch_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      type(epoch_t) :: uniform
      integer(long) :: seconds, part
      if (.not. self%is_set() .or. .not. ieee_is_finite(t)) return
      if (abs(t) > longest_time) return
      uniform = uniform_time(self)
      call split_time(t, seconds, part)
      call normalize(uniform%day, uniform%second + seconds, uniform%part + part, later)
      later%system = self%system
      if (self%system == 'UTC') call turn_to_utc(later)
      if (later%day < merge(first_utc_day, day_of(first_year, 1, 1), self%system == 'UTC') .or. &
          later%day > day_of(last_year, 12, 31)) later%system = ''
   end function after

   !> Returns an instant in a time system without leap seconds: UTC as TAI, others unchanged.
   pure type(epoch_t) function uniform_time(epoch) result(uniform)
      class(epoch_t), intent(in) :: epoch
      uniform%day = epoch%day
      uniform%second = epoch%second
      uniform%part = epoch%part
      uniform%system = epoch%system
      if (epoch%system /= 'UTC') return
      call normalize(epoch%day, int(epoch%second + tai_minus_utc(epoch%day), long), epoch%part, uniform)
      uniform%system = 'TAI'
   end function uniform_time

   !> Converts an instant from TAI to UTC.
   pure subroutine turn_to_utc(epoch)
      type(epoch_t), intent(inout) :: epoch
      type(epoch_t) :: utc
      integer :: day
      do day = epoch%day, epoch%day - 1, -1
         utc%day = day
         utc%part = epoch%part
         utc%second = epoch%second - tai_minus_utc(day) + seconds_in_day*(epoch%day - day)
         if (utc%second >= 0 .and. utc%second < seconds_of_day(day)) exit
      end do
      utc%system = epoch%system
      epoch = utc
   end subroutine turn_to_utc

   !> Reduces seconds and their parts to the range of a day, and changes the day accordingly.
   pure subroutine normalize(day, second, part, epoch)
      integer, intent(in) :: day
      integer(long), intent(in) :: second, part
      !> Reduced instant; its time system is not changed.
      type(epoch_t), intent(inout) :: epoch
      integer(long) :: seconds
      seconds = second + (part - modulo(part, parts))/parts
      epoch%part = modulo(part, parts)
      epoch%second = int(modulo(seconds, int(seconds_in_day, long)))
      epoch%day = day + int((seconds - epoch%second)/seconds_in_day)
   end subroutine normalize

   !> Splits a time into integer seconds and parts, both of its sign, by the decimal number that it is written as.
   pure subroutine split_time(t, seconds, part)
      !> Time, s, less than `longest_time`.
      real(wp), intent(in) :: t
      integer(long), intent(out) :: seconds, part
      character(len=:), allocatable :: text
      integer :: point, i
      text = exact_text(abs(t))
      seconds = int(abs(t), long)
      part = 0
      point = index(text, '.')
      if (scan(text, 'eE') > 0) then
         part = nint((abs(t) - real(seconds, wp))*real(parts, wp), long)
      else if (point > 0) then
         do i = point + 1, min(len(text), point + digits)
            part = part + number(text(i:i))*10_long**(digits - (i - point))
         end do
         if (len(text) > point + digits) then
            if (number(text(point + digits + 1:point + digits + 1)) >= 5) part = part + 1
         end if
      end if
      if (t < 0.0_wp) then
         seconds = -seconds
         part = -part
      end if
   end subroutine split_time

   !> Returns the date in format A, `2029-04-13T21:46:12.700000`: with as many digits as are needed, but at least
   !> `least`. Empty for no instant.
   pure function date_text(self, least) result(text)
      class(epoch_t), intent(in) :: self
      !> Digits after the decimal point, 0 to 15; default 0.
      integer, intent(in), optional :: least
      character(len=:), allocatable :: text
      character(len=35) :: line
      integer :: year, month, day, minutes, n
      text = ''
      if (.not. self%is_set()) return
      call date_of(self%day, year, month, day)
      ! A leap second belongs to the last minute of its day.
      minutes = min(self%second/60, 1439)
      write (line, '(i4.4,"-",i2.2,"-",i2.2,"T",i2.2,":",i2.2,":",i2.2,".",i15.15)') &
         year, month, day, minutes/60, modulo(minutes, 60), self%second - 60*minutes, self%part
      n = verify(line, '0', back=.true.) - 20
      if (present(least)) n = max(n, least)
      text = line(:19)
      if (n > 0) text = line(:20 + n)
   end function date_text

   !> Returns the time since an instant, s.
   pure real(wp) function since(self, earlier) result(t)
      class(epoch_t), intent(in) :: self
      !> Instant in the same time system.
      class(epoch_t), intent(in) :: earlier
      type(epoch_t) :: a, b
      a = uniform_time(self)
      b = uniform_time(earlier)
      t = real(seconds_in_day*int(a%day - b%day, long) + (a%second - b%second), wp) + &
          real(a%part - b%part, wp)/real(parts, wp)
   end function since

   !> Returns barycentric dynamical time past J2000, s, from TT by the formula of the leapseconds kernels of SPICE,
   !> which is good to 30 µs.
   pure real(wp) function tdb(self)
      class(epoch_t), intent(in) :: self
      type(epoch_t) :: tt, j2000
      real(wp) :: anomaly
      tt = uniform_time(self)
      if (tt%system == 'TAI') call normalize((tt%day), int(tt%second, long), tt%part + tt_minus_tai, tt)
      j2000%day = j2000_day
      j2000%second = seconds_in_day/2
      tdb = tt%since(j2000)
      if (self%system == 'TDB') return
      anomaly = 6.239996_wp + 1.99096871e-7_wp*tdb
      tdb = tdb + 1.657e-3_wp*sin(anomaly + 1.671e-2_wp*sin(anomaly))
   end function tdb

   !> Returns true for an instant of UTC after the last day up to which leap seconds are known.
   pure logical function is_uncertain(self)
      class(epoch_t), intent(in) :: self
      is_uncertain = self%system == 'UTC' .and. self%day >= last_known_day
   end function is_uncertain

end module nutate_epoch
