!> Parts of the proof that a root is the true one: the bounds of every effect, against the effect in steps drawn at
!> random; the bundled scenes, whose steps are all certified at once; and cases beyond a proof.
submodule(suites_of_methods) test_root_proof
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: body_t, diagonal, make_body
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_discrete_forces, only: discrete_forces_t
   use nutate_effect, only: effect_t, potential_t, torque_t
   use nutate_effect_bounds, only: effect_bounds_t, linear_map_t, map_of, spectral_norm
   use nutate_effect_list, only: effect_list_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: integrator_settings_t, make_stepper, methods, stepper_t
   use nutate_quaternion, only: rotate_to_body
   use nutate_run, only: integrate, observer_t, run_record_t, run_summary_t
   use nutate_run_plan, only: run_plan_t
   use nutate_scene, only: read_scene, scene_t
   use nutate_spring, only: spring_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_timed_force, only: timed_force_t
   use test_problems, only: make_state, new_system, system_t
   use test_support, only: check, check_below, error_type, new_unittest, random_unit, random_unit_quaternion, &
                           random_vector, scene_names, share_of, test_failed
   implicit none

   !> U = (a·γ)³/|a|³: within |γ| ≤ |n| its derivatives are bounded by 3|n|², 6|n| and 6.
   type, extends(potential_t) :: cubic_potential_t
      real(wp) :: axis(3) = 0.0_wp
   contains
      procedure :: energy => cubic_energy
      procedure :: gradient => cubic_gradient
   end type cubic_potential_t

   !> Rᵀν cos t: a torque fixed in space that nothing is known of but what is given.
   type, extends(torque_t) :: space_torque_t
      real(wp) :: amplitude(3) = 0.0_wp
   contains
      procedure :: torque => space_torque
   end type space_torque_t

   !> Largest quotients of what an effect does and its bounds: force, slope, curvature, and change with time.
   type :: quotients_t
      real(wp) :: force = 0.0_wp, slope = 0.0_wp, curvature = 0.0_wp, change = 0.0_wp
   end type quotients_t

   !> Length over which differences are taken.
   real(wp), parameter :: spacing = 1e-3_wp

   !> Keeps the lengths that were tried by continuation.
   type, extends(observer_t) :: effort_t
      integer :: continued = 0
   contains
      procedure :: observe => note_effort
   end type effort_t

