!> Limits: every key at and just beyond its limits, as text, from C and from FORTRAN 77. All give the same verdict, and
!> it is the one that the documentation promises.
submodule(suites_of_runs) test_limits
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan, ieee_positive_inf, ieee_quiet_nan, ieee_value
   use nutate_keys, only: group_kind_t, KEY_REAL
   use nutate_kinds, only: wp
   use nutate_scene, only: scene_kinds
   use test_limit_c, only: c_takes, c_takes_direction, c_takes_every
   use test_limit_f77, only: f77_takes, f77_takes_direction, f77_takes_energy, f77_takes_every
   use test_limit_promises, only: of_bodies, of_events, of_fits, of_fields, of_orbits, of_potentials, of_controllers, &
                                  of_tangents, &
      of_settings, of_starts, of_torques, of_wheels, promise_t
   use test_limit_text, only: number_text, setting_t, text_takes, text_takes_every
   use test_support, only: check, error_type, new_unittest, one_in, test_failed
   implicit none

   !> Groups whose numbers text and C refuse in the same words.
   character(len=16), parameter :: one_voice(10) = [ &
                                   'body            ', 'gravity         ', 'dipole          ', 'gravity_gradient', &
                                   'spring          ', 'damping         ', 'torque          ', 'rotor           ', &
                                   'wheel           ', 'integrator      ']
   !> Verdicts shown of those that are wrong.
   integer, parameter :: most_shown = 20

