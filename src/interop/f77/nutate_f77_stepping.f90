!> Steps for FORTRAN 77: what NUINIT, NUSTEP and NURUN do once their arguments have been tested.
module nutate_f77_stepping
   use nutate_body, only: diagonal, make_body
   use nutate_damping, only: damping_t
   use nutate_effect_list, only: effect_list_t
   use nutate_f77_callback, only: f77_potential, f77_potential_t, f77_torque, f77_torque_t
   use nutate_f77_work, only: count_work, fill_work, get_memory, get_place, get_setup, place_t, put_memory, put_place, &
      setup_t
   use nutate_gravity, only: gravity_t
   use nutate_hamiltonian, only: angular_velocity, body_momentum, kinetic_energy, potential_energy, space_momentum, &
      total_energy
   use nutate_kinds, only: wp, long
   use nutate_limits, only: greatest_number, in_words
   use nutate_methods, only: make_stepper
   use nutate_nielsen_krenk, only: nielsen_krenk_t
   use nutate_observer, only: observer_t, run_record_t
   use nutate_progress, only: run_summary_t
   use nutate_quaternion, only: quat_norm
   use nutate_reduced, only: reduced_t
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_run, only: integrate
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t, add_increment
   use nutate_status, only: status_t, fail, NUTATE_NOT_FINITE
   use nutate_stepper, only: integrator_settings_t, stepper_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: request_t, f77_invariants_t, needed_size, start_work, take_steps, find_invariants

   !> Writes rows into an array of the program, or none.
   type, extends(observer_t) :: row_store_t
      !> t, q, Ω, l, H; shape (12, number of rows).
      real(wp), pointer, contiguous :: rows(:, :) => null()
      !> Rows written.
      integer :: n = 0
      !> 1: a callback has returned a number that is not finite or exceeds 1e100.
      integer :: failed = 0
   contains
      procedure :: observe => store_row
      procedure :: poll => stop_on_failure
   end type row_store_t

   !> What a call of NUSTEP or NURUN asks for.
   type :: request_t
      !> Steps to take, and steps between two rows.
      integer :: n = 0, every = 1
      !> Step, s.
      real(wp) :: dt = 0.0_wp
      !> Time, s; attitude and conjugate momentum, shape (4): moved by the steps.
      real(wp) :: t = 0.0_wp, q(4) = 0.0_wp, p(4) = 0.0_wp
      type(row_store_t) :: store = row_store_t()
   end type request_t

   !> What NUINV computes.
   type :: f77_invariants_t
      !> T, V, H, J; shape (3).
      real(wp) :: energy(3) = 0.0_wp
      !> L in body and in space axes, N m s; shape (3, 2).
      real(wp) :: momentum(3, 2) = 0.0_wp
      !> |q|, q·p; shape (2).
      real(wp) :: constraints(2) = 0.0_wp
   end type f77_invariants_t

