!> Sensitivities of the explicit methods: differences of their own steps in the variables that they choose, their
!> order, that of the conserving step too, and flows of the reference.
submodule(suites_of_effects) test_tangent_explicit
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_body, only: diagonal, make_body
   use nutate_variation, only: attitude_variation, variation_t, inertia_variation, rate_variation
   use nutate_dipole, only: dipole_t
   use nutate_invariants, only: ALL_COMPONENTS, ALONG_AXIS, conserved_momentum
   use nutate_kinds, only: wp
   use nutate_methods, only: integrator_settings_t, make_stepper, stepper_t
   use nutate_quaternion, only: quat_conjugate, quat_exp, quat_normalized, quat_product, rotate_to_body
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_run, only: run_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_tangent, only: tangent_t
   use test_problems, only: body_momentum, make_state, new_system, system_t
   use test_support, only: check, check_below, check_close, error_type, new_unittest, random_unit, random_vector
   implicit none

   character(len=12), parameter :: scenes(10) = [character(len=12) :: 'box', 'box frame', 'top', 'top tilted', &
      'top frame', &
                                                 'two fields', 'two frame', 'spin 1', 'spin 2', 'spin 3']
   character(len=8), parameter :: methods(3) = [character(len=8) :: 'rk4', 'rk8', 'dop853']

   !> The numbers that a scene is made of.
   type :: start_t
      real(wp) :: turn(3) = 0.0_wp, rate(3) = [0.9_wp, -1.3_wp, 2.1_wp], moments(3) = [2.0_wp, 1.5_wp, 1.0_wp]
      real(wp) :: dipole(3) = [0.9_wp, -0.3_wp, 1.5_wp], frame(3) = [0.3_wp, 0.2_wp, -0.4_wp]
   end type start_t

