!> Satellites for tests: an orbit of the Earth, and what moves along it.
module test_satellites
   use nutate_attitude, only: quat_from_axis_angle
   use nutate_body, only: diagonal, make_body
   use nutate_lvlh_vector, only: lvlh_vector_t
   use nutate_earth_field, only: earth_field_t
   use nutate_force, only: moving_force_t
   use nutate_geomagnetic_field, only: geomagnetic_field_t
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: wp, pi
   use nutate_orbit, only: earth_mu, orbit_t
   use nutate_quaternion, only: quat_conjugate, quat_product
   use nutate_status, only: status_t
   use test_problems, only: make_state, new_problem, problem_t
   implicit none
   private

   public :: degree, moments, magnet, point, push, rotating, MAGNETIC, FORCE_ALONG, BOTH
   public :: path_of, field_along, push_along, satellite

   real(wp), parameter :: degree = pi/180
   !> Moments of the body, kg m²; its magnetic moment, A m²; a point of it, m, and a force there, N.
   real(wp), parameter :: moments(3) = [0.09_wp, 0.1_wp, 0.04_wp], magnet(3) = [0.6_wp, -0.9_wp, 1.2_wp], &
                          point(3) = [0.1_wp, -0.3_wp, 0.2_wp], push(3) = [2e-5_wp, 3e-5_wp, -4e-5_wp]
   !> Start against the stars, rad/s.
   real(wp), parameter :: rotating(3) = [4e-3_wp, -3e-3_wp, 5e-3_wp]

   !> Effects in the axes of the scene.
   integer, parameter :: MAGNETIC = 1, FORCE_ALONG = 2, BOTH = 3

contains

   type(kepler_orbit_t) function path_of(eccentricity) result(path)
      real(wp), intent(in) :: eccentricity
      path = kepler_orbit_t(semi_major_axis=1e7_wp, eccentricity=eccentricity, mu=earth_mu, inclination=60*degree, &
                            raan=30*degree, argument_of_periapsis=45*degree, mean_anomaly=1.0_wp)
   end function path_of

   !> The field of the Earth as the axes of an orbit see it.
   type(geomagnetic_field_t) function field_along(orbit) result(field)
      type(orbit_t), intent(in) :: orbit
      field%path = orbit%path
      field%in_orbit = orbit%is_frame
      field%epoch_angle = 0.7_wp
   end function field_along

   !> A force that the axes of an orbit see moving.
   type(lvlh_vector_t) function push_along(orbit) result(force)
      type(orbit_t), intent(in) :: orbit
      force%path = orbit%path
      force%from_orbit = orbit%is_frame
      force%vector = push
   end function push_along

   !> A body on an orbit, with what acts on it.
   function satellite(orbit, what) result(problem)
      type(orbit_t), intent(in) :: orbit
      integer, intent(in) :: what
      type(problem_t), pointer :: problem
      type(status_t) :: status
      real(wp) :: q(4)
      problem => new_problem()
      call make_body(diagonal(moments), problem%system%body, status)
      call problem%system%effects%add(orbit)
      if (what /= FORCE_ALONG) call problem%system%effects%add(earth_field_t(magnet, field_along(orbit)))
      if (what /= MAGNETIC) call problem%system%effects%add(moving_force_t(point, push_along(orbit)))
      call quat_from_axis_angle([1.0_wp, 1.0_wp, 1.0_wp], 40*degree, q, status)
      if (orbit%is_frame) q = quat_product(quat_conjugate(orbit%path%axes(0.0_wp)), q)
      problem%start = make_state(problem%system, q, rotating)
   end function satellite

end module test_satellites
