!> The rational sum: exact for what it is made for, left alone where a pole is near, and honest in the choice of steps.
submodule(suites_of_methods) test_series_tail
   use nutate_exact_free, only: free_body_t
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: default_settings, make_stepper
   use nutate_quaternion, only: attitude_distance
   use nutate_series_tail, only: most_parts, series_tail_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: integrator_settings_t, step_goal_t, stepper_t
   use nutate_taylor_stepper, only: taylor_t
   use test_problems, only: body_momentum, box, forced_body, free_body, march, problem_t
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   integer, parameter :: order = 12

contains

   module procedure collect_series_tail
      testsuite = [ &
                  new_unittest("the sum of a pair of poles is exact", pair_of_poles), &
                  new_unittest("the sum stays away from a pole on the way", pole_on_the_way), &
                  new_unittest("coefficients without a recurrence have no rational sum", no_recurrence), &
                  new_unittest("the box takes half the fixed steps of the plain sum", fewer_fixed_steps), &
                  new_unittest("no chosen step errs by much more than it may", honest_steps), &
                  new_unittest("a step as long as chosen goes back where it came from", goes_back)]
   end procedure collect_series_tail

   !> Coefficients `k` of three series of the poles 1/z and 1/z̄: real parts of cᵢ zᵏ.
   pure function poles(z, k) result(x)
      complex(wp), intent(in) :: z
      integer, intent(in) :: k
      real(wp) :: x(most_parts)
      x = 0.0_wp
      x(1:3) = real([(1.0_wp, 0.3_wp), (-0.5_wp, 2.0_wp), (0.2_wp, -0.7_wp)]*z**k, wp)
   end function poles

   !> The tail of that series.
   type(series_tail_t) function tail_of(z) result(tail)
      complex(wp), intent(in) :: z
      real(wp) :: x(most_parts, 4)
      integer :: i
      do i = 1, 4
         x(:, i) = poles(z, order + 1 - i)
      end do
      call tail%fit(3, x)
   end function tail_of

   subroutine pair_of_poles(error)
      type(error_type), allocatable, intent(out) :: error
      type(series_tail_t) :: tail
      complex(wp) :: z
      real(wp) :: last, before, s, expected(3), found(3), a(most_parts), b(most_parts)
      integer :: i
      do i = 1, 4
         z = cmplx(1.2_wp*cos(0.7_wp*i), 1.2_wp*sin(0.7_wp*i), wp)
         tail = tail_of(z)
         s = 0.7_wp
         call check(error, tail%limit > s, "no recurrence")
         call tail%use_in_step(s)
         call tail%weights(order, s, last, before)
         a = poles(z, order)
         b = poles(z, order - 1)
         found = last*a(1:3) + before*b(1:3)
         expected = real([(1.0_wp, 0.3_wp), (-0.5_wp, 2.0_wp), (0.2_wp, -0.7_wp)]*((z*s)**(order + 1)/(1 - z*s)), wp)
         call check_close(error, found, expected, 1e-12_wp*norm2(expected), "tail")
      end do
   end subroutine pair_of_poles

   !> 1/(1 - s): usable until 1 - s falls to 0.3, on the whole step or not at all.
   subroutine pole_on_the_way(error)
      type(error_type), allocatable, intent(out) :: error
      type(series_tail_t) :: tail
      real(wp) :: last, before
      tail = tail_of((1.0_wp, 0.0_wp))
      call check_close(error, tail%limit, 0.7_wp, 1e-9_wp, "limit")
      call tail%use_in_step(0.71_wp)
      call tail%weights(order, 0.2_wp, last, before)
      call check_close(error, [last, before], [0.0_wp, 0.0_wp], 0.0_wp, "a sum beyond the limit")
      call tail%use_in_step(0.69_wp)
      call tail%weights(order, 0.5_wp, last, before)
      call check_close(error, last + before, 2*0.5_wp**(order + 1), 1e-9_wp*0.5_wp**order, "tail")
   end subroutine pole_on_the_way

   subroutine no_recurrence(error)
      type(error_type), allocatable, intent(out) :: error
      type(series_tail_t) :: tail
      real(wp) :: x(most_parts, 4)
      x = 0.0_wp
      call tail%fit(3, x)
      call check_close(error, tail%limit, 0.0_wp, 0.0_wp, "of nothing")
      x(1, 1) = 1.0_wp
      x(2, 2) = 1.0_wp
      x(3, 3) = 1.0_wp
      x(1, 4) = 0.2_wp
      call tail%fit(3, x)
      call check_close(error, tail%limit, 0.0_wp, 0.0_wp, "of independent coefficients")
      call check_close(error, tail%squares, [1.0_wp, 1.0_wp], 0.0_wp, "squares")
   end subroutine no_recurrence

   !> The plain sum needs 448 steps of order 16 for 50 s to 1e-6 rad.
   subroutine fewer_fixed_steps(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(free_body_t) :: solution
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: q(4), momentum(3)
      problem => box()
      call solution%prepare(problem%system%body%moments, problem%start%q, body_momentum(problem%start), status)
      call solution%evaluate(50.0_wp, q, momentum)
      call make_stepper(problem%system, default_settings('taylor'), stepper, status)
      state = problem%start
      call march(problem%system, stepper, state, 50.0_wp/250, 250, status)
      call check(error, status%ok(), trim(status%message))
      call check_below(error, attitude_distance(state%q, q), 1e-6_wp)
   end subroutine fewer_fixed_steps

   !> Chosen steps along the motion of free bodies, each against the exact solution from where it starts.
   subroutine honest_steps(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t) :: problems(3)
      type(taylor_t) :: stepper
      type(state_t) :: state, middle
      type(status_t) :: status
      real(wp) :: tolerance, step, work, worst
      integer :: i, exponent
      character(len=40) :: label
      problems(1) = box()
      problems(2) = free_body([0.6_wp, 0.8_wp, 1.0_wp], [1.8_wp, 0.4_wp, -0.9_wp])
      problems(3) = free_body([0.345_wp, 0.653_wp, 0.9_wp], [0.2_wp, 1.5_wp, 0.1_wp])
      do i = 1, size(problems)
         do exponent = 4, 14, 2
            tolerance = 10.0_wp**(-exponent)
            state = problems(i)%start
            step = 0.01_wp
            worst = 0.0_wp
            call stepper%prepare(problems(i)%system, default_settings('taylor'), status)
            do while (state%t < 30.0_wp .and. status%ok())
               call stepper%choose_step(problems(i)%system, state, step_goal_t(tolerance, 0.0_wp, 1e3_wp), step, status)
               middle = state
               call look(problems(i), stepper, state, middle, step, work, worst, status)
            end do
            call check(error, status%ok(), trim(status%message))
            if (allocated(error)) return
            write (label, '("body ",i0,", tolerance 1e-",i0)') i, exponent
            call check_below(error, worst, 2*tolerance + 40*eps, label)
         end do
      end do
   end subroutine honest_steps

   !> Performs a step, and compares its end and a state inside with the exact solution.
   subroutine look(problem, stepper, state, inside, step, work, worst, status)
      type(problem_t), intent(in) :: problem
      type(taylor_t), intent(inout) :: stepper
      type(state_t), intent(inout) :: state, inside
      real(wp), intent(in) :: step
      real(wp), intent(out) :: work
      real(wp), intent(inout) :: worst
      type(status_t), intent(inout) :: status
      type(free_body_t) :: solution
      type(status_t) :: inner
      real(wp) :: q(4), momentum(3), t
      t = state%t
      call solution%prepare(problem%system%body%moments, state%q, body_momentum(state), status)
      call stepper%step(problem%system, state, step, status)
      if (.not. status%ok()) return
      call solution%evaluate(step, q, momentum)
      worst = max(worst, attitude_distance(state%q, q))
      call stepper%state_at(problem%system, t + 0.7_wp*step, inside, work, inner)
      call solution%evaluate(inside%t - t, q, momentum)
      worst = max(worst, attitude_distance(inside%q, q))
   end subroutine look

   !> Goes there and back by a chosen step, for bodies with every effect. Both have one order, which fixed steps do not
   !> take from a tolerance.
   subroutine goes_back(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(taylor_t) :: stepper
      type(integrator_settings_t) :: settings
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: step
      integer :: i
      settings = default_settings('taylor')
      settings%series_order = 20
      problem => forced_body()
      do i = 1, 2
         if (i == 2) problem => box()
         call stepper%prepare(problem%system, settings, status)
         state = problem%start
         step = 0.1_wp
         call stepper%choose_step(problem%system, state, step_goal_t(1e-10_wp, 0.0_wp, 10.0_wp), step, status)
         call stepper%step(problem%system, state, step, status)
         call stepper%step(problem%system, state, -step, status)
         call check(error, status%ok(), trim(status%message))
         call check_below(error, attitude_distance(state%q, problem%start%q), 4e-10_wp, "attitude")
         call check_close(error, state%p, problem%start%p, 4e-10_wp*norm2(state%p), "momentum")
      end do
   end subroutine goes_back

end submodule test_series_tail
