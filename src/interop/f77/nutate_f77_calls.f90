!> Steps of NUSTEP and NURUN.
!>
!> Every procedure that uses a module that leads to the IEEE modules saves the state of the processor (gfortran 12),
!> which takes a twentieth of a step. So NUSTEP calls `perform_steps` by its binding label.
module nutate_f77_calls
   use, intrinsic :: iso_c_binding, only: c_double, c_f_procpointer, c_funptr, c_int
   use nutate_f77_prepared, only: f77_body_t, find_body, let_go
   use nutate_f77_check, only: find_bad_step, work_fault
   use nutate_f77_interfaces, only: f77_potential, f77_torque
   use nutate_f77_stepping, only: go_on, request_t, take_steps
   use nutate_kinds, only: wp
   implicit none
   private

   public :: perform_steps, perform_rows

contains

   !> Performs the steps of a call of NUSTEP, which describes the arguments.
   subroutine perform_steps(n, dt, t, q, p, pot, tor, iuser, ruser, work, lwork, info) &
      bind(C, name='nutate_f77_perform')
      integer(c_int), intent(in) :: n
      !> Step and time, s; attitude; conjugate momentum, kg m²/s.
      real(c_double), intent(in) :: dt
      real(c_double), intent(inout) :: t, q(4), p(4)
      !> Callbacks POT and TOR.
      type(c_funptr), intent(in), value :: pot, tor
      !> User data, passed to the callbacks.
      integer(c_int), intent(in) :: iuser(*)
      real(c_double), intent(in) :: ruser(*)
      real(c_double), intent(inout), target :: work(*)
      integer(c_int), intent(in) :: lwork
      integer(c_int), intent(out) :: info
      type(f77_body_t), pointer :: body
      logical :: is_next, done
      info = work_fault(work, lwork, 10)
      if (info /= 0) return
      body => find_body(work)
      is_next = .false.
      if (n > 0) is_next = body%is_next(work, dt, t, q, p)
      if (.not. is_next) info = -find_bad_step(n, dt, t, q, p, body, work)
      if (info == 0 .and. n > 0) then
         if (body%setup%callbacks > 0) call set_callbacks(body, pot, tor, iuser, ruser)
         if (.not. is_next) call body%recall(work, dt, t, q, p)
         call go_on(n, body, work, done)
         if (done) then
            t = body%state%t
            q = body%state%q
            p = body%state%p
         else
            call run_again(n, dt, t, q, p, body, work, info)
         end if
      end if
      call let_go(body)
   end subroutine perform_steps

   !> Sets POT and TOR of a call.
   subroutine set_callbacks(body, pot, tor, iuser, ruser)
      type(f77_body_t), intent(inout) :: body
      type(c_funptr), intent(in) :: pot, tor
      integer, intent(in) :: iuser(*)
      real(wp), intent(in) :: ruser(*)
      procedure(f77_potential), pointer :: potential
      procedure(f77_torque), pointer :: torque
      call c_f_procpointer(pot, potential)
      call c_f_procpointer(tor, torque)
      call body%set_potential(potential, iuser, ruser)
      call body%set_torque(torque, iuser, ruser)
   end subroutine set_callbacks

   !> Performs the steps of a call as a run, which subdivides steps that fail.
   subroutine run_again(n, dt, t, q, p, body, work, info)
      integer, intent(in) :: n
      real(wp), intent(in) :: dt
      real(wp), intent(inout) :: t, q(4), p(4)
      type(f77_body_t), intent(inout) :: body
      real(wp), intent(inout), target :: work(*)
      integer, intent(out) :: info
      type(request_t) :: request
      request = request_t(n=n, every=n, dt=dt, t=t, q=q, p=p)
      call take_steps(request, body, work, info)
      if (info /= 0) return
      t = request%t
      q = request%q
      p = request%p
   end subroutine run_again

   !> Performs the steps of a call of NURUN, which describes the arguments, with rows.
   subroutine perform_rows(request, pot, tor, iuser, ruser, work, lwork, info)
      !> Steps to perform, with associated rows.
      type(request_t), intent(inout) :: request
      procedure(f77_potential) :: pot
      procedure(f77_torque) :: tor
      integer, intent(in) :: iuser(*)
      real(wp), intent(in) :: ruser(*)
      real(wp), intent(inout), target :: work(*)
      integer, intent(in) :: lwork
      integer, intent(out) :: info
      type(f77_body_t), pointer :: body
      info = work_fault(work, lwork, 14)
      if (info /= 0) return
      body => find_body(work)
      associate (n => request%n, k => request%every)
         info = -find_bad_step(n, request%dt, request%t, request%q, request%p, body, work)
         if (info == 0 .and. k < 1) info = -10
         if (info == 0) then
            if (size(request%store%rows, 2) - 1 < n/k + min(1, mod(n, k))) info = -12
         end if
      end associate
      if (info == 0) then
         call body%set_potential(pot, iuser, ruser)
         call body%set_torque(tor, iuser, ruser)
         call take_steps(request, body, work, info)
      end if
      call let_go(body)
   end subroutine perform_rows

end module nutate_f77_calls
