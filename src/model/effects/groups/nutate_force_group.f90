!> The scene group `&force`: a constant force at a point of the body, in one of four axes.
module nutate_force_group
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: body_t
   use nutate_lvlh_vector, only: lvlh_vector_t
   use nutate_effect, only: effect_t
   use nutate_force, only: force_t, moving_force_t
   use nutate_keys, only: group_t, key_t, KEY_TEXT
   use nutate_kinds, only: wp
   use nutate_orbit, only: orbit_t
   use nutate_quaternion, only: cross
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_timed_force, only: timed_force_t
   implicit none
   private

   public :: force_keys, build_force, build_force_on_orbit

   !> Keys of the scene group `&force`.
   type(key_t), parameter :: force_keys(5) = [ &
      key_t(name='body_point', least=3, most=3, required=.true.), &
      key_t(name='force', least=3, most=3, required=.true.), &
      key_t(name='axes', kind=KEY_TEXT, choices='space,lvlh,inertial,body', required=.true.), &
      key_t(name='start'), &
      key_t(name='stop')]

   real(wp), parameter :: none(3) = 0.0_wp

contains

   !> Builds a force in space or body axes from its scene group. Errors: `NUTATE_BAD_ARGUMENT` for an empty window,
   !> and for axes that need an orbit.
   subroutine build_force(group, body, effect, status)
      type(group_t), intent(in) :: group
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      type(lvlh_vector_t) :: force
      call check_window(group, status)
      if (.not. status%ok()) return
      force%vector = group%vector('force', none)
      select case (group%text('axes', 'space'))
      case ('body')
         allocate (effect, source=applied_torque_t( &
                   name='force', amplitude=cross(group%vector('body_point', none), force%vector), &
                   start=group%number('start', -huge(1.0_wp)), stop=group%number('stop', huge(1.0_wp))))
      case ('space')
         call make_force(group, force, .false., effect)
      case default
         status = fail(NUTATE_BAD_ARGUMENT, "axes = 'lvlh' or 'inertial' without an orbit (expected &orbit)", &
                       'axes')
      end select
   end subroutine build_force

   !> Builds a force in the LVLH frame, or in inertial axes. Errors: `NUTATE_BAD_ARGUMENT` for an empty window.
   subroutine build_force_on_orbit(group, orbit, effect, status)
      type(group_t), intent(in) :: group
      type(orbit_t), intent(in) :: orbit
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      type(lvlh_vector_t) :: force
      call check_window(group, status)
      if (allocated(orbit%path%track) .and. group%text('axes', '') == 'lvlh') &
         status = fail(NUTATE_BAD_ARGUMENT, "axes = 'lvlh' with a table of &orbit (expected elements of the orbit)", &
                       'axes')
      if (.not. status%ok()) return
      force%vector = group%vector('force', none)
      force%path = orbit%path
      force%from_orbit = orbit%is_frame
      call make_force(group, force, orbit%is_frame .neqv. group%text('axes', '') == 'lvlh', effect)
   end subroutine build_force_on_orbit

   !> Makes a force that is fixed in space axes or moves, at all times or within a window.
   subroutine make_force(group, force, moves, effect)
      type(group_t), intent(in) :: group
      type(lvlh_vector_t), intent(in) :: force
      logical, intent(in) :: moves
      class(effect_t), allocatable, intent(out) :: effect
      type(timed_force_t) :: timed
      if (group%has('start') .or. group%has('stop')) then
         timed%name = 'force'
         timed%body_point = group%vector('body_point', none)
         timed%force = force
         timed%moves = moves
         if (moves) timed%pace = force%path%fastest_turn()
         timed%start = group%number('start', timed%start)
         timed%stop = group%number('stop', timed%stop)
         allocate (effect, source=timed)
      else if (moves) then
         allocate (effect, source=moving_force_t(group%vector('body_point', none), force))
      else
         allocate (effect, source=force_t(group%vector('body_point', none), force%vector))
      end if
   end subroutine make_force

   !> Checks the window. Errors: `NUTATE_BAD_ARGUMENT` for an empty window.
   subroutine check_window(group, status)
      type(group_t), intent(in) :: group
      type(status_t), intent(out) :: status
      if (group%number('stop', huge(1.0_wp)) <= group%number('start', -huge(1.0_wp))) &
         status = fail(NUTATE_BAD_ARGUMENT, 'the force stops before it starts (expected stop > start)', 'stop')
   end subroutine check_window

end module nutate_force_group
