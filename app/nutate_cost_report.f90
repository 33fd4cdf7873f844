!> Results of `nutate cost`: the answer for people, the table, and the CSV file.
module nutate_cost_report
   use nutate_console, only: count_text, page_t
   use nutate_decimal, only: decimal_length, decimal_t, rounded_text
   use nutate_outputs, only: close_file
   use nutate_files, only: output_file_t
   use nutate_invariants, only: conserved_momentum, NO_COMPONENT
   use nutate_kinds, only: long, wp
   use nutate_method_choice, only: choose_method
   use nutate_methods, only: default_settings, family_of, methods
   use nutate_reference, only: reference_t, AGREED, EXACT_FREE_BODY, EXACT_TOP
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_table, only: number_text, table_t
   use nutate_work_point, only: point_within, work_point_t
   use nutate_work_precision, only: work_precision_t, LAST_LEVEL, OUT_OF_BUDGET, REFUSED, ROUND_OFF
   implicit none
   private

   public :: method_label, full_label, hopeless, add_answer, add_reference, add_table, cost_csv_t

   !> Attitude errors above this only show that the step is too long, rad.
   real(wp), parameter :: hopeless = 1.0_wp

   !> Name and full name of a method; methods that are not listed are shown by their name.
   type :: name_t
      character(len=24) :: name, words
   end type name_t

   type(name_t), parameter :: names(6) = [ &
      name_t('nielsen_krenk', 'Nielsen-Krenk'), name_t('rk4', 'Runge-Kutta rk4'), name_t('rk8', 'Runge-Kutta rk8'), &
      name_t('dop853', 'Dormand-Prince dop853'), name_t('taylor', 'Taylor series'), name_t('exact', 'closed solution')]

   !> Attitude errors in the table, rad.
   real(wp), parameter :: tolerances(4) = [1e-4_wp, 1e-6_wp, 1e-8_wp, 1e-10_wp]
   !> Energy errors up to this are round-off, even in the longest runs.
   real(wp), parameter :: conserved_error = 1e-11_wp

   character(len=*), parameter :: header = 'method,order,formulation,time_step,steps,subdivided_steps,samples,'// &
                                           'wall_time,ns_per_step,iterations,attitude_error,reference_error,'// &
                                           'momentum_error,energy_error,norm_error'

   !> CSV file that is being written.
   type :: cost_csv_t
      type(output_file_t) :: file
      logical :: on_standard_output = .false.
   contains
      !> Claims the file.
      procedure :: open
      !> Writes the runs and gives the file its name.
      procedure :: write
   end type cost_csv_t

