!> Gravity gradients along a circular orbit, in its axes, against values of 20 digits.
module test_orbit_reference
   use nutate_body, only: diagonal, make_body
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_attitude, only: quat_from_roll_pitch_yaw, roll_pitch_yaw_from_quat
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: wp, eps, pi
   use nutate_orbit, only: earth_mu, orbit_t
   use nutate_run, only: integrate
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_problems, only: angular_velocity, conserved_energy, frame_rate_of, make_state, new_problem, problem_t
   use test_support, only: check, check_close, error_type, new_unittest, unittest_type
   implicit none
   private

   public :: collect_orbit_reference, satellite, period, stable, unstable, wide

   real(wp), parameter :: degree = pi/180
   !> 500 km above the Earth: one revolution, s.
   real(wp), parameter :: period = 5676.9780285258586711621_wp

   !> Moments, roll, pitch and yaw at the start, and q, Ω (rad/s) after numbers of revolutions: 20 digits, by
   !> extrapolation in quadruple precision; `growth` is how much errors of the start have grown.
   type :: reference_t
      real(wp) :: moments(3), angles(3), orbits, q(4), omega(3), growth
   end type reference_t

   real(wp), parameter :: stable(3) = [90.0_wp, 100.0_wp, 40.0_wp], unstable(3) = [100.0_wp, 90.0_wp, 40.0_wp]
   real(wp), parameter :: wide(3) = [5.0_wp, -8.0_wp, 10.0_wp]*degree, narrow(3) = 0.1_wp*degree
   type(reference_t), parameter :: references(*) = [ &
      reference_t(stable, wide, 0.25_wp, [0.99208941665421661227_wp, &
         -0.035910920878857413667_wp, 0.024569096760392967104_wp, 0.11775124037014251531_wp], &
         [-0.00032447635921196281448_wp, -0.00090189742842998916845_wp, 2.2012934135052656574e-05_wp], 1.0_wp), &
      reference_t(stable, wide, 1.0_wp, [0.99824869804306540171_wp, &
         -0.027335464915441528947_wp, -0.013860311892227901021_wp, -0.050598428507530396348_wp], &
         [0.00024586996952661394459_wp, -0.00092522524178705391308_wp, -0.00018752252379550390027_wp], 1.0_wp), &
      reference_t(stable, wide, 2.0_wp, [0.9969171914585524726_wp, &
         -0.013615941580899065759_wp, 0.060356605437001320248_wp, 0.04824727649701607237_wp], &
         [-0.00021936550183505798294_wp, -0.0010556230242046334593_wp, 0.00018989848734061787482_wp], 1.0_wp), &
      reference_t(stable, wide, 5.0_wp, [0.9960523747826719197_wp, &
         -0.040607620620972435078_wp, -0.037922340588631341819_wp, 0.069228490678207727257_wp], &
         [-0.00018557529054688791623_wp, -0.0009441872263466276299_wp, -0.00023975827572445055698_wp], 1.0_wp), &
      reference_t(stable, wide, 10.0_wp, [0.99038034242713162655_wp, &
         -0.0042955363290317952973_wp, 0.021696297144253534946_wp, -0.13659281237236360162_wp], &
         [0.00034924303973441552777_wp, -0.00084265474759624303127_wp, 2.837951972868528184e-06_wp], 1.0_wp), &
      reference_t(stable, wide, 20.0_wp, [0.99287560490065123774_wp, &
         -0.041300585401872322804_wp, 0.053940404503934274814_wp, 0.097891407184596634726_wp], &
         [-8.0311462350390057607e-05_wp, -0.0011362690241483834296_wp, -0.00010054475673361476324_wp], 1.0_wp), &
      reference_t(stable, wide, 50.0_wp, [0.99651287965456318847_wp, &
         0.0033578841736096625812_wp, -0.0065139732257454621461_wp, 0.083116625588753040587_wp], &
         [-0.00036978769186825003665_wp, -0.0009201056486005850349_wp, 1.8385227541418082487e-05_wp], 1.0_wp), &
      reference_t(unstable, narrow, 0.25_wp, [0.99999744419883542387_wp, &
         -0.00028505404974461449122_wp, -0.00052762985596426922583_wp, 0.0021798960344135669972_wp], &
         [-5.9534947027534138761e-06_wp, -0.0011089455783536313213_wp, 3.6606318195008983017e-06_wp], 1.0_wp), &
      reference_t(unstable, narrow, 1.0_wp, [0.99976327898137289259_wp, &
         0.0016068422469081194628_wp, -0.00074377404087744502836_wp, 0.021685268238673532107_wp], &
         [-4.4420836759358399898e-05_wp, -0.0011072344286019135769_wp, 2.5894028945671995667e-05_wp], 1.0_wp), &
      reference_t(unstable, narrow, 2.0_wp, [0.94502472901083924226_wp, &
         0.030140189976166159157_wp, 0.00015850059917999132624_wp, 0.32560682637768902834_wp], &
         [-0.00065850144303098520405_wp, -0.00086589427931283056975_wp, 0.00036745104463380839721_wp], 1.0_wp), &
      reference_t(unstable, narrow, 5.0_wp, [0.99346924195929517183_wp, &
         -0.011445058411810510994_wp, 0.00070046385624558228019_wp, 0.11352262007705673374_wp], &
         [-0.00024598223573564096294_wp, -0.0010792471624981366622_wp, -0.00013644530439483091718_wp], 1.0_wp), &
      reference_t(unstable, narrow, 10.0_wp, [0.787636154060529922_wp, &
         -0.041242755867249145973_wp, 0.0033263850576515835109_wp, 0.61474975320666855269_wp], &
         [-0.0010895983700884716516_wp, -0.00025018251900472708339_wp, -0.00057046365988315771824_wp], 7e2_wp), &
      reference_t(unstable, narrow, 20.0_wp, [0.94463497310301502966_wp, &
         -0.041113088525460976808_wp, -0.031271916100994825821_wp, 0.32403170956857913816_wp], &
         [-0.00073000397723673160354_wp, -0.0009083648816614685795_wp, -0.0002904853966341029979_wp], 1.3e3_wp), &
      reference_t(unstable, narrow, 50.0_wp, [0.95726029484953102525_wp, &
         0.045320249223514181034_wp, -0.0094918089794824734481_wp, 0.28549730029757637525_wp], &
         [-0.00067426931691584595896_wp, -0.00086527898828839845465_wp, 0.00023469559377217776069_wp], 2.3e5_wp)]

