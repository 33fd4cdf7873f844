!> The attack on the true root: cases are stepped with both forms of the equations, stage by stage, and every stage is
!> assessed by the oracle.
!>
!> A stage is accepted or rejected by the library, and right or wrong by the oracle. The counts are in `tally_t`, for
!> each solver and each kind of stage.
module test_attack_run
   use, intrinsic :: iso_fortran_env, only: error_unit
   use nutate_composition, only: compositions
   use nutate_kinds, only: wp
   use nutate_methods, only: integrator_settings_t, make_stepper, stepper_t
   use nutate_quaternion, only: quat_conjugate, quat_product
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_attack_case, only: attack_case_t, draw_case, make_system
   use test_attack_oracle, only: branch_t, oracle_t, REACHED, ENDED, LOST
   use test_problems, only: angular_velocity, make_state, new_system, system_t
   implicit none
   private

   public :: attack_case, attack_cases, assess, tally_t, counts_t, outcome_t, kinds, solvers, verdict_text

   !> Kinds of stages by Δt|Ω| at the start of the stage and by the size of the effects' torques.
   character(len=32), parameter :: kinds(6) = [character(len=32) :: &
      'to 0.5, torques to JΩ²', 'to 0.5, stronger torques', '0.5 to 1', '1 to 2', '2 to 4', 'above 4']
   real(wp), parameter :: upper(5) = [0.5_wp, 0.5_wp, 1.0_wp, 2.0_wp, 4.0_wp]
   character(len=8), parameter :: solvers(2) = ['full    ', 'reduced ']
   integer, parameter :: most_stages = 17
   !> Distance of b from the oracle's that is none: both are good to 1e-9 but next to the end of a branch.
   real(wp), parameter :: same_root = 1e-6_wp
   !> |b| from which the library refuses what may exist.
   real(wp), parameter :: longest = 0.98_wp
   !> Least 1/‖P_b⁻¹‖ on the way of a branch that is followed once only.
   real(wp), parameter :: plain = 0.2_wp

   !> Counts of the stages of one kind with one solver.
   type :: counts_t
      integer :: stages = 0
      !> Accepted stages: directly, by continuation; of both, not certified.
      integer :: at_once = 0, continued = 0, uncertified = 0
      !> Stages accepted although the branch leads to another root or ends: certified, not certified.
      integer :: wrong = 0, wrong_uncertified = 0
      !> Stages rejected although the branch exists; rejected because it ends.
      integer :: too_careful = 0, refused = 0
      !> Stages that the oracle cannot decide.
      integer :: unclear = 0
   end type counts_t

   !> Results of a randomised stress test.
   type :: tally_t
      !> Counts; shape (kinds, solvers).
      type(counts_t) :: counts(size(kinds), size(solvers))
      !> Stages followed by the oracle, once for both solvers.
      integer :: stages = 0, cases = 0
      !> Stages that one solver accepts and the other refuses, or that they end elsewhere: where all that is accepted is
      !> certified, and others; composed steps that are not their stages; cases that the library could not set up.
      integer :: disagreements = 0, uncertified_disagreements = 0, composed = 0, broken = 0
      !> First failure, and how to see it again; blank where there is none.
      character(len=200) :: first = ''
      !> Each failure is written to standard error; each stage too.
      logical :: loud = .false., traced = .false.
      !> The case that is run: what repeats it; its step and stage.
      character(len=64), private :: command = ''
      integer, private :: step = 0, stage = 0
   contains
      procedure :: total
      procedure, private :: note
   end type tally_t

   !> Result of a solver for a stage.
   type :: outcome_t
      logical :: accepted = .false.
      !> b of the stage taken; shape (3).
      real(wp) :: b(3) = 0.0_wp
      !> Lengths tried by continuation; 1 where the root is not certified.
      integer :: continued = 0, uncertified = 0
   end type outcome_t

   !> One way to step a case: the order-2 steppers of the stages, and the whole method beside them.
   type :: stage_stepper_t
      class(stepper_t), allocatable :: item
   end type stage_stepper_t
   type :: walker_t
      type(stage_stepper_t) :: stages(most_stages)
      class(stepper_t), allocatable :: whole
      !> State at the last end of a stage; state at the last end of a step.
      type(state_t) :: state, step_end
      logical :: accepted = .true.
      !> The walk goes on; not where one of the solvers refuses or both differ.
      logical :: goes_on = .true.
      !> b of the stage last taken.
      real(wp) :: b(3) = 0.0_wp
   end type walker_t

