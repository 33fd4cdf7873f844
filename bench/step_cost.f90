!> Cost of a step as a ratio to one solution of an 8×8 system by the linked LAPACK (`dgesv`), measured in the same run.
!>
!> In each round the yardstick and every case take their turns; the figures are medians over the rounds.
program bench_step
   use bench_timing, only: mean_iterations, time_dgesv, time_steps
   use nutate, only: applied_torque_t, damping_t, dipole_t, effect_t, gravity_gradient_t, gravity_t, &
      integrator_settings_t, make_body, make_shape_body, make_state, rotor_t, spring_t, state_t, status_t, system_t, &
      wp
   use nutate_body, only: diagonal
   use nutate_work_point, only: median
   implicit none

   !> One line of the table.
   type :: case_t
      character(len=32) :: name = ''
      type(system_t) :: system
      type(state_t) :: start
      !> s.
      real(wp) :: dt = 0.01_wp
      !> True if something depends on the attitude.
      logical :: attitude = .true.
   end type case_t

   integer, parameter :: rounds = 15, repeats = 4000
   real(wp), parameter :: still(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
   type(case_t) :: cases(12)
   type(system_t) :: plain, all_effects
   !> Times, ns: the yardstick, a step 8×8, reduced, and reduced without the attitude.
   real(wp), allocatable :: samples(:, :, :)
   integer :: i, k, n

   n = 0
   call define_cases()
   allocate (samples(rounds, 0:3, n), source=0.0_wp)
   do k = 1, rounds
      do i = 1, n
         samples(k, :, i) = measure(cases(i))
      end do
   end do
   write (*, '("One dgesv of an 8x8 system takes ",f0.0," ns (median). A step in units of it:",/)') &
      median([(samples(:, 0, i), i=1, n)])
   write (*, '(a,t28,a,t38,a,t48,a,t62,a)') 'scene', '   8x8', 'reduced', 'no attitude', &
      'ns per step (iterations) 8x8, reduced'
   do i = 1, n
      call write_case(cases(i), samples(:, :, i))
   end do

contains

   !> Defines the yardstick's cases, then one body with each effect alone and with all of them.
   subroutine define_cases()
      type(system_t) :: system
      type(status_t) :: status
      call make_shape_body('box', [4.0_wp, 1.0_wp, 2.0_wp], system%body, status, mass=12.0_wp)
      call add_case('box, step 0.01', system, [0.1_wp, 0.0_wp, 10.0_wp], 0.01_wp, .false.)
      call make_body(diagonal([0.234375_wp, 0.46875_wp, 0.234375_wp]), system%body, status, mass=15.0_wp, &
                     center_of_mass=[0.0_wp, 1.0_wp, 0.0_wp], about_center_of_mass=.true.)
      call system%effects%add(gravity_t(system%body, [0.0_wp, 0.0_wp, -9.81_wp]))
      call add_case('heavy top, step 0.001', system, [0.0_wp, 150.0_wp, -4.61538_wp], 0.001_wp, .true.)
      call make_body(diagonal([4.0_wp, 5.0_wp, 6.0_wp]), plain%body, status, mass=2.0_wp, &
                     center_of_mass=[0.1_wp, -0.2_wp, 0.3_wp])
      all_effects = plain
      call add_case('no effect', plain, [1.0_wp, 2.0_wp, 3.0_wp], 0.01_wp, .false.)
      call add_effect(gravity_t(plain%body, [0.0_wp, 0.0_wp, -9.81_wp]), .true.)
      call add_effect(dipole_t([0.5_wp, 0.2_wp, -0.1_wp], [1.0_wp, 0.0_wp, 2.0_wp]), .true.)
      call add_effect(gravity_gradient_t(plain%body, [1.0_wp, 1.0_wp, 0.0_wp], 0.2_wp), .true.)
      call add_effect(spring_t([0.5_wp, 0.0_wp, 0.5_wp], [2.0_wp, 1.0_wp, 0.0_wp], 3.0_wp, 0.5_wp), .true.)
      call add_effect(damping_t([1e-3_wp, 2e-3_wp, 3e-3_wp]), .false.)
      call add_effect(applied_torque_t(name='torque', amplitude=[0.1_wp, 0.0_wp, 0.2_wp], frequency=0.3_wp), .false.)
      call add_effect(rotor_t(name='rotor', momentum=[0.0_wp, 1.0_wp, 3.0_wp]), .false.)
      call add_case('all of them', all_effects, [1.0_wp, 2.0_wp, 3.0_wp], 0.01_wp, .true.)
   end subroutine define_cases

   subroutine add_case(name, system, omega, dt, attitude)
      character(len=*), intent(in) :: name
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: omega(3), dt
      logical, intent(in) :: attitude
      n = n + 1
      cases(n)%name = name
      cases(n)%system = system
      cases(n)%start = make_state(system, still, omega)
      cases(n)%dt = dt
      cases(n)%attitude = attitude
   end subroutine add_case

   subroutine add_effect(effect, attitude)
      class(effect_t), intent(in) :: effect
      logical, intent(in) :: attitude
      type(system_t) :: system
      system = plain
      call system%effects%add(effect)
      call all_effects%effects%add(effect)
      call add_case('only '//trim(effect%name), system, [1.0_wp, 2.0_wp, 3.0_wp], 0.01_wp, attitude)
   end subroutine add_effect

   !> Returns times, ns: the yardstick, a step 8×8, reduced, reduced without the attitude (0 if something depends on
   !> it).
   function measure(item) result(cost)
      type(case_t), intent(in) :: item
      real(wp) :: cost(0:3)
      cost(0) = time_dgesv()
      cost(1) = time_steps(item%system, item%start, settings('full'), item%dt, repeats)
      cost(2) = time_steps(item%system, item%start, settings('reduced'), item%dt, repeats)
      cost(3) = 0.0_wp
      if (item%attitude) return
      cost(3) = time_steps(item%system, item%start, integrator_settings_t(formulation='reduced', attitude=.false.), &
                           item%dt, repeats)
   end function measure

   subroutine write_case(item, sample)
      type(case_t), intent(in) :: item
      real(wp), intent(in) :: sample(:, 0:)
      character(len=8) :: free
      free = '-'
      if (.not. item%attitude) write (free, '(f6.2)') median(sample(:, 3)/sample(:, 0))
      write (*, '(a,t26,f8.2,f10.2,t48,a,t60,2(f9.0," (",f0.1,")"))') trim(item%name), &
         median(sample(:, 1)/sample(:, 0)), median(sample(:, 2)/sample(:, 0)), free, &
         median(sample(:, 1)), mean_iterations(item%system, item%start, settings('full'), item%dt, repeats), &
         median(sample(:, 2)), mean_iterations(item%system, item%start, settings('reduced'), item%dt, repeats)
   end subroutine write_case

   type(integrator_settings_t) function settings(solver)
      character(len=*), intent(in) :: solver
      settings%formulation = solver
   end function settings

end program bench_step