contains

   subroutine collect_orbit_reference(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("the gravity gradient by the series", references_by_series), &
                  new_unittest("the gravity gradient by the series in short steps", references_in_short_steps), &
                  new_unittest("the gravity gradient by order 8", references_by_order_8), &
                  new_unittest("a wide libration in pitch is elliptic", wide_pitch)]
   end subroutine collect_orbit_reference

   !> A body on the circular orbit, rotated by angles against it and at rest in its axes.
   function satellite(moments, angles) result(problem)
      real(wp), intent(in) :: moments(3), angles(3)
      type(problem_t), pointer :: problem
      type(status_t) :: status
      type(orbit_t) :: orbit
      real(wp) :: q(4)
      problem => new_problem()
      call make_body(diagonal(moments), problem%system%body, status)
      orbit = orbit_t(kepler_orbit_t(semi_major_axis=6878137.0_wp, mu=earth_mu), inertial=.false.)
      call problem%system%effects%add(orbit)
      call problem%system%effects%add(gravity_gradient_t(problem%system%body, orbit))
      q = quat_from_roll_pitch_yaw(angles)
      problem%start = make_state(problem%system, q, frame_rate_of(problem%system%effects, q))
   end function satellite

   !> Compares a motion with a reference, with initial errors of 2e-15, which grow as given, or larger ones.
   subroutine check_reference(error, reference, settings, plan, uncertainty)
      type(error_type), allocatable, intent(inout) :: error
      type(reference_t), intent(in) :: reference
      type(integrator_settings_t), intent(in) :: settings
      !> Without its end.
      type(run_plan_t), intent(in) :: plan
      real(wp), intent(in), optional :: uncertainty
      type(run_plan_t) :: whole
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: n, bound
      problem => satellite(reference%moments, reference%angles)
      state = problem%start
      whole = plan
      whole%end_time = reference%orbits*period
      call integrate(problem%system, settings, state, whole, status)
      call check(error, status%ok(), trim(status%message))
      n = 2*pi/period
      bound = 2e-15_wp*reference%growth
      if (present(uncertainty)) bound = uncertainty*reference%growth
      bound = max(1e-11_wp, bound)
      call check_close(error, state%q, reference%q, bound, "attitude")
      call check_close(error, angular_velocity(problem%system, state)/n, reference%omega/n, bound, "rate")
      call check_close(error, conserved_energy(problem%system, state), &
                       conserved_energy(problem%system, problem%start), &
                       1e-13_wp*abs(conserved_energy(problem%system, problem%start)), "H - omega.l")
   end subroutine check_reference

   !> Each of its steps errs by the tolerance of some eps and rounds by as much, in proportion to its length; errors
   !> of the second to fifth revolution of the unstable satellite grow up to seven times as much as those of the start.
   !> After 20 revolutions it shows.
   subroutine references_by_series(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: uncertainty
      integer :: i
      do i = 1, size(references)
         uncertainty = 32*eps
         if (all(references(i)%moments == unstable) .and. references(i)%orbits == 20.0_wp) uncertainty = 7*uncertainty
         call check_reference(error, references(i), integrator_settings_t(method='taylor', conserve=.true.), &
                              run_plan_t(goal=run_goal_t(local_tolerance=1e-15_wp)), uncertainty)
      end do
   end subroutine references_by_series

   !> Checks short steps, whose rounding is in proportion to their length, since the state is a compensated sum.
   subroutine references_in_short_steps(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: i
      do i = 1, size(references)
         call check_reference(error, references(i), &
                              integrator_settings_t(method='taylor', series_order=18, conserve=.true.), &
                              run_plan_t(time_step=period/100))
      end do
   end subroutine references_in_short_steps

   subroutine references_by_order_8(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: i
      do i = 1, size(references)
         call check_reference(error, references(i), integrator_settings_t(order=8, formulation='reduced'), &
                              run_plan_t(time_step=period/merge(400, 100, references(i)%growth > 1e3_wp)))
      end do
      call check_reference(error, references(2), integrator_settings_t(order=8), run_plan_t(time_step=period/100))
   end subroutine references_by_order_8

   !> Released at 30°, at rest in the LVLH frame: sin θ = ½ sn(ωt + K), of modulus ½; digits of the closed form.
   subroutine wide_pitch(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: times(3) = [1000.0_wp, 5000.0_wp, 20000.0_wp]
      real(wp), parameter :: pitch(3) = [0.1621428582548244104252_wp, 0.5233390662621287343289_wp, &
                                         0.5194465503180468908739_wp]
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      integer :: i, form
      problem => satellite(stable, [0.0_wp, 30*degree, 0.0_wp])
      do form = 1, 2
         do i = 1, size(times)
            state = problem%start
            if (form == 1) then
               call integrate(problem%system, integrator_settings_t(method='taylor', conserve=.true.), state, &
                              run_plan_t(goal=run_goal_t(local_tolerance=1e-16_wp), end_time=times(i)), status)
            else
               call integrate(problem%system, integrator_settings_t(order=8, formulation='reduced'), state, &
                              run_plan_t(time_step=25.0_wp, end_time=times(i)), status)
            end if
            call check(error, status%ok(), trim(status%message))
            if (allocated(error)) return
            call check_close(error, roll_pitch_yaw_from_quat(state%q), [0.0_wp, pitch(i), 0.0_wp], 1e-11_wp, "angles")
         end do
      end do
   end subroutine wide_pitch

end module test_orbit_reference
