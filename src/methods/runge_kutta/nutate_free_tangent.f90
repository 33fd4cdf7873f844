!> The tangent of a step of `rk8` of a free body, whose attitude follows from the angle about the fixed momentum
!> (`nutate_specialised_motion`): the exact derivative of that step.
!>
!> Sensitivities to the initial state change by three matrices, θ1 = Sᵀθ0 + F δL0 and δL1 = G δL0, so that three
!> sensitivities, and one for each parameter, are propagated through the stages.
module nutate_free_tangent
   use nutate_hamiltonian, only: body_momentum, system_t
   use nutate_kinds, only: wp
   use nutate_order_eight, only: a, b, n_stages
   use nutate_quaternion, only: cross, quat_conjugate, quat_product, rotate_to_body
   use nutate_small_products, only: skew, times_columns, times_vector
   use nutate_stage_tangent, only: add_weighted, stage_weights_t
   use nutate_state, only: state_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: free_tangent_t

   !> The sensitivities inside a step.
   type :: free_tangent_t
      private
      !> δL at the start, in a stage and its rates; shapes (n, 3), (n, 3, stages); 2a - the change of the angle about l.
      real(wp), allocatable :: start(:, :), point(:, :), rates(:, :, :), angle(:)
      !> ΔtJ⁻¹; shape (3,3); L of the stages and ΔtL̇; shape (3, stages).
      real(wp) :: to_angle(3, 3) = 0.0_wp, momentum(3, n_stages) = 0.0_wp, rate(3, n_stages) = 0.0_wp
      !> u₀, the step's half angle about it, and 1/|L0|.
      real(wp) :: axis(3) = 0.0_wp, half = 0.0_wp, inverse = 0.0_wp
      !> Weights of the stages.
      type(stage_weights_t) :: weights
   contains
      !> Moves sensitivities over a step.
      procedure :: propagate
   end type free_tangent_t

