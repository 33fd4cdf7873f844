!> The projection onto the invariants after steps, as often as round-off asks for it.
!>
!> What a projection takes away comes back slowly, so that without torques only every few steps are projected, counted
!> from the start, while errors are small. What is seen of the steps between is a projected copy: the motion does not
!> depend on who looks. A state that has been seen and comes back stands for the one that it is a copy of.
module nutate_spaced_projection
   use nutate_archive, only: archive_t
   use nutate_invariant_projection, only: invariant_projection_t
   use nutate_kinds, only: wp
   use nutate_noise, only: noise_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   use nutate_work_share, only: step_error_t
   implicit none
   private

   public :: spaced_projection_t, small

   !> Move of a projection, of q and of p relative to |p|, up to which the next may wait: a few times it is far from
   !> what the projection refuses, and steps with larger errors are cheap beside what they lose.
   real(wp), parameter :: small = 1e-4_wp

   !> The projection of one run.
   type :: spaced_projection_t
      private
      type(invariant_projection_t) :: projection
      !> Every step is projected.
      logical :: each = .true.
      !> A step has been taken; steps that began where one did before are told from others.
      logical :: begun = .false., remembers = .false.
      !> Steps to a projection while errors are small; since the last one; from there to the next.
      integer :: usual = 1, count = 0, interval = 1
      !> q and p that the last step left; shape (4).
      real(wp), dimension(4) :: left_q = 0.0_wp, left_p = 0.0_wp
      !> States are compensated sums; the compensations of q and p that the last step left; shape (4).
      logical :: compensated = .false.
      real(wp), dimension(4) :: left_q_compensation = 0.0_wp, left_p_compensation = 0.0_wp
      !> A projected copy of them was seen; its q and p; shape (4).
      logical :: seen = .false.
      real(wp), dimension(4) :: seen_q = 0.0_wp, seen_p = 0.0_wp
      !> Where the last step began, if it can be taken again: state, count and interval; shape (4).
      real(wp), dimension(4) :: first_q = 0.0_wp, first_p = 0.0_wp
      integer :: first_count = 0, first_interval = 1
   contains
      !> Takes the invariants that a system has.
      procedure :: prepare
      !> Takes the noise of a pilot run.
      procedure :: disturb
      !> Takes the targets that another projection has for the state from which a step starts.
      procedure :: adopt
      !> How far round-off of the energy moved the last state that was projected.
      procedure :: moved_by_round_off
      !> From now on steps may be taken again from where they began.
      procedure :: remember_starts
      !> Puts the state that a step left in the place of a copy that was seen.
      procedure :: find_origin
      !> Takes the state from which a step starts.
      procedure :: begin_step
      !> Projects the state that the step reached, if that is due.
      procedure :: end_step
      !> Projects a copy of the state that the last step left.
      procedure :: show
      !> Projects a state inside the last step.
      procedure :: project_inside
      !> Shows what it remembers from step to step to an archive.
      procedure :: transfer
   end type spaced_projection_t

