!> Runs of many tops, several at a time by the lanes of vector instructions.
!>
!>     call tops%begin(tolerance)
!>     do while (tops%running > 0)
!>        call tops%perform_steps(1000)
!>     end do
!>
!> A lane whose top arrives gets the next one. Results do not depend on the other tops.
module nutate_tops
   use, intrinsic :: iso_c_binding, only: c_intptr_t, c_loc
   use nutate_kinds, only: wp, eps, long
   use nutate_power_series, only: highest_order, least_order
   use nutate_simd, only: has_avx2
   use nutate_top_avx2, only: expand_by_avx2 => expand_tops, move_by_avx2 => move_tops
   use nutate_top_lanes, only: lane_count, put_top, top_lanes_t, top_t
   use nutate_top_sse2, only: expand_by_sse2 => expand_tops, move_by_sse2 => move_tops
   implicit none
   private

   public :: top_t, tops_t

   !> Order for a tolerance: a part per binary digit, and a constant part.
   real(wp), parameter :: order_per_digit = 0.4_wp, extra_order = 5.0_wp
   !> Departure from the invariants that is round-off, over the energy or momentum that they consist of.
   real(wp), parameter :: round_off = 64*eps
   !> Longest correction of L over its size, in tolerances. Longer ones occur where the energy hardly depends on L.
   real(wp), parameter :: moved_tolerances = 10.0_wp
   !> Least cosine of half the rotation of a step, somewhat below that of the largest rotation.
   real(wp), parameter :: least_cosine = 0.06_wp

   !> Tops and their run.
   type :: tops_t
      !> Tops; before and after the run.
      type(top_t), allocatable :: tops(:)
      !> Number of tops under way.
      integer :: running = 0
      !> Limit of steps of a top.
      integer(long) :: max_steps = huge(1_long)
      type(top_lanes_t), private :: lanes
      !> Top in each lane, or 0; next top; order of the series; corrections of energy and momentum in a step.
      integer, private :: who(lane_count) = 0, next = 1, order = 0, corrections = 0
      real(wp), private :: tolerance = 0.0_wp
      !> Coefficients of the series, from `first` on, a multiple of the length of a register: registers that lie across
      !> two lines of the cache take twice the time.
      real(wp), private :: series(lane_count*(9*(highest_order + 1) + 1)) = 0.0_wp
      integer, private :: first = 1
      logical, private :: avx2 = .false.
   contains
      !> Prepares the runs.
      procedure :: begin
      !> Performs some steps of each lane.
      procedure :: perform_steps
   end type tops_t

