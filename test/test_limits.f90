!> Limits: every key at and just beyond its limits, as text, from C and from FORTRAN 77. All give the same verdict, and
!> it is the one that the documentation promises.
module test_limits
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan, ieee_positive_inf, ieee_quiet_nan, ieee_value
   use nutate_keys, only: group_kind_t, KEY_REAL
   use nutate_kinds, only: wp
   use nutate_scene, only: scene_kinds
   use test_limit_c, only: c_takes, c_takes_direction, c_takes_every
   use test_limit_f77, only: f77_takes, f77_takes_direction, f77_takes_energy, f77_takes_every
   use test_limit_text, only: number_text, setting_t, text_takes, text_takes_every
   use testdrive, only: check, error_type, new_unittest, test_failed, unittest_type
   implicit none
   private

   public :: collect_limits

   !> What a key admits in one of its numbers while the others stay: sizes from least to greatest, and what else.
   type :: promise_t
      type(setting_t) :: setting
      !> Which of the numbers is tried; 0: all of them together.
      integer :: which = 1
      real(wp) :: least = 1e-300_wp, greatest = 1e100_wp
      logical :: zero = .true., negative = .true., infinite = .false.
      !> A program carries the number from call to call, so that it may have decayed to any size: C and FORTRAN 77 take
      !> it below `least` too.
      logical :: carried = .false.
      !> C says by 0, FORTRAN 77 by 0 or a negative number, that it is not given.
      logical :: c_leaves_out = .false., f77_leaves_out = .false.
      !> C and FORTRAN 77 do not have it.
      logical :: text_only = .false.
      !> Without an end: C says so by infinity of this sign; 0: it has an end.
      integer :: c_open_end = 0
   end type promise_t

   !> Groups whose numbers text and C refuse in the same words.
   character(len=16), parameter :: one_voice(9) = [ &
                                   'body            ', 'gravity         ', 'dipole          ', 'gravity_gradient', &
                                   'spring          ', 'damping         ', 'torque          ', 'rotor           ', &
                                   'integrator      ']
   !> Verdicts shown of those that are wrong.
   integer, parameter :: most_shown = 20

