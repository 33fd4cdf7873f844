!> Bodies of FORTRAN 77 programs, prepared for their steps.
!>
!> All data of a body stay in WORK, as plain numbers. System and stepper, made from the set-up in WORK, are kept in a
!> cache of the thread, so that they are made once and not in every call: a call finds them by a hash of the set-up.
!> Work arrays with the same set-up share them, copies included; each call restores the memory of the stepper from its
!> own WORK. Nothing in the cache changes a result, so that bodies may leave it.
module nutate_f77_prepared
   use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_loc, c_ptr
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_damping, only: damping_t
   use nutate_effect_list, only: effect_list_t
   use nutate_f77_callback, only: f77_call_t, f77_potential_t, f77_torque_t
   use nutate_f77_interfaces, only: f77_potential, f77_torque
   use nutate_f77_work, only: AT_CALL, AT_DT, AT_FIRST_TIME, AT_MARK, AT_P_COMPENSATION, &
      AT_Q_COMPENSATION, AT_STEPS, continues, count_memory, get_memory, get_setup, has_setup, place_at, settings_of, &
      setup_of, setup_t
   use nutate_gravity, only: gravity_t
   use nutate_kinds, only: wp
   use nutate_methods, only: make_stepper
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: stepper_t, system_t
   implicit none
   private

   public :: f77_body_t, find_body, let_go

   !> Number of bodies that a cache has room for at first, and at most: some 100 MB at order 2.
   integer, parameter :: first_room = 64, most_room = 16384
   !> Largest number of places that are searched for a body; with more, a search without success costs more than it
   !> saves.
   integer, parameter :: most_places = 8

   !> A body as NUINIT received it, ready for steps.
   type :: f77_body_t
      type(setup_t) :: setup
      !> The numbers of the set-up and their hash, as in WORK.
      real(wp), allocatable, private :: numbers(:)
      real(wp), private :: hash = 0.0_wp
      type(system_t) :: system
      class(stepper_t), allocatable :: stepper
      !> Data of the stepper before its first step.
      real(wp), allocatable :: fresh(:)
      !> State that steps update; its wheels and its energy balance stay empty.
      type(state_t) :: state
      !> Time from which steps are counted, and their length, s; number of steps since then.
      real(wp) :: first_time = 0.0_wp, dt = 0.0_wp, steps = 0.0_wp
      !> Mark that no other body has, and number of the call: a WORK with both was left by the last call of the body.
      real(wp) :: mark = 0.0_wp, call = 0.0_wp
      !> Status of the steps: success between two calls.
      type(status_t) :: status
      !> Callbacks and user data of the present call.
      type(f77_call_t) :: now
      !> Flag, 1 if a callback has returned a number that is not finite or exceeds 1e100.
      integer :: failed = 0
      !> True while a call uses the body: a call inside a callback needs another one. True if the body is in no cache.
      logical, private :: is_busy = .false., is_alone = .false.
   contains
      !> Returns true if a call continues the last one of the body, with its step: nothing has to be tested, or
      !> restored.
      procedure :: is_next
      !> Restores the state of any other call, and the data that WORK keeps of the steps to it.
      procedure :: recall
      !> Clears the failure of a step.
      procedure :: start_again
      !> Sets the callbacks of a call.
      procedure :: set_potential
      procedure :: set_torque
   end type f77_body_t

   !> Holds one body, or none.
   type :: slot_t
      type(f77_body_t), pointer :: body => null()
   end type slot_t

   !> Bodies of a thread: a table in which a body is near the place that its hash gives.
   type :: cache_t
      !> Places of the table; shape (0:room - 1), the room a power of two.
      type(slot_t), allocatable :: places(:)
   end type cache_t

   interface
      type(c_ptr) function cache_of_thread() bind(C, name='nutate_f77_cache')
         import :: c_ptr
      end function cache_of_thread

      real(c_double) function new_mark() bind(C, name='nutate_f77_mark')
         import :: c_double
      end function new_mark

      subroutine keep_cache(cache) bind(C, name='nutate_f77_keep_cache')
         import :: c_ptr
         type(c_ptr), intent(in), value :: cache
      end subroutine keep_cache
   end interface

