!> Inner spheres: trajectories computed in 34 digits, an oracle in 33 digits, closed forms, the energy balance and the
!> momentum with every method, orders, sensitivities.
submodule(suites_of_effects) test_inner_sphere
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: diagonal, make_body
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_inertia_change, only: inertia_change_t
   use nutate_inner_sphere, only: inner_sphere_t
   use nutate_kinds, only: wp, long, eps
   use nutate_limits, only: most_spheres
   use nutate_linearization, only: linearization_t, linearize_equilibrium
   use nutate_methods, only: integrator_settings_t, make_stepper, methods, stepper_t
   use nutate_quaternion, only: attitude_distance, cross, quat_exp, quat_product, rotate_to_body, rotate_to_space
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_rotor, only: rotor_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: NUTATE_BAD_ARGUMENT, status_t
   use nutate_tangent, only: tangent_t
   use nutate_variation, only: variation_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_inner_sphere, add_wheel
   use test_oracle, only: qp
   use test_problems, only: angular_velocity, body_momentum, conserved_energy, kinetic_energy, make_state, march, &
      new_problem, problem_t, space_momentum
   use test_resume, only: check_run, check_stepper, label_of, settings_of
   use test_support, only: check, check_below, check_close, error_type, in_turn, new_unittest, random_unit_quaternion, &
      random_vector, share_of
   implicit none

   real(wp), parameter :: first_attitude(4) = [0.5_wp, 0.1_wp, -0.7_wp, 0.5_wp]
   real(wp), parameter :: first_rate(3) = [0.8_wp, -0.6_wp, 1.4_wp], sphere_rate(3) = [0.2_wp, -0.1_wp, 0.5_wp]

   !> A body with a rotor, a dipole, damping and two spheres in the precision of the oracle.
   type :: exact_scene_t
      real(qp) :: inertia(3, 3) = 0, rotor(3) = 0, moment(3) = 0, field(3) = 0, damping(3) = 0
      !> I, c and ω at the start in space, or relative to the body in its axes.
      real(qp) :: sphere_inertia(2) = 1, friction(2) = 0, rate(3, 2) = 0
      real(qp) :: q(4) = 0, omega(3) = 0
   end type exact_scene_t

   !> Numbers of the state of the oracle: q, J Ω + h, and the momenta of the spheres in space.
   integer, parameter :: numbers = 13

