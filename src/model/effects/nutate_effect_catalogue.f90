!> The effects a scene can name: one line each. A new effect is a file of its own, named here in a `use` and a line.
module nutate_effect_catalogue
   use nutate_applied_torque, only: applied_torque_keys, build_applied_torque
   use nutate_body, only: body_t
   use nutate_damping, only: build_damping, damping_keys
   use nutate_dipole, only: build_dipole, dipole_keys
   use nutate_earth_field, only: build_earth_field, earth_field_keys
   use nutate_effect, only: effect_t
   use nutate_force_group, only: build_force, force_keys
   use nutate_gravity, only: build_gravity, gravity_keys
   use nutate_gravity_gradient, only: build_gravity_gradient, gravity_gradient_keys
   use nutate_inertia_change, only: build_inertia_rate, inertia_rate_keys
   use nutate_inner_sphere, only: build_inner_sphere, inner_sphere_keys
   use nutate_keys, only: group_kind_t, group_t, key_t, KEY_LOGICAL, KEY_TEXT
   use nutate_controller_group, only: build_controller, controller_keys
   use nutate_orbit_group, only: build_orbit, orbit_keys
   use nutate_rotating_frame_group, only: build_rotating_frame, rotating_frame_keys
   use nutate_rotor, only: build_rotor, rotor_keys
   use nutate_spring, only: build_spring, spring_keys
   use nutate_status, only: status_t
   use nutate_tabulated_torque, only: build_tabulated_torque
   use nutate_third_degree, only: build_third_degree, third_degree_keys
   use nutate_wheel_group, only: build_wheel, wheel_keys
   implicit none
   private

   public :: effect_kind_t, effect_kinds

   abstract interface
      !> Makes an effect from a scene's group, whose values have been checked against the effect's keys.
      subroutine build_effect(group, body, effect, status)
         import :: body_t, effect_t, group_t, status_t
         type(group_t), intent(in) :: group
         type(body_t), intent(in) :: body
         class(effect_t), allocatable, intent(out) :: effect
         !> `status%subject` names the key at fault, if there is one.
         type(status_t), intent(out) :: status
      end subroutine build_effect
   end interface

   !> Largest number of kinds of effects.
   integer, parameter :: most_kinds = 32

   !> An effect that a scene can name.
   type :: effect_kind_t
      !> Group name and keys.
      type(group_kind_t) :: group
      procedure(build_effect), pointer, nopass :: build => null()
   end type effect_kind_t

contains

   !> Returns every effect that a scene can name.
   function effect_kinds(with_keys) result(kinds)
      !> Includes the keys of each effect (default); without keys, as for every member of an ensemble, the list is made
      !> in a thirtieth of the time.
      logical, intent(in), optional :: with_keys
      type(effect_kind_t), allocatable :: kinds(:)
      type(effect_kind_t) :: list(most_kinds)
      logical :: takes_keys
      integer :: n
      takes_keys = .true.
      if (present(with_keys)) takes_keys = with_keys
      n = 0
      call add_kind('gravity', gravity_keys, build_gravity, repeatable=.false.)
      call add_kind('dipole', dipole_keys, build_dipole)
      call add_kind('gravity_gradient', gravity_gradient_keys, build_gravity_gradient)
      call add_kind('third_degree', third_degree_keys, build_third_degree)
      call add_kind('spring', spring_keys, build_spring)
      call add_kind('damping', damping_keys, build_damping)
      call add_kind('torque', applied_torque_keys, build_torque)
      call add_kind('rotor', rotor_keys, build_rotor)
      call add_kind('rotating_frame', rotating_frame_keys, build_rotating_frame, repeatable=.false.)
      call add_kind('orbit', orbit_keys, build_orbit)
      call add_kind('earth_field', earth_field_keys, build_earth_field, repeatable=.false.)
      call add_kind('force', force_keys, build_force)
      call add_kind('wheel', wheel_keys, build_wheel)
      call add_kind('inner_sphere', inner_sphere_keys, build_inner_sphere)
      call add_kind('controller', controller_keys, build_controller)
      call add_kind('inertia_rate', inertia_rate_keys, build_inertia_rate)
      kinds = list(:n)

   contains

      subroutine add_kind(name, keys, build, repeatable)
         !> Name of the scene's group.
         character(len=*), intent(in) :: name
         type(key_t), intent(in) :: keys(:)
         procedure(build_effect) :: build
         !> True if a scene may have several groups of this name; default `.true.`.
         logical, intent(in), optional :: repeatable
         n = n + 1
         list(n)%group%name = name
         list(n)%group%repeatable = .true.
         if (present(repeatable)) list(n)%group%repeatable = repeatable
         if (takes_keys) &
            list(n)%group%keys = [keys, key_t(name='name', kind=KEY_TEXT), key_t(name='on', kind=KEY_LOGICAL)]
         list(n)%build => build
      end subroutine add_kind

   end function effect_kinds

   !> Builds a torque from its scene group: harmonic in time, or tabulated.
   subroutine build_torque(group, body, effect, status)
      type(group_t), intent(in) :: group
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      if (group%has('table')) then
         call build_tabulated_torque(group, body, effect, status)
      else
         call build_applied_torque(group, body, effect, status)
      end if
   end subroutine build_torque

end module nutate_effect_catalogue
