!> Dates of the Gregorian calendar as days, and the leap seconds of UTC.
module nutate_calendar
   implicit none
   private

   public :: day_of, date_of, days_in_month, is_leap_year, tai_minus_utc, seconds_of_day
   public :: first_year, last_year, first_utc_day, last_known_day

   !> Years of dates that can be written with four digits in the Gregorian calendar.
   integer, parameter :: first_year = 1583, last_year = 9999
   !> Days (MJD) from which UTC has a new difference from TAI. Source: leap-seconds.list of the IERS, Bulletin C.
   integer, parameter :: leap_days(*) = [41317, 41499, 41683, 42048, 42413, 42778, 43144, 43509, 43874, 44239, 44786, &
                                         45151, 45516, 46247, 47161, 47892, 48257, 48804, 49169, 49534, 50083, 50630, &
                                         51179, 53736, 54832, 56109, 57204, 57754]
   !> TAI - UTC on the first of these days, s; each of the others adds a second.
   integer, parameter :: first_difference = 10
   !> 1972-01-01, when integer leap seconds begin, and 2026-06-28, to which the list is known to be complete (MJD).
   integer, parameter :: first_utc_day = 41317, last_known_day = 61219

contains

   !> Returns the Modified Julian Day of a date.
   pure integer function day_of(year, month, day)
      integer, intent(in) :: year, month, day
      integer :: y, m
      ! Years from March, so that the leap day is the last of its year.
      m = modulo(month + 9, 12)
      y = year - m/10
      day_of = 365*y + y/4 - y/100 + y/400 + (m*306 + 5)/10 + day - 1 - 678881
   end function day_of

   !> Computes the date of a Modified Julian Day.
   pure subroutine date_of(mjd, year, month, day)
      integer, intent(in) :: mjd
      integer, intent(out) :: year, month, day
      year = (mjd + 678881)*400/146097
      do while (day_of(year + 1, 1, 1) <= mjd)
         year = year + 1
      end do
      do while (day_of(year, 1, 1) > mjd)
         year = year - 1
      end do
      month = 1
      do while (mjd - day_of(year, month, 1) >= days_in_month(year, month))
         month = month + 1
      end do
      day = mjd - day_of(year, month, 1) + 1
   end subroutine date_of

   !> Returns the number of days in a month.
   pure integer function days_in_month(year, month) result(days)
      integer, intent(in) :: year
      !> 1 to 12.
      integer, intent(in) :: month
      integer, parameter :: usual(12) = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31]
      days = usual(month)
      if (month == 2 .and. is_leap_year(year)) days = 29
   end function days_in_month

   !> Returns true for a year with 366 days.
   pure logical function is_leap_year(year)
      integer, intent(in) :: year
      is_leap_year = modulo(year, 4) == 0 .and. (modulo(year, 100) /= 0 .or. modulo(year, 400) == 0)
   end function is_leap_year

   !> Returns TAI - UTC on a day, s: that of the first day before 1972, that of the last known day later.
   pure integer function tai_minus_utc(mjd) result(difference)
      integer, intent(in) :: mjd
      difference = first_difference + max(count(leap_days <= mjd), 1) - 1
   end function tai_minus_utc

   !> Returns the number of seconds of a day of UTC.
   pure integer function seconds_of_day(mjd) result(seconds)
      integer, intent(in) :: mjd
      seconds = 86400 + tai_minus_utc(mjd + 1) - tai_minus_utc(mjd)
   end function seconds_of_day

end module nutate_calendar
