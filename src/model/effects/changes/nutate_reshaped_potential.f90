!> Potentials that vary with the body: what changes ΔJ of its inertia and Δc of its centre of mass add to U, ½γᵀEγ - e·γ
!> with E and e proportional to them.
module nutate_reshaped_potential
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp
   use nutate_small_products, only: deviator, times_vector
   implicit none
   private

   public :: potential_term, varying_energy, varying_gradient

contains

   !> Computes coefficient j of the power series of E and -e of a potential: the j-th derivative times unitʲ/j!.
   pure subroutine potential_term(effects, i, j, t, moment, unit, stiffness, slope, factors)
      use nutate_center_change, only: center_change_t
      type(effect_list_t), intent(in) :: effects
      !> Index of the potential; coefficient.
      integer, intent(in) :: i, j
      !> Time, a time inside of the step that begins, ends or contains it, and unit of time, s.
      real(wp), intent(in) :: t, moment, unit
      !> E, shape (3,3), and -e, shape (3), body axes, J over powers of the unit of γ.
      real(wp), intent(out) :: stiffness(3, 3), slope(3)
      !> Factors of ΔJ and Δc; default: `by_inertia` and `by_center`.
      real(wp), intent(in), optional :: factors(2)
      real(wp) :: by(2)
      integer :: k
      stiffness = 0.0_wp
      slope = 0.0_wp
      by = [effects%potentials(i)%item%by_inertia, effects%potentials(i)%item%by_center]
      if (present(factors)) by = factors
      if (effects%varies .and. abs(by(1)) > 0.0_wp) stiffness = by(1)*effects%inertia_term(j, t, moment, unit)
      if (.not. (effects%moves_center .and. abs(by(2)) > 0.0_wp)) return
      do k = 1, effects%n_torques
         select type (path => effects%torques(k)%item)
         type is (center_change_t)
            slope = slope - by(2)*path%displacement_term(j, t, moment, unit)
         end select
      end do
   end subroutine potential_term

   !> Returns ½γᵀEγ - e·γ of a potential that varies, J.
   pure real(wp) function varying_energy(effects, i, gamma, t) result(energy)
      type(effect_list_t), intent(in) :: effects
      !> Index of the potential.
      integer, intent(in) :: i
      !> γ, body axes, shape (3); time, s.
      real(wp), intent(in) :: gamma(3), t
      real(wp) :: stiffness(3, 3), slope(3)
      call potential_term(effects, i, 0, t, t, 1.0_wp, stiffness, slope)
      energy = dot_product(gamma, 0.5_wp*times_vector(stiffness, gamma) + slope)
   end function varying_energy

   !> Returns Eγ - e of a potential that varies, body axes; shape (3). The isotropic part of E, which exerts no torque,
   !> is left out.
   pure function varying_gradient(effects, i, gamma, t) result(gradient)
      type(effect_list_t), intent(in) :: effects
      !> Index of the potential.
      integer, intent(in) :: i
      !> γ, body axes, shape (3); time, s.
      real(wp), intent(in) :: gamma(3), t
      real(wp) :: gradient(3)
      real(wp) :: stiffness(3, 3)
      call potential_term(effects, i, 0, t, t, 1.0_wp, stiffness, gradient)
      gradient = gradient + times_vector(deviator(stiffness), gamma)
   end function varying_gradient

end module nutate_reshaped_potential
