!> Accumulation of rounding over many steps: no error grows in proportion to their number.
submodule(suites_of_runs) test_round_off
   use nutate_body, only: diagonal, make_body
   use nutate_dipole, only: dipole_t
   use nutate_gravity, only: gravity_t
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: integrator_settings_t, make_stepper, stepper_t
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_state, only: add_increment, state_t
   use nutate_status, only: status_t
   use nutate_steady_top, only: sleeping_spin
   use test_problems, only: box, kinetic_energy, make_state, march, new_problem, problem_t, space_momentum
   use test_support, only: check, check_below, error_type, new_unittest
   implicit none

contains

   module procedure collect_round_off
      testsuite = [ &
                  new_unittest("a sum keeps what is below the digits of its increments", sums_keep_small_parts), &
                  new_unittest("a steady spin does not lengthen q", steady_spin_keeps_norm), &
                  new_unittest("a finite J0 does not make the norm drift", finite_j0_keeps_norm), &
                  new_unittest("nor in axes that turn", finite_j0_keeps_norm_in_frame), &
                  new_unittest("a small torque does not make a fast spin drift", fast_spin_keeps_momentum), &
                  new_unittest("long turns do not make the momentum drift", long_turns_keep_momentum), &
                  new_unittest("energy is lost to the rounding of the increments alone", energy_errors_grow_slowly)]
   end procedure collect_round_off

   !> 4096 times 1/8 and, put into the compensation, 2⁻⁷⁰.
   subroutine sums_keep_small_parts(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: total, compensation
      integer :: i
      total = 1.0_wp
      compensation = 0.0_wp
      do i = 1, 4096
         compensation = compensation + 2.0_wp**(-70)
         call add_increment(total, compensation, 0.125_wp)
      end do
      call check(error, total == 513.0_wp .and. compensation == 2.0_wp**(-58), "sum of large and small parts")
   end subroutine sums_keep_small_parts

   !> In body axes each step is the same, and so is what rounding takes from 2/(1+β): it must be put back.
   subroutine steady_spin_keeps_norm(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(status_t) :: status
      real(wp), parameter :: steps(4) = [0.5_wp, 0.51_wp, 0.53_wp, 1.2_wp]
      integer :: i
      problem => new_problem()
      call make_body(diagonal([1.0_wp, 2.0_wp, 2.5_wp]), problem%system%body, status)
      problem%start = make_state(problem%system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 1.0_wp])
      do i = 1, size(steps)
         call check_norm(error, problem, 'reduced', 0.0_wp, steps(i), 200000)
      end do
      call check_norm(error, problem, 'full', 0.0_wp, 1.0_wp, 200000)
   end subroutine steady_spin_keeps_norm

   !> Rounding leaves 1e-16 of |p| of q·p, by which a finite J0 moves |q|; in the steady motion of an upright top it
   !> would be the same in every step.
   subroutine finite_j0_keeps_norm(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(status_t) :: status
      real(wp), parameter :: moments(3) = [1.0_wp, 1.0_wp, 0.25_wp], mgl = 9.81_wp
      problem => new_problem()
      call make_body(diagonal(moments), problem%system%body, status, mass=1.0_wp, &
                     center_of_mass=[0.0_wp, 0.0_wp, 1.0_wp])
      call problem%system%effects%add(gravity_t(problem%system%body, [0.0_wp, 0.0_wp, -mgl]))
      problem%start = make_state(problem%system, [1.0_wp, 0.5e-10_wp, 0.0_wp, 0.0_wp], &
                                 [0.0_wp, 0.0_wp, 1.05_wp*sleeping_spin(moments(1), moments(3), mgl)])
      call check_norm(error, problem, 'full', 0.1_wp, 0.01_wp, 50000)
   end subroutine finite_j0_keeps_norm

   !> A dipole in a frame, J0 finite and infinite: a correction of q·p made twice would leave it as it was, with the
   !> other sign, and roundings to add up.
   subroutine finite_j0_keeps_norm_in_frame(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: solvers(3) = ['full   ', 'full   ', 'reduced']
      type(problem_t), pointer :: problem
      type(status_t) :: status
      integer :: i, order
      problem => new_problem()
      call make_body(diagonal([1.0_wp, 2.0_wp, 2.5_wp]), problem%system%body, status)
      call problem%system%effects%add(rotating_frame_t(name='rotating_frame', rate=[0.2_wp, -0.3_wp, 0.5_wp]))
      call problem%system%effects%add(dipole_t([0.5_wp, 1.0_wp, 2.0_wp], [0.0_wp, 0.0_wp, 1.0_wp]))
      problem%start = make_state(problem%system, [0.8_wp, 0.36_wp, 0.48_wp, 0.0_wp], [1.0_wp, -0.5_wp, 0.8_wp])
      do order = 2, 4, 2
         do i = 1, size(solvers)
            call check_norm(error, problem, trim(solvers(i)), merge(1.0_wp, 0.0_wp, i == 1), 0.05_wp, 20000, order)
         end do
      end do
   end subroutine finite_j0_keeps_norm_in_frame

   !> A top at 1e6 rad/s, a steady spin but for 1e-11 of its momentum in a step.
   subroutine fast_spin_keeps_momentum(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(status_t) :: status
      problem => new_problem()
      call make_body(diagonal([1.0_wp, 1.0_wp, 0.25_wp]), problem%system%body, status, mass=1.0_wp, &
                     center_of_mass=[0.0_wp, 0.0_wp, 1.0_wp])
      call problem%system%effects%add(gravity_t(problem%system%body, [0.0_wp, 0.0_wp, -9.81_wp]))
      problem%start = make_state(problem%system, [cos(0.25_wp), sin(0.25_wp), 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 1e6_wp])
      call check_norm(error, problem, 'full', 0.0_wp, 1e-6_wp, 100000)
      call check_norm(error, problem, 'reduced', 0.0_wp, 1e-6_wp, 100000)
   end subroutine fast_spin_keeps_momentum

   !> Steps of 3.9 rad, close to the end of the branch, of a top at 1e6 rad/s: what rounding leaves of q·p must go along
   !> q of the end of the step. Along that of its start, half a turn away, it changes the momentum by as much, 1e-15, in
   !> every step.
   subroutine long_turns_keep_momentum(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(status_t) :: status
      type(integrator_settings_t) :: settings
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      integer, parameter :: n = 5000
      real(wp) :: before, after
      integer :: i
      problem => new_problem()
      call make_body(diagonal([1.0_wp, 1.0_wp, 0.25_wp]), problem%system%body, status, mass=1.0_wp, &
                     center_of_mass=[0.0_wp, 0.0_wp, 1.0_wp])
      call problem%system%effects%add(gravity_t(problem%system%body, [0.0_wp, 0.0_wp, -9.81_wp]))
      state = make_state(problem%system, [cos(0.25_wp), sin(0.25_wp), 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 1e6_wp])
      settings%inverse_auxiliary_inertia = 0.1_wp
      call make_stepper(problem%system, settings, stepper, status)
      before = vertical_momentum(state)
      do i = 1, n
         if (status%ok()) call stepper%step(problem%system, state, 3.90625e-6_wp, status)
      end do
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      after = vertical_momentum(state)
      ! The rounding of p and of its turn, at random: 4 of each.
      call check_below(error, abs(after/before - 1), 8*eps*sqrt(real(n, wp)), 'drift of the vertical momentum')
   end subroutine long_turns_keep_momentum

   !> l₃, N m s.
   real(wp) function vertical_momentum(state)
      type(state_t), intent(in) :: state
      real(wp) :: l(3)
      l = space_momentum(state)
      vertical_momentum = l(3)
   end function vertical_momentum

   !> Root of the mean square of the error of energy after n steps, over many starts and steps of about 0.5 rad: an
   !> increment of p, a fifth of |p|, has 2e-17 of rounding in each component. Taken from a momentum that is rounded
   !> itself it has 1e-16.
   subroutine energy_errors_grow_slowly(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=7), parameter :: solvers(2) = [character(len=7) :: 'full', 'reduced']
      integer, parameter :: runs = 24, n = 10000
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: start, squares
      integer :: i, k
      problem => box()
      do k = 1, size(solvers)
         squares = 0.0_wp
         do i = 1, runs
            state = make_state(problem%system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.1_wp + 1e-3_wp*i, 0.0_wp, 10.0_wp])
            start = kinetic_energy(problem%system, state)
            call make_stepper(problem%system, integrator_settings_t(formulation=solvers(k)), stepper, status)
            call march(problem%system, stepper, state, 0.05_wp + 1e-5_wp*i, n, status)
            call check(error, status%ok(), status%message)
            squares = squares + (kinetic_energy(problem%system, state)/start - 1)**2
         end do
         call check_below(error, sqrt(squares/runs), 7e-17_wp*sqrt(real(n, wp)), solvers(k)//': energy')
      end do
   end subroutine energy_errors_grow_slowly

   !> |q|² and, the spins being steady, |p|² stay within the random walk of roundings, and q·p within some.
   subroutine check_norm(error, problem, solver, inverse_j0, dt, n, order)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      character(len=*), intent(in) :: solver
      !> kg⁻¹ m⁻²; s
      real(wp), intent(in) :: inverse_j0, dt
      integer, intent(in) :: n
      !> Order of the method; present for a motion that is no steady spin.
      integer, intent(in), optional :: order
      class(stepper_t), allocatable :: stepper
      type(integrator_settings_t) :: settings
      type(state_t) :: state
      type(status_t) :: status
      character(len=16) :: label
      settings%formulation = solver
      settings%inverse_auxiliary_inertia = inverse_j0
      if (present(order)) settings%order = order
      call make_stepper(problem%system, settings, stepper, status)
      state = problem%start
      call march(problem%system, stepper, state, dt, n, status)
      call check(error, status%ok(), status%message)
      write (label, '(a,es8.1,a)') 'Δt', dt, ' s'
      call check_below(error, abs(dot_product(state%q, state%q) - dot_product(problem%start%q, problem%start%q)), &
                       2*eps*sqrt(real(n, wp)), label//': |q|²')
      if (.not. present(order)) call check_below( &
         error, abs(dot_product(state%p, state%p)/dot_product(problem%start%p, problem%start%p) - 1), &
         2*eps*sqrt(real(n, wp)), label//': |p|²')
      if (allocated(error) .or. solver == 'reduced') return
      call check_below(error, abs(dot_product(state%q, state%p)), 4*eps*norm2(state%p), label//': q·p')
   end subroutine check_norm

end submodule test_round_off
