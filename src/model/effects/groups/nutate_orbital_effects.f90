!> Effects that depend on the orbit of the scene.
module nutate_orbital_effects
   use nutate_body, only: body_t
   use nutate_earth_field, only: field_on_orbit
   use nutate_effect, only: effect_t
   use nutate_force_group, only: build_force_on_orbit
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_keys, only: group_t
   use nutate_orbit, only: orbit_t
   use nutate_orbital_gradient, only: orbital_gradient_t
   use nutate_status, only: status_t
   use nutate_third_degree, only: third_degree_on_orbit
   implicit none
   private

   public :: goes_by_orbit, build_on_orbit

contains

   !> Returns true for an effect that depends on the orbit: a gravity gradient without direction and strength, the field
   !> of the Earth, gravity of third degree, or a force in axes that only an orbit has.
   pure logical function goes_by_orbit(group)
      type(group_t), intent(in) :: group
      select case (group%name)
      case ('gravity_gradient')
         goes_by_orbit = .not. (group%has('direction') .or. group%has('strength'))
      case ('earth_field', 'third_degree')
         goes_by_orbit = .true.
      case ('force')
         goes_by_orbit = any(group%text('axes', '') == ['lvlh    ', 'inertial'])
      case default
         goes_by_orbit = .false.
      end select
   end function goes_by_orbit

   !> Builds an effect that depends on the orbit: constant if it is fixed in the axes of the scene, else moving. Errors:
   !> those of `build_force_on_orbit`.
   subroutine build_on_orbit(group, orbit, body, effect, status)
      type(group_t), intent(in) :: group
      type(orbit_t), intent(in) :: orbit
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      select case (group%name)
      case ('earth_field')
         allocate (effect, source=field_on_orbit(group, orbit))
      case ('force')
         call build_force_on_orbit(group, orbit, effect, status)
      case ('third_degree')
         call third_degree_on_orbit(group, orbit, effect, status)
      case default
         if (orbit%is_frame) then
            allocate (effect, source=gravity_gradient_t(body, orbit))
         else
            allocate (effect, source=orbital_gradient_t(body, orbit%path))
         end if
      end select
   end subroutine build_on_orbit

end module nutate_orbital_effects
