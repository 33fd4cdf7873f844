!> Histories: their numbers, columns and files.
submodule(suites_of_runs) test_history
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_body, only: diagonal, make_body
   use nutate_columns, only: columns_t
   use nutate_decimal, only: exact_text, rounded_text
   use nutate_gravity, only: gravity_t
   use nutate_history, only: history_t
   use nutate_kinds, only: wp, pi
   use nutate_followed_angles, only: followed_angles_t
   use nutate_quantities, only: quantities, set_of
   use nutate_quaternion, only: quat_exp, quat_normalized, quat_product
   use nutate_observer, only: run_record_t
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT, NUTATE_IO, NUTATE_NOT_FINITE
   use test_problems, only: make_state, new_system, system_t
   use test_support, only: check, check_close, error_type, new_unittest, random_unit, test_failed
   implicit none

contains

   module procedure collect_history
      testsuite = [ &
         new_unittest("numbers read back exactly", numbers_read_back_exactly), &
         new_unittest("short numbers stay short", short_numbers_stay_short), &
         new_unittest("numbers are rounded for people", numbers_are_rounded_for_people), &
         new_unittest("columns stand in the order of the table", columns_stand_in_the_order_of_the_table), &
         new_unittest("unknown columns are refused", unknown_columns_are_refused), &
         new_unittest("columns hold what their names say", columns_hold_what_their_names_say), &
         new_unittest("angles keep their whole revolutions", angles_keep_their_turns), &
         new_unittest("every sequence of angles makes the attitude", every_sequence_of_angles_makes_the_attitude), &
         new_unittest("a history has its name when complete", a_history_has_its_name_when_complete), &
         new_unittest("an abandoned history keeps its rows", an_abandoned_history_keeps_its_rows), &
         new_unittest("a history has one writer", a_history_has_one_writer), &
         new_unittest("a missing folder is reported", a_missing_folder_is_reported), &
         new_unittest("a number that is not finite is refused", a_number_that_is_not_finite_is_refused)]
   end procedure collect_history

   !> Random doubles of all magnitudes, neighbours of powers of ten and two, extremes.
   subroutine numbers_read_back_exactly(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: x
      integer :: i
      seed = 20120101_int64
      do i = 1, 20000
         x = (random_unit(seed) - 0.5_wp)*10.0_wp**int(400*random_unit(seed) - 200)
         call check_round_trip(error, x)
      end do
      do i = -300, 300
         x = 10.0_wp**i
         call check_round_trip(error, x)
         call check_round_trip(error, nearest(x, 1.0_wp))
         call check_round_trip(error, nearest(x, -1.0_wp))
         call check_round_trip(error, 2.0_wp**i)
         call check_round_trip(error, nearest(2.0_wp**i, -1.0_wp))
      end do
      call check_round_trip(error, huge(x))
      call check_round_trip(error, -tiny(x))
      call check_round_trip(error, nearest(0.0_wp, 1.0_wp))
   end subroutine numbers_read_back_exactly

   subroutine check_round_trip(error, x)
      type(error_type), allocatable, intent(inout) :: error
      real(wp), intent(in) :: x
      character(len=:), allocatable :: text
      real(wp) :: back
      text = exact_text(x)
      read (text, *) back
      if (abs(back - x) > 0.0_wp .or. len(text) > 24) call test_failed(error, text//' does not read back')
   end subroutine check_round_trip

   subroutine short_numbers_stay_short(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=16), parameter :: texts(14) = [character(len=16) :: '0', '1', '-1', '0.1', '-0.25', '1234.5678', &
         '0.3', '0.00001', '1E-6', '2.5E-13', '1E+22', '-6.02214076E+23', '1E-25', '299792458']
      real(wp), parameter :: numbers(14) = [0.0_wp, 1.0_wp, -1.0_wp, 0.1_wp, -0.25_wp, 1234.5678_wp, 0.3_wp, &
         1e-5_wp, 1e-6_wp, 2.5e-13_wp, 1e22_wp, -6.02214076e23_wp, 1e-25_wp, 299792458.0_wp]
      integer :: i
      do i = 1, size(texts)
         call check(error, exact_text(numbers(i)) == texts(i), exact_text(numbers(i))//' instead of '//trim(texts(i)))
      end do
      call check(error, exact_text(0.1_wp + 0.2_wp) == '0.30000000000000004', exact_text(0.1_wp + 0.2_wp))
   end subroutine short_numbers_stay_short

   subroutine numbers_are_rounded_for_people(error)
      type(error_type), allocatable, intent(out) :: error
      call check(error, rounded_text(pi) == '3.14159', rounded_text(pi))
      call check(error, rounded_text(-2.0_wp/3, 2) == '-0.67', rounded_text(-2.0_wp/3, 2))
      call check(error, rounded_text(999.96_wp, 4) == '1000', rounded_text(999.96_wp, 4))
      call check(error, rounded_text(1.0e-46_wp, 3) == '1E-46', rounded_text(1.0e-46_wp, 3))
      call check(error, rounded_text(7.0_wp, 1) == '7' .and. rounded_text(0.0_wp) == '0', 'one digit, or zero')
   end subroutine numbers_are_rounded_for_people

   subroutine columns_stand_in_the_order_of_the_table(error)
      type(error_type), allocatable, intent(out) :: error
      type(columns_t) :: columns
      type(status_t) :: status
      call columns%choose([character(len=24) :: 'solver', 'energy', 'quaternion', 'energy'], status)
      call check(error, status%ok(), status%message)
      if (allocated(error)) return
      call check(error, columns%header() == &
                 't,q0,q1,q2,q3,kinetic,potential,total,work,energy_residual,iterations,step_residual', &
                 columns%header())
      call check(error, columns%width == 12, 'width')
   end subroutine columns_stand_in_the_order_of_the_table

   subroutine unknown_columns_are_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(columns_t) :: columns
      type(status_t) :: status
      call columns%choose([character(len=24) :: 'energy', 'quaternoin'], status)
      call check(error, status%code == NUTATE_BAD_ARGUMENT .and. index(status%message, 'quaternion') > 0, &
                 status%message)
   end subroutine unknown_columns_are_refused

   !> A body with an offset, a potential and a finite J0, evaluated by hand: q a quarter turn about axis 1, L = (1,
   !> 4, 9).
   subroutine columns_hold_what_their_names_say(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: state
      type(columns_t) :: columns
      type(status_t) :: status
      real(wp), parameter :: half = sqrt(0.5_wp), inverse_j0 = 0.5_wp
      real(wp), allocatable :: values(:)
      real(wp) :: kinetic
      system => new_system()
      call set_up(system, state)
      ! All columns that depend neither on the effects of a system nor on data that its run propagates.
      call columns%choose(pack(set_of(quantities), quantities%pattern == '' .and. quantities%propagated == 0), status)
      allocate (values(columns%width))
      call columns%start(system, state, inverse_j0)
      state%p(1) = state%p(1) + 0.5_wp
      call columns%evaluate(system, state, run_record_t(iterations=3, residual=1e-17_wp, work=0.25_wp), &
                            values)
      call check_close(error, values(2:5), [half, half, 0.0_wp, 0.0_wp], 1e-15_wp, 'quaternion')
      call check_close(error, values(6:9), state%p, 0.0_wp, 'conjugate momentum')
      ! The increment of p adds ½q* to w = q*∘p: half/2 to its scalar part, and -half/2 to 2 L1.
      call check_close(error, values(10:12), [1 - 0.25_wp*half, 2.0_wp, 3.0_wp], 1e-14_wp, 'angular velocity')
      call check_close(error, values(13:15), [1 - 0.25_wp*half, -3.0_wp, 2.0_wp], 1e-14_wp, 'angular velocity in space')
      call check_close(error, values(16), norm2(values(10:12)), 1e-14_wp, 'angular speed')
      call check_close(error, values(17:22), [1 - 0.25_wp*half, 4.0_wp, 9.0_wp, 1 - 0.25_wp*half, -9.0_wp, &
                                                     4.0_wp], 1e-14_wp, 'angular momentum')
      call check_close(error, values(23:25), [0.0_wp, 0.5_wp*pi, 0.0_wp], 1e-15_wp, 'euler')
      kinetic = 0.5_wp*((1 - 0.25_wp*half)**2 + 8 + 27) + 0.125_wp*inverse_j0*(0.5_wp*half)**2
      ! m g·(R c) with c along axis 2, which points up.
      call check_close(error, values(26:30), [kinetic, 30.0_wp, kinetic + 30, 0.25_wp, kinetic - 18 - 0.25_wp], &
                       1e-13_wp, 'energy')
      call check_close(error, values(31:34), [0.0_wp, 0.5_wp*half, 3.0_wp, 1e-17_wp], 1e-15_wp, &
                       'constraints and solver')
      call check_close(error, values(35), values(28), 0.0_wp, 'jacobi without a frame')
      call system%effects%add(rotating_frame_t(name='rotating_frame', rate=[0.5_wp, 0.25_wp, -0.5_wp]))
      call columns%start(system, state, inverse_j0)
      call columns%evaluate(system, state, run_record_t(work=0.25_wp), values)
      call check_close(error, values(35), values(28) - (0.5_wp*values(20) + 0.25_wp*values(21) - 0.5_wp*values(22)), &
                       1e-13_wp, 'jacobi')
      call check_close(error, values(30), -0.25_wp, 1e-13_wp, 'its residual')
   end subroutine columns_hold_what_their_names_say

   !> Moments 1, 2, 3; mass 1.5 at 2 on axis 2, gravity 10 downwards; a quarter turn about axis 1; Ω = (1, 2, 3).
   subroutine set_up(system, state)
      type(system_t), intent(out) :: system
      type(state_t), intent(out) :: state
      type(status_t) :: status
      call make_body(diagonal([1.0_wp, 2.0_wp, 3.0_wp]), system%body, status, mass=1.5_wp, &
                     center_of_mass=[0.0_wp, 2.0_wp, 0.0_wp])
      call system%effects%add(gravity_t(system%body, [0.0_wp, 0.0_wp, -10.0_wp]))
      state = make_state(system, [sqrt(0.5_wp), sqrt(0.5_wp), 0.0_wp, 0.0_wp], [1.0_wp, 2.0_wp, 3.0_wp])
   end subroutine set_up

   !> Three turns about axis 3 in steps of 1 rad, of which only the last is written.
   subroutine angles_keep_their_turns(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: state
      type(columns_t) :: columns
      type(status_t) :: status
      real(wp) :: values(4)
      integer :: i
      system => new_system()
      call set_up(system, state)
      state%q = tilted(0.0_wp)
      call columns%choose(['euler'], status)
      call check(error, columns%follows_steps, 'the angles are not followed')
      call columns%start(system, state, 0.0_wp)
      do i = 1, 19
         state%q = tilted(real(i, wp))
         call columns%follow(state)
      end do
      call columns%evaluate(system, state, run_record_t(), values)
      call check_close(error, values(2:4), [0.0_wp, 0.3_wp, 19.0_wp], 1e-13_wp)
   end subroutine angles_keep_their_turns

   !> Each sequence gives back the attitude that its angles made: 200 random starts, then small turns that add up to
   !> several revolutions, in which no angle jumps.
   subroutine every_sequence_of_angles_makes_the_attitude(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=3), parameter :: sequences(12) = ['121', '123', '131', '132', '212', '213', '231', '232', '312', &
                                                      '313', '321', '323']
      type(followed_angles_t) :: followed
      real(wp) :: q(4), omega(3), angles(3), before(3)
      integer(int64) :: seed
      integer :: i, k, n
      seed = 5_int64
      do k = 1, size(sequences)
         do n = 1, 200
            q = quat_normalized([(random_unit(seed) - 0.5_wp, i=1, 4)])
            omega = [(2*random_unit(seed) - 1, i=1, 3)]
            call followed%start(sequences(k), q, omega)
            angles = followed%angles()
            do i = 1, 300
               call followed%follow(q)
               before = angles
               angles = followed%angles()
               ! The quaternion itself, or its negative: the sign is that of the start.
               call check_close(error, abs(dot_product(made_by(sequences(k), angles), q)), 1.0_wp, 1e-13_wp, &
                                sequences(k))
               ! Away from the poles no angle changes by more than the turn over the sine to the nearest pole.
               if (pole_distance(sequences(k), angles) > 0.3_wp .and. pole_distance(sequences(k), before) > 0.3_wp) &
                  call check(error, all(abs(angles - before) <= 0.04_wp*norm2(omega)/0.2_wp), sequences(k)//' jumps')
               q = quat_product(q, quat_exp(0.02_wp*omega))
            end do
         end do
      end do
   end subroutine every_sequence_of_angles_makes_the_attitude

   !> Returns the product of rotations about the axes of a sequence.
   pure function made_by(sequence, angles) result(q)
      character(len=3), intent(in) :: sequence
      real(wp), intent(in) :: angles(3)
      real(wp) :: q(4), axis(3)
      integer :: i
      q = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      do i = 1, 3
         axis = 0.0_wp
         axis(index('123', sequence(i:i))) = 0.5_wp*angles(i)
         q = quat_product(q, quat_exp(axis))
      end do
   end function made_by

   !> Returns the distance of the second angle from the values at which the others are not unique, rad.
   pure real(wp) function pole_distance(sequence, angles)
      character(len=3), intent(in) :: sequence
      real(wp), intent(in) :: angles(3)
      if (sequence(1:1) == sequence(3:3)) then
         pole_distance = min(angles(2), pi - angles(2))
      else
         pole_distance = 0.5_wp*pi - abs(angles(2))
      end if
   end function pole_distance

   !> θ = 0.3, then a spin.
   pure function tilted(spin) result(q)
      real(wp), intent(in) :: spin
      real(wp) :: q(4)
      real(wp) :: c(4), s(4)
      c = quat_exp([0.15_wp, 0.0_wp, 0.0_wp])
      s = quat_exp([0.0_wp, 0.0_wp, 0.5_wp*spin])
      q = [c(1)*s(1), c(2)*s(1), -c(2)*s(4), c(1)*s(4)]
   end function tilted

   subroutine a_history_has_its_name_when_complete(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: state
      type(history_t) :: history
      type(status_t) :: status
      character(len=:), allocatable :: name
      system => new_system()
      name = scratch('complete.csv')
      call set_up(system, state)
      call history%open(name, ['constraints'], system, state, 0.0_wp, status)
      if (status%ok()) call history%observe(system, state, run_record_t(), status)
      call check(error, status%ok() .and. history%rows == 1, status%message)
      if (allocated(error)) return
      call check_files(error, name, is_partial=.true.)
      call history%finish(status)
      call check(error, status%ok(), status%message)
      call check_files(error, name, is_partial=.false.)
      call remove(name)
   end subroutine a_history_has_its_name_when_complete

   subroutine an_abandoned_history_keeps_its_rows(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: state
      type(history_t) :: history
      type(status_t) :: status
      character(len=:), allocatable :: name
      system => new_system()
      name = scratch('abandoned.csv')
      call set_up(system, state)
      call history%open(name, ['quaternion'], system, state, 0.0_wp, status)
      call history%observe(system, state, run_record_t(), status)
      call history%abandon(status)
      call check(error, status%ok(), status%message)
      call check_files(error, name, is_partial=.true.)
      call check(error, history%file%kept_in() == name//'.partial', 'the rows are reported to be elsewhere')
      call remove(name//'.partial')
   end subroutine an_abandoned_history_keeps_its_rows

   subroutine a_history_has_one_writer(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: state
      type(history_t) :: first, second
      type(status_t) :: status
      character(len=:), allocatable :: name
      system => new_system()
      name = scratch('shared.csv')
      call set_up(system, state)
      call first%open(name, ['quaternion'], system, state, 0.0_wp, status)
      call check(error, status%ok(), status%message)
      if (allocated(error)) return
      call second%open(name, ['quaternion'], system, state, 0.0_wp, status)
      call check(error, status%code == NUTATE_IO .and. index(status%message, 'another run') > 0, 'two writers')
      call first%abandon(status)
      call second%open(name, ['quaternion'], system, state, 0.0_wp, status)
      call check(error, status%ok(), status%message)
      call second%abandon(status)
      call remove(name//'.partial')
   end subroutine a_history_has_one_writer

   subroutine a_missing_folder_is_reported(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: state
      type(history_t) :: history
      type(status_t) :: status
      system => new_system()
      call set_up(system, state)
      call history%open(scratch('nowhere')//'/history.csv', ['quaternion'], system, state, 0.0_wp, status)
      call check(error, status%code == NUTATE_IO .and. status%message /= '', 'no error')
   end subroutine a_missing_folder_is_reported

   subroutine a_number_that_is_not_finite_is_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: state
      type(history_t) :: history
      type(status_t) :: status
      character(len=:), allocatable :: name
      system => new_system()
      name = scratch('infinite.csv')
      call set_up(system, state)
      call history%open(name, ['quaternion'], system, state, 0.0_wp, status)
      state%q(2) = ieee_value(1.0_wp, ieee_positive_inf)
      call history%observe(system, state, run_record_t(), status)
      call check(error, status%code == NUTATE_NOT_FINITE .and. history%rows == 0, 'the row was written')
      call history%abandon(status)
      call remove(name//'.partial')
   end subroutine a_number_that_is_not_finite_is_refused

   !> Checks that there is either the partial file or the complete one.
   subroutine check_files(error, name, is_partial)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: name
      logical, intent(in) :: is_partial
      call check(error, there_is(name//'.partial') .eqv. is_partial, 'partial file')
      call check(error, there_is(name) .neqv. is_partial, 'complete file')
   end subroutine check_files

   !> Returns a path for a file that a test may write.
   function scratch(name) result(path)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: path
      character(len=200) :: folder
      integer :: length, status
      call get_environment_variable('TMPDIR', folder, length, status)
      if (status /= 0 .or. length == 0) folder = '/tmp'
      path = trim(folder)//'/nutate-test-'//name
      call remove(path)
      call remove(path//'.partial')
   end function scratch

   logical function there_is(path)
      character(len=*), intent(in) :: path
      inquire (file=path, exist=there_is)
   end function there_is

   subroutine remove(path)
      character(len=*), intent(in) :: path
      integer :: unit, status
      if (.not. there_is(path)) return
      open (newunit=unit, file=path, status='old', iostat=status)
      if (status == 0) close (unit, status='delete')
   end subroutine remove

end submodule test_history
