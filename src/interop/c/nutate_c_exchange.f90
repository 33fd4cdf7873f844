!> C interface: calendar time, and attitudes for other programs. The functions are documented in
!> `include/nutate_exchange.h`.
module nutate_c_exchange
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_int, c_loc, c_ptr, c_size_t
   use nutate_aem_reading, only: read_aem
   use nutate_aem_writing, only: aem_versions, write_aem
   use nutate_attitude_rows, only: attitude_rows_t, is_unit
   use nutate_c_handles, only: found, history_handle_t, system_handle_t, HISTORY_MARK
   use nutate_c_scene_handle, only: found, null_argument, open_slot, report, scene_handle_t
   use nutate_c_text, only: copy_text, lock_texts, message_to_c, text_to_c, unlock_texts
   use nutate_epoch, only: epoch_t, read_epoch, time_systems
   use nutate_export_facts, only: export_facts_t, parse_facts
   use nutate_gltf_writing, only: write_gltf
   use nutate_kinds, only: wp
   use nutate_limits, only: attitude_tolerance, is_moderate, most_rows
   use nutate_scene_labels, only: label_keys, label_of
   use nutate_spelling, only: escaped, is_listed
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_SCENE, NUTATE_IO, NUTATE_NO_MEMORY, &
      NUTATE_OK
   implicit none
   private

   public :: nutate_scene_get, nutate_date, nutate_tdb, nutate_system_frame_rate, nutate_system_space_axes, &
      nutate_write_aem, nutate_write_gltf, nutate_read_aem

