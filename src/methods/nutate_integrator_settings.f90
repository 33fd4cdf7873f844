!> Settings of integration methods.
module nutate_integrator_settings
   use nutate_kinds, only: wp
   implicit none
   private

   public :: integrator_settings_t

   !> How to integrate, as a scene's `&integrator` says it.
   type :: integrator_settings_t
      !> Blank: none is named. A run to an accuracy or a `local_tolerance` then chooses one, unless order, formulation,
      !> `series_order`, `conserve` or `projection` are set; else it is `nielsen_krenk`.
      character(len=24) :: method = ''
      !> 0: as the method has it, of `nielsen_krenk` 2, in a run to an accuracy as that asks for.
      integer :: order = 0
      !> Blank: as the method has it.
      character(len=24) :: formulation = ''
      !> 1/J0, kg⁻¹ m⁻²; 0 for an infinite auxiliary inertia.
      real(wp) :: inverse_auxiliary_inertia = 0.0_wp
      !> Project potential forces onto the tangent of |q| = 1 (equation (11) of Nielsen & Krenk 2012); `.false.` shows
      !> what that is for.
      logical :: projection = .true.
      !> Integrate the attitude; `.false.` only where neither an effect nor the output depends on it.
      logical :: attitude = .true.
      !> Project the state onto the invariants: for methods that do not conserve them, or so that round-off does not add
      !> up.
      logical :: conserve = .false.
      !> Project it after every step, not only as often as round-off asks for: where steps may be taken back.
      logical :: project_each = .false.
      !> Order of a Taylor series; 0: as the tolerance asks for, 16 at fixed steps.
      integer :: series_order = 0
      !> Newton: relative increment at which to stop; 0: iterate until the increment stops falling.
      real(wp) :: tolerance = 0.0_wp
      integer :: max_iterations = 20
      !> Longest adaptive step, s: what acts for a shorter time between the evaluations of a step can be missed.
      real(wp) :: max_step = huge(1.0_wp)
      !> Step in the space axes of the system, although the LVLH frame of its circular orbit would do
      !> (`nutate_lvlh_stepper`): for derivatives by the elements of the orbit.
      logical :: in_space_axes = .false.
   end type integrator_settings_t

end module nutate_integrator_settings
