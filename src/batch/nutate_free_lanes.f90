!> Several free bodies moved together by the reduced form of the conserving step, of order 2 or composed to 4, 6 or 8.
!>
!>     call bodies%set_up(order, dt)
!>     call bodies%put(lane, system, state)
!>     call bodies%step()
!>     call bodies%get(lane, state)
!>
!> A body that is `taken` has the bits that the scalar stepper gives it, whoever stands in the other lanes. A step is
!> taken where the root is that of the true motion for sure (|b| < 0.4 and a positive determinant), found as fast as in
!> most steps; a body of which that does not hold is given up, is no longer `taken`, and has to be run by the scalar
!> stepper from its start.
module nutate_free_lanes
   use nutate_composition, only: compositions
   use nutate_implicit_step, only: kept_after_surprise
   use nutate_kinds, only: wp
   use nutate_lane_step, only: correct_lanes, explicit_lanes, finish_lanes, invert_lanes, lanes, predict_lanes, &
      start_lanes, take_residuals
   use nutate_predictor, only: most_steps, weights
   use nutate_reduced, only: coarse, slow
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: free_lanes_t, lanes

   !> Iterations after which a lane that is not done is given up.
   integer, parameter :: most_iterations = 8
   !> Numbers of a body that a lane takes: products of several stay in the range of numbers.
   real(wp), parameter :: least = 1e-40_wp, greatest = 1e40_wp

   !> What belongs to one stage of a step.
   type :: stage_t
      !> s.
      real(wp) :: dt = 0.0_wp
      !> Δt/4s
      real(wp) :: scale(lanes) = 0.0_wp
      !> Steps known, and their roots, the latest first; shape (lanes, 3, steps).
      integer :: known = 0
      real(wp) :: past(lanes, 3, most_steps) = 0.0_wp
   end type stage_t

   !> The bodies, each a lane.
   type :: free_lanes_t
      private
      !> The lane has a body, which has not been given up.
      logical, public :: taken(lanes) = .false.
      type(stage_t), allocatable :: stages(:)
      !> Shapes (lanes, 4).
      real(wp) :: q(lanes, 4) = 0.0_wp, p(lanes, 4) = 0.0_wp, q_lost(lanes, 4) = 0.0_wp, p_lost(lanes, 4) = 0.0_wp
      !> J over its largest diagonal entry; J⁻¹, kg⁻¹ m⁻²; shapes (lanes, 3, 3).
      real(wp) :: inertia(lanes, 3, 3) = 0.0_wp, inverse(lanes, 3, 3) = 0.0_wp
   contains
      !> Empties all lanes, for steps of a length.
      procedure :: set_up
      !> Puts a body into a lane.
      procedure :: put
      !> One step of all bodies.
      procedure :: step
      !> Where a body is.
      procedure :: get
   end type free_lanes_t

