!> Bodies of the procedures whose interfaces are in `nutate_progress`.
submodule(nutate_progress) nutate_progress_procedures
   use nutate_control, only: is_watched
   use nutate_event_list, only: event_list_t
   use nutate_range, only: check_attitude
   use nutate_state, only: add_increment
   implicit none

contains

   module procedure start_run
      call check_attitude(state%q, status)
      if (.not. status%ok()) return
      self%plan = plan
      self%state = state
      self%record = run_record_t()
      self%summary = run_summary_t()
      self%t_first = state%t
      if (plan%steps_before > 0) self%t_first = plan%first_time
      self%n_steps = -1
      self%first_step = 0
      self%expected_steps = 0
      self%rows = 0
      self%resumed = .false.
      self%way = way_t()
      self%keeps_starts = .true.
      self%switch_compensation = 0.0_wp
      if (allocated(self%events)) deallocate (self%events)
      if (allocated(self%tangent)) deallocate (self%tangent, self%last_tangent)
      if (allocated(self%last_chaos)) deallocate (self%last_chaos)
      if (allocated(self%work_compensation)) deallocate (self%work_compensation)
      allocate (self%summary%work(effects%n_works()), self%work_compensation(effects%n_works()), source=0.0_wp)
      self%next_break = effects%next_break(state%t, sign(1.0_wp, plan%end_time - state%t))
   end procedure start_run

   module procedure watch_limits
      if (.not. is_watched(system%effects)) return
      allocate (self%events)
      call self%events%begin(event_list_t(), system, self%state, status)
   end procedure watch_limits

   module procedure take_back
      integer :: most_iterations
      most_iterations = self%summary%most_iterations
      self%run_point_t = mark
      self%summary%most_iterations = most_iterations
   end procedure take_back

   module procedure is_over
      if (self%n_steps >= 0) then
         is_over = self%summary%steps >= self%n_steps
      else
         is_over = .not. abs(self%plan%end_time - self%state%t) > 0.0_wp
      end if
   end procedure is_over

   module procedure sense_of
      sense = sign(1.0_wp, self%plan%end_time - self%t_first)
   end procedure sense_of

   module procedure fraction_done
      if (self%n_steps >= 0) then
         fraction_done = real(self%summary%steps - self%first_step, wp)/real(self%n_steps - self%first_step, wp)
      else
         fraction_done = (self%state%t - self%t_first)/(self%plan%end_time - self%t_first)
      end if
   end procedure fraction_done

   module procedure end_of_step
      t = self%t_first + real(self%plan%steps_before + step, wp)*self%plan%time_step
   end procedure end_of_step

   module procedure count_part
      self%summary%parts = self%summary%parts + 1
      self%record%iterations = self%record%iterations + stepper%iterations
      self%record%uncertified = self%record%uncertified + stepper%uncertified
      self%record%residual = max(self%record%residual, stepper%residual)
      call count_works(self, stepper)
   end procedure count_part

   module procedure count_works
      integer :: i
      do i = 1, size(stepper%work)
         call add_increment(self%summary%work(i), self%work_compensation(i), stepper%work(i))
      end do
   end procedure count_works

   module procedure count_step
      self%summary%steps = self%summary%steps + 1
      self%summary%iterations = self%summary%iterations + self%record%iterations
      self%summary%most_iterations = max(self%summary%most_iterations, self%record%iterations)
      if (self%record%uncertified > 0) self%summary%uncertified_steps = self%summary%uncertified_steps + 1
      self%record%step = self%summary%steps
   end procedure count_step

   module procedure total_work
      total_work = sum(self%work) + self%switch_work
   end procedure total_work

   module procedure put_works
      record%work = total_work(self)
      if (allocated(record%works)) record%works(:) = [self%work, self%switch_work]
   end procedure put_works

   module procedure add_works
      if (allocated(record%works)) record%works(:size(works)) = record%works(:size(works)) + works
   end procedure add_works

   module procedure conclude_run
      real(wp), allocatable :: work(:)
      if (.not. allocated(self%summary%work)) return
      state = self%state
      if (.not. present(summary)) return
      ! The work is moved: a copy of it would be one more allocation in every call of NUSTEP.
      call move_alloc(self%summary%work, work)
      summary = self%summary
      call move_alloc(work, summary%work)
   end procedure conclude_run

   module procedure transfer_progress
      call self%state%transfer(archive)
      call self%state%transfer_wheels(archive)
      call self%state%balance%transfer(archive)
      call self%summary%transfer(archive)
      call self%record%transfer(archive)
      call archive%transfer(self%plan%goal%local_tolerance)
      call archive%transfer(self%next_break)
      call archive%transfer(self%work_compensation)
      call archive%transfer(self%rows)
      call archive%transfer(self%way%begun)
      call archive%transfer(self%way%parts)
      call archive%transfer(self%way%level)
      call archive%transfer(self%way%done)
      call archive%transfer(self%way%start)
      call archive%transfer(self%way%length)
      if (allocated(self%tangent)) call self%tangent%transfer(archive)
      if (allocated(self%summary%chaos)) call self%summary%chaos%transfer(archive)
      if (.not. allocated(self%events)) return
      call archive%transfer(self%summary%switch_work)
      call archive%transfer(self%switch_compensation)
      call self%events%transfer(archive)
      if (allocated(self%tangent)) call self%events%transfer_changes(self%tangent%n, archive)
   end procedure transfer_progress

end submodule nutate_progress_procedures