contains

   !> Takes the invariants that a system has. To be called before the first step and after every change of the system.
   pure subroutine prepare(self, system, attitude, usual, compensated)
      class(spaced_projection_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> The attitude is integrated.
      logical, intent(in) :: attitude
      !> Steps to a projection while errors are small. With torques or wheels every step is projected.
      integer, intent(in) :: usual
      !> States are compensated sums, and stay so where moves allow it.
      logical, intent(in), optional :: compensated
      self%compensated = .false.
      if (present(compensated)) self%compensated = compensated
      call self%projection%prepare(system, attitude, self%compensated)
      self%usual = usual
      self%each = usual == 1 .or. system%effects%n_works() > 0
      self%begun = .false.
      self%seen = .false.
      self%remembers = .false.
   end subroutine prepare

   !> Takes the noise of a pilot run, for every state that a step reaches.
   pure subroutine disturb(self, noise)
      class(spaced_projection_t), intent(inout) :: self
      type(noise_t), intent(in) :: noise
      call self%projection%disturb(noise)
   end subroutine disturb

   !> Takes the targets that another projection has for the state from which a step starts.
   pure subroutine adopt(self, other, state)
      class(spaced_projection_t), intent(inout) :: self
      !> Of the same system.
      class(spaced_projection_t), intent(in) :: other
      type(state_t), intent(in) :: state
      call self%projection%adopt(other%projection, state)
   end subroutine adopt

   !> How far round-off of the energy moved the last state that was projected, rad.
   pure real(wp) function moved_by_round_off(self)
      class(spaced_projection_t), intent(in) :: self
      moved_by_round_off = self%projection%moved_by_round_off
   end function moved_by_round_off

   !> From now on steps may be taken again from where they began.
   pure subroutine remember_starts(self)
      class(spaced_projection_t), intent(inout) :: self
      self%remembers = .true.
   end subroutine remember_starts

   !> Puts the state that a step left in the place of a copy that was seen.
   pure subroutine find_origin(self, state)
      class(spaced_projection_t), intent(in) :: self
      type(state_t), intent(inout) :: state
      if (self%each .or. .not. (self%begun .and. self%seen)) return
      if (.not. state%is_at(self%seen_q, self%seen_p)) return
      state%q = self%left_q
      state%p = self%left_p
      state%q_compensation = self%left_q_compensation
      state%p_compensation = self%left_p_compensation
   end subroutine find_origin

   !> Takes the state from which a step starts: the one that the last step left, for a copy of it too, or the one it
   !> began with, for a step that is taken again; any other one is projected after its first step.
   pure subroutine begin_step(self, system, state)
      class(spaced_projection_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      logical :: known
      if (self%each) then
         call self%projection%follow(system, state)
         return
      end if
      call self%find_origin(state)
      known = self%begun
      if (known) known = state%is_at(self%left_q, self%left_p)
      if (self%begun .and. self%remembers .and. .not. known) then
         known = state%is_at(self%first_q, self%first_p)
         if (known) self%count = self%first_count
         if (known) self%interval = self%first_interval
      end if
      if (.not. known) then
         call self%projection%follow(system, state)
         ! Until the step has been taken: one that fails may have been no state of the run.
         self%begun = .false.
         self%count = 0
         self%interval = 1
      end if
      if (.not. self%remembers) return
      self%first_q = state%q
      self%first_p = state%p
      self%first_count = self%count
      self%first_interval = self%interval
   end subroutine begin_step

   !> Counts a step, and projects the state if that is due. Errors, with state and count as they were: those of the
   !> projection.
   pure subroutine end_step(self, system, state, due, work, status, error, given)
      class(spaced_projection_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      !> It is due in any case.
      logical, intent(in) :: due
      !> Work of all torques in the step, J.
      real(wp), intent(in) :: work
      !> Success on entry.
      type(status_t), intent(inout) :: status
      !> Estimated error of the step, and what works take for it, J: zero where they take nothing.
      type(step_error_t), intent(in), optional :: error
      real(wp), intent(inout), optional :: given
      real(wp) :: q(4), p(4)
      if (self%each) then
         call self%projection%project(system, state, work, status, error, given)
         return
      end if
      if (self%count + 1 < self%interval .and. .not. due) then
         self%count = self%count + 1
         call self%projection%shake_state(state)
      else
         q = state%q
         p = state%p
         call self%projection%project(system, state, 0.0_wp, status)
         if (status%code /= 0) return
         self%count = 0
         self%interval = 1
         if (maxval(abs(state%q - q)) <= small .and. maxval(abs(state%p - p)) <= small*maxval(abs(p))) &
            self%interval = self%usual
      end if
      self%begun = .true.
      self%left_q = state%q
      self%left_p = state%p
      self%seen = .false.
      self%left_q_compensation = state%q_compensation
      self%left_p_compensation = state%p_compensation
   end subroutine end_step

   !> Projects a copy of the state that the last step left. One that the projection cannot reach stays as it is: the
   !> step that is to be projected fails.
   pure subroutine show(self, system, state)
      class(spaced_projection_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      type(status_t) :: status
      if (self%each .or. .not. self%begun .or. self%count == 0) return
      if (.not. state%is_at(self%left_q, self%left_p)) return
      call self%projection%project_aside(system, state, .false., 0.0_wp, status)
      self%seen = .true.
      self%seen_q = state%q
      self%seen_p = state%p
   end subroutine show

   !> Projects a state inside the last step. Errors: those of the projection.
   pure subroutine project_inside(self, system, state, work, status, error, given)
      class(spaced_projection_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      !> Work of all torques from the start of the step to the state, J.
      real(wp), intent(in) :: work
      !> Success on entry.
      type(status_t), intent(inout) :: status
      !> As of `end_step`.
      type(step_error_t), intent(in), optional :: error
      real(wp), intent(inout), optional :: given
      call self%projection%project_aside(system, state, .true., work, status, error, given)
   end subroutine project_inside

   !> Shows what it remembers from step to step to an archive.
   subroutine transfer(self, archive)
      class(spaced_projection_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call self%projection%transfer(archive)
      call archive%transfer(self%begun)
      call archive%transfer(self%count)
      call archive%transfer(self%interval)
      call archive%transfer(self%left_q)
      call archive%transfer(self%left_p)
      call archive%transfer(self%left_q_compensation)
      call archive%transfer(self%left_p_compensation)
      call archive%transfer(self%seen)
      call archive%transfer(self%seen_q)
      call archive%transfer(self%seen_p)
   end subroutine transfer

end module nutate_spaced_projection