contains

   !> Sums over all kinds and solvers.
   pure type(counts_t) function total(self)
      class(tally_t), intent(in) :: self
      associate (c => self%counts)
         total = counts_t(sum(c%stages), sum(c%at_once), sum(c%continued), sum(c%uncertified), sum(c%wrong), &
                          sum(c%wrong_uncertified), sum(c%too_careful), sum(c%refused), sum(c%unclear))
      end associate
   end function total

   !> Draws and runs cases until enough stages were seen.
   subroutine attack_cases(seed, first, stages, tally, stride)
      integer, intent(in) :: seed
      !> Number of the first case; stages to see at least.
      integer, intent(in) :: first, stages
      type(tally_t), intent(inout) :: tally
      !> Every so manieth case; default 1.
      integer, intent(in), optional :: stride
      type(attack_case_t) :: item
      character(len=48) :: command
      integer :: number, increment
      number = first
      increment = 1
      if (present(stride)) increment = stride
      do while (tally%stages < stages)
         call draw_case(seed, number, item, .true.)
         write (command, '("bash tools/tests/attack.sh --seed ",i0," --case ",i0)') seed, number
         call attack_case(item, command, tally)
         number = number + increment
      end do
   end subroutine attack_cases

   !> Steps a case with both solvers until one of them refuses, and assesses every stage.
   subroutine attack_case(item, command, tally)
      type(attack_case_t), intent(in) :: item
      !> Repeats the case.
      character(len=*), intent(in) :: command
      type(tally_t), intent(inout) :: tally
      type(system_t), pointer :: system
      type(walker_t) :: walkers(size(solvers))
      real(wp) :: weights(most_stages)
      integer :: n, step, stage
      logical :: ok
      system => new_system()
      tally%cases = tally%cases + 1
      tally%command = command
      tally%step = 0
      tally%stage = 0
      call find_weights(item%order, weights, n)
      call set_up(item, n, system, walkers, ok)
      if (.not. ok) then
         tally%broken = tally%broken + 1
         call tally%note('cannot be set up')
         return
      end if
      do step = 1, item%steps
         do stage = 1, n
            tally%step = step
            tally%stage = stage
            call run_stage(item, system, walkers, stage, weights(stage)*item%dt, tally)
            if (.not. all(walkers%goes_on)) exit
         end do
         call compare_whole(item, system, walkers, n, tally)
         if (.not. all(walkers%goes_on)) return
      end do
   end subroutine attack_case

   !> Keeps the first failure, and says each, as well as what is no failure.
   subroutine note(self, what, fails)
      class(tally_t), intent(inout) :: self
      character(len=*), intent(in) :: what
      !> Default: true.
      logical, intent(in), optional :: fails
      logical :: kept
      kept = .true.
      if (present(fails)) kept = fails
      if (kept .and. len_trim(self%first) == 0) self%first = what//': '//self%command
      if (self%loud) &
         write (error_unit, '(a,": ",a," (step ",i0,", stage ",i0,")")') what, trim(self%command), self%step, self%stage
   end subroutine note

   !> Weights of the stages of an order.
   pure subroutine find_weights(order, weights, n)
      integer, intent(in) :: order
      real(wp), intent(out) :: weights(most_stages)
      integer, intent(out) :: n
      integer :: i, k
      weights = 1.0_wp
      n = 1
      do k = 1, size(compositions)
         if (compositions(k)%order /= order) cycle
         n = compositions(k)%stages
         do i = 1, n
            weights(i) = compositions(k)%weights(min(i, n + 1 - i))
         end do
      end do
   end subroutine find_weights

   subroutine set_up(item, n, system, walkers, ok)
      type(attack_case_t), intent(in) :: item
      !> Stages.
      integer, intent(in) :: n
      type(system_t), intent(out) :: system
      type(walker_t), intent(inout) :: walkers(:)
      logical, intent(out) :: ok
      type(integrator_settings_t) :: settings
      type(status_t) :: status
      integer :: i, k
      ok = .false.
      call make_system(item, system, status)
      if (.not. status%ok()) return
      do k = 1, size(solvers)
         settings%formulation = solvers(k)
         settings%inverse_auxiliary_inertia = item%inverse_j0
         settings%order = item%order
         call make_stepper(system, settings, walkers(k)%whole, status)
         if (.not. status%ok()) return
         settings%order = 2
         do i = 1, n
            call make_stepper(system, settings, walkers(k)%stages(i)%item, status)
            if (.not. status%ok()) return
         end do
         walkers(k)%state = make_state(system, item%q, item%omega, item%t)
         walkers(k)%step_end = walkers(k)%state
      end do
      ok = .true.
   end subroutine set_up

   !> One stage with both solvers, from the states where each of them is.
   subroutine run_stage(item, system, walkers, stage, length, tally)
      type(attack_case_t), intent(in) :: item
      type(system_t), intent(in) :: system
      type(walker_t), intent(inout) :: walkers(:)
      integer, intent(in) :: stage
      !> s
      real(wp), intent(in) :: length
      type(tally_t), intent(inout) :: tally
      type(oracle_t) :: oracle
      type(branch_t) :: branch
      type(state_t) :: before
      type(status_t) :: status
      real(wp) :: window_time, turn, omega(3)
      integer :: k, kind
      before = walkers(2)%state
      window_time = walkers(2)%step_end%t + 0.5_wp*item%dt
      omega = angular_velocity(system, before)
      call oracle%begin(item, before%q, omega, before%t, length, window_time, before%wheel_momentum)
      call oracle%follow(1.0_wp, branch)
      if (branch%outcome /= LOST .and. branch%stiffness < plain) call follow_again(oracle, branch)
      turn = abs(length)*norm2(omega)
      kind = 1 + count(turn > upper)
      if (kind == 1 .and. oracle%strength() > 1.0_wp) kind = 2
      tally%stages = tally%stages + 1
      do k = 1, size(walkers)
         associate (walker => walkers(k))
            before = walker%state
            status = status_t()
            call walker%stages(stage)%item%advance(system, walker%state, length, window_time, status)
            walker%accepted = status%ok()
            walker%goes_on = status%ok()
            walker%b = 0.0_wp
            if (walker%accepted) walker%b = turn_between(before%q, walker%state%q)
            if (tally%traced) call trace(tally, length, branch, outcome_of(walker, stage), solvers(k), status)
            call assess(oracle, branch, outcome_of(walker, stage), solvers(k), kind, k, tally)
         end associate
      end do
      if ((walkers(1)%accepted .neqv. walkers(2)%accepted) .or. &
          .not. norm2(walkers(1)%b - walkers(2)%b) <= same_root) then
         call count_difference(walkers, stage, tally)
         walkers%goes_on = .false.
      end if
   end subroutine run_stage

   !> Counts a stage on which the solvers differ.
   subroutine count_difference(walkers, stage, tally)
      type(walker_t), intent(in) :: walkers(:)
      integer, intent(in) :: stage
      type(tally_t), intent(inout) :: tally
      character(len=:), allocatable :: what
      logical :: certified
      integer :: k
      certified = .true.
      do k = 1, size(walkers)
         if (walkers(k)%accepted) certified = certified .and. walkers(k)%stages(stage)%item%uncertified == 0
      end do
      what = 'the solvers take different roots'
      if (.not. all(walkers%accepted)) what = 'one solver refuses what the other accepts'
      if (certified) then
         tally%disagreements = tally%disagreements + 1
         call tally%note(what)
      else
         tally%uncertified_disagreements = tally%uncertified_disagreements + 1
         call tally%note(what//' without a proof', fails=.false.)
      end if
   end subroutine count_difference

   !> Writes what was made of a stage to standard error.
   subroutine trace(tally, length, branch, outcome, solver, status)
      type(tally_t), intent(in) :: tally
      !> s
      real(wp), intent(in) :: length
      type(branch_t), intent(in) :: branch
      type(outcome_t), intent(in) :: outcome
      character(len=*), intent(in) :: solver
      !> Status of the step.
      type(status_t), intent(in) :: status
      character(len=8), parameter :: words(3) = [character(len=8) :: 'reached', 'ended', 'lost']
      write (error_unit, '("step ",i0,", stage ",i0,", ",es11.4," s: branch ",a," at part ",f8.6,", b =",3f13.9)') &
         tally%step, tally%stage, length, trim(words(branch%outcome)), branch%t, branch%b
      if (outcome%accepted) then
         write (error_unit, '(3x,a," accepts b =",3f13.9,", lengths of continuation: ",i0,", not certified: ",i0)') &
            solver, outcome%b, outcome%continued, outcome%uncertified
      else
         write (error_unit, '(3x,a," refuses, lengths of continuation: ",i0,"; ",a)') solver, outcome%continued, &
            trim(status%message)
      end if
   end subroutine trace

   !> Follows a branch in increments of a third; what does not come out the same is lost.
   subroutine follow_again(oracle, branch)
      type(oracle_t), intent(in) :: oracle
      type(branch_t), intent(inout) :: branch
      type(branch_t) :: finer
      call oracle%follow(3.0_wp, finer)
      if (finer%outcome /= branch%outcome) branch%outcome = LOST
      if (branch%outcome == REACHED .and. .not. norm2(finer%b - branch%b) <= same_root) branch%outcome = LOST
      if (branch%outcome == ENDED .and. .not. abs(finer%t - branch%t) <= 1e-3_wp) branch%outcome = LOST
   end subroutine follow_again

   !> Returns the result of a solver for a stage.
   pure type(outcome_t) function outcome_of(walker, stage)
      type(walker_t), intent(in) :: walker
      integer, intent(in) :: stage
      associate (stepper => walker%stages(stage)%item)
         outcome_of = outcome_t(walker%accepted, walker%b, stepper%continued, stepper%uncertified)
      end associate
   end function outcome_of

   !> Counts a stage. An apparent fault of the library is followed once more before it counts.
   subroutine assess(oracle, branch, outcome, solver, kind, k, tally)
      type(oracle_t), intent(in) :: oracle
      type(branch_t), intent(in) :: branch
      type(outcome_t), intent(in) :: outcome
      character(len=*), intent(in) :: solver
      !> Row and column of the counts.
      integer, intent(in) :: kind, k
      type(tally_t), intent(inout) :: tally
      type(branch_t) :: checked
      logical :: right
      right = outcome%accepted .eqv. branch%outcome == REACHED
      if (right .and. outcome%accepted) right = norm2(outcome%b - branch%b) <= same_root
      checked = branch
      if (.not. right .and. branch%outcome /= LOST) call follow_again(oracle, checked)
      ! The ends of a branch next to the end of the stage are a matter of round-off.
      if (checked%outcome == ENDED .and. checked%t > 1 - 1e-5_wp) checked%outcome = LOST
      associate (counts => tally%counts(kind, k))
         counts%stages = counts%stages + 1
         if (outcome%accepted) then
            if (outcome%continued == 0) counts%at_once = counts%at_once + 1
            if (outcome%continued > 0) counts%continued = counts%continued + 1
            if (outcome%uncertified > 0) counts%uncertified = counts%uncertified + 1
         end if
         if (checked%outcome == LOST) then
            counts%unclear = counts%unclear + 1
         else if (outcome%accepted .and. .not. right .and. outcome%uncertified > 0) then
            counts%wrong_uncertified = counts%wrong_uncertified + 1
            call tally%note(trim(solver)//' accepts, without a proof, a wrong root', fails=.false.)
         else if (outcome%accepted .and. .not. right) then
            counts%wrong = counts%wrong + 1
            call tally%note(trim(solver)//' accepts a wrong root as certified')
         else if (.not. outcome%accepted .and. (right .or. branch%turn > longest)) then
            counts%refused = counts%refused + 1
         else if (.not. outcome%accepted) then
            counts%too_careful = counts%too_careful + 1
         end if
      end associate
   end subroutine assess

   !> A step of the whole method must be its stages, to the last bit, and be refused with them.
   subroutine compare_whole(item, system, walkers, n, tally)
      type(attack_case_t), intent(in) :: item
      type(system_t), intent(in) :: system
      type(walker_t), intent(inout) :: walkers(:)
      integer, intent(in) :: n
      type(tally_t), intent(inout) :: tally
      type(status_t) :: status
      integer :: k
      logical :: same
      do k = 1, size(walkers)
         associate (walker => walkers(k))
            ! The walk ends where the solvers differ, which may be inside a step.
            if (.not. all(walkers%goes_on) .and. walker%accepted) cycle
            call walker%whole%step(system, walker%step_end, item%dt, status)
            walker%state%t = walker%step_end%t
            same = .not. status%ok()
            if (walker%accepted) &
               same = status%ok() .and. all(walker%state%q == walker%step_end%q) .and. &
                      all(walker%state%p == walker%step_end%p) .and. &
                      walker%whole%uncertified == uncertified_stages(walker, n)
            if (same) cycle
            tally%composed = tally%composed + 1
            call tally%note('a composed step is not its stages')
         end associate
      end do
   end subroutine compare_whole

   integer function uncertified_stages(walker, n)
      type(walker_t), intent(in) :: walker
      integer, intent(in) :: n
      integer :: i
      uncertified_stages = 0
      do i = 1, n
         uncertified_stages = uncertified_stages + walker%stages(i)%item%uncertified
      end do
   end function uncertified_stages

   !> Returns the failed requirements of a tally; blank: none.
   function verdict_text(tally) result(text)
      type(tally_t), intent(in) :: tally
      character(len=:), allocatable :: text
      type(counts_t) :: all, hard
      all = tally%total()
      associate (c => tally%counts)
         hard = counts_t(stages=sum(c(2:, :)%stages), too_careful=sum(c(2:, :)%too_careful))
         text = ''
         call require(tally%broken == 0, 'a case cannot be set up', tally%broken)
         call require(all%wrong == 0, 'wrong roots accepted as certified', all%wrong)
         call require(tally%disagreements == 0, 'the solvers disagree on what is certified', tally%disagreements)
         ! Roots that are not certified are right but for a few.
         call require(100*all%wrong_uncertified <= all%uncertified, 'wrong roots accepted without a proof', &
                      all%wrong_uncertified)
         call require(200*tally%uncertified_disagreements <= all%uncertified, &
                      'the solvers disagree on what is not certified', tally%uncertified_disagreements)
         call require(tally%composed == 0, 'composed steps are not their stages', tally%composed)
         call require(100*all%unclear <= all%stages, 'the oracle does not know', all%unclear)
         call require(100*sum(c(1, :)%too_careful) <= sum(c(1, :)%stages), 'moderate stages refused', &
                      sum(c(1, :)%too_careful))
         call require(100*hard%too_careful <= 12*hard%stages, 'hard stages refused', hard%too_careful)
         call require(100*(all%at_once + all%continued) >= 60*all%stages, 'too few stages accepted', &
                      all%at_once + all%continued)
      end associate
      if (len(text) > 0 .and. len_trim(tally%first) > 0) text = text//'; '//trim(tally%first)

   contains

      subroutine require(condition, what, number)
         logical, intent(in) :: condition
         character(len=*), intent(in) :: what
         integer, intent(in) :: number
         character(len=12) :: digits
         if (condition) return
         write (digits, '(i0)') number
         if (len(text) > 0) text = text//', '
         text = text//what//' ('//trim(digits)//')'
      end subroutine require

   end function verdict_text

   !> b of a stage from an attitude to another, c = (1 + b)∘(1 - b)⁻¹, |b| < 1.
   pure function turn_between(q0, q1) result(b)
      real(wp), intent(in) :: q0(4), q1(4)
      real(wp) :: b(3), c(4)
      c = quat_product(quat_conjugate(q0), q1)/(norm2(q0)*norm2(q1))
      b = c(2:4)/(1 + c(1))
   end function turn_between

end module test_attack_run
