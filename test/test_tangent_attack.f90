!> Random steps of all methods, with random columns, against the oracle of 33 digits: in the unit tests some hundred, at
!> full length 100 000.
module test_tangent_attack
   use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit
   use nutate_body, only: make_body
   use nutate_variation, only: attitude_variation, variation_t, inertia_variation, rate_variation
   use nutate_composition, only: compositions
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_kinds, only: wp
   use nutate_methods, only: integrator_settings_t, make_stepper, stepper_t
   use nutate_order_eight, only: order_eight => a, order_eight_weights => b
   use nutate_quaternion, only: quat_normalized, rotation_matrix
   use nutate_rotor, only: rotor_t
   use nutate_spring, only: spring_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_tangent, only: tangent_t
   use test_oracle, only: has_oracle, qp
   use test_problems, only: body_momentum, make_state, new_system, system_t
   use test_support, only: check, draws_fewer, error_type, new_unittest, one_in, random_unit, random_unit_quaternion, &
      random_vector, skip_test, test_failed, unittest_type
   use test_tangent_oracle, only: tangent_oracle_t, n_parameters, place, IMPLICIT_STAGES, RUNGE_KUTTA, FLOW, &
      anchor_at, damping_at, field_at, inertia_at, length_at, moment_at, momentum_at, point_at, rotor_at, &
      stiffness_at, turn_at
   implicit none
   private

   public :: collect_tangent_attack, report_tangent_attack

   !> Parameters that a body has, without effects; with a rotor in a uniform field; with all effects.
   integer, parameter :: FREE = rotor_at, UNIFORM = damping_at, FORCED = n_parameters

   !> A method.
   type :: way_t
      character(len=24) :: name
      type(integrator_settings_t) :: settings
      integer :: kind
      !> Number of its parameters, and of the columns that are compared: what the oracle has time for.
      integer :: parameters, columns
   end type way_t

   type(way_t), parameter :: ways(13) = [ &
      way_t('order 2, reduced', integrator_settings_t(method='nielsen_krenk', formulation='reduced', order=2), &
            IMPLICIT_STAGES, FORCED, 16), &
      way_t('order 2, full', integrator_settings_t(method='nielsen_krenk', formulation='full', order=2), &
            IMPLICIT_STAGES, FORCED, 16), &
      way_t('order 4, reduced', integrator_settings_t(method='nielsen_krenk', formulation='reduced', order=4), &
            IMPLICIT_STAGES, FORCED, 8), &
      way_t('order 4, full', integrator_settings_t(method='nielsen_krenk', formulation='full', order=4), &
            IMPLICIT_STAGES, FORCED, 8), &
      way_t('order 6, reduced', integrator_settings_t(method='nielsen_krenk', formulation='reduced', order=6), &
            IMPLICIT_STAGES, FORCED, 6), &
      way_t('order 6, full', integrator_settings_t(method='nielsen_krenk', formulation='full', order=6), &
            IMPLICIT_STAGES, FORCED, 6), &
      way_t('order 8, reduced', integrator_settings_t(method='nielsen_krenk', formulation='reduced', order=8), &
            IMPLICIT_STAGES, FORCED, 4), &
      way_t('order 8, full', integrator_settings_t(method='nielsen_krenk', formulation='full', order=8), &
            IMPLICIT_STAGES, FORCED, 4), &
      way_t('rk4', integrator_settings_t(method='rk4'), RUNGE_KUTTA, FORCED, 16), &
      way_t('rk8', integrator_settings_t(method='rk8'), RUNGE_KUTTA, FORCED, 8), &
      way_t('dop853', integrator_settings_t(method='dop853'), RUNGE_KUTTA, FORCED, 8), &
      way_t('taylor, order 24', integrator_settings_t(method='taylor', series_order=24), FLOW, UNIFORM, 4), &
      way_t('exact', integrator_settings_t(method='exact'), FLOW, FREE, 4)]

   !> Bound of the error of a column, divided by the square of the largest entry of all, which is also the condition of
   !> the step.
   real(wp), parameter :: bound = 1e-13_wp
   !> Difference of attitudes beyond which the oracle has found another root.
   real(wp), parameter :: other_root = 1e-8_wp

   !> Results for each method.
   type :: tally_t
      integer :: cases(size(ways)) = 0, steps(size(ways)) = 0, others(size(ways)) = 0, columns(size(ways)) = 0, &
         failures(size(ways)) = 0
      real(wp) :: worst(size(ways)) = 0.0_wp
      !> The first failure; blank without one.
      character(len=120) :: message = ''
   end type tally_t

