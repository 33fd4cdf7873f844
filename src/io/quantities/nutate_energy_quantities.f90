!> Quantities of energy and work, and residuals, which show the errors of the integration.
module nutate_energy_quantities
   use nutate_hamiltonian, only: potential_energy, system_t, time_dependent_power
   use nutate_kinds, only: wp
   use nutate_motion, only: motion_t
   use nutate_motion_bounds, only: speed_bounds_t
   use nutate_quantity, only: quantity_t, unit, adds_up, bound_margin, counts, is_round_off, of_effects, of_step, &
      BLACK, GREY, NEEDS_POTENTIAL, NEEDS_WORK, OF_ENERGY, ORANGE, PINK, SKY
   use nutate_small_products, only: vector_length
   implicit none
   private

   public :: energy_fastest, energy_greatest, energy_rate, energy_size, energy_value
   public :: Q_ENERGY, Q_CONSTRAINTS, Q_SOLVER, Q_JACOBI, Q_TIME_DEPENDENT_WORK, Q_ENERGIES, Q_WORKS

   !> Kinds: one case evaluates all components of a kind. Those from `Q_BALANCE` on are only columns.
   enum, bind(c)
      enumerator :: Q_ENERGY = OF_ENERGY, Q_JACOBI, Q_BALANCE, Q_CONSTRAINTS, Q_SOLVER, Q_TIME_DEPENDENT_WORK, &
         Q_ENERGIES, Q_WORKS
   end enum

   !> Components of energies.
   integer, parameter :: KINETIC = 1, POTENTIAL = 2

   !> Energies of the whole, and residuals.
   type(quantity_t), parameter, public :: energy_quantities(*) = [ &
      quantity_t('energy', 'kinetic', Q_ENERGY, 'J', 'energy', 31, SKY, attitude=.false., symbols='T'), &
      quantity_t('energy', 'potential', Q_ENERGY, 'J', 'energy', 31, ORANGE, first=2, attitude=.false., symbols='V'), &
      quantity_t('energy', 'total', Q_ENERGY, 'J', 'energy', 31, BLACK, first=3, attitude=.false., symbols='T + V'), &
      quantity_t('energy', 'work', Q_BALANCE, 'J', 'energy', 31, PINK, '', adds_up, adds_up, attitude=.false., &
                 symbols='W'), &
      quantity_t('energy', 'energy_residual', Q_BALANCE, 'J', 'energy residual', 32, GREY, '', adds_up, adds_up, &
                 attitude=.false., is_residual=.true., symbols='residual'), &
      quantity_t('constraints', 'norm_error', Q_CONSTRAINTS, '', 'error of the norm', 37, GREY, '', is_round_off, &
                 is_round_off, is_residual=.true., symbols='q·q − 1'), &
      quantity_t('constraints', 'orthogonality', Q_CONSTRAINTS, 'N m s', 'orthogonality', 38, GREY, '', is_round_off, &
                 is_round_off, is_residual=.true., symbols='q·p'), &
      quantity_t('solver', 'iterations', Q_SOLVER, '', 'iterations', 39, GREY, '', counts, counts, attitude=.false., &
                 is_residual=.true.), &
      quantity_t('solver', 'step_residual', Q_SOLVER, '', 'residual of a step', 40, GREY, '', of_step, of_step, &
                 attitude=.false., is_residual=.true., symbols='residual'), &
      quantity_t('jacobi', 'jacobi', Q_JACOBI, 'J', 'Jacobi integral', 33, BLACK, symbols='H')]
   !> Work of potentials that depend on time.
   type(quantity_t), parameter, public :: time_dependent_quantities(*) = [ &
      quantity_t('time_dependent_work', 'time_dependent_work', Q_TIME_DEPENDENT_WORK, 'J', 'works', 36, '', '', &
                 adds_up, adds_up, attitude=.false., symbols='time-dependent')]
   !> Energies and works of each effect.
   type(quantity_t), parameter, public :: effect_quantities(*) = [ &
      quantity_t('energies', 'energy_EFFECT', Q_ENERGIES, 'J', 'potential energies', 34, '', '', of_effects, &
                 of_effects, attitude=.false., needs=NEEDS_POTENTIAL, pattern='energy_*'), &
      quantity_t('works', 'work_EFFECT', Q_WORKS, 'J', 'works', 35, '', '', adds_up, adds_up, attitude=.false., &
                 needs=NEEDS_WORK, pattern='work_*')]

