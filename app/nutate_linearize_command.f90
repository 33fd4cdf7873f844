!> `nutate linearize SCENE`: matrices, eigenvalues and Floquet multipliers of small motions beside that of a scene.
module nutate_linearize_command
   use nutate_cli, only: command_t
   use nutate_console, only: page_t, say_error, show_page, EXIT_INPUT, EXIT_RUN, EXIT_SUCCESS
   use nutate_discarding, only: discard_file
   use nutate_files, only: output_file_t, STANDARD_ERROR, STANDARD_OUTPUT
   use nutate_linearization, only: linearization_t
   use nutate_linearization_json, only: json_of
   use nutate_linearize_report, only: add_linearization
   use nutate_outputs, only: outputs_t, LINEARIZATION
   use nutate_picture_opening, only: report_file
   use nutate_printable, only: printable_path
   use nutate_scene, only: scene_t
   use nutate_scene_linearization, only: linearize_scene
   use nutate_scene_loading, only: load_scene
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: linearize_command

contains

   !> Linearises the motion of a scene, shows the result, and writes it.
   subroutine linearize_command(command, exit_code)
      type(command_t), intent(in) :: command
      integer, intent(out) :: exit_code
      type(scene_t) :: scene
      type(linearization_t) :: linear
      type(page_t) :: page
      type(status_t) :: status
      logical :: to_output

      call load_scene(command, scene, exit_code)
      if (exit_code == EXIT_SUCCESS) call check_names(command, scene, exit_code)
      if (exit_code /= EXIT_SUCCESS) return
      scene%plan%max_steps = command%max_steps
      call linearize_scene(scene, command%period, linear, status)
      if (.not. status%ok()) then
         call say_error('nutate: '//printable_path(scene%file)//': '//trim(status%message))
         exit_code = merge(EXIT_INPUT, EXIT_RUN, status%code == NUTATE_BAD_ARGUMENT)
         return
      end if
      to_output = .false.
      if (allocated(command%json)) to_output = command%json == '-'
      call page%line(printable_path(scene%file)//': '//scene%title)
      call add_linearization(page, linear)
      if (.not. command%quiet) call show_page(page, merge(STANDARD_ERROR, STANDARD_OUTPUT, to_output), exit_code)
      if (allocated(command%json)) call write_json(linear, command%json, exit_code)
   end subroutine linearize_command

   !> Refuses a name by which the command would destroy what is there.
   subroutine check_names(command, scene, exit_code)
      type(command_t), intent(in) :: command
      type(scene_t), intent(in) :: scene
      integer, intent(inout) :: exit_code
      type(outputs_t) :: files
      call files%read_scene(scene)
      if (allocated(command%json)) call files%add(command%json, LINEARIZATION)
      call files%report(exit_code)
   end subroutine check_names

   !> Writes the linearisation as JSON.
   subroutine write_json(linear, name, exit_code)
      type(linearization_t), intent(in) :: linear
      !> Path, or `-` for standard output.
      character(len=*), intent(in) :: name
      integer, intent(inout) :: exit_code
      type(output_file_t) :: file
      type(status_t) :: status
      call file%open(name, status)
      if (status%ok()) call file%put_line(json_of(linear), status)
      if (status%ok()) then
         call file%finish(status)
      else
         call discard_file(file)
      end if
      call report_file(name, status, exit_code)
   end subroutine write_json

end module nutate_linearize_command
