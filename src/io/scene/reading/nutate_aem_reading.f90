!> Reads Attitude Ephemeris Messages (CCSDS 504.0-B, versions 1.0 and 2.0) in KVN.
module nutate_aem_reading
   use nutate_aem_keywords, only: ANGULAR_VELOCITY, attitude_types, attitude_type_t, DERIVATIVE, is_inverted, &
      keyword_length, known_keywords, NO_RATES, ROTATION_RATE
   use nutate_attitude_rows, only: attitude_rows_t, is_unit
   use nutate_epoch, only: epoch_t, read_epoch, time_systems
   use nutate_kinds, only: wp, pi
   use nutate_number_text, only: read_real
   use nutate_printable, only: printable_path, quoted
   use nutate_quaternion, only: quat_conjugate, quat_norm, quat_normalized, quat_product, rotate_to_body
   use nutate_scene_table, only: begin_of, count_lines
   use nutate_spelling, only: comma_list, count_text, is_listed, lower_case, nearest_name, split_list
   use nutate_text_file, only: read_text_file
   implicit none
   private

   public :: read_aem, parse_aem

   real(wp), parameter :: degree = pi/180
   !> Tolerance of the norm of quaternions that are rounded to few digits.
   real(wp), parameter :: norm_tolerance = 1e-3_wp
   !> Tolerance within which rounded attitudes, rad, and rates, relative to their size, are the same.
   real(wp), parameter :: same = 1e-6_wp
   !> Keywords whose values the standard defines: all letters are upper or lower case.
   character(len=*), parameter :: defined(*) = [character(len=16) :: 'REF_FRAME_A', 'REF_FRAME_B', 'ATTITUDE_DIR', &
      'TIME_SYSTEM', 'ATTITUDE_TYPE', 'QUATERNION_TYPE', 'ANGVEL_FRAME', 'RATE_FRAME']
   !> Bound that all numbers of a record must be below.
   real(wp), parameter :: greatest = 1e100_wp
   character, parameter :: line_feed = achar(10), carriage_return = achar(13), tab = achar(9)
   !> Parts of a message in which a line can be.
   integer, parameter :: IN_HEADER = 1, IN_METADATA = 2, BEFORE_DATA = 3, IN_DATA = 4, BETWEEN_SEGMENTS = 5

   !> Metadata of a segment.
   type :: segment_t
      !> Values of the known keywords, in their order; blank: absent.
      character(len=120) :: values(size(known_keywords)) = ''
   contains
      !> Returns the value of a keyword.
      procedure :: value => value_of
   end type segment_t

   !> State of the reader of a message.
   type :: reader_t
      integer :: place = IN_HEADER, line = 0
      !> Version of the standard, current segment, and first segment.
      character(len=8) :: version = ''
      type(segment_t) :: segment, first
      type(attitude_type_t) :: kind
      logical :: has_segment = .false., starts_segment = .false.
      type(epoch_t) :: epoch
      !> Dates from which and up to which records may be used; not set: there is no limit.
      type(epoch_t) :: useable_start, useable_stop
      !> Numbers of rows and segments read so far.
      integer :: n = 0, segments = 0
      !> Error message; empty if there is no error.
      character(len=:), allocatable :: problem
   end type reader_t

