!> Weights the errors of a step by their estimates, to reconcile quantities that are known twice at its end.
!>
!> A Runge-Kutta method integrates the works of torques, motors and time-dependent potentials beside the state, and with
!> them the momentum in space, l = l₀ + ∫ Rτ dt. Energy and momentum of the state are then known twice, but only the
!> difference of the two errors is known. Least squares divide it in the ratio of the squares of the estimates that the
!> embedded method gives for the two:
!>
!> * Of the difference E of energy and balance, the works take the part sE and the state the rest,
!>   s = σ_W²/(σ_W² + σ_H²), σ_H² = ν((Ω·δL)² + (τ·δ)² + Σ(ω δh)²) with the estimates for the momentum, the attitude
!>   (the rotation vector δ, τ the torque of the potentials) and the wheels. Terms are squared one by one, since they
!>   cancel only by coincidence.
!> * Of the difference D of the two momenta, the state takes the part sD, s = σ_L²/(σ_L² + σ_l²), σ_L that of RL,
!>   RδL + R(δ×L), and σ_l that of the integral. A weak torque so leaves l as it is without the torque, as unstable axes
!>   require.
!> * The state moves to its energy by a rotation δ and a change ΔL of the momentum, the smallest in |δ|² + |ΔL|²/S²: S²
!>   is ten times the sum of what is left of σ_L² and σ_l², over |δ|².
module nutate_error_weighting
   use nutate_effect_list, only: effect_list_t
   use nutate_invariants, only: ALL_COMPONENTS
   use nutate_kinds, only: wp
   use nutate_projection_point, only: projection_plan_t, projection_point_t, slope_t
   use nutate_quaternion, only: cross
   use nutate_state, only: state_t
   use nutate_step_error, only: step_error_t
   implicit none
   private

   public :: balance_momentum, step_error_t, book_share, divide_excess, share_of_works

   !> ν: the error of the method is three orders higher than its estimate, and there the works, which vary twice as fast
   !> as the state, are less accurate than estimated. Measured on 1500 random scenes: with 1 the scenes with the largest
   !> errors of work gain less; with 0.1 and less, more of the others lose.
   real(wp), parameter :: weight = 0.3_wp
   !> Factor of ν for series: the errors of works are no larger than those of the motion unless the motion decays; then
   !> they are 2ⁿ times as large.
   real(wp), parameter :: of_series = 100.0_wp
   !> Largest useful estimate, with energies of order one: the square of a larger one might overflow.
   real(wp), parameter :: hopeless = 1e50_wp
   !> Factor in S², measured likewise; largest factor between S² and its usual value; square of a rotation, rad², below
   !> which it is treated as none; square of the longest move with an unusual S², rad².
   real(wp), parameter :: freedom = 10.0_wp, farthest = 1e8_wp, least_rotation = 1e-40_wp, longest = 1e-4_wp

