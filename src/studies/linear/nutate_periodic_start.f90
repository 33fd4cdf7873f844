!> Periodic motions of bodies in spin-orbit resonance, by shooting: the forced librations without the free ones.
!>
!> In the resonance p a body rotates by 2πp about the normal of its orbit in a revolution, p a multiple of ½, since half
!> a rotation leaves gravity gradients unchanged. With z the normal and P the period, the initial state is a root of
!>
!>     log((Rz(2πp)∘q(0))*∘q(P)) = 0,   Ω(P) - Ω(0) = 0:
!>
!> six equations in the rotation x of q(0)∘exp(½x) and the change of Ω(0). The Jacobian of Newton's method, M - I,
!> follows from the sensitivities of the run.
module nutate_periodic_start
   use nutate_attitude, only: quat_from_euler, quat_from_matrix, quat_from_rotation_vector, rotation_vector_from_quat
   use nutate_variation, only: attitude_variation, variation_t, rate_variation
   use nutate_effect_list, only: effect_list_t
   use nutate_hamiltonian, only: angular_velocity, make_state
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: wp, long, pi
   use nutate_lapack, only: dgesvd, general_eigenvalues, handle_info
   use nutate_quaternion, only: cross, quat_conjugate, quat_normalized, quat_product, rotate_to_space
   use nutate_run, only: run_t
   use nutate_run_plan, only: run_plan_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_stepper, only: integrator_settings_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: periodic_start_t, find_periodic_start

   !> Error of a step, rad, and limit of steps in a revolution.
   real(wp), parameter :: step_error = 1e-15_wp
   integer(long), parameter :: most_steps = 5000
   !> Limits of the iteration; the longest change, rad and mean motions, for which the map is treated as linear.
   integer, parameter :: most_iterations = 30
   real(wp), parameter :: longest_change = 0.1_wp
   !> A defect below this that no longer falls is due to rounding.
   real(wp), parameter :: settled = 1e-11_wp
   !> Singular values of M - I below this, relative to the largest, belong to families of periodic motions: the smallest
   !> correction leaves these directions alone.
   real(wp), parameter :: negligible = 1e-12_wp
   !> Rounding moves multipliers by less, by its square root if two of them coincide: multipliers nearer to the unit
   !> circle, or to 1, are treated as being there.
   real(wp), parameter, public :: on_circle = 1e-6_wp
   !> From this ratio of singular values on, a free libration that comes round in a revolution is named as the cause if
   !> the iteration fails.
   real(wp), parameter :: ill_conditioned = 1e6_wp

   !> A periodic motion at t = 0.
   type :: periodic_start_t
      !> Unit quaternion, body→space; shape (4). Ω, body axes, rad/s; shape (3).
      real(wp) :: q(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], omega(3) = 0.0_wp
      !> M, the derivative of rotation and Ω/n after a revolution by those at the start, body axes; its eigenvalues are
      !> the multipliers exp(2πi·frequency/n). Shape (6, 6).
      real(wp) :: monodromy(6, 6) = 0.0_wp
      complex(wp) :: multipliers(6) = (0.0_wp, 0.0_wp)
      !> Ratio of the largest to the smallest singular value of M - I that is not negligible; number of negligible ones.
      real(wp) :: condition = 1.0_wp
      integer :: n_families = 0
      !> Largest number of the equations, rad and mean motions; revolutions computed.
      real(wp) :: defect = huge(1.0_wp)
      integer :: revolutions = 0
   contains
      !> Frequencies of the free librations, in units of the mean motion, without their whole numbers.
      procedure :: free_frequencies
      !> The largest modulus of a multiplier.
      procedure :: growth
   end type periodic_start_t

