!> `&output`: the file, the times and the columns of the rows.
module nutate_scene_output
   use nutate_epoch, only: epoch_t
   use nutate_keys, only: group_t, key_t, name_length
   use nutate_kinds, only: wp
   use nutate_run_plan, only: run_plan_t
   use nutate_scene_error, only: scene_error_t
   implicit none
   private

   public :: output_settings_t, output_keys, build_output, format_fault

   !> Extensions of other formats, which the file of a history must not have.
   character(len=8), parameter :: other_formats(*) = [character(len=8) :: &
      '.npy', '.npz', '.h5', '.hdf5', '.nc', '.mat', '.parquet', '.feather', '.xlsx', '.ods', '.json', '.pkl', '.gz', &
      '.zip', '.svg', '.png', '.pdf']

   !> Files, columns and format of the rows.
   type :: output_settings_t
      !> Path of the CSV file, relative to the working directory.
      character(len=:), allocatable :: file
      !> Path of the file of events if the scene names one; else blank: the path follows from that of the rows.
      character(len=:), allocatable :: events
      !> Names of the sets of columns, as requested; shape (number of sets).
      character(len=name_length), allocatable :: columns(:)
      !> True if the scene does not say when rows are due: at each step, or at equal intervals if steps are adaptive.
      logical :: by_default = .false.
      !> Significant digits of the numbers; 0: as many as read back exactly.
      integer :: digits = 0
      !> Angles in degrees, rates in degrees per second.
      logical :: degrees = .false.
      !> Date of t = 0, for a column of dates in the files; not set: there is no such column.
      type(epoch_t) :: epoch
   end type output_settings_t

   !> Largest number of times of rows in a scene (more need a file), and of digits, which determine every number.
   integer, parameter :: most_times = 1000, most_digits = 17
   !> Intervals between the rows of a run with adaptive steps, unless the scene says otherwise: such steps are too few
   !> to draw a smooth curve through their ends.
   real(wp), parameter :: usual_intervals = 1000.0_wp

   interface

      !> Keys of the scene group `&output`.
      pure module function output_keys() result(keys)
         type(key_t) :: keys(10)
      end function output_keys

      !> Reads the output settings and the times of rows.
      module subroutine build_output(group, scene_name, path, plan, output, error)
         type(group_t), intent(in) :: group
         !> Name of the scene, from which that of the file follows unless the group gives one.
         character(len=*), intent(in) :: scene_name
         !> Path of the scene file, which must not be overwritten.
         character(len=*), intent(in) :: path
         !> Plan of the run: `time_step`, `end_time` and goal are used; `every`, `times`, and `interval` of an active
         !> goal are set.
         type(run_plan_t), intent(inout) :: plan
         type(output_settings_t), intent(out) :: output
         type(scene_error_t), intent(inout) :: error
      end subroutine build_output

      !> Returns what is wrong with a name that has the extension of another format; empty if nothing is.
      pure module function format_fault(name) result(words)
         character(len=*), intent(in) :: name
         character(len=:), allocatable :: words
      end function format_fault

   end interface

end module nutate_scene_output