contains

   module procedure collect_tangent_explicit
      testsuite = [ &
                  new_unittest("columns are differences of the steps", differ), &
                  new_unittest("columns of the start are the same beside those of parameters", stand_alone), &
                  new_unittest("columns converge as the method", converge), &
                  new_unittest("columns of conserving steps have their orders", converge_composed), &
                  new_unittest("columns are those of flows in 50 digits", follow_flows), &
                  new_unittest("projected columns keep what the states keep", keep_rows), &
                  new_unittest("projected states do not depend on columns", leave_states), &
                  new_unittest("columns of the closed solution are its differences", differ_exact), &
                  new_unittest("the closed solution and rk8 have the same columns", compare_exact), &
                  new_unittest("columns of series are differences of their states", differ_series)]
   end procedure collect_tangent_explicit

   !> A scene.
   subroutine build(name, start, system, state)
      character(len=*), intent(in) :: name
      type(start_t), intent(in) :: start
      type(system_t), intent(out) :: system
      type(state_t), intent(out) :: state
      type(status_t) :: status
      real(wp) :: moments(3), dipole(3), field(3)
      integer :: axis
      moments = start%moments
      dipole = start%dipole
      field = [0.0_wp, 0.0_wp, -2.0_wp]
      if (name == 'top tilted' .or. name == 'top frame') field = [0.6_wp, -1.0_wp, 0.5_wp]
      axis = index('123', name(len_trim(name):len_trim(name)))
      if (axis > 0) then
         ! The last two moments are one number.
         moments = cshift([start%moments(3), start%moments(1), start%moments(1)], 1 - axis)
         dipole = cshift([start%dipole(3), 0.0_wp, 0.0_wp], 1 - axis)
      end if
      call make_body(diagonal(moments), system%body, status)
      if (index(name, 'box') == 0) call system%effects%add(dipole_t(dipole, field))
      if (index(name, 'two') > 0) call system%effects%add(dipole_t([0.2_wp, 0.5_wp, -0.4_wp], [1.0_wp, 0.5_wp, &
         0.3_wp]))
      if (index(name, 'frame') > 0) call system%effects%add(rotating_frame_t(name='rotating_frame', rate=start%frame))
      state = make_state(system, quat_product(quat_normalized([0.7_wp, 0.4_wp, -0.5_wp, 0.2_wp]), &
                                              quat_exp(0.5_wp*start%turn)), start%rate)
   end subroutine build

   !> A state, and columns if they are wanted, after steps.
   subroutine follow(name, start, settings, time_step, steps, state, columns, tangent, error)
      character(len=*), intent(in) :: name
      type(start_t), intent(in) :: start
      type(integrator_settings_t), intent(in) :: settings
      real(wp), intent(in) :: time_step
      integer, intent(in) :: steps
      type(state_t), intent(out) :: state
      type(variation_t), intent(in), optional :: columns(:)
      type(tangent_t), intent(inout), optional :: tangent
      type(error_type), allocatable, intent(inout) :: error
      class(stepper_t), allocatable :: stepper
      type(system_t), pointer :: system
      type(status_t) :: status
      type(state_t) :: before
      integer :: i
      system => new_system()
      call build(name, start, system, state)
      call make_stepper(system, settings, stepper, status)
      if (present(columns) .and. status%ok()) call tangent%begin(system, state, columns, status)
      do i = 1, steps
         if (.not. status%ok()) exit
         before = state
         call stepper%step(system, state, time_step, status)
         if (status%ok() .and. present(columns)) &
            call stepper%propagate(system, before, state, time_step, before%t + 0.5_wp*time_step, tangent, status)
      end do
      call check(error, status%ok(), name//': '//status%message)
   end subroutine follow

   !> The columns of a scene: of the start, the moments, the dipole and the frame, with starts to differ by.
   subroutine list_variations(name, columns, starts, shift)
      character(len=*), intent(in) :: name
      type(variation_t), allocatable, intent(out) :: columns(:)
      type(start_t), allocatable, intent(out) :: starts(:, :)
      real(wp), intent(in) :: shift
      real(wp), parameter :: parts(4) = [1.0_wp, -1.0_wp, 0.5_wp, -0.5_wp]
      type(system_t), pointer :: system
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: unit(3)
      integer :: i, k, n
      system => new_system()
      call build(name, start_t(), system, state)
      n = 9
      if (index(name, 'box') == 0) n = 12
      if (name == 'box frame') n = 12
      if (index(name, 'spin') > 0) n = 6
      allocate (columns(n), starts(4, n))
      do k = 1, 3
         unit = 0.0_wp
         unit(k) = 1.0_wp
         columns(k) = attitude_variation(k)
         columns(3 + k) = rate_variation(k)
         if (n > 6) columns(6 + k) = inertia_variation(k, k)
         if (name == 'box frame') columns(9 + k)%frame = unit
         if (n == 12 .and. name /= 'box frame') call columns(9 + k)%add(system%effects, 'dipole', 1, 'moment', &
            unit, status)
         do i = 1, 4
            starts(i, k)%turn(k) = parts(i)*shift
            starts(i, 3 + k)%rate(k) = starts(i, 3 + k)%rate(k) + parts(i)*shift
            if (n > 6) starts(i, 6 + k)%moments(k) = starts(i, 6 + k)%moments(k) + parts(i)*shift
            if (n < 12) cycle
            if (name == 'box frame') then
               starts(i, 9 + k)%frame(k) = starts(i, 9 + k)%frame(k) + parts(i)*shift
            else
               starts(i, 9 + k)%dipole(k) = starts(i, 9 + k)%dipole(k) + parts(i)*shift
            end if
         end do
      end do
   end subroutine list_variations

   !> All columns of all scenes: of steps so long that another step of the same order would be seen.
   subroutine differ(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: shift = 2e-3_wp
      type(variation_t), allocatable :: columns(:)
      type(start_t), allocatable :: starts(:, :)
      type(tangent_t) :: tangent
      type(state_t) :: state, ends(4)
      real(wp) :: difference(6), largest
      integer :: i, j, k, m
      do i = 1, size(scenes)
         call list_variations(trim(scenes(i)), columns, starts, shift)
         do m = 1, size(methods)
            call follow(trim(scenes(i)), start_t(), integrator_settings_t(method=methods(m)), 0.3_wp, 4, state, &
               columns, &
                        tangent, error)
            if (allocated(error)) return
            largest = max(maxval(abs(tangent%theta)), maxval(abs(tangent%momentum)))
            do k = 1, size(columns)
               do j = 1, 4
                  call follow(trim(scenes(i)), starts(j, k), integrator_settings_t(method=methods(m)), 0.3_wp, &
                     4, ends(j), &
                              error=error)
               end do
               if (allocated(error)) return
               difference = (4*difference_of(ends(3), ends(4), 0.5_wp*shift) - difference_of(ends(1), ends(2), &
                  shift))/3
               call check_below(error, maxval(abs(difference - [tangent%theta(k, :), tangent%momentum(k, &
                  :)]))/largest, &
                                1e-8_wp, trim(scenes(i))//' '//trim(methods(m))//' '//trim(columns(k)%name))
            end do
         end do
      end do
   end subroutine differ

   !> rk8 takes columns of the start through its equations for uniform fields, and through the general ones where there
   !> are columns of parameters: one derivative, to the round-off of four steps.
   subroutine stand_alone(error)
      type(error_type), allocatable, intent(out) :: error
      type(integrator_settings_t), parameter :: settings = integrator_settings_t(method='rk8')
      integer, parameter :: numbers(5) = [1, 2, 6, 13, 30]
      type(variation_t), allocatable :: columns(:)
      type(tangent_t) :: alone, beside
      type(state_t) :: state
      integer :: i, j, k, n
      columns = [(rate_variation(1 + mod(j, 3)), attitude_variation(1 + mod(j, 3)), j=1, maxval(numbers))]
      do i = 1, size(scenes)
         do k = 1, size(numbers)
            n = numbers(k)
            call follow(trim(scenes(i)), start_t(), settings, 0.3_wp, 4, state, columns(:n), alone, error)
            call follow(trim(scenes(i)), start_t(), settings, 0.3_wp, 4, state, [columns(:n), inertia_variation(1, &
               1)], &
                        beside, error)
            if (allocated(error)) return
            call check_below(error, maxval(abs(alone%theta - beside%theta(:n, :)))/maxval(abs(alone%theta)), &
                             1e-13_wp, trim(scenes(i)))
            call check_below(error, maxval(abs(alone%momentum - beside%momentum(:n, :)))/maxval(abs(alone%momentum)), &
                             1e-13_wp, trim(scenes(i)))
         end do
      end do
   end subroutine stand_alone

   !> The six columns of a state's start as a matrix, (θ, δL) by (θ, δL); shape (6,6).
   function matrix_of(system, state, settings, time_step, steps, end, error) result(matrix)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(integrator_settings_t), intent(in) :: settings
      real(wp), intent(in) :: time_step
      integer, intent(in) :: steps
      type(state_t), intent(out) :: end
      type(error_type), allocatable, intent(inout) :: error
      real(wp) :: matrix(6, 6)
      class(stepper_t), allocatable :: stepper
      type(variation_t) :: columns(6)
      type(tangent_t) :: tangent
      type(status_t) :: status
      type(state_t) :: before
      integer :: i
      do i = 1, 3
         columns(i) = attitude_variation(i)
         columns(3 + i) = rate_variation(i)
         columns(3 + i)%angular_velocity = system%body%inverse_inertia(:, i)
      end do
      end = state
      call make_stepper(system, settings, stepper, status)
      if (status%ok()) call tangent%begin(system, state, columns, status)
      do i = 1, steps
         if (.not. status%ok()) exit
         before = end
         call stepper%step(system, end, time_step, status)
         if (status%ok()) call stepper%propagate(system, before, end, time_step, before%t + 0.5_wp*time_step, &
            tangent, status)
      end do
      call check(error, status%ok(), trim(settings%method)//': '//status%message)
      matrix = 0.0_wp
      if (allocated(error)) return
      matrix(1:3, :) = transpose(tangent%theta)
      matrix(4:6, :) = transpose(tangent%momentum)
   end function matrix_of

   !> Errors of 2 s against those of half the step: of the attitude's order 4 and 8, projected or not.
   subroutine converge(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: orders(3) = [4.0_wp, 8.0_wp, 8.0_wp], steps(3) = [0.04_wp, 0.2_wp, 0.2_wp]
      type(integrator_settings_t) :: settings
      type(system_t), pointer :: system
      type(state_t) :: start, end
      real(wp) :: exact(6, 6), off(2), order
      integer :: i, m, k
      system => new_system()
      do i = 1, size(scenes)
         call build(trim(scenes(i)), start_t(), system, start)
         settings = integrator_settings_t(method='dop853')
         exact = matrix_of(system, start, settings, 0.01_wp, 200, end, error)
         do m = 1, size(methods)
            do k = 0, 1
               settings = integrator_settings_t(method=methods(m), conserve=k == 1)
               off(1) = maxval(abs(matrix_of(system, start, settings, steps(m), nint(2/steps(m)), end, &
                  error) - exact))
               off(2) = maxval(abs(matrix_of(system, start, settings, 0.5_wp*steps(m), nint(4/steps(m)), end, &
                  error) - exact))
               if (allocated(error)) return
               order = log(off(1)/off(2))/log(2.0_wp)
               call check_below(error, orders(m) - 0.75_wp, order, &
                  'order on '//trim(scenes(i))//' of '//trim(methods(m)))
            end do
         end do
      end do
   end subroutine converge

   !> Columns of the conserving step converge to those of the flow with its order.
   subroutine converge_composed(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: orders(4) = [2, 4, 6, 8]
      real(wp), parameter :: steps(4) = [0.005_wp, 0.02_wp, 0.05_wp, 0.2_wp]
      character(len=7), parameter :: forms(2) = [character(len=7) :: 'reduced', 'full']
      type(integrator_settings_t) :: settings
      type(system_t), pointer :: system
      type(state_t) :: start, end
      real(wp) :: exact(6, 6), off(2)
      character(len=60) :: label
      integer :: i, m, k
      system => new_system()
      do i = 1, size(scenes)
         call build(trim(scenes(i)), start_t(), system, start)
         exact = matrix_of(system, start, integrator_settings_t(method='dop853'), 0.01_wp, 200, end, error)
         do m = 1, size(orders)
            do k = 1, size(forms)
               settings = integrator_settings_t(method='nielsen_krenk', formulation=forms(k), order=orders(m))
               off(1) = maxval(abs(matrix_of(system, start, settings, steps(m), nint(2/steps(m)), end, error) - exact))
               off(2) = maxval(abs(matrix_of(system, start, settings, 0.5_wp*steps(m), nint(4/steps(m)), end, &
                                             error) - exact))
               if (allocated(error)) return
               write (label, '("order ",i0," on ",a," in ",a," form")') orders(m), trim(scenes(i)), trim(forms(k))
               call check_close(error, log(off(1)/off(2))/log(2.0_wp), real(orders(m), wp), 0.1_wp, trim(label))
            end do
         end do
      end do
   end subroutine converge_composed

   !> Trace and Σσ² of the derivative of a flow.
   subroutine follow_flows(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: values(6, 4) = reshape([ &
         67676.6880216973_wp, 29.9545759855932_wp, 9.25283747476441_wp, 0.0790487378865267_wp, &
            0.0352094988530636_wp, &
         1.91543760196857e-5_wp, &
         109.696965557958_wp, 32.6450822285920_wp, 5.51682777320931_wp, 0.161454345856520_wp, 0.0298890548550390_wp, &
         0.0104890527910665_wp, &
         80.9362923117815_wp, 37.4980083164826_wp, 11.5846809277370_wp, 0.0885940502001359_wp, &
            0.0278056355547347_wp, &
         0.0115458798563660_wp, &
         2370.90227267928_wp, 1.74814410921794_wp, 1.00000118484265_wp, 0.999998815158758_wp, 0.571954601590114_wp, &
         0.000421839804988962_wp], [6, 4])
      real(wp), parameter :: traces(4) = [-6616.19819161773_wp, 50.1131111217069_wp, -5.53916056690863_wp, &
                                          560.716924924227_wp]
      real(wp), parameter :: moments(3, 4) = reshape([3.0_wp, 2.0_wp, 1.0_wp, 2.0_wp, 2.0_wp, 1.0_wp, 1.0_wp, &
         1.0_wp, &
                                                      0.5_wp, 5.0_wp, 20.0_wp, 17.0_wp], [3, 4])
      real(wp), parameter :: dipoles(3, 3) = reshape([1.0_wp, 0.3_wp, 0.5_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
         0.0_wp, &
                                                      1.0_wp], [3, 3])
      real(wp), parameter :: rates(3, 4) = reshape([0.4_wp, -0.3_wp, 0.5_wp, 0.4_wp, -0.3_wp, 1.2_wp, 0.4_wp, &
         -0.3_wp, &
                                                    2.0_wp, 0.1_wp, 0.0_wp, 10.0_wp], [3, 4])
      real(wp), parameter :: tolerances(4) = [1e-6_wp, 1e-10_wp, 1e-10_wp, 1e-9_wp]
      type(system_t), pointer :: system
      type(state_t) :: start, end
      type(status_t) :: status
      real(wp) :: matrix(6, 6), q(4), squares
      character(len=8) :: names(3)
      integer :: i, k, m
      names = ['rk8     ', 'taylor  ', 'dop853  ']
      do i = 1, 4
         system => new_system()
         call make_body(diagonal(moments(:, i)), system%body, status)
         q = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
         if (i < 4) then
            call system%effects%add(dipole_t(dipoles(:, i), [0.0_wp, 0.0_wp, -1.0_wp]))
            q = quat_normalized([0.8_wp, 0.4_wp, -0.4_wp, 0.2_wp])
         else
            names(3) = 'exact'
         end if
         start = make_state(system, q, rates(:, i))
         do k = 1, 3
            m = merge(7, merge(800, 4000, names(k) == 'taylor'), names(k) == 'exact')
            matrix = matrix_of(system, start, integrator_settings_t(method=names(k)), merge(50.0_wp, 20.0_wp, &
               i < 4)/m, m, &
                               end, error)
            if (allocated(error)) return
            squares = sum(matrix**2)
            call check_close(error, squares/sum(values(:, i)**2), 1.0_wp, tolerances(i), &
               'sum of squares by '//names(k))
            call check_close(error, (matrix(1, 1) + matrix(2, 2) + matrix(3, 3) + matrix(4, 4) + matrix(5, 5) &
                                     + matrix(6, 6)), traces(i), tolerances(i)*values(1, i), 'trace by '//names(k))
         end do
         if (i == 4) call check_close(error, matrix(1:3, 1), [0.949147339362133_wp, -0.313488551011254_wp, &
                                                              0.0290560934512404_wp], 1e-9_wp, 'theta of theta1')
      end do
   end subroutine follow_flows

   !> Checks that energy and momentum of projected columns are kept in long runs, also those of columns of parameters.
   subroutine keep_rows(error)
      type(error_type), allocatable, intent(out) :: error
      type(variation_t), allocatable :: columns(:)
      type(start_t), allocatable :: starts(:, :)
      type(integrator_settings_t) :: settings
      type(tangent_t) :: tangent
      type(system_t), pointer :: system
      type(state_t) :: state
      real(wp) :: lacks(12), axis(3), of_momentum(12, 3), largest
      integer :: i, k, m, components
      system => new_system()
      do i = 1, size(scenes)
         call list_variations(trim(scenes(i)), columns, starts, 1.0_wp)
         do m = 0, size(methods)
            settings = integrator_settings_t(method='taylor', conserve=.true., project_each=m /= 2)
            if (m > 0) settings%method = methods(m)
            ! After a multiple of 8 steps the state is projected.
            call build(trim(scenes(i)), start_t(), system, state)
            call follow(trim(scenes(i)), start_t(), settings, 0.1_wp, 641, state, columns, tangent, error)
            if (allocated(error)) return
            call conserved_momentum(system%effects, components, axis)
            lacks(:size(columns)) = tangent%energy_row(system, state) - tangent%energy
            of_momentum(:size(columns), :) = tangent%momentum_row(state) - tangent%space_momentum
            do k = 1, size(columns)
               largest = norm2(tangent%theta(k, :)) + norm2(tangent%momentum(k, :))
               call check_below(error, abs(lacks(k))/(5*largest), 1e-13_wp, 'energy of '//trim(scenes(i))//' '// &
                                trim(settings%method)//' '//trim(columns(k)%name))
               if (components == ALL_COMPONENTS) &
                  call check_below(error, maxval(abs(of_momentum(k, :)))/(5*largest), 1e-13_wp, &
                     'l of '//trim(scenes(i)))
               if (components == ALONG_AXIS .and. .not. any(abs(columns(k)%frame) > 0.0_wp)) &
                  call check_below(error, abs(dot_product(axis, of_momentum(k, :)))/(5*largest), 1e-13_wp, 'l of '// &
                                   trim(scenes(i))//' '//trim(settings%method)//' '//trim(columns(k)%name))
            end do
         end do
      end do
   end subroutine keep_rows

   !> The states with columns have the bits of those without, in a run and inside its steps.
   subroutine leave_states(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=8), parameter :: names(5) = [character(len=8) :: 'rk4', 'rk8', 'dop853', 'exact', 'taylor']
      type(run_plan_t) :: plan
      class(run_t), allocatable :: runs(:)
      type(system_t), pointer :: system
      type(state_t) :: start
      type(status_t) :: status
      integer :: i, k, m
      system => new_system()
      allocate (runs(2))
      plan%time_step = 0.1_wp
      plan%end_time = 10.04_wp
      do i = 1, size(scenes)
         call build(trim(scenes(i)), start_t(), system, start)
         do m = 1, size(names)
            if (names(m) == 'exact' .and. scenes(i) /= 'box') cycle
            do k = 1, 2
               call runs(k)%begin(system, integrator_settings_t(method=names(m), conserve=modulo(i, 2) == 0), &
                  start, plan, &
                                  status)
               if (k == 2 .and. status%ok()) &
                  call runs(k)%differentiate([attitude_variation(1), rate_variation(2)], system, status)
               if (status%ok()) call runs(k)%run_to_end(system, status)
               call check(error, status%ok(), trim(scenes(i))//': '//status%message)
               if (allocated(error)) return
            end do
            associate (one => runs(1)%state, other => runs(2)%state)
               call check(error, maxval(abs([one%q - other%q, one%p - other%p])) <= 0.0_wp, &
                  'the state of '//trim(scenes(i)))
            end associate
            call check(error, maxval(abs(runs(2)%tangent%theta(2, :))) > 0.5_wp, 'columns of the run')
         end do
      end do
   end subroutine leave_states

   !> The closed solution of random bodies, beside axes and separatrix and with equal moments, against its differences.
   subroutine differ_exact(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: parts(4) = [1.0_wp, -1.0_wp, 0.5_wp, -0.5_wp]
      type(variation_t) :: columns(12)
      type(tangent_t) :: tangent
      type(system_t), pointer :: system
      type(system_t) :: other
      type(state_t) :: start, state, ends(4)
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      real(wp) :: inertia(3, 3), rate(3), turn(3), moved(3), difference(6), largest, shift
      integer(int64) :: seed
      integer :: i, j, k, n
      system => new_system()
      seed = 815
      do i = 1, 60
         call draw_body(seed, i, inertia, rate)
         call make_body(inertia, system%body, status)
         start = make_state(system, quat_normalized([0.7_wp, 0.4_wp, -0.5_wp, 0.2_wp]), rate)
         n = merge(12, 9, i > 40)
         do k = 1, 3
            columns(k) = attitude_variation(k)
            columns(3 + k) = rate_variation(k)
            columns(6 + k) = inertia_variation(k, k)
            columns(9 + k) = inertia_variation(1 + modulo(k, 3), 1 + modulo(k + 1, 3))
         end do
         call make_stepper(system, integrator_settings_t(method='exact'), stepper, status)
         call tangent%begin(system, start, columns(:n), status)
         state = start
         call stepper%step(system, state, 3.0_wp, status)
         if (status%ok()) call stepper%propagate(system, start, state, 3.0_wp, 1.5_wp, tangent, status)
         call check(error, status%ok(), status%message)
         if (allocated(error)) return
         largest = max(maxval(abs(tangent%theta)), maxval(abs(tangent%momentum)))
         shift = 1e-3_wp/largest
         do k = 1, n
            do j = 1, 4
               other = system
               turn = 0.0_wp
               moved = rate
               if (k <= 3) turn(k) = parts(j)*shift
               if (k > 3 .and. k <= 6) moved(k - 3) = moved(k - 3) + parts(j)*shift
               if (k > 6) call make_body(inertia + (parts(j)*shift)*columns(k)%inertia, other%body, status)
               ends(j) = make_state(other, quat_product(start%q, quat_exp(0.5_wp*turn)), moved)
               call make_stepper(other, integrator_settings_t(method='exact'), stepper, status)
               if (status%ok()) call stepper%step(other, ends(j), 3.0_wp, status)
               call check(error, status%ok(), status%message)
            end do
            if (allocated(error)) return
            difference = (4*difference_of(ends(3), ends(4), 0.5_wp*shift) - difference_of(ends(1), ends(2), shift))/3
            call check_below(error, maxval(abs(difference - [tangent%theta(k, :), tangent%momentum(k, :)]))/largest, &
                             2e-8_wp, 'body '//digits(i)//' '//trim(columns(k)%name))
         end do
      end do
   end subroutine differ_exact

   !> Bodies 1 to 20 at large; then with two equal moments, beside an axis, beside the separatrix, in steady rotation;
   !> from 41 on with products of inertia.
   subroutine draw_body(seed, i, inertia, rate)
      integer(int64), intent(inout) :: seed
      integer, intent(in) :: i
      real(wp), intent(out) :: inertia(3, 3), rate(3)
      real(wp) :: moments(3), turn(3)
      integer :: k
      moments = [1.0_wp, 1.0_wp, 1.0_wp] + [random_unit(seed), random_unit(seed), random_unit(seed)]
      rate = 2*random_vector(seed)
      turn = random_vector(seed)
      k = 1 + modulo(i, 3)
      select case (i)
      case (21:25)
         moments(k) = moments(1 + modulo(k, 3))
      case (26:30)
         rate = 1e-6_wp*rate
         rate(k) = 1.5_wp
      case (31:35)
         rate = 1e-6_wp*rate
         rate(sum([1, 2, 3], [1, 2, 3] /= minloc(moments, 1) .and. [1, 2, 3] /= maxloc(moments, 1))) = 1.5_wp
      case (36:40)
         rate = 0.0_wp
         rate(k) = 1.5_wp
         if (i > 38) moments(k) = moments(1 + modulo(k, 3))
      case default
         continue
      end select
      inertia = diagonal(moments)
      if (i <= 40) return
      do k = 1, 3
         inertia(:, k) = rotate_to_body(quat_exp(0.5_wp*turn), inertia(:, k))
      end do
      inertia = transpose(inertia)
      do k = 1, 3
         inertia(:, k) = rotate_to_body(quat_exp(0.5_wp*turn), inertia(:, k))
      end do
      inertia = 0.5_wp*(inertia + transpose(inertia))
   end subroutine draw_body

   !> All columns of the closed solution against those of many short steps.
   subroutine compare_exact(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: start, end
      type(status_t) :: status
      real(wp) :: inertia(3, 3), rate(3), one(6, 6), other(6, 6)
      integer(int64) :: seed
      integer :: i
      system => new_system()
      seed = 4711
      do i = 1, 60
         call draw_body(seed, i, inertia, rate)
         call make_body(inertia, system%body, status)
         start = make_state(system, quat_normalized([0.7_wp, 0.4_wp, -0.5_wp, 0.2_wp]), rate)
         one = matrix_of(system, start, integrator_settings_t(method='exact'), 2.0_wp, 5, end, error)
         other = matrix_of(system, start, integrator_settings_t(method='rk8'), 0.025_wp, 400, end, error)
         if (allocated(error)) return
         call check_below(error, maxval(abs(one - other))/maxval(abs(one)), 1e-11_wp, 'body '//digits(i))
      end do
   end subroutine compare_exact

   !> Series of order 20, so that the flow is followed, in all scenes.
   subroutine differ_series(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: shift = 2e-3_wp
      type(integrator_settings_t), parameter :: settings = integrator_settings_t(method='taylor', series_order=20)
      type(variation_t), allocatable :: columns(:)
      type(start_t), allocatable :: starts(:, :)
      type(tangent_t) :: tangent
      type(state_t) :: state, ends(4)
      type(system_t), pointer :: system
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      real(wp) :: difference(6), largest
      integer :: i, j, k
      system => new_system()
      do i = 1, size(scenes)
         call list_variations(trim(scenes(i)), columns, starts, shift)
         call follow(trim(scenes(i)), start_t(), settings, 0.2_wp, 6, state, columns, tangent, error)
         if (allocated(error)) return
         largest = max(maxval(abs(tangent%theta)), maxval(abs(tangent%momentum)))
         do k = 1, size(columns)
            do j = 1, 4
               call follow(trim(scenes(i)), starts(j, k), settings, 0.2_wp, 6, ends(j), error=error)
            end do
            if (allocated(error)) return
            difference = (4*difference_of(ends(3), ends(4), 0.5_wp*shift) - difference_of(ends(1), ends(2), shift))/3
            call check_below(error, maxval(abs(difference - [tangent%theta(k, :), tangent%momentum(k, :)]))/largest, &
                             1e-8_wp, trim(scenes(i))//' taylor '//trim(columns(k)%name))
         end do
      end do
   end subroutine differ_series

   pure character(len=2) function digits(i)
      integer, intent(in) :: i
      write (digits, '(i2)') i
   end function digits

   !> (θ, δL) of two states over twice a shift; shape (6).
   pure function difference_of(one, other, shift) result(difference)
      type(state_t), intent(in) :: one, other
      real(wp), intent(in) :: shift
      real(wp) :: difference(6), turn(4)
      turn = quat_product(quat_conjugate(other%q), one%q)
      difference = [turn(2:4)/shift, (body_momentum(one) - body_momentum(other))/(2*shift)]
   end function difference_of

end submodule test_tangent_explicit
