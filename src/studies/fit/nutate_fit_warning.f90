!> Warning of a fit whose residuals the noise of the data does not explain.
module nutate_fit_warning
   use nutate_decimal, only: rounded_text
   use nutate_fit, only: fit_t
   use nutate_kinds, only: wp
   use nutate_printable, only: printable_path
   implicit none
   private

   public :: misfit_text

   !> Number of rows that the warning names.
   integer, parameter :: named = 3

   !> A row of a measurement with its largest residual.
   type :: row_t
      integer :: measurement = 0, row = 0
      real(wp) :: size = 0.0_wp
   end type row_t

contains

   !> Returns the warning, with the worst rows; empty if noise explains the residuals.
   function misfit_text(fit) result(text)
      type(fit_t), intent(in) :: fit
      character(len=:), allocatable :: text
      type(row_t) :: worst(named)
      integer :: i
      text = ''
      if (.not. fit%exceeds_noise()) return
      text = 'chi-squared per degree of freedom is '// &
             rounded_text(fit%result%chi_squared/fit%result%degrees_of_freedom, 3)// &
             ', which noise of the given sigma exceeds in less than 1 of 10000 cases: the model, sigma or some '// &
             'rows are wrong, and the standard errors are too small; largest residuals:'
      worst = worst_rows(fit)
      do i = 1, named
         if (worst(i)%measurement == 0) exit
         associate (measurement => fit%problem%residuals(worst(i)%measurement)%measurement)
            if (i > 1) text = text//','
            text = text//' '//rounded_text(worst(i)%size, 3)//' sigma at t = '// &
                   rounded_text(measurement%times(worst(i)%row), 6)//' s of '//printable_path(measurement%file)
         end associate
      end do
   end function misfit_text

   !> Returns the rows with the largest residuals, the largest first.
   function worst_rows(fit) result(worst)
      type(fit_t), intent(in) :: fit
      type(row_t) :: worst(named)
      type(row_t) :: row
      integer :: i, k, place, at, width
      at = 0
      do i = 1, size(fit%problem%residuals)
         width = fit%problem%residuals(i)%measurement%width()
         do k = 1, size(fit%problem%residuals(i)%measurement%times)
            row = row_t(i, k, maxval(abs(fit%result%residuals(at + 1:at + width))))
            at = at + width
            place = 1 + count(worst%size >= row%size)
            if (place > named) cycle
            worst(place + 1:) = worst(place:named - 1)
            worst(place) = row
         end do
      end do
   end function worst_rows

end module nutate_fit_warning
