!> Ensembles: the statistics of what is drawn at fixed seeds, members against scenes written by hand, rows that depend
!> on nothing but their member.
submodule(suites_of_interfaces) test_ensemble
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_kinds, only: wp, eps, long
   use nutate_member, only: member_t
   use nutate_member_rows, only: run_members
   use nutate_quaternion, only: rotation_matrix
   use nutate_row_layout, only: make_layout, real_of, row_layout_t
   use nutate_sampling, only: draw_values
   use nutate_scene, only: parse_scene, scene_t
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY, NUTATE_BAD_SCENE
   use test_statistics, only: distance_to_uniform, normal_probability
   use test_support, only: check, check_below, check_close, error_type, new_unittest, test_failed
   implicit none

   character, parameter :: line_feed = achar(10)
   character(len=*), parameter :: box = "&body inertia = 5.0, 20.0, 17.0 /"//line_feed// &
                                  "&initial angular_velocity = 0.1, 0.0, 10.0 /"//line_feed// &
                                  "&integrator time_step = 0.01, end_time = 0.2 /"//line_feed
   !> Once in a thousand samples is this passed; the seeds stay.
   real(wp), parameter :: seldom = 1.95_wp

contains

   module procedure collect_ensemble
      testsuite = [ &
                  new_unittest("uniform and normal draws are distributed so", uniform_and_normal), &
                  new_unittest("draws together have their covariance", covariances), &
                  new_unittest("a covariance without full rank keeps to its plane", flat_covariance), &
                  new_unittest("rotations are uniform", rotations), &
                  new_unittest("latin sampling has one member in each part, and the distribution", latin), &
                  new_unittest("a grid has every combination, the last running fastest", grids), &
                  new_unittest("names mean the numbers of the N-th group", names), &
                  new_unittest("whole numbers are rounded, and run so", whole_numbers), &
                  new_unittest("a member is the scene with its numbers in it, to the bit", members_by_hand), &
                  new_unittest("what a scene refuses is a row with its status", refusals), &
                  new_unittest("a member after a refused one is as if it came first", members_are_alone), &
                  new_unittest("a member with the stepper of another is as if it came first", starts_are_alone), &
                  new_unittest("a last trial run treated as the run leaves no trace", trial_runs_are_runs), &
                  new_unittest("a frame that only some members turn is theirs alone", rotated_frames), &
                  new_unittest("a scene without an ensemble has no rows", scenes_without_ensemble), &
                  new_unittest("effects that a program adds act on every member", added_effects), &
                  new_unittest("every effect, method and event can stand in an ensemble", everything)]
   end procedure collect_ensemble

   !> A box with an ensemble.
   subroutine make(text, scene, error)
      !> Groups of the ensemble.
      character(len=*), intent(in) :: text
      type(scene_t), intent(inout) :: scene
      type(error_type), allocatable, intent(inout) :: error
      type(status_t) :: status
      character(len=:), allocatable :: message
      call parse_scene(box//text, 'box.nml', scene, status, message)
      if (.not. status%ok()) call test_failed(error, message)
   end subroutine make

   !> The values of all members; shape (targets, members).
   function values_of(scene) result(values)
      type(scene_t), intent(in) :: scene
      real(wp), allocatable :: values(:, :)
      integer(long) :: k
      allocate (values(size(scene%ensemble%targets), scene%ensemble%members))
      do k = 1, scene%ensemble%members
         call draw_values(scene%ensemble, k, values(:, k))
      end do
   end function values_of

   subroutine uniform_and_normal(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      real(wp), allocatable :: x(:, :)
      allocate (scene)
      call make("&ensemble members = 20000, seed = 3 /"// &
                "&vary key = 'body.inertia.1', distribution = 'uniform', low = 4.0, high = 7.0 /"// &
                "&vary key = 'initial.angular_velocity', distribution = 'normal', sigma = 0.1, 0.2, 3.0 /", &
                scene, error)
      if (allocated(error)) return
      x = values_of(scene)
      call check_below(error, distance_to_uniform((x(1, :) - 4)/3), seldom, 'uniform')
      call check_below(error, distance_to_uniform(normal_probability((x(2, :) - 0.1_wp)/0.1_wp)), seldom, 'normal')
      ! The mean is what the scene says.
      call check_below(error, distance_to_uniform(normal_probability((x(4, :) - 10)/3)), seldom, 'normal, third')
      call check_below(error, abs(correlation(x(1, :), x(2, :))), 0.02_wp, 'draws are independent')
   end subroutine uniform_and_normal

   pure real(wp) function correlation(x, y)
      real(wp), intent(in) :: x(:), y(:)
      real(wp) :: a(size(x)), b(size(y))
      a = x - sum(x)/size(x)
      b = y - sum(y)/size(y)
      correlation = sum(a*b)/sqrt(sum(a**2)*sum(b**2))
   end function correlation

   !> Checks a covariance over the keys of one group: variances 4 and 9, correlations 0.5, -0.8, 0.1.
   subroutine covariances(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      real(wp), allocatable :: x(:, :)
      allocate (scene)
      call make("&ensemble members = 40000, seed = 4 /"// &
                "&vary key = 'initial.angular_velocity.1', 'body.inertia.2', 'initial.angular_velocity.3', "// &
                "distribution = 'normal', mean = 1.0, 20.0, 0.0, "// &
                "covariance = 4.0, 3.0, -1.6, 3.0, 9.0, 0.3, -1.6, 0.3, 1.0 /", scene, error)
      if (allocated(error)) return
      x = values_of(scene)
      call check_close(error, [correlation(x(1, :), x(2, :)), correlation(x(1, :), x(3, :)), &
                               correlation(x(2, :), x(3, :))], [0.5_wp, -0.8_wp, 0.1_wp], 0.015_wp, 'correlations')
      call check_below(error, distance_to_uniform(normal_probability((x(2, :) - 20)/3)), seldom, 'second')
      call check_below(error, distance_to_uniform(normal_probability(x(3, :))), seldom, 'third')
   end subroutine covariances

   !> Two numbers that are one.
   subroutine flat_covariance(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      real(wp), allocatable :: x(:, :)
      allocate (scene)
      call make("&ensemble members = 100 /"// &
                "&vary key = 'initial.angular_velocity', distribution = 'normal', mean = 0.0, 0.0, 0.0, "// &
                "covariance = 1.0, 2.0, 0.0, 2.0, 4.0, 0.0, 0.0, 0.0, 0.0 /", scene, error)
      if (allocated(error)) return
      x = values_of(scene)
      call check_below(error, maxval(abs(x(2, :) - 2*x(1, :))), 8*eps, 'off the line')
      call check_below(error, maxval(abs(x(3, :))), 0.0_wp, 'no variance')
   end subroutine flat_covariance

   !> The angle θ has the probability (θ - sin θ)/π, every column of the matrix is uniform on the sphere.
   subroutine rotations(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      real(wp), allocatable :: q(:, :), angle(:), cosine(:, :)
      real(wp) :: r(3, 3)
      integer :: i
      allocate (scene)
      call make("&ensemble members = 20000, seed = 5 /"// &
                "&vary key = 'initial.quaternion', distribution = 'rotation' /", scene, error)
      if (allocated(error)) return
      q = values_of(scene)
      call check_below(error, maxval(abs(sum(q**2, dim=1) - 1)), 4*eps, 'norm')
      angle = 2*acos(min(abs(q(1, :)), 1.0_wp))
      call check_below(error, distance_to_uniform((angle - sin(angle))/acos(-1.0_wp)), seldom, 'angle')
      allocate (cosine(9, size(q, 2)))
      do i = 1, size(q, 2)
         r = rotation_matrix(q(:, i))
         cosine(:, i) = reshape(r, [9])
      end do
      do i = 1, 9
         call check_below(error, distance_to_uniform(min((cosine(i, :) + 1)/2, 1 - eps)), seldom, 'a cosine')
      end do
   end subroutine rotations

   subroutine latin(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      real(wp), allocatable :: x(:, :)
      logical, allocatable :: met(:, :)
      integer :: i
      allocate (scene)
      call make("&ensemble members = 1000, seed = 6, sampling = 'latin' /"// &
                "&vary key = 'initial.angular_velocity.1', distribution = 'uniform', low = 0.0, high = 1.0 /"// &
                "&vary key = 'initial.angular_velocity.2', distribution = 'normal', sigma = 1.0 /", scene, error)
      if (allocated(error)) return
      x = values_of(scene)
      x(2, :) = normal_probability(x(2, :))
      allocate (met(2, 0:999), source=.false.)
      do i = 1, 1000
         met(1, int(1000*x(1, i))) = .true.
         met(2, int(1000*x(2, i))) = .true.
      end do
      call check(error, all(met), 'a part without a member')
      ! Far better than chance: a sample with one in each part is within 1/n of the distribution.
      call check_below(error, distance_to_uniform(x(1, :)), 1.01_wp/sqrt(1000.0_wp), 'distance')
      call check_below(error, abs(correlation(x(1, :), x(2, :))), 0.1_wp, 'independent')
   end subroutine latin

   subroutine grids(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      real(wp), allocatable :: x(:, :)
      allocate (scene)
      call make("&ensemble file = 'grid.npy' /"// &
                "&vary key = 'initial.angular_velocity.2', distribution = 'grid', low = -1, high = 1, points = 3 /"// &
                "&vary key = 'body.inertia.1', 'body.inertia.2', distribution = 'grid', low = 4.9, 20.0, "// &
                "high = 5.1, 99.0, points = 2, 1 /", scene, error)
      if (allocated(error)) return
      call check(error, scene%ensemble%members == 6_long, 'not 3 times 2 members')
      x = values_of(scene)
      call check_close(error, x(1, :), [-1.0_wp, -1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp], 0.0_wp, 'slow')
      call check_close(error, x(2, :), [4.9_wp, 5.1_wp, 4.9_wp, 5.1_wp, 4.9_wp, 5.1_wp], 0.0_wp, 'fast')
      call check_close(error, x(3, :), spread(20.0_wp, 1, 6), 0.0_wp, 'one point')
   end subroutine grids

   !> The second torque; a number of a key that the scene does not give.
   subroutine names(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(member_t) :: member
      type(status_t) :: status
      allocate (scene)
      call make("&torque body = 1.0, 2.0, 3.0 /"//"&torque space = 4.0, 5.0, 6.0 /"//"&ensemble members = 2 /"// &
                "&vary key = 'TORQUE.2.Space.3', distribution = 'uniform', low = 7.0, high = 7.0 /"// &
                "&vary key = 'torque.2.frequency', distribution = 'uniform', low = 0.5, high = 0.5 /", scene, error)
      if (allocated(error)) return
      call check(error, scene%ensemble%targets(1)%name == 'torque.2.space.3', 'another name')
      call member%prepare(scene)
      call member%set_values(scene%ensemble, 1_long, status)
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      associate (groups => member%scene%groups)
         call check_close(error, groups(4)%vector('body', [0.0_wp, 0.0_wp, 0.0_wp]), [1.0_wp, 2.0_wp, 3.0_wp], 0.0_wp)
         call check_close(error, groups(5)%vector('space', [0.0_wp, 0.0_wp, 0.0_wp]), [4.0_wp, 5.0_wp, 7.0_wp], 0.0_wp)
         call check_close(error, groups(5)%number('frequency', 0.0_wp), 0.5_wp, 0.0_wp)
      end associate
      call check(error, member%scene%system%effects%n_torques == 2, 'effects are added again with each member')
   end subroutine names

   subroutine whole_numbers(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(member_t) :: member
      type(status_t) :: status
      allocate (scene)
      call make("&ensemble members = 1 /"//"&vary key = 'integrator.max_iterations', distribution = 'uniform', "// &
                "low = 7.4, high = 7.4 /", scene, error)
      if (allocated(error)) return
      call member%prepare(scene)
      call member%set_values(scene%ensemble, 1_long, status)
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      call check(error, member%scene%integrator%max_iterations == 7, 'not rounded')
      call check_close(error, member%values, [7.0_wp], 0.0_wp, 'the row tells another number')
   end subroutine whole_numbers

   !> Numbers of a member, written into a scene: the same end.
   subroutine members_by_hand(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene, other
      type(member_t) :: member
      type(status_t) :: status
      character(len=:), allocatable :: message
      character(len=400) :: text
      integer(long) :: k
      allocate (scene, other)
      call make("&ensemble members = 5, seed = 9 /"// &
                "&vary key = 'initial.angular_velocity', distribution = 'normal', sigma = 0.1, 0.2, 3.0 /"// &
                "&vary key = 'body.inertia', distribution = 'uniform', low = 4.9, 19.6, 16.7, "// &
                "high = 5.1, 20.4, 17.3 /"// &
                "&vary key = 'initial.quaternion', distribution = 'rotation' /", scene, error)
      if (allocated(error)) return
      call member%prepare(scene)
      do k = 1, 5
         call member%set_values(scene%ensemble, k, status)
         write (text, '("&body inertia =",3es25.16e3," /&initial angular_velocity =",3es25.16e3,'// &
                '" quaternion =",4es25.16e3," /&integrator time_step = 0.01, end_time = 0.2 /")') &
                member%values(4:6), member%values(1:3), member%values(7:10)
         call parse_scene(trim(text), 'box.nml', other, status, message)
         call check(error, status%ok(), message)
         if (allocated(error)) return
         call check_close(error, [member%scene%initial%q, member%scene%initial%p], [other%initial%q, other%initial%p], &
                          0.0_wp, 'the start')
         call check_close(error, member%scene%system%body%moments, other%system%body%moments, 0.0_wp, 'moments')
      end do
   end subroutine members_by_hand

   !> An inertia of no body, and a number out of range.
   subroutine refusals(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(row_layout_t) :: layout
      type(status_t) :: status
      integer(long), allocatable :: fields(:, :)
      integer :: at
      allocate (scene)
      call make("&ensemble members = 4 /"// &
                "&vary key = 'body.inertia.1', distribution = 'grid', low = 5.0, high = 50.0, points = 2 /"// &
                "&vary key = 'integrator.end_time', distribution = 'grid', low = -0.2, high = 0.2, points = 2 /", &
                scene, error)
      if (allocated(error)) return
      call make_layout(scene, layout, status)
      call run_members(scene, layout, 1_long, 4_long, fields, status)
      call check(error, all(fields(1, :) == [1, 2, 3, 4]), 'members')
      call check(error, all(fields(2, :) == [NUTATE_BAD_SCENE, 0, NUTATE_BAD_BODY, NUTATE_BAD_BODY]), 'status')
      call check_close(error, real_of(fields(3:4, 3)), [50.0_wp, -0.2_wp], 0.0_wp, 'the values that were refused')
      at = layout%values + 1
      call check_close(error, real_of(fields(at, 2)), 0.2_wp, eps, 'the end')
      call check(error, real_of(fields(at, 1)) /= real_of(fields(at, 1)), 'a time of a run that was not')
      call run_members(scene, layout, 0_long, 2_long, fields, status)
      call check(error, .not. status%ok(), 'a member 0')
      call run_members(scene, layout, 3_long, 5_long, fields, status)
      call check(error, .not. status%ok(), 'a member after the last')
   end subroutine refusals

   !> Rows of members run by one runner in their order, and each by one of its own.
   subroutine members_are_alone(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      integer(long), allocatable :: fields(:, :)
      allocate (scene)
      call make("&ensemble members = 12, seed = 2 /"// &
                "&event when = 'omega3', crosses = 9.0, switch = 'push toggle' /"// &
                "&torque name = 'push', body = 1, 2, 3 /"// &
                "&vary key = 'body.inertia.1', distribution = 'uniform', low = 1.0, high = 9.0 /"// &
                "&vary key = 'initial.angular_velocity', distribution = 'normal', sigma = 1.0, 1.0, 1.0 /", &
                scene, error)
      if (allocated(error)) return
      call compare_rows(scene, fields, error)
      call check(error, any(fields(2, :) /= 0) .and. any(fields(2, :) == 0), 'none refused, or all')
   end subroutine members_are_alone

   !> Every third member turns no frame.
   subroutine rotated_frames(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      integer(long), allocatable :: fields(:, :)
      allocate (scene)
      call make("&rotating_frame rate = 0, 0, 0 / &rotor momentum = 0, 1, 2 / &ensemble members = 12 /"// &
                "&vary key = 'rotating_frame.rate.3', distribution = 'grid', low = -1, high = 1, points = 3 /", &
                scene, error)
      if (allocated(error)) return
      call compare_rows(scene, fields, error)
      call check(error, all(fields(2, :) == 0), 'statuses')
   end subroutine rotated_frames

   !> Members with an accuracy, by each method that it can choose: Euler angles, which are followed through a run, have
   !> it run once more behind its trial runs. Some need more steps than they are allowed.
   subroutine trial_runs_are_runs(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: worlds(6) = [character(len=96) :: "accuracy = 1e-6 /", &
         "accuracy = 1e-3 / &rotor momentum = 0, 2, 5 /", "accuracy = 1e-9 / &rotor momentum = 0, 2, 5 /", &
         "accuracy = 1e-5 / &gravity acceleration = 0, 0, -9.8 / &torque body = 0.1, 0, 0 /", &
         "accuracy = 1e-7 / &gravity acceleration = 0, 0, -9.8 /", &
         "method = 'dop853', accuracy = 1e-6 / &rotor momentum = 0, 2, 5 /"]
      integer(long), allocatable :: once(:, :), twice(:, :)
      integer :: i
      do i = 1, size(worlds)
         call run_world(worlds(i), "'quaternion', 'energy'", i == size(worlds), once, error)
         call run_world(worlds(i), "'quaternion', 'energy', 'euler'", i == size(worlds), twice, error)
         if (allocated(error)) return
         ! The three of 'euler' stand between quaternions and energies. Errors, the last two, are of the same steps, but
         ! for a free body with its closed solution.
         call check(error, all(once(:10, :) == twice(:10, :)), 'another end: '//worlds(i))
         call check(error, all(once(11:15, :) == twice(14:18, :)), 'other energies: '//worlds(i))
         call check(error, all(once(16:, :) == twice(19:, :)) .or. i == 1, 'other errors: '//worlds(i))
         call check(error, any(once(2, :) == 0) .or. i == size(worlds), 'no member arrives: '//worlds(i))
         call check(error, any(once(2, :) /= 0) .or. i < size(worlds), 'all members arrive: '//worlds(i))
      end do
   end subroutine trial_runs_are_runs

   !> Members that differ in their starts, or in their bodies, too, by several methods; some need more steps than they
   !> are allowed, or have a torque switched.
   subroutine starts_are_alone(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: push = "&torque name = 'push', body = 1, 2, 3, start = 0.5, stop = 2 / ", &
         weight = "&gravity acceleration = 0, 0, -9.8 / ", bodies = &
         "&vary key = 'body.inertia.1', distribution = 'uniform', low = 4, high = 6 / ", &
         worlds(12) = [character(len=160) :: &
         "'taylor' /", "'taylor' / "//weight, "'taylor' / "//push//weight//"&damping coefficient = 0.1, 0.2, 0.3 /", &
         "'taylor' / &wheel axis = 0, 0, 1, inertia = 0.2, torque = 0.1 / &rotating_frame rate = 0, 0.1, 0.2 /", &
         "'taylor' / &event when = 'omega3', crosses = 6.0, switch = 'push toggle' / "//push, "'taylor' /", &
         "'exact' /", &
         "'taylor' / &orbit altitude = 5e5 / &gravity_gradient /", &
         "'auto' / "//weight, "'dop853', conserve = .true. / "//weight, "'taylor' / "//weight//bodies, &
         "'nielsen_krenk' / "//weight//bodies]
      class(scene_t), allocatable :: scene
      integer(long), allocatable :: fields(:, :)
      integer :: i
      do i = 1, size(worlds)
         allocate (scene)
         call make_world("local_tolerance = 1e-9, method = "//trim(worlds(i)), "'quaternion', 'energy'", .false., &
                         scene, error)
         if (allocated(error)) return
         if (i == 6) scene%plan%max_steps = 5
         call compare_rows(scene, fields, error)
         call check(error, any(fields(2, :) == 0) .and. (any(fields(2, :) /= 0) .eqv. i == 6), 'statuses: '//worlds(i))
         deallocate (scene)
      end do
   end subroutine starts_are_alone

   !> A scene that was not read has no ensemble.
   subroutine scenes_without_ensemble(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(row_layout_t) :: layout
      type(status_t) :: status
      allocate (scene)
      call make_layout(scene, layout, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT)
   end subroutine scenes_without_ensemble

   !> Members of a body.
   subroutine run_world(world, columns, is_short, fields, error)
      !> The rest of &integrator, and effects.
      character(len=*), intent(in) :: world, columns
      !> Twenty steps have to do.
      logical, intent(in) :: is_short
      integer(long), allocatable, intent(out) :: fields(:, :)
      type(error_type), allocatable, intent(inout) :: error
      class(scene_t), allocatable :: scene
      type(row_layout_t) :: layout
      type(status_t) :: status
      allocate (scene)
      call make_world(world, columns, is_short, scene, error)
      if (allocated(error)) return
      call make_layout(scene, layout, status)
      call run_members(scene, layout, 1_long, 8_long, fields, status)
   end subroutine run_world

   !> Makes a scene with members of a body.
   subroutine make_world(world, columns, is_short, scene, error)
      !> As of `run_world`.
      character(len=*), intent(in) :: world, columns
      logical, intent(in) :: is_short
      type(scene_t), intent(inout) :: scene
      type(error_type), allocatable, intent(inout) :: error
      type(status_t) :: status
      character(len=:), allocatable :: message
      call parse_scene("&body inertia = 5, 20, 17, mass = 12, center_of_mass = 0, 0, 0.3 / "//line_feed// &
                       "&initial angular_velocity = 0.1, 1, 6 / &integrator end_time = 3, "//world//line_feed// &
                       "&output columns = "//columns//" / &ensemble members = 8 / "//line_feed//"&vary key = "// &
                       "'initial.angular_velocity', distribution = 'normal', sigma = 0.5, 0.5, 2 /", &
                       'world.nml', scene, status, message)
      call check(error, status%ok(), message)
      if (is_short) scene%plan%max_steps = 20
   end subroutine make_world

   !> Members of scenes with effects of the program have the rows of scenes that name them, whatever is built again.
   subroutine added_effects(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: varied(4) = [character(len=40) :: 'initial.angular_velocity.2', 'body.inertia.2', &
                                                  'rotor.momentum.1', 'integrator.end_time']
      character(len=*), parameter :: named = "&dipole moment = 9, 0, 30, field = 5, 0, 2 / "// &
                                     "&damping coefficient = 0.1, 0.2, 0.3 / "
      class(scene_t), allocatable :: scene, by_name
      integer(long), allocatable :: fields(:, :), expected(:, :)
      character(len=:), allocatable :: text
      integer :: i
      allocate (scene, by_name)
      do i = 1, size(varied)
         text = "&ensemble members = 6 / &vary key = '"//trim(varied(i))//"', distribution = 'uniform', "// &
                merge("low = 16, high = 21 / ", "low = 0.1, high = 2 / ", i == 2)
         if (i == 3) text = text//"&rotor momentum = 0, 1, 2 / "
         call make(text, scene, error)
         if (.not. allocated(error)) call make(text//named, by_name, error)
         if (allocated(error)) return
         call scene%system%effects%add(dipole_t([9.0_wp, 0.0_wp, 30.0_wp], [5.0_wp, 0.0_wp, 2.0_wp]))
         call scene%system%effects%add(damping_t(name='damping', coefficient=[0.1_wp, 0.2_wp, 0.3_wp]))
         call compare_rows(scene, fields, error)
         call compare_rows(by_name, expected, error)
         if (allocated(error)) return
         call check(error, all(expected(2, :) == 0) .and. all(fields == expected), 'another row: '//trim(varied(i)))
      end do
   end subroutine added_effects

   !> Compares the rows of members run by one runner in their order with those of each alone.
   subroutine compare_rows(scene, fields, error)
      !> Scene with an ensemble.
      type(scene_t), intent(in) :: scene
      !> Shape (fields, members).
      integer(long), allocatable, intent(out) :: fields(:, :)
      type(error_type), allocatable, intent(inout) :: error
      type(row_layout_t) :: layout
      type(status_t) :: status
      integer(long), allocatable :: alone(:, :)
      integer(long) :: k
      call make_layout(scene, layout, status)
      call run_members(scene, layout, 1_long, scene%ensemble%members, fields, status)
      do k = 1, scene%ensemble%members
         call run_members(scene, layout, k, k, alone, status)
         call check(error, all(fields(:, k) == alone(:, 1)), 'another row for a member alone')
      end do
   end subroutine compare_rows

   !> Runs each method with events and a torque, Euler angles and an accuracy: rows of runs that reach their end.
   subroutine everything(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: methods(7) = [character(len=48) :: &
                                     "method = 'rk4', time_step = 0.01", "method = 'rk8', time_step = 0.01", &
                                     "method = 'dop853', local_tolerance = 1e-9", &
                                     "method = 'taylor', accuracy = 1e-9", &
                                     "order = 4, time_step = 0.01", "formulation = 'reduced', time_step = 0.01", &
                                     "method = 'auto', accuracy = 1e-6"]
      class(scene_t), allocatable :: scene
      type(row_layout_t) :: layout
      type(status_t) :: status
      character(len=:), allocatable :: message
      integer(long), allocatable :: fields(:, :)
      integer :: i
      allocate (scene)
      do i = 1, size(methods)
         call parse_scene("&body inertia = 2, 3, 4, mass = 1, center_of_mass = 0, 0, 0.3 /"// &
                          "&initial angular_velocity = 1, -2, 6 / &gravity / &torque body = 1, 0, -2 /"// &
                          "&integrator "//trim(methods(i))//", end_time = 0.4 /"// &
                          "&output columns = 'euler', 'energy' /"// &
                          "&event when = 'omega1', crosses = 2.0 / &ensemble members = 3 /"// &
                          "&vary key = 'body.mass', distribution = 'uniform', low = 1, high = 2 /", &
                          'top.nml', scene, status, message)
         call check(error, status%ok(), message)
         if (allocated(error)) return
         call make_layout(scene, layout, status)
         call run_members(scene, layout, 1_long, 3_long, fields, status)
         call check(error, all(fields(2, :) == 0), trim(methods(i)))
         call check_below(error, maxval(abs(real_of(fields(layout%values + 1, :)) - 0.4_wp)), 4*eps, 'the end')
      end do
   end subroutine everything

end submodule test_ensemble
