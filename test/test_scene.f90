!> Scenes in memory: what each key of a scene becomes.
submodule(suites_of_runs) test_scene
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_attitude, only: quat_from_euler
   use nutate_hamiltonian, only: angular_velocity
   use nutate_kinds, only: wp, eps, long, pi
   use nutate_quaternion, only: rotate_to_space
   use nutate_scene, only: scene_t, parse_scene
   use nutate_status, only: status_t
   use test_support, only: check, check_close, error_type, new_unittest, test_failed
   implicit none

   character(len=*), parameter :: body = '&body inertia = 5, 20, 17 / '
   character(len=*), parameter :: initial = '&initial angular_velocity = 0.1, 0, 10 / '
   character(len=*), parameter :: integrator = '&integrator time_step = 0.1, end_time = 2 / '

contains

   module procedure collect_scene
      testsuite = [ &
         new_unittest("what a scene does not say has its default", defaults), &
         new_unittest("names come from the file, titles from the scene", names_and_titles), &
         new_unittest("a tensor keeps its off-diagonal entries", tensor_entries), &
         new_unittest("shapes have the moments of the formulas", shapes), &
         new_unittest("moments about the centre of mass are moved to the reference point", parallel_axis_rule), &
         new_unittest("moments that no body has are admitted on request", triangle_on_request), &
         new_unittest("a quaternion is normalised", quaternion_is_normalised), &
         new_unittest("an axis and an angle make an attitude", axis_and_angle), &
         new_unittest("Euler angles are precession, nutation, spin", euler_angles), &
         new_unittest("Euler rates become body rates", euler_rates), &
         new_unittest("degrees apply to all angles and rates", degrees), &
         new_unittest("a space rate is turned into body axes", space_rate), &
         new_unittest("integrator settings arrive", integrator_settings), &
         new_unittest("auxiliary inertia may be infinite", infinite_auxiliary_inertia), &
         new_unittest("a negative pair of times goes back", backwards), &
         new_unittest("an interval is a number of steps", interval), &
         new_unittest("columns are taken as asked for", columns), &
         new_unittest("an effect is there only if its group is", effects), &
         new_unittest("settings of the command line replace and create", overrides)]
   end procedure collect_scene

   !> Parses a scene that must be right.
   subroutine parse(text, scene, error, settings)
      character(len=*), intent(in) :: text
      type(scene_t), intent(inout) :: scene
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in), optional :: settings(:)
      type(status_t) :: status
      character(len=:), allocatable :: message
      call parse_scene(text, 'scenes/box.nml', scene, status, message, settings)
      if (.not. status%ok()) call test_failed(error, message)
   end subroutine parse

   subroutine defaults(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      allocate (scene)
      call parse(body//initial//integrator, scene, error)
      if (allocated(error)) return
      call check(error, scene%title == 'box' .and. scene%shape == '' .and. scene%output%file == 'box.csv', 'names')
      call check_close(error, scene%initial%q, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], 0.0_wp, 'q')
      call check_close(error, scene%initial%p, [0.0_wp, 1.0_wp, 0.0_wp, 340.0_wp], 0.0_wp, 'p')
      call check(error, scene%integrator%method == 'nielsen_krenk' .and. scene%integrator%order == 2 .and. &
                 scene%integrator%formulation == 'full' .and. scene%integrator%projection .and. &
                 scene%integrator%max_iterations == 20, 'integrator')
      call check_close(error, [scene%integrator%inverse_auxiliary_inertia, scene%integrator%tolerance], &
                       [0.0_wp, 0.0_wp], 0.0_wp, '1/J0 and tolerance')
      call check_close(error, [scene%plan%time_step, scene%plan%end_time], [0.1_wp, 2.0_wp], 0.0_wp, 'times')
      call check(error, scene%plan%every == 1 .and. size(scene%output%columns) == 4, 'rows')
      if (allocated(error)) return
      call check(error, all(scene%output%columns == [character(len=24) :: 'quaternion', 'angular_velocity', 'energy', &
                                                     'constraints']), 'columns')
   end subroutine defaults

   subroutine names_and_titles(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      allocate (scene)
      call parse(body//initial//integrator//"&scene title = 'It''s a ""box""' / &output file = ""o'clock.csv"" /", &
                 scene, error)
      if (allocated(error)) return
      call check(error, scene%title == 'It''s a "box"' .and. scene%output%file == "o'clock.csv", scene%title)
      call parse_scene(body//initial//integrator, '/a/b.c/Top.NML', scene, status, message)
      call check(error, scene%name == 'Top' .and. scene%title == 'Top' .and. scene%file == '/a/b.c/Top.NML', scene%name)
      call parse_scene(body//initial//integrator, 'top.txt', scene, status, message)
      call check(error, scene%name == 'top.txt' .and. scene%output%file == 'top.txt.csv', scene%name)
   end subroutine names_and_titles

   subroutine tensor_entries(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      allocate (scene)
      call parse('&body inertia_tensor = 5, 20, 17, 0.5, -0.25, 0.125 / '//initial//integrator, scene, error)
      if (allocated(error)) return
      call check_close(error, reshape(scene%system%body%inertia, [9]), &
                       [5.0_wp, 0.5_wp, -0.25_wp, 0.5_wp, 20.0_wp, 0.125_wp, -0.25_wp, 0.125_wp, 17.0_wp], 0.0_wp)
   end subroutine tensor_entries

   subroutine shapes(error)
      type(error_type), allocatable, intent(out) :: error
      call check_shape('box', '4, 1, 2', 8.0_wp, [5.0_wp, 20.0_wp, 17.0_wp]/12, error)
      call check_shape('cylinder', '2, 6', 24*pi, [4.0_wp, 4.0_wp, 2.0_wp], error)
      call check_shape('cone', '2, 4', 16*pi/3, [1.2_wp, 1.2_wp, 1.2_wp], error)
      call check_shape('sphere', '5', 500*pi/3, [10.0_wp, 10.0_wp, 10.0_wp], error)
      call check_shape('ellipsoid', '1, 2, 3', 8*pi, [13.0_wp, 10.0_wp, 5.0_wp]/5, error)
   end subroutine shapes

   !> Moments by mass and by density, about the centre of mass.
   subroutine check_shape(name, size, volume, gyration, error)
      character(len=*), intent(in) :: name, size
      real(wp), intent(in) :: volume, gyration(3)
      type(error_type), allocatable, intent(inout) :: error
      class(scene_t), allocatable :: scene
      allocate (scene)
      call parse("&body shape = '"//name//"', size = "//size//', mass = 3 / '//initial//integrator, scene, error)
      if (allocated(error)) return
      call check(error, scene%shape == name, 'shape is kept')
      call check_close(error, scene%system%body%moments, 3*gyration, 8*eps*maxval(3*gyration), name)
      call parse("&body shape = '"//name//"', size = "//size//', density = 2 / '//initial//integrator, scene, error)
      if (allocated(error)) return
      call check_close(error, scene%system%body%mass, 2*volume, 8*eps*volume, name//' mass')
      call check_close(error, scene%system%body%moments, 2*volume*gyration, 16*eps*maxval(2*volume*gyration), name)
   end subroutine check_shape

   subroutine parallel_axis_rule(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      character(len=*), parameter :: off_center = ' mass = 2, center_of_mass = 1, 2, 3 '
      ! 2 (|c|² I - c cᵀ) added to the moments.
      real(wp), parameter :: moved(9) = [31.0_wp, -4.0_wp, -6.0_wp, -4.0_wp, 40.0_wp, -12.0_wp, -6.0_wp, -12.0_wp, &
                                        27.0_wp]
      allocate (scene)
      call parse("&body inertia = 5, 20, 17, inertia_about = 'center_of_mass'"//off_center//'/ '//initial//integrator, &
                 scene, error)
      if (allocated(error)) return
      call check_close(error, reshape(scene%system%body%inertia, [9]), moved, 0.0_wp, 'moments')
      call parse("&body shape = 'box' size = 4, 1, 2, mass = 12, center_of_mass = 0, 0, 0.5 / "//initial//integrator, &
                 scene, error)
      if (allocated(error)) return
      call check_close(error, scene%system%body%moments, [8.0_wp, 23.0_wp, 17.0_wp], 64*eps, 'shape')
      call parse("&body inertia = 50, 60, 70, inertia_about = 'reference'"//off_center//'/ '//initial//integrator, &
                 scene, error)
      if (allocated(error)) return
      call check_close(error, scene%system%body%moments, [50.0_wp, 60.0_wp, 70.0_wp], 0.0_wp, 'reference')
   end subroutine parallel_axis_rule

   subroutine triangle_on_request(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      allocate (scene)
      call parse('&body inertia = 0.345, 0.653, 1, check_triangle = .false. / '//initial//integrator, scene, error)
      if (allocated(error)) return
      call check(error, scene%system%body%breaks_triangle, 'the body is marked')
   end subroutine triangle_on_request

   subroutine quaternion_is_normalised(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      allocate (scene)
      call parse(body//integrator//'&initial quaternion = 0.6000003, 0, 0.8000003, 0, angular_velocity = 3*1 /', &
                 scene, error)
      if (allocated(error)) return
      call check_close(error, norm2(scene%initial%q), 1.0_wp, 2*eps, 'norm')
      call check_close(error, scene%initial%q(2:3)/scene%initial%q(1), [0.0_wp, 0.8000003_wp/0.6000003_wp], 8*eps, 'q')
   end subroutine quaternion_is_normalised

   subroutine axis_and_angle(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      allocate (scene)
      call parse(body//integrator//'&initial axis = 0, 0, 2, angle = 0.5, angular_velocity = 3*1 /', scene, error)
      if (allocated(error)) return
      call check_close(error, scene%initial%q, [cos(0.25_wp), 0.0_wp, 0.0_wp, sin(0.25_wp)], 4*eps)
   end subroutine axis_and_angle

   subroutine euler_angles(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      allocate (scene)
      call parse(body//integrator//'&initial euler = 0.1, 0.2, 0.3, angular_velocity = 3*1 /', scene, error)
      if (allocated(error)) return
      call check_close(error, scene%initial%q, quat_from_euler(0.1_wp, 0.2_wp, 0.3_wp), 0.0_wp)
   end subroutine euler_angles

   !> The steady precession of the paper's top: Ω = (0, 10 sin 60°, 10 cos 60° + 135.6).
   subroutine euler_rates(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      allocate (scene)
      call parse(body//integrator//'&initial euler = 0, 1.0471975511965976, 0, euler_rates = 10, 0, 135.6 /', &
                 scene, error)
      if (allocated(error)) return
      call check_close(error, angular_velocity(scene%system, scene%initial), &
                       [0.0_wp, 10*sin(pi/3), 140.6_wp], 1000*eps)
   end subroutine euler_rates

   subroutine degrees(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      allocate (scene)
      call parse(body//integrator//'&initial axis = 1, 0, 0, angle = 90, angular_velocity = 180, 0, 90, '// &
                 'degrees = T /', scene, error)
      if (allocated(error)) return
      call check_close(error, scene%initial%q, [cos(pi/4), sin(pi/4), 0.0_wp, 0.0_wp], 4*eps, 'angle')
      call check_close(error, angular_velocity(scene%system, scene%initial), [pi, 0.0_wp, pi/2], 16*eps, 'rate')
      call parse(body//integrator//'&initial euler = 0, 60, 0, euler_rates = 0, 0, 360, degrees = .true. /', &
                 scene, error)
      if (allocated(error)) return
      call check_close(error, scene%initial%q, [cos(pi/6), sin(pi/6), 0.0_wp, 0.0_wp], 4*eps, 'euler')
      call check_close(error, angular_velocity(scene%system, scene%initial), [0.0_wp, 0.0_wp, 2*pi], 64*eps, 'rates')
   end subroutine degrees

   subroutine space_rate(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      allocate (scene)
      call parse(body//integrator//"&initial euler = 0.3, 0.7, -0.2, angular_velocity = 1, 2, 3, frame = 'space' /", &
                 scene, error)
      if (allocated(error)) return
      call check_close(error, rotate_to_space(scene%initial%q, angular_velocity(scene%system, scene%initial)), &
                       [1.0_wp, 2.0_wp, 3.0_wp], 64*eps)
   end subroutine space_rate

   subroutine integrator_settings(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      allocate (scene)
      call parse(body//initial//"&INTEGRATOR Method='nielsen_krenk' order=+2, formulation='full' "// &
                 "auxiliary_inertia=2d2 projection=F,tolerance=1E-12 max_iterations=007 time_step=.5 end_time=1./", &
                 scene, error)
      if (allocated(error)) return
      call check_close(error, [scene%integrator%inverse_auxiliary_inertia, scene%integrator%tolerance, &
                               scene%plan%time_step, scene%plan%end_time], [5e-3_wp, 1e-12_wp, 0.5_wp, 1.0_wp], 0.0_wp)
      call check(error, scene%integrator%max_iterations == 7 .and. .not. scene%integrator%projection, 'settings')
   end subroutine integrator_settings

   subroutine infinite_auxiliary_inertia(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      character(len=9), parameter :: infinities(4) = [character(len=9) :: 'Infinity', '+inf', 'INF', '+infinity']
      integer :: i
      allocate (scene)
      do i = 1, size(infinities)
         call parse(body//initial//'&integrator time_step = 0.1, end_time = 2, auxiliary_inertia = '// &
                    infinities(i)//'/', scene, error)
         if (allocated(error)) return
         call check_close(error, scene%integrator%inverse_auxiliary_inertia, 0.0_wp, 0.0_wp, infinities(i))
      end do
   end subroutine infinite_auxiliary_inertia

   subroutine backwards(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      allocate (scene)
      call parse(body//initial//'&integrator time_step = -0.1, end_time = -2 / &output interval = 0.5 /', scene, error)
      if (allocated(error)) return
      call check_close(error, [scene%plan%time_step, scene%plan%end_time], [-0.1_wp, -2.0_wp], 0.0_wp)
      call check(error, scene%plan%every == 5, 'interval of a backward run')
   end subroutine backwards

   subroutine interval(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      allocate (scene)
      call parse(body//initial//integrator//'&output interval = 0.3 /', scene, error)
      if (allocated(error)) return
      call check(error, scene%plan%every == 3, '0.3 s in steps of 0.1 s')
      call parse(body//initial//'&integrator time_step = 1e-9 end_time = 1e6 / &output interval = 1e3 /', scene, error)
      if (allocated(error)) return
      call check(error, scene%plan%every == 1000000000000_long, 'more steps than a short integer counts')
   end subroutine interval

   subroutine columns(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      allocate (scene)
      call parse(body//initial//integrator//"&output columns = 'solver' 'energy', 'angular_velocity_space' "// &
                 'every = 7 /', scene, error)
      if (allocated(error)) return
      call check(error, size(scene%output%columns) == 3, 'three sets')
      if (allocated(error)) return
      call check(error, all(scene%output%columns == [character(len=24) :: 'solver', 'energy', &
                                                     'angular_velocity_space']) .and. scene%plan%every == 7, &
                 'their names')
   end subroutine columns

   subroutine effects(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      allocate (scene)
      call parse(body//initial//integrator, scene, error)
      if (allocated(error)) return
      call check(error, scene%system%effects%n_potentials == 0, 'no effect without a group')
      call parse('&gravity acceleration = 1, 2, 3 / &body inertia = 3*1, mass = 2, center_of_mass = 1, 0, 0 / '// &
                 initial//integrator, scene, error)
      if (allocated(error)) return
      call check(error, scene%system%effects%n_potentials == 1, 'one effect')
      call check_close(error, scene%system%effects%potentials(1)%item%direction, [1.0_wp, 2.0_wp, 3.0_wp], 0.0_wp)
      call check(error, scene%groups(1)%name == 'gravity' .and. scene%groups(2)%count_of('inertia') == 3, &
                 'groups are kept')
   end subroutine effects

   subroutine overrides(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      allocate (scene)
      call parse(body//initial//integrator, scene, error, &
                 [character(len=48) :: 'body.inertia=3*2.0', 'BODY.Mass = 4', 'gravity.acceleration=0,0,-1', &
                  'body.mass=5', "output.columns='energy','solver'", "scene.title='a=b.c'"])
      if (allocated(error)) return
      call check_close(error, [scene%system%body%moments, scene%system%body%mass], &
                       [2.0_wp, 2.0_wp, 2.0_wp, 5.0_wp], 0.0_wp, 'the last setting counts')
      call check_close(error, scene%system%effects%potentials(1)%item%direction, [0.0_wp, 0.0_wp, -1.0_wp], 0.0_wp, &
                       'a group is created')
      call check(error, size(scene%output%columns) == 2 .and. scene%title == 'a=b.c', 'texts')
      if (allocated(error)) return
      call check(error, ieee_is_finite(scene%initial%p(1)), 'state')
   end subroutine overrides

end submodule test_scene