contains

   !> Moves sensitivities over a step. `propagated` is false, and they are unchanged, for a body at rest.
   subroutine propagate(self, system, before, dt, tangent, propagated)
      class(free_tangent_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> State at the start of the step, which succeeded; length of the step, s.
      type(state_t), intent(in) :: before
      real(wp), intent(in) :: dt
      type(tangent_t), intent(inout) :: tangent
      logical, intent(out) :: propagated
      real(wp) :: first(3), last(3), square
      integer :: i
      first = body_momentum(before)
      square = dot_product(first, first)
      propagated = square > tiny(1.0_wp)
      if (.not. propagated) return
      self%to_angle = dt*system%body%inverse_inertia
      self%inverse = 1/sqrt(square)
      self%axis = self%inverse*first
      self%half = 0.0_wp
      call start_sensitivities(self, 3 + size(tangent%parametric))
      do i = 1, n_stages
         call take_argument(self, i, first, last)
         self%momentum(:, i) = last
         call add_stage(self, i, first, last, system, tangent)
      end do
      call take_argument(self, n_stages + 1, first, last)
      call finish_sensitivities(self, last, tangent)
   end subroutine propagate

   !> Sets unit sensitivities of δL, and those of parameters, which are zero at the start.
   pure subroutine start_sensitivities(self, n)
      type(free_tangent_t), intent(inout) :: self
      integer, intent(in) :: n
      integer :: i
      if (allocated(self%start)) then
         if (size(self%start, 1) /= n) deallocate (self%start, self%point, self%rates, self%angle)
      end if
      if (.not. allocated(self%start)) then
         allocate (self%start(n, 3), self%point(n, 3), self%rates(n, 3, n_stages), self%angle(n))
         call self%weights%list(a, b)
      end if
      self%start = 0.0_wp
      do i = 1, 3
         self%start(i, i) = 1.0_wp
      end do
      self%angle = 0.0_wp
   end subroutine start_sensitivities

   !> Computes L and δL in a stage, or at the end of the step.
   pure subroutine take_argument(self, i, first, last)
      type(free_tangent_t), intent(inout) :: self
      !> Index of the stage; one more than their number: the end.
      integer, intent(in) :: i
      real(wp), intent(in) :: first(3)
      real(wp), intent(out) :: last(3)
      integer :: j
      last = first
      if (i == 1) then
         self%point = self%start
         return
      end if
      associate (count => self%weights%counts(i), which => self%weights%which(:, i), w => self%weights%w(:, i))
         do j = 1, count
            last = last + w(j)*self%rate(:, which(j))
         end do
         call add_weighted(size(self%start), n_stages, count, which, w, self%start, self%rates, self%point)
      end associate
   end subroutine take_argument

   !> Adds the rates of a stage, L̇ = L×Ω, and its part of the angle, ½(u₀ + u)·Ω/(1 + u₀·u).
   pure subroutine add_stage(self, i, first, last, system, tangent)
      type(free_tangent_t), intent(inout) :: self
      integer, intent(in) :: i
      !> L at the start and in the stage; shape (3).
      real(wp), intent(in) :: first(3), last(3)
      type(system_t), intent(in) :: system
      type(tangent_t), intent(in) :: tangent
      real(wp) :: angle(3), m(3, 3), own(3), own_first(3), cosine, pace, sum(3), row(3), of_axis(3)
      integer :: j, k
      angle = times_vector(self%to_angle, last)
      self%rate(:, i) = cross(last, angle)
      m = times_columns(skew(last), self%to_angle) - skew(angle)
      do j = 1, 3
         self%rates(:, j, i) = m(j, 1)*self%point(:, 1) + m(j, 2)*self%point(:, 2) + m(j, 3)*self%point(:, 3)
      end do
      sum = 0.5_wp*(times_vector(self%to_angle, first) + angle)
      cosine = 1 + self%inverse*dot_product(self%axis, last)
      pace = dot_product(self%axis, sum)/cosine
      self%half = self%half + b(i)*pace
      ! Derivatives with respect to δL of the stage and to δL0, which changes u₀ and |L0|.
      row = (b(i)/cosine)*(0.5_wp*times_vector(self%to_angle, self%axis) - (pace*self%inverse)*self%axis)
      of_axis = (b(i)/cosine)*(sum - (pace*self%inverse)*last)
      of_axis = self%inverse*(of_axis - dot_product(of_axis, self%axis)*self%axis)
      of_axis = of_axis + (b(i)/cosine)*((pace*self%inverse*(cosine - 1))*self%axis &
                                         + 0.5_wp*times_vector(self%to_angle, self%axis))
      self%angle = self%angle + row(1)*self%point(:, 1) + row(2)*self%point(:, 2) + row(3)*self%point(:, 3)
      self%angle(1:3) = self%angle(1:3) + of_axis
      do k = 1, size(tangent%parametric)
         associate (rotor => tangent%variations(tangent%parametric(k))%rotor, change => tangent%inertia(:, :, k))
            own = times_vector(self%to_angle, times_vector(change, times_vector(system%body%inverse_inertia, last)) &
                               + rotor)
            own_first = times_vector(self%to_angle, times_vector(change, times_vector(system%body%inverse_inertia, &
                                                                                      first)) + rotor)
         end associate
         self%rates(3 + k, :, i) = self%rates(3 + k, :, i) - cross(last, own)
         self%angle(3 + k) = self%angle(3 + k) - (0.5_wp*b(i)/cosine)*dot_product(self%axis, own_first + own)
      end do
   end subroutine add_stage

   !> Computes θ1 and δL1 of all sensitivities from q1 = q0∘exp(½φu₀)∘(1 + u·u₀, u×u₀).
   pure subroutine finish_sensitivities(self, momentum, tangent)
      type(free_tangent_t), intent(in) :: self
      !> L1; shape (3).
      real(wp), intent(in) :: momentum(3)
      type(tangent_t), intent(inout) :: tangent
      real(wp) :: last(3), swing(4), turn(4), length, of_axis(3), theta(3, 3), more(3), old(3)
      integer :: i, k, m
      length = norm2(momentum)
      last = momentum/length
      turn = [cos(self%half), sin(self%half)*self%axis]
      swing = [1 + dot_product(last, self%axis), cross(last, self%axis)]
      swing = swing/norm2(swing)
      do i = 1, 3
         of_axis = -self%axis(i)*self%axis
         of_axis(i) = of_axis(i) + 1
         theta(:, i) = turn_of(self%point(i, :), self%inverse*of_axis, self%angle(i))
      end do
      turn = quat_product(turn, swing)
      do k = 1, tangent%n
         old = tangent%momentum(k, :)
         more = theta(:, 1)*old(1) + theta(:, 2)*old(2) + theta(:, 3)*old(3)
         tangent%theta(k, :) = rotate_to_body(turn, tangent%theta(k, :)) + more
         do i = 1, 3
            tangent%momentum(k, i) = dot_product(self%point(1:3, i), old)
         end do
      end do
      do m = 1, size(tangent%parametric)
         k = tangent%parametric(m)
         more = turn_of(self%point(3 + m, :), [0.0_wp, 0.0_wp, 0.0_wp], self%angle(3 + m))
         tangent%theta(k, :) = tangent%theta(k, :) + more
         tangent%momentum(k, :) = tangent%momentum(k, :) + self%point(3 + m, :)
      end do

   contains

      !> Returns θ1 of a change of L1, u₀ and the half angle.
      pure function turn_of(of_last, of_first, of_half) result(by)
         real(wp), intent(in) :: of_last(3), of_first(3), of_half
         real(wp) :: by(3)
         real(wp) :: s(4), d(4), u(3)
         u = (of_last - dot_product(last, of_last)*last)/length
         s = [1 + dot_product(last, self%axis), cross(last, self%axis)]
         d = [dot_product(u, self%axis) + dot_product(last, of_first), cross(u, self%axis) + cross(last, of_first)]
         d = quat_product(quat_conjugate(s), d)
         u = 2*of_half*self%axis + sin(2*self%half)*of_first - 2*sin(self%half)**2*cross(self%axis, of_first)
         by = rotate_to_body(swing, u) + (2/dot_product(s, s))*d(2:4)
      end function turn_of

   end subroutine finish_sensitivities

end module nutate_free_tangent
