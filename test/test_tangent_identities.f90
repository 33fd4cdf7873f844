!> Quantities that steps conserve, and that their tangent conserves too, to round-off: energy, with the work of torques
!> and its change by parameters, momentum, and symmetry about a direction. Random scenes, every parameter, both forms
!> and all orders.
module test_tangent_identities
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_sensitivity_projection, only: kept_steps
   use nutate_variation, only: attitude_variation, variation_t, inertia_variation, rate_variation, OF_POTENTIAL, &
      OF_TORQUE, OF_WHEEL
   use nutate_effect, only: effect_t, parameter_t
   use nutate_kinds, only: wp
   use nutate_methods, only: integrator_settings_t, make_stepper, stepper_t
   use nutate_quaternion, only: rotate_to_body
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_tangent, only: tangent_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_wheel
   use test_problems, only: angular_velocity, body_momentum, box, make_state, potential_torque, precessing_top, &
      problem_t, space_momentum, system_t
   use test_random_scenes, only: make_random_scene, random_scene_t
   use test_support, only: check, check_below, check_close, draws_fewer, error_type, new_unittest, random_unit, &
      random_vector, unittest_type
   implicit none
   private

   public :: collect_tangent_identities, enrich, worst_defect

   !> Round-off of 100 steps of up to 17 stages, of thin rods too, over |row||column|.
   real(wp), parameter :: bound = 5e-13_wp
   !> Columns beyond begin anew.
   real(wp), parameter :: largest = 1e100_wp

   type(integrator_settings_t), parameter :: settings(5) = [ &
      integrator_settings_t(method='nielsen_krenk', formulation='reduced', order=2), &
      integrator_settings_t(method='nielsen_krenk', formulation='full', order=2), &
      integrator_settings_t(method='nielsen_krenk', formulation='reduced', order=4), &
      integrator_settings_t(method='nielsen_krenk', formulation='reduced', order=6), &
      integrator_settings_t(method='nielsen_krenk', formulation='full', order=8)]

