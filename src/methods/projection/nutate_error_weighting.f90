!> How a step may have erred, and what follows for what is known of its end twice over.
!>
!> A Runge-Kutta method integrates the works of torques, motors and time-dependent potentials beside the state, and with
!> them the momentum in space, l = l₀ + ∫ Rτ dt. Energy and momentum of the state are then known twice, and of two
!> errors only the difference is known. Least squares divide it as the squares of what the embedded method estimates for
!> the two:
!>
!> * Of the difference E of energy and balance of the works those take sE, and the state the rest,
!>   s = σ_W²/(σ_W² + σ_H²), σ_H² = ν((Ω·δL)² + (τ·δ)² + Σ(ω δh)²) with the estimates for the momentum, the attitude
!>   (the rotation vector δ, τ the torque of the potentials) and the wheels, squared one by one: where they cancel it is
!>   by accident.
!> * Of the difference D of the two momenta the state takes sD, s = σ_L²/(σ_L² + σ_l²), σ_L that of RL, RδL + R(δ×L),
!>   and σ_l that of the integral. A weak torque so leaves l what it is without, which unstable axes need.
!> * The state moves to its energy by a rotation δ and a change ΔL of the momentum, the smallest in |δ|² + |ΔL|²/S²: S²
!>   is what is left of σ_L² and σ_l² together, ten times, over |δ|².
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

   !> ν: the method errs three orders later than its estimate, and there the works, which change twice as fast as the
   !> state, are worse off than the estimate says. Measured on 1500 random scenes: with 1 those scenes gain less whose
   !> works err most, with 0.1 and less more of the others lose.
   real(wp), parameter :: weight = 0.3_wp
   !> Factor of ν for series: the works of a series err no more than the motion unless it dies out, and then by 2ⁿ times
   !> as much.
   real(wp), parameter :: of_series = 100.0_wp
   !> An estimate above this, energies in an order of one, is as bad as any: the square of a larger one might overflow.
   real(wp), parameter :: hopeless = 1e50_wp
   !> Ten times in S², measured likewise; from its usual value S² departs by no more than the second. Squares of
   !> rotations below the third, rad², are none. The fourth is that of the longest move with an S² that is not the usual
   !> one, rad².
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

   !> Gives the works their share of an excess that is more than round-off of the energy that is left, and weighs the
   !> two moves for the rest. Round-off of the balance depends on the largest energy that there was.
   pure subroutine divide_excess(plan, error, point, slope, noise, size, to_order_one, excess, given, push)
      type(projection_plan_t), intent(in) :: plan
      type(step_error_t), intent(in) :: error
      !> Evaluated.
      type(projection_point_t), intent(in) :: point
      !> Slope at the point.
      type(slope_t), intent(in) :: slope
      !> Part of an energy that is round-off; the largest T + Σ|U| so far, J.
      real(wp), intent(in) :: noise, size
      !> A power of two that brings energies to order one.
      real(wp), intent(in) :: to_order_one
      !> Excess times `to_order_one`, J.
      real(wp), intent(inout) :: excess
      !> J; S² over its usual value; as they were for round-off.
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

   !> Returns the share of the works in an excess, 0 to 1: none if the excess is larger than both estimates. A step that
   !> errs more than a method of lower order follows no motion, and the invariants are all that keeps it near one.
   pure real(wp) function share_of_works(plan, point, error, rounding, to_order_one, excess) result(share)
      type(projection_plan_t), intent(in) :: plan
      !> Evaluated.
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
      ! If l is conserved and was restored, L errs by the attitude alone.
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

   !> S² over its usual value (2T/|Ω|)²; 1 where nothing is known.
   pure real(wp) function weight_of_push(point, error) result(push)
      !> Evaluated.
      type(projection_point_t), intent(in) :: point
      type(step_error_t), intent(in) :: error
      real(wp) :: rotation, ratio
      push = 1.0_wp
      if (error%square < 0.0_wp .or. .not. point%twice_kinetic > 0.0_wp) return
      rotation = max(dot_product(error%rotation, error%rotation), least_rotation)
      ratio = min(error%size*(sqrt(dot_product(point%omega, point%omega))/point%twice_kinetic), farthest)
      push = min(farthest, max(1/farthest, freedom*(error%square/rotation)*ratio**2))
   end function weight_of_push

   !> Adds what works take to each of them, in proportion to what it did in the step.
   pure subroutine book_share(effects, given, done, work, state)
      type(effect_list_t), intent(in) :: effects
      !> J, and Σ|work|, J.
      real(wp), intent(in) :: given, done
      !> Shape (n_works).
      real(wp), intent(inout) :: work(:)
      !> The work of wheels and of time-dependent potentials that it holds is moved with theirs.
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
