!> The exact attitude of those motions that have a closed solution: free bodies, and tops on their axis of symmetry.
module nutate_exact_motion
   use nutate_body, only: body_t
   use nutate_exact_free, only: free_body_t
   use nutate_exact_top, only: lagrange_top_t
   use nutate_hamiltonian, only: body_momentum
   use nutate_kinds, only: wp, eps
   use nutate_quaternion, only: cross
   use nutate_status, only: status_t
   use nutate_measured_run, only: problem_t
   implicit none
   private

   public :: find_exact_attitude, NOT_EXACT, EXACT_FREE_BODY, EXACT_TOP

   !> Kind of closed solution.
   integer, parameter :: NOT_EXACT = 0, EXACT_FREE_BODY = 1, EXACT_TOP = 2

   !> Differences of moments over the largest, and sines of angles, that are round-off of the input.
   real(wp), parameter :: same = 16*eps

contains

   !> Finds the attitude at the end of a problem, if a closed solution gives it.
   subroutine find_exact_attitude(problem, kind, q)
      type(problem_t), intent(in) :: problem
      !> `NOT_EXACT`, `EXACT_FREE_BODY` or `EXACT_TOP`.
      integer, intent(out) :: kind
      !> Attitude at `end_time`; the initial attitude if there is no closed solution.
      real(wp), intent(out) :: q(4)

      kind = NOT_EXACT
      q = problem%start%q
      associate (effects => problem%system%effects)
         if (effects%n_torques + effects%n_rotors + effects%n_off > 0 .or. effects%n_potentials > 1 .or. &
             effects%frame_turns .or. effects%moves) return
         if (effects%n_potentials == 0) then
            call solve_free(problem, kind, q)
         else
            associate (potential => effects%potentials(1)%item)
               if (potential%is_linear()) &
                  call solve_top(problem, potential%series_moment(), potential%direction, kind, q)
            end associate
         end if
      end associate
   end subroutine find_exact_attitude

   subroutine solve_free(problem, kind, q)
      type(problem_t), intent(in) :: problem
      integer, intent(out) :: kind
      real(wp), intent(inout) :: q(4)
      type(free_body_t) :: solution
      type(status_t) :: status
      real(wp) :: momentum(3)
      kind = NOT_EXACT
      associate (body => problem%system%body, start => problem%start)
         call solution%prepare(body%moments, start%q, body_momentum(start), status, body%axes)
      end associate
      if (.not. status%ok()) return
      call solution%evaluate(problem%duration(), q, momentum)
      kind = EXACT_FREE_BODY
   end subroutine solve_free

   !> Solves a top: U = -moment·γ, γ = R(q)ᵀ direction, is m g l cos θ about the upward vertical -direction.
   subroutine solve_top(problem, moment, direction, kind, q)
      type(problem_t), intent(in) :: problem
      !> Moment, body axes, and direction, space axes; shape (3).
      real(wp), intent(in) :: moment(3), direction(3)
      integer, intent(inout) :: kind
      real(wp), intent(inout) :: q(4)
      type(lagrange_top_t) :: top
      type(status_t) :: status
      real(wp) :: frame(3, 3), across, along, strength, momentum(3)
      logical :: symmetric

      strength = norm2(moment)*norm2(direction)
      if (.not. strength > 0.0_wp) then
         call solve_free(problem, kind, q)
         return
      end if
      call find_symmetry(problem%system%body, moment/norm2(moment), frame, across, along, symmetric)
      if (.not. symmetric) return
      call top%prepare(across, along, strength, problem%start%q, body_momentum(problem%start), status, frame, &
                       -direction)
      if (.not. status%ok()) return
      call top%evaluate(problem%duration(), q, momentum)
      kind = EXACT_TOP
   end subroutine solve_top

   !> Tests whether a body is symmetric about a direction, and completes that direction to a frame.
   pure subroutine find_symmetry(body, direction, frame, across, along, symmetric)
      type(body_t), intent(in) :: body
      !> Direction, a unit vector, body axes; shape (3).
      real(wp), intent(in) :: direction(3)
      !> Columns: two transverse axes, the axis of symmetry.
      real(wp), intent(out) :: frame(3, 3)
      !> Moments across and along the axis, kg m².
      real(wp), intent(out) :: across, along
      logical, intent(out) :: symmetric
      real(wp) :: spread
      integer :: k, i, j

      k = maxloc(abs(matmul(direction, body%axes)), 1)
      i = 1 + mod(k, 3)
      j = 1 + mod(i, 3)
      associate (moments => body%moments)
         across = 0.5_wp*(moments(i) + moments(j))
         along = moments(k)
         spread = same*maxval(moments)
         symmetric = abs(moments(i) - moments(j)) <= spread
         ! A sphere is symmetric about every direction.
         if (norm2(cross(body%axes(:, k), direction)) > same) symmetric = symmetric .and. abs(across - along) <= spread
      end associate
      frame(:, 3) = direction
      frame(:, 1) = 0.0_wp
      frame(minloc(abs(direction), 1), 1) = 1.0_wp
      frame(:, 1) = cross(frame(:, 1), direction)
      frame(:, 1) = frame(:, 1)/norm2(frame(:, 1))
      frame(:, 2) = cross(direction, frame(:, 1))
   end subroutine find_symmetry

end module nutate_exact_motion
