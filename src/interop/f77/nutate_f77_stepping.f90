!> Steps for FORTRAN 77: the work of NUINIT, NUSTEP and NURUN after the tests of their arguments.
module nutate_f77_stepping
   use nutate_body, only: diagonal, make_body
   use nutate_f77_prepared, only: f77_body_t
   use nutate_f77_work, only: AT_ALL_STEPS, AT_BEGUN, AT_CALL, AT_DT, AT_FIRST_TIME, AT_ITERATIONS, AT_MARK, AT_P, &
      AT_P_COMPENSATION, AT_Q, AT_Q_COMPENSATION, AT_STEPS, AT_SUBDIVIDED, AT_T, AT_UNCERTIFIED, AT_WORK, &
      AT_WORK_COMPENSATION, count_work, fill_work, place_at, put_memory, settings_of, setup_t
   use nutate_hamiltonian, only: angular_velocity, body_momentum, kinetic_energy, potential_energy, space_momentum, &
      system_t, total_energy
   use nutate_kinds, only: wp, long
   use nutate_limits, only: greatest_number, in_words
   use nutate_methods, only: make_stepper, stepper_t
   use nutate_quaternion, only: quat_norm
   use nutate_run, only: integrate, observer_t, run_record_t, run_summary_t
   use nutate_run_plan, only: step_margin, run_plan_t
   use nutate_state, only: state_t, add_increment
   use nutate_status, only: status_t, fail, NUTATE_NOT_FINITE
   implicit none
   private

   public :: request_t, needed_size, start_work, go_on, take_steps, find_invariants

   !> Largest number of effects that do work: damping and TOR.
   integer, parameter :: most_works = 2

   !> Writes rows into an array of the program, or none.
   type, extends(observer_t) :: row_store_t
      !> Rows of t, q, Ω, l, H; shape (12, number of rows).
      real(wp), pointer, contiguous :: rows(:, :) => null()
      !> Number of rows written.
      integer :: n = 0
      !> Flag, 1 if a callback has returned a number that is not finite or exceeds 1e100.
      integer, pointer :: failed => null()
   contains
      procedure :: observe => store_row
      procedure :: poll => stop_on_failure
   end type row_store_t

   !> Steps that a call of NUSTEP or NURUN requests.
   type :: request_t
      !> Number of steps, and of steps between two rows.
      integer :: n = 0, every = 1
      !> Step, s.
      real(wp) :: dt = 0.0_wp
      !> Time, s; attitude and conjugate momentum, shape (4): updated by the steps.
      real(wp) :: t = 0.0_wp, q(4) = 0.0_wp, p(4) = 0.0_wp
      type(row_store_t) :: store = row_store_t()
   end type request_t

