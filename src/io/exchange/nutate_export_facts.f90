!> Facts that files for other programs need and a history lacks: labels, body, and the rotation of the space axes.
module nutate_export_facts
   use nutate_body, only: body_t
   use nutate_effect_list, only: effect_list_t
   use nutate_keys, only: first_group, group_t, group_kind_t
   use nutate_kinds, only: wp
   use nutate_scene, only: scene_t, scene_kinds
   use nutate_scene_body, only: build_body
   use nutate_scene_table, only: read_effect_table
   use nutate_scene_check, only: read_groups
   use nutate_scene_error, only: scene_error_t, error_line
   use nutate_scene_labels, only: build_labels, labels_t
   use nutate_scene_override, only: apply_override
   use nutate_status, only: status_t, fail, NUTATE_BAD_SCENE
   implicit none
   private

   public :: export_facts_t, facts_of_scene, parse_facts

   !> Facts about a history.
   type :: export_facts_t
      type(labels_t) :: labels
      logical :: has_body = .false.
      type(body_t) :: body
      !> Name of the body's shape, and its lengths, m; blank if the inertia is given.
      character(len=:), allocatable :: shape
      real(wp), allocatable :: size(:)
      !> Space axes and orbits of the scene.
      type(effect_list_t) :: effects
   end type export_facts_t

contains

   !> Returns the facts that a scene has.
   function facts_of_scene(scene) result(facts)
      type(scene_t), intent(in) :: scene
      type(export_facts_t) :: facts
      facts%labels = scene%labels
      call take_body(scene%groups, scene%system%body, scene%shape, facts)
      facts%effects = scene%system%effects
   end function facts_of_scene

   !> Reads facts from groups `&scene` and `&body`, as those of scenes; both are optional.
   subroutine parse_facts(text, name, overrides, facts, status, message)
      !> The groups; may be empty.
      character(len=*), intent(in) :: text
      !> Name of the text in messages.
      character(len=*), intent(in) :: name
      !> `GROUP.KEY=VALUE` or `-GROUP.KEY`, applied in order after the text.
      character(len=*), intent(in) :: overrides(:)
      type(export_facts_t), intent(out) :: facts
      type(status_t), intent(out) :: status
      !> Error message, one printable line; empty on success.
      character(len=:), allocatable, intent(out) :: message
      type(group_kind_t), allocatable :: all_kinds(:), kinds(:)
      type(group_t), allocatable :: groups(:)
      type(scene_error_t) :: error
      type(body_t) :: body
      character(len=:), allocatable :: shape
      integer :: i, last_line

      all_kinds = scene_kinds()
      allocate (kinds(2))
      kinds(1) = all_kinds(findloc(all_kinds%name == 'scene', .true., dim=1))
      kinds(2) = all_kinds(findloc(all_kinds%name == 'body', .true., dim=1))
      call read_groups(text, kinds, groups, last_line, error)
      do i = 1, size(overrides)
         call apply_override(trim(overrides(i)), kinds, groups, error)
      end do
      if (.not. error%raised) call build_labels(first_group(groups, 'scene'), facts%labels, error)
      if (.not. error%raised .and. any(groups%name == 'body')) then
         i = findloc(groups%name, 'body', dim=1)
         call read_effect_table(groups(i), name(:index(name, '/', back=.true.)), error)
         if (.not. error%raised) call build_body(first_group(groups, 'body'), body, shape, error)
         if (.not. error%raised) call take_body(groups, body, shape, facts)
      end if
      message = ''
      if (.not. error%raised) return
      message = error_line(name, error)
      status = fail(NUTATE_BAD_SCENE, message)
   end subroutine parse_facts

   !> Stores a body with the lengths of its shape.
   subroutine take_body(groups, body, shape, facts)
      type(group_t), intent(in) :: groups(:)
      type(body_t), intent(in) :: body
      character(len=*), intent(in) :: shape
      type(export_facts_t), intent(inout) :: facts
      type(group_t) :: group
      facts%has_body = .true.
      facts%body = body
      facts%shape = shape
      group = first_group(groups, 'body')
      facts%size = group%vector('size', spread(0.0_wp, 1, group%count_of('size')))
   end subroutine take_body

end module nutate_export_facts
