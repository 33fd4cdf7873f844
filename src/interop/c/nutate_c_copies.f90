!> C interface: copies of steppers, in memory and as bytes. The functions are documented in `include/nutate_runs.h`.
module nutate_c_copies
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_int, c_loc, c_null_ptr, c_ptr, c_size_t
   use nutate_archive, only: archive_t
   use nutate_byte_archive, only: byte_archive_t
   use nutate_c_effects, only: report_failures_to
   use nutate_c_stepper_handle, only: conclude, found, null_argument, open_slot, report, stepper_handle_t, unprepare
   use nutate_c_polls, only: poll_t
   use nutate_c_quantity, only: c_event_t
   use nutate_c_settings, only: prepare
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_kinds, only: long
   use nutate_method_choice, only: AUTOMATIC_METHOD
   use nutate_methods, only: make_stepper, stepper_t
   use nutate_progress, only: start_run, transfer_progress
   use nutate_limits, only: attitude_tolerance, is_moderate, is_unit
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_step_policy, only: step_policy_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_HANDLE, NUTATE_NO_MEMORY, NUTATE_OK, &
      NUTATE_TRUNCATED
   use nutate_version, only: version
   implicit none
   private

   public :: nutate_stepper_copy, nutate_stepper_save, nutate_stepper_restore

