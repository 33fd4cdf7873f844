!> Tops in SIMD lanes: one top a lane, each with its own numbers, time and step.
!>
!> A top is an asymmetric body in a potential -m·e, e a fixed direction of space in body axes. The series are those of Ω
!> by Euler's equations, of e, and of h, a direction of space perpendicular to e:
!>
!>     J Ω' = JΩ×Ω + m×e,   e' = e×Ω,   h' = h×Ω:
!>
!> 15 products where L and three directions have 24. All numbers are in principal axes.
module nutate_top_lanes
   use nutate_kinds, only: wp, long
   use nutate_quaternion, only: rotation_matrix
   implicit none
   private

   public :: lane_count, top_t, top_lanes_t, put_top

   !> Number of SIMD lanes, one register of AVX2: with two, the nine sums would not stay in registers.
   integer, parameter :: lane_count = 4
   !> Largest rotation of a step, rad, below π, where q and -q could not be told apart.
   real(wp), parameter :: largest_turn = 3.0_wp
   !> First unit of time over the longest step.
   real(wp), parameter :: first_unit = 0.125_wp
   !> Least square of the angular velocity across e over that of the largest angular velocity.
   real(wp), parameter :: least_ratio = 1e-32_wp

   !> A top before and after its run.
   type :: top_t
      !> J, kg m², and m, J; shape (3).
      real(wp) :: moments(3) = 1.0_wp, moment(3) = 0.0_wp
      !> Angular velocity, rad/s; shape (3).
      real(wp) :: omega(3) = 0.0_wp
      !> Attitude with respect to axes whose third one is e; shape (4).
      real(wp) :: q(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> Time and end time, s.
      real(wp) :: t = 0.0_wp, end_time = 0.0_wp
      !> Largest departures from the energy, J, and the momentum along e, N m s, of the initial state, at the ends of
      !> steps.
      real(wp) :: energy_error = 0.0_wp, momentum_error = 0.0_wp
      !> Steps.
      integer(long) :: steps = 0
      !> True if the end time was reached, and the invariants kept.
      logical :: arrived = .false.
   end type top_t

   !> Tops in the lanes.
   type :: top_lanes_t
      !> J, kg m²; 1/J; (J₂ - J₃)/J₁ in cyclic order; m, J; m₂/J₁, m₃/J₁ in cyclic order; shape (lane, 3), or
      !> (lane, 3, 2).
      real(wp) :: moments(lane_count, 3), inverse(lane_count, 3), euler(lane_count, 3), moment(lane_count, 3), &
         push(lane_count, 3, 2)
      !> Energy and momentum along e of the initial state, J and N m s; largest departures from them; 1 over the size of
      !> L, which is |L| of the initial state or √(|m|J).
      real(wp), dimension(lane_count) :: energy, along, energy_error, momentum_error, per_momentum
      !> |m|, J; least square of the angular velocity across e, rad²/s², by which moves are divided; number of
      !> corrections that would have been too long.
      real(wp), dimension(lane_count) :: potential, least_square, failures
      !> Unit of time and remaining time, s, signed; longest step, s; step in units of time.
      real(wp), dimension(lane_count) :: unit, left, longest, step
      !> Squares of the last term, and of the one before, as angles.
      real(wp) :: terms(lane_count, 2)
      !> Attitude; least cosine of half the rotation of a step so far.
      real(wp) :: q(lane_count, 4), cosine(lane_count)
      !> Ω, rad/s, e and h; shape (lane, 9).
      real(wp) :: y(lane_count, 9)
   end type top_lanes_t

contains

   !> Fills a lane with a top.
   pure subroutine put_top(self, lane, top)
      type(top_lanes_t), intent(inout) :: self
      integer, intent(in) :: lane
      type(top_t), intent(in) :: top
      real(wp) :: rows(3, 3), momentum(3), energy, size
      integer :: i, j, k
      rows = rotation_matrix(top%q)
      do i = 1, 3
         j = 1 + modulo(i, 3)
         k = 1 + modulo(i + 1, 3)
         self%euler(lane, i) = (top%moments(j) - top%moments(k))/top%moments(i)
         self%push(lane, i, :) = [top%moment(j), top%moment(k)]/top%moments(i)
      end do
      self%moments(lane, :) = top%moments
      self%inverse(lane, :) = 1/top%moments
      self%moment(lane, :) = top%moment
      momentum = top%moments*top%omega
      size = norm2(top%moment)
      energy = 0.5_wp*dot_product(momentum, top%omega)
      self%energy(lane) = energy - dot_product(top%moment, rows(3, :))
      self%along(lane) = dot_product(momentum, rows(3, :))
      self%energy_error(lane) = 0.0_wp
      self%momentum_error(lane) = 0.0_wp
      self%per_momentum(lane) = 1/max(norm2(momentum), sqrt(size*minval(top%moments)))
      self%longest(lane) = largest_turn*sqrt(0.5_wp*minval(top%moments)/(energy + 2*size))
      self%potential(lane) = size
      self%least_square(lane) = least_ratio/self%longest(lane)**2
      self%failures(lane) = 0.0_wp
      self%left(lane) = top%end_time - top%t
      self%unit(lane) = sign(first_unit*self%longest(lane), self%left(lane))
      self%q(lane, :) = top%q
      self%cosine(lane) = 1.0_wp
      self%y(lane, :) = [top%omega, rows(3, :), rows(1, :)]
   end subroutine put_top

end module nutate_top_lanes
