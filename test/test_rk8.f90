!> The specialised explicit steps: their order in each of their forms, what they keep, and that reading a state
!> between steps does not change them.
submodule(suites_of_runs) test_rk8
   use nutate_body, only: diagonal, make_body
   use nutate_dipole, only: dipole_t
   use nutate_gravity, only: gravity_t
   use nutate_kinds, only: wp
   use nutate_methods, only: default_settings, stepper_t
   use nutate_quaternion, only: attitude_distance
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_run, only: integrate, observer_t, run_record_t
   use nutate_run_plan, only: run_plan_t
   use nutate_scene, only: read_scene, scene_t
   use nutate_state, only: state_t
   use nutate_status, only: NUTATE_OFF_BRANCH, status_t
   use test_conserving_runs, only: check_run, get_stepper, go
   use test_problems, only: box, bruls_top, fast_top, forced_body, free_body, make_state, march, new_problem, &
      problem_t, simo_top, system_t, total_energy
   use test_support, only: check, check_below, check_close, error_type, new_unittest, scene_names
   implicit none

   !> Looks at rows and keeps none.
   type, extends(observer_t) :: looker_t
   contains
      procedure :: observe => look
   end type looker_t

   !> A rate of axes that lies along nothing else, rad/s.
   real(wp), parameter :: inclined(3) = [0.8_wp, -1.4_wp, 1.1_wp]
   !> Methods whose steps are projected only now and then.
   character(len=6), parameter :: spaced(4) = ['rk8   ', 'dop853', 'rk4   ', 'taylor']

