!> Energies in the projection onto the invariants of several bodies together, and how they change: one body a lane.
!>
!> Potentials are linear or quadratic in directions n: where these are one, the component of the space momentum along it
!> is conserved, else none is. The arithmetic is that of `nutate_projection_point` and `nutate_invariant_projection`,
!> with γ = Rᵀn.
module nutate_lane_energies
   use nutate_kinds, only: wp, eps
   use nutate_lane_choice, only: choose_lanes, replace_lanes
   use nutate_lane_width, only: lanes
   implicit none
   private

   public :: turn_rates, find_energies, find_full_sizes, add_rotor
   public :: compute_momenta, restore_component, add_weight, add_gradient, find_pushes, push_momenta, turn_momenta
   public :: turn_momenta_little

contains

   !> Ω of bodies of diagonal inertia.
   pure subroutine turn_rates(inverse, x, w)
      real(wp), intent(in) :: inverse(lanes, 3, 3), x(lanes, 3)
      real(wp), intent(out) :: w(lanes, 3)
      integer :: i
      do i = 1, lanes
         w(i, 1) = inverse(i, 1, 1)*x(i, 1)
         w(i, 2) = inverse(i, 2, 2)*x(i, 2)
         w(i, 3) = inverse(i, 3, 3)*x(i, 3)
      end do
   end subroutine turn_rates

   !> 2T, T and L×Ω.
   pure subroutine find_energies(x, l, w, twice_kinetic, energy, rate)
      !> L without the momentum of rotors, L and Ω; shape (lanes, 3).
      real(wp), intent(in) :: x(lanes, 3), l(lanes, 3), w(lanes, 3)
      !> Shapes (lanes) and (lanes, 3).
      real(wp), intent(out) :: twice_kinetic(lanes), energy(lanes), rate(lanes, 3)
      integer :: i
      do i = 1, lanes
         twice_kinetic(i) = x(i, 1)*w(i, 1) + x(i, 2)*w(i, 2) + x(i, 3)*w(i, 3)
         energy(i) = 0.5_wp*twice_kinetic(i)
         rate(i, 1) = l(i, 2)*w(i, 3) - l(i, 3)*w(i, 2)
         rate(i, 2) = l(i, 3)*w(i, 1) - l(i, 1)*w(i, 3)
         rate(i, 3) = l(i, 1)*w(i, 2) - l(i, 2)*w(i, 1)
      end do
   end subroutine find_energies

   !> ½ Σ|xᵢ||J⁻¹ᵢⱼ||xⱼ|.
   pure subroutine find_full_sizes(inverse, x, size)
      real(wp), intent(in) :: inverse(lanes, 3, 3), x(lanes, 3)
      real(wp), intent(out) :: size(lanes)
      real(wp) :: s1, s2, s3
      integer :: i
      do i = 1, lanes
         s1 = abs(inverse(i, 1, 1)*x(i, 1)) + abs(inverse(i, 1, 2)*x(i, 2)) + abs(inverse(i, 1, 3)*x(i, 3))
         s2 = abs(inverse(i, 2, 1)*x(i, 1)) + abs(inverse(i, 2, 2)*x(i, 2)) + abs(inverse(i, 2, 3)*x(i, 3))
         s3 = abs(inverse(i, 3, 1)*x(i, 1)) + abs(inverse(i, 3, 2)*x(i, 2)) + abs(inverse(i, 3, 3)*x(i, 3))
         size(i) = 0.5_wp*(abs(x(i, 1))*s1 + abs(x(i, 2))*s2 + abs(x(i, 3))*s3)
      end do
   end subroutine find_full_sizes

   !> Adds |h||Ω|.
   pure subroutine add_rotor(rotor_length, w, size)
      real(wp), intent(in) :: rotor_length(lanes), w(lanes, 3)
      real(wp), intent(inout) :: size(lanes)
      integer :: i
      do i = 1, lanes
         size(i) = size(i) + rotor_length(i)*sqrt(w(i, 1)*w(i, 1) + w(i, 2)*w(i, 2) + w(i, 3)*w(i, 3))
      end do
   end subroutine add_rotor

   !> The L of p = 2 q∘[0, L], whatever round-off |q| has gathered.
   pure subroutine compute_momenta(q, p, momentum)
      !> Shape (lanes, 4).
      real(wp), intent(in) :: q(lanes, 4), p(lanes, 4)
      real(wp), intent(out) :: momentum(lanes, 3)
      real(wp) :: half
      integer :: i
      do i = 1, lanes
         half = 0.5_wp/((q(i, 1)*q(i, 1) + q(i, 2)*q(i, 2)) + (q(i, 3)*q(i, 3) + q(i, 4)*q(i, 4)))
         momentum(i, 1) = half*(q(i, 1)*p(i, 2) - q(i, 2)*p(i, 1) - q(i, 3)*p(i, 4) + q(i, 4)*p(i, 3))
         momentum(i, 2) = half*(q(i, 1)*p(i, 3) - q(i, 3)*p(i, 1) - q(i, 4)*p(i, 2) + q(i, 2)*p(i, 4))
         momentum(i, 3) = half*(q(i, 1)*p(i, 4) - q(i, 4)*p(i, 1) - q(i, 2)*p(i, 3) + q(i, 3)*p(i, 2))
      end do
   end subroutine compute_momenta

   !> Gives L its component along γ.
   pure subroutine restore_component(component, gamma, l)
      !> Shapes (lanes) and (lanes, 3).
      real(wp), intent(in) :: component(lanes), gamma(lanes, 3)
      real(wp), intent(inout) :: l(lanes, 3)
      real(wp) :: missing
      integer :: i
      do i = 1, lanes
         missing = component(i) - (l(i, 1)*gamma(i, 1) + l(i, 2)*gamma(i, 2) + l(i, 3)*gamma(i, 3))
         l(i, 1) = l(i, 1) + missing*gamma(i, 1)
         l(i, 2) = l(i, 2) + missing*gamma(i, 2)
         l(i, 3) = l(i, 3) + missing*gamma(i, 3)
      end do
   end subroutine restore_component

   !> Adds U and γ×∇U.
   pure subroutine add_weight(slope, gamma, energy, size, rate)
      !> ∇U = -m, J, and γ; shape (lanes, 3).
      real(wp), intent(in) :: slope(lanes, 3), gamma(lanes, 3)
      !> H, T + Σ|U| and L̇.
      real(wp), intent(inout) :: energy(lanes), size(lanes), rate(lanes, 3)
      real(wp) :: potential
      integer :: i
      do i = 1, lanes
         potential = slope(i, 1)*gamma(i, 1) + slope(i, 2)*gamma(i, 2) + slope(i, 3)*gamma(i, 3)
         energy(i) = energy(i) + potential
         size(i) = size(i) + abs(potential)
         rate(i, 1) = rate(i, 1) + (gamma(i, 2)*slope(i, 3) - gamma(i, 3)*slope(i, 2))
         rate(i, 2) = rate(i, 2) + (gamma(i, 3)*slope(i, 1) - gamma(i, 1)*slope(i, 3))
         rate(i, 3) = rate(i, 3) + (gamma(i, 1)*slope(i, 2) - gamma(i, 2)*slope(i, 1))
      end do
   end subroutine add_weight

   !> Adds U = ½γᵀAγ + U₀ and γ×Aγ.
   pure subroutine add_gradient(stiffness, offset, gamma, energy, size, rate)
      !> A and U₀, J, and γ; shapes (lanes, 3, 3), (lanes) and (lanes, 3).
      real(wp), intent(in) :: stiffness(lanes, 3, 3), offset(lanes), gamma(lanes, 3)
      !> H, T + Σ|U| and L̇.
      real(wp), intent(inout) :: energy(lanes), size(lanes), rate(lanes, 3)
      real(wp) :: g1, g2, g3, s1, s2, s3, potential
      integer :: i
      do i = 1, lanes
         g1 = gamma(i, 1)
         g2 = gamma(i, 2)
         g3 = gamma(i, 3)
         s1 = stiffness(i, 1, 1)*g1 + stiffness(i, 1, 2)*g2 + stiffness(i, 1, 3)*g3
         s2 = stiffness(i, 2, 1)*g1 + stiffness(i, 2, 2)*g2 + stiffness(i, 2, 3)*g3
         s3 = stiffness(i, 3, 1)*g1 + stiffness(i, 3, 2)*g2 + stiffness(i, 3, 3)*g3
         potential = 0.5_wp*(g1*s1 + g2*s2 + g3*s3) + offset(i)
         energy(i) = energy(i) + potential
         size(i) = size(i) + abs(potential)
         rate(i, 1) = rate(i, 1) + (g2*s3 - g3*s2)
         rate(i, 2) = rate(i, 2) + (g3*s1 - g1*s3)
         rate(i, 3) = rate(i, 3) + (g1*s2 - g2*s1)
      end do
   end subroutine add_gradient

   !> The part of the slope that changes L: ΔL = -c·inertia·Ω⊥.
   pure subroutine find_pushes(along, to_order_one, twice_kinetic, gamma, omega, inertia, steepness)
      !> Of l the component along γ is conserved, and Ω⊥ is the part of Ω across γ; else none is, and Ω⊥ is Ω.
      logical, intent(in) :: along
      !> A power of two that brings energies to order one, 2T, J, and γ.
      real(wp), intent(in) :: to_order_one(lanes), twice_kinetic(lanes), gamma(lanes, 3)
      !> Ω on entry, Ω⊥ on exit; shape (lanes, 3).
      real(wp), intent(inout) :: omega(lanes, 3)
      !> kg m².
      real(wp), intent(out) :: inertia(lanes)
      real(wp), intent(inout) :: steepness(lanes)
      real(wp), dimension(lanes) :: square, turns, kinetic
      real(wp) :: across
      integer :: i
      do i = 1, lanes
         square(i) = omega(i, 1)*omega(i, 1) + omega(i, 2)*omega(i, 2) + omega(i, 3)*omega(i, 3)
         turns(i) = 1 - merge(1.0_wp, 0.0_wp, square(i) <= tiny(1.0_wp)/eps)
      end do
      call replace_lanes(turns, 1.0_wp, square)
      do i = 1, lanes
         kinetic(i) = to_order_one(i)*twice_kinetic(i)
         inertia(i) = kinetic(i)*(twice_kinetic(i)/square(i))
      end do
      if (along) call project_across(gamma, omega)
      do i = 1, lanes
         across = omega(i, 1)*omega(i, 1) + omega(i, 2)*omega(i, 2) + omega(i, 3)*omega(i, 3)
         kinetic(i) = kinetic(i)*(across/square(i))*kinetic(i)
      end do
      call replace_lanes(turns, 0.0_wp, inertia)
      call replace_lanes(turns, 0.0_wp, kinetic)
      do i = 1, lanes
         steepness(i) = steepness(i) + kinetic(i)
      end do
   end subroutine find_pushes

   !> The part of Ω across γ.
   pure subroutine project_across(gamma, omega)
      !> Shape (lanes, 3).
      real(wp), intent(in) :: gamma(lanes, 3)
      real(wp), intent(inout) :: omega(lanes, 3)
      real(wp) :: along
      integer :: i
      do i = 1, lanes
         along = omega(i, 1)*gamma(i, 1) + omega(i, 2)*gamma(i, 2) + omega(i, 3)*gamma(i, 3)
         omega(i, 1) = omega(i, 1) - along*gamma(i, 1)
         omega(i, 2) = omega(i, 2) - along*gamma(i, 2)
         omega(i, 3) = omega(i, 3) - along*gamma(i, 3)
      end do
   end subroutine project_across

   !> L + ΔL.
   pure subroutine push_momenta(c, inertia, omega, momentum)
      real(wp), intent(in) :: c(lanes), inertia(lanes), omega(lanes, 3)
      real(wp), intent(inout) :: momentum(lanes, 3)
      real(wp) :: factor
      integer :: i
      do i = 1, lanes
         factor = c(i)*inertia(i)
         momentum(i, 1) = momentum(i, 1) - factor*omega(i, 1)
         momentum(i, 2) = momentum(i, 2) - factor*omega(i, 2)
         momentum(i, 3) = momentum(i, 3) - factor*omega(i, 3)
      end do
   end subroutine push_momenta

   !> The first term of a turn of the attitude by δ at fixed space momentum: L + L×δ.
   pure subroutine turn_momenta_little(c, to_order_one, rate, l, turned)
      !> δ is c times the rate, brought to order one; shapes (lanes) and (lanes, 3).
      real(wp), intent(in) :: c(lanes), to_order_one(lanes), rate(lanes, 3), l(lanes, 3)
      real(wp), intent(out) :: turned(lanes, 3)
      real(wp) :: d1, d2, d3
      integer :: i
      do i = 1, lanes
         d1 = c(i)*(to_order_one(i)*rate(i, 1))
         d2 = c(i)*(to_order_one(i)*rate(i, 2))
         d3 = c(i)*(to_order_one(i)*rate(i, 3))
         turned(i, 1) = l(i, 1) + (l(i, 2)*d3 - l(i, 3)*d2)
         turned(i, 2) = l(i, 2) + (l(i, 3)*d1 - l(i, 1)*d3)
         turned(i, 3) = l(i, 3) + (l(i, 1)*d2 - l(i, 2)*d1)
      end do
   end subroutine turn_momenta_little

   !> The whole of it, by the Cayley map, in some lanes: L + u + u×b, u = 2 L×b/(1 + |b|²), b = ½δ.
   pure subroutine turn_momenta(chosen, c, to_order_one, rate, l, turned)
      !> 1: yes; and as in `turn_momenta_little`.
      real(wp), intent(in) :: chosen(lanes), c(lanes), to_order_one(lanes), rate(lanes, 3), l(lanes, 3)
      real(wp), intent(inout) :: turned(lanes, 3)
      real(wp) :: whole(lanes, 3), h, b1, b2, b3, f, u1, u2, u3
      integer :: i, k
      do i = 1, lanes
         h = 0.5_wp*c(i)
         b1 = h*(to_order_one(i)*rate(i, 1))
         b2 = h*(to_order_one(i)*rate(i, 2))
         b3 = h*(to_order_one(i)*rate(i, 3))
         f = 2/(1 + (b1*b1 + b2*b2 + b3*b3))
         u1 = f*(l(i, 2)*b3 - l(i, 3)*b2)
         u2 = f*(l(i, 3)*b1 - l(i, 1)*b3)
         u3 = f*(l(i, 1)*b2 - l(i, 2)*b1)
         whole(i, 1) = l(i, 1) + (u1 + (u2*b3 - u3*b2))
         whole(i, 2) = l(i, 2) + (u2 + (u3*b1 - u1*b3))
         whole(i, 3) = l(i, 3) + (u3 + (u1*b2 - u2*b1))
      end do
      do k = 1, 3
         call choose_lanes(chosen, whole(:, k), turned(:, k))
      end do
   end subroutine turn_momenta

end module nutate_lane_energies
