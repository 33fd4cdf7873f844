!> The vocabulary of a scene: the keys of each group, the numbers that they admit, and the values that a scene gives
!> them.
!>
!> Every part of the library that a scene can use publishes its keys as a table of `key_t` and is built from a
!> `group_t`, so that a new effect brings its own keys along and the scene reader stays as it is. Code that gets the
!> numbers of a key from elsewhere than a scene checks them with the same key.
module nutate_keys
   use nutate_admissible, only: fault_of, fault_together, kind_in_words, ANY_VALUE
   use nutate_kinds, only: wp, long
   implicit none
   private

   public :: key_t, value_t, setting_t, table_t, group_t, group_kind_t, first_group, name_length
   public :: KEY_REAL, KEY_INTEGER, KEY_LOGICAL, KEY_TEXT

   !> Longest name of a group or key.
   integer, parameter :: name_length = 32

   !> A real number or several.
   integer, parameter :: KEY_REAL = 1
   !> A whole number.
   integer, parameter :: KEY_INTEGER = 2
   !> `.true.` or `.false.`.
   integer, parameter :: KEY_LOGICAL = 3
   !> Quoted text.
   integer, parameter :: KEY_TEXT = 4

   !> One key of a group.
   type :: key_t
      character(len=name_length) :: name = ''
      !> `KEY_REAL`, `KEY_INTEGER`, `KEY_LOGICAL` or `KEY_TEXT`.
      integer :: kind = KEY_REAL
      !> Least number of values.
      integer :: least = 1
      !> Greatest number of values.
      integer :: most = 1
      !> `ANY_VALUE`, ... of `nutate_admissible`: what the numbers may be.
      integer :: range = ANY_VALUE
      !> The group is incomplete without this key.
      logical :: required = .false.
      !> Admissible texts, comma separated, for a key that names a choice; blank: any text.
      character(len=1600) :: choices = ''
      !> Keys with the same meaning, comma separated: set from the command line, this key takes their place.
      character(len=48) :: instead_of = ''
      !> Value of the key if it is absent, as a scene would write it, for reports on scenes; blank: not reported.
      character(len=20) :: default = ''
      !> The default holds beside one of these keys, comma separated; blank: always.
      character(len=48) :: beside = ''
   contains
      !> Returns what is wrong with one of the key's numbers, or with all together, in words; empty if nothing is.
      procedure, non_overridable :: fault => fault_of_one
      procedure, non_overridable :: fault_of_all
      !> Returns which numbers the key expects, in words: `3 numbers > 0`.
      procedure, non_overridable :: expected_numbers
   end type key_t

   !> One value: the component of the key's kind is set.
   type :: value_t
      real(wp) :: number = 0.0_wp
      integer :: whole = 0
      logical :: flag = .false.
      character(len=:), allocatable :: text
   end type value_t

   !> A key with the values that a scene gives it.
   type :: setting_t
      character(len=name_length) :: name = ''
      !> Line of the file where the key stands; 0 for one given on the command line.
      integer :: line = 0
      !> `KEY_REAL`, ...: which component of the values is set.
      integer :: kind = KEY_REAL
      type(value_t), allocatable :: values(:)
   end type setting_t

   !> The numbers of a file that a group names.
   type :: table_t
      !> Shape (columns, lines).
      real(wp), allocatable :: numbers(:, :)
      !> Checksum of the bytes of the file.
      integer(long) :: checksum = 0
   end type table_t

   !> One group of a scene, its values already checked against the group's keys.
   type :: group_t
      character(len=name_length) :: name = ''
      !> Line of the file where the group starts.
      integer :: line = 0
      type(setting_t), allocatable :: settings(:)
      !> Table that the key `table` of the group names; not allocated if there is none, or if it has not been read.
      type(table_t), allocatable :: table
      !> Table of the path of the centre of mass of &body, likewise.
      type(table_t), allocatable :: center_table
   contains
      !> Returns true if the scene gives this key.
      procedure, non_overridable :: has
      !> Returns the line of a key, or of the group if the key is absent.
      procedure, non_overridable :: line_of
      !> Returns the first number of a key, or the default.
      procedure, non_overridable :: number
      !> Returns the first `size(default)` numbers of a key, or the default.
      procedure, non_overridable :: vector
      !> Returns the integer of a key, or the default.
      procedure, non_overridable :: whole
      !> Returns the boolean of a key, or the default.
      procedure, non_overridable :: flag
      !> Returns the first string of a key, or the default.
      procedure, non_overridable :: text
      !> Returns one of the strings of a key that is present.
      procedure, non_overridable :: text_at
      !> Returns the number of values of a key; 0 if it is absent.
      procedure, non_overridable :: count_of
      !> Puts a key behind the others, in place of one of the same name.
      generic :: put => put_setting, put_numbers, put_text
      procedure, private :: put_setting, put_numbers, put_text
      !> Removes a key, if it is there.
      procedure, non_overridable :: drop
   end type group_t

   !> Properties of a kind of group, for the scene reader.
   type :: group_kind_t
      character(len=name_length) :: name = ''
      !> The group may occur several times.
      logical :: repeatable = .false.
      !> A scene without the group is incomplete.
      logical :: required = .false.
      type(key_t), allocatable :: keys(:)
   end type group_kind_t

