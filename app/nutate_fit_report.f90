!> Report of a fit, for people.
module nutate_fit_report
   use nutate_scene_loading, only: add_space_axes
   use nutate_attitude, only: rotation_vector_from_quat
   use nutate_console, only: count_text, page_t, plural, vector_text
   use nutate_decimal, only: rounded_text
   use nutate_fit, only: fit_t
   use nutate_kinds, only: wp, long
   use nutate_least_squares, only: UNKNOWN_BELOW, WEAK_BELOW
   use nutate_quaternion, only: quat_conjugate, quat_product
   use nutate_table, only: table_t
   implicit none
   private

   public :: add_fit, value_with_error

   !> Least correlation that is reported; share of a direction below which it is left out.
   real(wp), parameter :: strong = 0.95_wp, negligible = 1e-3_wp

contains

   !> Adds values with standard errors, the quality of the fit, and what the data do not determine.
   subroutine add_fit(page, fit)
      type(page_t), intent(inout) :: page
      type(fit_t), intent(in) :: fit
      type(table_t) :: table
      call add_space_axes(page, fit%problem%model%scene)
      associate (result => fit%result)
         call page%item('data', plural(int(fit%problem%measured_in_arc(), long), 'residual')//' in '// &
                        plural(size(fit%problem%residuals, kind=long), 'measurement')//', '// &
                        plural(size(fit%problem%names, kind=long), 'parameter'))
         call page%item('fit', plural(int(result%iterations, long), 'iteration')//' from start '// &
                        count_text(fit%best)//' of '//count_text(fit%starts))
         call page%item('chi-squared', chi_text())
         call add_values()
         call page%line('')
         call page%line(table%text())
         call page%line('')
         if (fit%problem%model%plan%has_attitude) call page%item('attitude', 'quaternion '// &
                                                                vector_text(fit%problem%model%plan%attitude, 9))
         if (fit%problem%model%scene%system%body%breaks_triangle) &
            call page%item('body', 'a moment exceeds the sum of the other two: no rigid body has these')
         call add_correlations()
         call add_directions()
      end associate

   contains

      !> Returns χ², and what it implies for the standard deviations.
      function chi_text() result(text)
         character(len=:), allocatable :: text
         associate (result => fit%result)
            text = rounded_text(result%chi_squared, 8)//' for '// &
                   plural(int(result%degrees_of_freedom, long), 'degree')//' of freedom'
            if (result%degrees_of_freedom < 1) return
            if (fit%sigma_is_known) then
               text = text//': '//rounded_text(result%chi_squared/result%degrees_of_freedom, 3)//' per degree'
            else
               text = text//': sigma '//rounded_text(sqrt(result%chi_squared/result%degrees_of_freedom), 3)// &
                  ' from the residuals'
            end if
         end associate
      end function chi_text

      !> Adds a row for each parameter. The attitude is shown as the rotation vector from the attitude of the scene.
      subroutine add_values()
         real(wp) :: errors(size(fit%problem%names)), values(size(fit%problem%names)), turn(3)
         integer :: i
         associate (problem => fit%problem, result => fit%result, plan => fit%problem%model%plan)
            errors = result%standard_errors()
            values = result%x
            turn = rotation_vector_from_quat(quat_product(quat_conjugate(problem%known_attitude), &
               plan%attitude))/plan%angle_unit
            do i = 1, problem%n_free
               if (plan%free(i)%component > 0) values(i) = turn(plan%free(i)%component)
            end do
            table%indent = 2
            call table%add_column('parameter')
            call table%add_column('value')
            call table%add_column('')
            do i = 1, size(values)
               call table%add_row()
               call table%put(problem%names(i))
               if (result%at_bound(i)) then
                  call table%put(rounded_text(values(i)))
                  call table%put('at its bound')
               else if (result%unidentified(i)) then
                  call table%put(rounded_text(values(i)))
                  call table%put('not identifiable')
               else
                  call table%put(value_with_error(values(i), errors(i)))
               end if
            end do
         end associate
      end subroutine add_values

      !> Adds pairs of parameters with a strong correlation.
      subroutine add_correlations()
         real(wp) :: errors(size(fit%problem%names)), correlation
         character(len=:), allocatable :: label
         integer :: i, k
         errors = fit%result%standard_errors()
         label = 'correlation'
         do i = 1, size(errors)
            do k = i + 1, size(errors)
               if (.not. (errors(i) > 0.0_wp .and. errors(k) > 0.0_wp)) cycle
               correlation = fit%result%covariance(i, k)/(errors(i)*errors(k))
               if (abs(correlation) <= strong) cycle
               call page%item(label, trim(fit%problem%names(i))//', '//trim(fit%problem%names(k))//': '// &
                              rounded_text(correlation, 4))
               label = ''
            end do
         end do
      end subroutine add_correlations

      !> Adds the directions that the data do not determine, or only weakly.
      subroutine add_directions()
         integer :: i
         do i = size(fit%result%singular_values), 1, -1
            if (fit%result%singular_values(i) <= UNKNOWN_BELOW) then
               call page%item('not identifiable', direction_text(i))
            else if (fit%result%singular_values(i) <= WEAK_BELOW) then
               call page%item('weak', direction_text(i))
            end if
         end do
      end subroutine add_directions

      !> Returns a direction as changes of its parameters: relative to their values, or absolute if a value is zero
      !> within the error that it would have if all others were known.
      function direction_text(i) result(text)
         integer, intent(in) :: i
         character(len=:), allocatable :: text
         real(wp) :: change(size(fit%problem%names)), sigma
         integer :: k
         associate (result => fit%result)
            change = result%directions(:, i)
            sigma = 1.0_wp
            if (.not. fit%sigma_is_known) sigma = sqrt(result%chi_squared/max(1, result%degrees_of_freedom))
            do k = 1, size(change)
               if (abs(result%x(k))*norm2(result%jacobian(:, k)) > sigma) change(k) = change(k)/result%x(k)
            end do
         end associate
         change = change/change(maxloc(abs(change), dim=1))
         text = ''
         do k = 1, size(change)
            if (abs(change(k)) < negligible) cycle
            if (text /= '') text = text//', '
            text = text//trim(fit%problem%names(k))//' '//rounded_text(change(k), 3)
         end do
         text = text//' (changes together, relative to the values)'
      end function direction_text

   end subroutine add_fit

   !> Returns a number and its standard error, both to two digits of the error: `2.978 ± 0.214` has three.
   pure function value_with_error(value, error) result(text)
      real(wp), intent(in) :: value
      !> Standard error, above 0.
      real(wp), intent(in) :: error
      character(len=:), allocatable :: text
      integer :: exponent, decimals
      exponent = floor(log10(max(abs(value), error)))
      decimals = max(0, exponent + 1 - floor(log10(error)))
      if (exponent >= -3 .and. exponent < 6) then
         decimals = max(0, decimals - exponent)
         text = fixed(value, decimals)//' ± '//fixed(error, decimals)
      else
         text = '('//fixed(value*10.0_wp**(-exponent), decimals)//' ± '//fixed(error*10.0_wp**(-exponent), decimals)// &
                ')E'//count_text(exponent)
      end if
   end function value_with_error

   !> Returns a number with so many decimals.
   pure function fixed(number, decimals) result(text)
      real(wp), intent(in) :: number
      integer, intent(in) :: decimals
      character(len=:), allocatable :: text
      character(len=48) :: digits
      character(len=12) :: form
      write (form, '("(f48.",i0,")")') min(decimals, 17)
      write (digits, form) number
      text = trim(adjustl(digits))
      if (decimals == 0) text = text(:len(text) - 1)
      ! Zero has no sign.
      if (verify(text, '-0.') == 0) text = text(verify(text, '-'):)
   end function fixed

end module nutate_fit_report