contains

   !> Moves a momentum towards the balance of l, and the estimates with it.
   pure subroutine balance_momentum(error, noise, momentum)
      type(step_error_t), intent(inout) :: error
      !> Differences up to this part of the momentum are round-off.
      real(wp), intent(in) :: noise
      !> L, body axes, N m s; shape (3).
      real(wp), intent(inout) :: momentum(3)
      real(wp) :: of_state(3), of_balance_part(3), square, share
      error%square = -1.0_wp
      if (.not. error%balances) return
      if (.not. maxval(abs(error%balance)) > max(noise*maxval(abs(momentum)), tiny(1.0_wp))) return
      of_state = error%momentum + cross(error%rotation, momentum)
      of_balance_part = error%of_balance
      error%size = max(maxval(abs(momentum)), maxval(abs(of_state)), maxval(abs(of_balance_part)))
      of_state = of_state/error%size
      of_balance_part = of_balance_part/error%size
      square = dot_product(of_state, of_state)
      share = square + dot_product(of_balance_part, of_balance_part)
      if (.not. share > tiny(1.0_wp)) return
      share = square/share
      momentum = momentum + share*error%balance
      error%momentum = error%size*((1 - share)*of_state + share*of_balance_part) - cross(error%rotation, momentum)
      error%square = share*dot_product(of_balance_part, of_balance_part)
   end subroutine balance_momentum

   !> Gives the works their share of an excess above the round-off of the remaining energy, and weighs the two moves for
   !> the rest. Round-off of the balance depends on the largest energy so far.
   pure subroutine divide_excess(plan, error, point, slope, noise, size, to_order_one, excess, given, push)
      type(projection_plan_t), intent(in) :: plan
      type(step_error_t), intent(in) :: error
      !> Point that was evaluated.
      type(projection_point_t), intent(in) :: point
      !> Slope at the point.
      type(slope_t), intent(in) :: slope
      !> Part of an energy that is round-off; the largest T + Σ|U| so far, J.
      real(wp), intent(in) :: noise, size
      !> A power of two that brings energies to order one.
      real(wp), intent(in) :: to_order_one
      !> Excess times `to_order_one`, J.
      real(wp), intent(inout) :: excess
      !> Energy given to the works, J; S² over its usual value. Both are unchanged if the excess is round-off.
      real(wp), intent(inout) :: given, push
      type(slope_t) :: weighed
      real(wp) :: share, left
      left = point%size
      if (plan%has_wheels) left = left - plan%still_energy()
      if (abs(excess) <= noise*(to_order_one*left)) return
      share = share_of_works(plan, point, error, noise*size, to_order_one, excess)
      given = share*(excess/to_order_one)
      excess = (1 - share)*excess
      push = weight_of_push(point, error)
      weighed = slope
      call weighed%weigh_push(push)
      if (.not. excess*excess < longest*weighed%steepness) push = 1.0_wp
   end subroutine divide_excess

   !> Returns the share of the works in an excess, 0 to 1: none if the excess is larger than both estimates. A step with
   !> a larger error than that of a method of lower order does not follow the motion, and only the invariants keep it
   !> near.
   pure real(wp) function share_of_works(plan, point, error, rounding, to_order_one, excess) result(share)
      type(projection_plan_t), intent(in) :: plan
      !> Point that was evaluated.
      type(projection_point_t), intent(in) :: point
      type(step_error_t), intent(in) :: error
      !> Possible round-off of the works so far, J.
      real(wp), intent(in) :: rounding
      !> A power of two that brings energies to order one.
      real(wp), intent(in) :: to_order_one
      !> Excess times `to_order_one`, J.
      real(wp), intent(in) :: excess
      real(wp) :: omega(3), rate(3), kinetic, potential, wheels, work, state, speed, limit
      integer :: i
      omega = point%omega
      if (plan%turns) omega = point%relative
      ! If l is conserved and was restored, the error of L is that of the attitude alone.
      rate = point%rate
      if (plan%components == ALL_COMPONENTS) then
         omega = 0.0_wp
      else
         rate = rate - cross(point%momentum, omega)
      end if
      kinetic = to_order_one*dot_product(omega, error%momentum)
      potential = to_order_one*dot_product(rate, error%rotation)
      wheels = 0.0_wp
      if (plan%moves_wheels) then
         do i = 1, plan%wheels%n
            if (.not. plan%wheels%moves(i)) cycle
            speed = plan%wheels%inverse_inertia(i)*plan%wheels%momentum(i) &
                    - dot_product(plan%wheels%axis(:, i), point%omega)
            wheels = wheels + (to_order_one*speed*error%wheels(i))**2
         end do
      end if
      limit = hopeless/to_order_one
      work = (to_order_one*min(error%work, limit))**2 + (to_order_one*rounding)**2
      state = kinetic**2 + potential**2 + wheels
      if (error%of_momentum > 0.0_wp) state = state + of_series*( &
                                      (to_order_one*min(error%of_momentum, limit))**2*dot_product(omega, omega) + &
                                      (to_order_one*min(error%angle, limit))**2*dot_product(rate, rate))
      share = 0.0_wp
      if (work > tiny(1.0_wp) .and. excess**2 <= work + state) share = work/(work + weight*state)
   end function share_of_works

   !> Returns S² over its usual value (2T/|Ω|)²; 1 if nothing is known.
   pure real(wp) function weight_of_push(point, error) result(push)
      !> Point that was evaluated.
      type(projection_point_t), intent(in) :: point
      type(step_error_t), intent(in) :: error
      real(wp) :: rotation, ratio
      push = 1.0_wp
      if (error%square < 0.0_wp .or. .not. point%twice_kinetic > 0.0_wp) return
      rotation = max(dot_product(error%rotation, error%rotation), least_rotation)
      ratio = min(error%size*(sqrt(dot_product(point%omega, point%omega))/point%twice_kinetic), farthest)
      push = min(farthest, max(1/farthest, freedom*(error%square/rotation)*ratio**2))
   end function weight_of_push

   !> Distributes the share of the works over them, in proportion to the work of each in the step.
   pure subroutine book_share(effects, given, done, work, state)
      type(effect_list_t), intent(in) :: effects
      !> Share of the works, and Σ|work| of the step, J.
      real(wp), intent(in) :: given, done
      !> Work of each effect, J; shape (n_works).
      real(wp), intent(inout) :: work(:)
      !> State; its work of wheels and of time-dependent potentials is changed accordingly.
      type(state_t), intent(inout) :: state
      real(wp) :: more
      integer :: i, wheel
      do i = 1, size(work)
         more = given*(abs(work(i))/done)
         work(i) = work(i) + more
         wheel = (i - effects%n_torques + 1)/2
         if (i <= effects%n_torques) cycle
         if (wheel <= effects%n_wheels) then
            associate (booked => state%wheel_work(2 - modulo(i - effects%n_torques, 2), wheel))
               booked = booked + more
            end associate
         else
            state%time_dependent_work = state%time_dependent_work + more
         end if
      end do
   end subroutine book_share

end module nutate_error_weighting
