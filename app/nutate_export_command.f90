!> `nutate export HISTORY.csv`: writes a history for other programs, as AEM or glTF.
module nutate_export_command
   use nutate_aem_writing, only: aem_fault, write_aem
   use nutate_attitude_rows, only: attitude_rows_t, is_unit, put_in_order, to_inertial_axes
   use nutate_cli, only: command_t, naming_options
   use nutate_console, only: count_text, report_file, say_error, EXIT_INPUT, EXIT_SUCCESS
   use nutate_export_facts, only: export_facts_t, facts_of_scene, parse_facts
   use nutate_gltf_writing, only: gltf_fault, write_gltf
   use nutate_history_plot, only: name_length, read_history, read_names, recorded_t
   use nutate_kinds, only: wp
   use nutate_outputs, only: outputs_t, AEM, GLTF
   use nutate_printable, only: printable_path, quoted
   use nutate_quaternion, only: quat_normalized
   use nutate_resampling, only: resample
   use nutate_scene, only: scene_t, read_scene
   use nutate_status, only: status_t
   use nutate_table_units, only: conversion, split_header, units_of
   implicit none
   private

   public :: export_command

   !> Columns that are exported, the rates by two names, and their units without one in the header.
   character(len=10), parameter :: exported(10) = [character(len=10) :: 'q0', 'q1', 'q2', 'q3', 'omega1', 'omega2', &
                                                   'omega3', 'omega1_deg', 'omega2_deg', 'omega3_deg']
   character(len=5), parameter :: units(10) = [character(len=5) :: '', '', '', '', 'rad/s', 'rad/s', 'rad/s', &
                                               'deg/s', 'deg/s', 'deg/s']
   !> Tolerance of the norm of quaternions whose digits were rounded.
   real(wp), parameter :: norm_tolerance = 1e-2_wp

