!> Random numbers: the published answers of Philox, the quantile of the normal distribution, permutations, and the
!> statistics of what is drawn, at fixed seeds.
submodule(suites_of_interfaces) test_random
   use nutate_kinds, only: wp, eps, long
   use nutate_normal_quantile, only: normal_quantile, plain_log
   use nutate_permutation, only: permuted
   use nutate_philox, only: DRAW, PERMUTATION, philox4x32, uniform_of
   use test_statistics, only: chi_square, distance_to_uniform
   use test_support, only: check, check_below, error_type, new_unittest
   implicit none

   integer(long), parameter :: all_bits = int(z'FFFFFFFF', long)

contains

   module procedure collect_random
      testsuite = [ &
                  new_unittest("Philox gives the published answers", known_answers), &
                  new_unittest("a draw is a function of seed, member and number", draws_are_functions), &
                  new_unittest("uniform numbers are uniform, and neighbours independent", uniform_numbers), &
                  new_unittest("normal deviates have their quantile to round-off", quantiles), &
                  new_unittest("the logarithm without a C library is one", logarithms), &
                  new_unittest("permutations meet every place once, and differ", permutations)]
   end procedure collect_random

   !> The vectors of the authors' library Random123 for philox4x32 with ten rounds.
   subroutine known_answers(error)
      type(error_type), allocatable, intent(out) :: error
      integer(long) :: zero(4)
      zero = 0
      call check_words(error, philox4x32(zero, zero(1:2)), [int(z'6627E8D5', long), int(z'E169C58D', long), &
                                                            int(z'BC57AC4C', long), int(z'9B00DBD8', long)])
      call check_words(error, philox4x32(spread(all_bits, 1, 4), spread(all_bits, 1, 2)), &
                       [int(z'408F276D', long), int(z'41C83B0E', long), int(z'A20BC7C6', long), &
                        int(z'6D5451FD', long)])
      call check_words(error, philox4x32([int(z'243F6A88', long), int(z'85A308D3', long), int(z'13198A2E', long), &
                                          int(z'03707344', long)], [int(z'A4093822', long), int(z'299F31D0', long)]), &
                       [int(z'D16CFE09', long), int(z'94FDCCEB', long), int(z'5001E420', long), &
                        int(z'24126EA1', long)])
   end subroutine known_answers

   subroutine check_words(error, words, expected)
      type(error_type), allocatable, intent(inout) :: error
      integer(long), intent(in) :: words(4), expected(4)
      character(len=80) :: text
      write (text, '(4z9.8)') words
      call check(error, all(words == expected), 'other words: '//trim(text))
   end subroutine check_words

   !> Other seeds, members, numbers give other numbers, beyond 32 bits too; the words are those of their counter.
   subroutine draws_are_functions(error)
      type(error_type), allocatable, intent(out) :: error
      integer(long), parameter :: large = 2_long**32
      integer(long) :: words(4)
      real(wp) :: u(6)
      integer :: i
      u = [uniform_of(1_long, 1_long, 1), uniform_of(2_long, 1_long, 1), uniform_of(1_long, 2_long, 1), &
           uniform_of(1_long, 1_long, 2), uniform_of(1 + large, 1_long, 1), uniform_of(1_long, 1 + large, 1)]
      do i = 2, 6
         call check(error, all(abs(u(i) - u(:i - 1)) > 0.0_wp), 'two counters gave one number')
      end do
      words = philox4x32([5_long, 1_long, 3_long, DRAW], [7_long, 0_long])
      call check(error, int(uniform_of(7_long, 5 + large, 3)*large, long) == words(1), 'not the words of the counter')
      call check(error, any(words /= philox4x32([5_long, 1_long, 3_long, PERMUTATION], [7_long, 0_long])), &
                 'permutations and draws share numbers')
   end subroutine draws_are_functions

   subroutine uniform_numbers(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: n = 100000
      real(wp) :: u(n), v(n)
      integer :: i
      u = [(uniform_of(11_long, int(i, long), 1), i=1, n)]
      v = [(uniform_of(11_long, int(i, long), 2), i=1, n)]
      call check(error, all(u > 0.0_wp .and. u < 1.0_wp), 'a number is not between 0 and 1')
      ! 1.95 is passed once in a thousand; the seed stays.
      call check_below(error, distance_to_uniform(u), 1.95_wp, 'Kolmogorov-Smirnov, first draws')
      call check_below(error, distance_to_uniform(v), 1.95_wp, 'Kolmogorov-Smirnov, second draws')
      ! 99 degrees of freedom: 148 is passed once in a thousand.
      call check_below(error, chi_square(u, v), 148.0_wp, 'chi-square of pairs')
      call check_below(error, chi_square(u(1:n:2), u(2:n:2)), 148.0_wp, 'chi-square of neighbouring members')
   end subroutine uniform_numbers

   !> Compares with 40 digits by the inverse of erfc, in the middle, at the seams and far out.
   subroutine quantiles(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: p(7) = [0.6_wp, 0.925_wp, 0.9251_wp, 0.975_wp, 1e-3_wp, 1.3e-11_wp, 2.0_wp**(-53)]
      real(wp), parameter :: z(7) = [0.2533471031357997413246887_wp, 1.43953147093845622906332_wp, &
                                 1.440238267527963859387731_wp, 1.959963984540053855604431_wp, &
                                 -3.090232306167813535358005_wp, -6.667611456510740834662219_wp, &
                                 -8.209536151601386855630769_wp]
      integer :: i
      do i = 1, size(p)
         call check_below(error, abs(normal_quantile(p(i))/z(i) - 1), 8*eps, 'a quantile')
      end do
      call check(error, abs(normal_quantile(0.5_wp)) <= 0.0_wp, 'the median is not zero')
      call check(error, abs(normal_quantile(0.25_wp) + normal_quantile(0.75_wp)) <= 0.0_wp, 'not symmetric')
   end subroutine quantiles

   subroutine logarithms(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: x
      integer :: i
      do i = 1, 2000
         x = 2.0_wp**(-53*uniform_of(3_long, int(i, long), 1))
         call check_below(error, abs(plain_log(x) - log(x)), 2*eps*max(abs(log(x)), 0.1_wp), 'a logarithm')
      end do
   end subroutine logarithms

   subroutine permutations(error)
      type(error_type), allocatable, intent(out) :: error
      integer(long), parameter :: sizes(5) = [1_long, 2_long, 17_long, 64_long, 1000_long]
      integer :: i, k
      logical :: met(1000)
      do i = 1, size(sizes)
         met = .false.
         do k = 1, int(sizes(i))
            met(permuted(int(k, long), sizes(i), 5_long, 1)) = .true.
         end do
         call check(error, count(met) == sizes(i) .and. all(met(:sizes(i))), 'a place is met twice, or never')
      end do
      call check(error, count([(permuted(int(k, long), 1000_long, 5_long, 1) == &
                                permuted(int(k, long), 1000_long, 5_long, 2), k=1, 1000)]) < 10, 'they are alike')
   end subroutine permutations

end submodule test_random