contains

   !> Prepares the runs of `tops`.
   subroutine begin(self, tolerance)
      class(tops_t), intent(inout) :: self
      !> Error of a step, rad; positive.
      real(wp), intent(in) :: tolerance
      integer :: lane
      self%tolerance = max(tolerance, 0.5_wp*eps)
      self%order = nint(extra_order - order_per_digit*exponent(self%tolerance))
      self%order = min(max(self%order, least_order), highest_order)
      ! Each correction squares the error; 1e-20 is sufficient.
      self%corrections = merge(1, merge(2, 4, self%tolerance < 1e-6_wp), self%tolerance < 1e-11_wp)
      self%avx2 = has_avx2()
      self%first = aligned_index(self%series)
      self%running = 0
      self%next = 1
      if (size(self%tops) == 0) return
      do lane = 1, lane_count
         call fill_lane(self, lane)
      end do
   end subroutine begin

   !> Returns the index of the first element whose address is a multiple of the length of a register.
   integer function aligned_index(x) result(i)
      real(wp), intent(in), target :: x(lane_count)
      integer(c_intptr_t) :: address, bytes
      bytes = storage_size(x)/8
      address = transfer(c_loc(x), address)
      i = 1 + int(modulo(-(address/bytes), int(lane_count, c_intptr_t)))
   end function aligned_index

   !> Puts the next top into a lane. Without one the lane repeats the first top, whose second result is discarded.
   subroutine fill_lane(self, lane)
      class(tops_t), intent(inout) :: self
      integer, intent(in) :: lane
      self%who(lane) = 0
      if (self%next <= size(self%tops)) then
         self%who(lane) = self%next
         self%next = self%next + 1
         self%running = self%running + 1
      end if
      call put_top(self%lanes, lane, self%tops(max(self%who(lane), 1)))
   end subroutine fill_lane

   !> Performs some steps of each lane, fewer if all tops arrive.
   subroutine perform_steps(self, steps)
      class(tops_t), intent(inout) :: self
      integer, intent(in) :: steps
      real(wp) :: longest_move
      integer :: lane, n
      longest_move = moved_tolerances*self%tolerance + round_off
      do n = 1, steps
         if (self%running == 0) return
         if (self%avx2) then
            call expand_by_avx2(self%lanes, self%order, self%series(self%first))
            call choose_steps(self)
            call move_by_avx2(self%lanes, self%order, self%corrections, longest_move, self%series(self%first))
         else
            call expand_by_sse2(self%lanes, self%order, self%series(self%first))
            call choose_steps(self)
            call move_by_sse2(self%lanes, self%order, self%corrections, longest_move, self%series(self%first))
         end if
         do lane = 1, lane_count
            call note_step(self, lane)
         end do
      end do
   end subroutine perform_steps

   !> Chooses the steps by the last two terms (À. Jorba, M. Zou, Experimental Mathematics 14 (2005) 99), and so that
   !> no step leads beyond the end.
   pure subroutine choose_steps(self)
      class(tops_t), intent(inout) :: self
      real(wp) :: allowed
      integer :: i
      allowed = 2*log(self%tolerance)
      associate (lanes => self%lanes, n => self%order)
         do i = 1, lane_count
            lanes%step(i) = exp(min((allowed - log(lanes%terms(i, 1)))/(2*n), &
                                    (allowed - log(lanes%terms(i, 2)))/(2*n - 2)))
            lanes%step(i) = min(lanes%step(i), min(lanes%longest(i), abs(lanes%left(i)))/abs(lanes%unit(i)))
         end do
      end associate
   end subroutine choose_steps

   !> Counts the step of a lane; at the end, or after a failure, keeps the top and fills the lane with the next one.
   subroutine note_step(self, lane)
      class(tops_t), intent(inout) :: self
      integer, intent(in) :: lane
      real(wp) :: size_of_time
      associate (lanes => self%lanes, top => self%tops(max(self%who(lane), 1)))
         size_of_time = max(abs(top%t), abs(top%end_time))
         if (self%who(lane) == 0) then
            if (abs(lanes%left(lane)) <= 4*eps*size_of_time) call fill_lane(self, lane)
            return
         end if
         top%steps = top%steps + 1
         if (abs(lanes%left(lane)) > 4*eps*size_of_time) then
            if (top%steps < self%max_steps .and. abs(lanes%unit(lane)) > 4*eps*size_of_time) return
         else
            call keep_end(lanes, lane, top)
         end if
         self%running = self%running - 1
         call fill_lane(self, lane)
      end associate
   end subroutine note_step

   !> Keeps the end of a run. The top has arrived if it has kept the invariants, and each step its attitude.
   pure subroutine keep_end(lanes, lane, top)
      type(top_lanes_t), intent(in) :: lanes
      integer, intent(in) :: lane
      type(top_t), intent(inout) :: top
      real(wp) :: energy, momentum
      top%omega = lanes%y(lane, 1:3)
      top%q = lanes%q(lane, :)
      top%t = top%end_time
      top%energy_error = lanes%energy_error(lane)
      top%momentum_error = lanes%momentum_error(lane)
      momentum = max(norm2(top%moments*top%omega), 1/lanes%per_momentum(lane))
      energy = 0.5_wp*sum(top%moments*top%omega**2) + norm2(top%moment)
      top%arrived = lanes%cosine(lane) >= least_cosine .and. lanes%failures(lane) < 0.5_wp .and. &
                    top%energy_error <= round_off*energy .and. top%momentum_error <= round_off*momentum .and. &
                    all(abs([top%q, top%omega]) <= huge(1.0_wp))
   end subroutine keep_end

end module nutate_tops
