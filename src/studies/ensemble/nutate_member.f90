!> One member of an ensemble at a time: the scene with the member's numbers in it, checked and built like any scene.
module nutate_member
   use nutate_admissible, only: admits
   use nutate_ensemble_plan, only: ensemble_plan_t, target_t
   use nutate_keys, only: setting_t, KEY_INTEGER
   use nutate_kinds, only: wp, long
   use nutate_sampling, only: draw_values
   use nutate_scene, only: changed_part, keep_added, rebuild_scene, scene_t
   use nutate_scene_error, only: scene_error_t
   use nutate_scene_values, only: check_setting
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_SCENE
   implicit none
   private

   public :: member_t

   !> Largest integer that a key accepts.
   real(wp), parameter :: greatest_whole = 999999999.0_wp

   !> A scene into which the values of one member of an ensemble after another are set.
   type :: member_t
      !> Scene of the member set last, without its ensemble.
      class(scene_t), allocatable :: scene
      !> The values that the member varies; shape (number of varied values).
      real(wp), allocatable :: values(:)
      !> Part of the scene that is rebuilt for each member.
      integer, private :: part = 0
      !> Indices of the targets that are the first of their key.
      integer, allocatable, private :: keys(:)
   contains
      !> Prepares for a scene with an ensemble.
      procedure :: prepare
      !> Sets the values of a member.
      procedure :: set_values
   end type member_t

contains

   !> Prepares for a scene with an ensemble.
   subroutine prepare(self, scene)
      class(member_t), intent(inout) :: self
      type(scene_t), intent(in) :: scene
      integer :: i
      if (allocated(self%scene)) deallocate (self%scene)
      if (allocated(self%values)) deallocate (self%values)
      allocate (self%scene, source=scene)
      call keep_added(self%scene)
      call forget(self%scene%ensemble)
      self%scene%groups = scene%ensemble%groups
      associate (targets => scene%ensemble%targets)
         allocate (self%values(size(targets)))
         self%part = changed_part(scene%ensemble%groups, [(any(targets%group == i), i=1, size(scene%ensemble%groups))])
         self%keys = pack([(i, i=1, size(targets))], [(is_first(targets, i), i=1, size(targets))])
      end associate
   end subroutine prepare

   !> Empties the plan of an ensemble.
   subroutine forget(plan)
      type(ensemble_plan_t), intent(out) :: plan
   end subroutine forget

   !> Returns true for the first target of its key.
   pure logical function is_first(targets, i)
      type(target_t), intent(in) :: targets(:)
      integer, intent(in) :: i
      is_first = .not. any(targets(:i - 1)%group == targets(i)%group .and. &
                           targets(:i - 1)%setting == targets(i)%setting)
   end function is_first

   !> Sets the values of a member. Errors: `NUTATE_BAD_SCENE`, or a more specific code, if the scene rejects a value.
   subroutine set_values(self, plan, number, status)
      !> Prepared member.
      class(member_t), intent(inout) :: self
      !> The ensemble of the scene.
      type(ensemble_plan_t), intent(in) :: plan
      !> Number of the member, 1 to `plan%members`.
      integer(long), intent(in) :: number
      type(status_t), intent(out) :: status
      type(scene_error_t) :: error
      integer :: i
      call draw_values(plan, number, self%values)
      do i = 1, size(plan%targets)
         associate (target => plan%targets(i))
            associate (value => self%scene%groups(target%group)%settings(target%setting)%values(target%value))
               value%number = self%values(i)
               if (target%key%kind == KEY_INTEGER .and. abs(self%values(i)) <= greatest_whole) &
                  value%whole = nint(self%values(i))
            end associate
         end associate
      end do
      do i = 1, size(self%keys)
         associate (target => plan%targets(self%keys(i)))
            call check_numbers(target, self%scene%groups(target%group)%settings(target%setting), error)
         end associate
      end do
      if (.not. error%raised) call rebuild_scene(self%scene, self%part, error)
      if (.not. error%raised) return
      if (error%code == NUTATE_BAD_ARGUMENT) error%code = NUTATE_BAD_SCENE
      status = fail(error%code, error%text)
   end subroutine set_values

   !> Raises an error for numbers that their key does not admit.
   subroutine check_numbers(target, setting, error)
      type(target_t), intent(in) :: target
      type(setting_t), intent(in) :: setting
      type(scene_error_t), intent(inout) :: error
      associate (key => target%key, numbers => setting%values%number)
         if (key%kind == KEY_INTEGER .and. any(abs(numbers) > greatest_whole)) &
            call error%raise(setting%line, trim(key%name)//' is too large')
         if (.not. (error%raised .or. admits(key%range, numbers))) call check_setting(key, setting, error)
      end associate
   end subroutine check_numbers

end module nutate_member
