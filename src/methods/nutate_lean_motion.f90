!> Steps of the Runge-Kutta method of order 8 for free bodies and for bodies in uniform fields, in the variables that
!> make them short.
!>
!> With `s = t/Δt` and `w = ½ΔtΩ` the equations have no factors but constants that are multiplied by the step
!> beforehand:
!>
!>     q' = q∘w,   wᵢ' = κᵢ wⱼwₖ + ½Δt²(m×γ)ᵢ/Jᵢ,   κ₁ = 2(J₂ - J₃)/J₁, ...
!>
!> γ is a row of R(q), homogeneous in q: nothing is normalised in a stage.
!>
!> * **Free bodies**: w alone is integrated. The attitude follows from the angle φ about the fixed l, a quadrature. With
!>   u = L/|l| and u₀ at the start of the step, R = R₀ Rot(u₀, φ) S, S the shortest rotation from u to u₀, and
!>   `φ̇ = (u₀ + u)·Ω/(1 + u₀·u)`; u·Ω = 2T/|l| is constant.
!> * **Potentials linear in directions**: V = -Σ m·Rᵀn, summed into the matrix Σ m nᵀ. Where all n are parallel, the
!>   space axes are turned so that n is the third one, and γ the third row of R alone.
!> * **Symmetric tops**, J₁ = J₂ and all m along axis 3, in the frame that turns with L/J₁: κ = 0, and the body turns in
!>   it about its axis by `(1/J₃ - 1/J₁)L₃Δt` exactly. Steps are those of the slow motion.
module nutate_lean_motion
   use nutate_dop853, only: a, b
   use nutate_effect_list, only: effect_list_t
   use nutate_invariants, only: conserved_momentum, ALL_COMPONENTS, ALONG_AXIS
   use nutate_kinds, only: wp
   use nutate_linear_potential, only: linear_potential_t
   use nutate_quaternion, only: quat_conjugate, quat_product, quat_vector_product
   use nutate_system, only: system_t
   implicit none
   private

   public :: lean_motion_t

   !> Stages.
   integer, parameter :: n_stages = 12
   !> Largest product of w and the constants of the equations: a step as long follows no motion, and from 14 on stages
   !> could overflow, since each may square the one before.
   real(wp), parameter :: longest = 10.0_wp
   !> Least 1 + u₀·u: S must stay away from half a turn, where it has no axis.
   real(wp), parameter :: least_cosine = 0.1_wp
   !> Steps whose ½Δt/J is outside of these are left to the general equations: its reciprocal is a number in between.
   real(wp), parameter :: least_half = 1e-150_wp, greatest_half = 1e150_wp

   !> What does not change from step to step.
   type :: lean_motion_t
      private
      !> The system is one of those above.
      logical, public :: possible = .false.
      !> There is no force; all directions are parallel; the frame does not spin; space axes are turned.
      logical :: free = .true., single = .true., symmetric = .false., turned = .false.
      !> The first body axis of the equations, 1 to 3; the others follow cyclically, and space axes with them.
      integer :: first = 1
      !> Principal moments in that order, kg m²; shape (3).
      real(wp) :: moments(3) = 1.0_wp
      !> Space axes of the equations ← space axes; unit quaternion.
      real(wp) :: space(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> τᵢ = Σ torque(i, j, k) R(k, j), of the equations' axes, N m; shape (3,3,3).
      real(wp) :: torque(3, 3, 3) = 0.0_wp
      !> κ; Δt, s; ½Δt/J and its reciprocal; J₁/J₃ - 1 for the spin, or 0.
      real(wp) :: kappa(3) = 0.0_wp, dt = 0.0_wp, half(3) = 0.0_wp, back(3) = 0.0_wp, spin = 0.0_wp
      !> ½Δt² torque/J, for off-diagonal R(k, j) without their factor 2; shape (3,3,3).
      real(wp) :: pull(3, 3, 3) = 0.0_wp
      !> What |w| is multiplied by to see whether a step is too long; what the pull adds.
      real(wp) :: stiffness = 3.0_wp, pulled = 0.0_wp
   contains
      !> Looks what a system is.
      procedure :: prepare
      !> Takes the length of a step; false for one that is none.
      procedure :: fits
      !> One step.
      procedure :: move
   end type lean_motion_t

contains

   !> Looks what a system is: possible with diagonal inertia, without torques and rotors, and with potentials that are
   !> linear in directions.
   pure subroutine prepare(self, system)
      class(lean_motion_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp) :: axis(3)
      integer :: components
      self%dt = 0.0_wp
      associate (effects => system%effects, inertia => system%body%inertia)
         self%possible = effects%n_torques + effects%n_rotors == 0 .and. are_linear(effects) .and. &
                         .not. effects%frame_turns .and. &
                         .not. any(abs(effects%rotor_momentum) > 0.0_wp) .and. &
                         .not. any(abs([inertia(1, 2), inertia(1, 3), inertia(2, 3)]) > 0.0_wp)
         if (.not. self%possible) return
         call conserved_momentum(effects, components, axis)
         self%free = components == ALL_COMPONENTS
         self%single = components == ALONG_AXIS
         self%first = 1
         if (.not. self%free) self%first = first_axis(effects, system%body%moments)
         self%moments = cshift(system%body%moments, self%first - 1)
         self%space = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
         if (self%single) self%space = to_third(cshift(axis, self%first - 1))
         self%turned = any(abs(self%space(2:4)) > 0.0_wp)
         call add_torques(self, effects, axis)
      end associate
      self%symmetric = .not. self%free .and. equal(self%moments(1), self%moments(2)) .and. &
                       .not. any(abs(self%torque(3, :, :)) > 0.0_wp) .and. &
                       .not. any(abs(self%torque(:, 3, :)) > 0.0_wp)
      self%spin = 0.0_wp
      if (self%symmetric) self%spin = self%moments(1)/self%moments(3) - 1
      self%kappa = 2*(cshift(self%moments, 1) - cshift(self%moments, 2))/self%moments
      if (self%symmetric) self%kappa = 0.0_wp
      self%stiffness = max(3.0_wp, maxval(abs(self%kappa)))
   end subroutine prepare

   !> True if all potentials are linear in a direction.
   pure logical function are_linear(effects)
      type(effect_list_t), intent(in) :: effects
      integer :: i
      are_linear = .true.
      do i = 1, effects%n_potentials
         select type (potential => effects%potentials(i)%item)
         class is (linear_potential_t)
         class default
            are_linear = .false.
         end select
      end do
   end function are_linear

   !> The body axis that is to be the first: with two equal moments the one after the axis of symmetry, if all m lie on
   !> that.
   pure integer function first_axis(effects, moments) result(first)
      !> Linear potentials.
      type(effect_list_t), intent(in) :: effects
      !> kg m²; shape (3).
      real(wp), intent(in) :: moments(3)
      real(wp) :: off(3)
      integer :: axis, i
      first = 1
      do axis = 1, 3
         off = 0.0_wp
         do i = 1, effects%n_potentials
            off = off + abs(cshift(effects%potentials(i)%item%series_moment(), axis))
         end do
         if (equal(moments(mod(axis, 3) + 1), moments(mod(axis + 1, 3) + 1)) .and. .not. off(1) + off(2) > 0.0_wp) &
            first = mod(axis, 3) + 1
      end do
   end function first_axis

   !> True for the same number.
   elemental logical function equal(x, y)
      real(wp), intent(in) :: x, y
      equal = .not. abs(x - y) > 0.0_wp
   end function equal

   !> The shortest rotation that takes a unit vector to the third axis, or to its opposite where that is nearer: the
   !> sign is left to the torque.
   pure function to_third(n) result(q)
      real(wp), intent(in) :: n(3)
      real(wp) :: q(4)
      q = [1 + abs(n(3)), sign(1.0_wp, n(3))*n(2), -sign(1.0_wp, n(3))*n(1), 0.0_wp]
      q = q/norm2(q)
   end function to_third

   !> Sums Σ m nᵀ into the torques: those of all directions along n, or each of three axes.
   pure subroutine add_torques(self, effects, axis)
      type(lean_motion_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> Unit vector along all directions, where there is one; shape (3).
      real(wp), intent(in) :: axis(3)
      real(wp) :: m(3), n(3), along(3)
      integer :: i, k
      self%torque = 0.0_wp
      along = cshift(axis, self%first - 1)
      do i = 1, effects%n_potentials
         m = cshift(effects%potentials(i)%item%series_moment(), self%first - 1)
         n = cshift(effects%potentials(i)%item%direction, self%first - 1)
         if (self%single) n = [0.0_wp, 0.0_wp, sign(1.0_wp, along(3))*dot_product(n, along)]
         do k = 1, 3
            self%torque(1, 3, k) = self%torque(1, 3, k) + m(2)*n(k)
            self%torque(1, 2, k) = self%torque(1, 2, k) - m(3)*n(k)
            self%torque(2, 1, k) = self%torque(2, 1, k) + m(3)*n(k)
            self%torque(2, 3, k) = self%torque(2, 3, k) - m(1)*n(k)
            self%torque(3, 2, k) = self%torque(3, 2, k) + m(1)*n(k)
            self%torque(3, 1, k) = self%torque(3, 1, k) - m(2)*n(k)
         end do
      end do
   end subroutine add_torques

   !> Takes the length of a step. False for one that is so short, or long, that the general equations have to take it.
   pure subroutine fits(self, dt, yes)
      class(lean_motion_t), intent(inout) :: self
      !> s.
      real(wp), intent(in) :: dt
      logical, intent(out) :: yes
      real(wp) :: inertia(3)
      integer :: j, k
      yes = self%possible
      if (equal(dt, self%dt) .or. .not. yes) return
      inertia = self%moments
      if (self%symmetric) inertia = self%moments(1)
      self%half = 0.5_wp*dt/inertia
      yes = all(abs(self%half) >= least_half) .and. all(abs(self%half) <= greatest_half)
      self%dt = 0.0_wp
      if (.not. yes) return
      self%back = 1/self%half
      do k = 1, 3
         do j = 1, 3
            self%pull(:, j, k) = merge(1, 2, j == k)*((0.5_wp*dt*dt/inertia)*self%torque(:, j, k))
         end do
      end do
      self%pulled = sqrt(self%stiffness*maxval(abs(self%pull)))
      self%dt = dt
   end subroutine fits

   !> One step. A step too long to be followed leaves y as it is.
   pure subroutine move(self, y, followed)
      class(lean_motion_t), intent(in) :: self
      !> [q, L, 0], |q| nearly 1 before and not normalised afterwards; shape (8).
      real(wp), intent(inout) :: y(8)
      logical, intent(out) :: followed
      real(wp) :: w(3)
      if (self%free) then
         w(1) = self%half(1)*y(5)
         w(2) = self%half(2)*y(6)
         w(3) = self%half(3)*y(7)
         followed = self%stiffness*max(abs(w(1)), abs(w(2)), abs(w(3))) <= longest
         if (followed) call move_free(self, w, y, followed)
      else
         call move_heavy(self, y, followed)
      end if
   end subroutine move

   !> A step of a free body.
   pure subroutine move_free(self, w, y, followed)
      type(lean_motion_t), intent(in) :: self
      !> w at the start; shape (3).
      real(wp), intent(in) :: w(3)
      real(wp), intent(inout) :: y(8)
      logical, intent(out) :: followed
      real(wp) :: axis(3), along(3), last(3), change(4), turn(4), swing(4), length, angle
      followed = .true.
      length = sqrt(y(5)*y(5) + y(6)*y(6) + y(7)*y(7))
      if (length <= 0.0_wp) return
      axis = y(5:7)/length
      along = self%back*(axis/length)
      call free_stages(self%kappa, w, axis, along, change, followed)
      if (.not. followed) return
      y(5:7) = y(5:7) + self%back*change(1:3)
      length = sqrt(y(5)*y(5) + y(6)*y(6) + y(7)*y(7))
      last = y(5:7)/length
      swing(1) = 1 + (last(1)*axis(1) + last(2)*axis(2) + last(3)*axis(3))
      swing(2) = last(2)*axis(3) - last(3)*axis(2)
      swing(3) = last(3)*axis(1) - last(1)*axis(3)
      swing(4) = last(1)*axis(2) - last(2)*axis(1)
      angle = change(4)
      turn(1) = cos(angle)
      turn(2:4) = sin(angle)*axis
      y(1:4) = quat_product(quat_product(y(1:4), turn), swing)
   end subroutine move_free

   !> Increments of w and of φ/2 in a step.
   pure subroutine free_stages(kappa, start, axis, along, change, followed)
      !> κ, w at the start, u₀, and what makes u₀·u from w; shape (3).
      real(wp), intent(in) :: kappa(3), start(3), axis(3), along(3)
      real(wp), intent(out) :: change(4)
      !> False where u comes near to -u₀.
      logical, intent(out) :: followed
      real(wp) :: y(4), k(4, n_stages), stage(4), rate(n_stages), cosine(n_stages), constant
      integer :: i
      y(1:3) = start
      y(4) = 0.0_wp
      constant = start(1)*axis(1) + start(2)*axis(2) + start(3)*axis(3)
      stage = y
      do i = 1, n_stages
         k(1, i) = kappa(1)*stage(2)*stage(3)
         k(2, i) = kappa(2)*stage(3)*stage(1)
         k(3, i) = kappa(3)*stage(1)*stage(2)
         k(4, i) = 0.0_wp
         rate(i) = constant + (axis(1)*stage(1) + axis(2)*stage(2) + axis(3)*stage(3))
         cosine(i) = 1 + (along(1)*stage(1) + along(2)*stage(2) + along(3)*stage(3))
         select case (i)
         case (1)
            stage = y + a(1, 2)*k(:, 1)
         case (2)
            stage = y + a(1, 3)*k(:, 1) + a(2, 3)*k(:, 2)
         case (3)
            stage = y + a(1, 4)*k(:, 1) + a(3, 4)*k(:, 3)
         case (4)
            stage = y + a(1, 5)*k(:, 1) + a(3, 5)*k(:, 3) + a(4, 5)*k(:, 4)
         case (5)
            stage = y + a(1, 6)*k(:, 1) + a(4, 6)*k(:, 4) + a(5, 6)*k(:, 5)
         case (6)
            stage = y + a(1, 7)*k(:, 1) + a(4, 7)*k(:, 4) + a(5, 7)*k(:, 5) + a(6, 7)*k(:, 6)
         case (7)
            stage = y + a(1, 8)*k(:, 1) + a(4, 8)*k(:, 4) + a(5, 8)*k(:, 5) + a(6, 8)*k(:, 6) + a(7, 8)*k(:, 7)
         case (8)
            stage = y + a(1, 9)*k(:, 1) + a(4, 9)*k(:, 4) + a(5, 9)*k(:, 5) + a(6, 9)*k(:, 6) + a(7, 9)*k(:, 7) &
                    + a(8, 9)*k(:, 8)
         case (9)
            stage = y + a(1, 10)*k(:, 1) + a(4, 10)*k(:, 4) + a(5, 10)*k(:, 5) + a(6, 10)*k(:, 6) + a(7, 10)*k(:, 7) &
                    + a(8, 10)*k(:, 8) + a(9, 10)*k(:, 9)
         case (10)
            stage = y + a(1, 11)*k(:, 1) + a(4, 11)*k(:, 4) + a(5, 11)*k(:, 5) + a(6, 11)*k(:, 6) + a(7, 11)*k(:, 7) &
                    + a(8, 11)*k(:, 8) + a(9, 11)*k(:, 9) + a(10, 11)*k(:, 10)
         case (11)
            stage = y + a(1, 12)*k(:, 1) + a(4, 12)*k(:, 4) + a(5, 12)*k(:, 5) + a(6, 12)*k(:, 6) + a(7, 12)*k(:, 7) &
                    + a(8, 12)*k(:, 8) + a(9, 12)*k(:, 9) + a(10, 12)*k(:, 10) + a(11, 12)*k(:, 11)
         case default
            change = b(1)*k(:, 1) + b(6)*k(:, 6) + b(7)*k(:, 7) + b(8)*k(:, 8) + b(9)*k(:, 9) + b(10)*k(:, 10) &
                     + b(11)*k(:, 11) + b(12)*k(:, 12)
         end select
      end do
      ! Stages 2 to 5 have no weight: what divides is 1 there, or that of the first.
      rate(5) = rate(1)
      cosine(5) = cosine(1)
      followed = minval(cosine(5:)) >= least_cosine
      if (.not. followed) return
      rate(5:) = rate(5:)/cosine(5:)
      change(4) = b(1)*rate(5) + b(6)*rate(6) + b(7)*rate(7) + b(8)*rate(8) + b(9)*rate(9) + b(10)*rate(10) &
                  + b(11)*rate(11) + b(12)*rate(12)
   end subroutine free_stages

   !> A step of a body in uniform fields.
   pure subroutine move_heavy(self, y, followed)
      type(lean_motion_t), intent(in) :: self
      real(wp), intent(inout) :: y(8)
      logical, intent(out) :: followed
      real(wp) :: x(8), change(7), largest
      x = y
      if (self%first /= 1) call permute(self%first, x)
      if (self%turned) x(1:4) = quat_product(self%space, x(1:4))
      x(5) = self%half(1)*x(5)
      x(6) = self%half(2)*x(6)
      x(7) = self%half(3)*x(7)
      largest = max(abs(x(5)), abs(x(6)), abs(x(7)))
      followed = self%stiffness*largest + self%pulled <= longest
      if (.not. followed) return
      call heavy_stages(self, x(1:7), change)
      x(1:7) = x(1:7) + change
      if (self%turned) x(1:4) = quat_product(quat_conjugate(self%space), x(1:4))
      x(5) = self%back(1)*x(5)
      x(6) = self%back(2)*x(6)
      x(7) = self%back(3)*x(7)
      if (self%symmetric) call turn_body(self, x)
      if (self%first /= 1) call permute(5 - self%first, x)
      y = x
   end subroutine move_heavy

   !> Axes in cyclic order from a first one on, of body and space alike: attitude and momentum only change places.
   pure subroutine permute(first, x)
      !> 2 or 3.
      integer, intent(in) :: first
      real(wp), intent(inout) :: x(8)
      if (first == 2) then
         x(2:4) = [x(3), x(4), x(2)]
         x(5:7) = [x(6), x(7), x(5)]
      else
         x(2:4) = [x(4), x(2), x(3)]
         x(5:7) = [x(7), x(5), x(6)]
      end if
   end subroutine permute

   !> From the frame that turns with L/J₁ to the body, which has turned in it about axis 3.
   pure subroutine turn_body(self, x)
      type(lean_motion_t), intent(in) :: self
      !> [q, L, 0]; shape (8).
      real(wp), intent(inout) :: x(8)
      real(wp) :: angle, c, s, double_c, double_s, first
      angle = self%spin*(self%half(3)*x(7))
      c = cos(angle)
      s = sin(angle)
      x(1:4) = [c*x(1) - s*x(4), c*x(2) + s*x(3), c*x(3) - s*x(2), c*x(4) + s*x(1)]
      double_c = (c - s)*(c + s)
      double_s = 2*c*s
      first = double_c*x(5) + double_s*x(6)
      x(6) = double_c*x(6) - double_s*x(5)
      x(5) = first
   end subroutine turn_body

   !> Increments of q and w in a step.
   pure subroutine heavy_stages(self, y, change)
      type(lean_motion_t), intent(in) :: self
      !> [q, w]; shape (7).
      real(wp), intent(in) :: y(7)
      real(wp), intent(out) :: change(7)
      real(wp) :: k(7, n_stages), stage(7), row(3)
      integer :: i
      stage = y
      do i = 1, n_stages
         if (self%single) then
            k(1, i) = -(stage(2)*stage(5) + stage(3)*stage(6) + stage(4)*stage(7))
            k(2, i) = stage(1)*stage(5) + stage(3)*stage(7) - stage(4)*stage(6)
            k(3, i) = stage(1)*stage(6) + stage(4)*stage(5) - stage(2)*stage(7)
            k(4, i) = stage(1)*stage(7) + stage(2)*stage(6) - stage(3)*stage(5)
            row(1) = stage(2)*stage(4) - stage(1)*stage(3)
            row(2) = stage(3)*stage(4) + stage(1)*stage(2)
            row(3) = (stage(1)*stage(1) + stage(4)*stage(4)) - (stage(2)*stage(2) + stage(3)*stage(3))
            associate (c => self%pull, kappa => self%kappa)
               k(5, i) = kappa(1)*(stage(6)*stage(7)) + (c(1, 2, 3)*row(2) + c(1, 3, 3)*row(3))
               k(6, i) = kappa(2)*(stage(7)*stage(5)) + (c(2, 1, 3)*row(1) + c(2, 3, 3)*row(3))
               k(7, i) = kappa(3)*(stage(5)*stage(6)) + (c(3, 1, 3)*row(1) + c(3, 2, 3)*row(2))
            end associate
         else
            call rates_in_fields(self, stage, k(:, i))
         end if
         select case (i)
         case (1)
            stage = y + a(1, 2)*k(:, 1)
         case (2)
            stage = y + a(1, 3)*k(:, 1) + a(2, 3)*k(:, 2)
         case (3)
            stage = y + a(1, 4)*k(:, 1) + a(3, 4)*k(:, 3)
         case (4)
            stage = y + a(1, 5)*k(:, 1) + a(3, 5)*k(:, 3) + a(4, 5)*k(:, 4)
         case (5)
            stage = y + a(1, 6)*k(:, 1) + a(4, 6)*k(:, 4) + a(5, 6)*k(:, 5)
         case (6)
            stage = y + a(1, 7)*k(:, 1) + a(4, 7)*k(:, 4) + a(5, 7)*k(:, 5) + a(6, 7)*k(:, 6)
         case (7)
            stage = y + a(1, 8)*k(:, 1) + a(4, 8)*k(:, 4) + a(5, 8)*k(:, 5) + a(6, 8)*k(:, 6) + a(7, 8)*k(:, 7)
         case (8)
            stage = y + a(1, 9)*k(:, 1) + a(4, 9)*k(:, 4) + a(5, 9)*k(:, 5) + a(6, 9)*k(:, 6) + a(7, 9)*k(:, 7) &
                    + a(8, 9)*k(:, 8)
         case (9)
            stage = y + a(1, 10)*k(:, 1) + a(4, 10)*k(:, 4) + a(5, 10)*k(:, 5) + a(6, 10)*k(:, 6) + a(7, 10)*k(:, 7) &
                    + a(8, 10)*k(:, 8) + a(9, 10)*k(:, 9)
         case (10)
            stage = y + a(1, 11)*k(:, 1) + a(4, 11)*k(:, 4) + a(5, 11)*k(:, 5) + a(6, 11)*k(:, 6) + a(7, 11)*k(:, 7) &
                    + a(8, 11)*k(:, 8) + a(9, 11)*k(:, 9) + a(10, 11)*k(:, 10)
         case (11)
            stage = y + a(1, 12)*k(:, 1) + a(4, 12)*k(:, 4) + a(5, 12)*k(:, 5) + a(6, 12)*k(:, 6) + a(7, 12)*k(:, 7) &
                    + a(8, 12)*k(:, 8) + a(9, 12)*k(:, 9) + a(10, 12)*k(:, 10) + a(11, 12)*k(:, 11)
         case default
            change = b(1)*k(:, 1) + b(6)*k(:, 6) + b(7)*k(:, 7) + b(8)*k(:, 8) + b(9)*k(:, 9) + b(10)*k(:, 10) &
                     + b(11)*k(:, 11) + b(12)*k(:, 12)
         end select
      end do
   end subroutine heavy_stages

   !> The rates of q and w where directions differ: all rows of R count.
   pure subroutine rates_in_fields(self, y, rate)
      type(lean_motion_t), intent(in) :: self
      !> [q, w]; shape (7).
      real(wp), intent(in) :: y(7)
      real(wp), intent(out) :: rate(7)
      real(wp) :: row(3, 3)
      integer :: k
      associate (q => y(1:4), w => y(5:7))
         rate(1:4) = quat_vector_product(q, w)
         rate(5) = self%kappa(1)*(w(2)*w(3))
         rate(6) = self%kappa(2)*(w(3)*w(1))
         rate(7) = self%kappa(3)*(w(1)*w(2))
         row(1, 1) = (q(1)*q(1) + q(2)*q(2)) - (q(3)*q(3) + q(4)*q(4))
         row(2, 1) = q(2)*q(3) - q(1)*q(4)
         row(3, 1) = q(2)*q(4) + q(1)*q(3)
         row(1, 2) = q(2)*q(3) + q(1)*q(4)
         row(2, 2) = (q(1)*q(1) + q(3)*q(3)) - (q(2)*q(2) + q(4)*q(4))
         row(3, 2) = q(3)*q(4) - q(1)*q(2)
         row(1, 3) = q(2)*q(4) - q(1)*q(3)
         row(2, 3) = q(3)*q(4) + q(1)*q(2)
         row(3, 3) = (q(1)*q(1) + q(4)*q(4)) - (q(2)*q(2) + q(3)*q(3))
      end associate
      do k = 1, 3
         associate (c => self%pull)
            rate(5) = rate(5) + (c(1, 2, k)*row(2, k) + c(1, 3, k)*row(3, k))
            rate(6) = rate(6) + (c(2, 1, k)*row(1, k) + c(2, 3, k)*row(3, k))
            rate(7) = rate(7) + (c(3, 1, k)*row(1, k) + c(3, 2, k)*row(2, k))
         end associate
      end do
   end subroutine rates_in_fields

end module nutate_lean_motion
