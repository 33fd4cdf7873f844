!> The scene group `&orbit`.
module nutate_orbit_group
   use nutate_admissible, only: ANY_DIRECTION, NON_NEGATIVE, POSITIVE, SHAPE_LENGTH
   use nutate_body, only: body_t
   use nutate_effect, only: effect_t
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_keys, only: group_t, key_t, KEY_LOGICAL, KEY_TEXT
   use nutate_kinds, only: wp, pi
   use nutate_orbit, only: earth_mu, earth_radius, orbit_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_track, only: make_track
   implicit none
   private

   public :: orbit_keys, build_orbit

   !> Keys of the scene group `&orbit`.
   type(key_t), parameter :: orbit_keys(17) = [ &
      key_t(name='semi_major_axis', range=SHAPE_LENGTH, &
            instead_of='altitude,periapsis_distance'), &
      key_t(name='altitude', range=SHAPE_LENGTH, &
            instead_of='semi_major_axis,periapsis_distance'), &
      key_t(name='periapsis_distance', range=SHAPE_LENGTH, &
            instead_of='semi_major_axis,altitude'), &
      key_t(name='eccentricity', range=NON_NEGATIVE, default='0', &
            beside='semi_major_axis,altitude,periapsis_distance'), &
      key_t(name='inclination'), &
      key_t(name='raan'), &
      key_t(name='argument_of_periapsis'), &
      key_t(name='mean_anomaly', instead_of='periapsis_time'), &
      key_t(name='periapsis_time', default='0', beside='periapsis_distance', &
            instead_of='mean_anomaly'), &
      key_t(name='mu', range=POSITIVE, default='3.986004418e14'), &
      key_t(name='table', kind=KEY_TEXT), &
      key_t(name='interpolation', kind=KEY_TEXT, choices='cubic,quintic', default='cubic', &
            beside='table'), &
      key_t(name='sun', least=3, most=3, range=ANY_DIRECTION), &
      key_t(name='shadow_radius', range=SHAPE_LENGTH, default='6378137', beside='sun'), &
      key_t(name='frame', kind=KEY_TEXT, choices='lvlh,inertial', default='inertial'), &
      key_t(name='main', kind=KEY_LOGICAL), &
      key_t(name='degrees', kind=KEY_LOGICAL)]

