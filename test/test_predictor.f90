!> The predictor of implicit steps, and what the table says of the methods against what they are.
submodule(suites_of_runs) test_predictor
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: dense_stepper_t, integrator_settings_t, make_stepper, method_of, method_t, methods, &
      stepper_t
   use nutate_number_archive, only: number_archive_t
   use nutate_predictor, only: most_unknowns, predictor_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_problems, only: box, problem_t
   use test_support, only: check, check_close, error_type, new_unittest
   implicit none

contains

   module procedure collect_predictor
      testsuite = [ &
                  new_unittest("a polynomial through the steps is continued", polynomial_is_continued), &
                  new_unittest("a step of another length is predicted in proportion", other_length_in_proportion), &
                  new_unittest("what was forgotten has no weight", forgotten_steps_have_no_weight), &
                  new_unittest("a unit that changes changes the prediction alone", unit_changes_with_it), &
                  new_unittest("a predictor goes on from an archive", predictor_goes_on), &
                  new_unittest("the table knows the methods with dense output", table_knows_dense_output), &
                  new_unittest("the table knows the methods that estimate", table_knows_estimates)]
   end procedure collect_predictor

   !> Values of eight polynomials of a degree at step k.
   pure function polynomials(degree, k) result(z)
      integer, intent(in) :: degree, k
      real(wp) :: z(most_unknowns)
      integer :: i
      z = [(i*(real(k, wp)/8)**degree - 0.5_wp*k, i=1, most_unknowns)]
   end function polynomials

   !> Through m steps goes a polynomial of degree m - 1, up to 5.
   subroutine polynomial_is_continued(error)
      type(error_type), allocatable, intent(out) :: error
      type(predictor_t) :: predictor
      integer :: steps, k
      do steps = 1, 9
         call predictor%set_up(most_unknowns)
         do k = 1, steps
            call predictor%remember(0.1_wp, polynomials(min(steps, 6) - 1, k))
         end do
         call predictor%predict(0.1_wp)
         if (steps > 1) call check_close(error, predictor%guess, polynomials(min(steps, 6) - 1, steps + 1), &
                                         400*eps*maxval(abs(polynomials(min(steps, 6) - 1, steps + 1))), 'prediction')
         call check(error, predictor%known, min(steps, 6))
      end do
   end subroutine polynomial_is_continued

   subroutine other_length_in_proportion(error)
      type(error_type), allocatable, intent(out) :: error
      type(predictor_t) :: predictor
      integer :: k
      call predictor%set_up(most_unknowns)
      do k = 1, 4
         call predictor%remember(0.1_wp, polynomials(3, k))
      end do
      call predictor%predict(-0.3_wp)
      call check_close(error, predictor%guess, -3*polynomials(3, 4), 8*eps*norm2(polynomials(3, 4)), 'other length')
      call check(error, predictor%known, 1)
   end subroutine other_length_in_proportion

   subroutine forgotten_steps_have_no_weight(error)
      type(error_type), allocatable, intent(out) :: error
      type(predictor_t) :: predictor
      integer :: k
      call predictor%set_up(most_unknowns)
      do k = 1, 6
         call predictor%remember(0.1_wp, polynomials(5, k))
      end do
      call predictor%forget(2)
      call predictor%predict(0.1_wp)
      call check_close(error, predictor%guess, 2*polynomials(5, 6) - polynomials(5, 5), &
                       8*eps*norm2(polynomials(5, 6)), 'two steps')
   end subroutine forgotten_steps_have_no_weight

   subroutine unit_changes_with_it(error)
      type(error_type), allocatable, intent(out) :: error
      type(predictor_t) :: predictor
      real(wp) :: before(most_unknowns)
      integer :: k
      call predictor%set_up(most_unknowns)
      do k = 1, 3
         call predictor%remember(0.1_wp, polynomials(2, k))
      end do
      call predictor%predict(0.1_wp)
      before = predictor%guess
      call predictor%change_unit(5, 0.25_wp)
      call predictor%predict(0.1_wp)
      call check_close(error, predictor%guess(1:4), before(1:4), 0.0_wp, 'kept unit')
      call check_close(error, predictor%guess(5:8), 0.25_wp*before(5:8), 0.0_wp, 'changed unit')
   end subroutine unit_changes_with_it

   subroutine predictor_goes_on(error)
      type(error_type), allocatable, intent(out) :: error
      type(predictor_t) :: predictor, other
      type(number_archive_t) :: archive
      real(wp), target :: store(20)
      integer :: k
      call predictor%set_up(3)
      do k = 1, 5
         call predictor%remember(0.1_wp, polynomials(4, k))
      end do
      call archive%begin_counting()
      call predictor%transfer(archive)
      call check(error, archive%count(), size(store))
      if (allocated(error)) return
      call archive%begin_writing(store)
      call predictor%transfer(archive)
      call other%set_up(3)
      call archive%begin_reading(store)
      call other%transfer(archive)
      call check(error, archive%problem() == '', archive%problem())
      call predictor%predict(0.1_wp)
      call other%predict(0.1_wp)
      call check_close(error, other%guess, predictor%guess, 0.0_wp, 'prediction')
   end subroutine predictor_goes_on

   !> The settings of a row of the table.
   pure type(integrator_settings_t) function settings_of(method) result(settings)
      type(method_t), intent(in) :: method
      settings%method = method%name
      settings%formulation = method%formulation
      settings%order = method%order
      settings%conserve = method%projected
   end function settings_of

   subroutine table_knows_dense_output(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(status_t) :: status
      type(method_t) :: method
      logical :: dense
      integer :: i
      problem => box()
      do i = 1, size(methods)
         call make_stepper(problem%system, settings_of(methods(i)), stepper, status)
         call check(error, status%ok(), trim(status%message))
         if (allocated(error)) return
         select type (stepper)
         class is (dense_stepper_t)
            dense = .true.
         class default
            dense = .false.
         end select
         method = method_of(settings_of(methods(i)))
         call check(error, method%dense .eqv. dense, trim(methods(i)%name))
      end do
   end subroutine table_knows_dense_output

   !> Checks that after a long step an estimate is above round-off if there is one, and zero if there is none.
   subroutine table_knows_estimates(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      integer :: i
      problem => box()
      do i = 1, size(methods)
         call make_stepper(problem%system, settings_of(methods(i)), stepper, status)
         state = problem%start
         call stepper%step(problem%system, state, 0.05_wp, status)
         call check(error, status%ok() .and. ((stepper%error_estimate > 0.0_wp) .eqv. methods(i)%estimate_power > 0), &
                    trim(methods(i)%name))
      end do
   end subroutine table_knows_estimates

end submodule test_predictor