contains

   integer(c_int) function nutate_scene_get(scene, key, buffer, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: scene, key, buffer
      integer(c_size_t), intent(in), value :: size
      type(scene_handle_t), pointer :: handle
      character(len=:), allocatable :: name, value
      if (.not. found(scene, handle, code)) return
      call copy_text(key, name)
      if (name == 'title') then
         code = text_to_c(handle%scene%title, buffer, size)
         return
      end if
      call label_of(handle%scene%labels, name, value)
      code = NUTATE_BAD_ARGUMENT
      if (allocated(value)) code = text_to_c(value, buffer, size)
   end function nutate_scene_get

   integer(c_int) function nutate_date(epoch, time_system, t, buffer, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: epoch, time_system, buffer
      real(c_double), intent(in), value :: t
      integer(c_size_t), intent(in), value :: size
      type(epoch_t) :: first, later
      code = NUTATE_BAD_ARGUMENT
      call read_instant(epoch, time_system, first)
      if (.not. first%is_set()) return
      later = first%after(t)
      if (later%is_set()) code = text_to_c(later%text(), buffer, size)
   end function nutate_date

   integer(c_int) function nutate_tdb(epoch, time_system, n, t, tdb) result(code) bind(C)
      type(c_ptr), intent(in), value :: epoch, time_system
      integer(c_size_t), intent(in), value :: n
      real(c_double), intent(in), optional :: t(*)
      real(c_double), intent(inout), optional :: tdb(*)
      type(epoch_t) :: first, later
      integer(c_size_t) :: i
      code = NUTATE_BAD_ARGUMENT
      if (.not. (present(t) .and. present(tdb)) .or. n < 0) return
      call read_instant(epoch, time_system, first)
      if (.not. first%is_set()) return
      do i = 1, n
         later = first%after(t(i))
         if (.not. later%is_set()) return
      end do
      do i = 1, n
         later = first%after(t(i))
         tdb(i) = later%tdb()
      end do
      code = NUTATE_OK
   end function nutate_tdb

   integer(c_int) function nutate_system_frame_rate(system, rate) result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(inout), optional :: rate(3)
      type(system_handle_t), pointer :: handle
      if (.not. found(system, handle, code)) return
      code = NUTATE_BAD_ARGUMENT
      if (.not. present(rate)) return
      rate = handle%system%effects%frame_rate
      code = NUTATE_OK
   end function nutate_system_frame_rate

   integer(c_int) function nutate_system_space_axes(system, n, t, q) result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      integer(c_size_t), intent(in), value :: n
      real(c_double), intent(in), optional :: t(*)
      real(c_double), intent(inout), optional :: q(*)
      type(system_handle_t), pointer :: handle
      integer(c_size_t) :: i
      if (.not. found(system, handle, code)) return
      code = NUTATE_BAD_ARGUMENT
      if (.not. (present(t) .and. present(q) .and. n >= 0 .and. handle%system%effects%knows_space_axes())) return
      do i = 1, n
         if (.not. is_moderate(t(i))) return
      end do
      do i = 1, n
         q(4*i - 3:4*i) = handle%system%effects%space_axes(t(i))
      end do
      code = NUTATE_OK
   end function nutate_system_space_axes

   integer(c_int) function nutate_write_aem(path, facts, n, t, q, omega, version, error, message, size) result(code) &
      bind(C)
      type(c_ptr), intent(in), value :: path, facts, version, message
      integer(c_size_t), intent(in), value :: n, size
      real(c_double), intent(in), optional :: t(*), q(*), omega(*)
      real(c_double), intent(in), value :: error
      type(attitude_rows_t) :: rows
      type(export_facts_t) :: known
      type(status_t) :: status
      character(len=:), allocatable :: name, text, problem
      text = '2.0'
      if (c_associated(version)) call copy_text(version, text)
      call take_facts(path, facts, name, known, problem, status)
      if (status%ok()) call take_rows(n, t, q, omega, rows, status)
      if (status%ok() .and. .not. is_listed(text, aem_versions)) &
         status = fail(NUTATE_BAD_ARGUMENT, 'this version of AEM is not available (expected 2.0 or 1.0)', 'version')
      if (status%ok() .and. .not. (is_moderate(error) .and. .not. is_below(error, 0.0_wp))) &
         status = fail(NUTATE_BAD_ARGUMENT, 'error is out of its range (expected 0 or more)', 'error')
      if (status%ok()) then
         rows%labels = known%labels
         call lock_texts()
         call write_aem(name, rows, text, status, error)
         call unlock_texts()
      end if
      code = say(problem, status, message, size)
   end function nutate_write_aem

   integer(c_int) function nutate_write_gltf(path, facts, n, t, q, speed, message, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: path, facts, message
      integer(c_size_t), intent(in), value :: n, size
      real(c_double), intent(in), optional :: t(*), q(*)
      real(c_double), intent(in), value :: speed
      type(attitude_rows_t) :: rows
      type(export_facts_t) :: known
      type(status_t) :: status
      character(len=:), allocatable :: name, problem
      call take_facts(path, facts, name, known, problem, status)
      if (status%ok()) call take_rows(n, t, q, rows=rows, status=status)
      if (status%ok() .and. (.not. is_moderate(speed) .or. is_below(speed, 1e-9_wp) .or. is_below(1e12_wp, speed))) &
         status = fail(NUTATE_BAD_ARGUMENT, 'speed is out of its range (expected 1e-9 to 1e12)', 'speed')
      if (status%ok()) then
         call lock_texts()
         call write_gltf(name, rows, known, speed, status)
         call unlock_texts()
      end if
      code = say(problem, status, message, size)
   end function nutate_write_gltf

   integer(c_int) function nutate_read_aem(path, history, facts, facts_size, message, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: path, history, facts, message
      integer(c_size_t), intent(in), value :: facts_size, size
      type(c_ptr), pointer :: slot
      type(history_handle_t), pointer :: handle
      type(attitude_rows_t) :: rows
      type(status_t) :: status
      character(len=:), allocatable :: name, problem
      integer :: failed
      problem = ''
      slot => open_slot(history)
      if (.not. associated(slot)) status = null_argument('history')
      if (.not. c_associated(path)) status = null_argument('path')
      if (status%ok()) then
         call copy_text(path, name)
         call lock_texts()
         call read_aem(name, rows, problem)
         call unlock_texts()
         if (problem /= '') status = fail(NUTATE_BAD_SCENE, '')
         if (index(problem, ': cannot be read') > 0) status = fail(NUTATE_IO, '')
      end if
      if (status%ok()) then
         allocate (handle, stat=failed)
         if (failed /= 0) status = fail(NUTATE_NO_MEMORY, 'not enough memory for a history')
      end if
      if (status%ok()) then
         handle%mark = HISTORY_MARK
         slot = c_loc(handle)
         call keep_rows(rows, handle)
      end if
      code = say(problem, status, message, size)
      if (code == NUTATE_OK .and. c_associated(facts)) code = text_to_c(facts_text(rows), facts, facts_size)
   end function nutate_read_aem

   !> Reads the date of an epoch, which is not set if the date is invalid.
   subroutine read_instant(date, system, epoch)
      type(c_ptr), intent(in) :: date, system
      type(epoch_t), intent(out) :: epoch
      character(len=:), allocatable :: text, name, problem
      call copy_text(date, text)
      call copy_text(system, name)
      if (.not. is_listed(name, time_systems) .or. name == '') return
      call read_epoch(text, name, epoch, problem)
      if (problem /= '') epoch%system = ''
   end subroutine read_instant

   !> Reads path and facts of a file.
   subroutine take_facts(path, facts, name, known, problem, status)
      type(c_ptr), intent(in) :: path, facts
      character(len=:), allocatable, intent(out) :: name
      type(export_facts_t), intent(out) :: known
      !> Error in the facts, as one line; empty if there is none.
      character(len=:), allocatable, intent(out) :: problem
      type(status_t), intent(out) :: status
      character(len=1) :: none(0)
      character(len=:), allocatable :: text
      problem = ''
      call copy_text(path, name)
      if (.not. c_associated(facts)) status = null_argument('facts')
      if (.not. c_associated(path)) status = null_argument('path')
      if (status%ok() .and. name == '') status = fail(NUTATE_BAD_ARGUMENT, 'the path is empty', 'path')
      if (.not. status%ok()) return
      call copy_text(facts, text)
      call lock_texts()
      call parse_facts(text, 'facts', none, known, status, problem)
      call unlock_texts()
   end subroutine take_facts

   !> Copies rows from C arrays, and tests them.
   subroutine take_rows(n, t, q, omega, rows, status)
      integer(c_size_t), intent(in) :: n
      real(c_double), intent(in), optional :: t(*), q(*), omega(*)
      type(attitude_rows_t), intent(out) :: rows
      type(status_t), intent(inout) :: status
      integer :: i
      if (n < 1 .or. n > most_rows) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the number of rows is out of its range (expected 1 or more)', 'n')
      else if (.not. present(t)) then
         status = null_argument('t')
      else if (.not. present(q)) then
         status = null_argument('q')
      end if
      if (.not. status%ok()) return
      rows%t = t(:n)
      rows%q = reshape(q(:4*n), [4, int(n)])
      if (present(omega)) rows%omega = reshape(omega(:3*n), [3, int(n)])
      if (.not. (all(is_moderate(rows%t)) .and. all(is_moderate(rows%q)))) then
         status = fail(NUTATE_BAD_ARGUMENT, 'a time or an attitude is not finite', 't')
         return
      end if
      do i = 1, int(n)
         if (.not. is_unit(rows%q(:, i), attitude_tolerance)) then
            status = fail(NUTATE_BAD_ARGUMENT, 'an attitude is not a unit quaternion', 'q')
            return
         end if
      end do
      if (any(rows%t(2:) <= rows%t(:int(n) - 1))) &
         status = fail(NUTATE_BAD_ARGUMENT, 'the times do not ascend (expected each after the one before)', 't')
      if (present(omega)) then
         if (.not. all(is_moderate(rows%omega))) &
            status = fail(NUTATE_BAD_ARGUMENT, 'an angular velocity is not finite', 'omega')
      end if
   end subroutine take_rows

   !> Returns true if x < limit, false if x is not finite.
   pure logical function is_below(x, limit)
      real(wp), intent(in) :: x, limit
      is_below = .false.
      if (ieee_is_finite(x)) is_below = x < limit
   end function is_below

   !> Keeps rows as columns of a history.
   subroutine keep_rows(rows, handle)
      type(attitude_rows_t), intent(in) :: rows
      type(history_handle_t), intent(inout) :: handle
      handle%names = 't,q0,q1,q2,q3'
      handle%width = 5
      if (allocated(rows%omega)) then
         handle%names = handle%names//',omega1,omega2,omega3'
         handle%width = 8
      end if
      if (allocated(rows%segments)) then
         handle%names = handle%names//',segment'
         handle%width = handle%width + 1
      end if
      handle%rows = rows%count()
      allocate (handle%values(handle%width, handle%rows))
      handle%values(1, :) = rows%t
      handle%values(2:5, :) = rows%q
      if (allocated(rows%omega)) handle%values(6:8, :) = rows%omega
      if (allocated(rows%segments)) handle%values(handle%width, :) = rows%segments
   end subroutine keep_rows

   !> Returns epoch and names as a group `&scene`.
   function facts_text(rows) result(text)
      type(attitude_rows_t), intent(in) :: rows
      character(len=:), allocatable :: text, value
      integer :: i
      text = ''
      do i = 1, size(label_keys)
         if (label_keys(i)%name == 'title') cycle
         call label_of(rows%labels, trim(label_keys(i)%name), value)
         if (value == '') cycle
         if (text /= '') text = text//', '
         text = text//trim(label_keys(i)%name)//" = '"//escaped(value, "'", "'")//"'"
      end do
      text = '&scene '//text//' /'
   end function facts_text

   !> Writes a message into a buffer and returns the status code: the problem, if there is one, else the status message.
   integer(c_int) function say(problem, status, message, size) result(code)
      character(len=*), intent(in) :: problem
      type(status_t), intent(in) :: status
      type(c_ptr), intent(in) :: message
      integer(c_size_t), intent(in) :: size
      if (problem == '') then
         code = report(status, message, size)
      else
         call message_to_c(problem, message, size)
         code = status%code
      end if
   end function say

end module nutate_c_exchange
