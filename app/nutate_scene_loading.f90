!> Reading of a scene for a command, with the sensitivities that its history shows.
module nutate_scene_loading
   use nutate_cli, only: command_t, did_you_mean, naming_options
   use nutate_console, only: page_t, say_error, vector_text, EXIT_INPUT, EXIT_SUCCESS
   use nutate_decimal, only: rounded_text
   use nutate_free_variations, only: free_variations, shows_derivatives, shows_propagated
   use nutate_kinds, only: wp
   use nutate_printable, only: printable_path
   use nutate_run, only: run_t
   use nutate_scene, only: read_scene, scene_t
   use nutate_scene_error, only: error_line, scene_error_t
   use nutate_scene_output, only: format_fault
   use nutate_status, only: status_t, NUTATE_IO
   use nutate_variation, only: variation_t
   implicit none
   private

   public :: add_space_axes, load_scene, read_scene_of, add_free_numbers, propagated_fault, &
             propagate_free_parameters

contains

   !> Adds the kind of the space axes and their name, or that of the inertial axes to which exports convert.
   subroutine add_space_axes(page, scene)
      type(page_t), intent(inout) :: page
      type(scene_t), intent(in) :: scene
      character(len=:), allocatable :: text, name
      name = ''
      if (scene%labels%space_frame /= '') name = ', '//scene%labels%space_frame
      associate (effects => scene%system%effects)
         if (.not. effects%frame_turns) then
            text = 'inertial'
            if (effects%on_orbit) text = 'inertial, x to the equinox, z north'
            text = text//name
         else if (effects%knows_space_axes()) then
            text = 'LVLH, which rotate at '//vector_text(effects%frame_rate)//' rad/s'
            if (name /= '') text = text//'; inertial axes'//name
         else
            text = 'rotating, at '//vector_text(effects%frame_rate)//' rad/s'//name
         end if
      end associate
      call page%item('space axes', text)
   end subroutine add_space_axes

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
         call say_error(message, exit_code, EXIT_INPUT)
         return
      end if
      if (.not. allocated(command%output)) return
      scene%output%file = command%output
      if (format_fault(command%output) == '') return
      call say_error('nutate: --output '//printable_path(command%output)//' '//format_fault(command%output)// &
                     ' (expected a name such as '//scene%name//'.csv)', exit_code, EXIT_INPUT)
   end subroutine load_scene

   !> Gives a run the sensitivities that its history shows, if any. Reports a parameter without derivative in one line.
   subroutine propagate_free_parameters(scene, run, exit_code)
      type(scene_t), intent(in) :: scene
      !> Run that has begun.
      type(run_t), intent(inout) :: run
      !> Exit code, changed if something has no derivative.
      integer, intent(inout) :: exit_code
      type(variation_t), allocatable :: columns(:)
      type(scene_error_t) :: error
      type(status_t) :: status
      if (.not. shows_derivatives(scene%output%columns)) return
      call free_variations(scene, columns, error, run%summary%settings)
      if (.not. error%raised) then
         call run%differentiate(columns, scene%system, status)
         if (.not. status%ok()) call error%raise_status(scene%fit%free(1)%line, status)
      end if
      if (.not. error%raised) return
      call say_error(naming_options(error_line(scene%file, error)), exit_code, EXIT_INPUT)
   end subroutine propagate_free_parameters

   !> Returns the error message, in a line, if only `nutate run` can write the columns of a scene; else an empty string.
   function propagated_fault(scene) result(message)
      type(scene_t), intent(in) :: scene
      character(len=:), allocatable :: message
      type(scene_error_t) :: error
      integer :: i
      message = ''
      if (.not. shows_propagated(scene%output%columns)) return
      i = findloc(scene%groups%name == 'output', .true., dim=1)
      call error%raise(scene%groups(i)%line_of('columns'), 'only nutate run writes sensitivities, covariances and '// &
                       'indicators of chaos', expected='other columns')
      message = naming_options(error_line(scene%file, error))
   end function propagated_fault

   !> Adds the parameters in `&free` of a scene to a page.
   subroutine add_free_numbers(page, scene)
      type(page_t), intent(inout) :: page
      type(scene_t), intent(in) :: scene
      character(len=:), allocatable :: text
      integer :: i
      call page%line('free')
      do i = 1, size(scene%fit%free)
         associate (free => scene%fit%free(i), numbers => scene%fit%numbers)
            text = '0'
            if (free%target > 0) then
               associate (target => numbers%targets(free%target))
                  text = rounded_text(numbers%groups(target%group)%settings(target%setting)%values(target%value)%number)
               end associate
            end if
            if (free%sigma > 0.0_wp) text = text//', sigma = '//rounded_text(free%sigma)
            call page%item(trim(free%name), text)
         end associate
      end do
      if (.not. (shows_derivatives(scene%output%columns) .or. scene%fit%active())) &
         call page%item('derivatives', 'none: no column shows them')
   end subroutine add_free_numbers

end module nutate_scene_loading
