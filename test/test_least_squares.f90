!> Nonlinear least squares: NIST's Statistical Reference Datasets with their certified values, and problems that are not
!> well posed.
submodule(suites_of_methods) test_least_squares
   use nutate_kinds, only: wp
   use nutate_least_squares, only: least_squares_problem_t, least_squares_result_t, least_squares_settings_t, &
      minimize, &
      UNKNOWN_BELOW
   use nutate_robust_loss, only: loss_of, CAUCHY, HUBER, LINEAR, SOFT_L1
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT, NUTATE_NOT_CONVERGED
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   !> A curve y(x) with parameters b, and data.
   type, extends(least_squares_problem_t) :: curve_t
      integer :: model = 0
      real(wp), allocatable :: t(:), y(:)
   contains
      procedure :: evaluate
   end type curve_t

   integer, parameter :: BOX_BOD = 1, MISRA_1A = 2, MGH_09 = 3, RAT_42 = 4, DAN_WOOD = 5, MGH_10 = 6, LINE = 7, &
                         PRODUCT = 8, VALLEY = 9

contains

   module procedure collect_least_squares
      testsuite = [ &
                  new_unittest("certified_values_of_NIST_are_met", test_nist), &
                  new_unittest("a_product_of_parameters_is_known_but_not_its_factors", test_product), &
                  new_unittest("a_bound_holds_a_parameter_and_the_others_fit", test_bounds), &
                  new_unittest("a_bound_that_is_not_needed_changes_nothing", test_loose_bounds), &
                  new_unittest("robust_losses_resist_outliers", test_robust), &
                  new_unittest("losses_are_those_of_SciPy", test_losses), &
                  new_unittest("a_fit_that_stalls_ends", test_stall), &
                  new_unittest("fewer_residuals_than_parameters_are_rejected", test_too_few)]
   end procedure collect_least_squares

   subroutine evaluate(self, x, residuals, jacobian, status)
      class(curve_t), intent(inout) :: self
      real(wp), intent(in) :: x(:)
      real(wp), allocatable, intent(inout) :: residuals(:), jacobian(:, :)
      type(status_t), intent(out) :: status
      real(wp) :: y(size(self%t)), d(size(self%t), size(x)), e(size(self%t)), below(size(self%t))
      associate (t => self%t)
         select case (self%model)
         case (BOX_BOD, MISRA_1A)
            e = exp(-x(2)*t)
            y = x(1)*(1 - e)
            d(:, 1) = 1 - e
            d(:, 2) = x(1)*t*e
         case (MGH_09)
            below = t**2 + t*x(3) + x(4)
            e = t**2 + t*x(2)
            y = x(1)*e/below
            d(:, 1) = e/below
            d(:, 2) = x(1)*t/below
            d(:, 3) = -y*t/below
            d(:, 4) = -y/below
         case (RAT_42)
            e = exp(x(2) - x(3)*t)
            y = x(1)/(1 + e)
            d(:, 1) = 1/(1 + e)
            d(:, 2) = -y*e/(1 + e)
            d(:, 3) = y*e*t/(1 + e)
         case (DAN_WOOD)
            y = x(1)*t**x(2)
            d(:, 1) = t**x(2)
            d(:, 2) = y*log(t)
         case (MGH_10)
            d(:, 1) = exp(x(2)/(t + x(3)))
            y = x(1)*d(:, 1)
            d(:, 2) = y/(t + x(3))
            d(:, 3) = -y*x(2)/(t + x(3))**2
         case (VALLEY)
            y = [1e5_wp*(x(2) - sin(50*x(1))), x(1)]
            d = reshape([-5e6_wp*cos(50*x(1)), 1.0_wp, 1e5_wp, 0.0_wp], [2, 2])
         case (LINE)
            y = x(1) + x(2)*t
            d(:, 1) = 1.0_wp
            d(:, 2) = t
         case default
            y = x(1)*x(2)*t + x(3)
            d(:, 1) = x(2)*t
            d(:, 2) = x(1)*t
            d(:, 3) = 1.0_wp
         end select
      end associate
      residuals = y - self%y
      jacobian = d
      status = status_t()
   end subroutine evaluate

   !> Fits a problem of NIST and compares parameters, standard errors and sum of squares with the certified values.
   subroutine compare(error, label, model, t, y, start, values, deviations, sum_of_squares)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: label
      integer, intent(in) :: model
      real(wp), intent(in) :: t(:), y(:), start(:), values(:), deviations(:), sum_of_squares
      type(curve_t) :: curve
      type(least_squares_result_t) :: result
      type(status_t) :: status
      curve%model = model
      curve%t = t
      curve%y = y
      call minimize(curve, start, result, status, least_squares_settings_t(sigma_is_known=.false., &
         most_iterations=2000))
      call check(error, status%ok() .and. result%converged, label//': '//trim(status%message))
      if (allocated(error)) return
      ! The iteration ends at 1e-8 of a standard error, and the certified values have eleven digits.
      call check_below(error, maxval(abs(result%x - values)/(deviations + 1e-3_wp*values)), 5e-8_wp, label// &
         ', parameters')
      call check_close(error, result%standard_errors()/deviations, spread(1.0_wp, 1, size(values)), 1e-7_wp, &
                       label//', errors')
      call check_close(error, result%chi_squared/sum_of_squares, 1.0_wp, 1e-10_wp, label//', squares')
   end subroutine compare

   subroutine test_nist(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: i
      real(wp), parameter :: misra_x(14) = [77.6_wp, 114.9_wp, 141.1_wp, 190.8_wp, 239.9_wp, 289.0_wp, 332.8_wp, &
         378.4_wp, 434.8_wp, 477.3_wp, 536.8_wp, 593.1_wp, 689.1_wp, 760.0_wp]
      real(wp), parameter :: misra_y(14) = [10.07_wp, 14.73_wp, 17.94_wp, 23.93_wp, 29.61_wp, 35.18_wp, 40.02_wp, &
         44.82_wp, 50.76_wp, 55.05_wp, 61.01_wp, 66.40_wp, 75.47_wp, 81.78_wp]
      real(wp), parameter :: mgh09_x(11) = [4.0_wp, 2.0_wp, 1.0_wp, 0.5_wp, 0.25_wp, 0.167_wp, 0.125_wp, 0.1_wp, &
         0.0833_wp, 0.0714_wp, 0.0625_wp]
      real(wp), parameter :: mgh09_y(11) = [0.1957_wp, 0.1947_wp, 0.1735_wp, 0.16_wp, 0.0844_wp, 0.0627_wp, 0.0456_wp, &
         0.0342_wp, 0.0323_wp, 0.0235_wp, 0.0246_wp]
      real(wp), parameter :: rat_x(9) = [9.0_wp, 14.0_wp, 21.0_wp, 28.0_wp, 42.0_wp, 57.0_wp, 63.0_wp, 70.0_wp, 79.0_wp]
      real(wp), parameter :: rat_y(9) = [8.93_wp, 10.8_wp, 18.59_wp, 22.33_wp, 39.35_wp, 56.11_wp, 61.73_wp, 64.62_wp, &
         67.08_wp]
      real(wp), parameter :: mgh10_y(16) = [34780.0_wp, 28610.0_wp, 23650.0_wp, 19630.0_wp, 16370.0_wp, 13720.0_wp, &
         11540.0_wp, 9744.0_wp, 8261.0_wp, 7030.0_wp, 6005.0_wp, 5147.0_wp, 4427.0_wp, 3820.0_wp, 3307.0_wp, 2872.0_wp]
      call compare(error, 'BoxBOD', BOX_BOD, [1.0_wp, 2.0_wp, 3.0_wp, 5.0_wp, 7.0_wp, 10.0_wp], &
                   [109.0_wp, 149.0_wp, 149.0_wp, 191.0_wp, 213.0_wp, 224.0_wp], [100.0_wp, 0.75_wp], &
                   [2.1380940889e2_wp, 5.4723748542e-1_wp], [1.2354515176e1_wp, 1.0455993237e-1_wp], 1.1680088766e3_wp)
      call compare(error, 'Misra1a', MISRA_1A, misra_x, misra_y, [500.0_wp, 1e-4_wp], &
                   [2.3894212918e2_wp, 5.5015643181e-4_wp], [2.7070075241_wp, 7.2668688436e-6_wp], 1.2455138894e-1_wp)
      call compare(error, 'MGH09', MGH_09, mgh09_x, mgh09_y, [0.25_wp, 0.39_wp, 0.415_wp, 0.39_wp], &
                   [1.9280693458e-1_wp, 1.9128232873e-1_wp, 1.2305650693e-1_wp, 1.3606233068e-1_wp], &
                   [1.1435312227e-2_wp, 1.9633220911e-1_wp, 8.0842031232e-2_wp, 9.0025542308e-2_wp], 3.0750560385e-4_wp)
      call compare(error, 'Rat42', RAT_42, rat_x, rat_y, [100.0_wp, 1.0_wp, 0.1_wp], &
                   [7.2462237576e1_wp, 2.6180768402_wp, 6.7359200066e-2_wp], &
                   [1.7340283401_wp, 8.8295217536e-2_wp, 3.4465663377e-3_wp], 8.0565229338_wp)
      call compare(error, 'DanWood', DAN_WOOD, [1.309_wp, 1.471_wp, 1.49_wp, 1.565_wp, 1.611_wp, 1.68_wp], &
                   [2.138_wp, 3.421_wp, 3.597_wp, 4.34_wp, 4.882_wp, 5.66_wp], [1.0_wp, 5.0_wp], &
                   [7.6886226176e-1_wp, 3.8604055871_wp], [1.8281973860e-2_wp, 5.1726610913e-2_wp], 4.3173084083e-3_wp)
      call compare(error, 'MGH10', MGH_10, [(45.0_wp + 5*i, i=1, 16)], mgh10_y, [0.02_wp, 4000.0_wp, 250.0_wp], &
                   [5.6096364710e-3_wp, 6.1813463463e3_wp, 3.4522363462e2_wp], &
                   [1.5687892471e-4_wp, 2.3309021107e1_wp, 7.8486103508e-1_wp], 8.7945855171e1_wp)
   end subroutine test_nist

   !> y = abt + c, twenty lines with scatter.
   subroutine set_line(curve, model)
      type(curve_t), intent(inout) :: curve
      integer, intent(in) :: model
      integer :: i
      curve%model = model
      curve%t = [(0.5_wp*i, i=1, 20)]
      curve%y = 3 + 2*curve%t + [(0.1_wp*sin(37.0_wp*i), i=1, 20)]
   end subroutine set_line

   subroutine test_product(error)
      type(error_type), allocatable, intent(out) :: error
      type(curve_t) :: curve
      type(least_squares_result_t) :: result
      type(status_t) :: status
      call set_line(curve, PRODUCT)
      call minimize(curve, [4.0_wp, 1.0_wp, 0.0_wp], result, status)
      call check(error, status%ok() .and. result%converged, trim(status%message))
      if (allocated(error)) return
      call check(error, count(result%singular_values < UNKNOWN_BELOW), 1)
      call check(error, all(result%unidentified .eqv. [.true., .true., .false.]))
      ! a grows as b shrinks.
      associate (direction => result%directions(:, 3))
         call check_close(error, direction(1)/result%x(1), -direction(2)/result%x(2), 1e-12_wp*abs(direction(1)))
         call check_below(error, abs(direction(3)), 1e-12_wp*norm2(direction))
      end associate
      call check(error, result%degrees_of_freedom, 18)
      call check(error, result%covariance(3, 3) > 0.0_wp .and. all(abs(result%covariance(:2, :)) <= 0.0_wp))
   end subroutine test_product

   subroutine test_bounds(error)
      type(error_type), allocatable, intent(out) :: error
      type(curve_t) :: curve
      type(least_squares_result_t) :: result
      type(status_t) :: status
      call set_line(curve, LINE)
      curve%low = [-1e3_wp, -1e3_wp]
      curve%high = [1e3_wp, 1.5_wp]
      call minimize(curve, [0.0_wp, 0.0_wp], result, status)
      call check(error, status%ok() .and. result%converged, trim(status%message))
      if (allocated(error)) return
      call check(error, all(result%at_bound .eqv. [.false., .true.]))
      call check_close(error, result%x(2), 1.5_wp, 0.0_wp)
      ! The best constant with this slope.
      call check_close(error, result%x(1), sum(curve%y - 1.5_wp*curve%t)/20, 1e-12_wp)
      call check_close(error, result%covariance(1, 1), 0.05_wp, 1e-14_wp)
      call check_close(error, result%covariance(2, 2), 0.0_wp, 0.0_wp)
   end subroutine test_bounds

   subroutine test_loose_bounds(error)
      type(error_type), allocatable, intent(out) :: error
      type(curve_t) :: curve
      type(least_squares_result_t) :: free, bounded
      type(status_t) :: status
      call set_line(curve, LINE)
      call minimize(curve, [0.0_wp, 0.0_wp], free, status)
      curve%low = [-10.0_wp, 0.5_wp]
      curve%high = [4.0_wp, 10.0_wp]
      call minimize(curve, [0.0_wp, 0.0_wp], bounded, status)
      call check(error, status%ok() .and. .not. any(bounded%at_bound))
      if (allocated(error)) return
      call check_below(error, maxval(abs(bounded%x - free%x)/free%standard_errors()), 1e-7_wp)
      call check_close(error, bounded%standard_errors(), free%standard_errors(), 1e-14_wp)
   end subroutine test_loose_bounds

   subroutine test_robust(error)
      type(error_type), allocatable, intent(out) :: error
      type(curve_t) :: curve
      type(least_squares_result_t) :: plain, robust
      type(status_t) :: status
      integer :: loss, losses(3)
      losses = [HUBER, SOFT_L1, CAUCHY]
      call set_line(curve, LINE)
      curve%y([3, 11, 18]) = curve%y([3, 11, 18]) + [-40.0_wp, 25.0_wp, 60.0_wp]
      call minimize(curve, [0.0_wp, 0.0_wp], plain, status)
      call check(error, abs(plain%x(2) - 2) > 0.5_wp, 'the outliers spoil nothing')
      do loss = 1, 3
         curve%losses = spread(losses(loss), 1, 20)
         call minimize(curve, [0.0_wp, 0.0_wp], robust, status)
         call check(error, status%ok() .and. robust%converged, trim(status%message))
         if (allocated(error)) return
         call check_close(error, robust%x(2), 2.0_wp, 0.1_wp)
         call check_stationary(error, curve, robust, losses(loss))
      end do
   end subroutine test_robust

   !> The gradient of the sum of losses, Σ 2ρ'r ∂r, is zero.
   subroutine check_stationary(error, curve, result, loss)
      type(error_type), allocatable, intent(inout) :: error
      type(curve_t), intent(in) :: curve
      type(least_squares_result_t), intent(in) :: result
      integer, intent(in) :: loss
      real(wp) :: gradient(2), rho(3)
      integer :: i
      gradient = 0.0_wp
      do i = 1, size(curve%t)
         rho = loss_of(loss, result%residuals(i)**2)
         gradient = gradient + rho(2)*result%residuals(i)*[1.0_wp, curve%t(i)]
      end do
      call check_close(error, gradient, [0.0_wp, 0.0_wp], 1e-6_wp)
   end subroutine check_stationary

   subroutine test_losses(error)
      type(error_type), allocatable, intent(out) :: error
      ! scipy.optimize._lsq.least_squares, at z = 4.
      call check_close(error, loss_of(LINEAR, 4.0_wp), [4.0_wp, 1.0_wp, 0.0_wp], 0.0_wp)
      call check_close(error, loss_of(HUBER, 4.0_wp), [3.0_wp, 0.5_wp, -0.0625_wp], 1e-15_wp)
      call check_close(error, loss_of(HUBER, 0.25_wp), [0.25_wp, 1.0_wp, 0.0_wp], 0.0_wp)
      call check_close(error, loss_of(SOFT_L1, 4.0_wp), [2.4721359549995796_wp, 0.44721359549995793_wp, &
                                                         -0.044721359549995794_wp], 1e-15_wp)
      call check_close(error, loss_of(CAUCHY, 4.0_wp), [1.6094379124341003_wp, 0.2_wp, -0.04_wp], 1e-15_wp)
   end subroutine test_losses

   !> A valley that winds so narrowly that steps along it are short: the linearised problem predicts that the sum
   !> vanishes, and 20 iterations hardly reduce it.
   subroutine test_stall(error)
      type(error_type), allocatable, intent(out) :: error
      type(curve_t) :: curve
      type(least_squares_result_t) :: result
      type(status_t) :: status
      curve%model = VALLEY
      curve%t = [0.0_wp, 0.0_wp]
      curve%y = [0.0_wp, 3.0_wp]
      call minimize(curve, [0.0_wp, 0.0_wp], result, status)
      call check(error, status%code, NUTATE_NOT_CONVERGED)
      call check(error, index(status%message, 'stalls') > 0, trim(status%message))
      call check(error, result%iterations, 20)
      call check_below(error, result%chi_squared, 9.0_wp)
   end subroutine test_stall

   subroutine test_too_few(error)
      type(error_type), allocatable, intent(out) :: error
      type(curve_t) :: curve
      type(least_squares_result_t) :: result
      type(status_t) :: status
      curve%model = LINE
      curve%t = [1.0_wp]
      curve%y = [1.0_wp]
      call minimize(curve, [0.0_wp, 0.0_wp], result, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT)
   end subroutine test_too_few

end submodule test_least_squares
