!> Scenes that are wrong: which line is named, and what is reported. The files of `cli/malformed` hold the single cases
!> of the notation; here is what depends on order, on the command line and on each other.
submodule(suites_of_runs) test_scene_errors
   use nutate_scene, only: scene_t, parse_scene, read_scene
   use nutate_status, only: status_t, NUTATE_BAD_SCENE, NUTATE_IO
   use test_support, only: check, error_type, new_unittest
   implicit none

   character, parameter :: lf = achar(10)
   character(len=*), parameter :: body = '&body inertia = 5, 20, 17 /'//lf
   character(len=*), parameter :: initial = '&initial angular_velocity = 0.1, 0, 10 /'//lf
   character(len=*), parameter :: integrator = '&integrator time_step = 0.1, end_time = 2 /'//lf

   !> A scene, perhaps a setting, and the line that must come.
   type :: case_t
      character(len=200) :: text
      character(len=40) :: setting
      character(len=120) :: message
   end type case_t

contains

   module procedure collect_scene_errors
      testsuite = [ &
         new_unittest("each mistake is named with its line", mistakes), &
         new_unittest("what is missing is named with the group or the last line", missing), &
         new_unittest("mistakes on the command line are named as such", settings), &
         new_unittest("the first mistake of the file is the one reported", first_one), &
         new_unittest("file names in messages are printable", file_names), &
         new_unittest("a file that cannot be read is an error of its own", unreadable)]
   end procedure collect_scene_errors

   !> Every scene must give a message that begins as expected.
   subroutine check_cases(cases, error)
      type(case_t), intent(in) :: cases(:)
      type(error_type), allocatable, intent(inout) :: error
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      character(len=len(cases%setting)) :: setting(1)
      integer :: i
      allocate (scene)
      do i = 1, size(cases)
         setting = cases(i)%setting
         if (setting(1) == '') then
            call parse_scene(trim(cases(i)%text), 'a.nml', scene, status, message)
         else
            call parse_scene(trim(cases(i)%text), 'a.nml', scene, status, message, setting)
         end if
         call check(error, status%code == NUTATE_BAD_SCENE .and. index(message, trim(cases(i)%message)) == 1, &
                    "expected '"//trim(cases(i)%message)//"', got '"//message//"'")
      end do
   end subroutine check_cases

   subroutine mistakes(error)
      type(error_type), allocatable, intent(out) :: error
      call check_cases([ &
         case_t(body//lf//'stray', '', "a.nml:3: 'stray' stands outside of a group"), &
         case_t('&body'//lf//'inertia = 5,'//lf//'20 x', '', &
                "a.nml:3: 'x' is not a number (expected 3 numbers for inertia)"), &
         case_t('&body'//lf//'inertia'//lf//'= 5'//lf//'/', '', 'a.nml:2: inertia has 1 value (expected 3 numbers)'), &
         case_t('&body inertia = 3*1'//lf//'inertia_tensor = 6*1 /'//lf//initial//integrator, '', &
                'a.nml:2: inertia and inertia_tensor in &body exclude each other'), &
         case_t('&body inertia = 3*1'//lf//'density = 1 /'//lf//initial//integrator, '', &
                'a.nml:2: density without a shape'), &
         case_t("&body shape = 'box'"//lf//'mass = 1'//lf//'size = 1, 2 /'//lf//initial//integrator, '', &
                "a.nml:3: wrong number of lengths for shape 'box'"), &
         case_t('&body mass = 1'//lf//'inertia = 1, 2, 4 /'//lf//initial//integrator, '', &
                'a.nml:2: no rigid body has the principal moments'), &
         case_t('&gravity'//lf//'/'//lf//body//initial//integrator, '', &
                'a.nml:1: gravity needs the mass of the body'), &
         case_t(body//initial//'&integrator time_step = 0.1, end_time = 2,'//lf//'projection = F /', '', &
                'a.nml:4: projection = .false. with an infinite auxiliary_inertia'), &
         case_t(body//initial//"&integrator method = 'taylor', time_step = 0.1, end_time = 2,"//lf//'order = 8 /', '', &
                'a.nml:4: order with the method taylor (expected series_order'), &
         case_t(body//initial//"&integrator method = 'taylor', time_step = 0.1, end_time = 2,"//lf// &
                'series_order = 29 /', '', 'a.nml:4: series_order 29 is not available (expected 4 to 28'), &
         case_t(body//initial//'&integrator time_step = 0.1, end_time = 2,'//lf//'series_order = 8 /', '', &
                'a.nml:4: series_order with the method nielsen_krenk'), &
         case_t(body//initial//"&integrator method = 'taylor', time_step = 0.1, end_time = 2,"//lf// &
                "formulation = 'reduced' /", '', 'a.nml:4: taylor has no formulation reduced'), &
         case_t(body//initial//"&integrator method = 'exact', time_step = 0.1, end_time = 2,"//lf//'order = 4 /', '', &
                'a.nml:4: order with the method exact (expected no order with it)'), &
         case_t(body//initial//integrator//'&output'//lf//'interval = 0.15 /', '', &
                'a.nml:5: interval is 1.50000 steps (expected a whole number of steps)'), &
         case_t(body//initial//integrator//"&output file = 'a.nml' /", '', &
                'a.nml:4: file would replace the scene')], error)
   end subroutine mistakes

   subroutine missing(error)
      type(error_type), allocatable, intent(out) :: error
      call check_cases([ &
         case_t(' ', '', 'a.nml:1: the group &body is missing'), &
         case_t(initial//integrator//'! last', '', 'a.nml:3: the group &body is missing'), &
         case_t(body//initial//lf, '', 'a.nml:3: the group &integrator is missing'), &
         case_t(body//initial//'&integrator'//lf//'end_time = 1 /', '', 'a.nml:3: &integrator is incomplete'), &
         case_t('&body'//lf//'mass = 1 /'//lf//initial//integrator, '', 'a.nml:1: &body is incomplete'), &
         case_t(body//'&initial'//lf//'euler = 3*0'//lf//'/'//lf//integrator, '', 'a.nml:2: &initial is incomplete'), &
         case_t(body//initial//'&integrator'//lf//'time_step = 1', '', 'a.nml:3: &integrator is not closed')], error)
   end subroutine missing

   subroutine settings(error)
      type(error_type), allocatable, intent(out) :: error
      call check_cases([ &
         case_t(body//initial//integrator, 'mass=1', &
                "override: 'mass=1' is not a setting (expected GROUP.KEY=VALUE)"), &
         case_t(body//initial//integrator, 'body.mass', "override: 'body.mass' is not a setting"), &
         case_t(body//initial//integrator, '=', "override: '=' is not a setting"), &
         case_t(body//initial//integrator, '.=', "override: unknown group ''"), &
         case_t(body//initial//integrator, 'bodi.mass=1', "override: unknown group 'bodi'"), &
         case_t(body//initial//integrator, 'body.mas=1', "override: unknown key 'mas' in &body"), &
         case_t(body//initial//integrator, 'body.inertia=1,2', 'override: inertia has 2 values (expected 3 numbers)'), &
         case_t(body//initial//integrator, 'body.mass=-1', "override: '-1' is out of range"), &
         case_t(body//initial//integrator, 'body.mass=1 /', "override: '/' follows the value of mass"), &
         case_t(body//initial//integrator, "scene.title='x", 'override: a string is not closed'), &
         case_t(body//initial//integrator, "body.shape='box'", &
                'override: inertia and shape in &body exclude each other'), &
         case_t(body//initial//integrator, 'initial.euler_rates=1,2,3', &
                'override: angular_velocity and euler_rates in &initial exclude each other'), &
         case_t(body//initial//integrator, '-body', &
                "override with '-': 'body' is not a setting (expected GROUP.KEY)"), &
         case_t(body//initial//integrator, '-body.mas', "override with '-': unknown key 'mas' in &body"), &
         case_t(body//initial//integrator, 'body.2.mass=1', 'override: the scene has no group &body number 2'), &
         case_t(body//initial//integrator, '-wheel.2.friction', "override with '-': the scene has no group &wheel"), &
         case_t(body//initial//integrator, 'body.0.mass=1', "override: unknown key '0.mass' in &body"), &
         case_t(body//initial//integrator, '-integrator.end_time', 'a.nml:3: &integrator lacks end_time'), &
         case_t(body//initial//integrator, 'integrator.end_time=-1', &
                'override: end_time and time_step have opposite signs'), &
         case_t(body//initial, 'integrator.end_time=1', 'override: &integrator is incomplete'), &
         case_t(body//initial, 'body.mass=1', 'a.nml:2: the group &integrator is missing'), &
         case_t(body//initial//'&integrator end_time = x /', 'integrator.end_time=1', &
                "a.nml:3: 'x' is not a number")], &
                      error)
   end subroutine settings

   subroutine first_one(error)
      type(error_type), allocatable, intent(out) :: error
      call check_cases([ &
         case_t('&body mass = x'//lf//'mas = 1 / stray', '', "a.nml:1: 'x' is not a number"), &
         case_t('&body mas = 1'//lf//'mass = x / stray', '', "a.nml:1: unknown key 'mas'"), &
         case_t('&body mass = 1 /'//lf//'&initial frame = 3 /', '', "a.nml:2: '3' is not in quotes"), &
         case_t('&body mass = 1 /'//lf//'&body', 'body.mass=x', 'a.nml:2: a second group &body')], error)
   end subroutine first_one

   subroutine file_names(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      allocate (scene)
      call parse_scene('x', 'a'//lf//'b.nml', scene, status, message)
      call check(error, index(message, 'a\x0Ab.nml:1: ') == 1, message)
   end subroutine file_names

   subroutine unreadable(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      allocate (scene)
      call read_scene('no/such/scene.nml', scene, status, message)
      call check(error, status%code == NUTATE_IO .and. message == &
                 'no/such/scene.nml: cannot be read (there is no such file)', message)
      call read_scene('/', scene, status, message)
      call check(error, status%code == NUTATE_IO .and. index(message, '/: cannot be read (') == 1, message)
   end subroutine unreadable

end submodule test_scene_errors