contains

   !> Writes a history for other programs.
   subroutine export_command(command, exit_code)
      type(command_t), intent(in) :: command
      integer, intent(out) :: exit_code
      type(export_facts_t) :: facts
      type(attitude_rows_t) :: rows, chosen
      type(outputs_t) :: files
      character(len=:), allocatable :: problem

      exit_code = EXIT_SUCCESS
      call read_facts()
      if (problem == '') call check_names()
      if (exit_code /= EXIT_SUCCESS) return
      if (problem == '') call read_rows(command%scene, rows, problem)
      if (problem == '') then
         call to_inertial_axes(rows, facts%effects)
         call put_in_order(rows)
         rows%labels = facts%labels
         if (rows%labels%object == '') rows%labels%object = stem(command%scene)
         facts%labels = rows%labels
         if (command%error_between > 0.0_wp) then
            call resample(rows, command%error_between, chosen, problem)
            if (problem == '') rows = chosen
         end if
         if (problem == '' .and. allocated(command%aem)) problem = aem_fault(rows)
         if (problem == '' .and. allocated(command%gltf)) problem = gltf_fault(command%gltf, rows, facts)
         if (problem /= '') problem = 'nutate: '//printable_path(command%scene)//': '//problem
      end if
      if (problem /= '') then
         call say_error(problem, exit_code, EXIT_INPUT)
         return
      end if
      call write_files()

   contains

      !> Writes the requested files.
      subroutine write_files()
         type(status_t) :: status
         if (allocated(command%aem)) then
            call write_aem(command%aem, rows, command%aem_version, status, command%error_between)
            call report_file(command%aem, status, exit_code)
         end if
         if (allocated(command%gltf) .and. exit_code == EXIT_SUCCESS) then
            call write_gltf(command%gltf, rows, facts, command%speed, status)
            call report_file(command%gltf, status, exit_code)
         end if
      end subroutine write_files

      !> Reads the facts that the history lacks: from a scene with the overrides, or from the overrides alone.
      subroutine read_facts()
         type(scene_t) :: scene
         type(status_t) :: status
         if (allocated(command%of_scene)) then
            call read_scene(command%of_scene, scene, status, problem, command%overrides)
            if (status%ok()) facts = facts_of_scene(scene)
            if (status%ok()) call files%read_scene(scene)
         else
            call parse_facts('', command%scene, command%overrides, facts, status, problem)
         end if
         problem = naming_options(problem)
      end subroutine read_facts

      !> Rejects file names that would overwrite an input, a file of another kind or each other.
      subroutine check_names()
         call files%read_file(command%scene, 'the history itself')
         if (allocated(command%aem)) call files%add(command%aem, AEM)
         if (allocated(command%gltf)) call files%add(command%gltf, GLTF)
         call files%report(exit_code)
      end subroutine check_names

   end subroutine export_command

   !> Reads attitudes and angular velocities of a history.
   subroutine read_rows(path, rows, problem)
      character(len=*), intent(in) :: path
      type(attitude_rows_t), intent(inout) :: rows
      !> Error message, one printable line; empty on success.
      character(len=:), allocatable, intent(out) :: problem
      type(recorded_t) :: history
      character(len=name_length), allocatable :: names(:)
      character(len=name_length) :: headers(7)
      real(wp) :: factors(7)
      integer :: i
      call read_names(path, names, problem)
      if (problem /= '') return
      call find_columns(headers, factors)
      if (problem /= '') problem = printable_path(path)//':1: '//problem
      if (problem /= '') return
      call read_history(path, headers, history, problem)
      if (problem /= '') return
      rows%t = history%values(:, 1)
      rows%q = columns_of(history, headers(:4), factors(:4))
      if (all(headers /= '')) rows%omega = columns_of(history, headers(5:), factors(5:))
      call check_rows()
      if (problem /= '') return
      do i = 1, rows%count()
         rows%q(:, i) = quat_normalized(rows%q(:, i))
      end do

   contains

      !> Finds the columns of attitudes and rates by their names, behind which a unit may be in brackets.
      subroutine find_columns(headers, factors)
         !> Headers of q0 to q3 and of the three rates; empty for rates that there are not.
         character(len=name_length), intent(out) :: headers(7)
         !> Their units, SI.
         real(wp), intent(out) :: factors(7)
         character(len=:), allocatable :: name, unit
         integer :: i, k, at
         headers = ''
         factors = 1.0_wp
         do i = 1, size(names)
            call split_header(names(i), name, unit)
            at = findloc(exported == name, .true., dim=1)
            if (at == 0) cycle
            k = merge(at, at - 3, at <= 7)
            if (unit == '') unit = trim(units(at))
            if (headers(k) /= '') then
               problem = 'there are two columns '//quoted(trim(exported(k)))//' (expected one)'
            else if (k <= 4 .and. unit /= '') then
               problem = quoted(trim(names(i)))//' has a unit (expected none)'
            else if (k > 4) then
               factors(k) = conversion(unit, 'rad/s')
               if (.not. factors(k) > 0.0_wp) problem = quoted(trim(names(i)))//' has an unknown unit (expected '// &
                                                        units_of('rad/s')//')'
            end if
            if (problem /= '') return
            headers(k) = names(i)
         end do
         k = findloc(headers(:4) == '', .true., dim=1)
         if (k > 0) problem = 'there is no column '//trim(exported(k))//" (expected output.columns with 'quaternion')"
      end subroutine find_columns

      !> Finds the first row that is out of order in time, or has no valid attitude or angular velocity.
      subroutine check_rows()
         real(wp), parameter :: greatest = 1e100_wp
         real(wp) :: sense
         integer :: i
         sense = 1.0_wp
         if (rows%count() > 1) sense = merge(1.0_wp, -1.0_wp, rows%t(rows%count()) >= rows%t(1))
         do i = 1, rows%count()
            if (.not. is_unit(rows%q(:, i), norm_tolerance)) then
               problem = 'the quaternion is not of unit norm (expected q0, q1, q2, q3 of a run)'
            else if (.not. abs(rows%t(i)) < greatest) then
               problem = 't is too large (expected up to 1e100 s)'
            else if (allocated(rows%omega)) then
               if (.not. all(abs(rows%omega(:, i)) < greatest)) &
                  problem = 'an angular velocity is too large (expected up to 1e100 rad/s)'
            end if
            if (i > 1 .and. problem == '') then
               if (sense*(rows%t(i) - rows%t(i - 1)) <= 0.0_wp) &
                  problem = 't is out of order (expected rows in the order of the run)'
            end if
            if (problem == '') cycle
            problem = printable_path(path)//':'//count_text(i + 1)//': '//problem
            return
         end do
      end subroutine check_rows

   end subroutine read_rows

   !> Returns columns as rows of a matrix, SI.
   pure function columns_of(history, headers, factors) result(values)
      type(recorded_t), intent(in) :: history
      !> Headers of existing columns, and their units.
      character(len=*), intent(in) :: headers(:)
      real(wp), intent(in) :: factors(:)
      real(wp), allocatable :: values(:, :)
      integer :: i
      allocate (values(size(headers), size(history%values, 1)))
      do i = 1, size(headers)
         values(i, :) = factors(i)*history%values(:, findloc(history%names == headers(i), .true., dim=1))
      end do
   end function columns_of

   !> Returns a file name without folder and ending.
   pure function stem(path) result(name)
      character(len=*), intent(in) :: path
      character(len=:), allocatable :: name
      integer :: dot, i
      name = path(index(path, '/', back=.true.) + 1:)
      dot = index(name, '.', back=.true.)
      if (dot > 1) name = name(:dot - 1)
      do i = 1, len(name)
         if (iachar(name(i:i)) < 33 .or. iachar(name(i:i)) > 126) name(i:i) = '_'
      end do
   end function stem

end module nutate_export_command
