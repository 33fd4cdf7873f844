!> The loops that the benchmarks time.
module bench_timing
   use, intrinsic :: iso_fortran_env, only: error_unit
   use nutate, only: integrator_settings_t, make_stepper, state_t, status_t, stepper_t, system_t, wp
   use nutate_lapack, only: dgesv
   use nutate_stopwatch, only: stopwatch_t
   implicit none
   private

   public :: time_dgesv, time_steps, mean_iterations

contains

   !> Returns the time of one solution of an 8×8 system, ns, of the kind that a step leads to: near the unit matrix.
   real(wp) function time_dgesv() result(nanoseconds)
      integer, parameter :: repeats = 20000
      real(wp) :: matrix(8, 8), lu(8, 8), x(8), checksum
      integer :: pivots(8), info, i, j
      type(stopwatch_t) :: clock
      do j = 1, 8
         do i = 1, 8
            matrix(i, j) = 0.1_wp*sin(real(3*i + 7*j, wp))
         end do
         matrix(j, j) = matrix(j, j) + 1
      end do
      checksum = 0.0_wp
      call clock%start()
      do i = 1, repeats
         lu = matrix
         x = 1.0_wp
         call dgesv(8, 1, lu, 8, pivots, x, 8, info)
         checksum = checksum + x(1)
      end do
      nanoseconds = 1e9_wp*clock%seconds()/repeats
      if (.not. abs(checksum) > 0.0_wp) write (error_unit, '(a)') 'dgesv gave nothing'
   end function time_dgesv

   !> Returns the time of a step, ns, from `repeats` steps.
   real(wp) function time_steps(system, start, settings, dt, repeats) result(nanoseconds)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: start
      type(integrator_settings_t), intent(in) :: settings
      real(wp), intent(in) :: dt
      integer, intent(in) :: repeats
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      type(stopwatch_t) :: clock
      integer :: i
      call make_stepper(system, settings, stepper, status)
      if (.not. status%ok()) error stop 'a benchmark asks for a method that does not exist'
      state = start
      call clock%start()
      do i = 1, repeats
         call stepper%step(system, state, dt, status)
         if (.not. status%ok()) error stop 'a step of a benchmark failed'
      end do
      nanoseconds = 1e9_wp*clock%seconds()/repeats
   end function time_steps

   !> Returns the Newton iterations of a step, mean over `repeats` steps.
   real(wp) function mean_iterations(system, start, settings, dt, repeats)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: start
      type(integrator_settings_t), intent(in) :: settings
      real(wp), intent(in) :: dt
      integer, intent(in) :: repeats
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      integer :: i
      call make_stepper(system, settings, stepper, status)
      state = start
      mean_iterations = 0.0_wp
      do i = 1, repeats
         call stepper%step(system, state, dt, status)
         mean_iterations = mean_iterations + real(status%iterations, wp)/repeats
      end do
   end function mean_iterations

end module bench_timing