contains

   subroutine collect_limits(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("bodies at their limits", bodies), &
                  new_unittest("potentials at their limits", potentials), &
                  new_unittest("torques and rotors at their limits", torques), &
                  new_unittest("starts at their limits", starts), &
                  new_unittest("settings at their limits", settings), &
                  new_unittest("events and variations at their limits", events), &
                  new_unittest("every key of a number is tried", all_keys), &
                  new_unittest("whole numbers at their limits", whole_numbers), &
                  new_unittest("motions and turns at their limits", motions), &
                  new_unittest("the strength of an effect does not depend on the attitude", strengths), &
                  new_unittest("a gravity gradient along (1e-150, 0, 0) is refused by every way", tiny_direction), &
                  new_unittest("callbacks at their limits", callbacks)]
   end subroutine collect_limits

   !> A key with the numbers that stay; one is any number.
   pure type(promise_t) function any_number(group, key, values, which) result(promise)
      character(len=*), intent(in) :: group, key
      real(wp), intent(in) :: values(:)
      integer, intent(in), optional :: which
      promise%setting%group = group
      promise%setting%key = key
      promise%setting%n = size(values)
      promise%setting%values(1:size(values)) = values
      if (present(which)) promise%which = which
   end function any_number

   !> The same for one that is a size: positive, and not negligible.
   pure type(promise_t) function positive(group, key, values, which, least, greatest) result(promise)
      character(len=*), intent(in) :: group, key
      real(wp), intent(in) :: values(:)
      integer, intent(in), optional :: which
      real(wp), intent(in), optional :: least, greatest
      promise = any_number(group, key, values, which)
      promise%zero = .false.
      promise%negative = .false.
      promise%least = 1e-100_wp
      if (present(least)) promise%least = least
      if (present(greatest)) promise%greatest = greatest
   end function positive

   subroutine bodies(error)
      type(error_type), allocatable, intent(out) :: error
      call check_all(error, of_bodies())
   end subroutine bodies

   pure function of_bodies() result(promises)
      type(promise_t) :: promises(9)
      real(wp), parameter :: sphere(6) = [1.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      promises(1) = positive('body', 'inertia', sphere(1:3), which=0)
      promises(2) = any_number('body', 'inertia_tensor', sphere, which=4)
      ! Beyond half of its moments no body has such a tensor.
      promises(2)%greatest = 0.5_wp
      promises(3) = any_number('body', 'inertia_tensor', sphere, which=6)
      promises(3)%greatest = 0.5_wp
      promises(4) = positive('body', 'mass', [1.0_wp])
      promises(4)%c_leaves_out = .true.
      promises(5) = any_number('body', 'center_of_mass', sphere(4:6), which=1)
      promises(6) = any_number('body', 'center_of_mass', sphere(4:6), which=3)
      promises(7) = positive('body', 'size', sphere(1:3), which=0, least=1e-30_wp, greatest=1e30_wp)
      ! Small and large boxes, in which masses and moments stay within their own limits.
      promises(8) = positive('body', 'density', [1.0_wp], greatest=1e85_wp)
      promises(8)%setting%edge = 1e3_wp
      promises(9) = positive('body', 'density', [1.0_wp], least=1e-94_wp)
      promises(9)%setting%edge = 0.1_wp
      promises%setting%omega(3) = 0.25_wp
   end function of_bodies

   subroutine potentials(error)
      type(error_type), allocatable, intent(out) :: error
      call check_all(error, of_potentials())
   end subroutine potentials

   pure function of_potentials() result(promises)
      type(promise_t) :: promises(12)
      real(wp), parameter :: zero(3) = 0.0_wp, up(3) = [0.0_wp, 0.0_wp, 1.0_wp]
      integer :: i
      promises(1) = any_number('gravity', 'acceleration', zero, 1)
      promises(2) = any_number('gravity', 'acceleration', zero, 3)
      promises(3) = any_number('dipole', 'moment', zero, 2)
      promises(4) = any_number('dipole', 'field', zero, 3)
      ! A direction: one component must be there.
      promises(5) = any_number('gravity_gradient', 'direction', up, 1)
      promises(6) = any_number('gravity_gradient', 'direction', zero, 1)
      promises(6)%least = 1e-100_wp
      promises(6)%zero = .false.
      promises(7) = any_number('gravity_gradient', 'strength', [1.0_wp])
      promises(8) = any_number('spring', 'body_point', zero, 1)
      promises(9) = any_number('spring', 'anchor', zero, 2)
      promises(10) = any_number('spring', 'rest_length', zero(1:1))
      promises(10)%negative = .false.
      promises(11) = any_number('spring', 'stiffness', zero(1:1))
      promises(12) = any_number('gravity_gradient', 'direction', zero, 0)
      promises(12)%least = 1e-100_wp
      promises(12)%zero = .false.
      ! So weak that the longest spring has an energy within its limit.
      do i = 8, 10
         promises(i)%setting%stiffness = 1e-150_wp
      end do
   end function of_potentials

   subroutine torques(error)
      type(error_type), allocatable, intent(out) :: error
      call check_all(error, of_torques())
   end subroutine torques

   pure function of_torques() result(promises)
      type(promise_t) :: promises(10)
      real(wp), parameter :: zero(3) = 0.0_wp
      promises(1) = any_number('damping', 'coefficient', zero, 3)
      promises(2) = any_number('torque', 'body', zero, 1)
      promises(3) = any_number('torque', 'space', zero, 2)
      promises(4) = any_number('torque', 'frequency', zero(1:1))
      promises(5) = any_number('torque', 'phase', zero(1:1))
      promises(6) = any_number('torque', 'start', zero(1:1))
      promises(7) = any_number('torque', 'stop', zero(1:1))
      promises(6)%c_open_end = -1
      promises(7)%c_open_end = 1
      promises(8) = any_number('rotor', 'momentum', zero, 1)
      ! |p| is twice the momentum.
      promises(8)%greatest = 0.5e100_wp
      promises(9) = any_number('rotating_frame', 'rate', zero, 2)
      ! 1e8 rad in a step.
      promises(9)%greatest = 1e58_wp
      promises(9)%setting%time_step = 1e-50_wp
      promises(10) = any_number('rotating_frame', 'latitude', zero(1:1))
      promises(10)%greatest = 2*atan(1.0_wp)
   end function of_torques

   subroutine starts(error)
      type(error_type), allocatable, intent(out) :: error
      call check_all(error, of_starts())
   end subroutine starts

   pure function of_starts() result(promises)
      type(promise_t) :: promises(8)
      real(wp), parameter :: zero(3) = 0.0_wp
      promises(1) = any_number('initial', 'quaternion', [1.0_wp, zero], 1)
      promises(1)%least = 1.0_wp - 1e-6_wp
      promises(1)%greatest = 1.0_wp + 1e-6_wp
      promises(1)%zero = .false.
      promises(2) = any_number('initial', 'quaternion', [1.0_wp, zero], 3)
      promises(2)%greatest = 1e-3_wp
      promises(2)%carried = .true.
      promises(3) = any_number('initial', 'axis', zero, 1)
      promises(3)%least = 1e-100_wp
      promises(3)%zero = .false.
      promises(4) = any_number('initial', 'axis', [zero(1:2), 1.0_wp], 2)
      promises(5) = any_number('initial', 'angle', zero(1:1))
      promises(6) = any_number('initial', 'euler', zero, 2)
      ! Beside another component: a momentum of nothing but denormal numbers has lost digits.
      promises(7) = any_number('initial', 'euler_rates', [1.0_wp, zero(1:2)], 2)
      promises(8) = any_number('initial', 'angular_velocity', [1.0_wp, zero(1:2)], 3)
      promises(4:8)%carried = .true.
      ! |p||Ω| = 2JΩ² is at the limit of energies; steps are short enough to follow.
      promises(7:8)%greatest = sqrt(5.0_wp)*1e50_wp
      promises(7:8)%setting%time_step = 1e-45_wp
   end function of_starts

   subroutine settings(error)
      type(error_type), allocatable, intent(out) :: error
      call check_all(error, of_settings())
   end subroutine settings

   pure function of_settings() result(promises)
      type(promise_t) :: promises(8)
      real(wp), parameter :: below_one = nearest(1.0_wp, -1.0_wp)
      promises(1) = any_number('integrator', 'time_step', [1.0_wp])
      promises(1)%least = 1e-50_wp
      promises(1)%greatest = 1e50_wp
      promises(1)%zero = .false.
      promises(1)%setting%omega(3) = 1e-50_wp
      ! The first time is 0. Fewer than 9e15 steps of 0.01 s.
      promises(2) = positive('integrator', 'end_time', [1.0_wp], greatest=9e13_wp)
      promises(2)%carried = .true.
      promises(2)%c_leaves_out = .true.
      promises(3) = positive('integrator', 'accuracy', [1.0_wp], greatest=below_one)
      promises(4) = positive('integrator', 'local_tolerance', [1.0_wp], greatest=below_one)
      promises(5) = positive('integrator', 'tolerance', [1.0_wp], greatest=below_one)
      promises(6) = positive('integrator', 'auxiliary_inertia', [1.0_wp])
      promises(6)%infinite = .true.
      promises(6)%f77_leaves_out = .true.
      ! Fewer than 9e15 rows in 0.08 s.
      promises(7) = positive('output', 'interval', [1.0_wp], least=1e-17_wp)
      promises(7)%c_leaves_out = .true.
      ! Times of the run, of 0.08 s.
      promises(8) = any_number('output', 'times', [0.0_wp])
      promises(8)%greatest = 0.08_wp
      promises(8)%negative = .false.
      promises(8)%text_only = .true.
   end function of_settings

   subroutine events(error)
      type(error_type), allocatable, intent(out) :: error
      call check_all(error, of_events())
   end subroutine events

   pure function of_events() result(promises)
      type(promise_t) :: promises(8)
      promises(1) = any_number('event', 'crosses', [0.0_wp])
      promises(2) = any_number('event', 'weights', [1.0_wp])
      promises(3) = positive('event', 'modulo', [1.0_wp])
      promises(4) = any_number('vary', 'low', [0.0_wp])
      promises(5) = any_number('vary', 'high', [0.0_wp])
      promises(6) = any_number('vary', 'mean', [0.0_wp])
      promises(7) = any_number('vary', 'sigma', [0.0_wp])
      promises(8) = any_number('vary', 'covariance', [0.0_wp])
      promises(7:8)%negative = .false.
      ! Only scenes have them.
      promises%text_only = .true.
   end function of_events

   !> A new key belongs into one of the tables above.
   subroutine all_keys(error)
      type(error_type), allocatable, intent(out) :: error
      type(promise_t), allocatable :: promises(:)
      type(group_kind_t), allocatable :: kinds(:)
      integer :: i, k
      promises = [of_bodies(), of_potentials(), of_torques(), of_starts(), of_settings(), of_events()]
      kinds = scene_kinds()
      do i = 1, size(kinds)
         do k = 1, size(kinds(i)%keys)
            if (kinds(i)%keys(k)%kind /= KEY_REAL) cycle
            if (any(promises%setting%group == kinds(i)%name .and. promises%setting%key == kinds(i)%keys(k)%name)) cycle
            call test_failed(error, trim(kinds(i)%name)//'.'//trim(kinds(i)%keys(k)%name)//' is not tried')
         end do
      end do
   end subroutine all_keys

   !> Steps between rows: at least 1.
   subroutine whole_numbers(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: numbers(5) = [-7, -1, 0, 1, 7]
      integer :: i
      do i = 1, size(numbers)
         call check(error, all([text_takes_every(numbers(i)), c_takes_every(numbers(i)), f77_takes_every(numbers(i))] &
                               .eqv. numbers(i) > 0), number_text(real(numbers(i), wp)))
         if (allocated(error)) return
      end do
   end subroutine whole_numbers

   !> Momentum, energy, turn in a step, and damping, as large as they may be, and larger by a rounding or two.
   subroutine motions(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: more = 1.0_wp + 4*epsilon(1.0_wp)
      call try_motion(error, 'momentum', 0.5e100_wp, 1.0_wp, 1e-2_wp, 0.0_wp, .true.)
      call try_motion(error, 'momentum', 0.5e100_wp*more, 1.0_wp, 1e-2_wp, 0.0_wp, .false.)
      call try_motion(error, 'energy', 0.5_wp, 1e50_wp/more, 1e-45_wp, 0.0_wp, .true.)
      call try_motion(error, 'energy', 0.5_wp, 1e50_wp*more, 1e-45_wp, 0.0_wp, .false.)
      call try_motion(error, 'turn', 0.5_wp, 1.0_wp, 1e8_wp, 0.0_wp, .true.)
      call try_motion(error, 'turn', 0.5_wp, 1.0_wp, 1e8_wp*more, 0.0_wp, .false.)
      call try_motion(error, 'turn back in time', 0.5_wp, 1.0_wp, -1e8_wp*more, 0.0_wp, .false.)
      call try_motion(error, 'damping', 0.5_wp, 16.0_wp, 1e-2_wp, 0.0625e100_wp, .true.)
      call try_motion(error, 'damping', 0.5_wp, 16.0_wp, 1e-2_wp, 0.0625e100_wp*more, .false.)
   end subroutine motions

   !> One motion by every way.
   subroutine try_motion(error, label, inertia, rate, time_step, damping, promised)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: label
      !> kg m², rad/s, s, N m s.
      real(wp), intent(in) :: inertia, rate, time_step, damping
      logical, intent(in) :: promised
      type(setting_t) :: setting
      character(len=:), allocatable :: message
      logical :: takes(3), has_argument
      if (allocated(error)) return
      setting = setting_t(group='damping', key='coefficient', n=3, inertia=inertia, time_step=time_step, &
                          omega=[0.0_wp, 0.0_wp, rate])
      setting%values(3) = damping
      takes = [text_takes(setting, message), c_takes(setting, message), f77_takes(setting, has_argument)]
      if (.not. (has_argument .and. all(takes .eqv. promised))) call test_failed(error, label//': '//message)
   end subroutine try_motion

   !> A dipole is as strong as it is, however it stands to the field.
   subroutine strengths(error)
      type(error_type), allocatable, intent(out) :: error
      type(setting_t) :: setting
      character(len=:), allocatable :: message
      real(wp) :: half_angle, strength
      integer :: i, k
      logical :: takes(2)
      do k = 1, 2
         strength = merge(0.7e50_wp, 0.8e50_wp, k == 1)
         do i = 0, 8
            half_angle = i*atan(1.0_wp)/4
            setting = setting_t(group='dipole', key='moment', n=3, field=strength*[1.0_wp, 1.0_wp, 0.0_wp])
            setting%q = [cos(half_angle), 0.0_wp, 0.0_wp, sin(half_angle)]
            setting%values(1:2) = strength
            takes = [text_takes(setting, message), c_takes(setting, message)]
            if (any(takes .neqv. k == 1)) call test_failed(error, 'dipole: '//message)
            if (allocated(error)) return
         end do
      end do
   end subroutine strengths

   subroutine tiny_direction(error)
      type(error_type), allocatable, intent(out) :: error
      type(setting_t) :: setting
      character(len=:), allocatable :: message, said
      logical :: takes(2)
      setting = setting_t(group='gravity_gradient', key='direction', n=3)
      setting%values(1) = 1e-150_wp
      takes = [text_takes(setting, message), c_takes(setting, said)]
      if (any(takes)) call test_failed(error, 'it is taken')
      if (tail_of(message) /= tail_of(said) .or. index(said, 'direction is too short') == 0) &
         call test_failed(error, message//' / '//said)
      setting%values(1) = 1e-100_wp
      takes = [text_takes(setting, message), c_takes(setting, said)]
      if (.not. all(takes)) call test_failed(error, message//' / '//said)
   end subroutine tiny_direction

   !> What callbacks of C and FORTRAN 77 are given, and what they give.
   subroutine callbacks(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: lengths(6) = [0.0_wp, 1e-150_wp, 1e-100_wp, 1e100_wp, 1.0001e100_wp, 1e150_wp]
      logical, parameter :: promised(6) = [.false., .false., .true., .true., .false., .false.]
      real(wp), parameter :: energies(4) = [1e100_wp, 1.0001e100_wp, 1e200_wp, -1e100_wp]
      integer :: i
      do i = 1, size(lengths)
         call check(error, c_takes_direction([0.0_wp, lengths(i), 0.0_wp]) .eqv. promised(i), &
                    'C: '//number_text(lengths(i)))
         if (allocated(error)) return
         call check(error, f77_takes_direction([0.0_wp, lengths(i), 0.0_wp]) .eqv. promised(i), &
                    'F77: '//number_text(lengths(i)))
         if (allocated(error)) return
      end do
      do i = 1, size(energies)
         call check(error, f77_takes_energy(energies(i)) .eqv. abs(energies(i)) <= 1e100_wp, &
                    'F77: an energy of '//number_text(energies(i)))
         if (allocated(error)) return
      end do
   end subroutine callbacks

   !> Every size with either sign, by every way. The message has the first verdicts that differ.
   subroutine check_all(error, promises)
      type(error_type), allocatable, intent(out) :: error
      type(promise_t), intent(in) :: promises(:)
      real(wp) :: sizes(46)
      character(len=:), allocatable :: wrong
      integer :: i, k, n
      n = 0
      wrong = ''
      sizes = tried_sizes()
      do i = 1, size(promises)
         do k = 1, 2*size(sizes)
            call try(promises(i), merge(1, -1, mod(k, 2) == 0)*sizes((k + 1)/2), n, wrong)
         end do
      end do
      if (n > 0) call test_failed(error, wrong)
   end subroutine check_all

   !> Zero, the ends of every range of the library, their neighbours, and what is no number; without sign.
   function tried_sizes() result(sizes)
      real(wp) :: sizes(46)
      real(wp), parameter :: ends(13) = [1e-300_wp, 1e-150_wp, 1e-100_wp, 1e-50_wp, 1e-30_wp, 1e-6_wp, 1.0_wp, 1e8_wp, &
                                         1e30_wp, 1e50_wp, 0.5e100_wp, 1e100_wp, 1e150_wp]
      integer :: i
      do i = 1, size(ends)
         sizes(3*i - 2:3*i) = [nearest(ends(i), -1.0_wp), ends(i), nearest(ends(i), 1.0_wp)]
      end do
      sizes(40:44) = [0.0_wp, nearest(0.0_wp, 1.0_wp), 1e-310_wp, tiny(1.0_wp), huge(1.0_wp)]
      sizes(45) = ieee_value(1.0_wp, ieee_quiet_nan)
      sizes(46) = ieee_value(1.0_wp, ieee_positive_inf)
   end function tried_sizes

   !> One number by every way.
   subroutine try(promise, number, n, wrong)
      type(promise_t), intent(in) :: promise
      real(wp), intent(in) :: number
      !> Verdicts that differ from the promise, and the first of them in words.
      integer, intent(inout) :: n
      character(len=:), allocatable, intent(inout) :: wrong
      type(setting_t) :: setting
      character(len=:), allocatable :: message, said
      logical :: has_argument, takes
      setting = promise%setting
      if (promise%which > 0) then
         setting%values(promise%which) = number
      else
         where (setting%values(1:setting%n) /= 0.0_wp .or. .not. promise%zero) setting%values(1:setting%n) = number
      end if
      takes = text_takes(setting, message)
      call compare('text', takes, is_promised(promise, number, .false.), message)
      if (promise%text_only) return
      takes = c_takes(setting, said)
      call compare('C', takes, is_promised(promise, number, promise%carried) .or. &
                   promise%c_leaves_out .and. is_zero_or_less(number, 0.0_wp) .or. &
                   is_open_end(number, promise%c_open_end), said)
      ! A mass or density of 0 is none for C, which then says that one is missing.
      if (message /= '' .and. said /= '' .and. any(setting%group == one_voice) .and. .not. &
          (setting%group == 'body' .and. is_zero_or_less(number, 0.0_wp))) call compare_words(message, said)
      takes = f77_takes(setting, has_argument)
      if (has_argument) call compare('F77', takes, is_promised(promise, number, promise%carried) .or. &
                                     promise%f77_leaves_out .and. is_zero_or_less(number, -1e100_wp), '')

   contains

      subroutine compare(channel, taken, promised, said)
         character(len=*), intent(in) :: channel, said
         logical, intent(in) :: taken, promised
         if (taken .eqv. promised) return
         n = n + 1
         if (n > most_shown) return
         wrong = wrong//new_line('a')//channel//trim(merge(' takes  ', ' refuses', taken))//' '//trim(setting%group)// &
                 '.'//trim(setting%key)//' = '//number_text(number)//' '//said
      end subroutine compare

      !> Text begins with file and line and quotes a number as it was typed; what follows is the same.
      subroutine compare_words(message, said)
         character(len=*), intent(in) :: message, said
         if (tail_of(message) == tail_of(said)) return
         n = n + 1
         if (n <= most_shown) wrong = wrong//new_line('a')//'text says: '//message//new_line('a')//'C says: '//said
      end subroutine compare_words
   end subroutine try

   !> What is said behind the number.
   pure function tail_of(message) result(tail)
      character(len=*), intent(in) :: message
      character(len=:), allocatable :: tail
      tail = message(max(1, index(message, ' is ')):)
   end function tail_of

   !> Infinity of a sign.
   pure logical function is_open_end(number, side)
      real(wp), intent(in) :: number
      integer, intent(in) :: side
      is_open_end = .not. ieee_is_nan(number) .and. side /= 0
      if (is_open_end) is_open_end = side*number > huge(number)
   end function is_open_end

   !> From a number to zero.
   pure logical function is_zero_or_less(number, least)
      real(wp), intent(in) :: number, least
      is_zero_or_less = .not. ieee_is_nan(number)
      if (is_zero_or_less) is_zero_or_less = number <= 0.0_wp .and. number >= least
   end function is_zero_or_less

   !> What a promise says of a number.
   pure logical function is_promised(promise, number, any_small)
      type(promise_t), intent(in) :: promise
      real(wp), intent(in) :: number
      !> However small.
      logical, intent(in) :: any_small
      is_promised = .false.
      if (ieee_is_nan(number)) return
      if (.not. ieee_is_finite(number)) then
         is_promised = promise%infinite .and. number > 0.0_wp
      else if (abs(number) > 0.0_wp) then
         is_promised = abs(number) <= promise%greatest .and. (abs(number) >= promise%least .or. any_small) .and. &
                       (number > 0.0_wp .or. promise%negative)
      else
         is_promised = promise%zero
      end if
   end function is_promised

end module test_limits