contains

   !> Reads a file: all its segments, which must be of one body, in one pair of frames, time system and type.
   subroutine read_aem(path, rows, problem)
      character(len=*), intent(in) :: path
      !> Times since the first record, whose date is the epoch. The space axes are REF_FRAME_A, the body axes
      !> REF_FRAME_B, or vice versa if REF_FRAME_A is a frame of the spacecraft.
      type(attitude_rows_t), intent(out) :: rows
      !> Error message, one printable line, `FILE: ...` or `FILE:LINE: ...`; empty on success.
      character(len=:), allocatable, intent(out) :: problem
      character(len=:), allocatable :: text, reason
      call read_text_file(path, text, reason)
      problem = ''
      if (reason /= '') then
         problem = printable_path(path)//': cannot be read ('//reason//')'
      else
         call parse_aem(text, path, rows, problem)
      end if
   end subroutine read_aem

   !> Reads the text of a file.
   subroutine parse_aem(text, path, rows, problem)
      character(len=*), intent(in) :: text
      !> Name of the file in messages.
      character(len=*), intent(in) :: path
      type(attitude_rows_t), intent(out) :: rows
      character(len=:), allocatable, intent(out) :: problem
      type(reader_t) :: reader
      integer :: position, last, most
      reader%problem = ''
      most = count_lines(text)
      allocate (rows%t(most), rows%q(4, most), rows%omega(3, most), rows%lines(most), &
                rows%segments(most))
      position = begin_of(text)
      do while (position <= len(text) .and. reader%problem == '')
         last = index(text(position:), line_feed)
         last = merge(len(text), position + last - 2, last == 0)
         reader%line = reader%line + 1
         call take_line(reader, plain(text(position:last)), rows)
         position = last + 2
      end do
      if (reader%problem == '') then
         if (reader%place == IN_HEADER .and. reader%version == '') then
            reader%problem = 'not an attitude ephemeris message (expected a first line CCSDS_AEM_VERS = 2.0)'
         else if (reader%place /= BETWEEN_SEGMENTS) then
            reader%problem = 'the message ends too early (expected DATA_STOP)'
         else if (reader%n == 0) then
            reader%problem = 'the message has no records (expected one or more)'
         end if
      end if
      problem = ''
      if (reader%problem /= '') then
         problem = printable_path(path)//':'//count_text(max(reader%line, 1))//': '//reader%problem
         return
      end if
      rows%t = rows%t(:reader%n)
      rows%q = rows%q(:, :reader%n)
      rows%lines = rows%lines(:reader%n)
      rows%segments = rows%segments(:reader%n)
      if (reader%segments == 1) deallocate (rows%segments)
      if (reader%kind%rates /= NO_RATES) then
         rows%omega = rows%omega(:, :reader%n)
      else
         deallocate (rows%omega)
      end if
      call name_rows(reader, rows)
   end subroutine parse_aem

   !> Returns a line without blanks around it.
   pure function plain(line)
      character(len=*), intent(in) :: line
      character(len=:), allocatable :: plain
      integer :: i
      plain = line
      do i = 1, len(plain)
         if (plain(i:i) == tab .or. plain(i:i) == carriage_return) plain(i:i) = ' '
      end do
      plain = trim(adjustl(plain))
   end function plain

   !> Sets names and epoch of the rows.
   pure subroutine name_rows(reader, rows)
      type(reader_t), intent(in) :: reader
      type(attitude_rows_t), intent(inout) :: rows
      associate (labels => rows%labels)
         labels%epoch = reader%epoch
         labels%date = reader%epoch%text()
         labels%object = reader%first%value('OBJECT_NAME')
         labels%object_id = reader%first%value('OBJECT_ID')
         labels%space_frame = reader%first%value('REF_FRAME_A')
         labels%body_frame = reader%first%value('REF_FRAME_B')
         if (is_inverted(labels%space_frame, labels%body_frame)) then
            labels%space_frame = reader%first%value('REF_FRAME_B')
            labels%body_frame = reader%first%value('REF_FRAME_A')
         end if
      end associate
   end subroutine name_rows

   !> Returns the value of a keyword; empty if it is absent.
   pure function value_of(self, keyword) result(value)
      class(segment_t), intent(in) :: self
      character(len=*), intent(in) :: keyword
      character(len=:), allocatable :: value
      value = trim(self%values(findloc(known_keywords == keyword, .true., dim=1)))
   end function value_of

   !> Reads a line.
   subroutine take_line(reader, line, rows)
      type(reader_t), intent(inout) :: reader
      character(len=*), intent(in) :: line
      type(attitude_rows_t), intent(inout) :: rows
      if (line == '' .or. line == 'COMMENT' .or. index(line, 'COMMENT ') == 1) return
      select case (line)
      case ('META_START')
         call move(reader, [IN_HEADER, BETWEEN_SEGMENTS], IN_METADATA, line)
         reader%segment = segment_t()
         if (reader%version == '' .and. reader%problem == '') &
            reader%problem = 'META_START stands before the version (expected CCSDS_AEM_VERS = 2.0)'
      case ('META_STOP')
         call move(reader, [IN_METADATA], BEFORE_DATA, line)
         if (reader%problem == '') call check_segment(reader)
      case ('DATA_START')
         call move(reader, [BEFORE_DATA], IN_DATA, line)
         reader%starts_segment = .true.
      case ('DATA_STOP')
         call move(reader, [IN_DATA], BETWEEN_SEGMENTS, line)
      case default
         if (reader%place == IN_DATA) then
            call take_record(reader, line, rows)
         else
            call take_setting(reader, line)
         end if
      end select
   end subroutine take_line

   !> Goes on to another part of the message.
   pure subroutine move(reader, from, to, line)
      type(reader_t), intent(inout) :: reader
      integer, intent(in) :: from(:), to
      character(len=*), intent(in) :: line
      character(len=24), parameter :: due(5) = [character(len=24) :: 'META_START', 'META_STOP', 'DATA_START', &
                                                'DATA_STOP', 'META_START']
      if (all(from /= reader%place)) reader%problem = line//' is out of place (expected '//trim(due(reader%place))//')'
      reader%place = to
   end subroutine move

   !> Reads `KEYWORD = value`.
   subroutine take_setting(reader, line)
      type(reader_t), intent(inout) :: reader
      character(len=*), intent(in) :: line
      character(len=:), allocatable :: keyword, value
      integer :: equals, k
      equals = index(line, '=')
      if (index(line, '<') == 1) then
         reader%problem = 'XML is not supported (expected a message in KVN: KEYWORD = value)'
      else if (equals < 2) then
         reader%problem = quoted(line)//' is out of place (expected KEYWORD = value)'
      end if
      if (reader%problem /= '') return
      keyword = trim(line(:equals - 1))
      value = trim(adjustl(line(equals + 1:)))
      k = 0
      if (len(keyword) <= keyword_length) k = findloc(known_keywords == keyword, .true., dim=1)
      if (k == 0) then
         reader%problem = 'unknown keyword '//quoted(keyword)
         k = nearest_keyword(keyword)
         if (k > 0) reader%problem = reader%problem//' (nearest: '//trim(known_keywords(k))//')'
      else if (value == '') then
         reader%problem = keyword//' has no value'
      else if (reader%place == IN_METADATA) then
         if (reader%segment%values(k) /= '') reader%problem = keyword//' is given twice (expected it once)'
         if (any(defined == keyword) .and. value == lower_case(value)) value = upper_case(value)
         reader%segment%values(k) = value
      else if (keyword == 'CCSDS_AEM_VERS') then
         reader%version = value
         if (all(value /= ['1.0', '2.0'])) &
            reader%problem = 'version '//quoted(value)//' is not known (expected 1.0 or 2.0)'
      else if (reader%version == '') then
         reader%problem = 'not an attitude ephemeris message (expected a first line CCSDS_AEM_VERS = 2.0)'
      end if
   end subroutine take_setting

   !> Returns a word in capital letters.
   pure function upper_case(word) result(capitals)
      character(len=*), intent(in) :: word
      character(len=len(word)) :: capitals
      integer :: i
      capitals = word
      do i = 1, len(word)
         if (word(i:i) >= 'a' .and. word(i:i) <= 'z') capitals(i:i) = achar(iachar(word(i:i)) - 32)
      end do
   end function upper_case

   !> Returns the index of the known keyword that is nearest to another word; 0 if none is near.
   pure integer function nearest_keyword(word) result(k)
      character(len=*), intent(in) :: word
      character(len=keyword_length) :: known(size(known_keywords))
      character(len=:), allocatable :: nearest
      do k = 1, size(known)
         known(k) = lower_case(known_keywords(k))
      end do
      nearest = nearest_name(lower_case(word), known)
      k = 0
      if (nearest /= '') k = findloc(known == nearest, .true., dim=1)
   end function nearest_keyword

   !> Checks the metadata of a segment, and that they agree with those of the first one.
   subroutine check_segment(reader)
      type(reader_t), intent(inout) :: reader
      character(len=keyword_length), parameter :: needed(*) = [character(len=keyword_length) :: &
         'OBJECT_NAME', 'REF_FRAME_A', 'REF_FRAME_B', 'TIME_SYSTEM', 'ATTITUDE_TYPE']
      integer :: i
      associate (segment => reader%segment)
         do i = 1, size(needed)
            if (reader%problem == '' .and. segment%value(trim(needed(i))) == '') &
               reader%problem = 'the metadata lack '//trim(needed(i))
         end do
         if (reader%problem /= '') return
         i = findloc(attitude_types%name == segment%value('ATTITUDE_TYPE'), .true., dim=1)
         if (i == 0) then
            reader%problem = 'ATTITUDE_TYPE '//quoted(segment%value('ATTITUDE_TYPE'))// &
                             ' is not supported (expected '//comma_list(attitude_types%name)//')'
         else if (.not. is_listed(segment%value('TIME_SYSTEM'), time_systems)) then
            reader%problem = 'TIME_SYSTEM '//quoted(segment%value('TIME_SYSTEM'))//' is not supported (expected '// &
                             comma_list(split_list(time_systems))//')'
         else
            reader%kind = attitude_types(i)
            call check_direction(reader)
         end if
         if (reader%problem /= '') return
         if (.not. reader%has_segment) reader%first = segment
         do i = 1, size(needed)
            if (segment%value(trim(needed(i))) /= reader%first%value(trim(needed(i)))) reader%problem = &
               trim(needed(i))//' of this segment is not that of the first (expected '// &
               quoted(reader%first%value(trim(needed(i))))//')'
         end do
      end associate
      reader%has_segment = .true.
      call read_limit(reader, 'USEABLE_START_TIME', reader%useable_start)
      call read_limit(reader, 'USEABLE_STOP_TIME', reader%useable_stop)
   end subroutine check_segment

   !> Reads a date of the metadata; not set if it is absent.
   subroutine read_limit(reader, keyword, date)
      type(reader_t), intent(inout) :: reader
      character(len=*), intent(in) :: keyword
      type(epoch_t), intent(out) :: date
      character(len=:), allocatable :: text
      text = reader%segment%value(keyword)
      if (text == '' .or. reader%problem /= '') return
      call read_epoch(text, reader%segment%value('TIME_SYSTEM'), date, reader%problem, in_message=.true.)
      if (reader%problem /= '') reader%problem = keyword//' '//quoted(text)//' '//reader%problem
   end subroutine read_limit

   !> Checks direction and order of quaternions, and the frame of rates.
   subroutine check_direction(reader)
      type(reader_t), intent(inout) :: reader
      associate (segment => reader%segment)
         if (reader%version == '1.0') then
            if (all(lower_case(segment%value('ATTITUDE_DIR')) /= ['a2b', 'b2a'])) then
               reader%problem = 'ATTITUDE_DIR is absent or unknown (expected A2B or B2A)'
            else if (all(lower_case(segment%value('QUATERNION_TYPE')) /= ['first', 'last '])) then
               reader%problem = 'QUATERNION_TYPE is absent or unknown (expected FIRST or LAST)'
            end if
         else if (segment%value('ATTITUDE_DIR')//segment%value('QUATERNION_TYPE') /= '') then
            reader%problem = 'version 2.0 has neither ATTITUDE_DIR nor QUATERNION_TYPE (expected CCSDS_AEM_VERS = 1.0)'
         end if
      end associate
      if (reader%problem == '') call check_rates(reader)
   end subroutine check_direction

   !> Checks type and frame of rates: version 2.0 has no rotation rates, which are those of Euler angles if a sequence
   !> is given.
   subroutine check_rates(reader)
      type(reader_t), intent(inout) :: reader
      character(len=:), allocatable :: keyword
      associate (segment => reader%segment, rates => reader%kind%rates)
         keyword = frame_keyword(rates)
         if (rates == ROTATION_RATE .and. reader%version /= '1.0') then
            reader%problem = "ATTITUDE_TYPE 'QUATERNION/RATE' is one of version 1.0 (expected QUATERNION/ANGVEL)"
         else if (rates == ROTATION_RATE .and. segment%value('EULER_ROT_SEQ') /= '') then
            reader%problem = 'rates of Euler angles are not read (expected rates about the axes of RATE_FRAME, '// &
                             'without EULER_ROT_SEQ)'
         else if (keyword /= '') then
            if (.not. (is_frame(segment, keyword, 'REF_FRAME_A') .or. is_frame(segment, keyword, 'REF_FRAME_B'))) &
               reader%problem = keyword//' is absent or unknown (expected REF_FRAME_A or REF_FRAME_B)'
         end if
      end associate
   end subroutine check_rates

   !> Returns the keyword that names the axes of rates; empty for those that need none.
   pure function frame_keyword(rates) result(keyword)
      integer, intent(in) :: rates
      character(len=:), allocatable :: keyword
      keyword = ''
      if (rates == ANGULAR_VELOCITY) keyword = 'ANGVEL_FRAME'
      if (rates == ROTATION_RATE) keyword = 'RATE_FRAME'
   end function frame_keyword

   !> Returns true if a keyword has the value of a frame, or its keyword.
   pure logical function is_frame(segment, keyword, frame)
      type(segment_t), intent(in) :: segment
      !> `ANGVEL_FRAME` or `RATE_FRAME`; `REF_FRAME_A` or `REF_FRAME_B`.
      character(len=*), intent(in) :: keyword, frame
      is_frame = any(segment%value(keyword) == [character(len=120) :: frame, segment%value(frame)])
   end function is_frame

   !> Reads a record: a date and numbers.
   subroutine take_record(reader, line, rows)
      type(reader_t), intent(inout) :: reader
      character(len=*), intent(in) :: line
      type(attitude_rows_t), intent(inout) :: rows
      type(epoch_t) :: date
      real(wp) :: values(8), q(4), omega(3), t
      integer :: blank
      blank = index(line, ' ')
      if (blank == 0) blank = len(line) + 1
      call read_epoch(line(:blank - 1), reader%first%value('TIME_SYSTEM'), date, reader%problem, in_message=.true.)
      if (reader%problem /= '') reader%problem = quoted(line(:blank - 1))//' '//reader%problem
      if (reader%problem == '') call read_numbers(line(blank:), reader%kind%numbers, values, reader%problem)
      if (reader%problem == '') call find_attitude()
      if (reader%problem /= '' .or. .not. is_useable()) return
      if (reader%n == 0) reader%epoch = date
      t = date%since(reader%epoch)
      if (reader%n > 0) then
         if (t < rows%t(reader%n) .or. (t <= rows%t(reader%n) .and. .not. reader%starts_segment)) then
            reader%problem = 'the date is not after that of the record before (expected ascending dates)'
            return
         end if
         if (reader%starts_segment) reader%starts_segment = .not. goes_on()
         ! A segment that goes on from the end of the one before repeats its last record.
         if (t <= rows%t(reader%n) .and. .not. reader%starts_segment) return
      end if
      if (reader%starts_segment) reader%segments = reader%segments + 1
      reader%starts_segment = .false.
      reader%n = reader%n + 1
      rows%t(reader%n) = t
      rows%lines(reader%n) = reader%line
      rows%segments(reader%n) = reader%segments
      rows%q(:, reader%n) = q
      rows%omega(:, reader%n) = omega

   contains

      !> Finds attitude, body to space, and angular velocity, body axes, rad/s, of the numbers of a record.
      subroutine find_attitude()
         logical :: inverted
         q = scalar_first(values(1:4))
         if (.not. is_unit(q, norm_tolerance)) then
            reader%problem = 'the quaternion is not of unit norm (expected Q1 Q2 Q3 QC with a sum of squares of 1)'
            return
         end if
         omega = rate_of(quat_norm(q), quat_normalized(q), values(5:8))
         q = quat_normalized(q)
         if (is_reversed()) q = quat_conjugate(q)
         inverted = is_inverted(reader%segment%value('REF_FRAME_A'), reader%segment%value('REF_FRAME_B'))
         if (.not. inverted) return
         ! REF_FRAME_A rotates against REF_FRAME_B by the opposite rate, in its own axes.
         q = quat_conjugate(q)
         omega = -rotate_to_body(q, omega)
      end subroutine find_attitude

      !> Returns the angular velocity of REF_FRAME_B against REF_FRAME_A, in the axes of B, rad/s; zero without rates.
      pure function rate_of(norm, q, values) result(omega)
         !> Norm of the quaternion as given, and the quaternion normalised, scalar first.
         real(wp), intent(in) :: norm, q(4)
         !> Numbers behind the quaternion, shape (4).
         real(wp), intent(in) :: values(:)
         real(wp) :: omega(3), attitude(4), product(4)
         attitude = q
         if (is_reversed()) attitude = quat_conjugate(q)
         select case (reader%kind%rates)
         case (ANGULAR_VELOCITY, ROTATION_RATE)
            omega = values(1:3)*degree
            if (reader%kind%rates == ROTATION_RATE .and. is_reversed()) omega = -omega
            if (.not. is_frame(reader%segment, frame_keyword(reader%kind%rates), 'REF_FRAME_B')) &
               omega = rotate_to_body(attitude, omega)
         case (DERIVATIVE)
            product = scalar_first(values)/norm
            if (is_reversed()) product = quat_conjugate(product)
            product = quat_product(quat_conjugate(attitude), product)
            omega = 2*product(2:4)
         case default
            omega = 0.0_wp
         end select
      end function rate_of

      !> Returns the four numbers of a quaternion, or of its derivative, scalar first.
      pure function scalar_first(values) result(q)
         real(wp), intent(in) :: values(4)
         real(wp) :: q(4)
         q = [values(4), values(1:3)]
         if (lower_case(reader%segment%value('QUATERNION_TYPE')) == 'first') q = values
      end function scalar_first

      !> Returns true if the quaternion describes the rotation from REF_FRAME_B to REF_FRAME_A.
      pure logical function is_reversed()
         is_reversed = lower_case(reader%segment%value('ATTITUDE_DIR')) == 'b2a'
      end function is_reversed

      !> Returns true for a date inside of the useable part of the segment.
      pure logical function is_useable()
         is_useable = .true.
         if (reader%useable_start%is_set()) is_useable = date%since(reader%useable_start) >= 0.0_wp
         if (reader%useable_stop%is_set()) is_useable = is_useable .and. date%since(reader%useable_stop) <= 0.0_wp
      end function is_useable

      !> Returns true if the first record of a segment is the last one of the segment before.
      pure logical function goes_on()
         goes_on = t <= rows%t(reader%n) .and. &
                   min(norm2(q - rows%q(:, reader%n)), norm2(q + rows%q(:, reader%n))) <= same
         if (goes_on .and. reader%kind%rates /= NO_RATES) &
            goes_on = norm2(omega - rows%omega(:, reader%n)) <= same*max(norm2(omega), same)
      end function goes_on

   end subroutine take_record

   !> Reads numbers, parted by blanks.
   subroutine read_numbers(text, n, values, problem)
      character(len=*), intent(in) :: text
      integer, intent(in) :: n
      real(wp), intent(out) :: values(:)
      character(len=:), allocatable, intent(inout) :: problem
      character(len=:), allocatable :: fault
      integer :: first, last, found
      values = 0.0_wp
      found = 0
      first = 1
      do
         if (verify(text(first:), ' ') == 0) exit
         first = first + verify(text(first:), ' ') - 1
         last = first + index(text(first:)//' ', ' ') - 2
         found = found + 1
         if (found <= n) then
            call read_real(text(first:last), values(found), fault)
            if (fault /= '' .and. abs(values(found)) <= 0.0_wp) then
               problem = quoted(text(first:last))//' is not a number'
            else if (.not. abs(values(found)) < greatest) then
               problem = quoted(text(first:last))//' is too large (expected up to 1e100)'
            end if
            if (problem /= '') return
         end if
         first = last + 1
         if (first > len(text)) exit
      end do
      if (found /= n) &
         problem = 'wrong number of values in this record (expected a date and '//count_text(n)//' numbers)'
   end subroutine read_numbers

end module nutate_aem_reading