contains

   module procedure collect_rk8
      testsuite = [ &
                  new_unittest("order 8 in every form of the equations", order_8_in_every_form), &
                  new_unittest("and in space axes that turn", order_8_in_rotating_axes), &
                  new_unittest("a symmetric top takes the steps of its slow motion", symmetric_tops_take_few_steps), &
                  new_unittest("every axis of symmetry is as good", every_axis_is_as_good), &
                  new_unittest("every scene keeps its invariants", every_scene_keeps_its_invariants), &
                  new_unittest("nothing adds up over a million steps", nothing_adds_up), &
                  new_unittest("rows do not change the motion", rows_do_not_change_the_motion), &
                  new_unittest("nor do they with chosen steps of a series", rows_do_not_change_chosen_steps), &
                  new_unittest("a state that was seen goes on as the one behind it", seen_states_go_on), &
                  new_unittest("there and back", there_and_back), &
                  new_unittest("a body at rest stays there", rest_stays), &
                  new_unittest("steps too long are refused, nothing changed", too_long_is_refused)]
   end procedure collect_rk8

   !> A body with unequal moments under uniform fields.
   function body_in_fields(fields, tensor) result(problem)
      !> 1: gravity upright; 2: gravity aslant; 3: with a dipole.
      integer, intent(in) :: fields
      !> The inertia has products, which require the general equations.
      logical, intent(in) :: tensor
      type(problem_t), pointer :: problem
      type(status_t) :: status
      real(wp) :: inertia(3, 3)
      problem => new_problem()
      inertia = diagonal([0.4_wp, 0.7_wp, 1.0_wp])
      if (tensor) inertia(1, 2) = 0.05_wp
      if (tensor) inertia(2, 1) = 0.05_wp
      call make_body(inertia, problem%system%body, status, mass=2.0_wp, center_of_mass=[0.1_wp, 0.3_wp, -0.2_wp])
      associate (effects => problem%system%effects, body => problem%system%body)
         if (fields == 1) call effects%add(gravity_t(body, [0.0_wp, 0.0_wp, -9.0_wp]))
         if (fields > 1) call effects%add(gravity_t(body, [1.0_wp, -2.0_wp, -9.0_wp]))
         if (fields == 3) call effects%add(dipole_t([1.0_wp, 0.3_wp, 0.5_wp], [0.0_wp, 2.0_wp, 1.0_wp]))
      end associate
      problem%start = make_state(problem%system, [0.8_wp, 0.0_wp, -0.6_wp, 0.0_wp], [3.0_wp, 1.0_wp, -2.0_wp])
   end function body_in_fields

   subroutine order_8_in_every_form(error)
      type(error_type), allocatable, intent(out) :: error
      call check_order(error, free_body([0.6_wp, 0.8_wp, 1.0_wp], [1.8_wp, 0.4_wp, -0.9_wp]), 10.0_wp, 24, 'free')
      call check_order(error, bruls_top(), 2.0_wp, 16, 'symmetric')
      call check_order(error, body_in_fields(1, .false.), 5.0_wp, 60, 'upright')
      call check_order(error, body_in_fields(2, .false.), 5.0_wp, 60, 'aslant')
      call check_order(error, body_in_fields(3, .false.), 5.0_wp, 60, 'two fields')
      call check_order(error, body_in_fields(3, .true.), 5.0_wp, 60, 'tensor')
      call check_order(error, forced_body(), 2.0_wp, 16, 'all effects')
   end subroutine order_8_in_every_form

   !> Axes that turn about nothing that the body knows of.
   subroutine order_8_in_rotating_axes(error)
      type(error_type), allocatable, intent(out) :: error
      call check_order(error, rotating(bruls_top()), 2.0_wp, 20, 'symmetric')
      call check_order(error, rotating(body_in_fields(1, .false.)), 5.0_wp, 60, 'upright')
      call check_order(error, rotating(body_in_fields(2, .false.)), 5.0_wp, 60, 'aslant')
      call check_order(error, rotating(body_in_fields(3, .false.)), 5.0_wp, 60, 'two fields')
      call check_order(error, rotating(body_in_fields(3, .true.)), 5.0_wp, 60, 'tensor')
   end subroutine order_8_in_rotating_axes

   !> Returns a problem in inclined axes, with the same absolute motion.
   function rotating(still) result(problem)
      type(problem_t), intent(in) :: still
      type(problem_t), pointer :: problem
      problem => new_problem()
      problem = still
      call problem%system%effects%add(rotating_frame_t(name='rotating_frame', rate=inclined))
   end function rotating

   !> Slope of the attitude error over one halving from n steps, against the series; with the projection errors are at
   !> most twice as large.
   subroutine check_order(error, problem, t, n, label)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      !> s.
      real(wp), intent(in) :: t
      integer, intent(in) :: n
      character(len=*), intent(in) :: label
      type(state_t) :: exact, state
      real(wp) :: errors(2), projected
      integer :: k
      call go(error, problem, 'taylor', .true., t/2000, 2000, exact)
      do k = 1, 2
         if (.not. allocated(error)) call go(error, problem, 'rk8', .false., t/(k*n), k*n, state)
         errors(k) = attitude_distance(state%q, exact%q)
         if (.not. allocated(error)) call go(error, problem, 'rk8', .true., t/(k*n), k*n, state)
         projected = attitude_distance(state%q, exact%q)
         call check_below(error, projected, 2*errors(k), label//", projected")
      end do
      call check(error, errors(1) < 1e-4_wp .and. errors(2) > 5e-13_wp, label//": errors are out of range")
      call check_below(error, 7.5_wp, log(errors(1)/errors(2))/log(2.0_wp), label)
   end subroutine check_order

   !> Steps of up to two revolutions.
   subroutine symmetric_tops_take_few_steps(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(status_t) :: status
      type(state_t) :: exact, state
      problem => new_problem()
      call make_body(diagonal([3.0_wp, 3.0_wp, 4.0_wp]), problem%system%body, status, mass=1.0_wp, &
                     center_of_mass=[0.0_wp, 0.0_wp, 0.3_wp])
      call problem%system%effects%add(gravity_t(problem%system%body, [0.0_wp, 0.0_wp, -9.81_wp]))
      problem%start = make_state(problem%system, [0.8_wp, 0.6_wp, 0.0_wp, 0.0_wp], [0.3_wp, 1.0_wp, 5.0_wp])
      call go(error, problem, 'taylor', .true., 5e-3_wp, 4000, exact)
      if (.not. allocated(error)) call go(error, problem, 'rk8', .true., 0.125_wp, 160, state)
      call check_below(error, attitude_distance(state%q, exact%q), 1e-9_wp, "nutating top")
      call go(error, bruls_top(), 'taylor', .true., 5e-4_wp, 4000, exact)
      if (.not. allocated(error)) call go(error, bruls_top(), 'rk8', .true., 0.1_wp, 20, state)
      call check_below(error, attitude_distance(state%q, exact%q), 3e-8_wp, "Bruels")
      if (.not. allocated(error)) call go(error, rotating(bruls_top()), 'taylor', .true., 5e-4_wp, 4000, exact)
      if (.not. allocated(error)) call go(error, rotating(bruls_top()), 'rk8', .true., 0.1_wp, 20, state)
      call check_below(error, attitude_distance(state%q, exact%q), 6e-8_wp, "rotating axes")
      if (.not. allocated(error)) call go(error, fast_top(), 'taylor', .true., 5e-4_wp, 2000, exact)
      if (.not. allocated(error)) call go(error, fast_top(), 'rk8', .true., 0.01_wp, 100, state)
      call check_below(error, attitude_distance(state%q, exact%q), 3e-11_wp, "fast top")
   end subroutine symmetric_tops_take_few_steps

   !> A top about each of its axes, in a field along each axis of space, up and down.
   subroutine every_axis_is_as_good(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: moments(3), center(3), field(3)
      integer :: axis, along, sense
      do axis = 1, 3
         moments = 0.9_wp
         moments(axis) = 0.3_wp
         center = 0.0_wp
         center(axis) = 0.5_wp
         do along = 1, 3
            do sense = -1, 1, 2
               field = 0.0_wp
               field(along) = 5.0_wp*sense
               call compare_with_series(error, moments, center, field, .false.)
               call compare_with_series(error, moments, center, field, .true.)
            end do
         end do
      end do
   end subroutine every_axis_is_as_good

   !> The top of `moments` about `center` in a uniform field, by rk8 and by series.
   subroutine compare_with_series(error, moments, center, field, turns)
      type(error_type), allocatable, intent(inout) :: error
      real(wp), intent(in) :: moments(3), center(3), field(3)
      !> The space axes turn.
      logical, intent(in) :: turns
      type(problem_t), pointer :: problem
      type(state_t) :: exact, state
      type(status_t) :: status
      problem => new_problem()
      call make_body(diagonal(moments), problem%system%body, status, mass=1.0_wp, center_of_mass=center)
      call problem%system%effects%add(gravity_t(problem%system%body, field))
      if (turns) problem => rotating(problem)
      problem%start = make_state(problem%system, [0.8_wp, 0.0_wp, -0.6_wp, 0.0_wp], &
                                 20*center + [0.5_wp, 0.4_wp, 0.3_wp])
      call go(error, problem, 'taylor', .true., 1e-2_wp, 300, exact)
      if (.not. allocated(error)) call go(error, problem, 'rk8', .true., 0.05_wp, 60, state)
      call check_below(error, attitude_distance(state%q, exact%q), 1e-10_wp, "q")
      call check_close(error, state%p, exact%p, 1e-9_wp, "p")
   end subroutine compare_with_series

   subroutine every_scene_keeps_its_invariants(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      integer :: i
      allocate (scene)
      do i = 1, size(scene_names)
         call read_scene('scenes/'//trim(scene_names(i))//'.nml', scene, status, message)
         call check(error, status%ok(), message)
         call check_run(error, problem_t(scene%system, scene%initial), 'rk8', scene%plan%time_step, 2000, 1)
         if (allocated(error)) then
            error%message = trim(scene_names(i))//': '//error%message
            return
         end if
      end do
   end subroutine every_scene_keeps_its_invariants

   !> Rows at steps that are projected and at others.
   subroutine nothing_adds_up(error)
      type(error_type), allocatable, intent(out) :: error
      call check_run(error, box(), 'rk8', 0.01_wp, 1000000, 1001)
      call check_run(error, simo_top(), 'rk8', 0.01_wp, 1000000, 1001)
      call check_run(error, bruls_top(), 'rk8', 0.01_wp, 100000, 101)
      call check_run(error, rotating(bruls_top()), 'rk8', 0.01_wp, 100000, 101)
      call check_run(error, rotating(body_in_fields(3, .false.)), 'rk8', 0.01_wp, 100000, 101)
   end subroutine nothing_adds_up

   !> Compares to the last bit: no rows, a row for every step, steps by hand, and a state that is requested only now and
   !> then.
   subroutine rows_do_not_change_the_motion(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: n = 203
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(state_t) :: states(4)
      type(looker_t) :: looker
      type(status_t) :: status
      integer :: k, m
      problem => body_in_fields(2, .false.)
      do m = 1, size(spaced)
         do k = 1, 4
            states(k) = problem%start
            call get_stepper(problem, spaced(m), .true., stepper, status)
            if (k == 1) call integrate(problem%system, stepper, states(k), &
                                       run_plan_t(time_step=0.03125_wp, end_time=n*0.03125_wp, every=n), status)
            if (k == 2) call integrate(problem%system, stepper, states(k), &
                                       run_plan_t(time_step=0.03125_wp, end_time=n*0.03125_wp), status, looker)
            if (k == 3) call march(problem%system, stepper, states(k), 0.03125_wp, n, status)
            if (k == 4) call integrate_in_parts(problem, stepper, states(k), 0.03125_wp, n, status)
            call check(error, status%ok(), trim(status%message))
            call check_close(error, states(k)%q, states(1)%q, 0.0_wp, spaced(m)//" q")
            call check_close(error, states(k)%p, states(1)%p, 0.0_wp, spaced(m)//" p")
         end do
      end do
   end subroutine rows_do_not_change_the_motion

   !> Seen at every step, at times between, or at the end alone: the same bits, and the energy of the start.
   subroutine rows_do_not_change_chosen_steps(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(run_plan_t) :: plan
      type(looker_t) :: looker
      type(state_t) :: states(3)
      type(status_t) :: status
      integer :: k
      problem => body_in_fields(3, .false.)
      do k = 1, 3
         plan = run_plan_t(end_time=7.0_wp)
         plan%goal%local_tolerance = 1e-9_wp
         if (k == 3) plan%interval = 0.03125_wp
         states(k) = problem%start
         if (k == 1) call integrate(problem%system, default_settings('taylor'), states(k), plan, status)
         if (k > 1) call integrate(problem%system, default_settings('taylor'), states(k), plan, status, looker)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, states(k)%q, states(1)%q, 0.0_wp, "q")
         call check_close(error, states(k)%p, states(1)%p, 0.0_wp, "p")
      end do
      associate (energy => total_energy(problem%system, problem%start))
         call check_close(error, [total_energy(problem%system, states(1))], [energy], 1e-14_wp*abs(energy), "energy")
      end associate
   end subroutine rows_do_not_change_chosen_steps

   !> n steps by runs of 1, 2, 3, ... of them with one stepper.
   subroutine integrate_in_parts(problem, stepper, state, dt, n, status)
      type(problem_t), intent(in) :: problem
      class(stepper_t), intent(inout) :: stepper
      type(state_t), intent(inout) :: state
      !> s.
      real(wp), intent(in) :: dt
      integer, intent(in) :: n
      type(status_t), intent(inout) :: status
      integer :: done, part
      done = 0
      part = 1
      do while (done < n .and. status%ok())
         part = min(part, n - done)
         call integrate(problem%system, stepper, state, run_plan_t(time_step=dt, end_time=(done + part)*dt), status)
         done = done + part
         part = part + 1
      end do
   end subroutine integrate_in_parts

   subroutine look(self, system, state, record, status)
      class(looker_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
   end subroutine look

   !> Between two projections the state itself has the error of its steps, what is seen of it has not; both go on alike.
   subroutine seen_states_go_on(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state, seen, next
      type(status_t) :: status
      integer :: i
      problem => box()
      call get_stepper(problem, 'rk8', .true., stepper, status)
      state = problem%start
      do i = 1, 3
         call stepper%advance(problem%system, state, 0.04_wp, 0.0_wp, status)
      end do
      seen = state
      call stepper%project_for_output(problem%system, seen)
      call check(error, status%ok() .and. any(abs(seen%p - state%p) > 0.0_wp), "nothing to project")
      if (allocated(error)) return
      next = seen
      call stepper%advance(problem%system, next, 0.04_wp, 0.0_wp, status)
      call get_stepper(problem, 'rk8', .true., stepper, status)
      state = problem%start
      do i = 1, 4
         call stepper%advance(problem%system, state, 0.04_wp, 0.0_wp, status)
      end do
      call check_close(error, next%q, state%q, 0.0_wp, "q")
      call check_close(error, next%p, state%p, 0.0_wp, "p")
   end subroutine seen_states_go_on

   subroutine there_and_back(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      integer :: k
      problem => new_problem()
      do k = 1, 7
         if (k == 1) problem => free_body([0.6_wp, 0.8_wp, 1.0_wp], [1.8_wp, 0.4_wp, -0.9_wp])
         if (modulo(k, 3) == 2) problem => bruls_top()
         if (modulo(k, 3) < 2 .and. k > 1) problem => body_in_fields(2 + modulo(k, 3), .false.)
         if (k > 4) problem => rotating(problem)
         call get_stepper(problem, 'rk8', .true., stepper, status)
         state = problem%start
         call march(problem%system, stepper, state, 0.02_wp, 50, status)
         if (status%ok()) call march(problem%system, stepper, state, -0.02_wp, 50, status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, state%q, problem%start%q, 1e-11_wp, "q")
      end do
   end subroutine there_and_back

   !> Free, and hanging straight down.
   subroutine rest_stays(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      problem => free_body([0.6_wp, 0.8_wp, 1.0_wp], [0.0_wp, 0.0_wp, 0.0_wp])
      call go(error, problem, 'rk8', .true., 0.1_wp, 20, state)
      call check_close(error, state%q, problem%start%q, 0.0_wp, "free")
      problem => bruls_top()
      problem%start = make_state(problem%system, [sqrt(0.5_wp), -sqrt(0.5_wp), 0.0_wp, 0.0_wp], &
                                 [0.0_wp, 0.0_wp, 0.0_wp])
      call go(error, problem, 'rk8', .true., 0.01_wp, 20, state)
      call check_below(error, attitude_distance(state%q, problem%start%q), 1e-14_wp, "hanging")
   end subroutine rest_stays

   subroutine too_long_is_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      integer :: k
      problem => new_problem()
      do k = 1, 4
         if (k == 1) problem => box()
         if (k == 2) problem => body_in_fields(1, .false.)
         if (k > 2) problem => bruls_top()
         if (k > 3) problem => rotating(problem)
         call get_stepper(problem, 'rk8', .false., stepper, status)
         state = problem%start
         call stepper%step(problem%system, state, 100.0_wp, status)
         call check(error, status%code, NUTATE_OFF_BRANCH, trim(status%message))
         call check_close(error, [state%t, state%q, state%p], [problem%start%t, problem%start%q, problem%start%p], &
                          0.0_wp, "state")
      end do
   end subroutine too_long_is_refused

end submodule test_rk8
