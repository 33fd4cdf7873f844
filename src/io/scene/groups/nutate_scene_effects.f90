!> The effects of a scene: every group that is not one of its fixed parts.
module nutate_scene_effects
   use nutate_body, only: body_t, whole_body
   use nutate_effect, only: effect_t
   use nutate_effect_list, only: effect_list_t
   use nutate_effect_catalogue, only: effect_kind_t, effect_kinds
   use nutate_inertia_change, only: inertia_change_t
   use nutate_inner_sphere, only: inner_sphere_t
   use nutate_keys, only: group_t, group_kind_t
   use nutate_orbit, only: orbit_t
   use nutate_orbital_effects, only: build_on_orbit, goes_by_orbit
   use nutate_printable, only: quoted
   use nutate_range, only: check_strength
   use nutate_rotor, only: rotor_t
   use nutate_center_change, only: center_change_t
   use nutate_scene_body, only: build_center_table, build_inertia_table
   use nutate_scene_error, only: scene_error_t
   use nutate_controller, only: controller_t
   use nutate_controller_mounting, only: add_controller
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_scene_table, only: read_effect_table
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_system, only: system_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_inner_sphere, add_wheel
   implicit none
   private

   public :: add_effect_kinds, build_effects

   !> Passes through the groups.
   integer, parameter :: FIRST = 1, MIDDLE = 2, LAST = 3