contains

   module procedure collect_root_proof
      testsuite = [ &
                  new_unittest("spectral norms are those of random maps", norms_are_spectral), &
                  new_unittest("uniform fields keep to their bounds", linear_keeps_to_bounds), &
                  new_unittest("gravity gradients keep to their bounds", gradient_keeps_to_bounds), &
                  new_unittest("springs keep to their bounds", spring_keeps_to_bounds), &
                  new_unittest("springs whose ends can meet keep to their bounds", close_spring_keeps_to_bounds), &
                  new_unittest("torques keep to their bounds", torques_keep_to_bounds), &
                  new_unittest("damping keeps to its bounds", damping_keeps_to_bounds), &
                  new_unittest("user-defined potentials keep to given bounds", own_potential_keeps_to_bounds), &
                  new_unittest("torques of one's own keep to given bounds", own_torque_keeps_to_bounds), &
                  new_unittest("the scenes that come along are certified at once", scenes_are_certified_at_once), &
                  new_unittest("an effect without bounds is not certified, with bounds it is", bounds_make_the_proof), &
                  new_unittest("a state off the manifold is not certified", off_manifold_is_not_certified)]
   end procedure collect_root_proof

   pure real(wp) function cubic_energy(self, gamma)
      class(cubic_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      cubic_energy = (dot_product(self%axis, gamma)/norm2(self%axis))**3
   end function cubic_energy

   pure function cubic_gradient(self, gamma) result(gradient)
      class(cubic_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: gradient(3)
      gradient = 3*(dot_product(self%axis, gamma)/norm2(self%axis))**2*self%axis/norm2(self%axis)
   end function cubic_gradient

   pure function space_torque(self, t, q, omega) result(tau)
      class(space_torque_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = cos(t)*rotate_to_body(q, self%amplitude)
   end function space_torque

   subroutine note_effort(self, system, state, record, status)
      class(effort_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      self%continued = int(record%continued)
   end subroutine note_effort

   !> |Av| never exceeds ‖A‖|v| and comes within 1 % of it for the best of many v.
   subroutine norms_are_spectral(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: a(3, 3), v(3), ratio
      integer :: i, k
      seed = 11
      do i = 1, 50
         do k = 1, 3
            a(:, k) = random_vector(seed)*10.0_wp**(4*random_unit(seed))
         end do
         v = random_vector(seed)
         do k = 1, 200
            v = matmul(transpose(a), matmul(a, v))
            v = v/norm2(v)
         end do
         ratio = norm2(matmul(a, v))/spectral_norm(a)
         ! Power iteration converges from below; the norm is rounded upwards.
         call check_below(error, ratio, 1.0_wp, 'quotient of length and norm')
         call check_below(error, 1 - ratio, 1e-2_wp, 'what the norm exceeds')
      end do
   end subroutine norms_are_spectral

   subroutine linear_keeps_to_bounds(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      type(quotients_t) :: most
      integer :: i
      seed = 21
      do i = 1, 20
         call sample(dipole_t(random_vector(seed), random_vector(seed)), seed, most)
      end do
      call assess_quotients(error, most)
   end subroutine linear_keeps_to_bounds

   subroutine gradient_keeps_to_bounds(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      type(quotients_t) :: most
      integer :: i
      seed = 22
      do i = 1, 20
         call sample(gravity_gradient_t(random_body(seed), random_vector(seed), random_unit(seed) - 0.5_wp), seed, most)
      end do
      ! The components of the gradient are bounded one by one: γ cannot make all of them large.
      call assess_quotients(error, most, least=0.3_wp)
   end subroutine gradient_keeps_to_bounds

   subroutine spring_keeps_to_bounds(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      type(quotients_t) :: most
      integer :: i
      seed = 23
      do i = 1, 20
         call sample(spring_t(0.5_wp*random_vector(seed), [1.2_wp, 0.0_wp, 0.0_wp] + random_vector(seed), 3.0_wp, &
                              2*random_unit(seed)), seed, most)
         call sample(spring_t(random_vector(seed), random_vector(seed), 3.0_wp), seed, most)
      end do
      call assess_quotients(error, most)
   end subroutine spring_keeps_to_bounds

   subroutine close_spring_keeps_to_bounds(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      type(quotients_t) :: most
      real(wp) :: x(3), a(3)
      integer :: i
      seed = 24
      do i = 1, 60
         x = random_vector(seed)
         a = random_vector(seed)
         a = a*(norm2(x)/norm2(a))
         call sample(spring_t(x, a, 3.0_wp, 2*random_unit(seed)), seed, most)
         call sample(spring_t(x, a, 3.0_wp), seed, most)
      end do
      call assess_quotients(error, most)
   end subroutine close_spring_keeps_to_bounds

   !> In body axes, in space axes, and of forces that turn with an orbit.
   subroutine torques_keep_to_bounds(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      type(quotients_t) :: in_body, in_space, along
      type(timed_force_t) :: force
      integer :: i
      force%moves = .true.
      force%force%path = kepler_orbit_t(mu=20.0_wp, eccentricity=0.2_wp, mean_anomaly=3.0_wp)
      seed = 25
      do i = 1, 20
         call sample(applied_torque_t(amplitude=random_vector(seed), frequency=random_unit(seed)), seed, in_body)
         call sample(applied_torque_t(amplitude=random_vector(seed), frequency=random_unit(seed), phase=1.0_wp, &
                                      in_space=.true.), seed, in_space)
         force%body_point = random_vector(seed)
         force%force%vector = random_vector(seed)
         call sample(force, seed, along)
      end do
      call assess_quotients(error, in_body)
      call assess_quotients(error, in_space)
      call assess_quotients(error, along)
      call check(error, min(in_body%change, in_space%change, along%change) > 0.5_wp, 'nothing changed')
   end subroutine torques_keep_to_bounds

   subroutine damping_keeps_to_bounds(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      type(quotients_t) :: most
      integer :: i
      seed = 26
      do i = 1, 20
         call sample(damping_t(random_vector(seed)), seed, most)
      end do
      call assess_quotients(error, most)
   end subroutine damping_keeps_to_bounds

   subroutine own_potential_keeps_to_bounds(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      type(quotients_t) :: most
      type(cubic_potential_t) :: cubic
      real(wp) :: n
      integer :: i
      seed = 27
      do i = 1, 20
         cubic%axis = random_vector(seed)
         cubic%direction = random_vector(seed)
         n = norm2(cubic%direction)
         cubic%given = [3*n*n, 6*n, 6.0_wp, 0.0_wp]
         call sample(cubic, seed, most)
      end do
      ! Bounds for any potential cannot be as sharp.
      call assess_quotients(error, most, least=0.1_wp)
   end subroutine own_potential_keeps_to_bounds

   subroutine own_torque_keeps_to_bounds(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      type(quotients_t) :: most
      type(space_torque_t) :: torque
      real(wp) :: size
      integer :: i
      seed = 28
      do i = 1, 20
         torque%amplitude = random_vector(seed)
         size = norm2(torque%amplitude)
         torque%given = [size, size, size, 1.0_wp]
         call sample(torque, seed, most)
      end do
      call assess_quotients(error, most, least=0.1_wp)
   end subroutine own_torque_keeps_to_bounds

   !> No quotient exceeds 1, and bounds are not much larger than what is seen: forces come within `least` of theirs,
   !> derivatives within a third of that.
   subroutine assess_quotients(error, most, least)
      type(error_type), allocatable, intent(inout) :: error
      type(quotients_t), intent(in) :: most
      !> Default 0.6.
      real(wp), intent(in), optional :: least
      real(wp) :: nearest
      nearest = 0.6_wp
      if (present(least)) nearest = least
      call check_below(error, most%force, 1 + 64*eps, 'force over its bound')
      ! Differences have the rounding of T over the spacing, and over its square.
      call check_below(error, most%slope, 1 + 64*eps/spacing, 'slope over its bound')
      call check_below(error, most%curvature, 1 + 256*eps/spacing**2, 'curvature over its bound')
      call check_below(error, most%change, 1 + 64*eps/spacing, 'change over its bound')
      call check(error, most%force > nearest, 'the bound of the force is too wide')
      call check(error, most%slope > nearest/3, 'the bound of the slope is too wide')
      call check(error, most%curvature > nearest/6, 'the bound of the curvature is too wide')
   end subroutine assess_quotients

   !> Draws steps and maps, and compares what an effect does in them with its bounds.
   subroutine sample(effect, seed, most)
      class(effect_t), intent(in) :: effect
      integer(int64), intent(inout) :: seed
      type(quotients_t), intent(inout) :: most
      type(effect_list_t) :: effects
      type(discrete_forces_t) :: forces
      type(effect_bounds_t) :: bounds
      type(linear_map_t) :: map
      type(body_t) :: body
      real(wp) :: radius, gamma(3), b(3), d(3), e(3), q(4)
      integer :: i, k
      call effects%add(effect)
      call forces%prepare(effects, .true.)
      body = random_body(seed)
      do i = 1, share_of(20)
         q = random_unit_quaternion(seed)
         call forces%start(effects, 0.7_wp, q, 1.0_wp, 0.7_wp)
         map = map_of(reshape([random_vector(seed), random_vector(seed), random_vector(seed)], [3, 3]), body%axes)
         select type (effect)
         type is (gravity_gradient_t)
            map = map_of(map%matrix, axes_of(effect%stiffness))
         end select
         radius = 0.02_wp + 0.5_wp*random_unit(seed)
         gamma = 0.0_wp
         if (allocated(forces%gamma0)) then
            if (size(forces%gamma0, 2) > 0) gamma = forces%gamma0(:, 1)
         end if
         call effect%bound(map, radius, gamma, 0.0_wp, bounds)
         if (.not. bounds%known) cycle
         do k = 1, 20
            b = (radius - 2*spacing)*unit_of(random_vector(seed))*random_unit(seed)**(1.0_wp/6)
            d = spacing*unit_of(random_vector(seed))
            e = spacing*unit_of(random_vector(seed))
            call compare(effects, forces, map, bounds, b, d, e, most)
         end do
      end do
   end subroutine sample

   !> One step: T at b, its differences along d, mixed ones along d and e, and in time.
   subroutine compare(effects, forces, map, bounds, b, d, e, most)
      type(effect_list_t), intent(in) :: effects
      type(discrete_forces_t), intent(inout) :: forces
      type(linear_map_t), intent(in) :: map
      type(effect_bounds_t), intent(in) :: bounds
      real(wp), intent(in) :: b(3), d(3), e(3)
      type(quotients_t), intent(inout) :: most
      real(wp) :: first(3), second(3), t
      first = (image(b + d) - image(b - d))/(2*spacing)
      second = (image(b + d + e) - image(b + d - e) - image(b - d + e) + image(b - d - e))/(4*spacing**2)
      most%force = max(most%force, norm2(image(b))/(bounds%force + bounds%drag))
      most%slope = max(most%slope, norm2(first)/(bounds%slope + bounds%drag_slope))
      most%curvature = max(most%curvature, norm2(second)/(bounds%curvature + bounds%drag_curvature))
      if (.not. bounds%change > 0.0_wp) return
      t = forces%t
      forces%t = t + spacing
      first = image(b)
      forces%t = t - spacing
      first = (first - image(b))/(2*spacing)
      forces%t = t
      most%change = max(most%change, norm2(first)/bounds%change)

   contains

      !> A T(b) at a rate of b/s: there damping gives -T_D.
      function image(x) result(value)
         real(wp), intent(in) :: x(3)
         real(wp) :: value(3), tau(3)
         call forces%turn(effects, x, 1.0_wp, tau)
         value = matmul(map%matrix, (1 + dot_product(x, x))*tau - 2*dot_product(x, tau)*x)
      end function image

   end subroutine compare

   pure function unit_of(v) result(u)
      real(wp), intent(in) :: v(3)
      real(wp) :: u(3)
      u = v/norm2(v)
   end function unit_of

   !> A body with axes of its own.
   type(body_t) function random_body(seed) result(body)
      integer(int64), intent(inout) :: seed
      type(status_t) :: status
      real(wp) :: q(4), columns(3, 3), moments(3)
      integer :: i
      q = random_unit_quaternion(seed)
      moments = 1 + 0.9_wp*random_vector(seed)
      do i = 1, 3
         columns(:, i) = 0.0_wp
         columns(i, i) = 1.0_wp
         columns(:, i) = rotate_to_body(q, columns(:, i))
      end do
      columns = matmul(columns, matmul(diagonal(moments), transpose(columns)))
      call make_body(0.5_wp*(columns + transpose(columns)), body, status, check_triangle=.false.)
   end function random_body

   !> Principal axes of a symmetric matrix: those of a body with it as part of its inertia.
   function axes_of(matrix) result(axes)
      real(wp), intent(in) :: matrix(3, 3)
      real(wp) :: axes(3, 3)
      type(body_t) :: body
      type(status_t) :: status
      call make_body(matrix + diagonal([1.0_wp, 1.0_wp, 1.0_wp])*(1 + 2*sum(abs(matrix))), body, status, &
                     check_triangle=.false.)
      axes = body%axes
   end function axes_of

   !> Checks every conserving method of every order and solver, at the scene's own step: no step requires continuation.
   subroutine scenes_are_certified_at_once(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      type(run_summary_t) :: summary
      type(run_plan_t) :: plan
      type(state_t) :: state
      type(effort_t) :: effort
      character(len=:), allocatable :: message
      integer :: i, row
      allocate (scene)
      do i = 1, size(scene_names)
         call read_scene('scenes/'//trim(scene_names(i))//'.nml', scene, status, message)
         if (.not. status%ok()) call test_failed(error, message)
         do row = 1, size(methods)
            if (methods(row)%name /= 'nielsen_krenk') cycle
            scene%integrator%method = methods(row)%name
            scene%integrator%formulation = methods(row)%formulation
            scene%integrator%order = methods(row)%order
            plan%time_step = scene%plan%time_step
            plan%end_time = scene%initial%t + min(scene%plan%end_time - scene%initial%t, &
                                                  share_of(400)*plan%time_step)
            state = scene%initial
            effort%continued = 0
            call integrate(scene%system, scene%integrator, state, plan, status, effort, summary)
            call check(error, status%ok() .and. effort%continued == 0 .and. summary%uncertified_steps == 0, &
                       trim(scene_names(i))//' is not certified at once by '//trim(methods(row)%formulation))
         end do
      end do
   end subroutine scenes_are_certified_at_once

   !> A top in a cubic potential of its own: every step counts as not certified, unless bounds are given.
   subroutine bounds_make_the_proof(error)
      type(error_type), allocatable, intent(out) :: error
      type(cubic_potential_t) :: cubic
      type(run_summary_t) :: summary
      integer :: steps
      cubic%axis = [0.2_wp, -0.4_wp, 1.0_wp]
      cubic%direction = [0.0_wp, 0.0_wp, 1.0_wp]
      steps = 20
      call run_top(cubic, summary)
      call check(error, int(summary%uncertified_steps), steps)
      cubic%given = [3.0_wp, 6.0_wp, 6.0_wp, 0.0_wp]
      call run_top(cubic, summary)
      call check(error, int(summary%uncertified_steps), 0)

   contains

      subroutine run_top(effect, summary)
         class(effect_t), intent(in) :: effect
         type(run_summary_t), intent(out) :: summary
         type(system_t) :: system
         type(status_t) :: status
         type(state_t) :: state
         type(run_plan_t) :: plan
         type(integrator_settings_t) :: settings
         call make_body(diagonal([2.0_wp, 3.0_wp, 4.0_wp]), system%body, status)
         call system%effects%add(effect)
         state = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.3_wp, 0.2_wp, -1.0_wp])
         plan%time_step = 0.05_wp
         plan%end_time = steps*plan%time_step
         settings%formulation = 'reduced'
         call integrate(system, settings, state, plan, status, summary=summary)
      end subroutine run_top

   end subroutine bounds_make_the_proof

   !> q·p ≠ 0 with a finite J0: |q| changes in the step, which the proof does not know.
   subroutine off_manifold_is_not_certified(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(status_t) :: status
      type(state_t) :: state
      type(integrator_settings_t) :: settings
      class(stepper_t), allocatable :: stepper
      system => new_system()
      call make_body(diagonal([2.0_wp, 3.0_wp, 4.0_wp]), system%body, status)
      settings%inverse_auxiliary_inertia = 0.2_wp
      state = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.3_wp, 0.2_wp, -1.0_wp])
      state%p = state%p + 0.5_wp*state%q
      call make_stepper(system, settings, stepper, status)
      call stepper%step(system, state, 0.1_wp, status)
      call check(error, status%ok() .and. stepper%uncertified == 1, 'a state off the manifold counts as certified')
      state = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.3_wp, 0.2_wp, -1.0_wp])
      call stepper%prepare(system, settings, status)
      call stepper%step(system, state, 0.1_wp, status)
      call check(error, status%ok() .and. stepper%uncertified == 0, 'a free body is not certified')
   end subroutine off_manifold_is_not_certified

end submodule test_root_proof
