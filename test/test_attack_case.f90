!> Cases of the randomised stress test of the true root: bodies, effects, states and steps, each case from its seed and
!> number alone.
!>
!> A case is kept as plain numbers, from which the library's system is made, and from which `test_attack_oracle` writes
!> its own equations.
module test_attack_case
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: make_body
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_effect, only: potential_t, torque_t
   use nutate_gravity, only: gravity_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_inertia_change, only: inertia_change_t
   use nutate_inner_sphere, only: inner_sphere_t
   use nutate_kinds, only: wp, pi
   use nutate_quaternion, only: rotate_to_body, rotation_matrix
   use nutate_rotor, only: rotor_t
   use nutate_spring, only: spring_t
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   use nutate_wheel_mounting, only: add_inner_sphere
   use test_support, only: random_unit, random_unit_quaternion, random_vector
   implicit none
   private

   public :: attack_effect_t, attack_case_t, custom_potential_t, custom_torque_t, draw_case, make_system, most_effects
   public :: GRAVITY, DIPOLE, GRADIENT, SPRING, POLYNOMIAL, BODY_TORQUE, SPACE_TORQUE, DAMPING, FEEDBACK
   public :: effect_kinds

   !> Kinds of effects; a rotor is the body's `rotor`.
   integer, parameter :: GRAVITY = 1, DIPOLE = 2, GRADIENT = 3, SPRING = 4, POLYNOMIAL = 5, BODY_TORQUE = 6, &
      SPACE_TORQUE = 7, DAMPING = 8, FEEDBACK = 9
   integer, parameter :: effect_kinds = 9
   integer, parameter :: most_effects = 3
   !> One case in so many has inner spheres or an inertia that varies, and most spheres.
   integer, parameter, public :: changing_one_in = 4, most_drawn_spheres = 2

   !> One effect.
   type :: attack_effect_t
      integer :: kind = 0
      !> n, space axes: acceleration, field, unit vector to the centre, anchor, unit vector; amplitude of a torque in
      !> the axes of its kind; unit vector of the test's own; shape (3).
      real(wp) :: n(3) = 0.0_wp
      !> m, body axes: mass times centre of mass, dipole moment, point of a spring, axis of the potential or torque of
      !> the test's own; coefficients of damping; shape (3).
      real(wp) :: m(3) = 0.0_wp
      !> μ/r³, s⁻²; stiffness, N/m; size of the potential, J, or torque, N m, of the test's own.
      real(wp) :: strength = 0.0_wp
      real(wp) :: rest_length = 0.0_wp
      !> Hz, rad, s.
      real(wp) :: frequency = 0.0_wp, phase = 0.0_wp, start = -huge(1.0_wp), stop = huge(1.0_wp)
      !> The potential or torque of the test's own comes with bounds.
      logical :: bounded = .false.
   end type attack_effect_t

   !> One case: what is stepped, from where, and how.
   type :: attack_case_t
      !> Principal moments, kg m², and the attitude of the principal axes in the body's, scalar first.
      real(wp) :: moments(3) = 1.0_wp, axes(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> The moments may break the triangle rule.
      logical :: check_triangle = .true.
      !> h, body axes, N m s; shape (3).
      real(wp) :: rotor(3) = 0.0_wp
      integer :: n_effects = 0
      type(attack_effect_t) :: effects(most_effects)
      !> Inner spheres: inertia, kg m², damping, N m s, and rate relative to the body, rad/s.
      integer :: n_spheres = 0
      real(wp) :: sphere_inertia(most_drawn_spheres) = 1.0_wp, friction(most_drawn_spheres) = 0.0_wp, &
         sphere_rate(3, most_drawn_spheres) = 0.0_wp
      !> dJ/dt between two times, kg m²/s, s; whether the mass leaves.
      real(wp) :: inertia_rate(3, 3) = 0.0_wp, change_start = -huge(1.0_wp), change_stop = huge(1.0_wp)
      logical :: mass_leaves = .false.
      !> First state: body→space; body axes, rad/s; s.
      real(wp) :: q(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], omega(3) = 0.0_wp, t = 0.0_wp
      !> Step, s; order; steps at most.
      real(wp) :: dt = 0.0_wp
      integer :: order = 2, steps = 1
      !> 1/J0 of the 8×8 form, kg⁻¹ m⁻².
      real(wp) :: inverse_j0 = 0.0_wp
   contains
      procedure :: inertia
   end type attack_case_t

   !> User-defined potential without closed forms: U(γ) = e ((a·γ)³ - γ1γ2), n a unit vector. The discrete gradient is
   !> Gonzalez's.
   type, extends(potential_t) :: custom_potential_t
      real(wp) :: axis(3) = 0.0_wp, size = 0.0_wp
   contains
      procedure :: energy => custom_energy
      procedure :: gradient => custom_gradient
   end type custom_potential_t

   !> A torque of a user, a feedback of the attitude with a gain that goes up and down: τ = e cos(2πft + φ) (a·γ)γ,
   !> γ = Rᵀn, a and n unit vectors. It has no potential.
   type, extends(torque_t) :: custom_torque_t
      !> n, space axes; a, body axes; shape (3).
      real(wp) :: direction(3) = 0.0_wp, axis(3) = 0.0_wp
      real(wp) :: size = 0.0_wp, frequency = 0.0_wp, phase = 0.0_wp
   contains
      procedure :: torque => custom_torque
   end type custom_torque_t

contains

   pure function custom_torque(self, t, q, omega) result(tau)
      class(custom_torque_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3), gamma(3)
      gamma = rotate_to_body(q, self%direction)
      tau = (self%size*cos(2*pi*self%frequency*t + self%phase)*dot_product(self%axis, gamma))*gamma
   end function custom_torque

   pure real(wp) function custom_energy(self, gamma)
      class(custom_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      custom_energy = self%size*(dot_product(self%axis, gamma)**3 - gamma(1)*gamma(2))
   end function custom_energy

   pure function custom_gradient(self, gamma) result(gradient)
      class(custom_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: gradient(3)
      gradient = self%size*(3*dot_product(self%axis, gamma)**2*self%axis - [gamma(2), gamma(1), 0.0_wp])
   end function custom_gradient

   !> Case `number` of a seed: what comes out depends on these two only.
   subroutine draw_case(seed, number, item, changes)
      integer, intent(in) :: seed, number
      type(attack_case_t), intent(out) :: item
      !> One case in four has inner spheres or an inertia that varies; default `.false.`.
      logical, intent(in), optional :: changes
      integer(int64) :: state
      type(attack_effect_t) :: effect
      real(wp) :: rate, part, size
      integer :: i
      state = ieor(ieor(ishft(int(seed, int64), 32), int(number, int64)), 88172645463325252_int64)
      do i = 1, 16
         part = random_unit(state)
      end do
      call draw_body(state, item)
      item%q = random_unit_quaternion(state)
      rate = 10.0_wp**between(state, -1.0_wp, 1.0_wp)
      item%omega = rate*draw_direction(state)
      item%t = between(state, -10.0_wp, 10.0_wp)
      if (random_unit(state) < 0.15_wp) &
         item%rotor = between(state, 0.0_wp, 3.0_wp)*rate*minval(item%moments)*draw_direction(state)
      item%dt = 0.1_wp*60.0_wp**random_unit(state)/rate
      if (random_unit(state) < 0.2_wp) item%dt = -item%dt
      call draw_method(state, item)
      item%n_effects = 0
      if (random_unit(state) >= 0.05_wp) item%n_effects = 1 + int(3*random_unit(state))
      do i = 1, item%n_effects
         ! A third of the effects is moderate, the rest strong; between the least and the middle moment.
         size = 0.03_wp*1000.0_wp**random_unit(state)
         if (random_unit(state) < 0.33_wp) size = 0.03_wp*33.0_wp**random_unit(state)
         part = max(0.0_wp, between(state, -1.0_wp, 1.0_wp))
         size = size*rate**2*minval(item%moments)**(1 - part)*middle_of(item%moments)**part
         call draw_effect(state, item, size, rate, effect)
         item%effects(i) = effect
      end do
      if (.not. present(changes)) return
      if (changes .and. modulo(number, changing_one_in) == 0) call draw_changes(state, rate, item)
   end subroutine draw_case

   !> Inner spheres, an inertia that varies, or both.
   subroutine draw_changes(state, rate, item)
      integer(int64), intent(inout) :: state
      !> |Ω|, rad/s.
      real(wp), intent(in) :: rate
      type(attack_case_t), intent(inout) :: item
      real(wp) :: most, share
      integer :: i
      share = random_unit(state)
      if (share < 0.67_wp .or. any(item%effects(:item%n_effects)%kind == GRADIENT)) then
         item%n_spheres = 1 + int(most_drawn_spheres*random_unit(state))
         ! Friction over ½Δt; stages back in time come near its singularity, but do not reach it.
         most = 2.0_wp
         if (item%dt < 0.0_wp .or. item%order > 2) most = -0.6_wp
         do i = 1, item%n_spheres
            item%sphere_inertia(i) = 10.0_wp**between(state, -2.0_wp, 1.0_wp)*middle_of(item%moments)
            item%friction(i) = 10.0_wp**between(state, -3.0_wp, most)*item%sphere_inertia(i)/(0.5_wp*abs(item%dt))
            item%sphere_rate(:, i) = (rate*10.0_wp**between(state, -2.0_wp, 0.5_wp))*draw_direction(state)
         end do
      end if
      if (share > 0.33_wp .and. .not. any(item%effects(:item%n_effects)%kind == GRADIENT)) &
         call draw_inertia_rate(state, item)
   end subroutine draw_changes

   !> A rate G M Gᵀ of the inertia GGᵀ, M so small that the inertia stays positive. The case begins at t = 0.
   subroutine draw_inertia_rate(state, item)
      integer(int64), intent(inout) :: state
      type(attack_case_t), intent(inout) :: item
      real(wp) :: g(3, 3), m(3, 3), span
      integer :: i
      item%effects%start = item%effects%start - merge(item%t, 0.0_wp, item%effects%start > -huge(1.0_wp))
      item%effects%stop = item%effects%stop - merge(item%t, 0.0_wp, item%effects%stop < huge(1.0_wp))
      item%t = 0.0_wp
      g = rotation_matrix(item%axes)
      do i = 1, 3
         g(:, i) = g(:, i)*sqrt(item%moments(i))
         m(:, i) = random_vector(state)
      end do
      span = 2*abs(item%dt)*(item%steps + 1)
      m = m + transpose(m)
      m = m*(10.0_wp**between(state, -2.5_wp, -0.1_wp)/(norm2(m)*span))
      item%inertia_rate = matmul(g, matmul(m, transpose(g)))
      item%mass_leaves = random_unit(state) < 0.5_wp
      if (item%mass_leaves) return
      if (random_unit(state) < 0.67_wp) return
      item%change_start = item%dt*random_unit(state)
      item%change_stop = item%change_start + abs(item%dt)*between(state, 0.1_wp, 2.0_wp)
   end subroutine draw_inertia_rate

   !> Moments and axes: general, at the triangle limit, symmetric, rods, nearly equal, and such as break the rule.
   subroutine draw_body(state, item)
      integer(int64), intent(inout) :: state
      type(attack_case_t), intent(inout) :: item
      real(wp) :: a, b, c, unit
      unit = 10.0_wp**between(state, -2.0_wp, 2.0_wp)
      a = 10.0_wp**between(state, -2.0_wp, 0.0_wp)
      b = 10.0_wp**between(state, -2.0_wp, 0.0_wp)
      c = 10.0_wp**between(state, -2.0_wp, 0.0_wp)
      select case (int(7*random_unit(state)))
      case (0, 1)
         item%moments = [b + c, c + a, a + b]
      case (2)
         ! The third is between the difference and the sum of the others, next to the sum.
         item%moments = [a, b, a + b - 2*min(a, b)*10.0_wp**between(state, -12.0_wp, -0.1_wp)]
      case (3)
         item%moments = [a, a*(1 + 1e-4_wp*int(2*random_unit(state))), 2*a*between(state, 1e-3_wp, 1.0_wp)]
      case (4)
         item%moments = [10.0_wp**between(state, -3.0_wp, -1.0_wp), 1.0_wp, 1 + 1e-4_wp*random_unit(state)]
      case (5)
         item%moments = 1 + 0.2_wp*[a, b, c]
      case default
         item%moments = [a, b, c]
         if (random_unit(state) < 0.5_wp) item%moments = [a, 1.0_wp, 1 + a*random_unit(state)]
         item%check_triangle = .false.
      end select
      item%moments = unit*cshift(item%moments, int(3*random_unit(state)))
      if (random_unit(state) < 0.25_wp) item%axes = random_unit_quaternion(state)
   end subroutine draw_body

   !> Order, number of steps, J0.
   subroutine draw_method(state, item)
      integer(int64), intent(inout) :: state
      type(attack_case_t), intent(inout) :: item
      integer, parameter :: orders(8) = [2, 2, 2, 4, 4, 4, 6, 8], most(8) = [9, 9, 9, 3, 3, 3, 2, 2]
      integer :: i
      i = 1 + int(8*random_unit(state))
      item%order = orders(i)
      if (random_unit(state) < 0.5_wp) item%steps = 1 + int(most(i)*random_unit(state))
      if (random_unit(state) < 0.5_wp) &
         item%inverse_j0 = 10.0_wp**between(state, -2.0_wp, 0.5_wp)/maxval(item%moments)
   end subroutine draw_method

   !> One effect of any kind, with torques of about a size.
   subroutine draw_effect(state, item, size, rate, effect)
      integer(int64), intent(inout) :: state
      type(attack_case_t), intent(in) :: item
      !> N m, and |Ω|, rad/s.
      real(wp), intent(in) :: size, rate
      type(attack_effect_t), intent(out) :: effect
      real(wp) :: lengths(2), spread
      effect%kind = 1 + int(effect_kinds*random_unit(state))
      effect%n = draw_direction(state)
      effect%m = draw_direction(state)
      select case (effect%kind)
      case (GRAVITY, DIPOLE)
         effect%n = 9.8_wp*effect%n
         effect%m = (size/9.8_wp)*effect%m
         ! A body has one weight.
         if (any(item%effects(:item%n_effects)%kind == GRAVITY)) effect%kind = DIPOLE
      case (GRADIENT)
         spread = max(maxval(item%moments) - minval(item%moments), 1e-3_wp*minval(item%moments))
         effect%strength = sign(size/(3*spread), random_unit(state) - 0.2_wp)
      case (SPRING)
         lengths = [between(state, 0.2_wp, 1.0_wp), between(state, 0.2_wp, 1.0_wp)]
         if (random_unit(state) < 0.25_wp) lengths(2) = lengths(1)*(1 + 0.02_wp*random_unit(state))
         effect%n = lengths(1)*effect%n
         effect%m = lengths(2)*effect%m
         effect%strength = size/(lengths(1)*lengths(2))
         if (random_unit(state) < 0.7_wp) effect%rest_length = between(state, 0.0_wp, 1.5_wp)
      case (POLYNOMIAL)
         effect%strength = 0.3_wp*size
         effect%bounded = random_unit(state) < 0.5_wp
      case (FEEDBACK)
         effect%strength = size
         effect%bounded = random_unit(state) < 0.5_wp
         call draw_frequency(state, rate, effect)
      case (BODY_TORQUE, SPACE_TORQUE)
         effect%n = size*effect%n
         call draw_time(state, item, rate, effect)
      case default
         effect%m = (size/rate)*[random_unit(state), random_unit(state), random_unit(state)]
      end select
   end subroutine draw_effect

   !> A torque's frequency and window: a third each has one.
   subroutine draw_time(state, item, rate, effect)
      integer(int64), intent(inout) :: state
      type(attack_case_t), intent(in) :: item
      real(wp), intent(in) :: rate
      type(attack_effect_t), intent(inout) :: effect
      call draw_frequency(state, rate, effect)
      if (random_unit(state) > 0.33_wp) return
      effect%start = item%t + item%dt*between(state, -1.0_wp, 1.0_wp)
      effect%stop = effect%start + abs(item%dt)*between(state, 0.1_wp, 5.0_wp)
   end subroutine draw_time

   !> One in three has a frequency.
   subroutine draw_frequency(state, rate, effect)
      integer(int64), intent(inout) :: state
      real(wp), intent(in) :: rate
      type(attack_effect_t), intent(inout) :: effect
      if (random_unit(state) > 0.33_wp) return
      effect%frequency = between(state, 0.0_wp, 2.0_wp)*rate/(2*pi)
      effect%phase = between(state, 0.0_wp, 2*pi)
   end subroutine draw_frequency

   !> A unit vector; one in four near an axis.
   function draw_direction(state) result(n)
      integer(int64), intent(inout) :: state
      real(wp) :: n(3)
      integer :: axis
      n = random_vector(state)
      if (random_unit(state) < 0.25_wp) then
         axis = 1 + int(3*random_unit(state))
         n = 0.05_wp*n
         n(axis) = sign(1.0_wp, n(axis))
      end if
      n = n/norm2(n)
   end function draw_direction

   real(wp) function between(state, low, high)
      integer(int64), intent(inout) :: state
      real(wp), intent(in) :: low, high
      between = low + (high - low)*random_unit(state)
   end function between

   pure real(wp) function middle_of(moments)
      real(wp), intent(in) :: moments(3)
      middle_of = sum(moments) - maxval(moments) - minval(moments)
   end function middle_of

   !> Inertia tensor, body axes, kg m²; shape (3,3).
   pure function inertia(self)
      class(attack_case_t), intent(in) :: self
      real(wp) :: inertia(3, 3), axes(3, 3)
      integer :: i, j
      axes = rotation_matrix(self%axes)
      do j = 1, 3
         do i = 1, 3
            inertia(i, j) = sum(axes(i, :)*self%moments*axes(j, :))
         end do
      end do
      ! Symmetric to the last bit; of a body in its principal axes no digit is lost.
      inertia = 0.5_wp*(inertia + transpose(inertia))
   end function inertia

   !> The library's system of a case.
   subroutine make_system(item, system, status)
      type(attack_case_t), intent(in) :: item
      type(system_t), intent(out) :: system
      type(status_t), intent(out) :: status
      integer :: i
      call make_body(item%inertia(), system%body, status, mass=1.0_wp, check_triangle=item%check_triangle)
      if (.not. status%ok()) return
      if (any(abs(item%rotor) > 0.0_wp)) call system%effects%add(rotor_t(name='rotor', momentum=item%rotor))
      do i = 1, item%n_effects
         associate (effect => item%effects(i))
            select case (effect%kind)
            case (GRAVITY)
               system%body%center_of_mass = effect%m
               call system%effects%add(gravity_t(system%body, effect%n))
            case (DIPOLE)
               call system%effects%add(dipole_t(effect%m, effect%n))
            case (GRADIENT)
               call system%effects%add(gravity_gradient_t(system%body, effect%n, effect%strength))
            case (SPRING)
               call system%effects%add(spring_t(effect%m, effect%n, effect%strength, effect%rest_length))
            case (POLYNOMIAL, FEEDBACK)
               call add_own(effect, system, status)
            case (BODY_TORQUE, SPACE_TORQUE)
               call system%effects%add(applied_torque_t(amplitude=effect%n, in_space=effect%kind == SPACE_TORQUE, &
                                                        frequency=effect%frequency, phase=effect%phase, &
                                                        start=effect%start, stop=effect%stop))
            case default
               call system%effects%add(damping_t(effect%m))
            end select
         end associate
         if (.not. status%ok()) return
      end do
      if (any(abs(item%inertia_rate) > 0.0_wp)) call system%effects%add(inertia_change_t( &
         [(item%inertia_rate(i, i), i=1, 3), item%inertia_rate(1, 2), item%inertia_rate(1, 3), &
          item%inertia_rate(2, 3)], item%change_start, item%change_stop, item%mass_leaves))
      do i = 1, item%n_spheres
         if (.not. status%ok()) return
         call add_inner_sphere(system, inner_sphere_t(item%sphere_inertia(i), item%friction(i), &
                                                      item%sphere_rate(:, i)), status)
      end do
   end subroutine make_system

   !> Adds a potential or torque of the test's own, and its bounds if it comes with them. For |γ| ≤ |n|:
   !>
   !> - U = e((a·γ)³ - γ1γ2): |∇U| ≤ e(3|a|³|n|² + |n|), ‖∇²U‖ ≤ e(6|a|³|n| + 1), the third derivative is 6e|a|³;
   !> - τ = e(a·γ)γ: with the body rotated by θ about an axis each component is a constant and waves in θ and 2θ, of
   !>   amplitude e|a||n|²/2 together, since vᵀγγᵀa is at least (v·a - |a|)|n|²/2 and at most (v·a + |a|)|n|²/2 for unit
   !>   vectors v. By Bernstein's inequality the derivatives are at most 2 and 4 times that.
   subroutine add_own(effect, system, status)
      type(attack_effect_t), intent(in) :: effect
      type(system_t), intent(inout) :: system
      type(status_t), intent(out) :: status
      real(wp) :: n, a, e
      n = norm2(effect%n)
      a = norm2(effect%m)
      e = abs(effect%strength)
      if (effect%kind == POLYNOMIAL) then
         call system%effects%add(custom_potential_t(name='custom', direction=effect%n, axis=effect%m, &
                                                    size=effect%strength))
         if (effect%bounded) call system%effects%bound_potential(e*(3*a**3*n**2 + n), e*(6*a**3*n + 1), &
                                                                 6*e*a**3, status)
      else
         call system%effects%add(custom_torque_t(name='custom', direction=effect%n, axis=effect%m, &
                                                 size=effect%strength, frequency=effect%frequency, phase=effect%phase))
         if (effect%bounded) call system%effects%bound_torque(e*a*n**2, e*a*n**2, 2*e*a*n**2, &
                                                              2*pi*effect%frequency, status)
      end if
   end subroutine add_own

end module test_attack_case
