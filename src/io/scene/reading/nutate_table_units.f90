!> Units in the headers of tables: `omega1 (deg/s)`, and their conversion.
module nutate_table_units
   use nutate_kinds, only: wp, pi
   use nutate_spelling, only: comma_list
   implicit none
   private

   public :: conversion, split_header, units_of

   !> Unit and its value in SI units.
   type :: unit_t
      character(len=8) :: name, si
      real(wp) :: value
   end type unit_t

   real(wp), parameter :: degree = pi/180
   type(unit_t), parameter :: units(*) = [ &
      unit_t('s', 's', 1.0_wp), unit_t('ms', 's', 1e-3_wp), unit_t('us', 's', 1e-6_wp), unit_t('ns', 's', 1e-9_wp), &
      unit_t('min', 's', 60.0_wp), unit_t('h', 's', 3600.0_wp), unit_t('d', 's', 86400.0_wp), &
      unit_t('rad', 'rad', 1.0_wp), unit_t('mrad', 'rad', 1e-3_wp), unit_t('deg', 'rad', degree), &
      unit_t('arcmin', 'rad', degree/60), unit_t('arcsec', 'rad', degree/3600), &
      unit_t('rad/s', 'rad/s', 1.0_wp), unit_t('mrad/s', 'rad/s', 1e-3_wp), unit_t('deg/s', 'rad/s', degree), &
      unit_t('deg/h', 'rad/s', degree/3600), unit_t('deg/d', 'rad/s', degree/86400), unit_t('rpm', 'rad/s', pi/30), &
      unit_t('N m s', 'N m s', 1.0_wp), unit_t('mN m s', 'N m s', 1e-3_wp), unit_t('kg m2/s', 'N m s', 1.0_wp), &
      unit_t('J', 'J', 1.0_wp), unit_t('mJ', 'J', 1e-3_wp), &
      unit_t('T', 'T', 1.0_wp), unit_t('mT', 'T', 1e-3_wp), unit_t('uT', 'T', 1e-6_wp), unit_t('nT', 'T', 1e-9_wp)]

contains

   !> Splits a header into a name and the unit in brackets behind it; without brackets the unit is empty.
   pure subroutine split_header(header, name, unit)
      character(len=*), intent(in) :: header
      character(len=:), allocatable, intent(out) :: name, unit
      integer :: first, last
      unit = ''
      name = trim(header)
      first = scan(header, '([')
      last = len_trim(header)
      if (first == 0) return
      name = trim(header(:first - 1))
      if (scan(header(last:last), ')]') == 1) last = last - 1
      unit = trim(adjustl(header(first + 1:last)))
   end subroutine split_header

   !> Returns the value of one unit in another; 0 if it is unknown or of another quantity.
   pure real(wp) function conversion(unit, wanted)
      character(len=*), intent(in) :: unit
      !> One of the known units.
      character(len=*), intent(in) :: wanted
      integer :: i, k
      conversion = 1.0_wp
      if (unit == wanted) return
      conversion = 0.0_wp
      i = findloc(units%name, unit, dim=1)
      k = findloc(units%name, wanted, dim=1)
      if (min(i, k) == 0) return
      if (units(i)%si == units(k)%si) conversion = units(i)%value/units(k)%value
   end function conversion

   !> Returns the names of the known units of the quantity of a unit.
   pure function units_of(unit) result(names)
      character(len=*), intent(in) :: unit
      character(len=:), allocatable :: names
      integer :: i
      names = comma_list(pack(units%name, [(conversion(trim(units(i)%name), unit) > 0.0_wp, i=1, size(units))]))
   end function units_of

end module nutate_table_units
