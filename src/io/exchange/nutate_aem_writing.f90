!> Writes attitudes as an Attitude Ephemeris Message (CCSDS 504.0-B).
module nutate_aem_writing
   use nutate_aem_keywords, only: ecliptic, equatorial, from_ecliptic, is_ecliptic, is_inertial, is_inverted, &
      is_rotating
   use nutate_attitude_rows, only: attitude_rows_t, gap_fault
   use nutate_calendar, only: day_of
   use nutate_decimal, only: decimal_length, decimal_t, rounded_text
   use nutate_epoch, only: epoch_t
   use nutate_files, only: output_file_t
   use nutate_kinds, only: wp, pi
   use nutate_quaternion, only: quat_normalized, quat_product
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_version, only: version
   implicit none
   private

   public :: aem_fault, write_aem, aem_versions

   !> Versions that can be written.
   character(len=*), parameter :: aem_versions = '2.0,1.0'
   real(wp), parameter :: degree = pi/180
   !> Digits of the seconds of dates, at least.
   integer, parameter :: date_digits = 6

contains

   !> Returns what a message cannot be written without; empty if nothing is missing.
   pure function aem_fault(rows) result(problem)
      type(attitude_rows_t), intent(in) :: rows
      character(len=:), allocatable :: problem
      type(epoch_t) :: first, last
      problem = ''
      associate (labels => rows%labels)
         if (.not. labels%epoch%is_set()) then
            problem = 'an AEM needs the date of t = 0 (expected epoch and time_system of &scene)'
         else if (labels%space_frame == '') then
            problem = "an AEM needs the name of the space axes (expected space_frame of &scene, such as 'ICRF')"
         else if (rows%rotates .and. is_inertial(labels%space_frame)) then
            problem = "the space axes rotate, and space_frame = '"//labels%space_frame//"' names inertial axes "// &
                      "(expected the name of the axes of &rotating_frame, such as 'LAB')"
         else if (rows%on_orbit .and. is_rotating(labels%space_frame)) then
            problem = "space_frame = '"//labels%space_frame//"' names axes that rotate, and the attitudes are in "// &
                      "inertial axes (expected their name, such as 'ICRF')"
         else if (is_inverted(labels%space_frame, first_of(labels%body_frame, 'SC_BODY_1'))) then
            problem = "space_frame = '"//labels%space_frame//"' and body_frame = '"//labels%body_frame// &
                      "' are read vice versa (expected a space_frame outside of the spacecraft)"
         else if (labels%object == '') then
            problem = 'an AEM needs the name of the body (expected object of &scene)'
         else if (rows%count() < 1) then
            problem = 'there are no rows (expected one or more)'
         else
            first = labels%epoch%after(rows%t(1))
            last = labels%epoch%after(rows%t(rows%count()))
            if (.not. (first%is_set() .and. last%is_set())) &
               problem = 'the rows leave the calendar (expected the years 1583 to 9999, of UTC from 1972)'
            if (problem == '') problem = gap_fault(rows)
         end if
      end associate
   end function aem_fault

   !> Writes a message: the space axes are REF_FRAME_A, the body axes REF_FRAME_B.
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT` for what `aem_fault` finds; `NUTATE_IO`, what was written is in `PATH.partial` then.
   subroutine write_aem(path, rows, version_text, status, error)
      !> Path of the message; `-` is standard output.
      character(len=*), intent(in) :: path
      type(attitude_rows_t), intent(in) :: rows
      !> Version of the format: `2.0`, or `1.0`, which has no rates.
      character(len=*), intent(in) :: version_text
      type(status_t), intent(out) :: status
      !> Attitude error between the rows, rad, by which they were chosen; 0 if they were not.
      real(wp), intent(in) :: error
      type(output_file_t) :: file
      character(len=:), allocatable :: problem
      problem = aem_fault(rows)
      if (problem /= '') then
         status = fail(NUTATE_BAD_ARGUMENT, problem)
         return
      end if
      call file%open(path, status)
      if (status%ok()) call put_head()
      if (status%ok()) call put_records()
      if (status%ok()) call file%put_line('DATA_STOP', status)
      call file%close(status)

   contains

      !> Writes header and metadata.
      subroutine put_head()
         character(len=:), allocatable :: text
         character(len=*), parameter :: nl = new_line('a')
         type(epoch_t) :: first, last
         associate (labels => rows%labels)
            first = labels%epoch%after(rows%t(1))
            last = labels%epoch%after(rows%t(rows%count()))
            text = 'CCSDS_AEM_VERS = '//version_text//nl//'CREATION_DATE = '//date_now()//nl//'ORIGINATOR = NUTATE'//nl
            text = text//'META_START'//nl//'COMMENT written by nutate '//version//nl// &
                   'COMMENT the quaternion turns coordinates of REF_FRAME_A into those of REF_FRAME_B; QC, its '// &
                   'last component, is the scalar'//nl
            if (error > 0.0_wp) text = text//'COMMENT a rotation at a constant rate between records is within '// &
                                       rounded_text(error, 3)//' rad of the motion'//nl
            if (is_ecliptic(labels%space_frame)) text = text//'COMMENT '//ecliptic//' was rotated to '//equatorial// &
                                                        ' by 84381.448 arcseconds about x'//nl
            text = text//'OBJECT_NAME = '//labels%object//nl//'OBJECT_ID = '// &
                   first_of(labels%object_id, labels%object)//nl
            text = text//'REF_FRAME_A = '//frame_of(labels%space_frame)//nl// &
                   'REF_FRAME_B = '//first_of(labels%body_frame, 'SC_BODY_1')//nl
            if (version_text == '1.0') text = text//'ATTITUDE_DIR = A2B'//nl
            text = text//'TIME_SYSTEM = '//trim(labels%epoch%system)//nl
            text = text//'START_TIME = '//first%text(date_digits)//nl//'STOP_TIME = '//last%text(date_digits)//nl
            if (version_text == '1.0') then
               text = text//'ATTITUDE_TYPE = QUATERNION'//nl//'QUATERNION_TYPE = LAST'//nl
            else if (allocated(rows%omega)) then
               text = text//'ATTITUDE_TYPE = QUATERNION/ANGVEL'//nl//'ANGVEL_FRAME = REF_FRAME_B'//nl
            else
               text = text//'ATTITUDE_TYPE = QUATERNION'//nl
            end if
         end associate
         call file%put_line(text//'META_STOP'//nl//'DATA_START', status)
      end subroutine put_head

      !> Writes the records.
      subroutine put_records()
         character(len=(decimal_length + 1)*7) :: line
         type(decimal_t) :: decimal
         type(epoch_t) :: date
         real(wp) :: q(4), values(7)
         integer :: i, k, used, width
         call decimal%prepare()
         width = 4
         if (allocated(rows%omega) .and. version_text /= '1.0') width = 7
         values = 0.0_wp
         do i = 1, rows%count()
            q = rows%q(:, i)
            if (is_ecliptic(rows%labels%space_frame)) q = quat_product(from_ecliptic(), q)
            q = quat_normalized(q)
            values(1:4) = [q(2:4), q(1)]
            if (width == 7) values(5:7) = rows%omega(:, i)/degree
            used = 0
            do k = 1, width
               used = used + 1
               line(used:used) = ' '
               call decimal%append(line, used, values(k))
            end do
            date = rows%labels%epoch%after(rows%t(i))
            call file%put_line(date%text(date_digits)//line(:used), status)
            if (.not. status%ok()) return
         end do
      end subroutine put_records

   end subroutine write_aem

   !> Returns the name of the space axes as they are written.
   pure function frame_of(frame) result(name)
      character(len=*), intent(in) :: frame
      character(len=:), allocatable :: name
      name = frame
      if (is_ecliptic(frame)) name = equatorial
   end function frame_of

   !> Returns the first of two strings that is not empty.
   pure function first_of(a, b) result(text)
      character(len=*), intent(in) :: a, b
      character(len=:), allocatable :: text
      text = a
      if (a == '') text = b
   end function first_of

   !> Returns the date in UTC, to a second.
   function date_now() result(text)
      character(len=19) :: text
      type(epoch_t) :: now
      integer :: v(8)
      call date_and_time(values=v)
      ! The clock gives dates without leap seconds, as in TAI.
      now%day = day_of(v(1), v(2), v(3))
      now%system = 'TAI'
      now = now%after(60.0_wp*(60*v(5) + v(6) - v(4)) + min(v(7), 59))
      text = now%text()
   end function date_now

end module nutate_aem_writing