contains

   !> Returns the count of numbers that WORK must hold.
   integer function needed_size(setup) result(n)
      !> Set-up, of which solver and order determine the size: it is the same for any body.
      type(setup_t), intent(in) :: setup
      class(stepper_t), allocatable :: stepper
      type(system_t) :: system
      type(status_t) :: status
      call make_body(diagonal([1.0_wp, 1.0_wp, 1.0_wp]), system%body, status)
      call make_stepper(system, settings_of(setup), stepper, status)
      n = count_work(stepper)
   end function needed_size

   !> Makes WORK ready for the first step.
   subroutine start_work(setup, work)
      type(setup_t), intent(inout) :: setup
      !> Work array; shape (`needed_size` of the set-up).
      real(wp), intent(inout), target, contiguous :: work(:)
      class(stepper_t), allocatable :: stepper
      type(system_t) :: system
      type(status_t) :: status
      system%body = setup%body
      call make_stepper(system, settings_of(setup), stepper, status)
      call fill_work(setup, stepper, work)
   end subroutine start_work

   !> Performs steps as `integrate` does, if each succeeds at the first attempt, without the overhead of a run, which
   !> costs more than a step. If a step fails, WORK is unchanged.
   subroutine go_on(n, body, work, done)
      integer, intent(in) :: n
      !> Body of `work`, with the state and the callbacks of this call.
      type(f77_body_t), intent(inout) :: body
      real(wp), intent(inout), target :: work(*)
      !> False if a step has failed.
      logical, intent(out) :: done
      real(wp) :: end_time, dt, t, length, sums(most_works), compensation(most_works)
      integer :: i, k, n_works, iterations, uncertified
      done = .false.
      body%call = body%call + 1
      n_works = size(body%stepper%work)
      do k = 1, n_works
         sums(k) = 0.0_wp
         compensation(k) = 0.0_wp
      end do
      iterations = 0
      uncertified = 0
      dt = body%dt
      end_time = body%first_time + (body%steps + n)*dt
      associate (state => body%state, stepper => body%stepper)
         do i = 1, n
            t = body%first_time + (body%steps + i)*dt
            length = t - state%t
            if (abs(length - dt) <= step_margin(state%t, end_time, dt)) length = dt
            if (.not. abs(length) > 0.0_wp) return
            call stepper%advance(body%system, state, length, state%t + 0.5_wp*length, body%status)
            if (body%status%code /= 0 .or. body%failed /= 0) return
            state%t = t
            iterations = iterations + stepper%iterations
            if (stepper%uncertified > 0) uncertified = uncertified + 1
            do k = 1, n_works
               call add_increment(sums(k), compensation(k), stepper%work(k))
            end do
         end do
      end associate
      body%steps = body%steps + n
      k = place_at(work)
      do i = 1, n_works
         call add_increment(work(k + AT_WORK), work(k + AT_WORK_COMPENSATION), sums(i))
      end do
      work(k + AT_ALL_STEPS) = work(k + AT_ALL_STEPS) + n
      work(k + AT_ITERATIONS) = work(k + AT_ITERATIONS) + iterations
      if (uncertified > 0) work(k + AT_UNCERTIFIED) = work(k + AT_UNCERTIFIED) + uncertified
      call store(body, work)
      done = .true.
   end subroutine go_on

   !> Stores in WORK the state at the end of a call, but not the sums over its steps, such as their work.
   subroutine store(body, work)
      type(f77_body_t), intent(inout) :: body
      real(wp), intent(inout), target :: work(*)
      integer :: k
      k = place_at(work)
      work(k + AT_BEGUN) = 1.0_wp
      work(k + AT_STEPS) = body%steps
      work(k + AT_DT) = body%dt
      work(k + AT_FIRST_TIME) = body%first_time
      associate (state => body%state)
         work(k + AT_T) = state%t
         work(k + AT_Q:k + AT_Q + 3) = state%q
         work(k + AT_P:k + AT_P + 3) = state%p
         work(k + AT_Q_COMPENSATION:k + AT_Q_COMPENSATION + 3) = state%q_compensation
         work(k + AT_P_COMPENSATION:k + AT_P_COMPENSATION + 3) = state%p_compensation
      end associate
      work(k + AT_MARK) = body%mark
      work(k + AT_CALL) = body%call
      call put_memory(body%stepper, work)
   end subroutine store

   !> Performs steps as a run, with rows, and subdivides those that fail. Errors, `info` > 0, with WORK unchanged: a
   !> code of `nutate_status`.
   subroutine take_steps(request, body, work, info)
      type(request_t), intent(inout) :: request
      !> Body of `work`, with the callbacks of this call.
      type(f77_body_t), intent(inout), target :: body
      real(wp), intent(inout), target :: work(*)
      integer, intent(out) :: info
      type(run_plan_t) :: plan
      type(run_summary_t) :: summary
      type(status_t) :: status
      integer :: i, k
      call body%start_again()
      body%call = body%call + 1
      call body%recall(work, request%dt, request%t, request%q, request%p)
      plan = run_plan_t(time_step=body%dt, end_time=body%first_time + (body%steps + request%n)*body%dt, &
                        every=int(request%every, long), steps_before=int(body%steps, long), &
                        first_time=body%first_time, steps=int(request%n, long))
      request%store%failed => body%failed
      call integrate(body%system, body%stepper, body%state, plan, status, request%store, summary)
      info = status%code
      if (body%failed /= 0) info = NUTATE_NOT_FINITE
      if (info /= 0) return
      body%steps = body%steps + request%n
      k = place_at(work)
      work(k + AT_ALL_STEPS) = work(k + AT_ALL_STEPS) + request%n
      work(k + AT_ITERATIONS) = work(k + AT_ITERATIONS) + real(summary%iterations, wp)
      work(k + AT_SUBDIVIDED) = work(k + AT_SUBDIVIDED) + real(summary%subdivided_steps, wp)
      work(k + AT_UNCERTIFIED) = work(k + AT_UNCERTIFIED) + real(summary%uncertified_steps, wp)
      do i = 1, size(summary%work)
         call add_increment(work(k + AT_WORK), work(k + AT_WORK_COMPENSATION), summary%work(i))
      end do
      call store(body, work)
      request%t = body%state%t
      request%q = body%state%q
      request%p = body%state%p
   end subroutine take_steps

   !> Computes the results of NUINV. Error, `info` > 0, with the results unchanged: `NUTATE_NOT_FINITE`.
   subroutine find_invariants(body, state, energy, momentum, constraints, info)
      !> Body with POT of this call.
      type(f77_body_t), intent(inout), target :: body
      type(state_t), intent(in) :: state
      !> T, V, H, J; L in body and in space axes, N m s; |q| and q·p.
      real(wp), intent(inout) :: energy(3), momentum(3, 2), constraints(2)
      integer, intent(out) :: info
      ! Volatile: the compiler does not expect a pure procedure to change `failed`, and could call it afterwards.
      real(wp), volatile :: potential
      integer, pointer, volatile :: failed
      failed => body%failed
      potential = potential_energy(body%system%effects, state%q)
      info = merge(NUTATE_NOT_FINITE, 0, failed /= 0)
      if (info /= 0) return
      energy(1) = kinetic_energy(body%system, state, body%setup%inverse_j0)
      energy(2) = potential
      energy(3) = energy(1) + potential
      momentum(:, 1) = body_momentum(state)
      momentum(:, 2) = space_momentum(state)
      constraints = [quat_norm(state%q), dot_product(state%q, state%p)]
   end subroutine find_invariants

   subroutine store_row(self, system, state, record, status)
      class(row_store_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      if (.not. associated(self%rows)) return
      self%n = self%n + 1
      associate (row => self%rows(:, self%n))
         row(1) = state%t
         row(2:5) = state%q
         row(6:8) = angular_velocity(system, state)
         row(9:11) = space_momentum(state)
         row(12) = total_energy(system, state)
      end associate
   end subroutine store_row

   !> Ends a run in which a callback has failed.
   subroutine stop_on_failure(self, fraction, status)
      class(row_store_t), intent(inout) :: self
      real(wp), intent(in) :: fraction
      type(status_t), intent(out) :: status
      if (self%failed /= 0) &
         status = fail(NUTATE_NOT_FINITE, 'POT or TOR returned a number that is not finite or exceeds '// &
                       in_words(greatest_number))
   end subroutine stop_on_failure

end module nutate_f77_stepping