contains

   !> Returns the kinds of group that are effects, behind room for the fixed parts.
   subroutine add_effect_kinds(parts, kinds)
      !> Number of fixed parts.
      integer, intent(in) :: parts
      !> Shape (parts + number of effects); the first `parts` are left to the caller.
      type(group_kind_t), allocatable, intent(out) :: kinds(:)
      type(effect_kind_t), allocatable :: effects(:)
      integer :: i

      effects = effect_kinds()
      allocate (kinds(parts + size(effects)))
      do i = 1, size(effects)
         kinds(parts + i) = effects(i)%group
      end do
   end subroutine add_effect_kinds

   !> Adds the effects that the groups name, in their order but an orbit first and controllers last, to a system.
   !> Effects that depend on the body use the whole body, its wheels locked.
   subroutine build_effects(groups, system, error, folder, nominal)
      !> Groups of the scene; the tables that they name are read.
      type(group_t), intent(inout) :: groups(:)
      !> System whose body is used, and to which the effects are added.
      type(system_t), intent(inout) :: system
      type(scene_error_t), intent(inout) :: error
      !> Folder of the tables, `/` at its end; default: the working directory.
      character(len=*), intent(in), optional :: folder
      !> Body for which controllers are designed; default: the body of the system.
      type(body_t), intent(in), optional :: nominal
      type(effect_kind_t), allocatable :: kinds(:)
      type(body_t) :: body
      integer :: i, k, pass

      kinds = effect_kinds(with_keys=.false.)
      call add_body_tables(groups, system, error)
      if (error%raised) return
      body = whole_body(system%body)
      do pass = FIRST, LAST
         if (pass == LAST .and. present(nominal)) body = nominal
         do i = 1, size(groups)
            if (pass_of(groups(i)) /= pass) cycle
            do k = 1, size(kinds)
               if (kinds(k)%group%name /= groups(i)%name) cycle
               if (present(folder)) then
                  call read_effect_table(groups(i), folder, error, space_axes(groups, system%effects))
               else
                  call read_effect_table(groups(i), '', error, space_axes(groups, system%effects))
               end if
               if (.not. error%raised) call build_one(groups(i), i, kinds(k), body, system, error)
               if (error%raised) return
            end do
         end do
      end do
   end subroutine build_effects

   !> Returns the kind of the space axes, for the headers of tables; `space` without an orbit or a rotating frame.
   function space_axes(groups, effects) result(kind)
      type(group_t), intent(in) :: groups(:)
      !> Effects so far, orbits included.
      type(effect_list_t), intent(in) :: effects
      character(len=:), allocatable :: kind
      integer :: i
      kind = 'space'
      if (effects%on_orbit) then
         kind = 'inertial'
         if (effects%orbit%is_frame) kind = 'LVLH'
      else if (effects%frame_turns .or. &
               any([(groups(i)%name == 'rotating_frame' .and. groups(i)%flag('on', .true.), i=1, size(groups))])) then
         kind = 'rotating'
      end if
   end function space_axes

   !> Adds the changes of inertia and centre of mass that tables of the body describe.
   subroutine add_body_tables(groups, system, error)
      type(group_t), intent(in) :: groups(:)
      type(system_t), intent(inout) :: system
      type(scene_error_t), intent(inout) :: error
      type(inertia_change_t) :: change
      type(center_change_t) :: path
      type(status_t) :: status
      integer :: i
      i = findloc(groups%name, 'body', dim=1)
      if (i == 0) return
      if (groups(i)%has('inertia_table')) then
         call build_inertia_table(groups(i), change, status)
         if (.not. status%ok()) call error%raise_status(groups(i)%line_of('inertia_table'), status)
         if (error%raised) return
         change%group = i
         call system%effects%add(change)
      end if
      if (groups(i)%has('center_of_mass_table')) then
         call build_center_table(groups(i), path, status)
         if (.not. status%ok()) call error%raise_status(groups(i)%line_of('center_of_mass_table'), status)
         if (error%raised) return
         path%group = i
         call system%effects%add(path)
      end if
   end subroutine add_body_tables

   !> Returns the pass in which a group is built: orbits first, since other effects depend on them, and controllers
   !> last, since they act by wheels, in any order of the scene.
   pure integer function pass_of(group)
      type(group_t), intent(in) :: group
      select case (group%name)
      case ('orbit')
         pass_of = FIRST
      case ('controller')
         pass_of = LAST
      case default
         pass_of = MIDDLE
      end select
   end function pass_of

   !> Adds the effect that a group names.
   subroutine build_one(group, place, kind, body, system, error)
      type(group_t), intent(in) :: group
      !> Index among all groups.
      integer, intent(in) :: place
      !> Kind of the effect.
      type(effect_kind_t), intent(in) :: kind
      !> The whole body.
      type(body_t), intent(in) :: body
      type(system_t), intent(inout) :: system
      type(scene_error_t), intent(inout) :: error
      class(effect_t), allocatable :: effect
      logical, allocatable :: chosen(:)
      type(status_t) :: status
      integer :: i
      if (.not. (system%effects%on_orbit .and. goes_by_orbit(group))) then
         call kind%build(group, body, effect, status)
         call finish_one()
         return
      end if
      call choose_orbits(system%effects, chosen)
      do i = 1, size(chosen)
         if (error%raised) return
         if (.not. chosen(i)) cycle
         if (allocated(effect)) deallocate (effect)
         call build_on_orbit(group, system%effects%orbits(i), body, effect, status)
         call finish_one()
      end do

   contains

      !> Adds an effect that was built from a group, and reports its errors.
      subroutine finish_one()
         if (status%ok()) call check_strength(effect, status)
         if (status%ok()) then
            call read_switch()
            effect%group = place
         end if
         if (status%ok() .and. .not. error%raised) call add_effect_of(system, effect, status)
         if (.not. status%ok()) call error%raise_status(group%line_of(trim(status%subject)), status)
      end subroutine finish_one

      !> Finds the orbits to which an effect belongs: the one that its group names; otherwise all for gravity, the main
      !> one for other effects. Raises an error for a name that no orbit has.
      subroutine choose_orbits(effects, chosen)
         !> Effects with an orbit.
         type(effect_list_t), intent(in) :: effects
         !> Orbits to which the effect belongs; shape (number of orbits).
         logical, allocatable, intent(out) :: chosen(:)
         allocate (chosen(size(effects%orbits)))
         chosen = any(group%name == ['gravity_gradient', 'third_degree    ']) .or. &
                  effects%orbits%label == effects%orbit%label
         if (.not. group%has('orbit')) return
         chosen = effects%orbits%label == group%text('orbit', '')
         if (.not. any(chosen)) call error%raise(group%line_of('orbit'), 'no orbit is called '// &
                                                 quoted(group%text('orbit', '')), expected='the name of an &orbit')
      end subroutine choose_orbits

      !> Reads the name by which switches refer to an effect, and its switch at the start of the run.
      subroutine read_switch()
         character(len=:), allocatable :: name
         name = trim(group%text('name', ''))
         if (len(name) > len(effect%label)) call error%raise(group%line_of('name'), 'name is too long', &
                                                             expected='at most 24 characters')
         if (group%has('name') .and. name == '') call error%raise(group%line_of('name'), 'name is blank', &
                                                                  expected='a name for the effect')
         effect%label = name
         effect%on = group%flag('on', .true.)
      end subroutine read_switch

   end subroutine build_one

   !> Adds an effect. A rotor, a rotating frame, an orbit or a change of the inertia that is off is not added, since it
   !> cannot be switched.
   !> Errors: those of `add_wheel`, `add_inner_sphere` and `add_controller`; `NUTATE_BAD_ARGUMENT` for a second frame
   !> beside an orbit, and for incompatible orbits.
   subroutine add_effect_of(system, effect, status)
      type(system_t), intent(inout) :: system
      class(effect_t), intent(in) :: effect
      type(status_t), intent(out) :: status
      select type (effect)
      class is (rotor_t)
         if (effect%on) call system%effects%add(effect)
      type is (inertia_change_t)
         if (effect%on) call system%effects%add(effect)
      type is (rotating_frame_t)
         if (effect%on) call add_frame(system, effect, status)
      type is (orbit_t)
         if (effect%on) call add_frame(system, effect, status)
      type is (wheel_t)
         call add_wheel(system, effect, status)
      type is (inner_sphere_t)
         call add_inner_sphere(system, effect, status)
      type is (controller_t)
         call add_controller(system, effect, status)
      class default
         call system%effects%add(effect)
      end select
   end subroutine add_effect_of

   !> Adds a rotating frame, or an orbit. Errors: those of `add_effect_of`.
   subroutine add_frame(system, frame, status)
      type(system_t), intent(inout) :: system
      class(effect_t), intent(in) :: frame
      type(status_t), intent(out) :: status
      logical :: is_second
      is_second = system%effects%on_orbit
      select type (frame)
      type is (orbit_t)
         is_second = system%effects%frame_turns .and. .not. system%effects%on_orbit
         if (system%effects%on_orbit) call check_further_orbit(system%effects, frame, status)
      end select
      if (is_second) then
         status = fail(NUTATE_BAD_ARGUMENT, 'an orbit defines its own space axes (expected &orbit or &rotating_frame)')
      else if (status%ok()) then
         call system%effects%add(frame)
      end if
   end subroutine add_frame

   !> Checks a further orbit. Errors: `NUTATE_BAD_ARGUMENT` if it is incompatible with the orbits of the system.
   subroutine check_further_orbit(effects, orbit, status)
      !> Effects with an orbit.
      type(effect_list_t), intent(in) :: effects
      type(orbit_t), intent(in) :: orbit
      type(status_t), intent(out) :: status
      if (any(effects%orbits%label == orbit%label) .or. orbit%label == '' .or. any(effects%orbits%label == '')) then
         status = fail(NUTATE_BAD_ARGUMENT, 'several orbits need different names (expected name in each &orbit)', &
                       'name')
      else if (orbit%is_frame .or. any(effects%orbits%is_frame)) then
         status = fail(NUTATE_BAD_ARGUMENT, "several orbits need common space axes (expected frame = 'inertial' in "// &
                       'each &orbit)', 'frame')
      else if (orbit%is_main .and. any(effects%orbits%is_main)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'a second main orbit (expected main = .true. in one &orbit)', 'main')
      end if
   end subroutine check_further_orbit

end module nutate_scene_effects