contains

   !> Returns a row of `methods` in a few words: `nielsen_krenk order 6 (reduced)`, `dop853+conserve`.
   pure function method_label(method) result(label)
      !> Row of `methods`.
      integer, intent(in) :: method
      character(len=:), allocatable :: label
      label = trim(family_of(methods(method)))
      if (has_relatives(method)) label = label//' order '//count_text(methods(method)%order)
      if (methods(method)%formulation /= '') label = label//' ('//trim(methods(method)%formulation)//')'
   end function method_label

   !> Returns the full name of a row of `methods`, for pictures: `Nielsen-Krenk, order 8, reduced`.
   pure function full_label(method) result(label)
      !> Row of `methods`.
      integer, intent(in) :: method
      character(len=:), allocatable :: label
      integer :: i
      associate (row => methods(method))
         label = trim(row%name)
         do i = 1, size(names)
            if (names(i)%name == row%name) label = trim(names(i)%words)
         end do
         if (has_relatives(method)) label = label//', order '//count_text(row%order)
         if (row%formulation /= '') label = label//', '//trim(row%formulation)
         if (row%projected) label = label//', projected'
      end associate
   end function full_label

   !> Returns true if other rows of `methods` differ from this one in order or solver only.
   pure logical function has_relatives(method)
      !> Row of `methods`.
      integer, intent(in) :: method
      has_relatives = count(family_of(methods) == family_of(methods(method))) > 1
   end function has_relatives

   !> Adds the table of costs.
   subroutine add_answer(page, study)
      type(page_t), intent(inout) :: page
      type(work_precision_t), intent(in) :: study
      type(table_t) :: table
      integer :: i
      if (.not. study%reference%known()) return
      call table%add_column('accuracy', '/ rad', digits=2)
      call table%add_column('time', '/ ms', digits=2)
      call table%add_column('energy', digits=1)
      call table%add_column()
      call table%add_column('&integrator, cheapest first', &
                            '*: cheapest that conserves the invariants; auto: chosen by auto')
      do i = 1, size(tolerances)
         call add_ranking(table, study, tolerances(i))
      end do
      call page%line('')
      call page%line(table%text())
   end subroutine add_answer

   !> Adds the cost of one accuracy with each method, cheapest first.
   subroutine add_ranking(table, study, tolerance)
      type(table_t), intent(inout) :: table
      type(work_precision_t), intent(in) :: study
      !> Attitude error, rad.
      real(wp), intent(in) :: tolerance
      type(work_point_t) :: points(size(methods))
      real(wp) :: seconds(size(methods))
      logical :: marked
      integer :: m, i, auto

      call table%add_row()
      call table%put(tolerance)
      auto = automatic_row(study, tolerance)
      points = competitors(study, tolerance, auto)
      seconds = huge(1.0_wp)
      where (points%method > 0) seconds = points%seconds
      marked = .false.
      do i = 1, count(points%method > 0)
         m = minloc(seconds, dim=1)
         seconds(m) = huge(1.0_wp)
         if (i > 1) then
            call table%add_row()
            call table%put('')
         end if
         call add_point(table, points(m), .not. marked .and. keeps_invariants(points(m)), m == auto, tolerance)
         marked = marked .or. keeps_invariants(points(m))
      end do
      if (all(points%method == 0)) then
         call table%put('-')
         call table%put('-')
         call table%put('')
         call table%put('not reached by any run')
      else if (auto > 0) then
         if (points(auto)%method > 0) return
         call table%add_row()
         call table%put('')
         call table%put('-')
         call table%put('-')
         call table%put(' auto')
         if (study%ending(auto) == OUT_OF_BUDGET) then
            call table%put(method_text(auto)//', not measured within the budget')
         else
            call table%put(method_text(auto)//', which does not reach it')
         end if
      end if
   end subroutine add_ranking

   !> Adds the time of a point, and the settings to write into the scene for it.
   subroutine add_point(table, point, is_best, is_automatic, tolerance)
      type(table_t), intent(inout) :: table
      type(work_point_t), intent(in) :: point
      !> True for the cheapest point that conserves the invariants; true for the point that `auto` uses.
      logical, intent(in) :: is_best, is_automatic
      !> Attitude error, rad.
      real(wp), intent(in) :: tolerance
      call table%put(1e3_wp*point%seconds)
      call table%put(point%energy_error)
      call table%put(merge('*', ' ', is_best)//merge('auto', '    ', is_automatic))
      if (methods(point%method)%order < 1) then
         call table%put(method_text(point%method)//', accuracy='//number_text(tolerance, 2))
      else if (point%tolerance > 0.0_wp) then
         call table%put(method_text(point%method)//', local_tolerance='//number_text(point%tolerance, 2))
      else
         call table%put(method_text(point%method)//', time_step='//number_text(shorter(point%time_step), 3))
      end if
   end subroutine add_point

   !> Returns a step rounded to three digits, towards zero: a longer one could miss the accuracy.
   pure real(wp) function shorter(step)
      real(wp), intent(in) :: step
      real(wp) :: unit
      unit = 10.0_wp**(floor(log10(abs(step))) - 2)
      shorter = sign(unit*floor(abs(step)/unit*(1 + 4*epsilon(unit))), step)
   end function shorter

   !> Returns the points that compete at an accuracy: the cheapest of each family of methods, and the point of the row
   !> that `auto` uses; no point in the other elements. Shape (rows of `methods`).
   function competitors(study, tolerance, auto) result(points)
      type(work_precision_t), intent(in) :: study
      !> Attitude error, rad.
      real(wp), intent(in) :: tolerance
      !> Row of `methods` that `auto` uses, or 0.
      integer, intent(in) :: auto
      type(work_point_t) :: points(size(methods)), all_points(size(methods))
      integer :: m
      logical :: of_family(size(methods))
      if (tolerance < study%reference%uncertainty) return
      do m = 1, size(methods)
         all_points(m) = point_within(study%points_of(m), tolerance)
      end do
      do m = 1, size(methods)
         of_family = family_of(methods) == family_of(methods(m)) .and. all_points%method > 0
         if (m == auto) then
            points(m) = all_points(m)
         else if (of_family(m)) then
            if (m == minloc(all_points%seconds, mask=of_family, dim=1)) points(m) = all_points(m)
         end if
      end do
   end function competitors

   !> Returns the row of `methods` that `auto` uses for an accuracy; 0 if it uses another method.
   integer function automatic_row(study, tolerance) result(row)
      type(work_precision_t), intent(in) :: study
      !> Attitude error, rad.
      real(wp), intent(in) :: tolerance
      type(integrator_settings_t) :: settings
      character(len=:), allocatable :: reason
      settings = study%problem%settings
      associate (problem => study%problem)
         call choose_method(problem%system, problem%start, problem%duration(), tolerance, settings, reason)
      end associate
      do row = size(methods), 1, -1
         associate (method => methods(row))
            if (method%name /= settings%method .or. (method%projected .neqv. settings%conserve)) cycle
            if (method%formulation == '') exit
            if (method%formulation == settings%formulation .and. method%order == settings%order) exit
         end associate
      end do
   end function automatic_row

   !> Returns true if a point conserves energy and momentum to round-off.
   pure logical function keeps_invariants(point)
      !> Point that exists.
      type(work_point_t), intent(in) :: point
      keeps_invariants = methods(point%method)%conserving .and. point%energy_error <= conserved_error
   end function keeps_invariants

   !> Returns the settings to write into `&integrator` for a method.
   pure function method_text(row) result(text)
      !> Row of `methods`.
      integer, intent(in) :: row
      character(len=:), allocatable :: text
      type(integrator_settings_t) :: usual
      associate (method => methods(row))
         usual = default_settings(trim(method%name))
         text = 'method='//"'"//trim(method%name)//"'"
         if (usual%order /= method%order) text = text//', order='//count_text(method%order)
         if (usual%formulation /= method%formulation) &
            text = text//', formulation='//"'"//trim(method%formulation)//"'"
         if (usual%conserve .neqv. method%projected) &
            text = text//', conserve='//trim(merge('.true. ', '.false.', method%projected))
      end associate
   end function method_text

   !> Adds the reference of the errors.
   subroutine add_reference(page, study)
      type(page_t), intent(inout) :: page
      type(work_precision_t), intent(in) :: study
      character(len=:), allocatable :: known
      associate (reference => study%reference, end_time => study%problem%end_time)
         known = ' to '//number_text(reference%uncertainty, 2)//' rad'
         select case (reference%kind)
         case (EXACT_FREE_BODY)
            call page%item('reference', 'the exact motion of a free body, good'//known)
         case (EXACT_TOP)
            call page%item('reference', "the exact motion of Lagrange's top, good"//known)
         case (AGREED)
            call page%item('reference', method_label(reference%pair(1))//' and '//method_label(reference%pair(2)))
            call page%item('', 'agree'//known//': '// &
                           count_text(int(-log10(reference%uncertainty), long))//' digits')
         case default
            call page%item('reference', 'none: '//method_label(reference%pair(1))//' and '// &
                           method_label(reference%pair(2)))
            if (reference%uncertainty < huge(1.0_wp)) then
               known = 'agree only'//known//' at t = '//rounded_text(end_time)//' s'
            else
               known = 'do not reach t = '//rounded_text(end_time)//' s within the budget'
            end if
            call page%item('', known//'; attitude errors are not shown')
         end select
      end associate
   end subroutine add_reference

   !> Adds all runs, method by method.
   subroutine add_table(page, study)
      type(page_t), intent(inout) :: page
      type(work_precision_t), intent(in) :: study
      type(work_point_t), allocatable :: points(:)
      type(table_t) :: table
      integer :: m, components
      real(wp) :: axis(3)

      call conserved_momentum(study%problem%system%effects, components, axis)
      call table%add_column('time_step', '/ s', digits=5)
      call table%add_column('steps', digits=1)
      call table%add_column('subdivided', digits=1)
      call table%add_column('time', '/ ms', digits=3)
      call table%add_column('step', '/ ns', digits=3)
      call table%add_column('Newton', digits=3)
      call table%add_column('attitude', '/ rad', digits=2)
      call table%add_column('momentum', digits=2)
      call table%add_column('energy', digits=2)
      call table%add_column('norm', digits=2)
      do m = 1, size(methods)
         points = study%points_of(m)
         if (methods(m)%order < 1 .and. size(points) == 0) cycle
         call table%add_line(method_label(m)//ending_text(study, m, size(points)))
         call add_points(table, points, study%reference, components /= NO_COMPONENT)
      end do
      call page%line('')
      call page%line(table%text())
   end subroutine add_table

   !> Returns the reason, in words, why there are no further runs of a method.
   function ending_text(study, method, runs) result(text)
      type(work_precision_t), intent(in) :: study
      !> Row of `methods`, and the number of its runs.
      integer, intent(in) :: method, runs
      character(len=:), allocatable :: text
      if (methods(method)%order < 1) then
         text = ', the closed solution'
         return
      end if
      select case (study%ending(method))
      case (ROUND_OFF)
         text = ', until shorter steps gain nothing'
      case (OUT_OF_BUDGET)
         text = ', as far as the budget allows'
      case (LAST_LEVEL)
         text = ', down to the shortest step tried'
      case (REFUSED)
         text = ': not applicable to this scene ('//trim(study%refusal(method)%message)//')'
      case default
         text = ', until the study was stopped'
      end select
      if (runs > 0 .or. study%ending(method) == REFUSED) return
      text = ': no run finished within the budget'
      if (.not. study%refusal(method)%ok()) text = ': no run finished ('//trim(study%refusal(method)%message)//')'
   end function ending_text

   !> Adds the runs of one method; of the runs with hopelessly long steps, only the last.
   subroutine add_points(table, points, reference, has_momentum)
      type(table_t), intent(inout) :: table
      type(work_point_t), intent(in) :: points(:)
      type(reference_t), intent(in) :: reference
      !> True if a component of the momentum is conserved.
      logical, intent(in) :: has_momentum
      integer :: i
      do i = 1, size(points)
         if (reference%known() .and. i < size(points)) then
            if (points(i)%attitude_error > hopeless .and. points(i + 1)%attitude_error > hopeless) cycle
         end if
         call add_run(table, points(i), reference, has_momentum)
      end do
   end subroutine add_points

   !> Adds the row of a run.
   subroutine add_run(table, point, reference, has_momentum)
      type(table_t), intent(inout) :: table
      type(work_point_t), intent(in) :: point
      type(reference_t), intent(in) :: reference
      logical, intent(in) :: has_momentum
      call table%add_row()
      call table%put(point%time_step)
      call table%put(count_text(point%steps))
      if (point%subdivided_steps > 0) then
         call table%put(count_text(point%subdivided_steps))
      else
         call table%put('')
      end if
      call table%put(1e3_wp*point%seconds)
      call table%put(point%nanoseconds())
      call table%put(point%iterations)
      if (.not. reference%known()) then
         call table%put('-')
      else if (point%attitude_error < reference%uncertainty) then
         call table%put(reference%uncertainty, before='<')
      else
         call table%put(point%attitude_error)
      end if
      if (has_momentum) then
         call table%put(point%momentum_error)
      else
         call table%put('-')
      end if
      call table%put(point%energy_error)
      call table%put(point%norm_error)
   end subroutine add_run

   !> Claims the file. Errors: `NUTATE_IO`.
   subroutine open(self, name, status)
      class(cost_csv_t), intent(inout) :: self
      !> Path, or `-` for standard output.
      character(len=*), intent(in) :: name
      type(status_t), intent(out) :: status
      self%on_standard_output = name == '-' .or. name == '/dev/stdout' .or. name == '/dev/fd/1'
      call self%file%open(name, status)
   end subroutine open

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
      if (status%ok() .and. .not. complete) then
         call self%file%abandon(status)
      else
         call close_file(self%file, status)
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
         line = trim(family_of(method))//','//count_text(method%order)//','//trim(method%formulation)
      end associate
      line = line//field(decimal, point%time_step)//','//count_text(point%steps)//','// &
             count_text(point%subdivided_steps)//','//count_text(point%samples)// &
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

end module nutate_cost_report
