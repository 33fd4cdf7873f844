!> Archives give back every bit, and notice when they are asked for something else than they hold.
submodule(suites_of_runs) test_archive
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_archive, only: archive_t
   use nutate_byte_archive, only: byte_archive_t
   use nutate_checksum, only: checksum
   use nutate_kinds, only: wp, long
   use nutate_number_archive, only: number_archive_t
   use test_support, only: check, error_type, new_unittest
   implicit none

   !> One value of each kind.
   type :: sample_t
      real(wp) :: number = 0.0_wp, vector(3) = 0.0_wp, matrix(2, 3) = 0.0_wp
      integer :: whole = 0
      integer(long) :: count = 0
      logical :: flag = .false.
      character(len=:), allocatable :: text
   end type sample_t

contains

   module procedure collect_archive
      testsuite = [ &
                  new_unittest("every kind of value comes back", every_kind_comes_back), &
                  new_unittest("every bit of a number comes back", every_bit_comes_back), &
                  new_unittest("another kind or size is noticed", another_kind_or_size_is_noticed), &
                  new_unittest("an archive cut short is noticed anywhere", cut_short_is_noticed), &
                  new_unittest("what cannot be archived is told", refusal_is_told), &
                  new_unittest("numbers in an array come back", numbers_come_back), &
                  new_unittest("an array too short is noticed", short_arrays_are_noticed), &
                  new_unittest("the checksum is that of the standard", checksum_is_that_of_the_standard), &
                  new_unittest("the checksum sees every flipped bit", checksum_sees_every_flipped_bit)]
   end procedure collect_archive

   subroutine transfer_sample(archive, sample)
      class(archive_t), intent(inout) :: archive
      type(sample_t), intent(inout) :: sample
      call archive%transfer(sample%number)
      call archive%transfer(sample%vector)
      call archive%transfer(sample%matrix)
      call archive%transfer(sample%whole)
      call archive%transfer(sample%count)
      call archive%transfer(sample%flag)
      call archive%transfer(sample%text)
   end subroutine transfer_sample

   !> The bytes of a sample whose values all differ from the initial ones.
   subroutine fill(sample, bytes)
      type(sample_t), intent(out) :: sample
      character(len=:), allocatable, intent(out) :: bytes
      type(byte_archive_t) :: archive
      sample%number = 0.1_wp
      sample%vector = [1.0_wp, -2.0_wp, 3.0_wp]/7
      sample%matrix = reshape([1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp, 5.0_wp, 6.0_wp], [2, 3])/11
      sample%whole = -17
      sample%count = 12345678901234_long
      sample%flag = .true.
      sample%text = 'ends with blanks  '//achar(0)
      call archive%begin_writing()
      call transfer_sample(archive, sample)
      bytes = archive%content()
   end subroutine fill

   subroutine every_kind_comes_back(error)
      type(error_type), allocatable, intent(out) :: error
      type(sample_t) :: sample, back
      type(byte_archive_t) :: archive
      character(len=:), allocatable :: bytes
      call fill(sample, bytes)
      call archive%begin_reading(bytes)
      call transfer_sample(archive, back)
      call check(error, archive%problem() == '')
      call check(error, abs(back%number - sample%number) <= 0.0_wp .and. &
                 all(abs(back%vector - sample%vector) <= 0.0_wp) .and. &
                 all(abs(back%matrix - sample%matrix) <= 0.0_wp), "reals")
      call check(error, back%whole == sample%whole .and. back%count == sample%count .and. back%flag, "the others")
      call check(error, back%text == sample%text .and. len(back%text) == len(sample%text), "text")
   end subroutine every_kind_comes_back

   !> Negative zero, the least denormal, infinity and a signalling NaN, without an exception.
   subroutine every_bit_comes_back(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64), parameter :: patterns(5) = [ &
         ishft(1_int64, 63), 1_int64, int(z'7FF0000000000000', int64), int(z'7FF0000000000001', int64), &
         int(z'3FF0000000000001', int64)]
      real(wp) :: values(5), back(5)
      type(byte_archive_t) :: archive
      character(len=:), allocatable :: bytes
      values = transfer(patterns, values)
      back = 0.0_wp
      call archive%begin_writing()
      call archive%transfer(values)
      bytes = archive%content()
      call archive%begin_reading(bytes)
      call archive%transfer(back)
      ! The bits are compared with `values`: a compiler that makes the NaN itself may have quietened it.
      call check(error, all(transfer(back, patterns) == transfer(values, patterns)))
   end subroutine every_bit_comes_back

   subroutine another_kind_or_size_is_noticed(error)
      type(error_type), allocatable, intent(out) :: error
      type(byte_archive_t) :: archive
      character(len=:), allocatable :: bytes
      real(wp) :: two(2), three(3), number
      integer(long) :: count
      two = [1.0_wp, 2.0_wp]
      three = 5.0_wp
      number = 3.0_wp
      count = 7
      call archive%begin_writing()
      call archive%transfer(two)
      call archive%transfer(number)
      bytes = archive%content()
      call archive%begin_reading(bytes)
      call archive%transfer(three)
      call check(error, archive%problem() /= '' .and. all(abs(three - 5) <= 0.0_wp), "size")
      call archive%begin_reading(bytes)
      call archive%transfer(two)
      call archive%transfer(count)
      call check(error, archive%problem() /= '' .and. count == 7, "kind")
      call archive%transfer(number)
      call check(error, archive%problem() /= '', "what has failed stays so")
   end subroutine another_kind_or_size_is_noticed

   subroutine cut_short_is_noticed(error)
      type(error_type), allocatable, intent(out) :: error
      type(sample_t) :: sample, back
      type(byte_archive_t) :: archive
      character(len=:), allocatable :: bytes
      integer :: i
      call fill(sample, bytes)
      do i = 0, len(bytes) - 1
         call archive%begin_reading(bytes(1:i))
         call transfer_sample(archive, back)
         call check(error, archive%problem() /= '')
      end do
   end subroutine cut_short_is_noticed

   subroutine refusal_is_told(error)
      type(error_type), allocatable, intent(out) :: error
      type(byte_archive_t) :: archive
      call archive%begin_writing()
      call archive%refuse('this cannot be kept')
      call check(error, archive%problem() == 'this cannot be kept')
      call archive%begin_writing()
      call check(error, archive%problem() == '')
   end subroutine refusal_is_told

   !> Transfers the data that a program may keep in an array of reals.
   subroutine transfer_numbers(archive, sample)
      class(archive_t), intent(inout) :: archive
      type(sample_t), intent(inout) :: sample
      call archive%transfer(sample%number)
      call archive%transfer(sample%matrix)
      call archive%transfer(sample%whole)
      call archive%transfer(sample%count)
      call archive%transfer(sample%flag)
   end subroutine transfer_numbers

   subroutine numbers_come_back(error)
      type(error_type), allocatable, intent(out) :: error
      type(number_archive_t) :: archive
      type(sample_t) :: sample, other
      character(len=:), allocatable :: bytes
      real(wp), target :: store(11)
      call fill(sample, bytes)
      call archive%begin_counting()
      call transfer_numbers(archive, sample)
      call check(error, archive%count(), 10)
      store = 7.0_wp
      call archive%begin_writing(store)
      call transfer_numbers(archive, sample)
      call archive%begin_reading(store)
      call transfer_numbers(archive, other)
      call check(error, archive%problem() == '' .and. store(11) == 7.0_wp .and. other%number == sample%number .and. &
                 all(other%matrix == sample%matrix) .and. other%whole == sample%whole .and. &
                 other%count == sample%count .and. (other%flag .eqv. sample%flag), 'values')
      call archive%transfer(sample%text)
      call check(error, archive%problem() /= '', 'a text is no number')
   end subroutine numbers_come_back

   subroutine short_arrays_are_noticed(error)
      type(error_type), allocatable, intent(out) :: error
      type(number_archive_t) :: archive
      type(sample_t) :: sample
      character(len=:), allocatable :: bytes
      real(wp), target :: store(9)
      call fill(sample, bytes)
      call archive%begin_writing(store)
      call transfer_numbers(archive, sample)
      call check(error, archive%problem() /= '', 'nine numbers do not hold ten')
   end subroutine short_arrays_are_noticed

   !> The catalogue's check value of CRC-64/XZ, in two halves; and nothing has checksum 0.
   subroutine checksum_is_that_of_the_standard(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64), parameter :: low = int(z'FFFFFFFF', int64)
      integer(int64) :: sum
      sum = checksum('123456789')
      call check(error, iand(ishft(sum, -32), low) == int(z'995DC9BB', int64) .and. &
                 iand(sum, low) == int(z'DF1939FA', int64))
      call check(error, checksum('') == 0_int64)
   end subroutine checksum_is_that_of_the_standard

   subroutine checksum_sees_every_flipped_bit(error)
      type(error_type), allocatable, intent(out) :: error
      type(sample_t) :: sample
      character(len=:), allocatable :: bytes, spoiled
      integer :: i, k
      call fill(sample, bytes)
      do i = 1, len(bytes)
         do k = 0, 7
            spoiled = bytes
            spoiled(i:i) = achar(ieor(ichar(bytes(i:i)), ishft(1, k)))
            call check(error, checksum(spoiled) /= checksum(bytes))
         end do
      end do
   end subroutine checksum_sees_every_flipped_bit

end submodule test_archive
