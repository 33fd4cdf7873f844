!> Interface of integration methods for the layers above: a stepper moves a state by one step.
module nutate_stepper
   use nutate_archive, only: archive_t
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_kinds, only: wp
   use nutate_noise, only: noise_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   use nutate_step_error, only: step_error_t
   implicit none
   private

   public :: stepper_t, dense_stepper_t, integrator_settings_t, step_goal_t, check_prepared, is_inside, keep_starts, &
      outside, system_t

   character(len=*), parameter :: outside = 'the time is not inside a step that was kept '// &
                                          '(expected a time in the last step)'

   !> Goal of a method that chooses its steps; one of the first two components is set.
   type :: step_goal_t
      !> Error of the step, rad; error over its length, rad/s.
      real(wp) :: tolerance = 0.0_wp, rate = 0.0_wp
      !> Latest end of a step, s: no torque starts or stops before.
      real(wp) :: end_time = 0.0_wp
      !> The ends of steps are observed: a method without an error, which could go to the end in one step, then chooses
      !> a suitable length.
      logical :: seen = .false.
      !> Longest step of a method without an error if the ends of steps are not observed, s.
      real(wp) :: longest = huge(1.0_wp)
   end type step_goal_t

   !> A method with its work space. One stepper serves one run at a time; several threads each use their own. The table
   !> of `nutate_methods` lists the properties of a method (order, stages, estimate, dense output).
   type, abstract :: stepper_t
      !> Newton iterations of the last step.
      integer :: iterations = 0
      !> Last Newton increment over the step's increment (dimensionless).
      real(wp) :: residual = 0.0_wp
      !> Lengths that the last step tried by continuation in Δt (`nutate_continuation`): each costs as much as a step.
      integer :: continued = 0
      !> Stages of the last step whose root is accepted without certification (`nutate_continuation`).
      integer :: uncertified = 0
      !> Estimated error of the last step, rad, of attitude and relative momentum, by methods that have one.
      real(wp) :: error_estimate = 0.0_wp
      !> Estimated errors of all quantities in the energy balance, if there are works; zero without an estimate.
      type(step_error_t) :: step_error = step_error_t()
      !> Change of the end of the last step by projection due to round-off of the energy, rad.
      real(wp) :: moved_by_round_off = 0.0_wp
      !> Work in the last step of each torque, and of each wheel motor and bearing friction, J; shape (n_works).
      real(wp), allocatable :: work(:)
      !> Settings of the last `prepare`.
      type(integrator_settings_t) :: prepared_with = integrator_settings_t()
      !> Which method, projection and axes the stepper is made of, as `make_stepper` numbers them; 0: another way.
      integer :: parts = 0
      !> The method conserves by itself, and is not projected: `propagate` removes from sensitivities what round-off
      !> adds.
      logical :: conserves = .false.
      !> Starts of steps are stored, for `state_at`.
      logical :: keeps_steps = .false.
      !> Fingerprint of the system of the last `prepare`.
      integer, private :: system_mark = 0
      !> State at the start of the last step, allocated if starts are stored; length of the step, and the time that
      !> decided which torques act, s.
      type(state_t), allocatable :: last_start
      real(wp) :: last_length = 0.0_wp, last_window = 0.0_wp
      !> Stepper that repeats parts of the last step, a `stepper_t`, so that the steps themselves stay unchanged
      !> (gfortran 12 has no recursive class); it has been used since the last step.
      class(*), allocatable, private :: again
      logical, private :: used = .false.
      !> The next `prepare` is for the system of the last one, unchanged, and for a stepper of the same parts: a method
      !> may keep what depends on these alone, so also what depends on `attitude` and `conserve`.
      logical :: keeps_system = .false.
   contains
      !> Stores the settings and makes the work space; must be called before the first step and after every change of
      !> the system.
      procedure, non_overridable :: prepare => prepare_stepper
      !> Prepares again for a system that has changed, with the same settings.
      procedure, non_overridable :: renew
      !> Advances a state by one step.
      procedure, non_overridable :: step => take_step
      !> Makes a stepper that continues with identical results; a stepper inside it is copied likewise.
      procedure :: copy
      !> Stores the starts of steps from now on, for `state_at`; to be called after `prepare`.
      procedure :: keep_steps
      !> Returns the state at a time inside the last step (dense output), to the accuracy of the method: by a shorter
      !> step from its start, unless the method overrides it.
      procedure :: state_at => state_taken_again
      !> Returns true if the method chooses the length of a step before the step (`dense_stepper_t`).
      procedure :: chooses_steps => chooses_none
      !> Computes the length of a step that meets a goal; to be followed by that step. A method that does not choose
      !> leaves the estimate as it is.
      procedure :: choose_step => keep_estimate
      !> Sets the start of a step that `advance` will perform.
      procedure :: mark_step
      !> Discards the history of steps, which only serves to predict the next one.
      procedure :: forget_steps => forget_nothing
      !> Notifies the stepper that values held by torques or motors have changed, and nothing else.
      procedure :: update_commands => forget_for_commands
      !> Sets up the method; called by `prepare`.
      procedure(set_up_method), deferred :: set_up
      !> Performs the step, which may be a part of a longer one.
      procedure(advance_state), deferred :: advance
      !> Writes or reads in checkpoint data all values on which later steps depend, so that a stepper prepared in the
      !> same way continues bit for bit. A method that does not override it has no checkpoints.
      procedure :: transfer => refuse_archive
      !> Writes the data of `transfer` as numbers, and reads them: the same numbers in the same order, at less cost if a
      !> method overrides it.
      procedure :: put_memory => put_by_archive
      procedure :: take_memory => take_by_archive
      !> Completes the state that a step left for output: projects it onto the invariants, unless every step does so.
      !> Later steps continue from the unprojected state, whichever of the two they receive.
      procedure :: project_for_output => leave_state
      !> Sets the perturbation of a trial run, for states before their projection; a stepper without projection ignores
      !> it.
      procedure :: disturb => leave_noise
      !> Moves sensitivities over the step that `advance` took last (`nutate_tangent`), and removes from them the
      !> round-off of what the method conserves.
      procedure, non_overridable :: propagate
      !> Moves sensitivities by the derivative of the step; reports an error unless overridden.
      procedure :: propagate_step => refuse_tangent
      !> Moves sensitivities from the start of the step that is kept to the state that `state_at` computed last.
      procedure :: propagate_inside
   end type stepper_t

   !> A method that chooses the length of a step before the step, and has dense output.
   type, abstract, extends(stepper_t) :: dense_stepper_t
   contains
      procedure :: chooses_steps => chooses_all
   end type dense_stepper_t

   abstract interface
      !> Sets up the method. Errors: `NUTATE_BAD_ARGUMENT` for settings that the method cannot honour.
      subroutine set_up_method(self, system, settings, status)
         import :: stepper_t, system_t, integrator_settings_t, status_t
         class(stepper_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(integrator_settings_t), intent(in) :: settings
         type(status_t), intent(inout) :: status
      end subroutine set_up_method

      !> Performs the step. On failure the state is unchanged.
      subroutine advance_state(self, system, state, dt, window_time, status)
         import :: stepper_t, system_t, state_t, status_t, wp
         class(stepper_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(inout) :: state
         !> Step, s; negative steps go backwards in time.
         real(wp), intent(in) :: dt
         !> Time that decides which torques act, s: the middle of the whole step, which may lie outside of the part that
         !> is performed.
         real(wp), intent(in) :: window_time
         !> Success on entry.
         type(status_t), intent(inout) :: status
      end subroutine advance_state
   end interface

   interface

      !> Stores the settings and makes the work space. Errors: those of `check_system` and of the method's `set_up`,
      !> mostly `NUTATE_BAD_ARGUMENT` for settings that it cannot honour.
      recursive module subroutine prepare_stepper(self, system, settings, status)
         class(stepper_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(integrator_settings_t), intent(in) :: settings
         type(status_t), intent(out) :: status
      end subroutine prepare_stepper

      !> Prepares again for a system that has changed; steps are kept as before. Errors: those of `prepare`.
      module subroutine renew(self, system, status)
         !> Stepper that is prepared.
         class(stepper_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(status_t), intent(out) :: status
      end subroutine renew

      !> Tests whether a stepper was prepared for a body with this inertia and frame, and as many effects of such types.
      !> Errors: `NUTATE_BAD_ARGUMENT`.
      module subroutine check_prepared(self, system, status)
         class(stepper_t), intent(in) :: self
         type(system_t), intent(in) :: system
         type(status_t), intent(inout) :: status
      end subroutine check_prepared

      !> Moves a state by one step, whose middle decides which torques act, and completes it for output. On failure the
      !> state is unchanged. Errors: those of the step and of `check_prepared`.
      module subroutine take_step(self, system, state, dt, status)
         !> Prepared for `system`.
         class(stepper_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(inout) :: state
         !> Step, s; negative steps go backwards in time.
         real(wp), intent(in) :: dt
         type(status_t), intent(out) :: status
      end subroutine take_step

      !> Makes a stepper that continues with identical results. The stepper that repeats steps is copied separately, as
      !> a stepper: gfortran 12 does not copy a `class(*)` inside of another object, and loses the length that goes with
      !> it.
      recursive module subroutine copy(self, twin)
         !> Stepper to copy; unchanged on return.
         class(stepper_t), intent(inout) :: self
         class(stepper_t), allocatable, intent(out) :: twin
      end subroutine copy

      !> Stores the starts of steps from now on, for `state_at`. A copy of this stepper repeats parts of them,
      !> unless the method has dense output.
      module subroutine keep_steps(self)
         !> Stepper that is prepared.
         class(stepper_t), intent(inout) :: self
      end subroutine keep_steps

      !> Makes room for the start of a step, which `mark_step` sets from now on.
      module subroutine keep_starts(self)
         class(stepper_t), intent(inout) :: self
      end subroutine keep_starts

      !> Sets the start of a step that `advance` is to take, if starts are kept.
      module subroutine mark_step(self, state, dt, window_time)
         class(stepper_t), intent(inout) :: self
         type(state_t), intent(in) :: state
         !> Length of the step, and time that decides which torques act, s.
         real(wp), intent(in) :: dt, window_time
      end subroutine mark_step

      !> Computes the state at a time inside the last step: repeats the step from its start, shortened to end at the
      !> time. Later steps and their memory are unaffected.
      !>
      !> Errors: `NUTATE_BAD_ARGUMENT` if no step was kept, or the time is outside of it; those of the step.
      recursive module subroutine state_taken_again(self, system, t, state, work, status, works)
         class(stepper_t), intent(inout) :: self
         !> System of the step.
         type(system_t), intent(in) :: system
         !> Time, s.
         real(wp), intent(in) :: t
         !> State at the time; unchanged on failure.
         type(state_t), intent(inout) :: state
         !> Work of all torques from the start of the step to `t`, J.
         real(wp), intent(out) :: work
         type(status_t), intent(out) :: status
         !> Work of each torque from the start of the step to `t`, J; shape (n_works).
         real(wp), intent(inout), optional :: works(:)
      end subroutine state_taken_again

      !> Returns true for a time inside the last step that was kept, its ends and their round-off included.
      pure logical module function is_inside(self, t)
         class(stepper_t), intent(in) :: self
         !> Time, s.
         real(wp), intent(in) :: t
      end function is_inside

      !> Returns false.
      pure logical module function chooses_none(self)
         class(stepper_t), intent(in) :: self
      end function chooses_none

      !> Returns true.
      pure logical module function chooses_all(self)
         class(dense_stepper_t), intent(in) :: self
      end function chooses_all

      !> Leaves the estimate of a step as it is.
      recursive module subroutine keep_estimate(self, system, state, goal, step, status)
         class(stepper_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         !> State at the start of the step.
         type(state_t), intent(in) :: state
         type(step_goal_t), intent(in) :: goal
         !> Length of the step, s, positive also backwards in time; an estimate on entry.
         real(wp), intent(inout) :: step
         !> Success on entry.
         type(status_t), intent(inout) :: status
      end subroutine keep_estimate

      module subroutine forget_nothing(self)
         class(stepper_t), intent(inout) :: self
      end subroutine forget_nothing

      !> Discards the history of steps: predictions depend on the values before.
      recursive module subroutine forget_for_commands(self)
         class(stepper_t), intent(inout) :: self
      end subroutine forget_for_commands

      !> Returns an error: state of a method that is not listed would be missing, and the resumed run would differ.
      module subroutine refuse_archive(self, archive)
         !> Prepared for `system`.
         class(stepper_t), intent(inout) :: self
         class(archive_t), intent(inout) :: archive
      end subroutine refuse_archive

      !> Writes the data of `transfer` into an array of numbers.
      recursive module subroutine put_by_archive(self, room, numbers, used)
         !> Stepper that is prepared.
         class(stepper_t), intent(inout) :: self
         integer, intent(in) :: room
         real(wp), intent(inout), target :: numbers(room)
         !> Numbers in use before and after.
         integer, intent(inout) :: used
      end subroutine put_by_archive

      !> Reads the data of `transfer` from an array of numbers.
      recursive module subroutine take_by_archive(self, room, numbers, used)
         !> Prepared, for the same system.
         class(stepper_t), intent(inout) :: self
         integer, intent(in) :: room
         real(wp), intent(in), target :: numbers(room)
         !> Numbers read before and after.
         integer, intent(inout) :: used
      end subroutine take_by_archive

      !> Does nothing: the state needs no completion for output.
      module subroutine leave_state(self, system, state)
         !> Prepared for `system`.
         class(stepper_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         !> State that `advance` left last; any other is unchanged.
         type(state_t), intent(inout) :: state
      end subroutine leave_state

      !> Reports that the method has no sensitivities. Errors: `NUTATE_BAD_ARGUMENT`.
      recursive module subroutine refuse_tangent(self, system, before, after, dt, window_time, tangent, status)
         class(stepper_t), intent(inout) :: self
         !> System, as passed to `advance`.
         type(system_t), intent(in) :: system
         !> States at the start and at the end of the step.
         type(state_t), intent(in) :: before, after
         !> Length of the step and time that decides which torques act, as passed to `advance`, s.
         real(wp), intent(in) :: dt, window_time
         !> Sensitivities at the start of the step; unchanged on failure.
         type(tangent_t), intent(inout) :: tangent
         !> Success on entry.
         type(status_t), intent(inout) :: status
      end subroutine refuse_tangent

      !> Moves sensitivities over the step that `advance` took last. Errors, with the sensitivities unchanged: those of
      !> the method; `NUTATE_BAD_ARGUMENT` for one without sensitivities, and for sensitivities that it does not have.
      recursive module subroutine propagate(self, system, before, after, dt, window_time, tangent, status)
         class(stepper_t), intent(inout) :: self
         !> System, as passed to `advance`.
         type(system_t), intent(in) :: system
         !> States at the start and at the end of the step.
         type(state_t), intent(in) :: before, after
         !> Length of the step and time that decides which torques act, as passed to `advance`, s.
         real(wp), intent(in) :: dt, window_time
         type(tangent_t), intent(inout) :: tangent
         !> Success on entry.
         type(status_t), intent(inout) :: status
      end subroutine propagate

      !> Moves sensitivities to the state inside the last step that `state_at` computed last. Errors: those of
      !> `propagate`.
      recursive module subroutine propagate_inside(self, system, state, tangent, status)
         class(stepper_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(in) :: state
         !> Sensitivities at the start of the step that is kept.
         type(tangent_t), intent(inout) :: tangent
         type(status_t), intent(inout) :: status
      end subroutine propagate_inside

      module subroutine leave_noise(self, noise)
         class(stepper_t), intent(inout) :: self
         type(noise_t), intent(in) :: noise
      end subroutine leave_noise

   end interface

end module nutate_stepper
