!> Expected steps, rows and bytes of a run, and the default limits of its output.
module nutate_expectation
   use nutate_columns, only: columns_t
   use nutate_console, only: plural
   use nutate_decimal, only: rounded_text
   use nutate_fixed_steps, only: count_steps
   use nutate_kinds, only: wp, long
   use nutate_printable, only: printable_path
   use nutate_run, only: run_t
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t
   implicit none
   private

   public :: known_steps, rows_of, most_rows, too_many_rows, expectation_text, size_text, history_bytes

   !> Limits of the rows and bytes of a history whose scene has neither `every` nor `interval`.
   integer(long), parameter :: greatest_rows = 1000000
   real(wp), parameter :: greatest_size = 1e8_wp
   !> Characters that a number takes in a history, its comma included.
   real(wp), parameter :: usual_field = 19.0_wp
   !> Characters of a date, its comma included.
   real(wp), parameter :: date_field = 27.0_wp

contains

   !> Returns the number of steps to come; negative if it is unknown before the run is over.
   integer(long) function known_steps(scene, run) result(steps)
      type(scene_t), intent(in) :: scene
      !> Run that has begun and found its steps.
      type(run_t), intent(in) :: run
      if (.not. scene%plan%goal%active()) then
         steps = count_steps(scene%initial%t, scene%plan)
      else
         steps = -1
         if (run%expected_steps > 0) steps = run%expected_steps
      end if
   end function known_steps

   !> Returns the rows of a history of so many steps; negative if they depend on an unknown number of steps.
   pure integer(long) function rows_of(scene, steps) result(rows)
      type(scene_t), intent(in) :: scene
      !> Number of steps; negative if unknown.
      integer(long), intent(in) :: steps
      associate (plan => scene%plan)
         rows = -1
         if (allocated(plan%times)) then
            rows = size(plan%times, kind=long)
         else if (plan%interval > 0.0_wp) then
            rows = 1 + ceiling(abs(plan%end_time)/plan%interval*(1 - epsilon(1.0_wp)), long)
         else if (steps >= 0) then
            rows = 1 + steps/plan%every + min(modulo(steps, plan%every), 1_long)
         end if
      end associate
   end function rows_of

   !> Returns the size of a history, bytes.
   real(wp) function history_bytes(scene, rows)
      type(scene_t), intent(in) :: scene
      integer(long), intent(in) :: rows
      type(columns_t) :: columns
      type(status_t) :: status
      call columns%choose(scene%output%columns, status, effects=scene%system%effects, propagated=scene%propagated())
      history_bytes = usual_field*real(rows, wp)*real(columns%width, wp)
      if (scene%output%epoch%is_set()) history_bytes = history_bytes + date_field*real(rows, wp)
   end function history_bytes

   !> Returns the most rows that may be written: any number if `every`, `interval` or times are given.
   integer(long) function most_rows(scene)
      type(scene_t), intent(in) :: scene
      integer :: i
      most_rows = min(greatest_rows, int(greatest_size/history_bytes(scene, 1_long), long))
      do i = 1, size(scene%groups)
         if (scene%groups(i)%name /= 'output') cycle
         if (scene%groups(i)%has('every') .or. scene%groups(i)%has('interval') .or. allocated(scene%plan%times)) &
            most_rows = huge(most_rows)
      end do
   end function most_rows

   !> Returns why a history of so many rows is rejected, and what to write instead.
   function too_many_rows(scene, rows) result(text)
      type(scene_t), intent(in) :: scene
      integer(long), intent(in) :: rows
      character(len=:), allocatable :: text
      integer(long) :: every
      every = 10_long**ceiling(log10(real(rows, wp)/1e4_wp))
      text = plural(rows, 'row')//', about '//size_text(history_bytes(scene, rows))// &
             ', more than is written by default (expected every = '//rounded_text(real(every, wp))// &
             ' in &output; every = 1 for all of them)'
   end function too_many_rows

   !> Returns the expected steps and rows if trial runs have found them; blank otherwise.
   function expectation_text(scene, run) result(text)
      type(scene_t), intent(in) :: scene
      !> Run that has begun and found its steps.
      type(run_t), intent(in) :: run
      character(len=:), allocatable :: text
      integer(long) :: steps, rows
      text = ''
      steps = run%expected_steps
      if (steps < 1) return
      rows = rows_of(scene, steps)
      text = printable_path(scene%file)//': '//plural(steps, 'step')//', '//plural(rows, 'row')//', about '// &
             size_text(history_bytes(scene, rows))//' to expect'
   end function expectation_text

   !> Returns a number of bytes for people.
   pure function size_text(bytes) result(text)
      real(wp), intent(in) :: bytes
      character(len=:), allocatable :: text
      if (bytes < 1e6_wp) then
         text = rounded_text(max(1.0_wp, anint(bytes/1e3_wp)), 2)//' kB'
      else if (bytes < 1e9_wp) then
         text = rounded_text(bytes/1e6_wp, 2)//' MB'
      else
         text = rounded_text(bytes/1e9_wp, 2)//' GB'
      end if
   end function size_text

end module nutate_expectation
