!> Attitudes and angular velocities of an Attitude Ephemeris Message (CCSDS 504.0-B) at times and in axes of a scene: as
!> measurements, or as those of a frame.
module nutate_measured_message
   use nutate_aem_keywords, only: equatorial, from_ecliptic, is_ecliptic, is_inertial, is_rotating, standard_frame
   use nutate_aem_reading, only: parse_aem
   use nutate_attitude_rows, only: attitude_rows_t
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp, pi
   use nutate_printable, only: printable_path, quoted
   use nutate_quaternion, only: quat_conjugate, quat_product
   use nutate_scene_labels, only: labels_t
   use nutate_spelling, only: lower_case
   implicit none
   private

   public :: is_message, read_message, read_records

   real(wp), parameter :: degree = pi/180

contains

   !> Returns true for the text of a message rather than a table.
   pure logical function is_message(text)
      character(len=*), intent(in) :: text
      is_message = index(text, 'CCSDS_AEM_VERS') > 0
   end function is_message

   !> Reads the columns q0 to q3, and omega1 to omega3 with or without `_deg`, at times of the scene.
   subroutine read_message(text, path, labels, effects, columns, times, rows, problem, has_place)
      character(len=*), intent(in) :: text, path
      !> Labels of the scene.
      type(labels_t), intent(in) :: labels
      !> Effects of the scene, which give its space axes.
      type(effect_list_t), intent(in) :: effects
      character(len=*), intent(in) :: columns(:)
      !> Times, s past the epoch of the scene, shape (n); values, shape (columns, n).
      real(wp), allocatable, intent(out) :: times(:), rows(:, :)
      !> Error message; empty on success.
      character(len=:), allocatable, intent(out) :: problem
      !> The error message begins with file and line.
      logical, intent(out) :: has_place
      type(attitude_rows_t) :: read
      integer :: i
      call read_records(text, path, labels, effects, read, problem, has_place)
      if (problem /= '') return
      if (labels%body_frame /= '' .and. lower_case(labels%body_frame) /= lower_case(read%labels%body_frame)) &
         problem = 'REF_FRAME_B of '//printable_path(path)//' is '//quoted(read%labels%body_frame)// &
                   ', not the body_frame of &scene (expected '//quoted(labels%body_frame)//')'
      if (problem /= '') return
      times = read%t
      allocate (rows(size(columns), read%count()))
      do i = 1, size(columns)
         call find_column(read, trim(columns(i)), rows(i, :), problem)
         if (problem == '') cycle
         problem = printable_path(path)//' has no column '//quoted(trim(columns(i)))//problem
         return
      end do
   end subroutine read_message

   !> Reads the records of a message, whatever body they are of: times past the epoch of the scene, attitudes in its
   !> space axes.
   subroutine read_records(text, path, labels, effects, read, problem, has_place)
      character(len=*), intent(in) :: text, path
      !> Labels of the scene.
      type(labels_t), intent(in) :: labels
      !> Effects of the scene, which give its space axes.
      type(effect_list_t), intent(in) :: effects
      type(attitude_rows_t), intent(out) :: read
      !> Error message; empty on success.
      character(len=:), allocatable, intent(out) :: problem
      !> The error message begins with file and line.
      logical, intent(out) :: has_place
      integer :: i
      call parse_aem(text, path, read, problem)
      has_place = problem /= ''
      if (problem == '') call check_labels(labels, read%labels, effects, printable_path(path), problem)
      if (problem /= '') return
      if (is_ecliptic(labels%space_frame)) then
         do i = 1, read%count()
            read%q(:, i) = quat_product(quat_conjugate(from_ecliptic()), read%q(:, i))
         end do
      end if
      read%t = read%t + past(labels, read%labels)
   end subroutine read_records

   !> Returns the seconds from the epoch of the scene to that of a message.
   pure real(wp) function past(scene, message)
      type(labels_t), intent(in) :: scene, message
      if (scene%epoch%system == message%epoch%system) then
         past = message%epoch%since(scene%epoch)
      else
         past = message%epoch%tdb() - scene%epoch%tdb()
      end if
   end function past

   !> Reports why the records of a message cannot be used in the scene.
   pure subroutine check_labels(scene, message, effects, path, problem)
      type(labels_t), intent(in) :: scene, message
      type(effect_list_t), intent(in) :: effects
      character(len=*), intent(in) :: path
      character(len=:), allocatable, intent(inout) :: problem
      character(len=:), allocatable :: frame
      frame = scene%space_frame
      if (is_ecliptic(frame)) frame = equatorial
      if (.not. scene%epoch%is_set()) then
         problem = 'the records of '//path//' have dates, t = 0 of the scene has none (expected epoch and '// &
                   'time_system of &scene)'
      else if (frame /= '' .and. &
               lower_case(standard_frame(frame)) /= lower_case(standard_frame(message%space_frame))) then
         problem = 'REF_FRAME_A of '//path//' is '//quoted(message%space_frame)//', not the space_frame of &scene'// &
                   ' (expected '//quoted(frame)//')'
      else if (.not. effects%knows_space_axes()) then
         if (is_inertial(message%space_frame)) problem = 'the space axes rotate, and REF_FRAME_A of '//path//', '// &
            quoted(message%space_frame)//', names inertial axes (expected attitudes relative to the rotating axes)'
      else if (effects%on_orbit .and. is_rotating(message%space_frame)) then
         problem = 'REF_FRAME_A of '//path//', '//quoted(message%space_frame)// &
                   ', names axes that rotate (expected attitudes in inertial axes)'
      end if
   end subroutine check_labels

   !> Copies a column of a message.
   pure subroutine find_column(read, name, values, problem)
      type(attitude_rows_t), intent(in) :: read
      character(len=*), intent(in) :: name
      !> Shape (n).
      real(wp), intent(inout) :: values(:)
      !> Error message with the available columns; empty on success.
      character(len=:), allocatable, intent(out) :: problem
      problem = ''
      select case (name)
      case ('q0', 'q1', 'q2', 'q3')
         values = read%q(index('0123', name(2:2)), :)
      case ('omega1', 'omega2', 'omega3', 'omega1_deg', 'omega2_deg', 'omega3_deg')
         if (.not. allocated(read%omega)) then
            problem = ' (expected q0 to q3: its records have no angular velocities)'
            return
         end if
         values = read%omega(index('123', name(6:6)), :)
         if (len(name) > 6) values = values/degree
      case default
         problem = ' (expected q0 to q3, or omega1 to omega3)'
      end select
   end subroutine find_column

end module nutate_measured_message
