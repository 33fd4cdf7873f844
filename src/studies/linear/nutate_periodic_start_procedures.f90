!> Bodies of the procedures whose interfaces are in `nutate_periodic_start`.
submodule(nutate_periodic_start) nutate_periodic_start_procedures
   use nutate_attitude, only: quat_from_euler, quat_from_matrix, quat_from_rotation_vector, &
      rotation_vector_from_quat
   use nutate_variation, only: attitude_variation, variation_t, rate_variation
   use nutate_effect_list, only: effect_list_t
   use nutate_hamiltonian, only: angular_velocity, make_state
   use nutate_kinds, only: pi
   use nutate_lapack, only: dgesvd, general_eigenvalues, handle_info
   use nutate_quaternion, only: cross, quat_conjugate, quat_normalized, quat_product, rotate_to_space
   use nutate_run, only: run_t
   use nutate_run_plan, only: run_plan_t
   use nutate_status, only: fail, NUTATE_BAD_ARGUMENT
   use nutate_integrator_settings, only: integrator_settings_t
   implicit none

contains

   module procedure find_periodic_start
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
   end procedure find_periodic_start

   module procedure free_frequencies
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
   end procedure free_frequencies

   module procedure growth
      growth = maxval(abs(self%multipliers))
   end procedure growth

   !> Checks that the body moves on one closed orbit in inertial axes, and has no wheels. Errors: those of
   !> `find_periodic_start`.
   subroutine check_orbit(effects, status)
      type(effect_list_t), intent(in) :: effects
      type(status_t), intent(out) :: status
      character(len=:), allocatable :: fault
      fault = ''
      if (effects%varies) then
         fault = 'the inertia varies (expected no inertia_rate and inertia_table)'
      else if (.not. effects%on_orbit) then
         fault = 'there is no orbit (expected &orbit)'
      else if (size(effects%orbits) > 1) then
         fault = 'several orbits have no common period (expected one &orbit)'
      else if (.not. effects%orbit%path%mean_motion() > 0.0_wp) then
         fault = 'the orbit is not closed (expected elements with eccentricity < 1)'
      else if (effects%frame_turns) then
         fault = "the space axes turn (expected frame = 'inertial' in &orbit)"
      else if (effects%n_wheels > 0) then
         fault = 'wheels and inner spheres keep no period (expected a body without them)'
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

end submodule nutate_periodic_start_procedures