contains

   !> Finds the periodic motion of a spin-orbit resonance, from the axis of the least moment along the periapsis, that
   !> of the largest along the normal, and Ω = pn.
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT` unless the body moves on one closed orbit in inertial axes, and has no wheels; if
   !> the motion has no derivative; if the iteration finds no periodic motion.
   subroutine find_periodic_start(system, turns, start, status)
      type(system_t), intent(in) :: system
      !> p, rotations of the body in a revolution, a multiple of ½.
      real(wp), intent(in) :: turns
      type(periodic_start_t), intent(out) :: start
      type(status_t), intent(out) :: status
      type(periodic_start_t) :: trial
      real(wp) :: residual(6), change(6), rate, worst
      call check_orbit(system%effects, status)
      if (.not. status%ok()) return
      rate = system%effects%orbit%path%mean_motion()
      call guess(system, turns, trial%q, trial%omega)
      worst = 1.0_wp
      do while (trial%revolutions < most_iterations)
         trial%revolutions = trial%revolutions + 1
         call revolve(system, turns, trial, residual, status)
         if (.not. status%ok()) return
         trial%defect = maxval(abs(residual))
         if (start%defect <= settled .and. trial%defect >= 0.5_wp*start%defect) exit
         call correct(trial, residual, change, status)
         if (.not. status%ok()) return
         worst = max(worst, trial%condition)
         start = trial
         change = change*min(1.0_wp, longest_change/max(maxval(abs(change)), tiny(1.0_wp)))
         trial%q = quat_normalized(quat_product(trial%q, quat_from_rotation_vector(change(1:3))))
         trial%omega = trial%omega + rate*change(4:6)
      end do
      if (start%defect <= settled) then
         call general_eigenvalues(start%monodromy, start%multipliers, status)
      else if (max(worst, trial%condition) > ill_conditioned) then
         status = fail(NUTATE_BAD_ARGUMENT, 'no periodic motion was found in this resonance: a free libration '// &
                       'comes round in a whole fraction of a revolution (expected other moments, or a start by '// &
                       'attitude and rate)')
      else
         status = fail(NUTATE_BAD_ARGUMENT, 'no periodic motion was found in this resonance (expected one, or a '// &
                       'start by attitude and rate)')
      end if
   end subroutine find_periodic_start

   !> Returns the frequencies of the free librations, in units of the mean motion: f in 0 to ½ of the multipliers
   !> exp(±2πif) on the unit circle other than 1, largest first. A libration has a frequency k ± f, k whole. Shape
   !> (0 to 3).
   pure function free_frequencies(self) result(frequencies)
      class(periodic_start_t), intent(in) :: self
      real(wp), allocatable :: frequencies(:)
      real(wp) :: all_of_them(3), largest
      integer :: i, n
      all_of_them = 0.0_wp
      associate (values => self%multipliers)
         n = 0
         do i = 1, size(values)
            if (.not. aimag(values(i)) > on_circle .or. abs(abs(values(i)) - 1) > on_circle) cycle
            n = n + 1
            all_of_them(n) = atan2(aimag(values(i)), real(values(i), wp))/(2*pi)
         end do
      end associate
      allocate (frequencies(n))
      do i = 1, n
         largest = maxval(all_of_them)
         frequencies(i) = largest
         all_of_them(maxloc(all_of_them, dim=1)) = -1.0_wp
      end do
   end function free_frequencies

   !> Returns the largest modulus of a multiplier: the factor by which a deviation can grow in a revolution.
   pure real(wp) function growth(self)
      class(periodic_start_t), intent(in) :: self
      growth = maxval(abs(self%multipliers))
   end function growth

   !> Checks that the body moves on one closed orbit in inertial axes, and has no wheels. Errors: those of
   !> `find_periodic_start`.
   subroutine check_orbit(effects, status)
      type(effect_list_t), intent(in) :: effects
      type(status_t), intent(out) :: status
      character(len=:), allocatable :: fault
      fault = ''
      if (.not. effects%on_orbit) then
         fault = 'there is no orbit (expected &orbit)'
      else if (size(effects%orbits) > 1) then
         fault = 'several orbits have no common period (expected one &orbit)'
      else if (.not. effects%orbit%path%mean_motion() > 0.0_wp) then
         fault = 'the orbit is not closed (expected elements with eccentricity < 1)'
      else if (effects%frame_turns) then
         fault = "the space axes turn (expected frame = 'inertial' in &orbit)"
      else if (effects%n_wheels > 0) then
         fault = 'wheels keep no period (expected a body without them)'
      end if
      if (fault /= '') status = fail(NUTATE_BAD_ARGUMENT, 'resonance: '//fault)
   end subroutine check_orbit

   !> Computes the initial guess: the rotation at the constant rate pn through periapsis.
   subroutine guess(system, turns, q, omega)
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: turns
      real(wp), intent(out) :: q(4), omega(3)
      real(wp) :: long_axis(3), short_axis(3), rows(3, 3), mean_anomaly
      associate (body => system%body, path => system%effects%orbit%path)
         short_axis = body%axes(:, maxloc(body%moments, dim=1, back=.true.))
         long_axis = body%axes(:, minloc(body%moments, dim=1))
         rows(1, :) = long_axis
         rows(2, :) = cross(short_axis, long_axis)
         rows(3, :) = short_axis
         mean_anomaly = path%mean_anomaly
         if (path%is_from_periapsis()) mean_anomaly = -path%mean_motion()*path%periapsis_time
         q = quat_product(quat_from_euler(path%raan, path%inclination, path%argument_of_periapsis + &
                                          turns*mean_anomaly), quat_from_matrix(rows))
         omega = turns*path%mean_motion()*short_axis
      end associate
   end subroutine guess

   !> Computes a revolution with its derivative, and the residual of the equations after it.
   subroutine revolve(system, turns, start, residual, status)
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: turns
      type(periodic_start_t), intent(inout) :: start
      !> Residual, rad and n; shape (6).
      real(wp), intent(out) :: residual(6)
      type(status_t), intent(out) :: status
      type(run_t) :: run
      type(run_plan_t) :: plan
      type(variation_t) :: variations(6)
      real(wp) :: rate, normal(3), target(4)
      integer :: i
      residual = 0.0_wp
      associate (path => system%effects%orbit%path)
         rate = path%mean_motion()
         normal = rotate_to_space(quat_from_euler(path%raan, path%inclination, 0.0_wp), [0.0_wp, 0.0_wp, 1.0_wp])
      end associate
      plan%end_time = 2*pi/rate
      plan%goal%local_tolerance = step_error
      plan%max_steps = most_steps
      do i = 1, 3
         variations(i) = attitude_variation(i)
         variations(3 + i) = rate_variation(i)
      end do
      call run%begin(system, integrator_settings_t(method='dop853'), make_state(system, start%q, start%omega), &
                     plan, status)
      if (status%ok()) call run%differentiate(variations, system, status)
      if (status%ok()) call run%run_to_end(system, status)
      if (.not. status%ok()) then
         status = fail(NUTATE_BAD_ARGUMENT, 'resonance: '//trim(status%message))
         return
      end if
      target = quat_product(quat_from_rotation_vector(2*pi*turns*normal), start%q)
      residual(1:3) = rotation_vector_from_quat(quat_product(quat_conjugate(target), run%state%q))
      residual(4:6) = (angular_velocity(system, run%state) - start%omega)/rate
      start%monodromy(1:3, :) = transpose(run%tangent%theta)
      start%monodromy(4:6, :) = transpose(run%tangent%rates(system, run%state))/rate
      start%monodromy(:, 4:6) = rate*start%monodromy(:, 4:6)
   end subroutine revolve

   !> Computes the smallest correction by Newton's method. Errors: those of dgesvd.
   subroutine correct(start, residual, change, status)
      type(periodic_start_t), intent(inout) :: start
      real(wp), intent(in) :: residual(6)
      !> Correction, rad and n; shape (6).
      real(wp), intent(out) :: change(6)
      type(status_t), intent(out) :: status
      real(wp) :: jacobian(6, 6), u(6, 6), vt(6, 6), values(6), work(60)
      integer :: i, info
      change = 0.0_wp
      jacobian = start%monodromy
      do i = 1, 6
         jacobian(i, i) = jacobian(i, i) - 1
      end do
      call dgesvd('A', 'A', 6, 6, jacobian, 6, values, u, 6, vt, 6, work, size(work), info)
      status = handle_info('dgesvd', info)
      if (.not. status%ok()) return
      start%n_families = count(values <= negligible*values(1))
      if (start%n_families == 6) return
      associate (n => 6 - start%n_families)
         start%condition = values(1)/values(n)
         change = -matmul(matmul(residual, u(:, :n))/values(:n), vt(:n, :))
      end associate
   end subroutine correct

end module nutate_periodic_start
