!> Interface of a form of the implicit equations to the step that solves them (`nutate_implicit_step`): start,
!> increment, Jacobian and update of its unknowns, and the vector of the Cayley map that they stand for.
module nutate_implicit_equations
   use nutate_archive, only: archive_t
   use nutate_continuation, only: root_acceptance_t
   use nutate_kinds, only: wp
   use nutate_newton_increment, only: increment_t, usual_cancellation
   use nutate_number_archive, only: number_archive_t
   use nutate_predictor, only: most_unknowns, predictor_t
   use nutate_root_proof, only: root_proof_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: stepper_t, system_t
   implicit none
   private

   public :: implicit_equations_t

   !> Equations of a step in their unknowns, and what the steppers that solve them keep.
   type, abstract, extends(stepper_t) :: implicit_equations_t
      type(predictor_t) :: predictor
      type(root_proof_t) :: proof
      type(root_acceptance_t) :: acceptance
      !> Determinant of the Jacobian last computed, over that of a very short step.
      real(wp) :: determinant = 0.0_wp
      !> Step to which the kept part of the Jacobian belongs, s; 0: there is none that is worth keeping.
      real(wp) :: kept_dt = 0.0_wp
      !> How many times the result the terms of the equations linearized last can be.
      real(wp) :: cancellation = usual_cancellation
      !> The stage started is on the constraint manifold and stays there, as the proof of a root assumes.
      logical :: on_manifold = .true.
      !> The next step is the first since `prepare`.
      logical :: untested = .true.
   contains
      !> Sets the state and the length of a step. Refuses states that the form cannot move.
      procedure(start_equations), deferred :: start
      !> Chooses units for a step that was started and for which no Jacobian was kept.
      procedure(choose_units), deferred :: scale_unknowns
      !> The unknowns of a step with the rates of its start.
      procedure(extrapolate), deferred :: explicit_guess
      !> One increment of the modified Newton iteration.
      procedure(correct_unknowns), deferred :: correct
      !> A new Jacobian, with its determinant.
      procedure(linearize_equations), deferred :: linearize
      !> b0 = ¼Δt J⁻¹(L0 - h), the b of a step whose momentum stays.
      procedure(find_start_vector), deferred :: get_start_vector
      !> The unknowns that belong to a b.
      procedure(find_unknowns), deferred :: unknowns_of
      !> The b of a root: the vector of its Cayley map.
      procedure(find_cayley_vector), deferred :: get_cayley_vector
      !> Moves the state to the end of the step.
      procedure(move_state), deferred :: finish
      !> Writes or reads the data that the form keeps beside unknowns.
      procedure(transfer_more), deferred :: transfer_form
      !> Writes the same as numbers, and reads it.
      procedure :: put_form
      procedure :: take_form
   end type implicit_equations_t

   abstract interface
      !> Errors: `NUTATE_BAD_ARGUMENT`.
      subroutine start_equations(self, system, state, dt, window_time, status)
         import :: implicit_equations_t, system_t, state_t, status_t, wp
         class(implicit_equations_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(in) :: state
         !> s, and the time that decides which torques act, s.
         real(wp), intent(in) :: dt, window_time
         !> Success on entry.
         type(status_t), intent(inout) :: status
      end subroutine start_equations

      !> Errors: `NUTATE_OFF_BRANCH` where the body turns beyond all bounds in the step.
      subroutine choose_units(self, system, state, dt, window_time, status)
         import :: implicit_equations_t, system_t, state_t, status_t, wp
         class(implicit_equations_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(in) :: state
         real(wp), intent(in) :: dt, window_time
         !> Success on entry.
         type(status_t), intent(inout) :: status
      end subroutine choose_units

      subroutine extrapolate(self, system, z)
         import :: implicit_equations_t, system_t, most_unknowns, wp
         class(implicit_equations_t), intent(in) :: self
         type(system_t), intent(in) :: system
         real(wp), intent(out) :: z(most_unknowns)
      end subroutine extrapolate

      !> Errors: `NUTATE_SINGULAR`, `NUTATE_OFF_BRANCH` for effects too strong for the step.
      subroutine correct_unknowns(self, system, z, increment, status)
         import :: implicit_equations_t, system_t, increment_t, status_t, most_unknowns, wp
         class(implicit_equations_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         real(wp), intent(inout) :: z(most_unknowns)
         !> The previous one on entry.
         type(increment_t), intent(inout) :: increment
         !> Success on entry.
         type(status_t), intent(inout) :: status
      end subroutine correct_unknowns

      !> Errors as for `correct`.
      subroutine linearize_equations(self, system, z, status)
         import :: implicit_equations_t, system_t, status_t, most_unknowns, wp
         class(implicit_equations_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         real(wp), intent(in) :: z(most_unknowns)
         !> Success on entry.
         type(status_t), intent(inout) :: status
      end subroutine linearize_equations

      pure subroutine find_cayley_vector(self, z, b)
         import :: implicit_equations_t, most_unknowns, wp
         class(implicit_equations_t), intent(inout) :: self
         real(wp), intent(in) :: z(most_unknowns)
         !> b = ¼Δt Ω̄, body axes; shape (3).
         real(wp), intent(out) :: b(3)
      end subroutine find_cayley_vector

      pure subroutine find_start_vector(self, system, b)
         import :: implicit_equations_t, system_t, wp
         class(implicit_equations_t), intent(in) :: self
         type(system_t), intent(in) :: system
         !> Body axes; shape (3).
         real(wp), intent(out) :: b(3)
      end subroutine find_start_vector

      pure subroutine find_unknowns(self, system, b, z)
         import :: implicit_equations_t, system_t, most_unknowns, wp
         class(implicit_equations_t), intent(in) :: self
         type(system_t), intent(in) :: system
         !> b = ¼Δt Ω̄, body axes; shape (3).
         real(wp), intent(in) :: b(3)
         real(wp), intent(out) :: z(most_unknowns)
      end subroutine find_unknowns

      subroutine move_state(self, system, state, dt, z)
         import :: implicit_equations_t, system_t, state_t, most_unknowns, wp
         class(implicit_equations_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(inout) :: state
         real(wp), intent(in) :: dt
         !> The root, for which `get_cayley_vector` was asked last.
         real(wp), intent(in) :: z(most_unknowns)
      end subroutine move_state

      subroutine transfer_more(self, archive)
         import :: implicit_equations_t, archive_t
         class(implicit_equations_t), intent(inout) :: self
         class(archive_t), intent(inout) :: archive
      end subroutine transfer_more
   end interface

contains

   !> Writes what `transfer_form` shows as numbers.
   subroutine put_form(self, room, numbers, used)
      class(implicit_equations_t), intent(inout) :: self
      integer, intent(in) :: room
      real(wp), intent(inout), target :: numbers(room)
      !> Numbers in use before and after.
      integer, intent(inout) :: used
      type(number_archive_t) :: archive
      call archive%begin_writing(numbers(used + 1:))
      call self%transfer_form(archive)
      used = used + archive%count()
   end subroutine put_form

   !> Reads what `transfer_form` shows from numbers.
   subroutine take_form(self, room, numbers, used)
      class(implicit_equations_t), intent(inout) :: self
      integer, intent(in) :: room
      real(wp), intent(in), target :: numbers(room)
      !> Numbers read before and after.
      integer, intent(inout) :: used
      type(number_archive_t) :: archive
      call archive%begin_reading(numbers(used + 1:))
      call self%transfer_form(archive)
      used = used + archive%count()
   end subroutine take_form

end module nutate_implicit_equations
