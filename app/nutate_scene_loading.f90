!> Reads the scene that a command names, with the overrides of its command line.
module nutate_scene_loading
   use nutate_cli, only: command_t
   use nutate_console, only: say_error, EXIT_INPUT, EXIT_SUCCESS
   use nutate_file_hint, only: did_you_mean
   use nutate_printable, only: printable_path
   use nutate_scene, only: scene_t, read_scene
   use nutate_scene_error, only: PLACE_OF_SET, PLACE_OF_UNSET
   use nutate_scene_output, only: format_fault
   use nutate_status, only: status_t, NUTATE_IO
   implicit none
   private

   public :: load_scene, naming_options, read_scene_of

contains

   !> Reads the scene of a command with its overrides, and does nothing else. Errors: those of `read_scene`.
   subroutine read_scene_of(command, scene, status, message)
      type(command_t), intent(in) :: command
      type(scene_t), intent(out) :: scene
      type(status_t), intent(out) :: status
      !> Error message, one printable line that names the options of the command line; empty on success.
      character(len=:), allocatable, intent(out) :: message
      call read_scene(command%scene, scene, status, message, command%overrides)
      if (status%code == NUTATE_IO .and. did_you_mean(command%scene, '.nml') /= '') &
         message = message(:len(message) - 1)//'; '//did_you_mean(command%scene, '.nml')//')'
      message = naming_options(message)
   end subroutine read_scene_of

   !> Returns a message about an override with the option of the command line; returns other messages unchanged.
   pure function naming_options(message) result(text)
      character(len=*), intent(in) :: message
      character(len=:), allocatable :: text
      text = message
      if (index(message, PLACE_OF_SET) == 1) text = '--set: '//message(len(PLACE_OF_SET) + 1:)
      if (index(message, PLACE_OF_UNSET) == 1) text = '--unset: '//message(len(PLACE_OF_UNSET) + 1:)
   end function naming_options

   !> Reads the scene; reports an error in one line.
   subroutine load_scene(command, scene, exit_code)
      type(command_t), intent(in) :: command
      type(scene_t), intent(out) :: scene
      integer, intent(out) :: exit_code
      type(status_t) :: status
      character(len=:), allocatable :: message

      exit_code = EXIT_SUCCESS
      call read_scene_of(command, scene, status, message)
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