contains

   module procedure collect_limits
      testsuite = [ &
                  new_unittest("bodies at their limits", bodies), &
                  new_unittest("potentials at their limits", potentials), &
                  new_unittest("torques and rotors at their limits", torques), &
                  new_unittest("orbits at their limits", orbits), &
                  new_unittest("fields and forces at their limits", fields), &
                  new_unittest("wheels at their limits", wheels), &
                  new_unittest("controllers at their limits", controllers), &
                  new_unittest("starts at their limits", starts), &
                  new_unittest("settings at their limits", settings), &
                  new_unittest("events and variations at their limits", events), &
                  new_unittest("every key of a number is tried", all_keys), &
                  new_unittest("names of keys, choices and defaults are not cut off", whole_texts), &
                  new_unittest("whole numbers at their limits", whole_numbers), &
                  new_unittest("motions and turns at their limits", motions), &
                  new_unittest("the strength of an effect does not depend on the attitude", strengths), &
                  new_unittest("a gravity gradient along (1e-150, 0, 0) is refused by every way", tiny_direction), &
                  new_unittest("callbacks at their limits", callbacks)]
   end procedure collect_limits

   subroutine bodies(error)
      type(error_type), allocatable, intent(out) :: error
      call check_all(error, of_bodies())
   end subroutine bodies

   subroutine potentials(error)
      type(error_type), allocatable, intent(out) :: error
      call check_all(error, of_potentials())
   end subroutine potentials

   subroutine torques(error)
      type(error_type), allocatable, intent(out) :: error
      call check_all(error, of_torques())
   end subroutine torques

   subroutine orbits(error)
      type(error_type), allocatable, intent(out) :: error
      call check_all(error, of_orbits())
   end subroutine orbits

   subroutine fields(error)
      type(error_type), allocatable, intent(out) :: error
      call check_all(error, of_fields())
   end subroutine fields

   subroutine wheels(error)
      type(error_type), allocatable, intent(out) :: error
      call check_all(error, of_wheels())
   end subroutine wheels

   subroutine controllers(error)
      type(error_type), allocatable, intent(out) :: error
      call check_all(error, of_controllers())
   end subroutine controllers

   subroutine starts(error)
      type(error_type), allocatable, intent(out) :: error
      call check_all(error, of_starts())
   end subroutine starts

   subroutine settings(error)
      type(error_type), allocatable, intent(out) :: error
      call check_all(error, of_settings())
   end subroutine settings

   subroutine events(error)
      type(error_type), allocatable, intent(out) :: error
      call check_all(error, of_events())
      call check_all(error, of_fits())
      call check_all(error, of_tangents())
   end subroutine events

   !> A new key belongs into one of the tables above.
   subroutine all_keys(error)
      type(error_type), allocatable, intent(out) :: error
      type(promise_t), allocatable :: promises(:)
      type(group_kind_t), allocatable :: kinds(:)
      integer :: i, k
      promises = [of_bodies(), of_potentials(), of_torques(), of_orbits(), of_fields(), of_wheels(), of_controllers(), &
                  of_starts(), of_settings(), of_events(), of_fits(), of_tangents()]
      kinds = scene_kinds()
      do i = 1, size(kinds)
         do k = 1, size(kinds(i)%keys)
            if (kinds(i)%keys(k)%kind /= KEY_REAL) cycle
            if (any(promises%setting%group == kinds(i)%name .and. promises%setting%key == kinds(i)%keys(k)%name)) cycle
            call test_failed(error, trim(kinds(i)%name)//'.'//trim(kinds(i)%keys(k)%name)//' is not tried')
         end do
      end do
   end subroutine all_keys

   !> A text as long as its component may be cut off, and a key whose name is cut off cannot be set.
   subroutine whole_texts(error)
      type(error_type), allocatable, intent(out) :: error
      type(group_kind_t), allocatable :: kinds(:)
      integer :: i, k
      kinds = scene_kinds()
      do i = 1, size(kinds)
         call check(error, len_trim(kinds(i)%name) < len(kinds(i)%name), kinds(i)%name)
         do k = 1, size(kinds(i)%keys)
            associate (key => kinds(i)%keys(k))
               call check(error, len_trim(key%name) < len(key%name), key%name)
               call check(error, len_trim(key%choices) < len(key%choices), trim(key%name)//': choices')
               call check(error, len_trim(key%instead_of) < len(key%instead_of), trim(key%name)//': other names')
               call check(error, len_trim(key%default) < len(key%default), trim(key%name)//': default')
               call check(error, len_trim(key%beside) < len(key%beside), trim(key%name)//': beside')
            end associate
         end do
      end do
   end subroutine whole_texts

   !> Steps between rows: at least 1.
   subroutine whole_numbers(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: numbers(5) = [-7, -1, 0, 1, 7]
      integer :: i
      do i = 1, size(numbers)
         call check(error, all([text_takes_every(numbers(i)), c_takes_every(numbers(i)), f77_takes_every(numbers(i))] &
                               .eqv. numbers(i) > 0), number_text(real(numbers(i), wp)))
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

   !> Checks the numbers that callbacks of C and FORTRAN 77 receive, and those that they return.
   subroutine callbacks(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: lengths(6) = [0.0_wp, 1e-150_wp, 1e-100_wp, 1e100_wp, 1.0001e100_wp, 1e150_wp]
      logical, parameter :: promised(6) = [.false., .false., .true., .true., .false., .false.]
      real(wp), parameter :: energies(4) = [1e100_wp, 1.0001e100_wp, 1e200_wp, -1e100_wp]
      integer :: i
      do i = 1, size(lengths)
         call check(error, c_takes_direction([0.0_wp, lengths(i), 0.0_wp]) .eqv. promised(i), &
                    'C: '//number_text(lengths(i)))
         call check(error, f77_takes_direction([0.0_wp, lengths(i), 0.0_wp]) .eqv. promised(i), &
                    'F77: '//number_text(lengths(i)))
      end do
      do i = 1, size(energies)
         call check(error, f77_takes_energy(energies(i)) .eqv. abs(energies(i)) <= 1e100_wp, &
                    'F77: an energy of '//number_text(energies(i)))
      end do
   end subroutine callbacks

   !> Every size with either sign, by every way. The message has the first verdicts that differ.
   subroutine check_all(error, promises)
      type(error_type), allocatable, intent(inout) :: error
      type(promise_t), intent(in) :: promises(:)
      real(wp) :: sizes(46)
      character(len=:), allocatable :: wrong
      integer :: i, k, n
      n = 0
      wrong = ''
      sizes = tried_sizes()
      do i = 1, size(promises)
         do k = 1, 2*size(sizes), one_in()
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
      call compare('C', takes, is_promised(promise, number, promise%from_calls) .or. &
                   promise%c_leaves_out .and. is_zero_or_less(number, 0.0_wp) .or. &
                   is_open_end(number, promise%c_open_end), said)
      ! A mass or density of 0 is none for C, which then says that one is missing.
      if (message /= '' .and. said /= '' .and. any(setting%group == one_voice) .and. .not. &
          (setting%group == 'body' .and. is_zero_or_less(number, 0.0_wp))) call compare_words(message, said)
      takes = f77_takes(setting, has_argument)
      if (has_argument) call compare('F77', takes, is_promised(promise, number, promise%from_calls) .or. &
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

   !> Returns the part of a message behind the number.
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

   !> Returns true for a number from `least` to zero.
   pure logical function is_zero_or_less(number, least)
      real(wp), intent(in) :: number, least
      is_zero_or_less = .not. ieee_is_nan(number)
      if (is_zero_or_less) is_zero_or_less = number <= 0.0_wp .and. number >= least
   end function is_zero_or_less

   !> Returns true if a promise admits a number.
   pure logical function is_promised(promise, number, any_small)
      type(promise_t), intent(in) :: promise
      real(wp), intent(in) :: number
      !> Numbers of any small size are admitted.
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

end submodule test_limits
