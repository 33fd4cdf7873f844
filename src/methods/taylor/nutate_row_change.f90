!> Change of a state in a step by a series of rows, and its compensated sum with the state: the errors of q and p are
!> the rounding of the change, not that of their own digits.
module nutate_row_change
   use nutate_kinds, only: wp
   use nutate_limits, only: manifold_tolerance
   use nutate_motion_series, only: motion_series_t, NO_ROWS
   use nutate_quaternion, only: quat_conjugate, quat_product, quat_vector_product
   use nutate_series_sum, only: rotation_between
   use nutate_state, only: add_increment, state_t
   implicit none
   private

   public :: row_change_t, get_change, add_change

   real(wp), parameter :: identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]

   !> The change of a state from the start of a series to a time.
   type :: row_change_t
      !> c - 1, with c the unit quaternion of the rotation: the attitude is that of the start times c; shape (4).
      real(wp) :: turn(4) = 0.0_wp
      !> L at the time, and L less that of the start, body axes, N m s; shape (3).
      real(wp) :: momentum(3) = 0.0_wp, gain(3) = 0.0_wp
   end type row_change_t

contains

   !> Computes the change up to a time from the start of a series of L and three rows, or of L and the rotation, in body
   !> axes.
   pure subroutine get_change(series, s, change)
      type(motion_series_t), intent(in) :: series
      !> Time, in units of time.
      real(wp), intent(in) :: s
      type(row_change_t), intent(out) :: change
      real(wp) :: changes(4, 3), rows(3, 3)
      integer :: i
      call series%get_changes(s, changes)
      if (series%equations == NO_ROWS) then
         change%gain = changes(1:3, 2)
         change%momentum = series%momentum + change%gain
         change%turn = normalized_turn(changes(:, 1))
         return
      end if
      change%gain = changes(1, :)
      change%momentum = series%momentum + change%gain
      do i = 1, 3
         rows(:, i) = changes(1 + i, :)
      end do
      change%turn = turn_between(series%frame, rows)
      if (series%is_opposite(s, identity + change%turn)) change%turn = -change%turn - 2*identity
   end subroutine get_change

   !> Returns c/|c| - 1 from c - 1, without the rounding of c.
   pure function normalized_turn(turn) result(normalized)
      real(wp), intent(in) :: turn(4)
      real(wp) :: normalized(4), excess, length
      excess = 2*turn(1) + (turn(1)*turn(1) + turn(2)*turn(2) + turn(3)*turn(3) + turn(4)*turn(4))
      length = sqrt(1 + excess)
      normalized = turn/length
      normalized(1) = (turn(1) - excess/(1 + length))/length
   end function normalized_turn

   !> Returns c - 1 of the rotation c with R(c) (fᵢ + dᵢ) = fᵢ: of 4c₁c, which is linear in Σ fᵢ(fᵢ + dᵢ)ᵀ, the vector
   !> follows d alone, since Σ fᵢfᵢᵀ is symmetric.
   pure function turn_between(f, d) result(turn)
      !> fᵢ and dᵢ as columns; shape (3,3).
      real(wp), intent(in) :: f(3, 3), d(3, 3)
      real(wp) :: turn(4)
      real(wp) :: m(3, 3), c(4), square, length
      integer :: i
      do i = 1, 3
         m(:, i) = f(:, 1)*d(i, 1) + f(:, 2)*d(i, 2) + f(:, 3)*d(i, 3)
      end do
      c(1) = 4 + (m(1, 1) + m(2, 2) + m(3, 3))
      if (c(1) > 1.0_wp) then
         c(2:4) = [m(3, 2) - m(2, 3), m(1, 3) - m(3, 1), m(2, 1) - m(1, 2)]
         square = c(2)*c(2) + c(3)*c(3) + c(4)*c(4)
         length = sqrt(c(1)*c(1) + square)
         turn = [-square/(length + c(1)), c(2), c(3), c(4)]/length
      else
         c = rotation_between(f, f + d)
         turn = c/sqrt(c(1)*c(1) + c(2)*c(2) + c(3)*c(3) + c(4)*c(4))
         turn(1) = turn(1) - 1
      end if
   end function turn_between

   !> Adds a change to the q and p of a state, and removes the accumulated errors of |q| = 1 and q·p = 0: along both q
   !> and p, which leaves L unchanged.
   pure subroutine add_change(change, state)
      type(row_change_t), intent(in) :: change
      type(state_t), intent(inout) :: state
      real(wp) :: dq(4), dp(4), q(4), p(4), excess, along
      dq = quat_product(state%q, change%turn)
      dp = 2*(quat_vector_product(dq, change%momentum) + quat_vector_product(state%q, change%gain))
      q = state%q + dq
      p = state%p + dp
      excess = 0.5_wp*((q(1)*q(1) + q(2)*q(2)) + (q(3)*q(3) + q(4)*q(4)) - 1)
      along = (q(1)*p(1) + q(2)*p(2)) + (q(3)*p(3) + q(4)*p(4))
      state%q_compensation = state%q_compensation - excess*q
      state%p_compensation = state%p_compensation - (excess*p + along*q)
      call add_increment(state%q, state%q_compensation, dq)
      call add_increment(state%p, state%p_compensation, dp)
      p = state%p + state%p_compensation
      along = dot_product(state%q, p)
      if (along**2 <= (0.5_wp*manifold_tolerance)**2*dot_product(p, p)) return
      ! The momentum of a body that comes to rest is below the rounding of its earlier momentum.
      p = quat_product(quat_conjugate(state%q), p)
      state%p = quat_vector_product(state%q, p(2:4))
      state%p_compensation = 0.0_wp
   end subroutine add_change

end module nutate_row_change