contains

   integer(c_int) function nutate_stepper_copy(stepper, copy, message, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper, copy, message
      integer(c_size_t), intent(in), value :: size
      type(c_ptr), pointer :: slot
      type(stepper_handle_t), pointer :: from, handle
      class(stepper_t), allocatable :: method, inside, spare
      class(step_policy_t), allocatable :: policy
      type(status_t) :: status
      integer :: failed
      slot => open_slot(copy)
      if (.not. associated(slot)) then
         status = null_argument('copy')
      else if (.not. found(stepper, from)) then
         status = fail(NUTATE_BAD_HANDLE, 'stepper is NULL, destroyed or not a stepper')
      else
         ! The stepper is copied by its own procedure. The step policy points to it; the next run makes a new policy.
         if (allocated(from%run%stepper)) call move_alloc(from%run%stepper, method)
         if (allocated(from%run%policy)) call move_alloc(from%run%policy, policy)
         if (allocated(from%inside)) call move_alloc(from%inside, inside)
         if (allocated(from%run%spare)) call move_alloc(from%run%spare, spare)
         allocate (handle, source=from, stat=failed)
         if (failed /= 0) status = fail(NUTATE_NO_MEMORY, 'not enough memory for a stepper')
         if (allocated(policy)) call move_alloc(policy, from%run%policy)
         if (allocated(inside)) call move_alloc(inside, from%inside)
         if (allocated(spare)) call move_alloc(spare, from%run%spare)
         if (allocated(method)) then
            if (failed == 0) call method%copy(handle%run%stepper)
            call move_alloc(method, from%run%stepper)
         end if
         if (failed == 0) then
            call report_failures_to(handle%system%effects, c_loc(handle%failure))
            if (allocated(handle%run%events)) call report_failures_to(handle%run%events%system%effects, &
                                                                      c_loc(handle%failure))
            call point_events(handle)
            handle%poll = poll_t()
            slot = c_loc(handle)
         end if
      end if
      code = report(status, message, size)
   end function nutate_stepper_copy

   integer(c_int) function nutate_stepper_save(stepper, bytes, size, needed) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper, bytes
      integer(c_size_t), intent(in), value :: size
      integer(c_size_t), intent(inout), optional :: needed
      type(stepper_handle_t), pointer :: handle
      character(kind=c_char), pointer :: room(:)
      character(len=:), allocatable :: content
      type(byte_archive_t) :: archive
      type(status_t) :: status
      integer :: i
      if (present(needed)) needed = 0
      if (.not. found(stepper, handle, code)) return
      call archive%begin_writing()
      call transfer_handle(handle, archive, status)
      if (status%ok() .and. archive%problem() /= '') status = fail(NUTATE_BAD_ARGUMENT, archive%problem())
      if (status%ok()) then
         content = archive%content()
         if (present(needed)) needed = len(content, c_size_t)
         if (c_associated(bytes) .and. size >= len(content, c_size_t)) then
            call c_f_pointer(bytes, room, [len(content)])
            do i = 1, len(content)
               room(i) = content(i:i)
            end do
         else if (c_associated(bytes)) then
            status = fail(NUTATE_TRUNCATED, 'the bytes do not fit into their buffer', 'size')
         end if
      end if
      code = conclude(handle, status)
   end function nutate_stepper_save

   integer(c_int) function nutate_stepper_restore(stepper, bytes, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper, bytes
      integer(c_size_t), intent(in), value :: size
      type(stepper_handle_t), pointer :: handle, trial
      type(c_ptr), target :: twin
      character(kind=c_char), pointer :: given(:)
      character(len=:), allocatable :: content
      type(status_t) :: status
      integer :: i
      if (.not. found(stepper, handle, code)) return
      if (.not. c_associated(bytes) .or. size < 0 .or. size > huge(1)) then
         code = conclude(handle, fail(NUTATE_BAD_ARGUMENT, 'bytes is NULL, or size out of its range', 'bytes'))
         return
      end if
      call c_f_pointer(bytes, given, [size])
      allocate (character(len=int(size)) :: content)
      do i = 1, int(size)
         content(i:i) = given(i)
      end do
      ! A copy reads the bytes first, so that bytes that are rejected leave the stepper as it is.
      if (nutate_stepper_copy(stepper, c_loc(twin), c_null_ptr, 0_c_size_t) == NUTATE_OK) then
         call c_f_pointer(twin, trial)
         call read_bytes(trial, content, status)
         deallocate (trial)
         if (status%ok()) call read_bytes(handle, content, status)
      else
         status = fail(NUTATE_NO_MEMORY, 'not enough memory for a stepper')
      end if
      code = conclude(handle, status)
   end function nutate_stepper_restore

   !> Reads a stepper from saved bytes. Errors: `NUTATE_BAD_ARGUMENT`, and those of callbacks; the stepper is then
   !> undefined.
   subroutine read_bytes(handle, content, status)
      type(stepper_handle_t), intent(inout) :: handle
      character(len=*), intent(in) :: content
      type(status_t), intent(out) :: status
      type(byte_archive_t) :: archive
      call archive%begin_reading(content)
      call transfer_handle(handle, archive, status)
      if (status%ok() .and. archive%problem() /= '') &
         status = fail(NUTATE_BAD_ARGUMENT, 'the bytes are not those of a stepper of this system, with these '// &
                       'settings, saved by this version (expected bytes of nutate_stepper_save)', 'bytes')
   end subroutine read_bytes

   !> Makes the events of the program report their failures to the stepper.
   subroutine point_events(handle)
      type(stepper_handle_t), intent(inout), target :: handle
      integer :: i
      do i = 1, handle%events%count()
         select type (item => handle%events%slots(i)%item)
         class is (c_event_t)
            item%failure = c_loc(handle%failure)
         end select
      end do
      if (.not. allocated(handle%run%events)) return
      do i = 1, size(handle%run%events%watched)
         select type (item => handle%run%events%watched(i)%event)
         class is (c_event_t)
            item%failure = c_loc(handle%failure)
         end select
      end do
   end subroutine point_events

   !> Writes or reads all that changes in a stepper, in checkpoint data: another stepper of the same system, settings
   !> and columns can continue from them. Errors: those of callbacks.
   subroutine transfer_handle(handle, archive, status)
      type(stepper_handle_t), intent(inout) :: handle
      class(archive_t), intent(inout) :: archive
      type(status_t), intent(out) :: status
      type(state_t) :: first
      logical :: ready, stale
      call archive%expect('stepper '//version)
      call archive%expect(handle%names)
      ready = allocated(handle%run%stepper)
      stale = handle%stale
      call archive%transfer(stale)
      call archive%transfer(ready)
      call archive%transfer(handle%run%keeps_dense_output)
      first = handle%first%state()
      call first%transfer(archive)
      call first%transfer_wheels(archive)
      call handle%first%set(first)
      call archive%transfer(handle%first_energy)
      if (archive%is_reading() .and. .not. allocated(handle%given)) &
         allocate (handle%given, source=handle%system%effects)
      if (allocated(handle%run%spare)) handle%run%spare%keeps_system = .false.
      call handle%system%effects%transfer_switches(archive)
      call transfer_run()
      if (.not. allocated(handle%found)) allocate (handle%found)
      if (status%ok()) call handle%found%transfer(archive, status)
      if (.not. (status%ok() .and. archive%is_whole())) return
      if (archive%is_reading() .and. .not. stale) call prepare(handle, status)
      if (status%ok() .and. .not. stale) call archive%expect(settings_of())
      if (status%ok() .and. .not. stale) call transfer_method()
      handle%stale = stale
      if (archive%is_reading() .and. .not. (ready .and. status%ok())) call unprepare(handle)
      if (status%ok()) call handle%columns%transfer(archive)

   contains

      !> Writes or reads the chosen method, and the data that it keeps between steps. Errors: those of its `prepare`.
      subroutine transfer_method()
         character(len=:), allocatable :: method, formulation, choice
         associate (run => handle%run, settings => handle%run%summary%settings)
            method = settings%method
            formulation = settings%formulation
            choice = trim(run%summary%choice)
            call archive%transfer(method)
            call archive%transfer(formulation)
            call archive%transfer(choice)
            call archive%transfer(settings%order)
            call archive%transfer(settings%series_order)
            call archive%transfer(settings%conserve)
            call archive%transfer(settings%attitude)
            call archive%transfer(settings%in_space_axes)
            if (.not. archive%is_whole()) return
            if (archive%is_reading()) then
               settings%method = method
               settings%formulation = formulation
               run%summary%choice = choice
               ! A stepper that has done nothing yet has not chosen its method.
               if (method == AUTOMATIC_METHOD) return
               call make_stepper(handle%system, settings, run%stepper, status)
               if (status%ok() .and. run%keeps_dense_output) call run%stepper%keep_steps()
            end if
            if (ready .and. status%ok()) call run%stepper%transfer(archive)
         end associate
      end subroutine transfer_method

      !> Writes or reads the present state, the run that has led to it, and the state of its events.
      subroutine transfer_run()
         type(integrator_settings_t) :: settings
         type(run_plan_t) :: plan
         type(state_t) :: state
         logical :: has_events
         integer :: i
         do i = 1, handle%events%count()
            call archive%expect('event '//trim(handle%events%slots(i)%item%name))
         end do
         call archive%expect('end of events')
         has_events = allocated(handle%run%events)
         call archive%transfer(has_events)
         plan = handle%run%plan
         call archive%transfer(plan%steps_before)
         call archive%transfer(plan%time_step)
         call archive%transfer(plan%goal%accuracy)
         call archive%transfer(plan%goal%error_rate)
         if (archive%is_reading()) then
            if (.not. archive%is_whole()) return
            state = handle%first%state()
            settings = handle%run%summary%settings
            call start_run(handle%run%progress_t, handle%system%effects, state, plan, status)
            handle%run%summary%settings = settings
            if (has_events .and. status%ok()) then
               allocate (handle%run%events)
               call handle%run%events%begin(handle%events, handle%system, state, status)
            end if
            if (.not. status%ok()) return
         end if
         call archive%transfer(handle%run%t_first)
         call transfer_progress(handle%run%progress_t, archive)
         if (.not. archive%is_reading()) return
         associate (now => handle%run%state)
            if (.not. (is_unit(now%q, attitude_tolerance) .and. &
                       all(is_moderate([now%p, now%t, handle%run%t_first])))) &
               status = fail(NUTATE_BAD_ARGUMENT, 'the bytes are damaged (expected bytes of nutate_stepper_save)', &
                             'bytes')
         end associate
      end subroutine transfer_run

      !> Returns the settings of a stepper that decide its steps, as text: numbers by their bits.
      function settings_of() result(text)
         character(len=:), allocatable :: text
         character(len=200) :: line
         associate (given => handle%run%requested, plan => handle%plan)
            write (line, '(2(a,1x),3(i0,1x),2(l1,1x),6(z16,1x))') &
               trim(given%method), trim(given%formulation), given%order, given%series_order, given%max_iterations, &
               given%conserve, given%projection, &
               transfer([given%inverse_auxiliary_inertia, given%tolerance, given%max_step, plan%time_step, &
                         plan%goal%accuracy, plan%goal%local_tolerance], [0_long])
         end associate
         text = trim(line)
      end function settings_of

   end subroutine transfer_handle

end module nutate_c_copies
