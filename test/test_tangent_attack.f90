!> Random steps of order 2 against an oracle of 33 digits that shares no equation with the tangent: the step's own three
!> equations, solved by Newton, and central differences of its end.
module test_tangent_attack
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_body, only: make_body
   use nutate_column, only: attitude_column, column_t, inertia_column, rate_column
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_effect, only: rotor_t
   use nutate_hamiltonian, only: body_momentum, make_state
   use nutate_kinds, only: wp
   use nutate_methods, only: make_stepper
   use nutate_quaternion, only: quat_conjugate, quat_product, rotation_matrix
   use nutate_spring, only: spring_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: integrator_settings_t, stepper_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   use test_oracle, only: has_oracle, qp
   use test_support, only: check, check_below, draws_fewer, error_type, new_unittest, random_unit, &
      random_unit_quaternion, random_vector, skip_test, unittest_type
   implicit none
   private

   public :: collect_tangent_attack

   !> What a step depends on: rotation of the start, L0, J (11, 22, 33, 12, 13, 23), h, m and field of a dipole,
   !> damping, body point, anchor, stiffness and rest length of a spring.
   integer, parameter :: n_parameters = 32
   integer, parameter :: turn_at = 0, momentum_at = 3, inertia_at = 6, rotor_at = 12, moment_at = 15, field_at = 18, &
                         damping_at = 21, point_at = 24, anchor_at = 27, stiffness_at = 30, length_at = 31
   integer, parameter :: place(2, 6) = reshape([1, 1, 2, 2, 3, 3, 1, 2, 1, 3, 2, 3], [2, 6])
   !> Of the differences.
   real(qp), parameter :: shift = 1e-11_qp
   !> Of a column, over the largest entry of all and the condition of the step.
   real(wp), parameter :: bound = 2e-13_wp

