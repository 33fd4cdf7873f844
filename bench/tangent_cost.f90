!> Cost of sensitivities as a ratio to the plain step of the same method: 6 by the initial state, and 12, the others by
!> parameters or by the same initial state. In each round all cases take their turns; figures are medians.
!>
!>     bench_tangent                             table
!>     bench_tangent METHOD CASE COLUMNS STEPS   takes the steps of a case alone, for a count of instructions
program bench_tangent
   use nutate, only: attitude_variation, variation_t, damping_t, dipole_t, gravity_gradient_t, integrator_settings_t, &
      inertia_variation, make_body, make_state, make_stepper, rate_variation, spring_t, state_t, status_t, stepper_t, &
      system_t, tangent_t, wp
   use nutate_body, only: diagonal
   use nutate_quaternion, only: quat_normalized
   use nutate_stopwatch, only: stopwatch_t
   use nutate_work_point, only: median
   implicit none

   integer, parameter :: rounds = 101, n_cases = 5, n_methods = 3
   character(len=8), parameter :: names(n_cases) = [character(len=8) :: 'box', 'top', 'gradient', 'spring', 'damped']
   !> The reduced form of order 2, and the others.
   character(len=16), parameter :: methods(n_methods) = [character(len=16) :: 'nielsen_krenk', 'rk8', 'taylor']
   !> Steps in a sample: short, so that what disturbs the machine meets few of them.
   integer, parameter :: repeats(n_methods) = [1600, 400, 160]
   !> Numbers of sensitivities: none, 6 by the initial state, these twice, these with six by J (-12).
   integer, parameter :: choices(4) = [0, 6, 12, -12]
   real(wp) :: samples(rounds, 4, n_cases, n_methods)
   character(len=16) :: text(4)
   integer :: i, j, k, m, method, case, columns, steps
   do i = 1, size(text)
      call get_command_argument(i, text(i))
   end do
   if (text(1) /= '') then
      read (text, *) method, case, columns, steps
      samples(1, 1, 1, 1) = time_steps(method, case, columns, steps)
      stop
   end if
   do k = 1, rounds
      do j = 1, n_methods
         do i = 1, n_cases
            do m = 1, size(choices)
               samples(k, m, i, j) = time_steps(j, i, choices(m), repeats(j))
            end do
         end do
      end do
   end do
   write (*, '(a)') 'method         scene      ns a step   6 columns  12 columns  6 and 6 of J  (over the plain step)'
   do j = 1, n_methods
      do i = 1, n_cases
         write (*, '(a,t16,a,t27,f7.0,3f12.2)') methods(j), names(i), median(samples(:, 1, i, j)), &
            (median(samples(:, m, i, j)/samples(:, 1, i, j)), m=2, 4)
      end do
   end do

contains

   !> Returns the time of a step, ns, with a number of sensitivities; negative: half of them by J.
   real(wp) function time_steps(method, case, columns, steps) result(nanoseconds)
      integer, intent(in) :: method, case, columns, steps
      type(system_t) :: system
      type(state_t) :: state, before
      type(tangent_t) :: tangent
      type(status_t) :: status
      type(stopwatch_t) :: clock
      class(stepper_t), allocatable :: stepper
      real(wp) :: dt
      integer :: i
      call define(case, system, state, dt)
      call make_stepper(system, integrator_settings_t(method=methods(method), formulation='reduced'), stepper, status)
      if (.not. status%ok()) error stop 'a method of a benchmark is refused'
      if (columns /= 0) call tangent%begin(system, state, columns_of(columns), status)
      call clock%start()
      do i = 1, steps
         if (columns /= 0) call before%copy_from(state, n_wheels=0, balance=.false.)
         call stepper%step(system, state, dt, status)
         if (columns /= 0) call stepper%propagate(system, before, state, dt, before%t + 0.5_wp*dt, tangent, status)
         if (.not. status%ok()) error stop 'a step of a benchmark failed'
      end do
      nanoseconds = 1e9_wp*clock%seconds()/steps
   end function time_steps

   !> Returns the sensitivities by the initial state, twice or with those by J.
   function columns_of(columns) result(list)
      integer, intent(in) :: columns
      type(variation_t), allocatable :: list(:)
      integer :: i
      list = [(attitude_variation(i), i=1, 3), (rate_variation(i), i=1, 3)]
      if (columns == 12) list = [list, list]
      if (columns < 0) list = [list, inertia_variation(1, 1), inertia_variation(2, 2), inertia_variation(3, 3), &
                               inertia_variation(1, 2), inertia_variation(1, 3), inertia_variation(2, 3)]
   end function columns_of

   !> Defines the scenes of the reference.
   subroutine define(case, system, start, dt)
      integer, intent(in) :: case
      type(system_t), intent(out) :: system
      type(state_t), intent(out) :: start
      !> s.
      real(wp), intent(out) :: dt
      type(status_t) :: status
      dt = 0.02_wp
      select case (case)
      case (1)
         call make_body(diagonal([5.0_wp, 20.0_wp, 17.0_wp]), system%body, status)
         start = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.1_wp, 0.0_wp, 10.0_wp])
      case (3)
         call make_body(diagonal([90.0_wp, 100.0_wp, 40.0_wp]), system%body, status)
         call system%effects%add(gravity_gradient_t(system%body, [0.0_wp, 0.0_wp, 1.0_wp], 1.0_wp))
         start = make_state(system, quat_normalized([0.9_wp, 0.3_wp, -0.1_wp, 0.3_wp]), [0.2_wp, -1.1_wp, 0.1_wp])
      case default
         call make_body(diagonal([2.0_wp, 1.5_wp, 1.0_wp]), system%body, status)
         if (case /= 4) call system%effects%add(dipole_t([0.3_wp, 0.1_wp, 1.0_wp], [0.0_wp, 0.0_wp, -1.0_wp]))
         if (case == 4) call system%effects%add(spring_t([0.1_wp, 0.2_wp, 0.5_wp], [0.3_wp, -0.4_wp, 0.9_wp], 5.0_wp, &
                                                         0.4_wp))
         if (case == 5) call system%effects%add(damping_t([0.02_wp, 0.01_wp, 0.005_wp]))
         start = make_state(system, quat_normalized([0.8_wp, 0.4_wp, -0.4_wp, 0.2_wp]), [0.4_wp, -0.3_wp, 2.0_wp])
      end select
   end subroutine define

end program bench_tangent
