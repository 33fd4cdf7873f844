!> Quantities that every effect must conserve, to round-off: the energy balance, and the momentum about its direction.
submodule(suites_of_effects) test_effects
   use nutate_applied_torque, only: applied_torque_t
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_gravity, only: gravity_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_invariants, only: ALONG_AXIS, invariants_t, NO_COMPONENT
   use nutate_kinds, only: wp
   use nutate_nielsen_krenk, only: nielsen_krenk_t
   use nutate_rotor, only: rotor_t
   use nutate_spring, only: spring_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_effect_samples, only: effect_samples_t, quartic_t, sample_body
   use test_problems, only: make_state, new_problem, problem_t, solve, space_momentum, system_t
   use test_support, only: check, check_below, check_close, error_type, in_turn, new_unittest, share_of
   implicit none

   !> A start in the middle of everything.
   real(wp), parameter :: tilted(4) = [0.5_wp, -0.5_wp, 0.1_wp, 0.7_wp], rotating(3) = [0.7_wp, -1.1_wp, 0.9_wp]

contains

   module procedure collect_effects
      testsuite = [ &
                  new_unittest("energy balance closes for every combination", account_closes_for_every_combination), &
                  new_unittest("energy balance closes with opposite signs", account_closes_with_opposite_signs), &
                  new_unittest("energy balance closes through a spring's anchor", account_closes_through_the_anchor), &
                  new_unittest("each potential keeps momentum about its direction", each_potential_keeps_its_own), &
                  new_unittest("potentials of one direction keep it together", parallel_potentials_keep_it), &
                  new_unittest("inclined directions keep no component", inclined_directions_keep_none), &
                  new_unittest("a user's potential keeps energy and momentum", users_potential_keeps_invariants), &
                  new_unittest("effects of zero strength do nothing", zero_strengths_do_nothing), &
                  new_unittest("several effects of a kind add up", effects_of_a_kind_add_up)]
   end procedure collect_effects

   !> All combinations of the kinds, with J0 infinite and finite; of those with the kinds that only an orbit has, which
   !> are three out of four, fewer steps. In `make test` each kind by itself, a third of the pairs, a ninth of the
   !> others, and fewer steps still.
   subroutine account_closes_for_every_combination(error)
      type(error_type), allocatable, intent(out) :: error
      type(effect_samples_t) :: samples
      type(system_t), pointer :: system
      integer :: combination, k, steps
      call samples%load(error)
      if (allocated(error)) return
      do combination = 0, 2**size(samples%names) - 1
         if (samples%is_excluded(combination)) cycle
         if (popcnt(combination) > 1 .and. .not. in_turn(combination)) cycle
         if (popcnt(combination) > 2 .and. .not. in_turn(combination/3)) cycle
         system => sample_body()
         steps = share_of(150)
         if (btest(combination, samples%position('earth_field') - 1) .or. &
             btest(combination, samples%position('force') - 1) .or. &
             btest(combination, samples%position('inner_sphere') - 1)) steps = share_of(40)
         if (btest(combination, samples%position('inertia_rate') - 1)) steps = share_of(20)
         do k = 1, size(samples%names)
            if (btest(combination, k - 1)) call samples%add(system, k)
         end do
         call check_account(error, system, 0.0_wp, steps)
         call check_account(error, system, 1/60.0_wp, steps)
      end do
   end subroutine account_closes_for_every_combination

   !> H - H(0) - work stays within 1e-13 of T + |V|.
   subroutine check_account(error, system, inverse_j0, n, q)
      type(error_type), allocatable, intent(inout) :: error
      type(system_t), intent(in) :: system
      !> 1/J0, kg⁻¹ m⁻².
      real(wp), intent(in) :: inverse_j0
      !> Steps of 0.05 s.
      integer, intent(in) :: n
      !> Attitude at the start, if not the tilted one.
      real(wp), intent(in), optional :: q(4)
      type(nielsen_krenk_t) :: stepper
      type(integrator_settings_t) :: settings
      type(invariants_t) :: invariants
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: work
      integer :: i
      settings%inverse_auxiliary_inertia = inverse_j0
      call stepper%prepare(system, settings, status)
      state = make_state(system, tilted, rotating)
      if (present(q)) state = make_state(system, q, rotating)
      call invariants%start(system, state, inverse_j0)
      work = 0.0_wp
      do i = 1, n
         call stepper%step(system, state, 0.05_wp, status)
         call check(error, status%ok(), trim(status%message))
         work = work + sum(stepper%work)
         call invariants%measure(system, state, work)
      end do
      call check_below(error, invariants%energy_error(), 1e-13_wp, "energy balance")
   end subroutine check_account

   !> Negative stiffness, strength and damping: motion that gains energy.
   subroutine account_closes_with_opposite_signs(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      system => sample_body()
      call system%effects%add(gravity_gradient_t(system%body, [1.0_wp, 2.0_wp, -1.0_wp], -0.4_wp))
      call system%effects%add(spring_t([0.4_wp, 0.1_wp, -0.6_wp], [0.5_wp, 1.0_wp, -0.8_wp], -5.0_wp, 0.7_wp))
      call system%effects%add(dipole_t([-0.5_wp, 1.0_wp, -2.0_wp], [1.0_wp, 0.5_wp, -0.3_wp]))
      call system%effects%add(damping_t([-0.3_wp, 0.1_wp, -0.2_wp]))
      call check_account(error, system, 0.0_wp, 200)
   end subroutine account_closes_with_opposite_signs

   !> The spring starts with both ends in one point, with and without rest length, and comes back near it.
   subroutine account_closes_through_the_anchor(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      real(wp), parameter :: identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], point(3) = [0.4_wp, 0.1_wp, -0.6_wp]
      integer :: i
      do i = 0, 1
         system => sample_body()
         call system%effects%add(spring_t(point, point, 60.0_wp, 0.2_wp*i))
         call check_account(error, system, 0.0_wp, 300, identity)
      end do
   end subroutine account_closes_through_the_anchor

   !> l·n within 1e-13 of |l|, while the rest of l changes.
   subroutine each_potential_keeps_its_own(error)
      type(error_type), allocatable, intent(out) :: error
      type(effect_samples_t) :: samples
      type(system_t), pointer :: system
      integer :: i
      call samples%load(error)
      if (allocated(error)) return
      do i = 1, size(samples%potentials)
         system => sample_body()
         call samples%add(system, samples%potentials(i))
         call samples%add(system, samples%position('rotor'))
         call check_component(error, system, trim(samples%names(samples%potentials(i))))
      end do
   end subroutine each_potential_keeps_its_own

   subroutine parallel_potentials_keep_it(error)
      type(error_type), allocatable, intent(out) :: error
      type(effect_samples_t) :: samples
      type(system_t), pointer :: system
      real(wp), parameter :: n(3) = [0.3_wp, -0.2_wp, 0.25_wp]
      integer :: i, k
      call samples%load(error)
      if (allocated(error)) return
      do i = 1, size(samples%potentials)
         do k = i + 1, size(samples%potentials)
            system => sample_body()
            call samples%add(system, samples%potentials(i), n)
            call samples%add(system, samples%potentials(k), n)
            call check_component(error, system, pair_name(samples, i, k))
         end do
      end do
   end subroutine parallel_potentials_keep_it

   !> Two potentials by name.
   function pair_name(samples, i, k) result(name)
      type(effect_samples_t), intent(in) :: samples
      !> Positions among the potentials.
      integer, intent(in) :: i, k
      character(len=:), allocatable :: name
      name = trim(samples%names(samples%potentials(i)))//" and "//trim(samples%names(samples%potentials(k)))
   end function pair_name

   subroutine check_component(error, system, label)
      type(error_type), allocatable, intent(inout) :: error
      type(system_t), intent(in) :: system
      character(len=*), intent(in) :: label
      type(nielsen_krenk_t) :: stepper
      type(invariants_t) :: invariants
      type(state_t) :: state
      type(status_t) :: status
      integer :: i
      call stepper%prepare(system, integrator_settings_t(), status)
      state = make_state(system, tilted, rotating)
      call invariants%start(system, state)
      call check(error, invariants%components, ALONG_AXIS, label//": conserved components")
      do i = 1, 300
         call stepper%step(system, state, 0.05_wp, status)
         call check(error, status%ok(), label//": "//trim(status%message))
         call invariants%measure(system, state)
      end do
      call check_below(error, invariants%momentum_error(), 1e-13_wp, label//", along the direction")
      call check_below(error, invariants%energy_error(), 1e-13_wp, label//", energy")
      call check(error, norm2(space_momentum(state) - invariants%momentum) > 1e-3_wp*invariants%momentum_scale, &
                 label//": the rest of the momentum should change")
   end subroutine check_component

   !> Two potentials whose directions differ: neither direction keeps its component, nor does what they have in common.
   subroutine inclined_directions_keep_none(error)
      type(error_type), allocatable, intent(out) :: error
      type(effect_samples_t) :: samples
      type(problem_t), pointer :: problem
      type(invariants_t) :: invariants
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: change(3), n(3)
      integer :: i, j, k
      problem => new_problem()
      call samples%load(error)
      if (allocated(error)) return
      do i = 1, size(samples%potentials)
         do k = i + 1, size(samples%potentials)
            problem%system = sample_body()
            call samples%add(problem%system, samples%potentials(i))
            call samples%add(problem%system, samples%potentials(k))
            problem%start = make_state(problem%system, tilted, rotating)
            call invariants%start(problem%system, problem%start)
            call check(error, invariants%components, NO_COMPONENT)
            call solve(problem, 0.05_wp, 40, state, status)
            change = space_momentum(state) - space_momentum(problem%start)
            do j = 1, 2
               n = problem%system%effects%potentials(j)%item%direction
               call check(error, abs(dot_product(change, n)) > 1e-3_wp*norm2(n)*norm2(space_momentum(state)), &
                          pair_name(samples, i, k)//" keep momentum")
            end do
         end do
      end do
   end subroutine inclined_directions_keep_none

   subroutine users_potential_keeps_invariants(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(quartic_t) :: quartic
      system => sample_body()
      quartic%direction = [0.6_wp, -0.5_wp, 0.9_wp]
      call system%effects%add(quartic)
      call check_component(error, system, "user's potential")
   end subroutine users_potential_keeps_invariants

   subroutine zero_strengths_do_nothing(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: free
      type(problem_t) :: problem
      type(state_t) :: expected, state
      type(status_t) :: status
      real(wp), parameter :: none(3) = 0.0_wp, n(3) = [0.6_wp, -0.5_wp, 0.9_wp]
      free => new_problem()
      free%system = sample_body()
      free%start = make_state(free%system, tilted, rotating)
      call solve(free, 0.05_wp, 100, expected, status)
      problem = free
      associate (effects => problem%system%effects, body => problem%system%body)
         call effects%add(gravity_t(body, none))
         call effects%add(dipole_t(none, n))
         call effects%add(dipole_t(n, none))
         call effects%add(gravity_gradient_t(body, n, 0.0_wp))
         call effects%add(spring_t(n, n, 0.0_wp, 0.5_wp))
         call effects%add(spring_t(n, none, 3.0_wp, 0.5_wp))
         call effects%add(spring_t(none, n, 3.0_wp, 0.5_wp))
         call effects%add(spring_t(none, none, 3.0_wp, 0.5_wp))
         call effects%add(damping_t(none))
         call effects%add(applied_torque_t(amplitude=none))
         call effects%add(rotor_t(momentum=none))
      end associate
      call solve(problem, 0.05_wp, 100, state, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, [state%q, state%p], [expected%q, expected%p], 1e-12_wp, "state of the free body")
   end subroutine zero_strengths_do_nothing

   !> Two of a kind against one of their sum.
   subroutine effects_of_a_kind_add_up(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: one
      type(problem_t) :: two
      type(state_t) :: a, b
      type(status_t) :: status
      real(wp), parameter :: m1(3) = [0.5_wp, -1.0_wp, 2.0_wp], m2(3) = [1.5_wp, 0.5_wp, -1.0_wp], &
                             n(3) = [0.6_wp, -0.5_wp, 0.9_wp]
      one => new_problem()
      one%system = sample_body()
      two = one
      associate (sum => one%system%effects, parts => two%system%effects, body => one%system%body)
         call sum%add(dipole_t(m1 + m2, n))
         call parts%add(dipole_t(m1, n))
         call parts%add(dipole_t(m2, n))
         call sum%add(gravity_gradient_t(body, n, 0.5_wp))
         call parts%add(gravity_gradient_t(body, n, 0.75_wp))
         call parts%add(gravity_gradient_t(body, -2*n, -0.25_wp))
         call sum%add(spring_t(m1, n, 5.0_wp, 0.5_wp))
         call parts%add(spring_t(m1, n, 3.0_wp, 0.5_wp))
         call parts%add(spring_t(m1, n, 2.0_wp, 0.5_wp))
         call sum%add(damping_t(0.1_wp*abs(m1 + m2)))
         call parts%add(damping_t(0.1_wp*(m1 + m2)))
         call parts%add(damping_t(0.1_wp*(abs(m1 + m2) - (m1 + m2))))
         call sum%add(applied_torque_t(amplitude=m1 - m2))
         call parts%add(applied_torque_t(amplitude=m1))
         call parts%add(applied_torque_t(amplitude=-m2))
         call sum%add(rotor_t(momentum=m1 + m2))
         call parts%add(rotor_t(momentum=m1))
         call parts%add(rotor_t(momentum=m2))
      end associate
      one%start = make_state(one%system, tilted, rotating)
      two%start = make_state(two%system, tilted, rotating)
      call solve(one, 0.02_wp, 100, a, status)
      call solve(two, 0.02_wp, 100, b, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, [b%q, b%p], [a%q, a%p], 1e-12_wp, "state")
   end subroutine effects_of_a_kind_add_up

end submodule test_effects