contains

   !> Returns the body of a work array, from the cache or newly made. Callers give it back with `let_go`.
   function find_body(work) result(body)
      !> Work array from NUINIT.
      real(wp), intent(in), target :: work(*)
      type(f77_body_t), pointer :: body
      type(cache_t), pointer :: cache
      type(c_ptr) :: address
      address = cache_of_thread()
      if (c_associated(address)) then
         call c_f_pointer(address, cache)
         body => cache%places(home(work(5), size(cache%places)))%body
         if (associated(body)) then
            if (is_of(body, work) .and. .not. body%is_busy) then
               body%is_busy = .true.
               body%failed = 0
               return
            end if
         end if
      end if
      body => search_body(work)
   end function find_body

   !> Returns the body of a work array, from the cache or newly made, if it is not in its first place.
   function search_body(work) result(body)
      real(wp), intent(in), target :: work(*)
      type(f77_body_t), pointer :: body
      type(cache_t), pointer :: cache
      integer :: i, place, room
      if (c_associated(cache_of_thread())) then
         call c_f_pointer(cache_of_thread(), cache)
      else
         allocate (cache)
         allocate (cache%places(0:first_room - 1))
         call keep_cache(c_loc(cache))
      end if
      room = size(cache%places)
      do i = 0, most_places - 1
         place = iand(home(work(5), room) + i, room - 1)
         body => cache%places(place)%body
         if (.not. associated(body)) exit
         if (is_of(body, work)) exit
         body => null()
      end do
      if (.not. associated(body)) then
         body => new_body(work)
         call put(cache, body)
      else if (body%is_busy) then
         body => new_body(work)
         body%is_alone = .true.
      end if
      body%is_busy = .true.
      body%failed = 0
   end function search_body

   !> Returns true if the set-up of a body is that of a work array; a mark shows this if the body has used the array or
   !> a copy.
   pure logical function is_of(body, work)
      type(f77_body_t), intent(in) :: body
      real(wp), intent(in) :: work(*)
      is_of = work(place_at(work) + AT_MARK) == body%mark
      if (is_of) return
      is_of = work(5) == body%hash
      if (is_of) is_of = has_setup(work, body%numbers)
   end function is_of

   !> Returns the first place of a body.
   pure integer function home(hash, room)
      !> Hash of the set-up, not below 0 unless WORK is broken.
      real(wp), intent(in) :: hash
      integer, intent(in) :: room
      home = 0
      if (hash >= 0.0_wp .and. hash < 2.0_wp**32) home = int(iand(int(hash, int64), int(room - 1, int64)))
   end function home

   !> Gives a body back to the cache, or deletes it if it is in none.
   subroutine let_go(body)
      type(f77_body_t), pointer, intent(inout) :: body
      body%is_busy = .false.
      if (body%is_alone) deallocate (body)
   end subroutine let_go

   !> Returns true if a call continues the last one of the body, with its step.
   pure logical function is_next(self, work, dt, t, q, p)
      class(f77_body_t), intent(in) :: self
      real(wp), intent(in) :: work(*)
      !> Step and time, s; attitude and conjugate momentum, shape (4).
      real(wp), intent(in) :: dt, t, q(4), p(4)
      integer :: k
      k = place_at(work)
      is_next = work(k + AT_MARK) == self%mark .and. work(k + AT_CALL) == self%call .and. dt == self%dt .and. &
                t == self%state%t
      if (is_next) is_next = q(1) == self%state%q(1) .and. q(2) == self%state%q(2) .and. q(3) == self%state%q(3) .and. &
                             q(4) == self%state%q(4) .and. p(1) == self%state%p(1) .and. p(2) == self%state%p(2) .and. &
                             p(3) == self%state%p(3) .and. p(4) == self%state%p(4)
   end function is_next

   !> Restores the state of any other call, and the data that WORK keeps of the steps to it.
   subroutine recall(self, work, dt, t, q, p)
      class(f77_body_t), intent(inout) :: self
      real(wp), intent(in), target :: work(*)
      !> Step and time, s; attitude and conjugate momentum, shape (4).
      real(wp), intent(in) :: dt, t, q(4), p(4)
      integer :: k, used
      k = place_at(work)
      self%state%t = t
      self%state%q = q
      self%state%p = p
      self%first_time = t
      self%steps = 0.0_wp
      self%dt = dt
      if (continues(work, t, q, p)) then
         if (dt == work(k + AT_DT)) then
            self%first_time = work(k + AT_FIRST_TIME)
            self%steps = work(k + AT_STEPS)
         end if
         self%state%q_compensation = work(k + AT_Q_COMPENSATION:k + AT_Q_COMPENSATION + 3)
         self%state%p_compensation = work(k + AT_P_COMPENSATION:k + AT_P_COMPENSATION + 3)
         call get_memory(work, self%stepper)
      else
         self%state%q_compensation = 0.0_wp
         self%state%p_compensation = 0.0_wp
         used = 0
         call self%stepper%take_memory(size(self%fresh), self%fresh, used)
      end if
   end subroutine recall

   !> Puts a new body into a cache: in a free place near its own, or, if the cache is full, in place of another body. If
   !> all of these are busy, the body stays outside of the cache.
   recursive subroutine put(cache, body)
      type(cache_t), intent(inout) :: cache
      type(f77_body_t), pointer, intent(in) :: body
      integer :: i, place, idle, room
      logical :: is_full
      room = size(cache%places)
      is_full = room >= most_room
      idle = -1
      do i = most_places - 1, 0, -1
         place = iand(home(body%hash, room) + i, room - 1)
         if (.not. associated(cache%places(place)%body)) then
            idle = place
         else if (is_full .and. idle < 0) then
            if (.not. cache%places(place)%body%is_busy) idle = place
         end if
      end do
      if (idle >= 0) then
         if (associated(cache%places(idle)%body)) deallocate (cache%places(idle)%body)
         cache%places(idle)%body => body
      else if (is_full) then
         body%is_alone = .true.
      else
         call grow(cache)
         call put(cache, body)
      end if
   end subroutine put

   !> Makes a cache twice as large.
   recursive subroutine grow(cache)
      type(cache_t), intent(inout) :: cache
      type(slot_t), allocatable :: old(:)
      integer :: i
      call move_alloc(cache%places, old)
      allocate (cache%places(0:2*size(old) - 1))
      do i = lbound(old, 1), ubound(old, 1)
         if (associated(old(i)%body)) call put(cache, old(i)%body)
      end do
   end subroutine grow

   !> Frees the cache of a thread that ends.
   subroutine free_cache(address) bind(C, name='nutate_f77_free_cache')
      type(c_ptr), intent(in), value :: address
      type(cache_t), pointer :: cache
      integer :: i
      call c_f_pointer(address, cache)
      do i = lbound(cache%places, 1), ubound(cache%places, 1)
         if (associated(cache%places(i)%body)) deallocate (cache%places(i)%body)
      end do
      deallocate (cache)
   end subroutine free_cache

   !> Makes the body of a work array.
   function new_body(work) result(body)
      real(wp), intent(in), target :: work(*)
      type(f77_body_t), pointer :: body
      type(status_t) :: status
      type(f77_call_t), pointer :: now
      integer, pointer :: failed
      integer :: used
      allocate (body)
      call get_setup(work, body%setup)
      body%numbers = setup_of(work)
      body%hash = work(5)
      body%mark = new_mark()
      body%system%body = body%setup%body
      failed => body%failed
      now => body%now
      call build_effects(body%setup, now, failed, body%system%effects)
      call make_stepper(body%system, settings_of(body%setup), body%stepper, status)
      allocate (body%fresh(count_memory(work)))
      used = 0
      call body%stepper%put_memory(size(body%fresh), body%fresh, used)
   end function new_body

   !> Builds the effects of a set-up: gravity, POT, damping, TOR, in this order, without those that are zero.
   subroutine build_effects(setup, now, failed, effects)
      type(setup_t), intent(in) :: setup
      !> Callbacks of the present call.
      type(f77_call_t), pointer, intent(in) :: now
      !> Flag, set to 1 when a callback returns a number that is not finite or exceeds 1e100.
      integer, pointer, intent(in) :: failed
      type(effect_list_t), intent(inout) :: effects
      type(gravity_t) :: gravity
      type(damping_t) :: damping
      type(f77_potential_t) :: potential
      type(f77_torque_t) :: torque
      effects%rotor_momentum = setup%rotor
      if (any(abs(setup%frame_rate) > 0.0_wp)) call effects%add(rotating_frame_t(rate=setup%frame_rate))
      if (any(setup%gravity /= 0.0_wp) .and. any(setup%moment /= 0.0_wp)) then
         gravity%direction = setup%gravity
         gravity%moment = setup%moment
         call effects%add(gravity)
      end if
      if (mod(setup%callbacks, 2) == 1) then
         potential%direction = setup%direction
         potential%now => now
         potential%failure%noted => failed
         potential%given = setup%potential_bounds
         call effects%add(potential)
      end if
      if (any(setup%damping /= 0.0_wp)) then
         damping%coefficient = setup%damping
         call effects%add(damping)
      end if
      if (setup%callbacks < 2) return
      torque%now => now
      torque%failure%noted => failed
      torque%given = setup%torque_bounds
      call effects%add(torque)
   end subroutine build_effects

   !> Clears the failure of a step.
   subroutine start_again(self)
      class(f77_body_t), intent(inout) :: self
      self%status = status_t()
      self%failed = 0
   end subroutine start_again

   !> Sets POT of a call.
   subroutine set_potential(self, pot, iuser, ruser)
      class(f77_body_t), intent(inout) :: self
      procedure(f77_potential) :: pot
      !> User data, passed to POT.
      integer, intent(in), target :: iuser(*)
      real(wp), intent(in), target :: ruser(*)
      self%now%pot => pot
      self%now%iuser => iuser(1:1)
      self%now%ruser => ruser(1:1)
   end subroutine set_potential

   !> Sets TOR of a call.
   subroutine set_torque(self, tor, iuser, ruser)
      class(f77_body_t), intent(inout) :: self
      procedure(f77_torque) :: tor
      !> User data, passed to TOR.
      integer, intent(in), target :: iuser(*)
      real(wp), intent(in), target :: ruser(*)
      self%now%tor => tor
      self%now%iuser => iuser(1:1)
      self%now%ruser => ruser(1:1)
   end subroutine set_torque

end module nutate_f77_prepared
