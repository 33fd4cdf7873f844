!> Derivatives in the history with respect to the parameters of a scene: `&free`.
module nutate_free_setup
   use nutate_variation, only: variation_t
   use nutate_console, only: page_t, say_error, EXIT_INPUT
   use nutate_decimal, only: rounded_text
   use nutate_free_variations, only: free_variations, shows_propagated, shows_derivatives
   use nutate_kinds, only: wp
   use nutate_run, only: run_t
   use nutate_scene, only: scene_t
   use nutate_scene_error, only: error_line, scene_error_t
   use nutate_scene_loading, only: naming_options
   use nutate_status, only: status_t
   implicit none
   private

   public :: add_free_numbers, propagated_fault, propagate_free_parameters

contains

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
      call say_error(naming_options(error_line(scene%file, error)))
      exit_code = EXIT_INPUT
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

end module nutate_free_setup