contains

   subroutine collect_tangent_attack(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [new_unittest("columns of random steps are those of 33 digits", attack)]
   end subroutine collect_tangent_attack

   subroutine attack(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      integer :: number, done
      if (.not. has_oracle) then
         call skip_test(error, 'no numbers of 33 digits')
         return
      end if
      seed = 20261125_int64
      done = 0
      do number = 1, merge(300, 3000, draws_fewer())
         call try_step(error, seed, number, done)
         if (allocated(error)) return
      end do
      call check(error, done > 0.7_wp*(number - 1), 'most of the steps are possible')
   end subroutine attack

   !> One random step with all columns.
   subroutine try_step(error, seed, number, done)
      type(error_type), allocatable, intent(inout) :: error
      integer(int64), intent(inout) :: seed
      integer, intent(in) :: number
      integer, intent(inout) :: done
      type(system_t) :: system
      type(state_t) :: state, before
      type(status_t) :: status
      type(tangent_t) :: tangent
      class(stepper_t), allocatable :: stepper
      real(wp) :: p(n_parameters), q(4), omega(3), dt, c(4), largest, found(6)
      real(qp) :: rotation(3, 3), exact(6)
      logical :: ok
      integer :: k
      character(len=40) :: label
      call draw(seed, p, q, omega, system, status)
      if (.not. status%ok()) return
      state = make_state(system, q, omega)
      p(momentum_at + 1:momentum_at + 3) = body_momentum(state)
      dt = (0.02_wp + 0.6_wp*random_unit(seed))*merge(-1.0_wp, 1.0_wp, random_unit(seed) < 0.2_wp)
      call tangent%begin(system, state, columns_of(system), status)
      call make_stepper(system, integrator_settings_t(method='nielsen_krenk', formulation=merge( &
                        'full   ', 'reduced', modulo(number, 2) == 0), order=2), stepper, status)
      before = state
      call stepper%step(system, state, dt, status)
      if (.not. status%ok()) return
      call stepper%carry(system, before, state, dt, 0.5_wp*dt, tangent, status)
      call check(error, status%ok(), trim(status%message))
      rotation = real(rotation_matrix(q), qp)
      c = quat_product(quat_conjugate(before%q), state%q)
      largest = max(maxval(abs(tangent%theta)), maxval(abs(tangent%momentum)))
      done = done + 1
      do k = 1, n_parameters
         call differ(p, rotation, real(dt, qp), real(c(2:4)/(1 + c(1)), qp), k, exact, ok)
         if (.not. ok) return
         found = [tangent%theta(k, :), tangent%momentum(k, :)]
         write (label, '("step ",i0,", column ",i0)') number, k
         call check_below(error, maxval(abs(found - real(exact, wp)))/largest, bound*max(1.0_wp, largest), trim(label))
      end do
   end subroutine try_step

   !> A random body with effects, and its start.
   subroutine draw(seed, p, q, omega, system, status)
      integer(int64), intent(inout) :: seed
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
      call make_body(tensor, system%body, status, check_triangle=.false.)
      if (.not. status%ok()) return
      ! Where the ends can meet the spring has another discrete gradient.
      if (abs(norm2(p(point_at + 1:point_at + 3)) - norm2(p(anchor_at + 1:anchor_at + 3))) &
          < 0.1_wp*norm2(p(anchor_at + 1:anchor_at + 3))) p(anchor_at + 1:anchor_at + 3) = [2.0_wp, 1.0_wp, -1.0_wp]
      call system%effects%add(rotor_t(name='rotor', momentum=p(rotor_at + 1:rotor_at + 3)))
      call system%effects%add(dipole_t(p(moment_at + 1:moment_at + 3), p(field_at + 1:field_at + 3)))
      call system%effects%add(damping_t(p(damping_at + 1:damping_at + 3)))
      call system%effects%add(spring_t(p(point_at + 1:point_at + 3), p(anchor_at + 1:anchor_at + 3), &
                                       p(stiffness_at + 1), p(length_at + 1)))
   end subroutine draw

   !> The columns of all parameters; L0 is held where one of the body changes, as the oracle does.
   function columns_of(system) result(columns)
      type(system_t), intent(in) :: system
      type(column_t) :: columns(n_parameters)
      type(status_t) :: status
      real(wp) :: unit(3)
      integer :: i
      do i = 1, 3
         unit = 0.0_wp
         unit(i) = 1.0_wp
         columns(turn_at + i) = attitude_column(i)
         columns(momentum_at + i) = rate_column(i)
         columns(momentum_at + i)%angular_velocity = system%body%inverse_inertia(:, i)
         columns(rotor_at + i)%rotor = unit
         call columns(moment_at + i)%add(system%effects, 'dipole', 1, 'moment', unit, status)
         call columns(field_at + i)%add(system%effects, 'dipole', 1, 'field', unit, status)
         call columns(damping_at + i)%add(system%effects, 'damping', 1, 'coefficient', unit, status)
         call columns(point_at + i)%add(system%effects, 'spring', 1, 'body_point', unit, status)
         call columns(anchor_at + i)%add(system%effects, 'spring', 1, 'anchor', unit, status)
      end do
      do i = 1, 6
         columns(inertia_at + i) = inertia_column(place(1, i), place(2, i))
      end do
      call columns(stiffness_at + 1)%add(system%effects, 'spring', 1, 'stiffness', [1.0_wp], status)
      call columns(length_at + 1)%add(system%effects, 'spring', 1, 'rest_length', [1.0_wp], status)
   end function columns_of

   !> A column by central differences of the oracle's step, Ω0 held where J or h changes.
   subroutine differ(p, rotation, dt, b, k, column, ok)
      real(wp), intent(in) :: p(n_parameters)
      real(qp), intent(in) :: rotation(3, 3), dt, b(3)
      integer, intent(in) :: k
      real(qp), intent(out) :: column(6)
      logical, intent(out) :: ok
      real(qp) :: x(n_parameters), ends(3, 3, 2), l(3, 2), omega(3), turn(3, 3)
      integer :: i
      ! Ω0 = J⁻¹(L0 - h).
      x = real(p, qp)
      omega = solved(inertia_of(x), x(momentum_at + 1:momentum_at + 3) - x(rotor_at + 1:rotor_at + 3))
      do i = 1, 2
         x = real(p, qp)
         x(k) = x(k) + (3 - 2*i)*shift
         if (k > inertia_at .and. k <= moment_at) &
            x(momentum_at + 1:momentum_at + 3) = matmul(inertia_of(x), omega) + x(rotor_at + 1:rotor_at + 3)
         call step(x, rotation, dt, b, ends(:, :, i), l(:, i), ok)
         if (.not. ok) return
      end do
      turn = matmul(transpose(ends(:, :, 2)), ends(:, :, 1))
      column(1:3) = [turn(3, 2) - turn(2, 3), turn(1, 3) - turn(3, 1), turn(2, 1) - turn(1, 2)]/(4*shift)
      column(4:6) = (l(:, 1) - l(:, 2))/(2*shift)
   end subroutine differ

   pure function inertia_of(x) result(inertia)
      real(qp), intent(in) :: x(n_parameters)
      real(qp) :: inertia(3, 3)
      integer :: i
      do i = 1, 6
         inertia(place(1, i), place(2, i)) = x(inertia_at + i)
         inertia(place(2, i), place(1, i)) = x(inertia_at + i)
      end do
   end function inertia_of

   !> The step from the parameters: R(q1) and L1.
   subroutine step(x, rotation, dt, guess, last, l, ok)
      real(qp), intent(in) :: x(n_parameters), rotation(3, 3), dt, guess(3)
      real(qp), intent(out) :: last(3, 3), l(3)
      logical, intent(out) :: ok
      real(qp) :: first(3, 3), b(3), f(3), moved(3), slope(3, 3), h(3), tau(3), half(3, 3)
      integer :: i, k
      first = matmul(rotation, turn_of(x(turn_at + 1:turn_at + 3)/2))
      b = guess
      do k = 1, 8
         f = equations(x, first, dt, b, tau)
         do i = 1, 3
            h = 0
            h(i) = 1e-15_qp
            moved = equations(x, first, dt, b + h, tau)
            slope(:, i) = (moved - equations(x, first, dt, b - h, tau))/2e-15_qp
         end do
         h = solved(slope, f)
         b = b - h
         if (maxval(abs(h)) < 1e-31_qp) exit
      end do
      ok = maxval(abs(h)) < 1e-28_qp
      f = equations(x, first, dt, b, tau)
      half = turn_of(b)
      last = matmul(first, matmul(half, half))
      ! R(c½)L1 = R(c½)ᵀL0 + Δtτ̄.
      l = matmul(transpose(half), matmul(transpose(half), x(momentum_at + 1:momentum_at + 3)) + dt*tau)
   end subroutine step

   !> R(1 + b), the rotation by the Cayley map's half; shape (3,3).
   pure function turn_of(b) result(r)
      real(qp), intent(in) :: b(3)
      real(qp) :: r(3, 3)
      integer :: j
      do j = 1, 3
         r(:, j) = 2*b(j)*b
         r(j, j) = r(j, j) + 1 - dot_product(b, b)
      end do
      r(2, 1) = r(2, 1) + 2*b(3)
      r(3, 1) = r(3, 1) - 2*b(2)
      r(1, 2) = r(1, 2) - 2*b(3)
      r(3, 2) = r(3, 2) + 2*b(1)
      r(1, 3) = r(1, 3) + 2*b(2)
      r(2, 3) = r(2, 3) - 2*b(1)
      r = r/(1 + dot_product(b, b))
   end function turn_of

   !> G(b), from R(c½)L1 - R(c½)ᵀL0 = Δtτ̄ and L1 = 2((4/Δt)Jb + h) - L0; and τ̄.
   function equations(x, first, dt, b, tau) result(g)
      real(qp), intent(in) :: x(n_parameters), first(3, 3), dt, b(3)
      real(qp), intent(out) :: tau(3)
      real(qp) :: g(3), half(3, 3), l0(3), field(3), mid(3), ends(3, 2), length(2), slack
      integer :: i
      half = turn_of(b)
      l0 = x(momentum_at + 1:momentum_at + 3)
      mid = matmul(transpose(half), matmul(transpose(first), x(field_at + 1:field_at + 3)))/(1 + dot_product(b, b))
      tau = cross(x(moment_at + 1:moment_at + 3), mid) - x(damping_at + 1:damping_at + 3)*(4/dt)*b
      associate (point => x(point_at + 1:point_at + 3))
         ends(:, 1) = matmul(transpose(first), x(anchor_at + 1:anchor_at + 3))
         field = matmul(transpose(half), ends(:, 1))
         ends(:, 2) = matmul(transpose(half), field)
         do i = 1, 2
            length(i) = sqrt(sum((point - ends(:, i))**2))
         end do
         slack = 1 - 2*x(length_at + 1)/sum(length)
         tau = tau + cross(x(stiffness_at + 1)*slack*point, field)/(1 + dot_product(b, b))
      end associate
      g = matmul(half, 2*((4/dt)*matmul(inertia_of(x), b) + x(rotor_at + 1:rotor_at + 3)) - l0) &
          - matmul(transpose(half), l0) - dt*tau
   end function equations

   pure function cross(a, b) result(c)
      real(qp), intent(in) :: a(3), b(3)
      real(qp) :: c(3)
      c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
   end function cross

   !> A⁻¹v
   pure function solved(a, v) result(x)
      real(qp), intent(in) :: a(3, 3), v(3)
      real(qp) :: x(3), rows(3, 3)
      rows(:, 1) = cross(a(:, 2), a(:, 3))
      rows(:, 2) = cross(a(:, 3), a(:, 1))
      rows(:, 3) = cross(a(:, 1), a(:, 2))
      x = matmul(transpose(rows), v)/dot_product(rows(:, 1), a(:, 1))
   end function solved

end module test_tangent_attack
