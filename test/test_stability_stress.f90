!> The groups of stability cases by name, and the report of a group run at full length: rows of
!> docs/results/hard-cases.csv.
module test_stability_stress
   use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
   use nutate_kinds, only: long
   use test_stability_axes, only: axis_cases
   use test_stability_columns, only: columns_cases
   use test_stability_case, only: number_text, record_t, stability_case_t, way_label, ways
   use test_stability_large_steps, only: large_step_cases
   use test_stability_long, only: long_cases
   use test_stability_scales, only: scales_cases
   use test_stability_starts, only: starts_cases
   use test_stability_stiff, only: stiff_cases
   use test_stability_time, only: time_cases
   use test_stability_top, only: top_cases
   implicit none
   private

   public :: list_groups, report_group

   !> Cases that belong together.
   type :: group_t
      character(len=16) :: name
      character(len=64) :: title
      procedure(list_cases), nopass, pointer :: cases => null()
   end type group_t

   abstract interface
      !> The cases of a group.
      function list_cases() result(cases)
         import :: stability_case_t
         type(stability_case_t), allocatable :: cases(:)
      end function list_cases
   end interface

contains

   !> The groups: one line for each, in the order of the document.
   function groups() result(list)
      type(group_t), allocatable :: list(:)
      list = [ &
             group_t('long', 'Long runs', long_cases), &
             group_t('large_steps', 'Large steps', large_step_cases), &
             group_t('axes', 'Unstable and degenerate axes', axis_cases), &
             group_t('top', 'Poles and limits of the top', top_cases), &
             group_t('stiff', 'Stiff and soft', stiff_cases), &
             group_t('scales', 'Scales', scales_cases), &
             group_t('starts', 'Starts off the manifold and from files', starts_cases), &
             group_t('time', 'Time', time_cases), &
             group_t('columns', 'Sensitivities over many steps', columns_cases) &
             ]
   end function groups

   !> Writes a line for each group, its name and title, and behind it one for each of its cases: nothing, its name, and
   !> what it guards against. Tabs separate the fields.
   subroutine list_groups()
      type(group_t), allocatable :: list(:)
      type(stability_case_t), allocatable :: cases(:)
      integer :: i, k
      list = groups()
      do i = 1, size(list)
         write (output_unit, '(3a)') trim(list(i)%name), achar(9), trim(list(i)%title)
         cases = list(i)%cases()
         do k = 1, size(cases)
            write (output_unit, '(4a)') achar(9), trim(cases(k)%name), achar(9), trim(cases(k)%guards)
         end do
      end do
   end subroutine list_groups

   !> Runs all cases of a group at full length and writes their rows of docs/results/hard-cases.csv; progress and
   !> failures go to standard error.
   subroutine report_group(name, runs, failures)
      character(len=*), intent(in) :: name
      !> Cases times ways; 0: there is no such group.
      integer, intent(out) :: runs
      integer, intent(out) :: failures
      type(group_t), allocatable :: list(:)
      type(stability_case_t), allocatable :: cases(:)
      integer :: i, k
      runs = 0
      failures = 0
      list = groups()
      do i = 1, size(list)
         if (list(i)%name /= name) cycle
         cases = list(i)%cases()
         do k = 1, size(cases)
            call report_case(name, cases(k), runs, failures)
         end do
      end do
   end subroutine report_group

   !> The rows of one case: group, case, formulation and order, steps, subdivided steps, errors of energy, momentum and
   !> norm, what else was measured with its value, 1 if the case was rejected, and why.
   subroutine report_case(group, item, runs, failures)
      character(len=*), intent(in) :: group
      type(stability_case_t), intent(in) :: item
      integer, intent(inout) :: runs, failures
      type(record_t) :: record
      integer :: i
      do i = 1, size(ways)
         if (.not. item%selected(i)) cycle
         record = record_t()
         call item%run(ways(i), .true., record)
         runs = runs + 1
         if (.not. record%passed) then
            failures = failures + 1
            record%outcome = 'FAILED: '//record%message
         end if
         write (error_unit, '(*(a))') trim(item%name), ' (', way_label(ways(i)), '): ', &
            merge('passed', 'FAILED', record%passed), ' ', trim(record%outcome)
         write (output_unit, '(*(a))') group, ',', quoted(item%name), ',', quoted(way_label(ways(i))), ',', &
            count_text(record%steps), ',', count_text(record%subdivided_steps), ',', number_text(record%energy), ',', &
            number_text(record%momentum), ',', number_text(record%norm), ',', quoted(record%measure), ',', &
            number_text(record%value), ',', merge('1', '0', record%refused), ',', quoted(record%outcome)
         flush (output_unit)
      end do
   end subroutine report_case

   !> A text as a field of a CSV file.
   pure function quoted(text)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: quoted
      integer :: i
      quoted = '"'
      do i = 1, len_trim(text)
         if (text(i:i) == '"') quoted = quoted//'"'
         quoted = quoted//text(i:i)
      end do
      quoted = quoted//'"'
   end function quoted

   !> Digits of a count.
   pure function count_text(count) result(text)
      integer(long), intent(in) :: count
      character(len=:), allocatable :: text
      character(len=20) :: buffer
      write (buffer, '(i0)') count
      text = trim(buffer)
   end function count_text

end module test_stability_stress
