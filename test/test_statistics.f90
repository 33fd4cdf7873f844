!> Statistics of samples, for tests of what is drawn at random.
module test_statistics
   use nutate_kinds, only: wp
   implicit none
   private

   public :: chi_square, distance_to_uniform, normal_probability

contains

   !> √n times the largest distance between the distribution of a sample and the uniform one (Kolmogorov, Smirnov).
   function distance_to_uniform(sample) result(distance)
      !> Between 0 and 1.
      real(wp), intent(in) :: sample(:)
      real(wp) :: distance
      real(wp) :: least(0:size(sample)), greatest(0:size(sample))
      real(wp) :: below
      integer :: counts(0:size(sample)), i, k, n
      n = size(sample)
      ! Sorted into n + 1 classes, of which the ends alone count.
      counts = 0
      least = 2.0_wp
      greatest = -1.0_wp
      do i = 1, n
         k = int(n*sample(i))
         counts(k) = counts(k) + 1
         least(k) = min(least(k), sample(i))
         greatest(k) = max(greatest(k), sample(i))
      end do
      distance = 0.0_wp
      below = 0.0_wp
      do k = 0, n
         if (counts(k) == 0) cycle
         distance = max(distance, abs(least(k) - below/n))
         below = below + counts(k)
         distance = max(distance, abs(greatest(k) - below/n))
      end do
      distance = distance*sqrt(real(n, wp))
   end function distance_to_uniform

   !> χ² of pairs over 10 × 10 equal squares: 99 degrees of freedom.
   function chi_square(x, y) result(sum_of_squares)
      !> Between 0 and 1.
      real(wp), intent(in) :: x(:), y(:)
      real(wp) :: sum_of_squares
      integer :: counts(0:9, 0:9), i
      counts = 0
      do i = 1, size(x)
         associate (c => counts(int(10*x(i)), int(10*y(i))))
            c = c + 1
         end associate
      end do
      sum_of_squares = sum((counts - size(x)/100.0_wp)**2)/(size(x)/100.0_wp)
   end function chi_square

   !> Probability that a normal deviate is below z.
   elemental real(wp) function normal_probability(z)
      real(wp), intent(in) :: z
      normal_probability = erfc(-z/sqrt(2.0_wp))/2
   end function normal_probability

end module test_statistics
