!> Reads the scene that a command names, with the overrides of its command line.
module nutate_scene_loading
   use nutate_cli, only: command_t
   use nutate_console, only: say_error, EXIT_INPUT, EXIT_SUCCESS
   use nutate_printable, only: printable_path
   use nutate_scene, only: scene_t, read_scene
   use nutate_scene_output, only: format_fault
   use nutate_status, only: status_t
   implicit none
   private

   public :: load_scene

contains

   !> Reads the scene; what is wrong with it is said in one line.
   subroutine load_scene(command, scene, exit_code)
      type(command_t), intent(in) :: command
      type(scene_t), intent(out) :: scene
      integer, intent(out) :: exit_code
      type(status_t) :: status
      character(len=:), allocatable :: message

      exit_code = EXIT_SUCCESS
      call read_scene(command%scene, scene, status, message, command%overrides)
      if (.not. status%ok()) then
         call say_error(message)
         exit_code = EXIT_INPUT
         return
      end if
      if (.not. allocated(command%output)) return
      scene%output%file = command%output
      if (format_fault(command%output) == '') return
      call say_error('nutate: --output '//printable_path(command%output)//' '//format_fault(command%output)// &
                     ' (expected a name such as '//scene%name//'.csv)')
      exit_code = EXIT_INPUT
   end subroutine load_scene

end module nutate_scene_loading
