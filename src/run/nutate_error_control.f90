!> Adaptive steps: by the method itself before the step, if it can; else by its own estimate after the step, if it has
!> one; else by Richardson's estimate from a whole step against two halves.
!>
!> If a run propagates sensitivities, explicit methods and series hold them to the same tolerance, each relative to its
!> own size; implicit steps have the sensitivities of the steps that they take anyway.
!>
!> The halves are kept, so every invariant of the method is kept too. States between the ends of steps are computed by
!> the method, if it has dense output, else by a branch: two shorter steps of the same method from the start of the
!> step, which keep the invariants and leave the run as it is.
module nutate_error_control
   use nutate_archive, only: archive_t
   use nutate_equal_steps, only: equal_steps_t
   use nutate_kinds, only: wp
   use nutate_methods, only: method_t
   use nutate_noise, only: noise_t
   use nutate_observer, only: observer_t, run_record_t
   use nutate_progress, only: progress_t, run_point_t
   use nutate_step_length, only: step_length_t
   use nutate_step_policy, only: step_policy_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: integrator_settings_t, stepper_t, system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: error_control_t, is_evaluable

   !> Number of last events that ended steps; their mean distance times the second limits the length of steps, since the
   !> part of a step after such an event is discarded.
   integer, parameter :: cuts_kept = 8
   real(wp), parameter :: reach_over_cuts = 2.0_wp

   !> Adaptive steps. The goal is that of the run's plan.
   type, extends(step_policy_t) :: error_control_t
      private
      type(method_t) :: method
      !> The next step to try.
      type(step_length_t) :: length
      !> Fixed steps, which suit some runs to an accuracy.
      type(equal_steps_t), public :: equal
      !> The halves of a step, or the only one: `begin` prepares a stepper that is there anew.
      class(stepper_t), allocatable, public :: half
      !> The whole step, and branches for output points; each with its own memory, if needed.
      class(stepper_t), allocatable :: whole, branch
      !> Branch for events, which does not affect output points; true if it has been used since the last step.
      class(stepper_t), allocatable :: probe
      logical :: probed = .false.
      !> Work of each torque in the step tried, J; shape (number of torques).
      real(wp), allocatable :: work(:)
      !> States before the last step and at the end of the step tried, except for the time, and the works, J.
      type(state_t) :: start, next
      type(run_record_t) :: before
      !> The last step can be repeated: nothing has been switched or set since.
      logical :: repeatable = .false.
      !> Largest |L| or momentum of a wheel or an inner sphere seen, kg m²/s.
      real(wp) :: momentum_scale = 0.0_wp
      !> Longest step of the settings, s.
      real(wp) :: max_step = huge(1.0_wp)
      !> Longest step that may be chosen after one that failed, s.
      real(wp) :: longest = huge(1.0_wp)
      !> Time of the last event that ended a step, and the times between the last of them, s; not set before the first.
      real(wp) :: last_cut = 0.0_wp, between_cuts(cuts_kept) = 0.0_wp
      logical :: has_cuts = .false.
      !> +1 forward, -1 backward in time.
      real(wp) :: sense = 1.0_wp
      !> Digits of the time that its sum cannot hold, s.
      real(wp) :: t_compensation = 0.0_wp
      !> Noise of a trial run, for the ends of steps that nothing projects.
      type(noise_t) :: noise
      !> Sensitivities of the run, moved along with the step that is tried, and with a whole step.
      type(tangent_t), allocatable :: trial, once
   contains
      !> Prepares the steppers and the first step.
      procedure :: begin
      !> Adds noise to every step, for a trial run.
      procedure :: disturb
      procedure :: advance
      procedure :: project_for_output
      procedure :: state_inside
      procedure :: expect_events
      procedure :: retake
      procedure :: propagate
      procedure :: renew
      procedure :: update_commands
      procedure :: transfer => transfer_control
   end type error_control_t

   !> Rotation in the first step, rad, and part of the run for a body that is nearly at rest.
   real(wp), parameter :: first_turn = 0.1_wp, first_part = 0.1_wp
   !> Rows inside of a step of a method without an error: polls come between steps, and must not be delayed.
   integer, parameter :: rows_in_a_step = 64
   !> States nearer to the start of the step than this are the start, s: equations cannot divide by less.
   real(wp), parameter :: least_time = 1e-290_wp
   !> Shortest step over the length of the run: no run makes 1e13 steps, and 1e-16 would not tell their times apart.
   real(wp), parameter :: shortest = 1e-13_wp

   interface

      !> Prepares the steppers, those of an earlier run anew, and the first step. Errors: those of the method.
      module subroutine begin(self, system, settings, progress, status)
         class(error_control_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(integrator_settings_t), intent(in) :: settings
         !> Run that was started.
         type(progress_t), intent(in) :: progress
         type(status_t), intent(inout) :: status
      end subroutine begin

      !> Adds noise to the end of every step, before it is projected, if it is. Implicit steps have none: what their
      !> compensated sums lose is far below what iteration leaves, and noise would break their invariants.
      module subroutine disturb(self, noise)
         !> Step policy that has begun.
         class(error_control_t), intent(inout) :: self
         type(noise_t), intent(in) :: noise
      end subroutine disturb

      !> Takes one step, and keeps it if the estimate of its error allows.
      module subroutine advance(self, system, progress, status, observer)
         class(error_control_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(progress_t), intent(inout) :: progress
         type(status_t), intent(inout) :: status
         class(observer_t), intent(inout), optional :: observer
      end subroutine advance

      !> Projects the state at the end of the last step for output.
      module subroutine project_for_output(self, system, state)
         class(error_control_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(inout) :: state
      end subroutine project_for_output

      !> Evaluates the state at a time inside the last step: by the method, or by steps of a branch; for events by a
      !> branch of their own, as the step would be repeated: by one step, or by two halves.
      module subroutine state_inside(self, system, progress, t, state, status, record, tangent, before)
         class(error_control_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(progress_t), intent(in) :: progress
         !> Time inside the step, s.
         real(wp), intent(in) :: t
         type(state_t), intent(inout) :: state
         type(status_t), intent(inout) :: status
         type(run_record_t), intent(out), optional :: record
         type(tangent_t), intent(inout), optional :: tangent
         type(run_point_t), intent(in), optional :: before
      end subroutine state_inside

      !> Returns true if the last step contains a time and can be evaluated there.
      pure logical module function is_evaluable(self, end_time, t)
         type(error_control_t), intent(in) :: self
         !> Time at the end of the last step, and the time to evaluate, s.
         real(wp), intent(in) :: end_time, t
      end function is_evaluable

      !> Prepares the stepper that evaluates states inside steps, if the method has no dense output.
      module subroutine expect_events(self, system, progress, status)
         class(error_control_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(progress_t), intent(inout) :: progress
         type(status_t), intent(inout) :: status
      end subroutine expect_events

      !> Repeats the last step, shorter. The next step is tried with the length that it had.
      module subroutine retake(self, system, progress, t_end, status)
         class(error_control_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(progress_t), intent(inout) :: progress
         real(wp), intent(in) :: t_end
         type(status_t), intent(inout) :: status
      end subroutine retake

      !> Sets the sensitivities, which were moved along with the step.
      module subroutine propagate(self, system, before, progress, status)
         class(error_control_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(in) :: before
         type(progress_t), intent(inout) :: progress
         type(status_t), intent(inout) :: status
      end subroutine propagate

      !> Prepares again for a system that has changed.
      module subroutine renew(self, system, status)
         class(error_control_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(status_t), intent(inout) :: status
      end subroutine renew

      !> Notes that torques and motors hold other values.
      module subroutine update_commands(self)
         class(error_control_t), intent(inout) :: self
      end subroutine update_commands

      !> Writes or reads the data on which the next steps depend in checkpoint data, under the name of this policy.
      module subroutine transfer_control(self, archive)
         class(error_control_t), intent(inout) :: self
         class(archive_t), intent(inout) :: archive
      end subroutine transfer_control

   end interface

end module nutate_error_control
