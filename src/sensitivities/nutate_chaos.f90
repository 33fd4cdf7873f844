!> Indicators of chaos: Lyapunov exponents, MEGNO and the fast Lyapunov indicator, from sensitivities that a run
!> propagates. The sensitivities are orthonormalised at the end of steps, so that no motion is too long for them.
module nutate_chaos
   use nutate_archive, only: archive_t
   use nutate_chaos_settings, only: chaos_settings_t, longest_interval, most_exponents
   use nutate_hamiltonian, only: body_momentum, system_t
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_NOT_FINITE
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: chaos_t

   !> Components below this are set to 0, units of the sensitivity: blocks of the sensitivities that do not couple
   !> would end as denormal numbers, which are slow.
   real(wp), parameter :: negligible = 1e-150_wp

   !> Indicators so far: their sensitivities are the last `n` of a tangent.
   type :: chaos_t
      !> Number of exponents.
      integer :: n = 0
      !> Time from the start to the last sample, s, positive.
      real(wp) :: time = 0.0_wp
      integer, private :: every = 1, steps = 0
      !> Initial time, s, and scale of momentum, N m s.
      real(wp), private :: t_first = 0.0_wp, scale = 1.0_wp
      !> Logarithms of the growth of each sensitivity since the start, the first the largest so far of the first
      !> sensitivity; shape (6).
      real(wp), private :: growth(most_exponents) = 0.0_wp, largest = 0.0_wp
      !> Sums of MEGNO: over t·d ln |X|, s, and over its value times dt, s.
      real(wp), private :: weighted = 0.0_wp, area = 0.0_wp
   contains
      !> Sets the sensitivities at the initial state.
      procedure, non_overridable :: begin
      !> Follows the sensitivities over a step.
      procedure, non_overridable :: follow
      !> Return the indicators up to the last sample.
      procedure, non_overridable :: lyapunov
      procedure, non_overridable :: megno
      procedure, non_overridable :: fli
      !> Writes or reads its values in checkpoint data.
      procedure, non_overridable :: transfer
   end type chaos_t

