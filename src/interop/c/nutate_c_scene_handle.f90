!> Type behind the handles of scenes in the C interface.
module nutate_c_scene_handle
   use, intrinsic :: iso_c_binding, only: c_f_pointer, c_int, c_ptr
   use nutate_c_handles, only: conclude, found, handle_t, has_mark, is_taken, null_argument, open_slot, report, &
      SCENE_MARK
   use nutate_c_polls, only: poll_t
   use nutate_fit_problem, only: fit_problem_t
   use nutate_scene, only: scene_t
   implicit none
   private

   public :: scene_handle_t
   !> Procedures that all functions with a scene need.
   public :: conclude, found, is_taken, null_argument, open_slot, report, SCENE_MARK

   type, extends(handle_t) :: scene_handle_t
      type(scene_t) :: scene
      !> The poll callback of its runs.
      type(poll_t) :: poll
      !> Residuals of the fit of the scene; allocated when they are first requested.
      type(fit_problem_t), allocatable :: fit
   end type scene_handle_t

   interface found
      module procedure found_scene
   end interface found

contains

   logical function found_scene(address, handle, code) result(is_found)
      type(c_ptr), intent(in) :: address
      type(scene_handle_t), pointer, intent(inout) :: handle
      integer(c_int), intent(out), optional :: code
      is_found = has_mark(address, [SCENE_MARK], code)
      if (is_found) call c_f_pointer(address, handle)
   end function found_scene

end module nutate_c_scene_handle