contains

   subroutine collect_tangent_identities(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("energy and momentum of random scenes", keep_invariants), &
                  new_unittest("both formulations have the same columns", agree), &
                  new_unittest("columns of tops and free bodies keep them over many steps", keep_for_long), &
                  new_unittest("only round-off is removed from columns", keep_errors), &
                  new_unittest("turns about a direction go on as turns about it", keep_symmetry)]
   end subroutine collect_tangent_identities

   !> A column for each start and each parameter of a system, in units in which they change it by about their size.
   function all_columns(system) result(columns)
      type(system_t), intent(in) :: system
      type(variation_t), allocatable :: columns(:)
      integer :: i, k
      allocate (columns(0))
      do i = 1, 3
         columns = [columns, attitude_variation(i), rate_variation(i)]
         do k = 1, i
            columns = [columns, inertia_variation(k, i)]
            columns(size(columns))%inertia = maxval(system%body%moments)*columns(size(columns))%inertia
         end do
      end do
      do i = 1, system%effects%n_potentials
         call add_all(columns, system%effects%potentials(i)%item, OF_POTENTIAL, system%effects%potentials(i)%place)
      end do
      do i = 1, system%effects%n_torques
         call add_all(columns, system%effects%torques(i)%item, OF_TORQUE, i)
      end do
      do i = 1, system%effects%n_wheels
         call add_all(columns, system%effects%wheels(i), OF_WHEEL, i)
      end do
      columns = [columns, variation_t(name='rotor', rotor=maxval(system%body%moments)*[0.5_wp, -0.2_wp, 0.3_wp])]
      if (system%effects%frame_turns) columns = [columns, variation_t(name='frame', frame=[0.2_wp, 0.5_wp, -0.4_wp])]
   end function all_columns

   !> Adds the variations of the numbers of an effect.
   subroutine add_all(columns, effect, kind, place)
      type(variation_t), allocatable, intent(inout) :: columns(:)
      class(effect_t), intent(in) :: effect
      integer, intent(in) :: kind, place
      type(parameter_t), allocatable :: list(:)
      type(variation_t) :: column
      integer :: i, n
      list = effect%parameters()
      n = sum(list%size)
      ! The inertia of a gravity gradient follows from that of the body.
      if (any(list%name == 'inertia')) n = n - 9
      do i = 1, n
         column = variation_t(name=effect%name)
         allocate (column%effects(1))
         column%effects(1)%kind = kind
         column%effects(1)%place = place
         allocate (column%effects(1)%change(sum(list%size)), source=0.0_wp)
         column%effects(1)%change(i) = 1.0_wp
         columns = [columns, column]
      end do
   end subroutine add_all

   !> Takes steps with columns; the largest defect of the energy of a column, and of its momentum where that is
   !> conserved, over |row||column|, the largest of all steps so far, δL in units of |L|: columns that shrink keep the
   !> round-off of what they were.
   subroutine worst_defect(system, how, start, time_step, steps, axis, energy, momentum, status, done)
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: how
      type(state_t), intent(in) :: start
      real(wp), intent(in) :: time_step
      integer(int64), intent(in) :: steps
      !> l is kept along it; 0: all of it is kept; shape (3).
      real(wp), intent(in) :: axis(3)
      real(wp), intent(out) :: energy, momentum
      type(status_t), intent(out) :: status
      !> Steps before one was impossible.
      integer(int64), intent(out), optional :: done
      class(stepper_t), allocatable :: stepper
      type(tangent_t) :: tangent
      type(state_t) :: state, before
      real(wp), allocatable :: scale(:), scale_l(:)
      integer(int64) :: i
      energy = 0.0_wp
      momentum = 0.0_wp
      state = start
      call tangent%begin(system, state, all_columns(system), status)
      if (status%ok()) call make_stepper(system, how, stepper, status)
      if (.not. status%ok()) return
      allocate (scale(tangent%n), scale_l(tangent%n), source=0.0_wp)
      call measure()
      call assess()
      do i = 1, steps
         before = state
         call stepper%step(system, state, time_step, status)
         if (status%ok()) call stepper%propagate(system, before, state, time_step, before%t + 0.5_wp*time_step, &
            tangent, &
                                             status)
         if (present(done)) done = i
         if (.not. status%ok()) return
         call measure()
         if (mod(i, max(1_int64, steps/1000)) == 0) call assess()
         if (max(maxval(abs(tangent%theta)), maxval(abs(tangent%momentum))) < largest) cycle
         call assess()
         call tangent%begin(system, state, all_columns(system), status)
         scale = 0.0_wp
         scale_l = 0.0_wp
         call measure()
      end do

   contains

      !> The largest |row||column| so far, of every step.
      subroutine measure()
         real(wp) :: l, omega, rotating, torque, theta, delta
         integer :: k
         l = norm2(body_momentum(state))
         omega = norm2(angular_velocity(system, state))
         rotating = norm2(system%effects%frame_rate)
         torque = norm2(potential_torque(system%effects, state%q, state%t))
         do k = 1, tangent%n
            theta = norm2(tangent%theta(k, :))
            delta = norm2(tangent%momentum(k, :))
            scale(k) = max(scale(k), (torque + rotating*l)*theta + (omega + rotating)*(delta + l*theta) &
                           + abs(tangent%energy(k)) + abs(tangent%work(k)))
            scale_l(k) = max(scale_l(k), l*theta + delta)
         end do
      end subroutine measure

      subroutine assess()
         real(wp) :: row(tangent%n), change(tangent%n, 3), along
         integer :: k
         row = abs(tangent%energy_row(system, state) - tangent%energy - tangent%work)
         change = tangent%momentum_row(state) - tangent%space_momentum
         do k = 1, tangent%n
            if (scale(k) > 0.0_wp) energy = max(energy, row(k)/scale(k))
            along = norm2(change(k, :))
            if (any(abs(axis) > 0.0_wp)) along = abs(dot_product(change(k, :), axis))
            ! A change of the direction changes what is kept.
            if (any(abs(axis) > 0.0_wp) .and. allocated(tangent%variations(k)%effects)) cycle
            if (scale_l(k) > 0.0_wp) momentum = max(momentum, along/scale_l(k))
         end do
      end subroutine assess

   end subroutine worst_defect

   !> Random scenes, with wheels and frames added to some.
   subroutine keep_invariants(error)
      type(error_type), allocatable, intent(out) :: error
      type(random_scene_t) :: scene
      type(status_t) :: status
      real(wp) :: energy, momentum, length
      integer :: number, m, done
      character(len=160) :: label
      done = 0
      do number = 1, merge(60, 400, draws_fewer())
         call make_random_scene(number, scene)
         call enrich(scene, number)
         m = 1 + modulo(number, size(settings))
         length = 0.3_wp/max(norm2(angular_velocity(scene%problem%system, scene%problem%start)), &
                             30/abs(scene%end_time))
         call worst_defect(scene%problem%system, settings(m), scene%problem%start, length, 100_int64, &
                           [0.0_wp, 0.0_wp, 0.0_wp], energy, momentum, status)
         if (.not. status%ok()) cycle
         done = done + 1
         write (label, '("scene ",i0," order ",i0,": ",a)') number, settings(m)%order, trim(scene%text)
         call check_below(error, energy, bound, trim(label))
         if (scene%problem%system%effects%n_potentials + scene%problem%system%effects%n_torques == 0 .and. &
             .not. scene%problem%system%effects%frame_turns) &
            call check_below(error, momentum, bound, 'momentum of '//trim(label))
      end do
      call check(error, done > 0.8_wp*(number - 1), 'most of the scenes can be stepped')
   end subroutine keep_invariants

   !> Adds wheels to each third scene, rotating axes to each fifth.
   subroutine enrich(scene, number)
      type(random_scene_t), intent(inout) :: scene
      integer, intent(in) :: number
      type(wheel_t) :: wheel
      type(status_t) :: status
      type(state_t) :: start
      integer(int64) :: seed
      real(wp) :: rate
      seed = 31_int64*number + 7
      associate (system => scene%problem%system)
         start = scene%problem%start
         rate = norm2(angular_velocity(system, start)) + 1/abs(scene%end_time)
         if (modulo(number, 3) == 0) then
            wheel%name = 'wheel'
            wheel%axis = random_vector(seed)
            wheel%axis = wheel%axis/norm2(wheel%axis)
            wheel%inertia = 0.1_wp*minval(system%body%moments)
            wheel%speed = 3*rate*random_unit(seed)
            wheel%friction = 0.3_wp*wheel%inertia*rate*random_unit(seed)
            call add_wheel(system, wheel, status)
            scene%text = trim(scene%text)//', wheel'
         end if
         if (modulo(number, 5) == 0) then
            call system%effects%add(rotating_frame_t(name='rotating_frame', rate=0.3_wp*rate*random_vector(seed)))
            scene%text = trim(scene%text)//', frame'
         end if
         scene%problem%start = make_state(system, start%q, rate*random_vector(seed))
      end associate
   end subroutine enrich

   !> The two forms of the equations in random scenes, step by step.
   subroutine agree(error)
      type(error_type), allocatable, intent(out) :: error
      type(random_scene_t) :: scene
      type(tangent_t) :: tangents(2)
      type(state_t) :: state, before
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      real(wp) :: length, difference
      integer :: number, i, k
      character(len=160) :: label
      do number = 1, merge(30, 200, draws_fewer())
         call make_random_scene(number, scene)
         call enrich(scene, number)
         length = 0.2_wp/max(norm2(angular_velocity(scene%problem%system, scene%problem%start)), &
                             30/abs(scene%end_time))
         do k = 1, 2
            state = scene%problem%start
            call tangents(k)%begin(scene%problem%system, state, all_columns(scene%problem%system), status)
            if (status%ok()) call make_stepper(scene%problem%system, settings(k), stepper, status)
            do i = 1, 5
               if (.not. status%ok()) exit
               before = state
               call stepper%step(scene%problem%system, state, length, status)
               if (status%ok()) call stepper%propagate(scene%problem%system, before, state, length, &
                                                   before%t + 0.5_wp*length, tangents(k), status)
            end do
            if (.not. status%ok()) exit
         end do
         if (.not. status%ok()) cycle
         write (label, '("scene ",i0,": ",a)') number, trim(scene%text)
         do i = 1, tangents(1)%n
            difference = norm2(tangents(1)%theta(i, :) - tangents(2)%theta(i, :))/ &
                         (norm2(tangents(1)%theta(i, :)) + norm2(tangents(1)%momentum(i, :))/scale_of(scene) &
                          + tiny(1.0_wp))
            call check_below(error, difference, 1e-11_wp, trim(label))
         end do
      end do
   end subroutine agree

   !> |L| of the start, or of a slow rotation, N m s.
   real(wp) function scale_of(scene)
      type(random_scene_t), intent(in) :: scene
      scale_of = max(norm2(body_momentum(scene%problem%start)), maxval(scene%problem%system%body%moments)/ &
                     abs(scene%end_time))
   end function scale_of

   !> The box and the top of the paper: energy and momentum over many steps.
   subroutine keep_for_long(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(status_t) :: status
      real(wp) :: energy, momentum
      integer(int64) :: steps
      integer :: m
      steps = merge(7000_int64, 20000_int64, draws_fewer())
      do m = 1, 2
         problem => box()
         call worst_defect(problem%system, settings(m), problem%start, 0.05_wp, steps, [0.0_wp, 0.0_wp, 0.0_wp], &
                           energy, momentum, status)
         call check(error, status%ok(), 'free body: '//trim(status%message))
         call check_below(error, energy, 1e-13_wp, 'energy of the free body')
         call check_below(error, momentum, 1e-13_wp, 'momentum of the free body')
         problem => precessing_top()
         call worst_defect(problem%system, settings(m), problem%start, 1e-3_wp, steps, [0.0_wp, 0.0_wp, 1.0_wp], &
                           energy, momentum, status)
         call check(error, status%ok(), 'top: '//trim(status%message))
         call check_below(error, energy, 1e-13_wp, 'energy of the top')
         call check_below(error, momentum, 1e-13_wp, 'momentum of the top')
      end do
   end subroutine keep_for_long

   !> A column of the box with an error as round-off may leave it, which goes, and with a larger one, which stays.
   subroutine keep_errors(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: wrong(2) = [1e-13_wp, 3e-12_wp]
      type(problem_t), pointer :: problem
      real(wp) :: energy, momentum
      integer :: m, k
      problem => box()
      do m = 1, size(settings)
         do k = 1, 2
            call disturb(problem, settings(m), wrong(k), energy, momentum, error)
            if (allocated(error)) return
            if (k == 1) then
               call check_below(error, energy, 0.1_wp*wrong(1), 'energy after round-off')
               call check_below(error, momentum, 0.1_wp*wrong(1), 'momentum after round-off')
            else
               call check_close(error, energy, wrong(2), 0.01_wp*wrong(2), 'energy after an error')
               call check_close(error, momentum, wrong(2), 0.01_wp*wrong(2), 'momentum after an error')
            end if
         end do
      end do
   end subroutine keep_errors

   !> Defects of a column of the rate after as many steps as round-off may stay, the last of them with an error along Ω.
   subroutine disturb(problem, how, wrong, energy, momentum, error)
      type(problem_t), intent(in) :: problem
      type(integrator_settings_t), intent(in) :: how
      !> Over |δL| + |L||θ|, as `momentum` is; `energy` over this and |Ω|.
      real(wp), intent(in) :: wrong
      real(wp), intent(out) :: energy, momentum
      type(error_type), allocatable, intent(inout) :: error
      type(tangent_t) :: tangent
      type(state_t) :: state, before
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      real(wp) :: omega(3), scale, row(1), change(1, 3)
      integer :: i
      state = problem%start
      call tangent%begin(problem%system, state, [rate_variation(3)], status)
      if (status%ok()) call make_stepper(problem%system, how, stepper, status)
      do i = 1, kept_steps
         if (.not. status%ok()) exit
         if (i == kept_steps) then
            omega = angular_velocity(problem%system, state)
            scale = norm2(tangent%momentum(1, :)) + norm2(body_momentum(state))*norm2(tangent%theta(1, :))
            tangent%momentum(1, :) = tangent%momentum(1, :) + (wrong*scale/norm2(omega))*omega
         end if
         before = state
         call stepper%step(problem%system, state, 0.05_wp, status)
         if (status%ok()) call stepper%propagate(problem%system, before, state, 0.05_wp, before%t + 0.025_wp, tangent, &
                                             status)
      end do
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      row = tangent%energy_row(problem%system, state) - tangent%energy
      change = tangent%momentum_row(state) - tangent%space_momentum
      energy = abs(row(1))/(scale*norm2(omega))
      momentum = norm2(change(1, :))/scale
   end subroutine disturb

   !> M(γ0, 0) = (γ1, 0) of a potential's direction, of a free body M(θ, 0) = (R1ᵀR0θ, 0).
   subroutine keep_symmetry(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(tangent_t) :: tangent
      type(variation_t) :: column
      type(status_t) :: status
      type(state_t) :: state, before
      class(stepper_t), allocatable :: stepper
      real(wp) :: n(3)
      integer :: i, m, k
      do k = 1, 2
         problem => box()
         if (k == 2) problem => precessing_top()
         n = [0.0_wp, 0.0_wp, 1.0_wp]
         if (k == 1) n = [0.6_wp, 0.0_wp, -0.8_wp]
         do m = 1, size(settings)
            state = problem%start
            column = variation_t()
            column%attitude = rotate_to_body(state%q, n)
            call tangent%begin(problem%system, state, [column], status)
            call make_stepper(problem%system, settings(m), stepper, status)
            do i = 1, 100
               before = state
               call stepper%step(problem%system, state, merge(0.05_wp, 2e-3_wp, k == 1), status)
               call stepper%propagate(problem%system, before, state, merge(0.05_wp, 2e-3_wp, k == 1), before%t, &
                  tangent, &
                                  status)
               call check(error, status%ok(), trim(status%message))
               if (allocated(error)) return
            end do
            call check_below(error, norm2(tangent%theta(1, :) - rotate_to_body(state%q, n)), 2e-12_wp, 'turn')
            call check_below(error, norm2(tangent%momentum(1, :))/norm2(body_momentum(state)), 2e-12_wp, 'momentum')
         end do
      end do
   end subroutine keep_symmetry

end module test_tangent_identities
