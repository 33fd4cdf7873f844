!> Bodies of the procedures whose interfaces are in `nutate_stepper`.
submodule(nutate_stepper) nutate_stepper_procedures
   use nutate_sensitivity_projection, only: kept_steps, project_sensitivities
   use nutate_number_archive, only: number_archive_t
   use nutate_range, only: check_system
   use nutate_status, only: fail, NUTATE_BAD_ARGUMENT
   implicit none

contains

   module procedure prepare_stepper
      if (.not. self%keeps_system) then
         call check_system(system, status)
         if (allocated(self%work)) deallocate (self%work)
      end if
      if (status%ok()) call check_settings(settings, status)
      if (.not. status%ok()) return
      if (.not. allocated(self%work)) allocate (self%work(system%effects%n_works()))
      self%work(:) = 0.0_wp
      self%iterations = 0
      self%residual = 0.0_wp
      self%continued = 0
      self%uncertified = 0
      self%error_estimate = 0.0_wp
      self%step_error = step_error_t()
      self%prepared_with = settings
      if (.not. self%keeps_system) self%system_mark = 0
      self%keeps_steps = .false.
      self%last_length = 0.0_wp
      if (allocated(self%again)) deallocate (self%again)
      call self%set_up(system, settings, status)
      if (status%ok() .and. self%system_mark == 0) self%system_mark = mark_of(system)
      self%keeps_system = .false.
   end procedure prepare_stepper

   module procedure renew
      type(integrator_settings_t) :: settings
      logical :: keeps
      settings = self%prepared_with
      keeps = self%keeps_steps
      call self%prepare(system, settings, status)
      if (keeps .and. status%ok()) call self%keep_steps()
   end procedure renew

   !> Tests the settings that all methods have. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine check_settings(settings, status)
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
      if (.not. settings%max_step > 0.0_wp) then
         status = fail(NUTATE_BAD_ARGUMENT, 'max_step is out of range (expected a number > 0)', 'max_step')
      else if (settings%max_iterations < 1) then
         status = fail(NUTATE_BAD_ARGUMENT, 'max_iterations is out of range (expected 1 or more)', 'max_iterations')
      else if (.not. settings%tolerance >= 0.0_wp) then
         status = fail(NUTATE_BAD_ARGUMENT, 'tolerance is out of range (expected a number >= 0)', 'tolerance')
      end if
   end subroutine check_settings

   !> Returns a fingerprint of a system, from its inertia, the rate of its frame, its numbers of potentials, torques,
   !> rotors and wheels, and the sizes of potentials and torques, which tell most types apart.
   pure integer function mark_of(system) result(mark)
      type(system_t), intent(in) :: system
      real(wp), parameter :: weights(3, 3) = reshape([1.0_wp, 1.1_wp, 1.3_wp, 1.4_wp, 1.7_wp, 1.9_wp, 2.3_wp, 2.6_wp, &
                                                      2.9_wp], [3, 3])
      real(wp) :: number
      integer :: halves(2), i
      associate (effects => system%effects)
         number = 1 + effects%n_potentials + 1e2_wp*effects%n_torques + 1e4_wp*effects%n_rotors + &
                  1e5_wp*effects%n_wheels
         do i = 1, effects%n_potentials
            number = modulo(1.1_wp*number + storage_size(effects%potentials(i)%item), 1e9_wp)
         end do
         do i = 1, effects%n_torques
            number = modulo(1.1_wp*number + storage_size(effects%torques(i)%item), 1e9_wp)
         end do
         if (effects%frame_turns) number = 1.3_wp*number + sum(weights(:, 1)*effects%frame_rate)
         number = sum(weights*system%body%inertia)*number
      end associate
      halves = transfer(number, halves)
      mark = ieor(halves(1), halves(2))
   end function mark_of

   module procedure check_prepared
      if (self%system_mark /= mark_of(system)) &
         status = fail(NUTATE_BAD_ARGUMENT, 'the stepper was prepared for another system, or before the system '// &
                       'changed (expected make_stepper or renew)', 'system')
   end procedure check_prepared

   module procedure take_step
      call check_prepared(self, system, status)
      if (status%code /= 0) return
      if (self%keeps_steps) call self%mark_step(state, dt, state%t + 0.5_wp*dt)
      call self%advance(system, state, dt, state%t + 0.5_wp*dt, status)
      if (status%code == 0) call self%project_for_output(system, state)
   end procedure take_step

   module procedure copy
      class(*), allocatable :: again, its_own
      if (allocated(self%again)) call move_alloc(self%again, again)
      allocate (twin, source=self)
      if (.not. allocated(again)) return
      select type (again)
      class is (stepper_t)
         allocate (its_own, source=again)
      end select
      call move_alloc(its_own, twin%again)
      call move_alloc(again, self%again)
   end procedure copy

   module procedure keep_steps
      class(*), allocatable :: twin
      if (.not. (self%keeps_steps .or. self%chooses_steps())) then
         allocate (twin, source=self)
         call move_alloc(twin, self%again)
      end if
      call keep_starts(self)
   end procedure keep_steps

   module procedure keep_starts
      if (.not. allocated(self%last_start)) allocate (self%last_start)
      self%keeps_steps = .true.
   end procedure keep_starts

   module procedure mark_step
      self%last_start = state
      self%last_length = dt
      self%last_window = window_time
      self%used = .false.
   end procedure mark_step

   module procedure state_taken_again
      type(state_t) :: inside
      work = 0.0_wp
      if (present(works)) works = 0.0_wp
      if (.not. (allocated(self%again) .and. is_inside(self, t))) then
         status = fail(NUTATE_BAD_ARGUMENT, outside)
         return
      end if
      inside = self%last_start
      if (abs(t - self%last_start%t) > 0.0_wp) then
         select type (again => self%again)
         class is (stepper_t)
            if (.not. self%used) call again%forget_steps()
            self%used = .true.
            call again%advance(system, inside, t - self%last_start%t, self%last_window, status)
            if (status%code /= 0) then
               ! A failed step has discarded the steps before it: without their prediction it may succeed.
               status = status_t()
               call again%advance(system, inside, t - self%last_start%t, self%last_window, status)
            end if
            if (status%code /= 0) return
            work = sum(again%work)
            if (present(works)) works(:) = again%work
            self%step_error = again%step_error
         end select
         inside%t = t
      end if
      state = inside
   end procedure state_taken_again

   module procedure is_inside
      real(wp) :: since, margin
      is_inside = self%keeps_steps .and. abs(self%last_length) > 0.0_wp
      if (.not. is_inside) return
      since = sign(1.0_wp, self%last_length)*(t - self%last_start%t)
      margin = 4*spacing(max(abs(self%last_start%t), abs(self%last_length)))
      is_inside = since >= 0.0_wp .and. since <= abs(self%last_length) + margin
   end procedure is_inside

   module procedure chooses_none
      chooses_none = .false.
   end procedure chooses_none

   module procedure chooses_all
      chooses_all = .true.
   end procedure chooses_all

   module procedure keep_estimate
   end procedure keep_estimate

   module procedure forget_nothing
   end procedure forget_nothing

   module procedure forget_for_commands
      call self%forget_steps()
   end procedure forget_for_commands

   module procedure refuse_archive
      call archive%refuse('this method cannot be interrupted and go on')
   end procedure refuse_archive

   module procedure put_by_archive
      type(number_archive_t) :: archive
      call archive%begin_writing(numbers(used + 1:))
      call self%transfer(archive)
      used = used + archive%count()
   end procedure put_by_archive

   module procedure take_by_archive
      type(number_archive_t) :: archive
      call archive%begin_reading(numbers(used + 1:))
      call self%transfer(archive)
      used = used + archive%count()
   end procedure take_by_archive

   module procedure leave_state
   end procedure leave_state

   module procedure refuse_tangent
      status = fail(NUTATE_BAD_ARGUMENT, "method = '"//trim(self%prepared_with%method)//"' has no sensitivities "// &
                    '(expected another method)', 'method')
   end procedure refuse_tangent

   module procedure propagate
      call self%propagate_step(system, before, after, dt, window_time, tangent, status)
      if (status%code /= 0 .or. .not. self%conserves) return
      tangent%steps = tangent%steps + 1
      if (tangent%steps < kept_steps) return
      tangent%steps = 0
      call project_sensitivities(system, after, .true., tangent)
   end procedure propagate

   module procedure propagate_inside
      real(wp) :: since
      since = state%t - self%last_start%t
      if (.not. abs(since) > 0.0_wp) return
      if (.not. allocated(self%again)) then
         call self%propagate(system, self%last_start, state, since, self%last_window, tangent, status)
         return
      end if
      select type (again => self%again)
      class is (stepper_t)
         call again%propagate(system, self%last_start, state, since, self%last_window, tangent, status)
      end select
   end procedure propagate_inside

   module procedure leave_noise
   end procedure leave_noise

end submodule nutate_stepper_procedures
