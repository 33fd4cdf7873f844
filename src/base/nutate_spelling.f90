!> Names and whole numbers as people write them: lower case, lists of names, marks before characters, and which known
!> name is nearest to a misspelt one.
module nutate_spelling
   use nutate_keys, only: name_length
   use nutate_kinds, only: long
   implicit none
   private

   public :: lower_case, split_list, joined, comma_list, distinct, is_listed, nearest_name, new_name, edit_distance
   public :: count_text, escaped

   !> Names of before the first release, each with its present name; shape (2, n). They are rejected, with the new name
   !> in the message.
   character(len=name_length), parameter :: former_names(2, 9) = reshape([character(len=name_length) :: &
      'linear_solver', 'formulation', &
      'lapack', 'full', &
      'regulator', 'controller', &
      'magnets', 'magnetorquers', &
      'argument_of_perigee', 'argument_of_periapsis', &
      'orbit', 'lvlh', &
      'orbit_attitude', 'lvlh_attitude', &
      'world_work', 'time_dependent_work', &
      'tangent', 'chaos'], [2, 9])

   !> Returns a whole number as a text.
   interface count_text
      module procedure count_text, long_count_text
   end interface count_text

contains

   pure function count_text(n) result(text)
      integer, intent(in) :: n
      character(len=:), allocatable :: text
      text = long_count_text(int(n, long))
   end function count_text

   pure function long_count_text(n) result(text)
      integer(long), intent(in) :: n
      character(len=:), allocatable :: text
      character(len=20) :: digits
      write (digits, '(i0)') n
      text = trim(digits)
   end function long_count_text

   !> Returns a text with a mark before each of some characters.
   pure function escaped(text, characters, mark) result(marked)
      character(len=*), intent(in) :: text, characters, mark
      character(len=:), allocatable :: marked
      integer :: i
      marked = ''
      do i = 1, len(text)
         if (index(characters, text(i:i)) > 0) marked = marked//mark
         marked = marked//text(i:i)
      end do
   end function escaped

   !> Returns a text with its ASCII letters in lower case.
   pure function lower_case(text) result(lower)
      character(len=*), intent(in) :: text
      character(len=len(text)) :: lower
      integer :: i
      lower = text
      do i = 1, len(text)
         if (text(i:i) >= 'A' .and. text(i:i) <= 'Z') lower(i:i) = achar(iachar(text(i:i)) + 32)
      end do
   end function lower_case

   !> Returns the names in a comma separated list; shape (number of names).
   pure function split_list(list) result(names)
      character(len=*), intent(in) :: list
      character(len=name_length), allocatable :: names(:)
      integer :: i, first, width

      allocate (names(count([(list(i:i) == ',', i=1, len(list))]) + merge(1, 0, list /= '')))
      first = 1
      do i = 1, size(names)
         width = index(list(first:)//',', ',') - 1
         names(i) = list(first:first + width - 1)
         first = first + width + 1
      end do
   end function split_list

   !> Returns names as a comma separated list, without blanks: the form of `key_t%choices`.
   pure function joined(names) result(list)
      character(len=*), intent(in) :: names(:)
      character(len=:), allocatable :: list
      integer :: i
      list = ''
      do i = 1, size(names)
         if (i > 1) list = list//','
         list = list//trim(names(i))
      end do
   end function joined

   !> Returns names as `a, b, c`.
   pure function comma_list(names) result(text)
      character(len=*), intent(in) :: names(:)
      character(len=:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, size(names)
         if (i > 1) text = text//', '
         text = text//trim(names(i))
      end do
   end function comma_list

   !> Returns the names of a list, each once, in the order of their first position.
   pure function distinct(names) result(once)
      character(len=*), intent(in) :: names(:)
      character(len=len(names)), allocatable :: once(:)
      logical :: new(size(names))
      integer :: i
      do i = 1, size(names)
         new(i) = .not. any(names(1:i - 1) == names(i))
      end do
      once = pack(names, new)
   end function distinct

   !> Returns true if a name is in a comma separated list.
   pure logical function is_listed(name, list)
      character(len=*), intent(in) :: name, list
      is_listed = .false.
      if (len_trim(name) <= name_length) is_listed = any(split_list(list) == name)
   end function is_listed

   !> Returns the known name that a former, misspelt or shortened one probably means; blank if none is near.
   pure function nearest_name(name, known) result(nearest)
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: known(:)
      character(len=:), allocatable :: nearest
      ! On the stack, whatever the length of the name.
      character(len=min(len_trim(name), 2*name_length)) :: word
      integer :: i, distance, least

      nearest = ''
      if (len_trim(name) > 2*name_length) return
      word = lower_case(trim(name))
      i = place_of_former(word, known)
      if (i == 0) i = only_beginning(word, known)
      if (i > 0) then
         nearest = trim(known(i))
         return
      end if
      ! A third of the letters may be wrong, and always one.
      least = max(2, (len(word) + 2)/3 + 1)
      do i = 1, size(known)
         distance = edit_distance(word, trim(known(i)))
         if (distance >= least .or. distance >= len_trim(known(i))) cycle
         least = distance
         nearest = trim(known(i))
      end do
   end function nearest_name

   !> Returns the known name that a former name became; blank for any other name.
   pure function new_name(name, known) result(new)
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: known(:)
      character(len=:), allocatable :: new
      integer :: i
      new = ''
      i = place_of_former(lower_case(trim(name)), known)
      if (i > 0) new = trim(known(i))
   end function new_name

   !> Returns the index of the known name that a former name became, both with the same number behind; 0 if there is
   !> none.
   pure integer function place_of_former(word, known) result(place)
      character(len=*), intent(in) :: word
      character(len=*), intent(in) :: known(:)
      integer :: i, k, last
      place = 0
      last = verify(word, '0123456789', back=.true.)
      do k = 1, size(former_names, 2)
         if (former_names(1, k) /= word(:last)) cycle
         do i = 1, size(known)
            if (known(i) == trim(former_names(2, k))//word(last + 1:)) place = i
         end do
      end do
   end function place_of_former

   !> Returns the index of the only known name that begins with a word of two letters or more, hyphens apart; 0 if there
   !> is none, or more than one.
   pure integer function only_beginning(word, known) result(place)
      character(len=*), intent(in) :: word
      character(len=*), intent(in) :: known(:)
      integer :: i
      place = 0
      if (len(word) - verify(word//'.', '-') + 1 < 2) return
      do i = 1, size(known)
         if (index(known(i), word) /= 1) cycle
         if (place > 0) then
            if (known(i) == known(place)) cycle
            place = 0
            return
         end if
         place = i
      end do
   end function only_beginning

   !> Returns the number of letters to insert, delete, replace or swap with their neighbour to change one word into
   !> another (optimal string alignment).
   pure integer function edit_distance(a, b) result(distance)
      character(len=*), intent(in) :: a, b
      integer :: table(-1:len(b), -1:len(a)), i, j, cost

      table = len(a) + len(b)
      table(0:, 0) = [(i, i=0, len(b))]
      table(0, 0:) = [(i, i=0, len(a))]
      do j = 1, len(a)
         do i = 1, len(b)
            cost = merge(0, 1, a(j:j) == b(i:i))
            table(i, j) = min(table(i - 1, j) + 1, table(i, j - 1) + 1, table(i - 1, j - 1) + cost)
            if (i == 1 .or. j == 1) cycle
            if (a(j:j) == b(i - 1:i - 1) .and. a(j - 1:j - 1) == b(i:i)) &
               table(i, j) = min(table(i, j), table(i - 2, j - 2) + 1)
         end do
      end do
      distance = table(len(b), len(a))
   end function edit_distance

end module nutate_spelling
