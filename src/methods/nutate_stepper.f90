!> What an integration method is to the layers above it: something that moves a state by one step.
module nutate_stepper
   use nutate_archive, only: archive_t
   use nutate_kinds, only: wp
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_system, only: system_t
   implicit none
   private

   public :: stepper_t, integrator_settings_t, step_goal_t

   !> How to integrate, as a scene's `&integrator` says it.
   type :: integrator_settings_t
      character(len=24) :: method = 'nielsen_krenk'
      integer :: order = 2
      character(len=24) :: linear_solver = 'lapack'
      !> 1/J0, kg⁻¹ m⁻²; 0 for an infinite auxiliary inertia.
      real(wp) :: inverse_auxiliary_inertia = 0.0_wp
      !> Project potential forces onto the tangent of |q| = 1; `.false.` shows what that is for.
      logical :: projection = .true.
      !> Integrate the attitude; `.false.` only where neither an effect nor the output depends on it.
      logical :: attitude = .true.
      !> Correct the state after every step so that the invariants are kept: for methods that do not keep them.
      logical :: conserve = .false.
      !> Order of a Taylor series; 0: as the tolerance asks for, 16 at fixed steps.
      integer :: series_order = 0
      !> Newton: relative increment at which to stop; 0: iterate until the increment stops falling.
      real(wp) :: tolerance = 0.0_wp
      integer :: max_iterations = 20
   end type integrator_settings_t

   !> What a method that chooses its steps must keep to; one of the first two is set.
   type :: step_goal_t
      !> Error of the step, rad; error over its length, rad/s.
      real(wp) :: tolerance = 0.0_wp, rate = 0.0_wp
      !> Where a step must end at the latest, s: no torque starts or stops before.
      real(wp) :: end_time = 0.0_wp
   end type step_goal_t

   !> A method with its work space. One stepper serves one run at a time; several threads each use their own.
   type, abstract :: stepper_t
      !> Newton iterations of the last step.
      integer :: iterations = 0
      !> Last Newton increment over the step's increment (dimensionless).
      real(wp) :: residual = 0.0_wp
      !> Lengths that the last step tried on its walk to the root (`nutate_continuation`): each costs as much as a step.
      integer :: continued = 0
      !> The step is a part of a longer one, the middle of which decides which torques act, s: parts may leave the
      !> time of the whole.
      logical :: is_part = .false.
      real(wp) :: whole_middle = 0.0_wp
      !> The method estimates the error of its steps; the estimate of the last one, rad, of attitude and relative
      !> momentum.
      logical :: has_estimate = .false.
      real(wp) :: error_estimate = 0.0_wp
      !> The estimate goes as this power of the step.
      integer :: estimate_power = 0
      !> The method knows the length of a step before it takes it (`choose_step`), and the states inside
      !> (`state_at`).
      logical :: chooses_steps = .false.
      !> Work that each torque did in the last step, J; shape (number of torques).
      real(wp), allocatable :: work(:)
   contains
      !> Takes the settings and allocates the work space; must be called before the first step and after every
      !> change of the system.
      procedure(prepare_stepper), deferred :: prepare
      !> Moves a state by one step.
      procedure(take_step), deferred :: step
      !> Shows to an archive all that the next steps depend on, so that a stepper prepared in the same way can go on in
      !> its place.
      procedure, non_overridable :: transfer => transfer_stepper
      !> What a method remembers from step to step, shown to an archive, each value once; a method that does not say so
      !> cannot be archived.
      procedure :: transfer_memory => refuse_archive
      !> The length of a step that meets a goal; to be followed by that step.
      procedure :: choose_step => take_guess
      !> The state at a time inside the last step.
      procedure :: state_at => refuse_to_look
      !> What the method remembers of its steps, as numbers: how many, and out of and into a prepared stepper. A stepper
      !> that gets them goes on to the last digit like the one they come from.
      procedure :: memory_size => no_memory_size
      procedure :: get_memory => get_no_memory
      procedure :: set_memory => set_no_memory
   end type stepper_t

   abstract interface
      !> Errors: `NUTATE_BAD_ARGUMENT` for settings that the method cannot honour.
      subroutine prepare_stepper(self, system, settings, status)
         import :: stepper_t, system_t, integrator_settings_t, status_t
         class(stepper_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(integrator_settings_t), intent(in) :: settings
         type(status_t), intent(out) :: status
      end subroutine prepare_stepper

      !> On failure the state is as it was.
      subroutine take_step(self, system, state, dt, status)
         import :: stepper_t, system_t, state_t, status_t, wp
         class(stepper_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(inout) :: state
         !> Step, s; negative steps go backwards in time.
         real(wp), intent(in) :: dt
         type(status_t), intent(out) :: status
      end subroutine take_step
   end interface

contains

   !> Shows to an archive what every method has, then the method's own memory. Recursive for steppers made of others.
   recursive subroutine transfer_stepper(self, archive)
      !> Prepared.
      class(stepper_t), intent(inout) :: self
      type(archive_t), intent(inout) :: archive
      call archive%transfer(self%iterations)
      call archive%transfer(self%residual)
      call archive%transfer(self%is_part)
      call archive%transfer(self%whole_middle)
      call archive%transfer(self%error_estimate)
      call archive%transfer(self%work)
      call self%transfer_memory(archive)
   end subroutine transfer_stepper

   !> Refuses: going on without a memory that nobody listed would be another run.
   subroutine refuse_archive(self, archive)
      class(stepper_t), intent(inout) :: self
      type(archive_t), intent(inout) :: archive
      call archive%refuse('this method cannot be interrupted and go on')
   end subroutine refuse_archive

   !> Leaves the guess as it is: for methods that do not choose.
   subroutine take_guess(self, system, state, goal, step, status)
      class(stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(step_goal_t), intent(in) :: goal
      !> A guess on entry, s, positive whichever way time goes.
      real(wp), intent(inout) :: step
      !> Success on entry.
      type(status_t), intent(inout) :: status
   end subroutine take_guess

   !> Errors: `NUTATE_BAD_ARGUMENT`: for methods that know the ends of their steps only.
   subroutine refuse_to_look(self, system, t, state, work, status)
      class(stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> s.
      real(wp), intent(in) :: t
      type(state_t), intent(inout) :: state
      !> Work of all torques from the start of the step to `t`, J.
      real(wp), intent(out) :: work
      type(status_t), intent(out) :: status
      work = 0.0_wp
      status = fail(NUTATE_BAD_ARGUMENT, 'the method knows no states inside of its steps')
   end subroutine refuse_to_look

   !> The method remembers nothing.
   pure integer function no_memory_size(self)
      class(stepper_t), intent(in) :: self
      no_memory_size = 0
   end function no_memory_size

   !> Does nothing.
   pure subroutine get_no_memory(self, store)
      class(stepper_t), intent(in) :: self
      !> Shape (memory_size).
      real(wp), intent(inout), contiguous :: store(:)
   end subroutine get_no_memory

   !> Does nothing.
   pure subroutine set_no_memory(self, system, store)
      class(stepper_t), intent(inout) :: self
      !> For which the stepper was prepared.
      type(system_t), intent(in) :: system
      !> From `get_memory` of a stepper prepared alike; shape (memory_size).
      real(wp), intent(in), contiguous :: store(:)
   end subroutine set_no_memory

end module nutate_stepper
