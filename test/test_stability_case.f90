!> Stability cases, the ways in which they are run, and the record of a run.
!>
!> A case says what it guards against and is run in each of its ways: shortened by the unit tests, whole by
!> `make stress`. The rule for all of them: a step is right, or it is refused with a reason; never silently wrong, never
!> a number that is not finite, never a state that stands still.
module test_stability_case
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_kinds, only: wp, long
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_system, only: system_t
   use test_support, only: check, error_type, one_in
   implicit none
   private

   public :: way_t, stability_case_t, record_t, check_case, number_text, way_label
   public :: ways, EVERY_WAY, ORDER_TWO, ORDER_EIGHT, INFINITE_J0, FULL_SYSTEM

   !> A way to integrate.
   type :: way_t
      !> Formulation, 'full' or 'reduced'.
      character(len=8) :: solver
      !> J0 is ten times the largest moment, not infinite.
      logical :: finite_j0
      integer :: order
      !> Steps are projected onto the invariants.
      logical :: conserve = .false.
   contains
      !> The settings that it means for a system.
      procedure :: settings
      !> 1/J0 for a system, kg⁻¹ m⁻².
      procedure :: inverse_j0
   end type way_t

   !> The ways there are. The reduced form has no J0.
   type(way_t), parameter :: ways(6) = [ &
      way_t('full', .false., 2), way_t('full', .true., 2), way_t('reduced', .false., 2), &
      way_t('full', .false., 8), way_t('full', .true., 8), way_t('reduced', .false., 8)]

   !> Selections among `ways`, for `stability_case_t`; `.and.` and `.or.` combine them.
   logical, parameter :: EVERY_WAY(6) = .true.
   logical, parameter :: ORDER_TWO(6) = ways%order == 2
   logical, parameter :: ORDER_EIGHT(6) = ways%order == 8
   logical, parameter :: INFINITE_J0(6) = .not. ways%finite_j0
   !> Ways that take states off the constraint manifold.
   logical, parameter :: FULL_SYSTEM(6) = ways%solver == 'full'

   !> Results of a case in one way.
   type :: record_t
      !> Nominal steps, and those that were subdivided.
      integer(long) :: steps = 0, subdivided_steps = 0
      !> Largest errors: energy residual over the largest T + |V|, momentum over the largest |l|, |qᵀq - 1|.
      real(wp) :: energy = 0.0_wp, momentum = 0.0_wp, norm = 0.0_wp
      !> A run ended before its time; the code of its status.
      logical :: refused = .false.
      integer :: code = 0
      !> Reason why a run was rejected; blank if none was.
      character(len=320) :: outcome = ''
      !> Another measured quantity, in a few words, and its value; blank if none.
      character(len=40) :: measure = ''
      real(wp) :: value = 0.0_wp
      logical :: passed = .true.
      !> The first requirement that was missed.
      character(len=240) :: message = ''
   contains
      !> Fails the case unless a condition holds.
      procedure :: require
      !> Fails the case unless a value is within a bound.
      procedure :: require_below
      !> Fails the case unless energy, momentum and norm are within a bound.
      procedure :: require_invariants
      !> Sets what else was measured.
      procedure :: show
      !> Adds the errors of a part: the largest count; steps add up.
      procedure :: absorb
   end type record_t

   !> A case.
   type :: stability_case_t
      character(len=56) :: name = ''
      !> Fault that the case guards against, in one sentence.
      character(len=320) :: guards = ''
      !> Selection of `ways` in which the case is run.
      logical :: selected(6) = .true.
      procedure(run_case), nopass, pointer :: run => null()
   end type stability_case_t

   abstract interface
      !> Runs a case in one way and assesses it.
      subroutine run_case(way, whole, record)
         import :: way_t, record_t
         type(way_t), intent(in) :: way
         !> The case is run at full length (minutes); otherwise in a fraction of a second.
         logical, intent(in) :: whole
         !> Blank on entry.
         type(record_t), intent(inout) :: record
      end subroutine run_case
   end interface