contains

   module procedure collect_inner_sphere
      testsuite = [ &
                  new_unittest("one sphere has its reference trajectory", one_sphere), &
                  new_unittest("all that changes has its reference trajectory", everything_changes), &
                  new_unittest("a body ends on its major axis", major_axis), &
                  new_unittest("random scenes follow the oracle", random_scenes_follow), &
                  new_unittest("sensitivities are those of the oracle", sensitivities_follow), &
                  new_unittest("a spherical body has the closed form", spherical_body), &
                  new_unittest("every method closes the energy balance", every_method_balances), &
                  new_unittest("every method keeps the momentum", every_method_keeps_momentum), &
                  new_unittest("the methods have their orders", methods_have_their_orders), &
                  new_unittest("rotating axes show the same motion", rotating_axes), &
                  new_unittest("what is interrupted goes on bit for bit", runs_go_on), &
                  new_unittest("a sphere that is off rotates by itself", off_rotates_alone), &
                  new_unittest("wheels stand before spheres", wheels_come_first), &
                  new_unittest("what has no spheres rejects them", bad_spheres_are_rejected)]
   end procedure collect_inner_sphere

   !> A body with a sphere whose angular velocity in space is given.
   function body_with_sphere(moments, inertia, damping, omega, in_space) result(problem)
      real(wp), intent(in) :: moments(3), inertia, damping, omega(3)
      !> Shape (3).
      real(wp), intent(in), optional :: in_space(3)
      type(problem_t), pointer :: problem
      type(status_t) :: status
      real(wp) :: relative(3)
      problem => new_problem()
      call make_body(diagonal(moments), problem%system%body, status)
      relative = 0.0_wp
      if (present(in_space)) relative = rotate_to_body(first_attitude, in_space) - omega
      call add_inner_sphere(problem%system, inner_sphere_t(inertia, damping, relative), status)
      problem%start = make_state(problem%system, first_attitude, omega)
   end function body_with_sphere

   !> Trajectory C of the reference, t = 10 s.
   subroutine one_sphere(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      integer :: m
      problem => body_with_sphere([1.7_wp, 1.1_wp, 0.9_wp], 0.3_wp, 0.2_wp, first_rate, sphere_rate)
      do m = 1, size(methods)
         if (methods(m)%order < 8 .or. methods(m)%name == 'exact') cycle
         call make_stepper(problem%system, settings_of(methods(m)), stepper, status)
         state = problem%start
         call march(problem%system, stepper, state, 0.02_wp, 500, status)
         call check(error, status%ok(), trim(status%message))
         call check_below(error, attitude_distance(state%q, [0.49247634825305776341_wp, 0.58056144968524349736_wp, &
                                                              -0.64780866565997794179_wp, 0.02755689108989561658_wp]), &
                          1e-12_wp, label_of(methods(m)))
         call check_close(error, body_momentum(state) - state%wheel_momentum(1:3), &
                          [1.2977313716956363168_wp, 1.0647437429125462574_wp, 0.22143931505204331465_wp], 1e-12_wp, &
                          label_of(methods(m))//", L")
         call check_close(error, rotate_to_space(state%q, state%wheel_momentum(1:3)), &
                          [-0.16896804540135860658_wp, -0.13513737894468656267_wp, 0.30730232347535115317_wp], &
                          1e-12_wp, label_of(methods(m))//", l of the sphere")
         call check_close(error, kinetic_energy(problem%system, state), &
                          1.037876120787379797_wp + 0.23541171594690794533_wp, 1e-12_wp, label_of(methods(m))//", T")
         call check_close(error, space_momentum(state), [-0.9264_wp, -0.8652_wp, 1.634_wp], 1e-13_wp, "l")
      end do
   end subroutine one_sphere

   !> Trajectory D of the reference, t = 5 s: a varying inertia, two spheres, rotor, dipole and damping; with its
   !> derivatives by inertia and damping of the first sphere and by a factor of the rate of the inertia.
   subroutine everything_changes(error)
      type(error_type), allocatable, intent(out) :: error
      type(exact_scene_t) :: exact
      type(problem_t) :: problem
      type(state_t) :: state, before
      type(status_t) :: status
      type(variation_t) :: variations(3)
      type(tangent_t) :: tangent
      class(stepper_t), allocatable :: stepper
      real(wp), parameter :: k(6) = [0.03_wp, 0.08_wp, 0.05_wp, 0.01_wp, -0.02_wp, 0.0_wp]
      real(wp), parameter :: attitude(4) = [0.1435309243080899183_wp, 0.95796817914082307738_wp, &
                                            0.033451400008735375311_wp, -0.2461236383575069096_wp]
      real(wp), parameter :: rate(3) = [-0.92691593505520480223_wp, 0.86626480248473533302_wp, &
                                        -0.80849617407346799859_wp]
      real(wp), parameter :: momenta(6) = [ &
         -0.10610224284383396915_wp, -0.11596566501531548099_wp, 0.35389430502990711176_wp, &
         -0.021016255169009364332_wp, -0.030712417729807650882_wp, 0.063852560353181916763_wp]
      real(wp), parameter :: energy = 2.0345625894986529622_wp + 0.24991150088589536609_wp + 0.054620850477958553517_wp
      real(wp), parameter :: wanted(6, 3) = reshape([ &
         0.29047461849279_wp, 0.083551259744629_wp, -0.75718690814804_wp, 0.010598966961784_wp, 0.70919323479284_wp, &
         -0.52461299974994_wp, 0.72763536139516_wp, 0.79124552363397_wp, -0.81184695498149_wp, -0.28769520005493_wp, &
         0.73646647522552_wp, -0.028607453633042_wp, 0.002137513255146_wp, 0.26570266344882_wp, -0.43439964157049_wp, &
         -0.1223246612867_wp, 0.05161035118213_wp, 0.041726481237834_wp], [6, 3])
      integer :: i, m
      call make_scene(0, exact, problem)
      call problem%system%effects%add(inertia_change_t(k))
      call variations(1)%add(problem%system%effects, 'inner_sphere', 1, 'inertia', [1.0_wp], status)
      call variations(2)%add(problem%system%effects, 'inner_sphere', 1, 'damping', [1.0_wp], status)
      call variations(3)%add(problem%system%effects, 'inertia_rate', 1, 'tensor', k, status)
      call check(error, status%ok(), trim(status%message))
      do m = 1, size(methods)
         if (methods(m)%order < 8 .or. methods(m)%name == 'exact') cycle
         call make_stepper(problem%system, settings_of(methods(m)), stepper, status)
         state = problem%start
         call tangent%begin(problem%system, state, variations, status)
         do i = 1, 500
            before = state
            call stepper%step(problem%system, state, 0.01_wp, status)
            if (status%ok()) &
               call stepper%propagate(problem%system, before, state, 0.01_wp, before%t + 0.005_wp, tangent, status)
         end do
         call check(error, status%ok(), trim(status%message))
         call check_below(error, attitude_distance(state%q, attitude), 1e-12_wp, label_of(methods(m)))
         call check_close(error, angular_velocity(problem%system, state), rate, 1e-12_wp, label_of(methods(m)))
         call check_close(error, [rotate_to_space(state%q, state%wheel_momentum(1:3)), &
                                  rotate_to_space(state%q, state%wheel_momentum(4:6))], momenta, 1e-12_wp, &
                          label_of(methods(m))//", spheres")
         call check_close(error, kinetic_energy(problem%system, state), energy, 1e-11_wp, label_of(methods(m))//", T")
         do i = 1, 3
            call check_close(error, space_derivative(state, tangent, i), wanted(:, i), 1e-11_wp, &
                             label_of(methods(m))//' '//trim(variations(i)%name))
         end do
      end do
   end subroutine everything_changes

   !> Returns θ in space axes and the derivative of R L, L the momentum of the body alone.
   pure function space_derivative(state, tangent, i) result(derivative)
      type(state_t), intent(in) :: state
      type(tangent_t), intent(in) :: tangent
      integer, intent(in) :: i
      real(wp) :: derivative(6), own(3), change(3)
      own = body_momentum(state) - state%wheel_momentum(1:3) - state%wheel_momentum(4:6)
      change = tangent%momentum(i, :) - tangent%wheels(i, 1:3) - tangent%wheels(i, 4:6)
      derivative(1:3) = rotate_to_space(state%q, tangent%theta(i, :))
      derivative(4:6) = rotate_to_space(state%q, change + cross(tangent%theta(i, :), own))
   end function space_derivative

   !> Trajectory G of the reference: the spin about the minor axis becomes one about the major axis.
   subroutine major_axis(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      real(wp), parameter :: energies(3) = [2.31058028135922969_wp, 1.44473921119260572_wp, 1.4404490000058791_wp]
      real(wp), parameter :: rates(3, 3) = reshape([0.3525963819571018_wp, 0.1614359229739884_wp, &
         1.901684022940317_wp, 1.19599004325187_wp, -0.1364939110046587_wp, 0.04670904746102652_wp, &
         1.200187068746193_wp, 5.38203864099e-6_wp, 3.62890433035e-7_wp], [3, 3])
      integer, parameter :: steps(3) = [2500, 2500, 5000]
      integer :: i, m
      problem => body_with_sphere([1.7_wp, 1.1_wp, 0.9_wp], 0.3_wp, 0.5_wp, [0.02_wp, 0.01_wp, 2.0_wp])
      call check_close(error, norm2(space_momentum(problem%start)), 2.400374137504401625_wp, 1e-15_wp, "|l|")
      do m = 1, size(methods)
         if (methods(m)%order < 8 .or. methods(m)%name == 'exact' .or. .not. in_turn(m)) cycle
         call make_stepper(problem%system, settings_of(methods(m)), stepper, status)
         state = problem%start
         do i = 1, 3
            call march(problem%system, stepper, state, 0.02_wp, steps(i), status)
            call check(error, status%ok(), trim(status%message))
            call check_close(error, kinetic_energy(problem%system, state), energies(i), 1e-11_wp, &
                             label_of(methods(m))//", energy")
            call check_close(error, angular_velocity(problem%system, state), rates(:, i), 1e-11_wp, &
                             label_of(methods(m)))
         end do
      end do
   end subroutine major_axis

   !> A scene of the oracle as a system; J without K of trajectory D of the reference, unless a number is given.
   subroutine make_scene(number, exact, problem)
      !> 0: trajectory D; else a random scene.
      integer, intent(in) :: number
      type(exact_scene_t), intent(out) :: exact
      type(problem_t), intent(inout) :: problem
      type(problem_t), pointer :: empty
      type(status_t) :: status
      real(wp) :: tensor(3, 3), rotor(3), moment(3), field(3), damping(3), inertia(2), friction(2), rate(3, 2), q(4), &
         omega(3), x(3)
      integer(int64) :: seed
      empty => new_problem()
      problem = empty
      tensor = reshape([2.0_wp, 0.1_wp, 0.2_wp, 0.1_wp, 1.5_wp, -0.05_wp, 0.2_wp, -0.05_wp, 1.0_wp], [3, 3])
      rotor = [0.1_wp, -0.4_wp, 0.2_wp]
      moment = [0.3_wp, 0.1_wp, 1.0_wp]
      field = [0.1_wp, 0.0_wp, -1.0_wp]
      damping = [0.02_wp, 0.01_wp, 0.03_wp]
      inertia = [0.3_wp, 0.05_wp]
      friction = [0.2_wp, 0.2_wp]
      q = first_attitude
      omega = first_rate
      rate(:, 1) = rotate_to_body(q, sphere_rate) - omega
      rate(:, 2) = 0.0_wp
      if (number > 0) then
         seed = 7_int64*number
         q = random_unit_quaternion(seed)
         omega = random_vector(seed)
         rate(:, 1) = random_vector(seed)
         rate(:, 2) = random_vector(seed)
         rotor = random_vector(seed)
         field = random_vector(seed)
         x = random_vector(seed)
         inertia = 10**(0.7_wp*x(1:2) - 0.5_wp)
         friction = 10**(0.5_wp*x(2:3) - 1)
      end if
      exact = exact_scene_t(inertia=real(tensor, qp), rotor=real(rotor, qp), moment=real(moment, qp), &
                            field=real(field, qp), damping=real(damping, qp), sphere_inertia=real(inertia, qp), &
                            friction=real(friction, qp), rate=real(rate, qp), q=real(q, qp)/norm2(real(q, qp)), &
                            omega=real(omega, qp))
      call make_body(tensor, problem%system%body, status)
      call problem%system%effects%add(rotor_t(name='rotor', momentum=rotor))
      call problem%system%effects%add(dipole_t(moment, field))
      call problem%system%effects%add(damping_t(damping))
      call add_inner_sphere(problem%system, inner_sphere_t(inertia(1), friction(1), rate(:, 1)), status)
      call add_inner_sphere(problem%system, inner_sphere_t(inertia(2), friction(2), rate(:, 2)), status)
      problem%start = make_state(problem%system, q, omega)
   end subroutine make_scene

   !> Both forms of the conserving scheme, explicit methods and series against the oracle.
   subroutine random_scenes_follow(error)
      type(error_type), allocatable, intent(out) :: error
      type(exact_scene_t) :: exact
      type(problem_t) :: problem
      type(state_t) :: state
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      real(qp) :: y(numbers)
      integer :: i, m
      do i = 0, 8
         call make_scene(i, exact, problem)
         y = followed(exact, 2.0_qp)
         do m = 1, size(methods)
            if (methods(m)%order < 8 .or. methods(m)%name == 'exact' .or. .not. in_turn(m + i)) cycle
            call make_stepper(problem%system, settings_of(methods(m)), stepper, status)
            state = problem%start
            call march(problem%system, stepper, state, 0.01_wp, 200, status)
            call check(error, status%ok(), trim(status%message))
            call check_below(error, attitude_distance(state%q, real(y(1:4), wp)), 1e-12_wp, label_of(methods(m)))
            call check_close(error, rotate_to_space(state%q, state%wheel_momentum(1:3)), real(y(8:10), wp), &
                             1e-12_wp*(1 + norm2(real(y(8:10), wp))), label_of(methods(m))//", sphere 1")
            call check_close(error, rotate_to_space(state%q, state%wheel_momentum(4:6)), real(y(11:13), wp), &
                             1e-12_wp*(1 + norm2(real(y(11:13), wp))), label_of(methods(m))//", sphere 2")
         end do
      end do
   end subroutine random_scenes_follow

   !> Derivatives with respect to I, c and the rates of a sphere, differences of the oracle over 1e-10.
   subroutine sensitivities_follow(error)
      type(error_type), allocatable, intent(out) :: error
      real(qp), parameter :: shift = 1e-10_qp
      type(exact_scene_t) :: exact, moved
      type(problem_t) :: problem
      type(state_t) :: state, before
      type(status_t) :: status
      type(variation_t) :: variations(3)
      type(tangent_t) :: tangent
      class(stepper_t), allocatable :: stepper
      real(wp) :: wanted(12, 3), found(12)
      integer :: i, k, m
      call make_scene(0, exact, problem)
      call variations(1)%add(problem%system%effects, 'inner_sphere', 1, 'inertia', [1.0_wp], status)
      call variations(2)%add(problem%system%effects, 'inner_sphere', 2, 'damping', [1.0_wp], status)
      call variations(3)%add(problem%system%effects, 'inner_sphere', 1, 'angular_velocity', &
                             [1.0_wp, -0.5_wp, 0.25_wp], status)
      call check(error, status%ok(), trim(status%message))
      do k = 1, 3
         wanted(:, k) = 0.0_wp
         do i = -1, 1, 2
            moved = exact
            if (k == 1) moved%sphere_inertia(1) = exact%sphere_inertia(1) + i*shift
            if (k == 2) moved%friction(2) = exact%friction(2) + i*shift
            if (k == 3) moved%rate(:, 1) = exact%rate(:, 1) + i*shift*[1.0_qp, -0.5_qp, 0.25_qp]
            wanted(:, k) = wanted(:, k) &
                           + real(i*in_body(followed(moved, 2.0_qp), followed(exact, 2.0_qp))/(2*shift), wp)
         end do
      end do
      do m = 1, size(methods)
         if (methods(m)%order < 8 .or. methods(m)%name == 'exact') cycle
         call make_stepper(problem%system, settings_of(methods(m)), stepper, status)
         state = problem%start
         call tangent%begin(problem%system, state, variations, status)
         do i = 1, 200
            before = state
            call stepper%step(problem%system, state, 0.01_wp, status)
            if (status%ok()) call stepper%propagate(problem%system, before, state, 0.01_wp, before%t + 0.005_wp, &
                                                    tangent, status)
         end do
         call check(error, status%ok(), trim(status%message))
         do k = 1, 3
            found = [tangent%theta(k, :), tangent%momentum(k, :), tangent%wheels(k, :)]
            call check_close(error, found, wanted(:, k), 1e-11_wp, label_of(methods(m))//' '//trim(variations(k)%name))
         end do
      end do
   end subroutine sensitivities_follow

   !> A sphere in a body of equal moments j: ω of the sphere relative to the body falls as exp(-ct(1/j + 1/I)) in space.
   subroutine spherical_body(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      real(wp) :: relative(3), first(3)
      integer :: m
      problem => body_with_sphere([1.5_wp, 1.5_wp, 1.5_wp], 0.4_wp, 0.3_wp, first_rate, sphere_rate)
      first = sphere_rate - rotate_to_space(first_attitude, first_rate)
      do m = 1, size(methods)
         if (methods(m)%order < 8 .or. methods(m)%name == 'exact') cycle
         call make_stepper(problem%system, settings_of(methods(m)), stepper, status)
         state = problem%start
         call march(problem%system, stepper, state, 0.02_wp, 100, status)
         call check(error, status%ok(), trim(status%message))
         relative = rotate_to_space(state%q, state%wheel_momentum(1:3)/0.4_wp - angular_velocity(problem%system, state))
         call check_close(error, relative, exp(-0.6_wp*(1/1.5_wp + 1/0.4_wp))*first, 1e-12_wp, label_of(methods(m)))
      end do
   end subroutine spherical_body

   !> Two spheres, a wheel with friction, a rotor, a dipole and damping; the space axes rotate if asked.
   function crowded_body(rate) result(problem)
      real(wp), intent(in), optional :: rate(3)
      type(problem_t), pointer :: problem
      type(exact_scene_t) :: exact
      type(status_t) :: status
      type(wheel_t) :: wheel
      problem => new_problem()
      call make_scene(0, exact, problem)
      wheel = wheel_t(name='wheel', axis=[2.0_wp, -1.0_wp, 2.0_wp]/3, inertia=0.1_wp, speed=5.0_wp, friction=0.05_wp)
      allocate (wheel%motor, source=applied_torque_t(amplitude=[0.5_wp, 0.0_wp, 0.0_wp], frequency=0.3_wp))
      call add_wheel(problem%system, wheel, status)
      if (present(rate)) call problem%system%effects%add(rotating_frame_t(rate=rate))
      problem%start = make_state(problem%system, first_attitude, first_rate)
   end function crowded_body

   !> H - H(0) - work, in axes at rest and in rotating axes.
   subroutine every_method_balances(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      integer :: m, k
      do k = 1, 2
         if (k == 1) problem => crowded_body()
         if (k == 2) problem => crowded_body([0.3_wp, -0.2_wp, 0.5_wp])
         do m = 1, size(methods)
            if (methods(m)%name == 'exact' .or. .not. methods(m)%conserving) cycle
            call check_balance(error, problem, settings_of(methods(m)), label_of(methods(m)))
         end do
         call check_balance(error, problem, integrator_settings_t(formulation='reduced'), "reduced")
         call check_balance(error, problem, integrator_settings_t(inverse_auxiliary_inertia=1/60.0_wp), "finite J0")
      end do
   end subroutine every_method_balances

   subroutine check_balance(error, problem, settings, label)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      type(integrator_settings_t), intent(in) :: settings
      character(len=*), intent(in) :: label
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: work, first, size_of
      integer :: i
      call make_stepper(problem%system, settings, stepper, status)
      call check(error, status%ok(), label//": "//trim(status%message))
      if (allocated(error)) return
      state = problem%start
      first = conserved_energy(problem%system, state, settings%inverse_auxiliary_inertia)
      size_of = abs(first) + kinetic_energy(problem%system, state)
      work = 0.0_wp
      do i = 1, share_of(1000)
         call stepper%step(problem%system, state, 0.02_wp, status)
         call check(error, status%ok(), label//": "//trim(status%message))
         work = work + sum(stepper%work)
         call check_below(error, abs(conserved_energy(problem%system, state, settings%inverse_auxiliary_inertia) &
                                     - first - work), 256*eps*size_of, label//", energy")
      end do
      call check(error, all(state%wheel_work(2, 2:7) < 0.0_wp) .and. &
                 .not. any(abs(state%wheel_work(1, 2:7)) > 0.0_wp), label//", works")
   end subroutine check_balance

   !> Spheres leave all of l alone.
   subroutine every_method_keeps_momentum(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      integer :: m
      problem => body_with_sphere([1.7_wp, 1.1_wp, 0.9_wp], 0.3_wp, 0.2_wp, first_rate, sphere_rate)
      do m = 1, size(methods)
         if (methods(m)%name == 'exact' .or. .not. methods(m)%conserving) cycle
         call check_momentum(error, problem, settings_of(methods(m)), label_of(methods(m)))
      end do
      call check_momentum(error, problem, integrator_settings_t(formulation='reduced'), "reduced")
   end subroutine every_method_keeps_momentum

   subroutine check_momentum(error, problem, settings, label)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      type(integrator_settings_t), intent(in) :: settings
      character(len=*), intent(in) :: label
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: momentum(3)
      momentum = space_momentum(problem%start)
      call make_stepper(problem%system, settings, stepper, status)
      state = problem%start
      call march(problem%system, stepper, state, 0.02_wp, share_of(10000), status)
      call check(error, status%ok(), trim(status%message))
      call check_below(error, norm2(space_momentum(state) - momentum), 64*eps*norm2(momentum), label)
   end subroutine check_momentum

   !> Errors at two steps against the oracle.
   subroutine methods_have_their_orders(error)
      type(error_type), allocatable, intent(out) :: error
      type(exact_scene_t) :: exact
      type(problem_t) :: problem
      type(state_t) :: state
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      real(wp) :: steps(2), errors(2), order
      real(qp) :: y(numbers)
      integer :: m, k
      call make_scene(0, exact, problem)
      y = followed(exact, 3.2_qp)
      do m = 1, size(methods)
         if (methods(m)%name == 'exact' .or. methods(m)%name == 'taylor') cycle
         steps = [0.02_wp, 0.01_wp]
         if (methods(m)%order > 2) steps = 2**(methods(m)%order/2)*steps
         do k = 1, 2
            call make_stepper(problem%system, settings_of(methods(m)), stepper, status)
            state = problem%start
            call march(problem%system, stepper, state, steps(k), nint(3.2_wp/steps(k)), status)
            call check(error, status%ok(), trim(status%message))
            errors(k) = attitude_distance(state%q, real(y(1:4), wp)) &
                        + norm2(rotate_to_space(state%q, state%wheel_momentum(1:3)) - real(y(8:10), wp))
         end do
         order = log(errors(1)/errors(2))/log(2.0_wp)
         call check(error, abs(order - methods(m)%order) < 0.6_wp, label_of(methods(m)))
      end do
   end subroutine methods_have_their_orders

   !> A free body seen from rotating axes and from axes at rest: both forms, explicit methods and series.
   subroutine rotating_axes(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(problem_t) :: seen
      type(state_t) :: state
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      real(wp), parameter :: rate(3) = [0.3_wp, -0.2_wp, 0.5_wp], end = 2.0_wp
      real(wp) :: q(4), momentum(3)
      integer :: m
      problem => body_with_sphere([1.7_wp, 1.1_wp, 0.9_wp], 0.3_wp, 0.2_wp, first_rate, sphere_rate)
      call make_stepper(problem%system, integrator_settings_t(method='taylor', formulation='', order=16, &
                                                               conserve=.true.), stepper, status)
      state = problem%start
      call march(problem%system, stepper, state, 0.02_wp, 100, status)
      q = quat_product(quat_exp(-0.5_wp*end*rate), state%q)
      momentum = state%wheel_momentum(1:3)
      seen = problem
      call seen%system%effects%add(rotating_frame_t(rate=rate))
      ! With an effect the methods integrate the equations of the rotating axes themselves.
      call seen%system%effects%add(damping_t([0.0_wp, 0.0_wp, 0.0_wp]))
      do m = 1, size(methods)
         if (methods(m)%order < 8 .or. methods(m)%name == 'exact') cycle
         call make_stepper(seen%system, settings_of(methods(m)), stepper, status)
         state = seen%start
         call march(seen%system, stepper, state, 0.02_wp, nint(end/0.02_wp), status)
         call check(error, status%ok(), trim(status%message))
         call check_below(error, attitude_distance(state%q, q), 1e-12_wp, label_of(methods(m)))
         call check_close(error, state%wheel_momentum(1:3), momentum, 1e-12_wp, label_of(methods(m))//", sphere")
      end do
   end subroutine rotating_axes

   !> Steppers, and runs with fixed and with adaptive steps.
   subroutine runs_go_on(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_plan_t), parameter :: controlled = run_plan_t(goal=run_goal_t(local_tolerance=1e-9_wp), &
                                                             end_time=3.0_wp)
      type(problem_t), pointer :: problem
      integer :: m
      problem => crowded_body()
      do m = 1, size(methods)
         if (methods(m)%name == 'exact' .or. .not. in_turn(m)) cycle
         call check_stepper(error, problem, settings_of(methods(m)), [0.01_wp, 0.01_wp, 0.02_wp], &
                            [0.02_wp, 0.02_wp, 0.015_wp, 0.015_wp], label_of(methods(m)))
         call check_run(error, problem, settings_of(methods(m)), run_plan_t(time_step=0.01_wp, end_time=0.403_wp, &
                        every=3_long), [1, 10, 25, 39], label_of(methods(m)))
         call check_run(error, problem, settings_of(methods(m)), controlled, [1, 2], label_of(methods(m)))
      end do
   end subroutine runs_go_on

   !> Without friction the sphere keeps its momentum in space, and the body moves as if it were alone.
   subroutine off_rotates_alone(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem, alone
      type(state_t) :: state, other
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      integer :: m
      alone => new_problem()
      problem => body_with_sphere([1.7_wp, 1.1_wp, 0.9_wp], 0.3_wp, 0.2_wp, first_rate, sphere_rate)
      problem%system%effects%wheels%label = 'core'
      call problem%system%effects%switch('core', .false.)
      call make_body(diagonal([1.7_wp, 1.1_wp, 0.9_wp]), alone%system%body, status)
      do m = 1, size(methods)
         if (methods(m)%order < 8 .or. methods(m)%name == 'exact') cycle
         call make_stepper(problem%system, settings_of(methods(m)), stepper, status)
         state = problem%start
         call march(problem%system, stepper, state, 0.02_wp, 200, status)
         call make_stepper(alone%system, settings_of(methods(m)), stepper, status)
         other = make_state(alone%system, first_attitude, first_rate)
         call march(alone%system, stepper, other, 0.02_wp, 200, status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, rotate_to_space(state%q, state%wheel_momentum(1:3)), 0.3_wp*sphere_rate, 1e-12_wp, &
                          label_of(methods(m)))
         call check_below(error, attitude_distance(state%q, other%q), 1e-11_wp, label_of(methods(m))//", body")
         call check(error, .not. any(abs(state%wheel_work) > 0.0_wp), label_of(methods(m))//", work")
      end do
      call problem%system%effects%switch('core')
      call check_close(error, problem%system%effects%wheels(2)%friction, 0.2_wp, 0.0_wp, "on again")
   end subroutine off_rotates_alone

   !> The momenta of wheels come before those of spheres, whichever was added first.
   subroutine wheels_come_first(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      problem => crowded_body()
      associate (effects => problem%system%effects)
         call check(error, all([effects%n_wheels, effects%n_spheres, effects%n_reaction_wheels] == [7, 2, 1]), &
                    "numbers")
         call check(error, all(effects%wheels%component == [0, 1, 2, 3, 1, 2, 3]), "order")
         call check_close(error, effects%wheels%inertia, [0.1_wp, 0.3_wp, 0.3_wp, 0.3_wp, 0.05_wp, 0.05_wp, 0.05_wp], &
                          0.0_wp, "inertia")
      end associate
   end subroutine wheels_come_first

   subroutine bad_spheres_are_rejected(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(status_t) :: status
      type(linearization_t) :: linear
      class(stepper_t), allocatable :: stepper
      integer :: i
      problem => body_with_sphere([1.7_wp, 1.1_wp, 0.9_wp], 0.3_wp, 0.2_wp, first_rate)
      call add_inner_sphere(problem%system, inner_sphere_t(0.0_wp, 0.2_wp), status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, "no inertia")
      call add_inner_sphere(problem%system, inner_sphere_t(0.3_wp, -0.2_wp), status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, "negative damping")
      call make_stepper(problem%system, integrator_settings_t(method='exact', formulation=''), stepper, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, "exact")
      call make_stepper(problem%system, integrator_settings_t(projection=.false., inverse_auxiliary_inertia=1.0_wp), &
                        stepper, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, "without projection")
      call linearize_equilibrium(problem%system, problem%start, 1.0_wp, linear, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, "linear system")
      do i = 2, most_spheres + 1
         call check(error, problem%system%effects%n_spheres, i - 1, "number of spheres")
         call add_inner_sphere(problem%system, inner_sphere_t(0.3_wp, 0.2_wp), status)
      end do
      call check(error, status%code, NUTATE_BAD_ARGUMENT, "too many")
      call check(error, problem%system%effects%n_spheres, most_spheres, "most spheres")
   end subroutine bad_spheres_are_rejected

   !> The state of a scene at a time, by Gragg's extrapolation.
   function followed(scene, end) result(y)
      type(exact_scene_t), intent(in) :: scene
      real(qp), intent(in) :: end
      real(qp) :: y(numbers)
      integer, parameter :: columns = 12, parts = 16
      real(qp) :: table(numbers, columns), before(numbers), now(numbers), next(numbers), saved(numbers), h
      integer :: i, j, k
      y(1:4) = scene%q
      y(5:7) = matmul(scene%inertia, scene%omega) + scene%rotor
      do i = 1, 2
         y(5 + 3*i:7 + 3*i) = scene%sphere_inertia(i)*matmul(matrix_of(scene%q), scene%omega + scene%rate(:, i))
      end do
      do i = 1, parts
         do j = 1, columns
            h = end/(2*j*parts)
            before = y
            now = y + h*rates(scene, y)
            do k = 2, 2*j
               next = before + 2*h*rates(scene, now)
               before = now
               now = next
            end do
            do k = 1, j - 1
               saved = table(:, k)
               table(:, k) = now
               now = now + (now - saved)/((real(j, qp)/(j - k))**2 - 1)
            end do
            table(:, j) = now
         end do
         y = table(:, columns)
      end do
   end function followed

   !> q̇ = ½ q∘Ω, L̇ = L×Ω + m×RᵀB - cΩ + Σ c(Rᵀl/I - Ω), l̇ = -R c(Rᵀl/I - Ω), L without the spheres.
   function rates(scene, y)
      type(exact_scene_t), intent(in) :: scene
      real(qp), intent(in) :: y(numbers)
      real(qp) :: rates(numbers)
      real(qp) :: omega(3), tau(3), turn(3, 3), friction(3)
      integer :: i
      turn = matrix_of(y(1:4))
      omega = solved(scene%inertia, y(5:7) - scene%rotor)
      tau = across(scene%moment, matmul(scene%field, turn)) - scene%damping*omega
      do i = 1, 2
         associate (l => y(5 + 3*i:7 + 3*i))
            friction = scene%friction(i)*(matmul(l, turn)/scene%sphere_inertia(i) - omega)
            rates(5 + 3*i:7 + 3*i) = -matmul(turn, friction)
         end associate
         tau = tau + friction
      end do
      rates(1) = -dot_product(y(2:4), omega)/2
      rates(2:4) = (y(1)*omega + across(y(2:4), omega))/2
      rates(5:7) = across(y(5:7), omega) + tau
   end function rates

   !> R of a quaternion of any length.
   pure function matrix_of(q) result(r)
      real(qp), intent(in) :: q(4)
      real(qp) :: r(3, 3)
      integer :: i
      do i = 1, 3
         r(:, i) = 0
         r(i, i) = 1
         r(:, i) = r(:, i) + 2*(q(1)*across(q(2:4), r(:, i)) + across(q(2:4), across(q(2:4), r(:, i))))/sum(q**2)
      end do
   end function matrix_of

   pure function across(a, b) result(c)
      real(qp), intent(in) :: a(3), b(3)
      real(qp) :: c(3)
      c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
   end function across

   !> A⁻¹v of a symmetric matrix.
   pure function solved(a, v) result(x)
      real(qp), intent(in) :: a(3, 3), v(3)
      real(qp) :: x(3), rows(3, 3)
      rows(:, 1) = across(a(:, 2), a(:, 3))
      rows(:, 2) = across(a(:, 3), a(:, 1))
      rows(:, 3) = across(a(:, 1), a(:, 2))
      x = matmul(rows, v)/dot_product(rows(:, 1), a(:, 1))
   end function solved

   !> Small difference of two states, as sensitivities have it: θ, δL with the spheres and δh, body axes.
   function in_body(y, from) result(difference)
      real(qp), intent(in) :: y(numbers), from(numbers)
      real(qp) :: difference(12), turn(3, 3), other(3, 3)
      turn = matrix_of(y(1:4))
      other = matrix_of(from(1:4))
      difference(1:3) = 2*(from(1)*y(2:4) - y(1)*from(2:4) - across(from(2:4), y(2:4)))/sum(from(1:4)**2)
      difference(7:9) = matmul(y(8:10), turn) - matmul(from(8:10), other)
      difference(10:12) = matmul(y(11:13), turn) - matmul(from(11:13), other)
      difference(4:6) = y(5:7) - from(5:7) + difference(7:9) + difference(10:12)
   end function in_body

end submodule test_inner_sphere
