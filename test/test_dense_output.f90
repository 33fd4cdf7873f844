!> States inside a step, for every method: as good as the method, and unnoticed by the steps.
submodule(suites_of_methods) test_dense_output
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: default_settings, integrator_settings_t, make_stepper, methods, stepper_t
   use nutate_quaternion, only: attitude_distance
   use nutate_state, only: state_t
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT
   use test_problems, only: box, fast_top, forced_body, march, new_problem, problem_t, total_energy
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

contains

   module procedure collect_dense_output
      testsuite = [ &
                  new_unittest("states inside have the error of the method", errors_inside), &
                  new_unittest("states inside keep energy and momentum as steps do", invariants_inside), &
                  new_unittest("the account of work holds inside", work_inside), &
                  new_unittest("steps do not notice who looks inside", unnoticed), &
                  new_unittest("the same time gives the same state, whatever came before", independent_of_memory), &
                  new_unittest("the ends of the step are inside, other times are not", outside_is_refused)]
   end procedure collect_dense_output

   !> The settings of a row of the table.
   type(integrator_settings_t) function settings_of(row) result(settings)
      integer, intent(in) :: row
      settings = default_settings(methods(row)%name)
      settings%order = methods(row)%order
      settings%formulation = methods(row)%formulation
      settings%conserve = methods(row)%projected
   end function settings_of

   !> A problem that the method of a row can integrate.
   function problem_of(row) result(problem)
      integer, intent(in) :: row
      type(problem_t), pointer :: problem
      problem => new_problem()
      if (methods(row)%name == 'exact') then
         problem => box()
      else
         problem => forced_body()
      end if
   end function problem_of

   !> A stepper that has taken n steps of dt and keeps them.
   subroutine start(problem, row, dt, n, stepper, state, status)
      type(problem_t), intent(in) :: problem
      integer, intent(in) :: row, n
      real(wp), intent(in) :: dt
      class(stepper_t), allocatable, intent(out) :: stepper
      type(state_t), intent(out) :: state
      type(status_t), intent(out) :: status
      state = problem%start
      call make_stepper(problem%system, settings_of(row), stepper, status)
      if (.not. status%ok()) return
      call stepper%keep_steps()
      call march(problem%system, stepper, state, dt, n, status)
   end subroutine start

   !> The error inside is no larger than that of some steps: against the series with a tenth of the step.
   subroutine errors_inside(error)
      type(error_type), allocatable, intent(out) :: error
      class(stepper_t), allocatable :: stepper, reference
      type(problem_t), pointer :: problem
      type(state_t) :: state, exact, inside
      type(status_t) :: status
      real(wp) :: dt, part, work, at_end, within
      integer :: row, i
      do row = 1, size(methods)
         problem => problem_of(row)
         dt = merge(0.04_wp, -0.04_wp, mod(row, 2) == 0)
         call start(problem, row, dt, 4, stepper, state, status)
         call check(error, status%ok(), trim(methods(row)%name)//': '//trim(status%message))
         if (allocated(error)) return
         do i = 0, 4
            part = 0.25_wp*i
            exact = problem%start
            call make_stepper(problem%system, default_settings('taylor'), reference, status)
            call march(problem%system, reference, exact, (3 + part)*dt/16, 16, status)
            call stepper%state_at(problem%system, problem%start%t + (3 + part)*dt, inside, work, status)
            call check(error, status%ok(), trim(methods(row)%name)//': '//trim(status%message))
            within = attitude_distance(inside%q, exact%q)
            if (i == 4) at_end = attitude_distance(inside%q, state%q)
            call check_below(error, within, merge(1e-12_wp, 8*0.04_wp**(min(methods(row)%order, 8) + 1)*40, &
                                                  methods(row)%order == 0 .or. methods(row)%name == 'taylor') &
                             + 64*eps, trim(methods(row)%name))
         end do
         call check_below(error, at_end, 64*eps, trim(methods(row)%name)//' at the end')
      end do
   end subroutine errors_inside

   !> A top: the energy and the momentum along the vertical at every time inside.
   subroutine invariants_inside(error)
      type(error_type), allocatable, intent(out) :: error
      class(stepper_t), allocatable :: stepper
      type(problem_t), pointer :: problem
      type(state_t) :: state, inside
      type(status_t) :: status
      real(wp) :: energy, work, worst
      integer :: row, i
      problem => fast_top()
      energy = total_energy(problem%system, problem%start)
      do row = 1, size(methods)
         if (.not. methods(row)%conserving .or. methods(row)%name == 'exact') cycle
         call start(problem, row, 2e-3_wp, 3, stepper, state, status)
         worst = abs(total_energy(problem%system, state) - energy)
         do i = 1, 9
            call stepper%state_at(problem%system, 4e-3_wp + 2e-4_wp*i, inside, work, status)
            call check(error, status%ok(), trim(methods(row)%name)//': '//trim(status%message))
            call check_below(error, abs(total_energy(problem%system, inside) - energy), worst + 16*eps*energy, &
                             trim(methods(row)%name)//', energy')
            call check_below(error, abs(dot_product(inside%q, inside%q) - 1), 16*eps, trim(methods(row)%name))
         end do
      end do
   end subroutine invariants_inside

   !> H(t) - H(start of the step) is the work that is handed out with the state.
   subroutine work_inside(error)
      type(error_type), allocatable, intent(out) :: error
      class(stepper_t), allocatable :: stepper
      type(problem_t), pointer :: problem
      type(state_t) :: state, inside
      type(status_t) :: status
      real(wp) :: energy, work
      integer :: row
      problem => forced_body()
      do row = 1, size(methods)
         if (.not. methods(row)%conserving .or. methods(row)%name == 'exact') cycle
         call start(problem, row, 0.04_wp, 3, stepper, state, status)
         energy = total_energy(problem%system, state)
         call stepper%step(problem%system, state, 0.04_wp, status)
         call stepper%state_at(problem%system, 0.145_wp, inside, work, status)
         call check(error, status%ok(), trim(methods(row)%name)//': '//trim(status%message))
         call check_below(error, abs(total_energy(problem%system, inside) - energy - work), 256*eps*abs(energy), &
                          trim(methods(row)%name))
         call check(error, abs(work) > 1e-3_wp, 'no work to speak of')
      end do
   end subroutine work_inside

   !> Checks that evaluating states inside steps leaves the run bitwise identical.
   subroutine unnoticed(error)
      type(error_type), allocatable, intent(out) :: error
      class(stepper_t), allocatable :: looked, plain
      type(problem_t), pointer :: problem
      type(state_t) :: a, b, inside
      type(status_t) :: status
      real(wp) :: work
      integer :: row, i, k
      do row = 1, size(methods)
         problem => problem_of(row)
         call start(problem, row, 0.03_wp, 0, looked, a, status)
         call make_stepper(problem%system, settings_of(row), plain, status)
         b = problem%start
         do i = 1, 20
            call looked%step(problem%system, a, 0.03_wp, status)
            do k = 1, mod(i, 4)
               call looked%state_at(problem%system, a%t - 0.007_wp*k, inside, work, status)
               call check(error, status%ok(), trim(methods(row)%name)//': '//trim(status%message))
            end do
            call plain%step(problem%system, b, 0.03_wp, status)
         end do
         call check(error, all([a%t, a%q, a%p] == [b%t, b%q, b%p]), trim(methods(row)%name)//' noticed')
      end do
   end subroutine unnoticed

   !> One stepper looks inside every step, the other only inside the last.
   subroutine independent_of_memory(error)
      type(error_type), allocatable, intent(out) :: error
      class(stepper_t), allocatable :: often, once
      type(problem_t), pointer :: problem
      type(state_t) :: a, b, inside, same
      type(status_t) :: status
      real(wp) :: work
      integer :: row, i
      do row = 1, size(methods)
         problem => problem_of(row)
         call start(problem, row, 0.03_wp, 0, often, a, status)
         call start(problem, row, 0.03_wp, 0, once, b, status)
         do i = 1, 9
            call often%step(problem%system, a, 0.03_wp, status)
            call often%state_at(problem%system, a%t - 0.011_wp, inside, work, status)
            call once%step(problem%system, b, 0.03_wp, status)
         end do
         call once%state_at(problem%system, b%t - 0.011_wp, same, work, status)
         call check(error, all([inside%t, inside%q, inside%p] == [same%t, same%q, same%p]), trim(methods(row)%name))
      end do
   end subroutine independent_of_memory

   subroutine outside_is_refused(error)
      type(error_type), allocatable, intent(out) :: error
      class(stepper_t), allocatable :: stepper
      type(problem_t), pointer :: problem
      type(state_t) :: state, inside
      type(status_t) :: status
      real(wp) :: work
      integer :: row
      do row = 1, size(methods)
         problem => problem_of(row)
         call start(problem, row, 0.03_wp, 0, stepper, state, status)
         call stepper%state_at(problem%system, 0.0_wp, inside, work, status)
         call check(error, status%code, NUTATE_BAD_ARGUMENT, trim(methods(row)%name)//' before the first step')
         call march(problem%system, stepper, state, 0.03_wp, 2, status)
         call stepper%state_at(problem%system, 0.03_wp, inside, work, status)
         call check(error, status%ok(), trim(methods(row)%name)//' at the start')
         call check_close(error, inside%t, 0.03_wp, eps, trim(methods(row)%name))
         call stepper%state_at(problem%system, 0.0299_wp, inside, work, status)
         call check(error, status%code, NUTATE_BAD_ARGUMENT, trim(methods(row)%name)//' before the step')
         call stepper%state_at(problem%system, 0.0601_wp, inside, work, status)
         call check(error, status%code, NUTATE_BAD_ARGUMENT, trim(methods(row)%name)//' after the step')
      end do
   end subroutine outside_is_refused

end submodule test_dense_output
