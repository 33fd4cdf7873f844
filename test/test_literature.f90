!> Problems of the literature with known exact solutions (40-digit Taylor integration): second order, down to 1e-6.
submodule(suites_of_runs) test_literature
   use nutate_body, only: make_shape_body
   use nutate_kinds, only: wp, eps
   use nutate_quaternion, only: attitude_distance
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_problems, only: bruls_top, free_body, make_state, new_problem, precessing_top, problem_t, simo_top, solve, &
      total_energy
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

contains

   module procedure collect_literature
      testsuite = [ &
                  new_unittest("heavy top of Brüls, Cardona and Arnold", heavy_top_of_bruls), &
                  new_unittest("steadily precessing top of Betsch and Kinon", steady_top_of_betsch), &
                  new_unittest("heavy top of Simo and Wong", heavy_top_of_simo), &
                  new_unittest("free body of Hairer and Vilmart", free_body_of_hairer), &
                  new_unittest("water molecule of Hairer and Vilmart", water_molecule_of_hairer), &
                  new_unittest("tumbling box of the simulator comparison", tumbling_box)]
   end procedure collect_literature

   subroutine heavy_top_of_bruls(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: top
      top => bruls_top()
      call check_close(error, total_energy(top%system, top%start), 5435.69679_wp, 0.5e-5_wp, "H")
      call check_convergence(error, top, 0.2_wp, 400, [-0.708279152974312562_wp, 0.438781088126581897_wp, &
                                                       0.545728396145417673_wp, 0.0893997528240050105_wp])
      call check_convergence(error, top, 1.0_wp, 4000, [0.732943980679663718_wp, -0.278285719337612679_wp, &
                                                        0.531824611334162618_wp, -0.320176142736249281_wp])
      call check_convergence(error, top, 2.0_wp, 10000, [0.122947135041533467_wp, -0.491079892550027015_wp, &
                                                         0.350430030343620962_wp, -0.787986887550485669_wp])
   end subroutine heavy_top_of_bruls

   subroutine steady_top_of_betsch(error)
      type(error_type), allocatable, intent(out) :: error
      call check_convergence(error, precessing_top(), 1.0_wp, 2000, &
                             [-0.74129324557326555_wp, 0.49974636690044272_wp, 0.015923842809073599_wp, &
                              -0.44775475884400627_wp])
   end subroutine steady_top_of_betsch

   subroutine heavy_top_of_simo(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: top
      top => simo_top()
      call check_close(error, total_energy(top%system, top%start), 1269.97500520789932_wp, 8*eps*1270, "H")
      call check_convergence(error, top, 10.0_wp, 10000, [0.2438016485933435_wp, 0.0195997964216783492_wp, &
                                                          -0.0187249229592649203_wp, -0.96944622408030772_wp])
   end subroutine heavy_top_of_simo

   !> Also down to an error of 1e-6 rad.
   subroutine free_body_of_hairer(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: exact(4) = [-0.736061364160793936_wp, -0.570786951240350733_wp, -0.299388571830790094_wp, &
                                         -0.206839086104673192_wp]
      type(problem_t), pointer :: body
      type(state_t) :: state
      type(status_t) :: status
      body => free_body([0.6_wp, 0.8_wp, 1.0_wp], [1.8_wp, 0.4_wp, -0.9_wp])
      call check_convergence(error, body, 10.0_wp, 200, exact)
      call solve(body, 10.0_wp/32000, 32000, state, status)
      call check_below(error, attitude_distance(state%q, exact), 1e-6_wp, "error at the shortest step")
   end subroutine free_body_of_hairer

   subroutine water_molecule_of_hairer(error)
      type(error_type), allocatable, intent(out) :: error
      call check_convergence(error, free_body([0.345_wp, 0.653_wp, 1.0_wp], [1.8_wp, 0.4_wp, -0.9_wp]), 10.0_wp, 400, &
                             [-0.590953130059877682_wp, 0.749777146603624299_wp, -0.27756735059869179_wp, &
                              -0.107540663867132049_wp])
   end subroutine water_molecule_of_hairer

   subroutine tumbling_box(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: body
      type(status_t) :: status
      body => new_problem()
      call make_shape_body('box', [0.1_wp, 0.4_wp, 0.9_wp], body%system%body, status, mass=10.0_wp)
      body%start = make_state(body%system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.1_wp, 5.0_wp, 0.1_wp])
      call check_convergence(error, body, 10.0_wp, 2000, [0.22516456341395816_wp, -0.61992756249945249_wp, &
                                                          -0.27702915068719459_wp, 0.69874572364031014_wp])
   end subroutine tumbling_box

   !> The attitude error at time t falls as Δt², slope 2.0 ± 0.1 over three halvings from n steps.
   subroutine check_convergence(error, problem, t, n, exact)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: t, exact(4)
      integer, intent(in) :: n
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: errors(4)
      integer :: i
      do i = 1, 4
         call solve(problem, t/(n*2**(i - 1)), n*2**(i - 1), state, status)
         call check(error, status%ok(), trim(status%message))
         errors(i) = attitude_distance(state%q, exact)
      end do
      call check_close(error, log(errors(1:3)/errors(2:4))/log(2.0_wp), [2.0_wp, 2.0_wp, 2.0_wp], 0.1_wp, "order")
   end subroutine check_convergence

end submodule test_literature
