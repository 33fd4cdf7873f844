!> `nutate linearize SCENE`: matrices, eigenvalues and Floquet multipliers of small deviations from the motion of a
!> scene, or all its equilibria.
module nutate_linearize_command
   use nutate_axes_words, only: add_space_axes
   use nutate_cli, only: command_t
   use nutate_console, only: page_t, say_error, show_page, EXIT_INPUT, EXIT_RUN, EXIT_SUCCESS
   use nutate_discarding, only: discard_file
   use nutate_equilibria, only: equilibria_t
   use nutate_files, only: output_file_t, STANDARD_ERROR, STANDARD_OUTPUT
   use nutate_linearization, only: linearization_t
   use nutate_linearization_json, only: json_of, json_of_equilibria
   use nutate_linearize_report, only: add_equilibria, add_linearization
   use nutate_outputs, only: outputs_t, LINEARIZATION
   use nutate_picture_opening, only: report_file
   use nutate_printable, only: printable_path
   use nutate_scene, only: scene_t
   use nutate_scene_linearization, only: linearize_scene, scene_equilibria
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
      type(equilibria_t) :: found
      type(page_t) :: page
      type(status_t) :: status
      logical :: to_output

      call load_scene(command, scene, exit_code)
      if (exit_code == EXIT_SUCCESS) call check_names(command, scene, exit_code)
      if (exit_code /= EXIT_SUCCESS) return
      scene%plan%max_steps = command%max_steps
      if (command%equilibria) then
         call scene_equilibria(scene, found, status)
      else
         call linearize_scene(scene, command%period, linear, status)
         if (status%ok() .and. command%relative_rates) call linear%use_relative_rates(status)
      end if
      if (.not. status%ok()) then
         call say_error('nutate: '//printable_path(scene%file)//': '//trim(status%message))
         exit_code = merge(EXIT_INPUT, EXIT_RUN, status%code == NUTATE_BAD_ARGUMENT)
         return
      end if
      to_output = .false.
      if (allocated(command%json)) to_output = command%json == '-'
      call page%line(printable_path(scene%file)//': '//scene%title)
      call add_space_axes(page, scene)
      if (command%equilibria) then
         call add_equilibria(page, found)
      else
         call add_linearization(page, linear)
      end if
      if (.not. command%quiet) call show_page(page, merge(STANDARD_ERROR, STANDARD_OUTPUT, to_output), exit_code)
      if (.not. allocated(command%json)) return
      if (command%equilibria) call write_json(json_of_equilibria(found), command%json, exit_code)
      if (.not. command%equilibria) call write_json(json_of(linear), command%json, exit_code)
   end subroutine linearize_command

   !> Rejects file names that would overwrite an input, a file of another kind or each other.
   subroutine check_names(command, scene, exit_code)
      type(command_t), intent(in) :: command
      type(scene_t), intent(in) :: scene
      integer, intent(inout) :: exit_code
      type(outputs_t) :: files
      call files%read_scene(scene)
      if (allocated(command%json)) call files%add(command%json, LINEARIZATION)
      call files%report(exit_code)
   end subroutine check_names

   !> Writes JSON.
   subroutine write_json(text, name, exit_code)
      character(len=*), intent(in) :: text
      !> Path, or `-` for standard output.
      character(len=*), intent(in) :: name
      integer, intent(inout) :: exit_code
      type(output_file_t) :: file
      type(status_t) :: status
      call file%open(name, status)
      if (status%ok()) call file%put_line(text, status)
      if (status%ok()) then
         call file%finish(status)
      else
         call discard_file(file)
      end if
      call report_file(name, status, exit_code)
   end subroutine write_json

end module nutate_linearize_command
