!> A stepper that watches another one: is each step it accepts the continuation of the true motion?
!>
!> The root of a step is continued from short steps: from the same start, with the step growing to its length by small
!> amounts and each root the predictor of the next. A wrong root, with every invariant at round-off, is not found this
!> way.
module test_stability_branch
   use nutate_kinds, only: wp, long
   use nutate_methods, only: make_stepper
   use nutate_quaternion, only: quat_conjugate, quat_product
   use nutate_reduced_equations, only: reduced_equations_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: integrator_settings_t, stepper_t, system_t
   implicit none
   private

   public :: watched_t

   !> Lengths on the way from a short step to the whole.
   integer, parameter :: lengths = 3000
   !> Turns that are the same: at the end of a branch a root is good to the square root of round-off.
   real(wp), parameter :: same = 1e-6_wp

   !> Steps of a method, each compared with the continued one.
   type, extends(stepper_t) :: watched_t
      class(stepper_t), allocatable :: inner
      !> Steps accepted, and those that were not on the branch.
      integer(long) :: accepted = 0, off_branch = 0
   contains
      procedure :: set_up
      procedure :: advance
   end type watched_t

contains

   subroutine set_up(self, system, settings, status)
      class(watched_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
      call make_stepper(system, settings, self%inner, status)
   end subroutine set_up

   subroutine advance(self, system, state, dt, window_time, status)
      class(watched_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      type(state_t) :: before
      real(wp) :: root(3)
      before = state
      call self%inner%step(system, state, dt, status)
      self%iterations = self%inner%iterations
      self%residual = self%inner%residual
      self%work = self%inner%work
      if (.not. status%ok()) return
      self%accepted = self%accepted + 1
      call continue_branch(system, before, dt, root)
      if (.not. norm2(turn_between(before%q, state%q) - root) <= same) self%off_branch = self%off_branch + 1
   end subroutine advance

   !> The root b of a step, continued from short ones by Newton's iteration of the reduced equations; zero where the
   !> branch ends before.
   subroutine continue_branch(system, start, dt, root)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: start
      real(wp), intent(in) :: dt
      real(wp), intent(out) :: root(3)
      type(reduced_equations_t) :: equations
      real(wp) :: f(3), rows(3, 3), determinant
      integer :: i, k
      call equations%forces%prepare(system%effects, .true.)
      do i = 1, lengths
         call equations%set_step(system, (dt*i)/lengths)
         call equations%start(system, start, start%t + 0.5_wp*dt)
         if (i == 1) root = equations%explicit_guess(system)
         if (i > 1) root = (real(i, wp)/(i - 1))*root
         do k = 1, 8
            call equations%residual(system, root, f)
            if (equations%forces%active) call equations%linearize_forces(system, root)
            call equations%invert(root, rows, determinant)
            if (.not. determinant > 0.0_wp) exit
            root = root - matmul(transpose(rows), f)
            if (.not. maxval(abs(root)) < 2.0_wp) exit
         end do
         if (determinant > 0.0_wp .and. maxval(abs(root)) < 2.0_wp) cycle
         root = 0.0_wp
         return
      end do
   end subroutine continue_branch

   !> b of a step from an attitude to another: c = (1+b)∘(1-b)⁻¹.
   pure function turn_between(q0, q1) result(b)
      real(wp), intent(in) :: q0(4), q1(4)
      real(wp) :: b(3), c(4)
      c = quat_product(quat_conjugate(q0), q1)
      b = c(2:4)/(1 + c(1))
   end function turn_between

end module test_stability_branch