contains

   !> Builds an orbit from its scene group. Errors: `NUTATE_BAD_ARGUMENT` unless it gives one of semi-major axis,
   !> altitude, periapsis distance and table, for an eccentricity out of range, and for an altitude or LVLH axes of an
   !> eccentric orbit.
   subroutine build_orbit(group, body, effect, status)
      type(group_t), intent(in) :: group
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      type(kepler_orbit_t) :: path
      type(orbit_t) :: orbit
      real(wp) :: unit, sun(3)
      if (group%has('table')) then
         call read_track(group, path, status)
      else
         call check_shape(group, status)
      end if
      if (.not. status%ok()) return
      unit = 1.0_wp
      if (group%flag('degrees', .false.)) unit = pi/180
      path%semi_major_axis = group%number('semi_major_axis', earth_radius + group%number('altitude', 0.0_wp))
      path%eccentricity = group%number('eccentricity', 0.0_wp)
      path%mu = group%number('mu', earth_mu)
      path%inclination = unit*group%number('inclination', 0.0_wp)
      path%raan = unit*group%number('raan', 0.0_wp)
      path%argument_of_periapsis = unit*group%number('argument_of_periapsis', 0.0_wp)
      path%mean_anomaly = unit*group%number('mean_anomaly', 0.0_wp)
      path%periapsis_distance = group%number('periapsis_distance', 0.0_wp)
      path%periapsis_time = group%number('periapsis_time', 0.0_wp)
      orbit = orbit_t(path, group%text('frame', 'inertial') == 'inertial')
      orbit%is_main = group%flag('main', .false.)
      if (group%has('sun')) then
         sun = group%vector('sun', orbit%sun)
         ! The vector is scaled first: the squares of a long or short vector would leave the range of numbers.
         sun = sun/maxval(abs(sun))
         orbit%sun = sun/norm2(sun)
         orbit%shadow_radius = group%number('shadow_radius', orbit%shadow_radius)
      end if
      allocate (effect, source=orbit)
   end subroutine build_orbit

   !> Makes the path of a group with a table. Errors: those of `make_track`; `NUTATE_BAD_ARGUMENT` for elements beside a
   !> table, and for a table that has not been read.
   subroutine read_track(group, path, status)
      type(group_t), intent(in) :: group
      type(kepler_orbit_t), intent(inout) :: path
      type(status_t), intent(out) :: status
      character(len=21), parameter :: others(9) = [character(len=21) :: &
         'semi_major_axis', 'altitude', 'periapsis_distance', 'eccentricity', 'inclination', 'raan', &
         'argument_of_periapsis', 'mean_anomaly', 'periapsis_time']
      integer :: i, at
      do i = 1, size(others)
         if (group%has(trim(others(i)))) status = fail(NUTATE_BAD_ARGUMENT, 'table and '//trim(others(i))// &
            ' exclude each other (expected a table or elements)', others(i))
      end do
      if (.not. status%ok()) return
      if (.not. allocated(group%table)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the table has not been read', 'table')
      else if (group%text('frame', 'inertial') == 'lvlh') then
         status = fail(NUTATE_BAD_ARGUMENT, "the LVLH frame of a table does not turn at a constant rate (expected "// &
                       "frame = 'inertial')", 'frame')
      else if (group%text('interpolation', 'cubic') == 'quintic' .and. size(group%table%numbers, 1) < 7) then
         status = fail(NUTATE_BAD_ARGUMENT, "interpolation = 'quintic' needs velocities (expected them in the table)", &
                       'interpolation')
      end if
      if (.not. status%ok()) return
      allocate (path%track)
      associate (x => group%table%numbers)
         if (size(x, 1) < 7) then
            call make_track(x(1, :), x(2:4, :), path%track, status, at)
         else if (group%text('interpolation', 'cubic') == 'quintic') then
            call make_track(x(1, :), x(2:4, :), path%track, status, at, x(5:7, :), group%number('mu', earth_mu))
         else
            call make_track(x(1, :), x(2:4, :), path%track, status, at, x(5:7, :))
         end if
      end associate
   end subroutine read_track

   !> Checks the shape of an orbit. Errors: those of `build_orbit`.
   subroutine check_shape(group, status)
      type(group_t), intent(in) :: group
      type(status_t), intent(out) :: status
      real(wp) :: eccentricity
      eccentricity = group%number('eccentricity', 0.0_wp)
      call check_size(group, status)
      if (.not. status%ok()) return
      if (eccentricity >= 1.0_wp .and. .not. group%has('periapsis_distance')) then
         status = fail(NUTATE_BAD_ARGUMENT, 'eccentricity is out of range (expected a number >= 0 and < 1, or '// &
                       'periapsis_distance)', 'eccentricity')
      else if (eccentricity > 0.0_wp .and. group%has('altitude')) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the altitude of an eccentric orbit changes (expected semi_major_axis '// &
                       'or periapsis_distance)', 'altitude')
      else if (eccentricity > 0.0_wp .and. group%text('frame', 'inertial') == 'lvlh') then
         status = fail(NUTATE_BAD_ARGUMENT, 'the LVLH frame of an eccentric orbit does not turn at a constant rate '// &
                       "(expected frame = 'inertial')", 'frame')
      else if (group%has('shadow_radius') .and. .not. group%has('sun')) then
         status = fail(NUTATE_BAD_ARGUMENT, 'shadow_radius without sun (expected sun)', 'shadow_radius')
      end if
   end subroutine check_shape

   !> Checks the size of an orbit. Errors: `NUTATE_BAD_ARGUMENT` unless a group gives the size, and the position on the
   !> orbit, once.
   subroutine check_size(group, status)
      type(group_t), intent(in) :: group
      type(status_t), intent(out) :: status
      character(len=18), parameter :: sizes(3) = [character(len=18) :: &
                                                  'altitude', 'periapsis_distance', 'semi_major_axis']
      integer :: i, last
      last = 0
      do i = size(sizes), 1, -1
         if (group%has(trim(sizes(i))) .and. last == 0) then
            last = i
         else if (group%has(trim(sizes(i)))) then
            status = fail(NUTATE_BAD_ARGUMENT, trim(sizes(last))//' and '//trim(sizes(i))//' exclude each other '// &
                          '(expected one of them)', sizes(i))
            return
         end if
      end do
      if (last == 0) then
         status = fail(NUTATE_BAD_ARGUMENT, 'an orbit needs semi_major_axis, altitude or periapsis_distance '// &
                       '(expected one of them)')
      else if (group%has('periapsis_distance') .and. group%has('mean_anomaly')) then
         status = fail(NUTATE_BAD_ARGUMENT, 'mean_anomaly with periapsis_distance (expected periapsis_time)', &
                       'mean_anomaly')
      else if (group%has('periapsis_time') .and. .not. group%has('periapsis_distance')) then
         status = fail(NUTATE_BAD_ARGUMENT, 'periapsis_time without periapsis_distance (expected both)', &
                       'periapsis_time')
      end if
   end subroutine check_size

end module nutate_orbit_group
