!> The runs of a work-precision study as CSV: one row for each run, in the notation of histories.
module nutate_cost_csv
   use nutate_console, only: count_text
   use nutate_discarding, only: discard_file
   use nutate_decimal, only: decimal_length, decimal_t
   use nutate_files, only: output_file_t
   use nutate_invariants, only: conserved_momentum, NO_COMPONENT
   use nutate_kinds, only: wp, long
   use nutate_methods, only: family_of, methods
   use nutate_reference, only: reference_t
   use nutate_status, only: status_t
   use nutate_work_point, only: work_point_t
   use nutate_work_precision, only: work_precision_t
   implicit none
   private

   public :: cost_csv_t

   character(len=*), parameter :: header = 'method,order,formulation,time_step,steps,subdivided_steps,samples,'// &
                                           'wall_time,ns_per_step,iterations,attitude_error,reference_error,'// &
                                           'momentum_error,energy_error,norm_error'

   !> CSV file that is being written.
   type :: cost_csv_t
      type(output_file_t), private :: file
      logical :: on_standard_output = .false.
   contains
      !> Claims the file.
      procedure :: open
      !> Writes the runs and gives the file its name.
      procedure :: write
      !> Discards the file.
      procedure :: discard
      !> Returns the file that keeps the runs of a stopped study; blank if they are not in a file.
      procedure :: kept_in
   end type cost_csv_t

contains

   !> Claims the file. Errors: `NUTATE_IO`.
   subroutine open(self, name, status)
      class(cost_csv_t), intent(inout) :: self
      !> Path, or `-` for standard output.
      character(len=*), intent(in) :: name
      type(status_t), intent(out) :: status
      self%on_standard_output = name == '-' .or. name == '/dev/stdout' .or. name == '/dev/fd/1'
      call self%file%open(name, status)
   end subroutine open

   !> Discards the file.
   subroutine discard(self)
      class(cost_csv_t), intent(inout) :: self
      call discard_file(self%file)
   end subroutine discard

   !> Returns the file that keeps the runs of a stopped study; blank if they are not in a file.
   function kept_in(self) result(name)
      class(cost_csv_t), intent(in) :: self
      character(len=:), allocatable :: name
      name = self%file%kept_in()
   end function kept_in

   !> Writes all runs, method by method, longest step first. A complete file gets its name; another one stays partial.
   !> Errors: `NUTATE_IO`.
   subroutine write(self, study, complete, status)
      class(cost_csv_t), intent(inout) :: self
      type(work_precision_t), intent(in) :: study
      !> True if the file is complete and gets its name.
      logical, intent(in) :: complete
      type(status_t), intent(out) :: status
      type(work_point_t), allocatable :: points(:)
      type(decimal_t) :: decimal
      integer :: m, i, components
      real(wp) :: axis(3)

      call conserved_momentum(study%problem%system%effects, components, axis)
      call decimal%prepare()
      call self%file%put_line(header, status)
      do m = 1, size(methods)
         points = study%points_of(m)
         do i = 1, size(points)
            if (status%ok()) call self%file%put_line( &
               row(decimal, points(i), study%reference, components /= NO_COMPONENT), status)
         end do
      end do
      if (status%ok() .and. complete) then
         call self%file%finish(status)
      else if (status%ok()) then
         call self%file%abandon(status)
      else
         call discard_file(self%file)
      end if
   end subroutine write

   !> Returns the line of a run. Unknown values are empty fields.
   function row(decimal, point, reference, has_momentum) result(line)
      type(decimal_t), intent(in) :: decimal
      type(work_point_t), intent(in) :: point
      type(reference_t), intent(in) :: reference
      !> True if a component of the momentum is conserved.
      logical, intent(in) :: has_momentum
      character(len=:), allocatable :: line
      associate (method => methods(point%method))
         line = trim(family_of(method))//','//count_text(int(method%order, long))//','//trim(method%formulation)
      end associate
      line = line//field(decimal, point%time_step)//','//count_text(point%steps)//','// &
             count_text(point%subdivided_steps)//','//count_text(int(point%samples, long))// &
             field(decimal, point%seconds)//field(decimal, point%nanoseconds())//field(decimal, point%iterations)
      if (reference%known()) then
         line = line//field(decimal, point%attitude_error)//field(decimal, reference%uncertainty)
      else
         line = line//',,'
      end if
      if (has_momentum) then
         line = line//field(decimal, point%momentum_error)
      else
         line = line//','
      end if
      line = line//field(decimal, point%energy_error)//field(decimal, point%norm_error)
   end function row

   !> Returns a comma and a number.
   function field(decimal, value) result(text)
      type(decimal_t), intent(in) :: decimal
      real(wp), intent(in) :: value
      character(len=:), allocatable :: text
      character(len=decimal_length) :: line
      integer :: used
      used = 0
      call decimal%append(line, used, value)
      text = ','//line(1:used)
   end function field

end module nutate_cost_csv
