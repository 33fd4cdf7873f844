!> Cost of an attitude error with every method, as ratios to dop853 of the same run: box for 100 s, heavy top for 2 s.
!>
!> Fixed steps; times are medians of repeated integrations without rows, interpolated between two runs of a
!> work-precision study.
program bench_accuracy
   use, intrinsic :: iso_fortran_env, only: error_unit
   use nutate, only: read_scene, scene_t, status_t, wp
   use nutate_methods, only: family_of, methods
   use nutate_measured_run, only: problem_t
   use nutate_work_point, only: point_at_error, work_point_t
   use nutate_study_budget, only: study_budget_t
   use nutate_work_precision, only: work_precision_t
   implicit none

   !> Time limit for a scene, s.
   type(study_budget_t), parameter :: budget = study_budget_t(limit=20.0_wp)
   real(wp), parameter :: accuracies(2) = [1e-6_wp, 1e-10_wp]

   call write_table('box', 100.0_wp)
   call write_table('heavy_top', 2.0_wp)

contains

   !> Measures all methods on a scene and writes what the accuracies cost.
   subroutine write_table(name, end_time)
      character(len=*), intent(in) :: name
      !> s.
      real(wp), intent(in) :: end_time
      type(scene_t) :: scene
      type(work_precision_t) :: study
      type(work_point_t) :: points(size(methods), size(accuracies))
      type(status_t) :: status
      character(len=:), allocatable :: message
      integer :: i, k, baseline

      call read_scene('scenes/'//name//'.nml', scene, status, message)
      if (.not. status%ok()) then
         write (error_unit, '(a)') message
         error stop
      end if
      call study%begin(problem_t(scene%system, scene%initial, end_time, scene%integrator), scene%plan%time_step, budget)
      do while (.not. study%done)
         call study%advance()
      end do
      baseline = 0
      do i = 1, size(methods)
         if (family_of(methods(i)) == 'dop853') baseline = i
         do k = 1, size(accuracies)
            points(i, k) = point_at_error(study%points_of(i), methods(i)%order, accuracies(k))
         end do
      end do
      write (*, '(a,", ",f0.0," s: time to an attitude error of 1e-6 and 1e-10 rad, in units of dop853",/)') &
         name, end_time
      write (*, '(a,t26,4a12)') 'method', '1e-6 (ms)', 'ratio', '1e-10 (ms)', 'ratio'
      do i = 1, size(methods)
         if (methods(i)%order < 1) cycle
         call write_row(family_of(methods(i)), methods(i)%formulation, methods(i)%order, points(i, :), &
                        points(baseline, :))
      end do
      write (*, *)
   end subroutine write_table

   subroutine write_row(name, solver, order, points, baseline)
      character(len=*), intent(in) :: name, solver
      integer, intent(in) :: order
      type(work_point_t), intent(in) :: points(:), baseline(:)
      character(len=24) :: columns(2*size(points))
      character(len=48) :: label
      integer :: k
      write (label, '(a,1x,i0,1x,a)') trim(name), order, trim(solver)
      columns = '-'
      do k = 1, size(points)
         if (.not. points(k)%exists()) cycle
         write (columns(2*k - 1), '(f12.3)') 1e3_wp*points(k)%seconds
         if (baseline(k)%exists()) write (columns(2*k), '(f12.2)') points(k)%seconds/baseline(k)%seconds
      end do
      write (*, '(a,t26,4a12)') trim(label), (adjustr(columns(k) (1:12)), k=1, size(columns))
   end subroutine write_row

end program bench_accuracy
