!> Settings of integration methods.
module nutate_integrator_settings
   use nutate_kinds, only: wp
   implicit none
   private

   public :: integrator_settings_t

   !> Settings of the integration, as in `&integrator` of a scene.
   type :: integrator_settings_t
      !> Name of the method; blank: none is named. A run to an accuracy or a `local_tolerance` then chooses one, unless
      !> order, formulation, `series_order`, `conserve` or `projection` are set; else it is `nielsen_krenk`.
      character(len=24) :: method = ''
      !> Order; 0: the default of the method, 2 for `nielsen_krenk`, or the one that suits the accuracy of the run.
      integer :: order = 0
      !> Formulation; blank: the default of the method.
      character(len=24) :: formulation = ''
      !> 1/J0, kg⁻¹ m⁻²; 0 for an infinite auxiliary inertia.
      real(wp) :: inverse_auxiliary_inertia = 0.0_wp
      !> Project potential forces onto the tangent of |q| = 1 (equation (11) of Nielsen & Krenk 2012); `.false.` shows
      !> the effect of that.
      logical :: projection = .true.
      !> Integrate the attitude; `.false.` only if neither an effect nor the output depends on it.
      logical :: attitude = .true.
      !> Project the state onto the invariants: for methods that do not conserve them, or so that round-off does not add
      !> up.
      logical :: conserve = .false.
      !> Project it after every step, not only as often as round-off requires: if steps may be taken back.
      logical :: project_each = .false.
      !> Order of a Taylor series; 0: the one that suits the tolerance, 16 with fixed steps.
      integer :: series_order = 0
      !> Relative increment at which Newton's iteration stops; 0: it ends when the increment stops falling.
      real(wp) :: tolerance = 0.0_wp
      integer :: max_iterations = 20
      !> Longest adaptive step, s: a pulse shorter than the time between the evaluations of a step can be missed.
      real(wp) :: max_step = huge(1.0_wp)
      !> Step in the space axes of the system, even if the LVLH frame of its circular orbit could be used
      !> (`nutate_lvlh_stepper`): for derivatives with respect to the elements of the orbit.
      logical :: in_space_axes = .false.
   end type integrator_settings_t

end module nutate_integrator_settings
