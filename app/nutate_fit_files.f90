!> The files that a fit writes: residuals as CSV, and the fitted scene.
module nutate_fit_files
   use nutate_decimal, only: exact_text
   use nutate_discarding, only: discard_file
   use nutate_files, only: output_file_t
   use nutate_fit, only: fit_t
   use nutate_fit_plan, only: ATTITUDES
   use nutate_kinds, only: wp
   use nutate_printable, only: printable_path
   use nutate_scene, only: scene_t
   use nutate_scene_text, only: scene_text
   use nutate_status, only: status_t
   implicit none
   private

   public :: write_residuals, write_fitted_scene

contains

   !> Writes one line for each residual. Errors: `NUTATE_IO`.
   subroutine write_residuals(fit, name, status)
      type(fit_t), intent(in) :: fit
      !> Path, or `-` for standard output.
      character(len=*), intent(in) :: name
      type(status_t), intent(out) :: status
      type(output_file_t) :: file
      integer :: i, k, at
      call file%open(name, status)
      if (status%ok()) call file%put_line('measurement,t,column,measured,model,residual', status)
      at = 0
      do i = 1, size(fit%problem%residuals)
         do k = 1, size(fit%problem%residuals(i)%measurement%times)
            if (status%ok()) call put_row(fit, i, k, at, file, status)
            at = at + fit%problem%residuals(i)%measurement%width()
         end do
      end do
      if (status%ok()) then
         call file%finish(status)
      else
         call discard_file(file)
      end if
   end subroutine write_residuals

   !> Writes the residuals of a row.
   subroutine put_row(fit, i, k, before, file, status)
      type(fit_t), intent(in) :: fit
      !> Index of the measurement, and its row.
      integer, intent(in) :: i, k
      !> Number of residuals before those of the row.
      integer, intent(in) :: before
      type(output_file_t), intent(inout) :: file
      type(status_t), intent(inout) :: status
      real(wp), allocatable :: measured(:), model(:)
      character(len=:), allocatable :: line
      character(len=12) :: number
      integer :: c
      associate (measurement => fit%problem%residuals(i)%measurement)
         associate (residuals => fit%result%residuals(before + 1:before + measurement%width()))
            if (measurement%kind == ATTITUDES) then
               ! The model value is the rotation vector from the measured attitude to that of the model.
               measured = spread(0.0_wp, 1, 3)
            else
               measured = measurement%rows(:, k)
            end if
            model = measured + measurement%sigma*residuals
            write (number, '(i0)') i
            do c = 1, size(model)
               line = trim(number)//','//exact_text(measurement%times(k))//','
               if (measurement%kind == ATTITUDES) then
                  line = line//'rotation'//achar(iachar('0') + c)
               else
                  line = line//trim(measurement%columns(c))
               end if
               call file%put_line(line//','//exact_text(measured(c))//','//exact_text(model(c))//','// &
                                  exact_text(residuals(c)), status)
               if (.not. status%ok()) return
            end do
         end associate
      end associate
   end subroutine put_row

   !> Writes the scene with the fitted parameters. Errors: `NUTATE_IO`.
   subroutine write_fitted_scene(fit, scene, name, status)
      type(fit_t), intent(in) :: fit
      !> The scene that was fitted.
      type(scene_t), intent(in) :: scene
      character(len=*), intent(in) :: name
      type(status_t), intent(out) :: status
      type(output_file_t) :: file
      call file%open(name, status)
      if (status%ok()) call file%put_line('! nutate fit of '//printable_path(scene%file), status)
      if (status%ok()) call file%put_line(scene_text(fit%problem%model%present_groups(), scene%file, name), status)
      if (status%ok()) then
         call file%finish(status)
      else
         call discard_file(file)
      end if
   end subroutine write_fitted_scene

end module nutate_fit_files
