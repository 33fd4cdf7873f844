!> Sweeps of tops, several at a time: against the oracle, and against single runs.
submodule(suites_of_interfaces) test_tops
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_kinds, only: wp, eps, long
   use nutate_member, only: member_t
   use nutate_member_rows, only: run_members
   use nutate_member_tops, only: find_top, state_of_top
   use nutate_quaternion, only: rotation_matrix
   use nutate_row_layout, only: make_layout, real_of, row_layout_t
   use nutate_run, only: integrate
   use nutate_scene, only: parse_scene, scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, NUTATE_STEP_LIMIT
   use nutate_tops, only: top_t, tops_t
   use test_oracle, only: find_true_attitude, has_oracle, qp, true_distance
   use test_support, only: check, check_below, check_close, error_type, in_turn, new_unittest, random_unit, &
      random_unit_quaternion, random_vector, skip_test, test_failed
   implicit none

   !> Members of a sweep.
   integer, parameter :: n = 9

contains

   module procedure collect_tops
      testsuite = [ &
                  new_unittest("random tops as by the oracle", random_tops), &
                  new_unittest("rows of tops as by single runs", rows_by_single_runs), &
                  new_unittest("slow motions near an equilibrium", near_equilibria), &
                  new_unittest("settings that vary from member to member", varied_settings), &
                  new_unittest("the row of a top does not depend on the others", rows_are_alone), &
                  new_unittest("other members are run singly, to the bit", others_are_single), &
                  new_unittest("a limit of steps is that of a single run", limits)]
   end procedure collect_tops

   !> Reads a scene with an ensemble.
   subroutine read_text(text, scene, error)
      character(len=*), intent(in) :: text
      class(scene_t), allocatable, intent(out) :: scene
      type(error_type), allocatable, intent(inout) :: error
      type(status_t) :: status
      character(len=:), allocatable :: message
      allocate (scene)
      call parse_scene(text, 'tops.nml', scene, status, message)
      if (.not. status%ok()) call test_failed(error, message)
   end subroutine read_text

   !> Reads a scene, all members of which start with another angular velocity.
   subroutine read_tops(text, scene, error, size)
      character(len=*), intent(in) :: text
      class(scene_t), allocatable, intent(out) :: scene
      type(error_type), allocatable, intent(inout) :: error
      !> Largest of these velocities, rad/s; default 2.5.
      real(wp), intent(in), optional :: size
      character(len=24) :: high
      high = '2.5'
      if (present(size)) write (high, '(es24.16)') size
      call read_text(text//' &ensemble members = 9 / &vary key = "initial.angular_velocity.1", distribution = "grid", &
         &low = -'//trim(adjustl(high))//', high = '//high//', points = 9 /', scene, error)
   end subroutine read_tops

   !> Compares rows of a sweep with the ends of single runs, and their invariants with round-off.
   subroutine compare_rows(scene, first, last, tolerance, label, error)
      class(scene_t), intent(in) :: scene
      integer, intent(in) :: first, last
      !> Largest difference of a component of q.
      real(wp), intent(in) :: tolerance
      character(len=*), intent(in) :: label
      type(error_type), allocatable, intent(inout) :: error
      type(member_t) :: member
      type(row_layout_t) :: layout
      type(state_t) :: state
      type(status_t) :: status
      integer(long), allocatable :: fields(:, :)
      integer(long) :: k
      call make_layout(scene, layout, status)
      call run_members(scene, layout, int(first, long), int(last, long), fields, status)
      call member%prepare(scene)
      do k = first, last
         call member%set_values(scene%ensemble, k, status)
         state = member%scene%initial
         call integrate(member%scene%system, member%scene%integrator, state, member%scene%plan, status)
         call check(error, status%ok(), trim(status%message))
         associate (row => fields(:, k - first + 1), at => layout%values, end => layout%columns)
            call check_close(error, real_of(row(at + 1)), state%t, 0.0_wp, label//', time')
            call check_close(error, real_of(row(at + 2:at + 5)), state%q, tolerance, label//', attitude')
            call check_below(error, maxval(real_of(row(end + 1:end + 2))), 64*eps, label//', invariants')
         end associate
      end do
   end subroutine compare_rows

   !> Returns a random top: any body and direction, forward and backward.
   function random_top(seed, tolerance) result(text)
      integer(int64), intent(inout) :: seed
      real(wp), intent(in) :: tolerance
      character(len=:), allocatable :: text
      character(len=640) :: line
      real(wp) :: moments(3), acceleration(3), axes(3, 3), j(3, 3)
      integer :: i
      moments = 1 + 0.9_wp*random_vector(seed)
      moments = [moments(2) + moments(3), moments(3) + moments(1), moments(1) + moments(2)]
      axes = rotation_matrix(random_unit_quaternion(seed))
      do i = 1, 3
         j(:, i) = matmul(axes, moments*axes(i, :))
      end do
      acceleration = 5*random_vector(seed)
      write (line, '(a,*(es25.17,:,","))') '&body mass = 2, check_triangle = .false., inertia_tensor = ', j(1, 1), &
         j(2, 2), j(3, 3), j(1, 2), j(1, 3), j(2, 3)
      text = trim(line)
      write (line, '(2(a,3(es25.17,:,",")))') ' center_of_mass = ', random_vector(seed), &
         ' / &gravity acceleration = ', acceleration
      text = text//trim(line)//' /'
      write (line, '(a,4(es25.17,:,","))') ' &initial quaternion = ', random_unit_quaternion(seed)
      text = text//trim(line)
      write (line, '(a,3(es25.17,:,","))') ' angular_velocity = ', 3*random_vector(seed)
      text = text//trim(line)
      write (line, '(a,es25.17,a)') " / &integrator method = 'taylor', local_tolerance = ", tolerance, ','
      text = text//trim(line)
      write (line, '(a,es25.17)') ' end_time = ', sign(4 + 8*random_unit(seed), random_unit(seed) - 0.3_wp)
      text = text//trim(line)//' /'
   end function random_top

   !> Each step has an error of the tolerance, which the motions multiply by some ten. Tops whose Ω passes zero or the
   !> direction e may be given up, and would be run singly.
   subroutine random_tops(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(member_t), allocatable :: members(:)
      type(tops_t) :: tops
      type(state_t) :: state
      type(status_t) :: status
      real(qp) :: exact(4)
      real(wp) :: tolerance
      integer(int64) :: seed
      integer :: number, i, given_up, runs
      logical :: is_top
      given_up = 0
      runs = 0
      if (.not. has_oracle) then
         call skip_test(error, "no kind of 33 digits")
         return
      end if
      seed = 271828_int64
      allocate (members(n))
      do number = 1, 60
         tolerance = 10.0_wp**(-4 - 9*random_unit(seed))
         call read_tops(random_top(seed, tolerance), scene, error)
         if (allocated(error)) return
         if (.not. in_turn(number)) cycle
         if (allocated(tops%tops)) deallocate (tops%tops)
         allocate (tops%tops(n))
         do i = 1, n
            call members(i)%prepare(scene)
            call members(i)%set_values(scene%ensemble, int(i, long), status)
            call find_top(members(i)%scene%system, members(i)%scene%initial, tops%tops(i), is_top)
            tops%tops(i)%end_time = members(i)%scene%plan%end_time
            call check(error, is_top, 'a member is no top')
         end do
         call tops%begin(tolerance)
         do while (tops%running > 0)
            call tops%perform_steps(10)
         end do
         given_up = given_up + count(.not. tops%tops%arrived)
         runs = runs + n
         do i = 1, n
            if (modulo(i + number, 4) > 0 .or. allocated(error) .or. .not. tops%tops(i)%arrived) cycle
            associate (one => members(i)%scene)
               call find_true_attitude(one%system, one%initial, one%plan%end_time, exact, 1e-20_qp)
               state = state_of_top(one%system, tops%tops(i))
               call check_below(error, true_distance(exact, state%q), &
                                10*tolerance*tops%tops(i)%steps + 1e-13_wp, 'attitude')
            end associate
         end do
         if (allocated(error)) return
      end do
      call check(error, 20*given_up <= runs, 'more than one in 20 tops did not arrive')
   end subroutine random_tops

   !> The rows have the states of single runs, with the same one of q and -q, and invariants to round-off.
   subroutine rows_by_single_runs(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      integer(int64) :: seed
      integer :: number
      seed = 314159_int64
      do number = 1, 40
         call read_tops(random_top(seed, 1e-11_wp), scene, error)
         if (.not. allocated(error) .and. in_turn(number)) call compare_rows(scene, 1, n, 2e-8_wp, 'random top', error)
      end do
   end subroutine rows_by_single_runs

   !> Hanging and upright bodies that turn slowly, and bodies that spin about the vertical: where the energy is
   !> stationary its round-off must not move the state. The amplitudes grow by e⁶ at most.
   subroutine near_equilibria(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      character(len=400) :: text
      integer(int64) :: seed
      real(wp) :: spin
      integer :: number
      seed = 662607_int64
      do number = 1, 36
         spin = merge(10.0_wp, 0.0_wp, modulo(number, 3) == 0)
         write (text, '(3a,es24.16,",",es24.16,a,es9.1,a)') &
            '&body inertia = 2, 3, 4, mass = 1, center_of_mass = 0, 0, ', &
            merge('-0.3', ' 0.3', modulo(number, 2) == 0), &
            ' / &gravity / &initial angular_velocity = ', &
            10.0_wp**(-number/3)*random_unit(seed), 10.0_wp**(-number/3)*random_unit(seed), ',', spin, &
            " / &integrator method = 'taylor', local_tolerance = 1e-12, end_time = 4 /"
         call read_tops(trim(text)//' ', scene, error, 10.0_wp**(-number/3))
         if (allocated(error)) return
         if (in_turn(number)) call compare_rows(scene, 1, n, 1e-10_wp, trim(text), error)
      end do
   end subroutine near_equilibria

   !> Members with a setting that tops do not know are run singly; those with other limits and tolerances, too.
   subroutine varied_settings(error)
      type(error_type), allocatable, intent(out) :: error
      call compare('integrator.series_order', '12', '20')
      call compare('integrator.max_step', '0.01', '0.1')
      call compare('integrator.local_tolerance', '1e-6', '1e-4')

   contains

      !> Compares the second member.
      subroutine compare(key, low, high)
         character(len=*), intent(in) :: key, low, high
         class(scene_t), allocatable :: scene
         integer(int64) :: seed
         seed = 602214_int64
         if (.not. allocated(error)) call read_text( &
            random_top(seed, 1e-7_wp)//' &ensemble members = 2 / &vary key = "'//key//'", distribution = "grid", '// &
            'low = '//low//', high = '//high//', points = 2 /', scene, error)
         if (.not. allocated(error)) call compare_rows(scene, 2, 2, 0.0_wp, key, error)
      end subroutine compare

   end subroutine varied_settings

   subroutine rows_are_alone(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(row_layout_t) :: layout
      type(status_t) :: status
      integer(long), allocatable :: fields(:, :), row(:, :)
      integer(int64) :: seed
      integer :: i
      seed = 161803_int64
      call read_tops(random_top(seed, 1e-9_wp), scene, error)
      if (allocated(error)) return
      call make_layout(scene, layout, status)
      call run_members(scene, layout, 1_long, int(n, long), fields, status)
      do i = 1, n
         call run_members(scene, layout, int(i, long), int(i, long), row, status)
         call check(error, all(row(:, 1) == fields(:, i)), 'other bits')
      end do
   end subroutine rows_are_alone

   !> Symmetric bodies, rotors, damping, and tops that hang at rest: their rows are those of single runs.
   subroutine others_are_single(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: top = " &gravity acceleration = 0, 0, -9.81 / &integrator method = 'taylor', &
         &local_tolerance = 1e-9, end_time = 3 / ", asymmetric = "&body inertia = 2, 3, 4, mass = 1, &
         &center_of_mass = 0.1, 0.0, 0.3 /", spins = "&initial angular_velocity = 0, 1, 5 /"
      call compare("&body inertia = 3, 3, 4, mass = 1, center_of_mass = 0, 0, 0.3 /"//spins//top)
      call compare(asymmetric//spins//top//"&rotor momentum = 0, 1, 2 /")
      call compare(asymmetric//spins//top//"&damping coefficient = 3*0.1 /")
      call compare("&body inertia = 2, 3, 4, mass = 1 / &initial angular_velocity = 3*0 /"//top)
      call compare("&body inertia = 2, 3, 4, mass = 1, center_of_mass = 0, 0, -0.3 / "// &
                   "&initial quaternion = 1, 0, 0, 0, angular_velocity = 3*0 /"//top)

   contains

      !> The first member does not vary, so that a body can be at rest.
      subroutine compare(text)
         character(len=*), intent(in) :: text
         class(scene_t), allocatable :: scene
         if (.not. allocated(error)) call read_text( &
            text//'&ensemble members = 2 / &vary key = "body.mass", distribution = "grid", low = 1, high = 2, '// &
            'points = 2 /', scene, error)
         if (.not. allocated(error)) call compare_rows(scene, 1, 1, 0.0_wp, text, error)
      end subroutine compare

   end subroutine others_are_single

   subroutine limits(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(row_layout_t) :: layout
      type(status_t) :: status
      integer(long), allocatable :: fields(:, :)
      integer(int64) :: seed
      seed = 577215_int64
      call read_tops(random_top(seed, 1e-9_wp), scene, error)
      if (allocated(error)) return
      scene%plan%max_steps = 5
      call make_layout(scene, layout, status)
      call run_members(scene, layout, 1_long, int(n, long), fields, status)
      call check(error, all(fields(2, :) == NUTATE_STEP_LIMIT), 'status')
   end subroutine limits

end submodule test_tops
