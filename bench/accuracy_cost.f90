!> What an attitude error costs with every method, as ratios to dop853 of the same run: box after 100 s, heavy top
!> after 2 s.
!>
!> Fixed steps; times are medians of repeated integrations without rows, between two rungs of a ladder of steps
!> interpolated.
program bench_accuracy
   use, intrinsic :: iso_fortran_env, only: error_unit
   use nutate, only: read_scene, scene_t, status_t, wp
   use nutate_step_ladder, only: step_ladder_t
   use nutate_methods, only: family_of, methods
   use nutate_accuracy_price, only: price_of, accuracy_price_t
   use nutate_reference, only: reference_methods, reference_t
   use nutate_stopwatch, only: stopwatch_t
   use nutate_measured_run, only: fastest_rate, problem_t
   implicit none

   !> Time for a scene, s.
   real(wp), parameter :: budget = 20.0_wp
   real(wp), parameter :: accuracies(2) = [1e-6_wp, 1e-10_wp]

   call write_table('box', 100.0_wp)
   call write_table('heavy_top', 2.0_wp)

contains

   !> Measures all methods on a scene and writes their prices.
   subroutine write_table(name, end_time)
      character(len=*), intent(in) :: name
      !> s.
      real(wp), intent(in) :: end_time
      type(scene_t) :: scene
      type(step_ladder_t) :: ladder
      type(accuracy_price_t) :: prices(size(methods), size(accuracies))
      type(status_t) :: status
      character(len=:), allocatable :: message
      integer :: i, k, baseline

      call read_scene('scenes/'//name//'.nml', scene, status, message)
      if (.not. status%ok()) then
         write (error_unit, '(a)') message
         error stop
      end if
      call climb(scene, end_time, ladder)
      baseline = 0
      do i = 1, size(methods)
         if (family_of(methods(i)) == 'dop853') baseline = i
         do k = 1, size(accuracies)
            prices(i, k) = price_of(ladder%runs_of(i), methods(i)%order, accuracies(k))
         end do
      end do
      write (*, '(a,", ",f0.0," s: time to an attitude error of 1e-6 and 1e-10 rad, in units of dop853",/)') &
         name, end_time
      write (*, '(a,t26,4a12)') 'method', '1e-6 (ms)', 'ratio', '1e-10 (ms)', 'ratio'
      do i = 1, size(methods)
         if (methods(i)%order < 1) cycle
         call write_row(family_of(methods(i)), methods(i)%linear_solver, methods(i)%order, prices(i, :), &
                        prices(baseline, :))
      end do
      write (*, *)
   end subroutine write_table

   !> Runs every method on a ladder of steps.
   subroutine climb(scene, end_time, ladder)
      type(scene_t), intent(in) :: scene
      real(wp), intent(in) :: end_time
      type(step_ladder_t), intent(out) :: ladder
      type(problem_t) :: problem
      type(reference_t) :: reference
      type(stopwatch_t) :: clock
      type(status_t) :: status
      real(wp) :: rate
      integer :: first, second

      problem%system = scene%system
      problem%start = scene%initial
      problem%end_time = end_time
      problem%settings = scene%integrator
      call clock%start()
      call reference_methods(first, second)
      call fastest_rate(problem, first, rate, status)
      call reference%begin(problem, rate)
      do while (.not. reference%settled)
         call reference%refine(problem, clock, 0.3_wp*budget)
      end do
      call ladder%begin(problem, rate, scene%plan%time_step)
      do while (.not. ladder%done)
         call ladder%climb(problem, reference, clock, budget)
      end do
   end subroutine climb

   subroutine write_row(name, solver, order, prices, baseline)
      character(len=*), intent(in) :: name, solver
      integer, intent(in) :: order
      type(accuracy_price_t), intent(in) :: prices(:), baseline(:)
      character(len=24) :: columns(2*size(prices))
      character(len=48) :: label
      integer :: k
      write (label, '(a,1x,i0,1x,a)') trim(name), order, trim(solver)
      columns = '-'
      do k = 1, size(prices)
         if (.not. prices(k)%reached) cycle
         write (columns(2*k - 1), '(f12.3)') 1e3_wp*prices(k)%seconds
         if (baseline(k)%reached) write (columns(2*k), '(f12.2)') prices(k)%seconds/baseline(k)%seconds
      end do
      write (*, '(a,t26,4a12)') trim(label), (adjustr(columns(k) (1:12)), k=1, size(columns))
   end subroutine write_row

end program bench_accuracy
