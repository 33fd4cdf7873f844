!> Result of a work-precision study: a table of the cost of some accuracies, with the settings for the scene.
module nutate_cost_answer
   use nutate_console, only: count_text, page_t
   use nutate_kinds, only: wp, long
   use nutate_method_choice, only: choose_method
   use nutate_methods, only: default_settings, family_of, methods
   use nutate_stepper, only: integrator_settings_t
   use nutate_table, only: number_text, table_t
   use nutate_work_point, only: point_within, work_point_t
   use nutate_work_precision, only: work_precision_t, OUT_OF_BUDGET
   implicit none
   private

   public :: add_answer

   !> Attitude errors in the table, rad.
   real(wp), parameter :: tolerances(4) = [1e-4_wp, 1e-6_wp, 1e-8_wp, 1e-10_wp]
   !> Energy errors up to this are round-off, even in the longest runs.
   real(wp), parameter :: round_off = 1e-11_wp

contains

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
                            '*: cheapest that keeps the invariants; auto: chosen by auto')
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
      keeps_invariants = methods(point%method)%conserving .and. point%energy_error <= round_off
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
         if (usual%order /= method%order) text = text//', order='//count_text(int(method%order, long))
         if (usual%formulation /= method%formulation) &
            text = text//', formulation='//"'"//trim(method%formulation)//"'"
         if (usual%conserve .neqv. method%projected) &
            text = text//', conserve='//trim(merge('.true. ', '.false.', method%projected))
      end associate
   end function method_text

end module nutate_cost_answer
