!> What an accuracy costs with a method, read from the method's runs.
module nutate_accuracy_price
   use nutate_kinds, only: wp
   use nutate_run_cost, only: run_cost_t
   implicit none
   private

   public :: accuracy_price_t, price_of

   !> An error after a rung that met a tolerance may be this much above it; more, and the rung was luck.
   real(wp), parameter :: luck = 4.0_wp

   !> What an accuracy costs.
   type :: accuracy_price_t
      !> The runs reach the accuracy.
      logical :: reached = .false.
      !> Row of `methods`.
      integer :: method = 0
      !> Wall time and step, s.
      real(wp) :: seconds = huge(1.0_wp), time_step = 0.0_wp
      !> Error of each step, rad, where they were chosen for it.
      real(wp) :: tolerance = 0.0_wp
      !> Worst energy residual, over T + |V|.
      real(wp) :: energy_error = 0.0_wp
   end type accuracy_price_t

contains

   !> The price of an attitude error, by interpolation between the logarithms of errors, times and steps of two runs. An
   !> error is taken to fall no faster than the method's order, or the tolerance of its steps, says, so that a longest
   !> step that is hopeless does not make the next one look better than it is.
   pure function price_of(runs, order, tolerance) result(price)
      !> Of one method, longest step first, with errors that are known; shape (any).
      type(run_cost_t), intent(in) :: runs(:)
      integer, intent(in) :: order
      !> rad.
      real(wp), intent(in) :: tolerance
      type(accuracy_price_t) :: price
      integer :: i
      real(wp) :: fraction, fall

      i = first_within(runs, tolerance)
      if (i == 0) return
      price%reached = .true.
      price%method = runs(i)%method
      price%seconds = runs(i)%seconds
      price%time_step = runs(i)%time_step
      price%tolerance = runs(i)%tolerance
      price%energy_error = runs(i)%energy_error
      if (i == 1 .or. .not. runs(i)%attitude_error > 0.0_wp) return
      associate (long => runs(i - 1), short => runs(i))
         fall = real(order, wp)*log(long%time_step/short%time_step)
         if (short%tolerance > 0.0_wp) fall = log(long%tolerance/short%tolerance)
         fraction = log(tolerance/short%attitude_error)/min(log(long%attitude_error/short%attitude_error), fall)
         fraction = min(max(fraction, 0.0_wp), 1.0_wp)
         price%tolerance = between(short%tolerance, long%tolerance, fraction)
         price%time_step = between(short%time_step, long%time_step, fraction)
         price%seconds = between(short%seconds, long%seconds, fraction)
         price%energy_error = between(short%energy_error, long%energy_error, fraction)
      end associate
   end function price_of

   !> A value between two on a logarithmic scale; the first where one of them has no logarithm.
   pure real(wp) function between(a, b, fraction)
      !> Of one sign.
      real(wp), intent(in) :: a, b
      !> 0 at a, 1 at b.
      real(wp), intent(in) :: fraction
      between = a
      if (abs(a) > 0.0_wp .and. abs(b) > 0.0_wp) between = a*(b/a)**fraction
   end function between

   !> The longest step that meets a tolerance, and not by luck; 0 if there is none.
   pure integer function first_within(runs, tolerance) result(i)
      type(run_cost_t), intent(in) :: runs(:)
      real(wp), intent(in) :: tolerance
      do i = 1, size(runs)
         if (runs(i)%attitude_error > tolerance) cycle
         if (i == size(runs)) return
         if (runs(i + 1)%attitude_error <= luck*tolerance) return
      end do
      i = 0
   end function first_within

end module nutate_accuracy_price
