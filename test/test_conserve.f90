!> The projection onto the invariants: what it keeps, and that it costs no order.
submodule(suites_of_runs) test_conserve
   use nutate_applied_torque, only: applied_torque_t
   use nutate_damping, only: damping_t
   use nutate_kinds, only: wp
   use nutate_methods, only: default_settings, integrator_settings_t, make_stepper, stepper_t
   use nutate_quaternion, only: attitude_distance
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_run, only: integrate, run_record_t, run_summary_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_scene, only: read_scene, scene_t
   use nutate_state, only: add_increment, state_t
   use nutate_status, only: NUTATE_BAD_ARGUMENT, status_t
   use test_conserving_runs, only: check_guard, check_run, get_stepper, go, guard_row, guard_t, methods, round_off
   use test_problems, only: body_momentum, box, bruls_top, forced_body, free_body, make_state, march, new_problem, &
      problem_t, simo_top, total_energy
   use test_support, only: check, check_below, check_close, error_type, in_turn, new_unittest, scene_names
   implicit none

contains

   module procedure collect_conserve
      testsuite = [ &
                  new_unittest("every scene keeps its invariants", every_scene_keeps_its_invariants), &
                  new_unittest("nothing adds up over a million steps", nothing_adds_up), &
                  new_unittest("orders are kept", orders_are_kept), &
                  new_unittest("the error on the box is divided", error_on_the_box_is_divided), &
                  new_unittest("work and energy as by another method", work_and_energy_as_by_another), &
                  new_unittest("there and back", there_and_back), &
                  new_unittest("units by powers of two change no digit", units_change_no_digit), &
                  new_unittest("momentum alone", momentum_alone), &
                  new_unittest("controlled runs and rows between steps", controlled_runs), &
                  new_unittest("a step tried again keeps the targets", a_step_tried_again), &
                  new_unittest("steps that are taken back leave no trace", steps_aside_leave_no_trace), &
                  new_unittest("another state starts anew", another_state_starts_anew), &
                  new_unittest("a balance of another system is not used", another_system_starts_anew), &
                  new_unittest("parts of a step are known to be such", parts_are_known), &
                  new_unittest("implicit steps move by round-off alone", implicit_steps_move_little), &
                  new_unittest("only methods with round-off to take away have it", only_where_it_has_a_use)]
   end procedure collect_conserve

   subroutine every_scene_keeps_its_invariants(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      integer :: i, m
      allocate (scene)
      do i = 1, size(scene_names)
         call read_scene('scenes/'//trim(scene_names(i))//'.nml', scene, status, message)
         call check(error, status%ok(), message)
         do m = 1, 2
            call check_run(error, problem_t(scene%system, scene%initial), methods(m), scene%plan%time_step, 2000, 1)
         end do
         if (allocated(error)) then
            error%message = trim(scene_names(i))//': '//error%message
            return
         end if
      end do
   end subroutine every_scene_keeps_its_invariants

   subroutine nothing_adds_up(error)
      type(error_type), allocatable, intent(out) :: error
      call check_run(error, box(), 'rk4', 0.01_wp, 1000000, 1000)
      call check_run(error, simo_top(), 'dop853', 0.01_wp, 100000, 100)
      call check_run(error, forced_body(), 'rk4', 0.01_wp, 100000, 100)
      call check_run(error, simo_top(), 'nielsen_krenk', 0.01_wp, 50000, 100)
      call check_run(error, forced_body(), 'nielsen_krenk', 0.01_wp, 50000, 100)
   end subroutine nothing_adds_up

   subroutine orders_are_kept(error)
      type(error_type), allocatable, intent(out) :: error
      call check_orders(error, free_body([0.6_wp, 0.8_wp, 1.0_wp], [1.8_wp, 0.4_wp, -0.9_wp]), 10.0_wp, [200, 32])
      call check_orders(error, box(), 2.0_wp, [200, 25])
      call check_orders(error, bruls_top(), 0.2_wp, [400, 50])
      call check_orders(error, forced_body(), 2.0_wp, [100, 12])
   end subroutine orders_are_kept

   !> Slope of the attitude error over a halving from n steps: 4 ± 0.2 and 8 - 0.5 or more.
   subroutine check_orders(error, problem, t, n)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: t
      integer, intent(in) :: n(2)
      real(wp), parameter :: least(2) = [3.8_wp, 7.5_wp], most(2) = [4.2_wp, 9.2_wp]
      type(state_t) :: reference, state
      real(wp) :: errors(2)
      integer :: k, m
      call go(error, problem, 'dop853', .false., t/1000, 1000, reference)
      do m = 1, 2
         do k = 1, 2
            if (.not. allocated(error)) call go(error, problem, methods(m), .true., t/(k*n(m)), k*n(m), state)
            errors(k) = attitude_distance(state%q, reference%q)
         end do
         call check(error, errors(1) < 1e-3_wp .and. errors(2) > 5e-12_wp, "errors are out of the range that shows")
         call check_below(error, log(errors(1)/errors(2))/log(2.0_wp), most(m), methods(m)//" order")
         call check_below(error, least(m), log(errors(1)/errors(2))/log(2.0_wp), methods(m)//" order")
      end do
   end subroutine check_orders

   !> The box tumbles on its unstable axis, where errors of energy and momentum grow the fastest.
   subroutine error_on_the_box_is_divided(error)
      type(error_type), allocatable, intent(out) :: error
      type(state_t) :: reference, plain, corrected
      call go(error, box(), 'dop853', .true., 0.01_wp, 2000, reference)
      if (.not. allocated(error)) call go(error, box(), 'dop853', .false., 0.04_wp, 500, plain)
      if (.not. allocated(error)) call go(error, box(), 'dop853', .true., 0.04_wp, 500, corrected)
      call check_below(error, 15*attitude_distance(corrected%q, reference%q), attitude_distance(plain%q, reference%q), &
                       "15 times the corrected error")
   end subroutine error_on_the_box_is_divided

   !> Work and energy after 4 s of every kind of effect against steps of another kind, as good as the method.
   subroutine work_and_energy_as_by_another(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: tolerances(2) = [2e-6_wp, 2e-10_wp]
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: energies(3, 3)
      integer :: i, m
      problem => forced_body()
      do m = 1, 3
         if (m == 1) call make_stepper(problem%system, integrator_settings_t(order=8, formulation='reduced'), &
                                       stepper, status)
         if (m > 1) call get_stepper(problem, methods(m - 1), .true., stepper, status)
         state = problem%start
         energies(:, m) = 0.0_wp
         do i = 1, 200
            call stepper%step(problem%system, state, 0.02_wp, status)
            if (status%ok()) energies(1:2, m) = energies(1:2, m) + stepper%work
         end do
         energies(3, m) = total_energy(problem%system, state)
         call check(error, status%ok(), trim(status%message))
         if (allocated(error)) return
         if (m == 1) cycle
         associate (first => total_energy(problem%system, problem%start))
            call check_close(error, energies(3, m) - first, sum(energies(1:2, m)), 2*round_off*first, "account")
         end associate
         call check_close(error, energies(:, m), energies(:, 1), &
                          tolerances(m - 1)*maxval(abs(energies(:, 1))), methods(m - 1)//" energies")
      end do
   end subroutine work_and_energy_as_by_another

   subroutine there_and_back(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: steps(2) = [0.01_wp, 0.05_wp], tolerances(2) = [1e-7_wp, 1e-9_wp]
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      integer :: m
      problem => forced_body()
      do m = 1, 2
         call get_stepper(problem, methods(m), .true., stepper, status)
         state = problem%start
         call march(problem%system, stepper, state, steps(m), 40, status)
         if (status%ok()) call march(problem%system, stepper, state, -steps(m), 40, status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, [state%t, state%q], [0.0_wp, problem%start%q], tolerances(m), "q")
         problem%start%t = 0.0_wp
         call check_run(error, problem, methods(m), -steps(m), 40, 1)
      end do
   end subroutine there_and_back

   !> Units of mass and time in powers of two, up to energies of 2^±600, whose squares are beyond all numbers.
   subroutine units_change_no_digit(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: masses(3) = [300, -300, 37], times(3) = [-150, 150, 11]
      real(wp), parameter :: moments(3) = [0.6_wp, 0.8_wp, 1.0_wp], momentum(3) = [0.1_wp, 1.8_wp, -0.2_wp]
      type(state_t) :: a, b
      integer :: k, m
      do m = 1, 2
         call go(error, free_body(moments, momentum), methods(m), .true., 0.125_wp, 400, a)
         do k = 1, size(masses)
            if (allocated(error)) return
            call go(error, free_body(scale(moments, masses(k)), scale(momentum, masses(k) - times(k))), methods(m), &
                    .true., scale(0.125_wp, times(k)), 400, b)
            call check_close(error, b%q, a%q, 0.0_wp, methods(m)//" q")
            call check_close(error, scale(b%p, times(k) - masses(k)), a%p, 0.0_wp, methods(m)//" p")
         end do
      end do
   end subroutine units_change_no_digit

   !> Without attitude: |L| and T of a free body; with damping the account of its work; q is not touched.
   subroutine momentum_alone(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(integrator_settings_t) :: settings
      type(state_t) :: state, with
      type(guard_t) :: guard
      type(run_summary_t) :: summary
      type(status_t) :: status
      integer :: k, m
      problem => box()
      do k = 1, 2
         do m = 1, 2
            settings = default_settings(methods(m))
            settings%conserve = .true.
            settings%attitude = .false.
            call make_stepper(problem%system, settings, stepper, status)
            state = problem%start
            call guard%begin(attitude=.false.)
            call integrate(problem%system, stepper, state, run_plan_t(time_step=0.01_wp, end_time=10.0_wp), status, &
                           guard)
            call check(error, status%ok(), trim(status%message))
            call check_guard(error, guard)
            call check_close(error, state%q, problem%start%q, 0.0_wp, "q")
            if (.not. allocated(error)) call go(error, problem, 'dop853', .true., 0.01_wp, 1000, with)
            call check_close(error, body_momentum(state), body_momentum(with), merge(0.1_wp, 1e-8_wp, m == 1)*170, "L")
         end do
         call problem%system%effects%add(damping_t([0.1_wp, 0.2_wp, 0.3_wp]))
      end do
   end subroutine momentum_alone

   !> Steps chosen by Richardson's halves and by an estimate, with tries rejected and rows between the steps.
   subroutine controlled_runs(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(integrator_settings_t) :: settings
      type(guard_t) :: guard
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      integer :: k, m, rejected
      problem => new_problem()
      rejected = 0
      do k = 1, 3
         if (k == 1) problem => box()
         if (k == 2) problem => bruls_top()
         if (k == 3) problem => forced_body()
         do m = 1, 2
            settings = default_settings(methods(m))
            settings%conserve = .true.
            state = problem%start
            call guard%begin(attitude=.true.)
            call integrate(problem%system, settings, state, &
                           run_plan_t(end_time=merge(1.0_wp, 10.0_wp, k == 2), interval=0.0123_wp, &
                                      goal=run_goal_t(local_tolerance=1e-7_wp)), status, guard, summary)
            call check(error, status%ok(), trim(status%message))
            call check(error, guard%rows > summary%steps/30 .and. guard%rows > 80, "no rows between steps")
            call check_guard(error, guard)
            rejected = rejected + int(summary%subdivided_steps)
         end do
      end do
      call check(error, rejected > 10, "no tries were rejected")
   end subroutine controlled_runs

   !> Every step is taken twice, the first time twice as long: targets are those of the first state all the same.
   subroutine a_step_tried_again(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state, try
      type(status_t) :: status
      type(guard_t) :: guard
      type(run_record_t) :: record
      real(wp) :: compensation
      integer :: i, k
      do k = 1, 2
         compensation = 0.0_wp
         problem => box()
         if (k == 2) problem => forced_body()
         call get_stepper(problem, 'rk4', .true., stepper, status)
         state = problem%start
         record = run_record_t()
         call guard%begin(attitude=.true.)
         call guard_row(guard, problem%system, state, record, status)
         do i = 1, 20000
            try = state
            if (status%ok()) call stepper%step(problem%system, try, 0.02_wp, status)
            if (status%ok()) call stepper%step(problem%system, state, 0.01_wp, status)
            call add_increment(record%work, compensation, sum(stepper%work))
            if (mod(i, 100) == 1) call guard_row(guard, problem%system, state, record, status)
         end do
         call check(error, status%ok(), trim(status%message))
         call check_guard(error, guard)
      end do
   end subroutine a_step_tried_again

   !> All that a projection follows travels with the state: a stepper that tries steps of other lengths and has them
   !> taken back gives the digits of one that does not. (`taylor` uses the series of such a step again.)
   subroutine steps_aside_leave_no_trace(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=6), parameter :: names(3) = ['rk4   ', 'dop853', 'rk8   ']
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: tries, plain
      type(state_t) :: a, b, aside
      type(status_t) :: status, refused
      integer :: i, k, m
      do k = 1, 2
         problem => box()
         if (k == 2) problem => forced_body()
         do m = 1, size(names)
            call get_stepper(problem, names(m), .true., tries, status)
            call get_stepper(problem, names(m), .true., plain, status)
            a = problem%start
            b = problem%start
            do i = 1, 500
               aside = a
               call tries%step(problem%system, aside, 0.003_wp*mod(7*i, 11) + 0.001_wp, refused)
               if (status%ok()) call tries%step(problem%system, a, 0.01_wp, status)
               if (status%ok()) call plain%step(problem%system, b, 0.01_wp, status)
            end do
            call check(error, status%ok(), trim(names(m))//': '//trim(status%message))
            call check_close(error, [a%t, a%q, a%p], [b%t, b%q, b%p], 0.0_wp, trim(names(m)))
         end do
      end do
   end subroutine steps_aside_leave_no_trace

   !> A stepper that is prepared for another system does not use the balance that a state brings along.
   subroutine another_system_starts_anew(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: first, second
      class(stepper_t), allocatable :: stepper
      type(state_t) :: a, b
      type(status_t) :: status
      integer :: m
      first => box()
      second => bruls_top()
      do m = 1, 2
         call get_stepper(first, methods(m), .true., stepper, status)
         a = first%start
         call march(first%system, stepper, a, 0.01_wp, 10, status)
         b = make_state(second%system, a%q, [0.3_wp, -0.2_wp, 9.0_wp])
         b%t = a%t
         a%q = b%q
         a%p = b%p
         a%q_compensation = 0.0_wp
         a%p_compensation = 0.0_wp
         ! The balance is set as if the first system had left this very state.
         call a%balance_here()
         call get_stepper(second, methods(m), .true., stepper, status)
         if (status%ok()) call march(second%system, stepper, a, 0.001_wp, 10, status)
         call get_stepper(second, methods(m), .true., stepper, status)
         if (status%ok()) call march(second%system, stepper, b, 0.001_wp, 10, status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, [a%t, a%q, a%p], [b%t, b%q, b%p], 0.0_wp, trim(methods(m)))
      end do
   end subroutine another_system_starts_anew

   !> A stepper that has been elsewhere gives the digits of a new one.
   subroutine another_state_starts_anew(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: used, fresh
      type(state_t) :: a, b
      type(status_t) :: status
      integer :: m
      problem => forced_body()
      do m = 1, 2
         call get_stepper(problem, methods(m), .true., used, status)
         call get_stepper(problem, methods(m), .true., fresh, status)
         a = problem%start
         call march(problem%system, used, a, 0.02_wp, 10, status)
         a = make_state(problem%system, [0.5_wp, 0.5_wp, 0.5_wp, 0.5_wp], [-0.1_wp, 0.2_wp, 0.15_wp])
         b = a
         if (status%ok()) call march(problem%system, used, a, 0.02_wp, 10, status)
         if (status%ok()) call march(problem%system, fresh, b, 0.02_wp, 10, status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, [a%t, a%q, a%p], [b%t, b%q, b%p], 0.0_wp, "state")
      end do
   end subroutine another_state_starts_anew

   !> A torque with a window acts or not by the middle of the whole step, whatever the time.
   subroutine parts_are_known(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      integer :: m
      problem => box()
      call problem%system%effects%add(applied_torque_t(name='torque', amplitude=[1.0_wp, 2.0_wp, 3.0_wp], &
                                                       start=0.0_wp, stop=1.0_wp))
      do m = 1, 2
         call get_stepper(problem, methods(m), .true., stepper, status)
         state = problem%start
         call stepper%advance(problem%system, state, 0.01_wp, 1.5_wp, status)
         call check_close(error, stepper%work, [0.0_wp], 0.0_wp, "work without the whole in the window")
         state%t = 1.5_wp
         call stepper%advance(problem%system, state, 0.01_wp, 0.5_wp, status)
         call check(error, abs(stepper%work(1)) > 0.1_wp, "no work though the whole is in the window")
      end do
   end subroutine parts_are_known

   !> In every form and order, with potentials and torques, in axes that turn, with a finite J0: the same motion as
   !> without the projection, invariants and account at round-off.
   subroutine implicit_steps_move_little(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(integrator_settings_t) :: settings
      type(state_t) :: states(2)
      type(status_t) :: status
      type(guard_t) :: guard
      integer :: i, k, form
      problem => new_problem()
      do i = 1, 4
         if (i == 1) problem => box()
         if (i == 2) problem => simo_top()
         if (i >= 3) problem => forced_body()
         if (i == 4) call problem%system%effects%add(rotating_frame_t(name='rotating_frame', &
                                                                      rate=[0.1_wp, -0.2_wp, 0.3_wp]))
         do form = 0, 11
            if (.not. in_turn(form + i)) cycle
            settings%order = 2 + 2*modulo(form, 4)
            settings%formulation = merge('reduced', 'full   ', form < 4)
            settings%inverse_auxiliary_inertia = merge(1.0_wp, 0.0_wp, form > 7)
            do k = 1, 2
               settings%conserve = k == 2
               states(k) = problem%start
               call guard%begin(.true.)
               call integrate(problem%system, settings, states(k), run_plan_t(time_step=0.01_wp, end_time=10.0_wp), &
                              status, guard)
               call check(error, status%ok(), trim(status%message))
            end do
            call check_guard(error, guard)
            call check_below(error, attitude_distance(states(2)%q, states(1)%q), 1e-10_wp, "attitude")
         end do
      end do
   end subroutine implicit_steps_move_little

   subroutine only_where_it_has_a_use(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(status_t) :: status
      problem => box()
      call get_stepper(problem, 'exact', .true., stepper, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT)
      call make_stepper(problem%system, integrator_settings_t(conserve=.true., projection=.false., &
                                                              inverse_auxiliary_inertia=0.1_wp), stepper, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT)
      call get_stepper(problem, 'dop853', .true., stepper, status)
      call check(error, status%ok() .and. stepper%error_estimate >= 0.0_wp, "no estimate")
   end subroutine only_where_it_has_a_use

end submodule test_conserve
