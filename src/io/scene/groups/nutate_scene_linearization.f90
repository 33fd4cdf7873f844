!> Linearises the motion of a scene, and finds its equilibria.
module nutate_scene_linearization
   use nutate_equilibria, only: equilibria_t, find_equilibria
   use nutate_kinds, only: wp
   use nutate_linearization, only: linearization_t, linearize_equilibrium, linearize_period, period_of_orbit
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: linearize_scene, scene_equilibria

contains

   !> Linearises the motion of a scene about its initial state, or over a period. Errors: those of the linearisation;
   !> `NUTATE_BAD_ARGUMENT` for events that switch effects in a period, and for the period of an orbit that the scene
   !> does not have.
   subroutine linearize_scene(scene, period, linear, status)
      type(scene_t), intent(in) :: scene
      !> Period, s; 0: the initial state is an equilibrium; negative: the period of the orbit.
      real(wp), intent(in) :: period
      type(linearization_t), intent(out) :: linear
      type(status_t), intent(out) :: status
      real(wp) :: whole
      integer :: i
      if (.not. abs(period) > 0.0_wp) then
         call linearize_equilibrium(scene%system, scene%initial, scene%plan%end_time, linear, status)
         return
      end if
      whole = period
      if (period < 0.0_wp) whole = period_of_orbit(scene%system)
      if (.not. whole > 0.0_wp) &
         status = fail(NUTATE_BAD_ARGUMENT, 'there is no orbit with a period (expected &orbit, or a period in seconds)')
      do i = 1, scene%events%count()
         if (scene%events%slots(i)%item%action == 0) cycle
         status = fail(NUTATE_BAD_ARGUMENT, 'a linearised period does not support events that switch effects '// &
                       '(expected no switch)')
      end do
      if (status%ok()) call linearize_period(scene%system, scene%integrator, scene%initial, scene%plan, whole, linear, &
                                             status)
   end subroutine linearize_scene

   !> Finds all equilibria of a scene; only the wheel speeds of its initial state matter. Errors: those of
   !> `find_equilibria`.
   subroutine scene_equilibria(scene, found, status)
      type(scene_t), intent(in) :: scene
      type(equilibria_t), intent(out) :: found
      type(status_t), intent(out) :: status
      integer :: i
      associate (effects => scene%system%effects)
         call find_equilibria(scene%system, [(effects%wheels(i)%speed, i=1, effects%n_wheels)], found, status)
      end associate
   end subroutine scene_equilibria

end module nutate_scene_linearization