contains

   !> The effects that a set-up asks for: gravity, POT, damping, TOR, in this order; absent what is zero.
   subroutine build_effects(setup, pot, tor, iuser, ruser, failed, effects)
      type(setup_t), intent(in) :: setup
      procedure(f77_potential) :: pot
      procedure(f77_torque) :: tor
      !> The program's own, for the callbacks.
      integer, intent(in), target :: iuser(*)
      real(wp), intent(in), target :: ruser(*)
      !> Set to 1 when a callback returns a number that is not finite or exceeds 1e100.
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
         potential%ask => pot
         potential%iuser => iuser(1:1)
         potential%ruser => ruser(1:1)
         potential%failure%noted => failed
         potential%given = setup%potential_bounds
         call effects%add(potential)
      end if
      if (any(setup%damping /= 0.0_wp)) then
         damping%coefficient = setup%damping
         call effects%add(damping)
      end if
      if (setup%callbacks < 2) return
      torque%ask => tor
      torque%iuser => iuser(1:1)
      torque%ruser => ruser(1:1)
      torque%failure%noted => failed
      torque%given = setup%torque_bounds
      call effects%add(torque)
   end subroutine build_effects

   !> Numbers that WORK must hold.
   integer function needed_size(setup) result(n)
      !> Solver and order count: the size is that for any body.
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
      !> Shape (as `needed_size` says).
      real(wp), intent(inout), target, contiguous :: work(:)
      class(stepper_t), allocatable :: stepper
      type(system_t) :: system
      type(status_t) :: status
      system%body = setup%body
      call make_stepper(system, settings_of(setup), stepper, status)
      call fill_work(setup, stepper, work)
   end subroutine start_work

   !> The settings of a stepper.
   pure type(integrator_settings_t) function settings_of(setup) result(settings)
      type(setup_t), intent(in) :: setup
      settings%order = setup%order
      settings%formulation = merge('reduced', 'full   ', setup%solver == 1)
      settings%inverse_auxiliary_inertia = setup%inverse_j0
   end function settings_of

   !> Performs steps. Errors, `info` > 0, with state and WORK as they were: a code of `nutate_status`.
   subroutine take_steps(request, pot, tor, iuser, ruser, work, info)
      type(request_t), intent(inout), target :: request
      procedure(f77_potential) :: pot
      procedure(f77_torque) :: tor
      !> The program's own, for the callbacks.
      integer, intent(in), target :: iuser(*)
      real(wp), intent(in), target :: ruser(*)
      real(wp), intent(inout), target, contiguous :: work(:)
      integer, intent(out) :: info
      type(setup_t) :: setup
      type(system_t) :: system

      call get_setup(work, setup)
      system%body = setup%body
      call build_effects(setup, pot, tor, iuser, ruser, request%store%failed, system%effects)
      if (setup%order > 2) then
         call with_composition(request, setup, system, work, info)
      else if (setup%solver == 1) then
         call with_reduced(request, setup, system, work, info)
      else
         call with_eight(request, setup, system, work, info)
      end if
   end subroutine take_steps

   !> `advance` with the reduced form, which then needs no room but the stack's: a single step notices.
   subroutine with_reduced(request, setup, system, work, info)
      type(request_t), intent(inout) :: request
      type(setup_t), intent(in) :: setup
      type(system_t), intent(in) :: system
      real(wp), intent(inout), target, contiguous :: work(:)
      integer, intent(out) :: info
      type(reduced_t) :: stepper
      call advance(request, setup, system, stepper, work, info)
   end subroutine with_reduced

   !> `advance` with the eight equations.
   subroutine with_eight(request, setup, system, work, info)
      type(request_t), intent(inout) :: request
      type(setup_t), intent(in) :: setup
      type(system_t), intent(in) :: system
      real(wp), intent(inout), target, contiguous :: work(:)
      integer, intent(out) :: info
      type(nielsen_krenk_t) :: stepper
      call advance(request, setup, system, stepper, work, info)
   end subroutine with_eight

   !> `advance` with a composition of either.
   subroutine with_composition(request, setup, system, work, info)
      type(request_t), intent(inout) :: request
      type(setup_t), intent(in) :: setup
      type(system_t), intent(in) :: system
      real(wp), intent(inout), target, contiguous :: work(:)
      integer, intent(out) :: info
      class(stepper_t), allocatable :: stepper
      type(status_t) :: status
      call make_stepper(system, settings_of(setup), stepper, status)
      call advance(request, setup, system, stepper, work, info)
   end subroutine with_composition

   !> Performs steps with a stepper that is not prepared yet. Errors as for `take_steps`.
   subroutine advance(request, setup, system, stepper, work, info)
      type(request_t), intent(inout) :: request
      type(setup_t), intent(in) :: setup
      type(system_t), intent(in) :: system
      class(stepper_t), intent(inout) :: stepper
      real(wp), intent(inout), target, contiguous :: work(:)
      integer, intent(out) :: info
      type(place_t) :: place
      type(run_plan_t) :: plan
      type(run_summary_t) :: summary
      type(status_t) :: status

      call get_place(work, place)
      call stepper%prepare(system, settings_of(setup), status)
      if (place%continues_at(request%t, request%q, request%p)) then
         call get_memory(work, stepper)
         if (request%dt /= place%dt) place%steps = 0
      else
         place%steps = 0
         place%state = state_t(t=request%t, q=request%q, p=request%p)
      end if
      if (place%steps == 0) place%first_time = request%t
      place%dt = request%dt
      plan = run_plan_t(time_step=place%dt, end_time=place%first_time + real(place%steps + request%n, wp)*place%dt, &
                        every=int(request%every, long), steps_before=place%steps, first_time=place%first_time, &
                        steps=int(request%n, long))
      call integrate(system, stepper, place%state, plan, status, request%store, summary)
      info = status%code
      if (request%store%failed /= 0) info = NUTATE_NOT_FINITE
      if (info /= 0) return
      request%t = place%state%t
      request%q = place%state%q
      request%p = place%state%p
      call account(place, summary)
      call put_place(place, work)
      call put_memory(stepper, work)
   end subroutine advance

   !> Adds what a run took to what is known of the runs before.
   pure subroutine account(place, summary)
      type(place_t), intent(inout) :: place
      type(run_summary_t), intent(in) :: summary
      integer :: i
      place%begun = .true.
      place%steps = place%steps + summary%steps
      place%all_steps = place%all_steps + summary%steps
      place%iterations = place%iterations + summary%iterations
      place%subdivided_steps = place%subdivided_steps + summary%subdivided_steps
      place%uncertified_steps = place%uncertified_steps + summary%uncertified_steps
      do i = 1, size(summary%work)
         call add_increment(place%work, place%work_compensation, summary%work(i))
      end do
   end subroutine account

   !> What NUINV computes. Error, `info` > 0: `NUTATE_NOT_FINITE`.
   subroutine find_invariants(work, state, pot, iuser, ruser, found, info)
      real(wp), intent(in), target, contiguous :: work(:)
      type(state_t), intent(in) :: state
      procedure(f77_potential) :: pot
      !> The program's own, for POT.
      integer, intent(in) :: iuser(*)
      real(wp), intent(in) :: ruser(*)
      type(f77_invariants_t), intent(out) :: found
      integer, intent(out) :: info
      type(setup_t) :: setup
      type(system_t) :: system
      ! Volatile: what a pure procedure does to it goes unnoticed otherwise.
      integer, target, volatile :: failed
      failed = 0
      call get_setup(work, setup)
      setup%callbacks = mod(setup%callbacks, 2)
      system%body = setup%body
      call build_effects(setup, pot, no_torque, iuser, ruser, failed, system%effects)
      found%energy(2) = potential_energy(system%effects, state%q)
      info = merge(NUTATE_NOT_FINITE, 0, failed /= 0)
      if (info /= 0) return
      found%energy(1) = kinetic_energy(system, state, setup%inverse_j0)
      found%energy(3) = found%energy(1) + found%energy(2)
      found%momentum(:, 1) = body_momentum(state)
      found%momentum(:, 2) = space_momentum(state)
      found%constraints = [quat_norm(state%q), dot_product(state%q, state%p)]
   end subroutine find_invariants

   !> Stands for TOR where it cannot act.
   pure subroutine no_torque(t, q, omega, tau, iuser, ruser)
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp), intent(out) :: tau(3)
      integer, intent(in) :: iuser(*)
      real(wp), intent(in) :: ruser(*)
      tau = 0.0_wp
   end subroutine no_torque

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