contains

   subroutine collect_tangent_attack(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [new_unittest("columns of random steps are those of 33 digits", attack)]
   end subroutine collect_tangent_attack

   subroutine attack(error)
      type(error_type), allocatable, intent(out) :: error
      type(tally_t) :: tally
      integer :: number
      if (.not. has_oracle) then
         call skip_test(error, 'no numbers of 33 digits')
         return
      end if
      do number = 1, merge(merge(65, 260, one_in() > 3), 2600, draws_fewer())
         call try_case(1, number, tally)
      end do
      if (sum(tally%failures) > 0) call test_failed(error, trim(tally%message))
      call check(error, all(tally%steps > 0.7_wp*tally%cases), 'most of the steps are possible')
   end subroutine attack

   !> The attack at full length, or a case of it: a table on standard output, failures on standard error.
   subroutine report_tangent_attack(seed, number, alone, passed)
      integer, intent(in) :: seed
      !> Number of cases, or number of the only one.
      integer, intent(in) :: number
      logical, intent(in) :: alone
      logical, intent(out) :: passed
      type(tally_t) :: tally
      integer :: i
      do i = merge(number, 1, alone), number
         call try_case(seed, i, tally, aloud=.true.)
      end do
      write (output_unit, '(4(a,i0),a)') 'Seed ', seed, ': ', sum(tally%cases), ' steps with ', sum(tally%columns), &
         ' sensitivities compared, ', sum(tally%failures), ' beyond their bounds.'
      write (output_unit, '(/,a,/,a)') '| method | steps | not assessed | sensitivities | largest error |', &
         '|---|---|---|---|---|'
      do i = 1, size(ways)
         if (tally%cases(i) > 0) write (output_unit, '("| ",a,3(" | ",i0)," | ",es7.1," |")') trim(ways(i)%name), &
            tally%steps(i), tally%cases(i) - tally%steps(i), tally%columns(i), tally%worst(i)
      end do
      passed = sum(tally%failures) == 0 .and. all(tally%steps >= 0.7_wp*tally%cases)
   end subroutine report_tangent_attack

   !> One random step with all columns, some of which are compared.
   subroutine try_case(seed, number, tally, aloud)
      integer, intent(in) :: seed, number
      type(tally_t), intent(inout) :: tally
      !> Writes what fails.
      logical, intent(in), optional :: aloud
      type(system_t), pointer :: system
      type(state_t) :: state, before
      type(status_t) :: status
      type(tangent_t) :: tangent
      type(tangent_oracle_t) :: oracle
      type(variation_t), allocatable :: columns(:)
      class(stepper_t), allocatable :: stepper
      real(wp) :: p(n_parameters), q(4), omega(3), dt, largest, error
      real(qp) :: exact(6)
      integer(int64) :: random
      logical :: ok
      integer :: i, k, m
      system => new_system()
      m = 1 + modulo(number - 1, size(ways))
      random = 104729_int64*number + 7919_int64*seed
      do i = 1, 20
         dt = random_unit(random)
      end do
      tally%cases(m) = tally%cases(m) + 1
      call draw(random, ways(m)%parameters, p, q, omega, system, status)
      if (.not. status%ok()) return
      state = make_state(system, q, omega)
      p(momentum_at + 1:momentum_at + 3) = body_momentum(state)
      dt = (0.02_wp + 0.6_wp*random_unit(random))*merge(-1.0_wp, 1.0_wp, random_unit(random) < 0.2_wp)
      ! Series follow the flow over short steps.
      if (ways(m)%settings%method == 'taylor') dt = 0.5_wp*dt/max(1.0_wp, norm2(omega))
      call make_variations(system, ways(m)%parameters, columns)
      call tangent%begin(system, state, columns, status)
      if (status%ok()) call make_stepper(system, ways(m)%settings, stepper, status)
      before = state
      if (status%ok()) call stepper%step(system, state, dt, status)
      if (.not. status%ok()) return
      call stepper%propagate(system, before, state, dt, 0.5_wp*dt, tangent, status)
      if (.not. status%ok()) call note(tally, m, number, 0, trim(status%message), aloud)
      call prepare_oracle(ways(m), oracle)
      call oracle%begin(p, before%q, dt, ok)
      if (.not. ok) return
      if (maxval(abs(real(oracle%rotation, wp) - rotation_matrix(quat_normalized(state%q)))) > other_root) return
      tally%steps(m) = tally%steps(m) + 1
      largest = max(1.0_wp, maxval(abs(tangent%theta)), maxval(abs(tangent%momentum)))
      do i = 1, ways(m)%columns
         k = i
         if (ways(m)%columns < ways(m)%parameters) k = 1 + int(ways(m)%parameters*random_unit(random))
         call oracle%differ(k, exact, ok)
         if (.not. ok) cycle
         error = maxval(abs([tangent%theta(k, :), tangent%momentum(k, :)] - real(exact, wp)))/largest**2
         tally%columns(m) = tally%columns(m) + 1
         tally%worst(m) = max(tally%worst(m), error)
         if (.not. error <= bound) call note(tally, m, number, k, 'is off', aloud, error)
      end do
   end subroutine try_case

   !> Notes a failure.
   subroutine note(tally, m, number, k, words, aloud, error)
      type(tally_t), intent(inout) :: tally
      !> Method, case and column.
      integer, intent(in) :: m, number, k
      character(len=*), intent(in) :: words
      logical, intent(in), optional :: aloud
      real(wp), intent(in), optional :: error
      character(len=120) :: line
      write (line, '("case ",i0," (",a,"), column ",i0," ",a)') number, trim(ways(m)%name), k, words
      if (present(error)) write (line(len_trim(line) + 1:), '(" by",es9.2)') error
      tally%failures(m) = tally%failures(m) + 1
      if (tally%message == '') tally%message = line
      if (present(aloud)) write (error_unit, '(a)') trim(line)
   end subroutine note

   !> The stages of a method.
   subroutine prepare_oracle(way, oracle)
      type(way_t), intent(in) :: way
      type(tangent_oracle_t), intent(inout) :: oracle
      integer :: i
      oracle%kind = way%kind
      select case (trim(way%settings%method))
      case ('nielsen_krenk')
         oracle%lengths = [1.0_wp]
         do i = 1, size(compositions)
            if (compositions(i)%order /= way%settings%order) cycle
            associate (weights => compositions(i)%weights(:(compositions(i)%stages + 1)/2))
               oracle%lengths = [weights, weights(size(weights) - 1:1:-1)]
            end associate
         end do
      case ('rk4')
         oracle%a = reshape([0.5_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.5_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])
         oracle%weights = [1.0_wp, 2.0_wp, 2.0_wp, 1.0_wp]/6
      case ('rk8', 'dop853')
         oracle%a = order_eight(:, :)
         oracle%weights = order_eight_weights
      case default
      end select
   end subroutine prepare_oracle

   !> A random body with effects, and its start.
   subroutine draw(seed, parameters, p, q, omega, system, status)
      integer(int64), intent(inout) :: seed
      !> `FREE`, `UNIFORM` or `FORCED`.
      integer, intent(in) :: parameters
      real(wp), intent(out) :: p(n_parameters), q(4), omega(3)
      type(system_t), intent(out) :: system
      type(status_t), intent(out) :: status
      real(wp) :: tensor(3, 3)
      integer :: i
      do i = 1, n_parameters
         p(i) = 2*random_unit(seed) - 1
      end do
      p(turn_at + 1:turn_at + 3) = 0.0_wp
      p(inertia_at + 1:inertia_at + 3) = 1.5_wp + 0.5_wp*p(inertia_at + 1:inertia_at + 3)
      p(inertia_at + 4:inertia_at + 6) = 0.2_wp*p(inertia_at + 4:inertia_at + 6)
      p(damping_at + 1:damping_at + 3) = 0.3_wp*abs(p(damping_at + 1:damping_at + 3))
      p(anchor_at + 1:anchor_at + 3) = 2.5_wp*p(anchor_at + 1:anchor_at + 3)
      p(stiffness_at + 1:length_at + 1) = abs(p(stiffness_at + 1:length_at + 1))
      do i = 1, 6
         tensor(place(1, i), place(2, i)) = p(inertia_at + i)
         tensor(place(2, i), place(1, i)) = p(inertia_at + i)
      end do
      q = random_unit_quaternion(seed)
      omega = 2*random_vector(seed)
      ! The spring has another discrete gradient if its ends can meet.
      if (abs(norm2(p(point_at + 1:point_at + 3)) - norm2(p(anchor_at + 1:anchor_at + 3))) &
          < 0.1_wp*norm2(p(anchor_at + 1:anchor_at + 3))) p(anchor_at + 1:anchor_at + 3) = [2.0_wp, 1.0_wp, -1.0_wp]
      p(parameters + 1:) = 0.0_wp
      call make_body(tensor, system%body, status, check_triangle=.false.)
      if (.not. status%ok() .or. parameters < UNIFORM) return
      call system%effects%add(rotor_t(name='rotor', momentum=p(rotor_at + 1:rotor_at + 3)))
      call system%effects%add(dipole_t(p(moment_at + 1:moment_at + 3), p(field_at + 1:field_at + 3)))
      if (parameters < FORCED) return
      call system%effects%add(damping_t(p(damping_at + 1:damping_at + 3)))
      call system%effects%add(spring_t(p(point_at + 1:point_at + 3), p(anchor_at + 1:anchor_at + 3), &
                                       p(stiffness_at + 1), p(length_at + 1)))
   end subroutine draw

   !> The columns of the parameters; L0 is held where one of the body changes, as the oracle does.
   subroutine make_variations(system, parameters, columns)
      type(system_t), intent(in) :: system
      integer, intent(in) :: parameters
      type(variation_t), allocatable, intent(out) :: columns(:)
      type(status_t) :: status
      real(wp) :: unit(3)
      integer :: i
      allocate (columns(parameters))
      do i = 1, 6
         columns(inertia_at + i) = inertia_variation(place(1, i), place(2, i))
      end do
      do i = 1, 3
         unit = 0.0_wp
         unit(i) = 1.0_wp
         columns(turn_at + i) = attitude_variation(i)
         columns(momentum_at + i) = rate_variation(i)
         columns(momentum_at + i)%angular_velocity = system%body%inverse_inertia(:, i)
         if (parameters < UNIFORM) cycle
         columns(rotor_at + i)%rotor = unit
         call columns(moment_at + i)%add(system%effects, 'dipole', 1, 'moment', unit, status)
         call columns(field_at + i)%add(system%effects, 'dipole', 1, 'field', unit, status)
         if (parameters < FORCED) cycle
         call columns(damping_at + i)%add(system%effects, 'damping', 1, 'coefficient', unit, status)
         call columns(point_at + i)%add(system%effects, 'spring', 1, 'body_point', unit, status)
         call columns(anchor_at + i)%add(system%effects, 'spring', 1, 'anchor', unit, status)
      end do
      if (parameters < FORCED) return
      call columns(stiffness_at + 1)%add(system%effects, 'spring', 1, 'stiffness', [1.0_wp], status)
      call columns(length_at + 1)%add(system%effects, 'spring', 1, 'rest_length', [1.0_wp], status)
   end subroutine make_variations

end module test_tangent_attack