contains

   !> Returns the kinetic, potential or total energy, or the Jacobi integral, J, without that of an auxiliary inertia,
   !> which does not belong to the body.
   pure real(wp) function energy_value(kind, component, system, motion) result(x)
      integer, intent(in) :: kind, component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      x = 0.0_wp
      associate (omega => motion%omega, momentum => motion%momentum, effects => system%effects, state => motion%state)
         if (kind == Q_JACOBI .or. component /= POTENTIAL) &
            x = 0.5_wp*dot_product(omega, momentum - effects%inner_momentum(state%wheel_momentum)) &
                + effects%wheel_energy(state%wheel_momentum)
         if (kind == Q_JACOBI .or. component /= KINETIC) x = x + potential_energy(effects, state%q, state%t)
         if (kind == Q_JACOBI) x = x - dot_product(omega - motion%relative, momentum)
      end associate
   end function energy_value

   !> Returns the rate of an energy or of the Jacobi integral, W.
   pure real(wp) function energy_rate(kind, component, system, motion) result(x)
      integer, intent(in) :: kind, component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: by_time
      by_time = 0.0_wp
      if (system%effects%moves) by_time = time_dependent_power(system%effects, unit(motion%state%q), motion%state%t)
      associate (omega => motion%omega, relative => motion%relative)
         if (kind == Q_JACOBI) then
            x = dot_product(relative, motion%torque) + motion%inner_power + motion%inertia_power + by_time
         else if (component == KINETIC) then
            x = dot_product(omega, motion%potential_torque + motion%torque) + motion%inner_power + motion%inertia_power
         else if (component == POTENTIAL) then
            x = by_time - dot_product(relative, motion%potential_torque)
         else
            x = dot_product(omega, motion%torque) + dot_product(omega - relative, motion%potential_torque) + &
                motion%inner_power + motion%inertia_power + by_time
         end if
      end associate
   end function energy_rate

   !> Returns the size of the sum that an energy is, to which its round-off is relative.
   pure real(wp) function energy_size(kind, component, system, motion) result(x)
      integer, intent(in) :: kind, component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      x = 0.5_wp*vector_length(motion%omega)*vector_length(motion%momentum)
      if (kind == Q_JACOBI .or. component /= KINETIC) &
         x = x + abs(potential_energy(system%effects, motion%state%q, motion%state%t))
   end function energy_size

   !> Returns a bound of the rate of an energy, W.
   pure real(wp) function energy_fastest(kind, component, speeds) result(rate)
      integer, intent(in) :: kind, component
      type(speed_bounds_t), intent(in) :: speeds
      rate = speeds%total_rate
      if (kind == Q_JACOBI) then
         rate = speeds%jacobi_rate
      else if (component == KINETIC) then
         rate = speeds%kinetic_rate
      else if (component == POTENTIAL) then
         rate = speeds%potential_rate
      end if
   end function energy_fastest

   !> Returns a bound of the kinetic energy, J; negative for the others.
   pure real(wp) function energy_greatest(kind, component, speeds) result(value)
      integer, intent(in) :: kind, component
      type(speed_bounds_t), intent(in) :: speeds
      value = -1.0_wp
      if (kind == Q_ENERGY .and. component == KINETIC .and. speeds%kinetic_rate >= 0.0_wp) &
         value = 0.5_wp*bound_margin*speeds%root_energy**2
   end function energy_greatest

end module nutate_energy_quantities
