!> Runs of the stability cases: `integrate` of the library with an observer that measures what must hold.
module test_stability_meter
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_invariants, only: invariants_t
   use nutate_kinds, only: wp, long
   use nutate_methods, only: make_stepper
   use nutate_run, only: integrate, observer_t, run_record_t, run_summary_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: fail, NUTATE_NOT_FINITE, status_t
   use nutate_stepper, only: stepper_t, system_t
   use test_problems, only: problem_t
   use test_stability_case, only: number_text, record_t, way_t
   implicit none
   private

   public :: meter_t, follow

   !> Most doublings of the number of rows that are kept.
   integer, parameter :: most_octaves = 40

   !> Measures the invariants at every row; a case that looks at more extends it and overrides `note`.
   type, extends(observer_t) :: meter_t
      type(invariants_t) :: invariants
      !> 1/J0, kg⁻¹ m⁻².
      real(wp) :: inverse_j0 = 0.0_wp
      !> Largest relative errors of energy, momentum and norm up to row 1, 2, 4, 8, ...; shape (3, octave).
      real(wp) :: history(3, 0:most_octaves) = 0.0_wp
      integer(long) :: rows = 0
      integer :: octaves = 0
   contains
      procedure :: observe => measure_row
      !> Called with every row after it is measured.
      procedure :: note
      !> Exponents with which the errors of energy, momentum and norm grow with the number of steps.
      procedure :: growth
   end type meter_t

contains

   !> Compares a row with the first. A row that is not finite ends the run.
   subroutine measure_row(self, system, state, record, status)
      class(meter_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      if (.not. all(ieee_is_finite([state%t, state%q, state%p, record%work]))) then
         status = fail(NUTATE_NOT_FINITE, 'a state that is not finite was shown')
         return
      end if
      if (record%step == 0) then
         call self%invariants%start(system, state, self%inverse_j0)
      else
         call self%invariants%measure(system, state, record%work)
         self%rows = self%rows + 1
         if (iand(self%rows, self%rows - 1) == 0) then
            self%history(:, self%octaves) = [self%invariants%energy_error(), self%invariants%momentum_error(), &
                                             self%invariants%norm_error]
            self%octaves = self%octaves + 1
         end if
      end if
      call self%note(system, state, record)
   end subroutine measure_row

   !> Does nothing.
   subroutine note(self, system, state, record)
      class(meter_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
   end subroutine note

   !> Slope of log(largest error) against log(steps) by least squares over the last ten doublings; shape (3).
   function growth(self) result(exponents)
      class(meter_t), intent(in) :: self
      real(wp) :: exponents(3)
      real(wp) :: x, y, mean
      integer :: i, k, first
      first = max(0, self%octaves - 10)
      exponents = 0.0_wp
      if (self%octaves - first < 3) return
      mean = 0.5_wp*(first + self%octaves - 1)
      do i = 1, 3
         x = 0.0_wp
         y = 0.0_wp
         do k = first, self%octaves - 1
            x = x + (k - mean)**2
            y = y + (k - mean)*log(max(self%history(i, k), epsilon(1.0_wp)**2))/log(2.0_wp)
         end do
         exponents(i) = y/x
      end do
   end function growth

   !> Performs `n` nominal steps, subdivided where need be, and puts into the record what came of it: steps, errors, and
   !> on refusal its time and reason. A state that is not finite, or did not come to its time, fails the case.
   subroutine follow(problem, way, dt, n, record, state, meter, every, stepper)
      type(problem_t), intent(in) :: problem
      type(way_t), intent(in) :: way
      !> s.
      real(wp), intent(in) :: dt
      integer(long), intent(in) :: n
      !> Adds to what it holds.
      type(record_t), intent(inout) :: record
      !> The last state reached.
      type(state_t), intent(out), optional :: state
      !> Default: one that measures the invariants.
      class(meter_t), intent(inout), optional :: meter
      !> Steps between rows; default 1.
      integer(long), intent(in), optional :: every
      !> Performs the steps; prepared here. Default: the method that the way means.
      class(stepper_t), intent(inout), optional :: stepper
      class(stepper_t), allocatable :: method
      type(status_t) :: status
      type(meter_t) :: plain
      type(run_plan_t) :: plan
      plan%time_step = dt
      plan%end_time = problem%start%t + real(n, wp)*dt
      if (present(every)) plan%every = every
      plain%inverse_j0 = way%inverse_j0(problem%system)
      if (present(meter)) meter%inverse_j0 = plain%inverse_j0
      if (present(stepper)) then
         call stepper%prepare(problem%system, way%settings(problem%system), status)
      else
         call make_stepper(problem%system, way%settings(problem%system), method, status)
      end if
      call record%require(status%ok(), trim(status%message))
      if (.not. status%ok()) return
      if (present(stepper) .and. present(meter)) then
         call run_metered(problem, stepper, plan, meter, record, state)
      else if (present(stepper)) then
         call run_metered(problem, stepper, plan, plain, record, state)
      else if (present(meter)) then
         call run_metered(problem, method, plan, meter, record, state)
      else
         call run_metered(problem, method, plan, plain, record, state)
      end if
   end subroutine follow

   !> Runs a plan and accounts for it.
   subroutine run_metered(problem, stepper, plan, meter, record, last)
      type(problem_t), intent(in) :: problem
      class(stepper_t), intent(inout) :: stepper
      type(run_plan_t), intent(in) :: plan
      class(meter_t), intent(inout) :: meter
      type(record_t), intent(inout) :: record
      type(state_t), intent(out), optional :: last
      type(run_summary_t) :: summary
      type(status_t) :: status
      type(record_t) :: part
      type(state_t) :: state
      state = problem%start
      call integrate(problem%system, stepper, state, plan, status, meter, summary)
      part%steps = summary%steps
      part%subdivided_steps = summary%subdivided_steps
      part%energy = meter%invariants%energy_error()
      part%momentum = meter%invariants%momentum_error()
      part%norm = meter%invariants%norm_error
      part%refused = .not. status%ok()
      part%code = status%code
      if (part%refused) part%outcome = 'refused at t = '//number_text(state%t)//' s: '//trim(status%message)
      call part%require(status%code /= NUTATE_NOT_FINITE, trim(status%message))
      call part%require(part%refused .or. abs(state%t - plan%end_time) <= 0.0_wp, 'the run did not come to its end')
      call record%absorb(part)
      if (present(last)) last = state
   end subroutine run_metered

end module test_stability_meter
