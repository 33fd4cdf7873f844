!> Moves a state by a length: in one step of a method, or, if that fails, in parts as short as necessary.
module nutate_step_subdivision
   use nutate_failure_causes, only: add_cause
   use nutate_kinds, only: wp, long
   use nutate_progress, only: count_part, progress_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_NOT_CONVERGED, NUTATE_OFF_BRANCH, NUTATE_SINGULAR
   use nutate_stepper, only: stepper_t, system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: go_inside, spare_tries, perform_next_part, try, try_piece

   !> A step that fails is subdivided into up to 2**deepest_level parts. A part can be followed if it rotates the body
   !> by less than about 2 rad: a step that fails in 1024 parts fails for another reason, or was meant to be another
   !> step.
   integer, parameter :: deepest_level = 10
   !> Number of lengths that continuation may always try, whatever the limit of steps: a step in 1024 parts needs about
   !> as many, and must not fail because of a small limit. Beyond this number, and beyond ten times the allowed steps, a
   !> step is not subdivided further: such a run has failed, and is not continued from checkpoint data.
   integer(long), parameter :: spare_tries = 1000

contains

   !> Moves the state by `length` in one step, or, if that fails, by the first part of it that does not.
   subroutine try_piece(stepper, system, progress, length, status)
      class(stepper_t), intent(inout) :: stepper
      type(system_t), intent(in) :: system
      type(progress_t), intent(inout) :: progress
      real(wp), intent(in) :: length
      type(status_t), intent(inout) :: status
      type(status_t), parameter :: success = status_t()
      call try(stepper, system, progress, length, status)
      if (status%code /= 0) then
         progress%record%iterations = progress%record%iterations + stepper%iterations
         status = success
         call try(stepper, system, progress, length, status)
      end if
      if (status%code == 0) then
         call count_part(progress, stepper)
      else
         progress%record%iterations = progress%record%iterations + stepper%iterations
         progress%way%start = progress%state%t
         progress%way%length = length
         progress%way%done = 0
         call perform_next_part(stepper, system, progress, status)
      end if
   end subroutine try_piece

   !> Takes a step of the method, and counts the lengths that it tried by continuation.
   subroutine try(stepper, system, progress, length, status)
      class(stepper_t), intent(inout) :: stepper
      type(system_t), intent(in) :: system
      type(progress_t), intent(inout) :: progress
      real(wp), intent(in) :: length
      !> Success on entry.
      type(status_t), intent(inout) :: status
      if (stepper%keeps_steps .and. progress%keeps_starts) &
         call stepper%mark_step(progress%state, length, progress%state%t + 0.5_wp*length)
      call stepper%advance(system, progress%state, length, progress%state%t + 0.5_wp*length, status)
      progress%last_length = length
      progress%record%continued = progress%record%continued + stepper%continued
   end subroutine try

   !> Moves the state by the next part of a piece that is subdivided, as long as it does not fail.
   subroutine perform_next_part(stepper, system, progress, status)
      class(stepper_t), intent(inout) :: stepper
      type(system_t), intent(in) :: system
      !> Run; the level of its way is 0 again at the end of the piece.
      type(progress_t), intent(inout) :: progress
      !> Failure of the last try, if it failed, on entry.
      type(status_t), intent(inout) :: status
      type(status_t), parameter :: success = status_t()
      character(len=12) :: parts
      do
         if (status%code /= 0) then
            if (all(status%code /= [NUTATE_NOT_CONVERGED, NUTATE_OFF_BRANCH, NUTATE_SINGULAR])) return
            if (progress%way%level == deepest_level) then
               write (parts, '(i0)') 2**deepest_level
               status%message = trim(status%message)//', even subdivided into '//trim(parts)//' parts'
               call add_cause(stepper, system, status)
               return
            end if
            progress%way%level = progress%way%level + 1
            progress%way%done = 2*progress%way%done
            status = success
         end if
         if (progress%record%continued > spare_tries .and. &
             progress%record%continued/10 > progress%plan%max_steps) then
            status = fail(NUTATE_NOT_CONVERGED, 'the step needed more attempts than allowed')
            return
         end if
         call try(stepper, system, progress, progress%way%length/2**progress%way%level, status)
         if (status%code == 0) exit
         progress%record%iterations = progress%record%iterations + stepper%iterations
      end do
      associate (way => progress%way)
         way%done = way%done + 1
         progress%state%t = way%start + way%length*(real(way%done, wp)/2**way%level)
         call count_part(progress, stepper)
         if (way%done == 2**way%level) way%level = 0
      end associate
   end subroutine perform_next_part

   !> Moves the start of the last step to a time inside of it, by one step or more. Errors: those of the stepper.
   subroutine go_inside(stepper, system, parts, t, end_time, state, work, status, works, tangent)
      !> Stepper that is used for nothing else.
      class(stepper_t), intent(inout) :: stepper
      type(system_t), intent(in) :: system
      !> Number of steps.
      integer, intent(in) :: parts
      !> Time inside the step, and of its end, s.
      real(wp), intent(in) :: t, end_time
      type(state_t), intent(inout) :: state
      !> Work, J, to which that of these steps is added.
      real(wp), intent(inout) :: work
      type(status_t), intent(inout) :: status
      real(wp), intent(inout), optional :: works(:)
      !> Sensitivities, moved along with the state.
      type(tangent_t), intent(inout), optional :: tangent
      type(state_t) :: before
      real(wp) :: length, middle
      integer :: i
      length = (t - state%t)/parts
      middle = 0.5_wp*(state%t + end_time)
      do i = 1, parts
         if (present(tangent)) before = state
         call stepper%advance(system, state, length, middle, status)
         if (present(tangent) .and. status%code == 0) &
            call stepper%propagate(system, before, state, length, middle, tangent, status)
         if (status%code /= 0) return
         work = work + sum(stepper%work)
         if (present(works)) works(:) = works + stepper%work
      end do
      state%t = t
   end subroutine go_inside

end module nutate_step_subdivision