contains

   !> The settings that a way means for a system.
   type(integrator_settings_t) function settings(self, system)
      class(way_t), intent(in) :: self
      type(system_t), intent(in) :: system
      settings%formulation = self%solver
      settings%order = self%order
      settings%conserve = self%conserve
      settings%inverse_auxiliary_inertia = self%inverse_j0(system)
   end function settings

   !> 1/J0 for a system: 0, or a tenth of the inverse of the largest moment; kg⁻¹ m⁻².
   pure real(wp) function inverse_j0(self, system)
      class(way_t), intent(in) :: self
      type(system_t), intent(in) :: system
      inverse_j0 = 0.0_wp
      if (self%finite_j0) inverse_j0 = 0.1_wp/maxval(system%body%moments)
   end function inverse_j0

   !> 'full, finite J0, order 8'
   pure function way_label(way) result(text)
      type(way_t), intent(in) :: way
      character(len=:), allocatable :: text
      character(len=1) :: order
      write (order, '(i1)') way%order
      text = trim(way%solver)
      if (way%finite_j0) text = text//', finite J0'
      text = text//', order '//order
   end function way_label

   !> Fails the case unless a condition holds; the first failure is kept.
   subroutine require(self, condition, message)
      class(record_t), intent(inout) :: self
      logical, intent(in) :: condition
      !> Message if the condition does not hold.
      character(len=*), intent(in) :: message
      if (condition .or. .not. self%passed) return
      self%passed = .false.
      self%message = message
   end subroutine require

   !> Fails the case unless value <= bound; what is not finite fails.
   subroutine require_below(self, value, bound, label)
      class(record_t), intent(inout) :: self
      real(wp), intent(in) :: value, bound
      character(len=*), intent(in) :: label
      logical :: within
      within = .false.
      if (ieee_is_finite(value)) within = value <= bound
      call self%require(within, label//': '//number_text(value)//' is above '//number_text(bound))
   end subroutine require_below

   !> Fails the case unless energy, momentum and norm are within a bound.
   subroutine require_invariants(self, bound)
      class(record_t), intent(inout) :: self
      real(wp), intent(in) :: bound
      call self%require_below(self%energy, bound, 'energy')
      call self%require_below(self%momentum, bound, 'momentum')
      call self%require_below(self%norm, bound, 'norm')
   end subroutine require_invariants

   !> Sets what else was measured, and its value.
   subroutine show(self, measure, value)
      class(record_t), intent(inout) :: self
      !> A few words, with the unit.
      character(len=*), intent(in) :: measure
      real(wp), intent(in) :: value
      self%measure = measure
      self%value = value
   end subroutine show

   !> Adds a part of the case: largest errors, sums of steps, refusal and failure.
   subroutine absorb(self, part)
      class(record_t), intent(inout) :: self
      type(record_t), intent(in) :: part
      self%steps = self%steps + part%steps
      self%subdivided_steps = self%subdivided_steps + part%subdivided_steps
      self%energy = max(self%energy, part%energy)
      self%momentum = max(self%momentum, part%momentum)
      self%norm = max(self%norm, part%norm)
      if (part%refused .and. .not. self%refused) then
         self%refused = .true.
         self%code = part%code
         self%outcome = part%outcome
      end if
      call self%require(part%passed, trim(part%message))
   end subroutine absorb

   !> Two digits: '3.1E-14'.
   pure function number_text(value) result(text)
      real(wp), intent(in) :: value
      character(len=:), allocatable :: text
      character(len=16) :: buffer
      write (buffer, '(es10.1e3)') value
      buffer = adjustl(buffer)
      ! Two digits of the exponent do nearly always.
      if (index(buffer, 'E-0') > 0 .or. index(buffer, 'E+0') > 0) &
         buffer = buffer(:index(buffer, 'E') + 1)//buffer(index(buffer, 'E') + 3:)
      text = trim(buffer)
   end function number_text

   !> Runs the shortened form of a case in all of its ways; the first that fails is the error. But for `make stress`
   !> tests run it in some of them, others from case to case.
   subroutine check_case(error, item)
      type(error_type), allocatable, intent(inout) :: error
      type(stability_case_t), intent(in) :: item
      type(record_t) :: record
      integer :: i
      logical :: selected(size(ways))
      selected = share_of_ways(item)
      do i = 1, size(ways)
         if (.not. selected(i)) cycle
         record = record_t()
         call item%run(ways(i), .false., record)
         call check(error, record%passed, way_label(ways(i))//': '//trim(record%message))
      end do
   end subroutine check_case

   !> One in `one_in()` of the ways of a case; the length of its name says which. One in three are those with one
   !> solver and kind of J0, in every order.
   function share_of_ways(item) result(selected)
      type(stability_case_t), intent(in) :: item
      logical :: selected(size(ways))
      integer :: first, i
      do first = len_trim(item%name), len_trim(item%name) + one_in() - 1
         selected = item%selected .and. [(mod(i + first, one_in()) == 0, i=1, size(ways))]
         if (any(selected)) return
      end do
   end function share_of_ways

end module test_stability_case