contains

   !> Empties all lanes, for steps of a length.
   pure subroutine set_up(self, order, dt)
      class(free_lanes_t), intent(inout) :: self
      !> 2, 4, 6 or 8.
      integer, intent(in) :: order
      !> s.
      real(wp), intent(in) :: dt
      integer :: i, k, n
      if (allocated(self%stages)) deallocate (self%stages)
      if (order == 2) then
         allocate (self%stages(1))
         self%stages(1)%dt = dt
      else
         k = findloc(compositions%order, order, dim=1)
         n = compositions(k)%stages
         allocate (self%stages(n))
         do i = 1, n
            self%stages(i)%dt = compositions(k)%weights(min(i, n + 1 - i))*dt
         end do
      end if
      do i = 1, lanes
         call rest(self, i)
      end do
   end subroutine set_up

   !> A lane without a body: a sphere at rest, whose numbers disturb nobody.
   pure subroutine rest(self, lane)
      class(free_lanes_t), intent(inout) :: self
      integer, intent(in) :: lane
      integer :: k
      self%taken(lane) = .false.
      self%q(lane, :) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      self%p(lane, :) = 0.0_wp
      self%q_lost(lane, :) = 0.0_wp
      self%p_lost(lane, :) = 0.0_wp
      self%inertia(lane, :, :) = 0.0_wp
      self%inverse(lane, :, :) = 0.0_wp
      do k = 1, 3
         self%inertia(lane, k, k) = 1.0_wp
         self%inverse(lane, k, k) = 1.0_wp
      end do
      do k = 1, size(self%stages)
         self%stages(k)%scale(lane) = 0.0_wp
         self%stages(k)%past(lane, :, :) = 0.0_wp
      end do
   end subroutine rest

   !> Puts a body into a lane, before the first step; it is not `taken` where its numbers are out of a lane's range.
   pure subroutine put(self, lane, system, state)
      !> Set up.
      class(free_lanes_t), intent(inout) :: self
      !> 1 to `lanes`.
      integer, intent(in) :: lane
      !> Without effects.
      type(system_t), intent(in) :: system
      !> |q| = 1 and q·p = 0.
      type(state_t), intent(in) :: state
      real(wp) :: largest, momentum
      integer :: i
      call rest(self, lane)
      momentum = maxval(abs(state%p))
      if (.not. (all(abs(state%q) <= 2.0_wp) .and. momentum <= greatest .and. &
                 minval(system%body%moments) >= least .and. maxval(system%body%moments) <= greatest)) return
      if (system%body%breaks_triangle .or. (momentum > 0.0_wp .and. momentum < least)) return
      if (.not. all(abs(self%stages%dt) >= least .and. abs(self%stages%dt) <= greatest)) return
      self%taken(lane) = .true.
      self%q(lane, :) = state%q
      self%p(lane, :) = state%p
      self%q_lost(lane, :) = state%q_compensation
      self%p_lost(lane, :) = state%p_compensation
      self%inverse(lane, :, :) = system%body%inverse_inertia
      associate (j => system%body%inertia)
         largest = max(j(1, 1), j(2, 2), j(3, 3))
         self%inertia(lane, :, :) = j/largest
      end associate
      do i = 1, size(self%stages)
         self%stages(i)%scale(lane) = 0.25_wp*self%stages(i)%dt/largest
      end do
   end subroutine put

   !> One step of all bodies.
   pure subroutine step(self)
      class(free_lanes_t), intent(inout) :: self
      real(wp) :: given_up(lanes)
      integer :: i
      do i = 1, size(self%stages)
         given_up = merge(0.0_wp, 1.0_wp, self%taken)
         call take_stage(self, self%stages(i), given_up)
         self%taken = given_up < 0.5_wp
      end do
      do i = 1, lanes
         if (.not. self%taken(i)) call rest(self, i)
      end do
   end subroutine step

   !> One stage of a step.
   pure subroutine take_stage(self, stage, given_up)
      class(free_lanes_t), intent(inout) :: self
      type(stage_t), intent(inout) :: stage
      !> 1: yes.
      real(wp), intent(inout) :: given_up(lanes)
      real(wp) :: half(lanes, 3), momentum(lanes, 3), z(lanes, 3), determinant(lanes)
      integer :: iterations(lanes), k
      call start_lanes(self%q, self%p, stage%scale, half, momentum, given_up)
      if (stage%known > 0) then
         call predict_lanes(weights(:, stage%known), stage%past, given_up, z)
      else
         call explicit_lanes(0.25_wp*stage%dt, self%inverse, half, z, given_up)
      end if
      call solve(self%inertia, momentum, z, determinant, iterations, given_up)
      stage%known = min(stage%known + 1, most_steps)
      if (stage%known > kept_after_surprise) where (iterations > slow) given_up = 1.0_wp
      call finish_lanes(z, determinant, self%q, self%p, self%q_lost, self%p_lost, given_up)
      do k = most_steps, 2, -1
         stage%past(:, :, k) = stage%past(:, :, k - 1)
      end do
      stage%past(:, :, 1) = z
   end subroutine take_stage

   !> The modified Newton iteration, until every lane is done or given up.
   pure subroutine solve(inertia, momentum, z, determinant, iterations, given_up)
      real(wp), intent(in) :: inertia(lanes, 3, 3), momentum(lanes, 3)
      !> The prediction on entry.
      real(wp), intent(inout) :: z(lanes, 3)
      real(wp), intent(out) :: determinant(lanes)
      integer, intent(out) :: iterations(lanes)
      real(wp), intent(inout) :: given_up(lanes)
      real(wp) :: mean(lanes, 3), change(lanes, 3), rest_of(lanes), f(lanes, 3), rows(lanes, 3, 3)
      real(wp) :: size(lanes), moved(lanes), done(lanes)
      integer :: k
      size = huge(1.0_wp)
      moved = 0.0_wp
      done = 0.0_wp
      determinant = 1.0_wp
      rows = 0.0_wp
      iterations = 0
      do k = 1, most_iterations
         where (done < 0.5_wp) iterations = k
         call take_residuals(inertia, momentum, z, mean, change, rest_of, f)
         if (maxval(size) > coarse) &
            call invert_lanes(inertia, z, mean, change, rest_of, size, rows, determinant, moved, given_up)
         call correct_lanes(rows, determinant, f, z, size, moved, done, given_up)
         if (minval(done) > 0.5_wp) return
      end do
      where (done < 0.5_wp) given_up = 1.0_wp
   end subroutine solve

   !> Where a body is. Its time is not touched.
   pure subroutine get(self, lane, state)
      class(free_lanes_t), intent(in) :: self
      !> 1 to `lanes`, taken.
      integer, intent(in) :: lane
      type(state_t), intent(inout) :: state
      state%q = self%q(lane, :)
      state%p = self%p(lane, :)
      state%q_compensation = self%q_lost(lane, :)
      state%p_compensation = self%p_lost(lane, :)
   end subroutine get

end module nutate_free_lanes
