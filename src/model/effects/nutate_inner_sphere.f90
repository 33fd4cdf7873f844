!> A sphere that rotates freely inside of the body, in a viscous fluid: Kane's damper, a fluid core, fuel in a spherical
!> tank. With the inertia I about its centre, its angular velocity ω relative to the body and its momentum h = I(ω + Ω)
!> in body axes,
!>
!>     ḣ = h×Ω - cω,   L = JΩ + h,   T = ½ΩᵀJΩ + |h|²/2I,
!>
!> J that of the body without the sphere. The torque of the fluid is internal: the total momentum stays, and the energy
!> falls at the rate c|ω|². The momentum has the form of those of three wheels along the body axes (`nutate_wheel`), but
!> for the term h×Ω: the sphere does not rotate with the body. The sphere is isotropic, so that no gravity gradient acts
!> on it; its mass is part of the mass and centre of mass of the body.
module nutate_inner_sphere
   use nutate_admissible, only: POSITIVE
   use nutate_body, only: body_t
   use nutate_effect, only: effect_t, LINEAR_SERIES
   use nutate_keys, only: group_t, key_t
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate, least_size
   use nutate_status, only: status_t
   use nutate_wheel, only: follow_switch, wheel_t
   implicit none
   private

   public :: inner_sphere_t, inner_sphere_keys, build_inner_sphere

   !> Keys of the scene group `&inner_sphere`.
   type(key_t), parameter :: inner_sphere_keys(3) = [ &
      key_t(name='inertia', range=POSITIVE, required=.true.), &
      key_t(name='damping', range=POSITIVE, required=.true.), &
      key_t(name='angular_velocity', least=3, most=3, default='0, 0, 0')]

   !> A viscous inner sphere; `add_inner_sphere` adds it to a system.
   type, extends(effect_t) :: inner_sphere_t
      !> I about the centre, kg m².
      real(wp) :: inertia = 0.0_wp
      !> c, N m s.
      real(wp) :: damping = 0.0_wp
      !> ω at the initial state, relative to the body, body axes, rad/s; shape (3).
      real(wp) :: angular_velocity(3) = 0.0_wp
   contains
      procedure :: series_kind => linear_kind
      procedure :: is_valid => sphere_is_valid
      !> Returns the wheel that has the momentum of the sphere along a body axis.
      procedure :: component
   end type inner_sphere_t

   !> Makes an inner sphere.
   interface inner_sphere_t
      module procedure new_inner_sphere
   end interface inner_sphere_t

contains

   !> Makes a viscous inner sphere.
   pure function new_inner_sphere(inertia, damping, angular_velocity) result(sphere)
      !> I, kg m², and c, N m s; positive.
      real(wp), intent(in) :: inertia, damping
      !> ω at the initial state, relative to the body, body axes, rad/s; shape (3); default 0.
      real(wp), intent(in), optional :: angular_velocity(3)
      type(inner_sphere_t) :: sphere
      sphere%name = 'inner_sphere'
      sphere%inertia = inertia
      sphere%damping = damping
      if (present(angular_velocity)) sphere%angular_velocity = angular_velocity
   end function new_inner_sphere

   !> Builds an inner sphere from its scene group. Returns no errors.
   subroutine build_inner_sphere(group, body, effect, status)
      type(group_t), intent(in) :: group
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      allocate (effect, source=inner_sphere_t(group%number('inertia', 0.0_wp), group%number('damping', 0.0_wp), &
                                              group%vector('angular_velocity', [0.0_wp, 0.0_wp, 0.0_wp])))
   end subroutine build_inner_sphere

   !> Returns `LINEAR_SERIES`: the methods expand the momenta themselves.
   pure integer function linear_kind(self)
      class(inner_sphere_t), intent(in) :: self
      linear_kind = LINEAR_SERIES
   end function linear_kind

   !> Returns true if inertia, damping and angular velocity can be computed with.
   pure logical function sphere_is_valid(self) result(valid)
      class(inner_sphere_t), intent(in) :: self
      associate (speed => self%angular_velocity)
         valid = is_moderate(self%inertia) .and. is_moderate(self%damping) .and. all(is_moderate(speed))
         if (valid) valid = self%inertia >= least_size .and. self%damping >= least_size
         if (valid) valid = all(is_moderate(self%inertia*speed)) .and. all(is_moderate(self%damping*speed))
         if (valid) valid = all(is_moderate(self%inertia*speed*speed))
      end associate
   end function sphere_is_valid

   !> Returns the wheel that has the momentum of the sphere along a body axis.
   function component(self, axis) result(wheel)
      class(inner_sphere_t), intent(in) :: self
      !> Body axis: 1, 2 or 3.
      integer, intent(in) :: axis
      type(wheel_t) :: wheel
      wheel%name = self%name
      wheel%label = self%label
      wheel%group = self%group
      wheel%on = self%on
      wheel%axis = 0.0_wp
      wheel%axis(axis) = 1.0_wp
      wheel%inertia = self%inertia
      wheel%speed = self%angular_velocity(axis)
      wheel%damping = self%damping
      wheel%component = axis
      call follow_switch(wheel)
   end function component

end module nutate_inner_sphere