contains

   !> Returns what is wrong with a number: `is too large (expected 1e-100 to 1e100 for mass)`.
   pure function fault_of_one(self, number) result(words)
      class(key_t), intent(in) :: self
      real(wp), intent(in) :: number
      character(len=:), allocatable :: words
      words = fault_of(self%range, number, self%expected_numbers())
      if (words /= '') words = words//' for '//trim(self%name)//')'
   end function fault_of_one

   !> Returns what is wrong with numbers none of which is at fault: `is zero (expected 3 numbers, not zero)`.
   pure function fault_of_all(self, numbers) result(words)
      class(key_t), intent(in) :: self
      real(wp), intent(in) :: numbers(:)
      character(len=:), allocatable :: words
      words = fault_together(self%range, numbers, self%expected_numbers())
      if (words /= '') words = words//')'
   end function fault_of_all

   pure function expected_numbers(self) result(words)
      class(key_t), intent(in) :: self
      character(len=:), allocatable :: words
      character(len=12) :: count
      words = 'number'
      if (self%kind == KEY_INTEGER) words = 'whole number'
      if (self%most == 1) then
         words = 'a '//words//kind_in_words(self%range)
         return
      end if
      write (count, '(i0)') self%most
      if (self%least < self%most) write (count, '(i0," to ",i0)') self%least, self%most
      words = trim(count)//' '//words//'s'//kind_in_words(self%range)
   end function expected_numbers

   !> Returns the position of a key among the settings; 0 if it is absent.
   pure integer function find(self, name)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: name
      find = 0
      if (.not. allocated(self%settings) .or. len(name) == 0) return
      do find = size(self%settings), 1, -1
         ! Most names differ in their first letter: members of ensembles look up many.
         if (self%settings(find)%name(1:1) /= name(1:1)) cycle
         if (self%settings(find)%name == name) return
      end do
   end function find

   pure logical function has(self, name)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: name
      has = find(self, name) > 0
   end function has

   pure integer function line_of(self, name)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: name
      integer :: i
      i = find(self, name)
      line_of = self%line
      if (i > 0) line_of = self%settings(i)%line
   end function line_of

   pure integer function count_of(self, name)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: name
      integer :: i
      i = find(self, name)
      count_of = 0
      if (i > 0) count_of = size(self%settings(i)%values)
   end function count_of

   pure real(wp) function number(self, name, default)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: default
      integer :: i
      i = find(self, name)
      number = default
      if (i > 0) number = self%settings(i)%values(1)%number
   end function number

   pure function vector(self, name, default)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: default(:)
      real(wp) :: vector(size(default))
      integer :: i
      i = find(self, name)
      vector = default
      if (i > 0) vector = self%settings(i)%values(1:size(default))%number
   end function vector

   pure integer function whole(self, name, default)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: name
      integer, intent(in) :: default
      integer :: i
      i = find(self, name)
      whole = default
      if (i > 0) whole = self%settings(i)%values(1)%whole
   end function whole

   pure logical function flag(self, name, default)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: name
      logical, intent(in) :: default
      integer :: i
      i = find(self, name)
      flag = default
      if (i > 0) flag = self%settings(i)%values(1)%flag
   end function flag

   pure function text(self, name, default)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: name, default
      character(len=:), allocatable :: text
      integer :: i
      i = find(self, name)
      text = default
      if (i > 0) text = self%settings(i)%values(1)%text
   end function text

   pure function text_at(self, name, at) result(text)
      class(group_t), intent(in) :: self
      character(len=*), intent(in) :: name
      !> Index of the string among the values of the key: 1 to `count_of(name)`.
      integer, intent(in) :: at
      character(len=:), allocatable :: text
      text = self%settings(find(self, name))%values(at)%text
   end function text_at

   !> Puts a key. Settings are copied one by one: gfortran 12 loses the components of what it puts into an array
   !> constructor.
   subroutine put_setting(self, setting)
      class(group_t), intent(inout) :: self
      type(setting_t), intent(in) :: setting
      type(setting_t), allocatable :: settings(:)
      integer :: i, n
      call self%drop(trim(setting%name))
      n = 0
      if (allocated(self%settings)) n = size(self%settings)
      allocate (settings(n + 1))
      do i = 1, n
         settings(i) = self%settings(i)
      end do
      settings(n + 1) = setting
      call move_alloc(settings, self%settings)
   end subroutine put_setting

   !> Puts a key of real numbers, if they are present.
   subroutine put_numbers(self, name, values)
      class(group_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      real(wp), intent(in), optional :: values(:)
      type(setting_t) :: setting
      if (.not. present(values)) return
      setting%name = name
      allocate (setting%values(size(values)))
      setting%values%number = values
      call self%put(setting)
   end subroutine put_numbers

   !> Puts a key of one string.
   subroutine put_text(self, name, text)
      class(group_t), intent(inout) :: self
      character(len=*), intent(in) :: name, text
      type(setting_t) :: setting
      setting%name = name
      setting%kind = KEY_TEXT
      allocate (setting%values(1))
      setting%values(1)%text = text
      call self%put(setting)
   end subroutine put_text

   !> Returns the first group of a name; a group without keys if there is none.
   pure function first_group(groups, name) result(group)
      type(group_t), intent(in) :: groups(:)
      character(len=*), intent(in) :: name
      type(group_t) :: group
      integer :: i
      i = findloc(groups%name, name, dim=1)
      if (i > 0) group = groups(i)
   end function first_group

   subroutine drop(self, name)
      class(group_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      type(setting_t), allocatable :: kept(:)
      integer :: i, n
      if (.not. self%has(name)) return
      allocate (kept(count(self%settings%name /= name)))
      n = 0
      do i = 1, size(self%settings)
         if (self%settings(i)%name == name) cycle
         n = n + 1
         kept(n) = self%settings(i)
      end do
      call move_alloc(kept, self%settings)
   end subroutine drop

end module nutate_keys
