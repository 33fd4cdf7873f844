!> Sensitivities against steps in 50 digits (test/tangent_steps.csv), and what they keep.
submodule(suites_of_effects) test_tangent
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_body, only: diagonal, make_body
   use nutate_variation, only: attitude_variation, variation_t, inertia_variation, rate_variation
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: eps, wp
   use nutate_methods, only: integrator_settings_t, make_stepper, stepper_t
   use nutate_orbital_gradient, only: orbital_gradient_t
   use nutate_quaternion, only: quat_normalized
   use nutate_run, only: run_t
   use nutate_run_plan, only: run_plan_t
   use nutate_spring, only: spring_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_tangent, only: tangent_t
   use test_problems, only: body_momentum, make_state, new_problem, problem_t, system_t
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   character(len=7), parameter :: forms(2) = ['reduced', 'full   ']

contains

   module procedure collect_tangent
      testsuite = [ &
                  new_unittest("columns are those of steps in 50 digits", follow_reference), &
                  new_unittest("states do not depend on columns", leave_states), &
                  new_unittest("columns do not depend on how many there are", count_columns), &
                  new_unittest("a step back is the inverse of the step", go_back)]
   end procedure collect_tangent

   !> A scene of the reference.
   function scene_of(name) result(problem)
      character(len=*), intent(in) :: name
      type(problem_t), pointer :: problem
      type(status_t) :: status
      type(kepler_orbit_t) :: path
      problem => new_problem()
      associate (system => problem%system, start => problem%start)
         select case (name)
         case ('box')
            call make_body(diagonal([5.0_wp, 20.0_wp, 17.0_wp]), system%body, status)
            start = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.1_wp, 0.0_wp, 10.0_wp])
         case ('top')
            call make_body(diagonal([2.0_wp, 1.5_wp, 1.0_wp]), system%body, status)
            call system%effects%add(dipole_t([0.3_wp, 0.1_wp, 1.0_wp], [0.0_wp, 0.0_wp, -1.0_wp]))
            start = make_state(system, quat_normalized([0.8_wp, 0.4_wp, -0.4_wp, 0.2_wp]), [0.4_wp, -0.3_wp, 2.0_wp])
         case ('gradient')
            call make_body(diagonal([90.0_wp, 100.0_wp, 40.0_wp]), system%body, status)
            call system%effects%add(gravity_gradient_t(system%body, [0.0_wp, 0.0_wp, 1.0_wp], 1.0_wp))
            start = make_state(system, quat_normalized([0.9_wp, 0.3_wp, -0.1_wp, 0.3_wp]), [0.2_wp, -1.1_wp, 0.1_wp])
         case ('damped')
            call make_body(diagonal([2.0_wp, 1.5_wp, 1.0_wp]), system%body, status)
            call system%effects%add(dipole_t([0.3_wp, 0.0_wp, 1.0_wp], [0.0_wp, 0.6_wp, -0.8_wp]))
            call system%effects%add(damping_t([0.2_wp, 0.1_wp, 0.05_wp]))
            start = make_state(system, quat_normalized([0.7_wp, 0.1_wp, 0.5_wp, -0.5_wp]), [1.0_wp, -0.5_wp, 0.8_wp])
         case ('spring')
            call make_body(diagonal([2.0_wp, 1.5_wp, 1.0_wp]), system%body, status)
            call system%effects%add(spring_t([0.1_wp, 0.2_wp, 0.5_wp], [0.3_wp, -0.4_wp, 0.9_wp], 5.0_wp, 0.4_wp))
            start = make_state(system, quat_normalized([0.9_wp, -0.3_wp, 0.1_wp, 0.3_wp]), [0.5_wp, 1.0_wp, 3.0_wp])
         case ('hyperion')
            call make_body(diagonal([0.5_wp, 0.764033333333333_wp, 1.0_wp]), system%body, status)
            path%mu = 1.0_wp
            path%semi_major_axis = 1.0_wp
            path%eccentricity = 0.1_wp
            call system%effects%add(orbital_gradient_t(system%body, path))
            start = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 1.0_wp])
         case default
            error stop 'no such scene'
         end select
      end associate
   end function scene_of

   !> The column that the reference calls so.
   type(variation_t) function variation_of(system, name) result(column)
      type(system_t), intent(in) :: system
      character(len=*), intent(in) :: name
      type(status_t) :: status
      real(wp) :: change(3)
      integer :: axis
      axis = index('123', name(len_trim(name):len_trim(name)))
      change = 0.0_wp
      if (axis > 0) change(axis) = 1.0_wp
      select case (name(:max(1, len_trim(name) - 1)))
      case ('theta')
         column = attitude_variation(axis)
      case ('L')
         column = rate_variation(axis)
         column%angular_velocity = system%body%inverse_inertia(:, axis)
      case ('Jx')
         column = inertia_variation(1, 1)
      case ('Jy')
         column = inertia_variation(2, 2)
      case ('Jz')
         column = inertia_variation(3, 3)
      case ('m')
         call column%add(system%effects, 'dipole', 1, 'moment', change, status)
      case ('strengt')
         call column%add(system%effects, 'gravity_gradient', 1, 'strength', [1.0_wp], status)
      case ('damping')
         call column%add(system%effects, 'damping', 1, 'coefficient', change, status)
      case ('stiffnes')
         call column%add(system%effects, 'spring', 1, 'stiffness', [1.0_wp], status)
      case ('rest_lengt')
         call column%add(system%effects, 'spring', 1, 'rest_length', [1.0_wp], status)
      case ('body_point')
         call column%add(system%effects, 'spring', 1, 'body_point', change, status)
      case ('anchor')
         call column%add(system%effects, 'spring', 1, 'anchor', change, status)
      case default
         status%code = 1
      end select
      column%name = name
      if (.not. status%ok()) column%name = 'none'
   end function variation_of

   !> Settings of a form and an order.
   pure type(integrator_settings_t) function settings_of(form, order) result(settings)
      character(len=*), intent(in) :: form
      integer, intent(in) :: order
      settings%method = 'nielsen_krenk'
      settings%formulation = form
      settings%order = order
   end function settings_of

   !> One to six columns of the start are to the last bit the first of six: steps move them in pairs. Beside a column of
   !> a parameter, by the way of these, they are the same to round-off: measured 0.9 units at most.
   subroutine count_columns(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=8), parameter :: scenes(5) = [character(len=8) :: 'box', 'top', 'gradient', 'damped', 'spring']
      type(problem_t), pointer :: problem
      type(variation_t) :: columns(7)
      type(tangent_t) :: all_six, some
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: unit
      integer :: i, n
      do i = 1, size(scenes)
         problem => scene_of(trim(scenes(i)))
         columns = [(attitude_variation(n), n=1, 3), (rate_variation(n), n=1, 3), inertia_variation(1, 2)]
         do n = 6, 1, -1
            state = problem%start
            call some%begin(problem%system, state, columns(:n), status)
            call take_steps(problem%system, settings_of('reduced', 2), state, some, 0.02_wp, 20, status)
            call check(error, status%ok(), trim(scenes(i)))
            if (n == 6) all_six = some
            call check(error, all(abs(some%theta - all_six%theta(:n, :)) <= 0.0_wp), trim(scenes(i))//', turns')
            call check(error, all(abs(some%momentum - all_six%momentum(:n, :)) <= 0.0_wp), trim(scenes(i))//', momenta')
            call check(error, all(abs(some%work - all_six%work(:n)) <= 0.0_wp), trim(scenes(i))//', works')
         end do
         state = problem%start
         call some%begin(problem%system, state, columns, status)
         call take_steps(problem%system, settings_of('reduced', 2), state, some, 0.02_wp, 20, status)
         ! Rounding of θ, and of δL, which turns the body by J⁻¹ in each unit of time.
         unit = eps*(maxval(abs(all_six%theta)) + maxval(abs(problem%system%body%inverse_inertia)) &
                     *maxval(abs(all_six%momentum)))
         call check_below(error, maxval(abs(some%theta(:6, :) - all_six%theta)), 5*unit, &
                          trim(scenes(i))//', turns beside a parameter')
         call check_below(error, maxval(abs(some%work(:6) - all_six%work)), 5*eps*maxval(abs(all_six%momentum)), &
                          trim(scenes(i))//', works beside a parameter')
      end do
   end subroutine count_columns

   !> A state and its columns after steps.
   subroutine take_steps(system, settings, state, tangent, time_step, steps, status)
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(state_t), intent(inout) :: state
      type(tangent_t), intent(inout) :: tangent
      real(wp), intent(in) :: time_step
      integer, intent(in) :: steps
      type(status_t), intent(out) :: status
      class(stepper_t), allocatable :: stepper
      type(state_t) :: before
      integer :: i
      call make_stepper(system, settings, stepper, status)
      do i = 1, steps
         if (.not. status%ok()) return
         before = state
         call stepper%step(system, state, time_step, status)
         if (status%ok()) call stepper%propagate(system, before, state, time_step, before%t + 0.5_wp*time_step, &
            tangent, &
                                             status)
      end do
   end subroutine take_steps

   !> Reads the reference block by block: the lines of one scene, order and number of steps.
   subroutine follow_reference(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=400) :: line
      character(len=12) :: fields(4), block(4)
      character(len=12) :: names(24)
      real(wp) :: numbers(6), rows(6, 24)
      integer :: unit, io, n, at(4), i, blocks
      open (newunit=unit, file='test/tangent_steps.csv', status='old', action='read', iostat=io)
      call check(error, io, 0, 'test/tangent_steps.csv')
      if (allocated(error)) return
      read (unit, '(a)') line
      n = 0
      blocks = 0
      block = ''
      do
         read (unit, '(a)', iostat=io) line
         if (io == 0) then
            at(1) = index(line, ',')
            do i = 2, 4
               at(i) = at(i - 1) + index(line(at(i - 1) + 1:), ',')
            end do
            fields = [character(len=12) :: line(:at(1) - 1), line(at(1) + 1:at(2) - 1), line(at(2) + 1:at(3) - 1), &
                      line(at(3) + 1:at(4) - 1)]
         end if
         if (io /= 0 .or. any(fields /= block)) then
            if (n > 0) then
               call compare_block(error, block, names(:n), rows(:, :n))
               blocks = blocks + 1
            end if
            n = 0
            block = fields
         end if
         if (io /= 0 .or. allocated(error)) exit
         n = n + 1
         line = line(at(4) + 1:)
         names(n) = line(:index(line, ',') - 1)
         numbers = 0.0_wp
         read (line(index(line, ',') + 1:), *) numbers(:merge(4, merge(3, 6, names(n) == 'state L'), &
                                                              names(n) == 'state q'))
         rows(:, n) = numbers
      end do
      close (unit)
      call check(error, blocks, 30, 'blocks of the reference')
   end subroutine follow_reference

   !> All columns of one block, by both forms, to 1e-12 of the largest entry.
   subroutine compare_block(error, block, names, rows)
      type(error_type), allocatable, intent(inout) :: error
      !> Scene, order, step, number of steps.
      character(len=*), intent(in) :: block(4), names(:)
      !> θ and δL of each column, of the states q and L; shape (6, n).
      real(wp), intent(in) :: rows(:, :)
      type(problem_t), pointer :: problem
      type(variation_t) :: columns(size(names) - 2)
      type(tangent_t) :: tangent
      type(status_t) :: status
      type(state_t) :: state
      real(wp) :: time_step, largest
      character(len=80) :: label
      integer :: order, steps, k, form
      problem => scene_of(trim(block(1)))
      read (block(2), *) order
      read (block(3), *) time_step
      read (block(4), *) steps
      do k = 1, size(columns)
         columns(k) = variation_of(problem%system, trim(names(k + 2)))
         call check(error, columns(k)%name /= 'none', 'no column '//names(k + 2))
      end do
      largest = maxval(abs(rows(:, 3:)))
      do form = 1, 2
         state = problem%start
         call tangent%begin(problem%system, state, columns, status)
         if (status%ok()) call take_steps(problem%system, settings_of(forms(form), order), state, tangent, time_step, &
                                          steps, status)
         call check(error, status%ok(), status%message)
         if (allocated(error)) return
         label = trim(block(1))//' '//trim(block(2))//' '//trim(block(4))//' '//forms(form)
         call check_close(error, state%q, rows(1:4, 1), 1e-13_wp, trim(label)//' q')
         call check_close(error, body_momentum(state), rows(1:3, 2), 1e-12_wp*maxval(abs(rows(1:3, 2))), &
                          trim(label)//' L')
         do k = 1, size(columns)
            call check_close(error, [tangent%theta(k, :), tangent%momentum(k, :)], rows(:, k + 2), 1e-12_wp*largest, &
                             trim(label)//' '//trim(names(k + 2)))
         end do
      end do
   end subroutine compare_block

   !> The states of runs with columns have the bits of those without.
   subroutine leave_states(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=8), parameter :: scenes(6) = [character(len=8) :: 'box', 'top', 'gradient', 'damped', 'spring', &
                                                  'hyperion']
      type(problem_t), pointer :: problem
      type(run_plan_t) :: plan
      class(run_t), allocatable :: runs(:)
      type(status_t) :: status
      integer :: i, k, order, form
      allocate (runs(2))
      plan%time_step = 0.1_wp
      plan%end_time = 10.04_wp
      do i = 1, size(scenes)
         do order = 2, 4, 2
            do form = 1, 2
               problem => scene_of(trim(scenes(i)))
               do k = 1, 2
                  call runs(k)%begin(problem%system, settings_of(forms(form), order), problem%start, plan, status)
                  if (k == 2 .and. status%ok()) &
                     call runs(k)%differentiate([attitude_variation(1), rate_variation(2)], problem%system, status)
                  if (status%ok()) call runs(k)%run_to_end(problem%system, status)
                  call check(error, status%ok(), trim(scenes(i))//': '//status%message)
                  if (allocated(error)) return
               end do
               associate (one => runs(1)%state, other => runs(2)%state)
                  call check(error, maxval(abs([one%q - other%q, one%p - other%p, one%q_compensation &
                                                - other%q_compensation, one%p_compensation - other%p_compensation])) &
                             <= 0.0_wp, 'the state of '//trim(scenes(i)))
               end associate
               call check(error, maxval(abs(runs(2)%tangent%theta(1, :))) > 0.5_wp, 'columns of the run')
            end do
         end do
      end do
   end subroutine leave_states

   !> M(x1, -Δt) M(x0, Δt) = 1.
   subroutine go_back(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=8), parameter :: scenes(6) = [character(len=8) :: 'box', 'top', 'gradient', 'damped', 'spring', &
                                                  'hyperion']
      integer, parameter :: orders(4) = [2, 4, 6, 8]
      type(problem_t), pointer :: problem
      type(variation_t) :: columns(6)
      type(tangent_t) :: tangent
      type(status_t) :: status
      type(state_t) :: state
      real(wp) :: matrix(6, 6), largest
      integer :: i, k, m, form
      do i = 1, size(scenes)
         do m = 1, size(orders)
            do form = 1, 2
               problem => scene_of(trim(scenes(i)))
               do k = 1, 3
                  columns(k) = attitude_variation(k)
                  columns(3 + k) = rate_variation(k)
               end do
               state = problem%start
               call tangent%begin(problem%system, state, columns, status)
               call take_steps(problem%system, settings_of(forms(form), orders(m)), state, tangent, 0.1_wp, 5, status)
               largest = max(maxval(abs(tangent%theta)), maxval(abs(tangent%momentum)))
               if (status%ok()) call take_steps(problem%system, settings_of(forms(form), orders(m)), state, tangent, &
                                                -0.1_wp, 5, status)
               call check(error, status%ok(), trim(scenes(i))//': '//status%message)
               if (allocated(error)) return
               matrix(:, :3) = tangent%theta
               matrix(:, 4:) = tangent%momentum
               matrix(4:, 4:) = matmul(problem%system%body%inverse_inertia, matrix(4:, 4:))
               do k = 1, 6
                  matrix(k, k) = matrix(k, k) - 1
               end do
               call check_below(error, maxval(abs(matrix)), 1e-13_wp*largest**2, trim(scenes(i))//' '//forms(form))
            end do
         end do
      end do
   end subroutine go_back

end submodule test_tangent