contains

   !> Sets the last sensitivities of a tangent, one for each exponent: the first is `vector`, the others are unit
   !> vectors, orthonormalised. Errors: `NUTATE_BAD_ARGUMENT` for settings out of range, for more exponents than
   !> sensitivities, and for a body at rest without a scale of momentum.
   subroutine begin(self, settings, system, state, tangent, status)
      class(chaos_t), intent(out) :: self
      type(chaos_settings_t), intent(in) :: settings
      type(system_t), intent(in) :: system
      !> Initial state.
      type(state_t), intent(in) :: state
      !> Tangent after `begin`.
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(out) :: status
      real(wp) :: vectors(most_exponents, most_exponents), logs(most_exponents)
      integer :: i, k
      if (settings%exponents < 1 .or. settings%exponents > min(most_exponents, tangent%n) .or. settings%every < 1 .or. &
          settings%every > longest_interval .or. &
          .not. (is_moderate(settings%momentum_scale) .and. settings%momentum_scale >= 0.0_wp) .or. &
          .not. (all(is_moderate(settings%vector)) .and. any(abs(settings%vector) > 0.0_wp))) then
         status = fail(NUTATE_BAD_ARGUMENT, 'settings of chaos are out of range (expected 1 to 6 exponents, '// &
                       'every of 1 to 100, momentum_scale >= 0 and a vector that is not zero)', 'exponents')
         return
      end if
      self%n = settings%exponents
      self%every = settings%every
      self%t_first = state%t
      self%scale = settings%momentum_scale
      if (.not. self%scale > 0.0_wp) self%scale = norm2(body_momentum(state))
      if (.not. self%scale > 0.0_wp) then
         status = fail(NUTATE_BAD_ARGUMENT, 'a body at rest has no scale of momentum (expected momentum_scale in '// &
                       '&chaos)', 'momentum_scale')
         return
      end if
      vectors = 0.0_wp
      vectors(:, 1) = settings%vector/maxval(abs(settings%vector))
      k = 1
      do i = 1, most_exponents
         if (i == maxloc(abs(settings%vector), 1)) cycle
         k = k + 1
         vectors(i, k) = 1.0_wp
      end do
      do k = 1, self%n
         i = tangent%n - self%n + k
         tangent%theta(i, :) = vectors(:3, k)
         tangent%momentum(i, :) = self%scale*vectors(4:, k)
         tangent%wheels(i, :) = 0.0_wp
      end do
      call orthonormalise(self, system, state, tangent, logs, status)
   end subroutine begin

   !> Follows the sensitivities over a step that was accepted; after every so many of them orthonormalises them and
   !> takes a sample of the sums. Errors: `NUTATE_NOT_FINITE` for a sensitivity that vanishes or overflows.
   !>
   !> MEGNO is Y(t) = (2/t) ∫ t' d ln|X|, its mean (1/t) ∫ Y dt' (Cincotta & Simó, Astron. Astrophys. Suppl. 147, 2000);
   !> exponents by Gram-Schmidt (Benettin et al., Meccanica 15, 1980).
   subroutine follow(self, system, state, tangent, status)
      class(chaos_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> State at the end of the step.
      type(state_t), intent(in) :: state
      type(tangent_t), intent(inout) :: tangent
      !> Status, success on entry.
      type(status_t), intent(inout) :: status
      real(wp) :: logs(most_exponents), time, dt
      if (self%n == 0) return
      self%steps = self%steps + 1
      if (self%steps < self%every) return
      self%steps = 0
      call orthonormalise(self, system, state, tangent, logs, status)
      if (status%code /= 0) return
      time = abs(state%t - self%t_first)
      dt = time - self%time
      self%growth(:self%n) = self%growth(:self%n) + logs(:self%n)
      self%largest = max(self%largest, self%growth(1))
      self%weighted = self%weighted + (time - 0.5_wp*dt)*logs(1)
      self%area = self%area + (2*self%weighted/time)*dt
      self%time = time
   end subroutine follow

   !> Orthonormalises the sensitivities by modified Gram-Schmidt. Errors: `NUTATE_NOT_FINITE`.
   subroutine orthonormalise(self, system, state, tangent, logs, status)
      class(chaos_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(tangent_t), intent(inout) :: tangent
      !> Logarithm of the length of each sensitivity, without its parts along the ones before; shape (6).
      real(wp), intent(out) :: logs(most_exponents)
      type(status_t), intent(inout) :: status
      real(wp) :: largest, square
      integer :: first, i, k
      first = tangent%n - self%n
      logs = 0.0_wp
      do k = first + 1, first + self%n
         largest = max(maxval(abs(tangent%theta(k, :))), maxval(abs(tangent%momentum(k, :)))/self%scale)
         if (size(tangent%wheels, 2) > 0) largest = max(largest, maxval(abs(tangent%wheels(k, :)))/self%scale)
         if (.not. (largest > tiny(largest) .and. largest < 1/tiny(largest))) then
            status = fail(NUTATE_NOT_FINITE, 'a sensitivity vanishes or overflows (expected a smaller every in '// &
                          '&chaos)', 'every')
            return
         end if
         ! The vector is scaled by a power of 2 first, so that no square overflows.
         call scale_deviation(tangent, k, scale(1.0_wp, -exponent(largest)), self%scale)
         do i = first + 1, k - 1
            call add_column(tangent, k, i, -product_of(self, tangent, i, k))
         end do
         square = max(product_of(self, tangent, k, k), tiny(square))
         call scale_deviation(tangent, k, 1/sqrt(square), self%scale)
         logs(k - first) = 0.5_wp*log(square) + exponent(largest)*log(2.0_wp)
      end do
      call renew_targets(system, state, first, tangent)
   end subroutine orthonormalise

   !> Sets the targets of projections to the present rows. As linear functions of the sensitivities they would keep the
   !> round-off of all earlier steps, which grows as the ratio of the longest to the shortest sensitivity.
   pure subroutine renew_targets(system, state, first, tangent)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Number of sensitivities before those of the indicators.
      integer, intent(in) :: first
      type(tangent_t), intent(inout) :: tangent
      real(wp) :: energy(tangent%n), momentum(tangent%n, 3)
      energy = tangent%energy_row(system, state)
      momentum = tangent%momentum_row(state)
      tangent%energy(first + 1:) = energy(first + 1:)
      tangent%space_momentum(first + 1:, :) = momentum(first + 1:, :)
      tangent%work(first + 1:) = 0.0_wp
   end subroutine renew_targets

   !> Returns the scalar product of two sensitivities, with momenta in units of the scale.
   pure real(wp) function product_of(self, tangent, i, k) result(s)
      class(chaos_t), intent(in) :: self
      type(tangent_t), intent(in) :: tangent
      integer, intent(in) :: i, k
      s = dot_product(tangent%theta(i, :), tangent%theta(k, :)) &
          + dot_product(tangent%momentum(i, :)/self%scale, tangent%momentum(k, :)/self%scale) &
          + dot_product(tangent%wheels(i, :)/self%scale, tangent%wheels(k, :)/self%scale)
   end function product_of

   !> Adds a multiple of sensitivity i to sensitivity k.
   pure subroutine add_column(tangent, k, i, factor)
      type(tangent_t), intent(inout) :: tangent
      integer, intent(in) :: k, i
      real(wp), intent(in) :: factor
      tangent%theta(k, :) = tangent%theta(k, :) + factor*tangent%theta(i, :)
      tangent%momentum(k, :) = tangent%momentum(k, :) + factor*tangent%momentum(i, :)
      tangent%wheels(k, :) = tangent%wheels(k, :) + factor*tangent%wheels(i, :)
   end subroutine add_column

   !> Multiplies a sensitivity, and sets its negligible components to 0.
   pure subroutine scale_deviation(tangent, k, factor, unit)
      type(tangent_t), intent(inout) :: tangent
      integer, intent(in) :: k
      real(wp), intent(in) :: factor
      !> Scale of momentum, N m s.
      real(wp), intent(in) :: unit
      tangent%theta(k, :) = without_dust(factor*tangent%theta(k, :), negligible)
      tangent%momentum(k, :) = without_dust(factor*tangent%momentum(k, :), negligible*unit)
      tangent%wheels(k, :) = without_dust(factor*tangent%wheels(k, :), negligible*unit)
   end subroutine scale_deviation

   !> Returns a component, or 0 for one below a limit.
   elemental real(wp) function without_dust(x, least)
      real(wp), intent(in) :: x, least
      without_dust = merge(x, 0.0_wp, abs(x) > least)
   end function without_dust

   !> Returns the Lyapunov exponents, the mean growth rates of the sensitivities, 1/s; zeros before the first sample.
   !> Shape (number of exponents).
   pure function lyapunov(self) result(rates)
      class(chaos_t), intent(in) :: self
      real(wp) :: rates(self%n)
      rates = 0.0_wp
      if (self%time > 0.0_wp) rates = self%growth(:self%n)/self%time
   end function lyapunov

   !> Returns the mean MEGNO of the first sensitivity: tends to 2 for regular motion, to λt/2 for chaotic.
   pure real(wp) function megno(self)
      class(chaos_t), intent(in) :: self
      megno = 0.0_wp
      if (self%time > 0.0_wp) megno = self%area/self%time
   end function megno

   !> Returns the fast Lyapunov indicator, the largest ln |X| of the first sensitivity so far (Froeschlé, Lega & Gonczi,
   !> Celest. Mech. Dyn. Astron. 67, 1997); at least 0.
   pure real(wp) function fli(self)
      class(chaos_t), intent(in) :: self
      fli = self%largest
   end function fli

   !> Writes or reads its values in checkpoint data.
   subroutine transfer(self, archive)
      !> Indicators begun with the same settings.
      class(chaos_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%time)
      call archive%transfer(self%steps)
      call archive%transfer(self%growth)
      call archive%transfer(self%largest)
      call archive%transfer(self%weighted)
      call archive%transfer(self%area)
   end subroutine transfer

end module nutate_chaos
