! Stepping from FORTRAN 77: external subroutines, to be called without any module. SI units, angles in radians; REAL
! arguments are DOUBLE PRECISION, quaternions have their scalar first and rotate body into space components.
!
! INFO = 0: success. INFO = -i: argument number i is wrong. INFO > 0: the step failed for a reason that NUTEXT returns.
! On failure every argument but INFO is unchanged. All data of a body are in WORK. Each thread caches what it has
! prepared for them (`nutate_f77_prepared`). Nothing is printed.

!> NUINIT prepares WORK for the steps of a body, or returns the length that WORK needs.
!>
!> INFO = -1 also for a tensor that is not symmetric and positive definite. Moments of an idealised top, which break the
!> triangle rule, are accepted.
subroutine nuinit(aj, aj0, h, cm, g, d, dn, iform, iorder, icall, work, lwork, info)
   use nutate_f77_check, only: check_setup, find_bad_form
   use nutate_f77_stepping, only: needed_size, start_work
   use nutate_f77_work, only: setup_t
   use nutate_kinds, only: wp
   implicit none
   !> (input) Inertia tensor about the pivot, body axes, kg m², no principal moment above the sum of the other two;
   !> dimension (3,3).
   real(wp), intent(in) :: aj(3, 3)
   !> (input) Auxiliary inertia of the eight equations, kg m²; 0 or negative: infinite, which is best.
   real(wp), intent(in) :: aj0
   !> (input) Momentum of rotors that spin in the body, body axes, N m s; dimension (3); zero for none.
   real(wp), intent(in) :: h(3)
   !> (input) Mass times the position of the centre of mass, from the pivot, body axes, kg m; dimension (3).
   real(wp), intent(in) :: cm(3)
   !> (input) Acceleration of gravity, space axes, m/s²; dimension (3). No gravity: CM or G zero.
   real(wp), intent(in) :: g(3)
   !> (input) Damping: the torque -D(i)*OMEGA(i) along the body axes, N m s; dimension (3); zero for none.
   real(wp), intent(in) :: d(3)
   !> (input) The direction fixed in space whose body components are GAMMA of POT, any length; dimension (3).
   real(wp), intent(in) :: dn(3)
   !> (input) 1: reduced formulation, three equations (fast); 2: full formulation, eight equations solved by LAPACK.
   integer, intent(in) :: iform
   !> (input) Order of the method: 2, 4, 6 or 8.
   integer, intent(in) :: iorder
   !> (input) User-supplied subroutines in use: 0 none, 1 POT, 2 TOR, 3 both.
   integer, intent(in) :: icall
   !> (output) Dimension (LWORK). WORK(1): the length that it needs.
   real(wp), intent(inout) :: work(*)
   !> (input) Length of WORK; -1: query, only WORK(1) is set; it depends on IFORM, IORDER and ICALL.
   integer, intent(in) :: lwork
   !> (output) 0, or -i: argument i is wrong, for LWORK: WORK is too short.
   integer, intent(out) :: info
   type(setup_t) :: setup
   integer :: n
   setup%solver = iform
   setup%order = iorder
   setup%callbacks = icall
   setup%rotor = h
   setup%moment = cm
   setup%gravity = g
   setup%damping = d
   setup%direction = dn
   if (lwork == -1) then
      info = -find_bad_form(setup)
      if (info == 0) work(1) = real(needed_size(setup), wp)
      return
   end if
   call check_setup(setup, aj, aj0, info)
   info = -info
   if (info /= 0) return
   n = needed_size(setup)
   if (lwork < n) then
      info = -12
   else
      call start_work(setup, work(1:n))
   end if
end subroutine nuinit

!> NUFRAM makes the space axes rotate at a constant rate W, on the Earth or on a circular orbit. Call it after NUINIT,
!> before steps.
!>
!> G and DN are then fixed in these axes, and Q takes body components to components in these axes. P, OMEGA and AL are
!> absolute quantities, OMEGA of TOR too; AL(.,2) has components in these axes. Damping uses the rate relative to
!> these axes, and the work of damping and TOR is relative to them. The Jacobi integral T + V - W.AL(.,2), with
!> E(3) = T + V of NUINV, is conserved in place of the energy.
subroutine nufram(w, work, lwork, info)
   use nutate_f77_check, only: work_fault
   use nutate_f77_work, only: get_setup, place_at, put_setup, setup_t, AT_BEGUN
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   implicit none
   !> (input) Angular velocity of the space axes in inertial space, in these axes, rad/s; dimension (3).
   real(wp), intent(in) :: w(3)
   !> (input/output) From NUINIT, before the first step; dimension (LWORK).
   real(wp), intent(inout) :: work(*)
   !> (input) Length of WORK.
   integer, intent(in) :: lwork
   !> (output) 0; -i: argument i is wrong.
   integer, intent(out) :: info
   type(setup_t) :: setup
   info = merge(0, -1, all(is_moderate(w)))
   if (info == 0) info = work_fault(work, lwork, 2)
   if (info /= 0) return
   if (work(place_at(work) + AT_BEGUN) > 0.5_wp) then
      info = -2
      return
   end if
   call get_setup(work, setup)
   setup%frame_rate = w
   call put_setup(setup, work)
end subroutine nufram

!> NUSTEP performs N steps of length DT from T, Q, P.
!>
!> A call that starts where the last call with this WORK ended continues it: single steps give the same digits as one
!> call. A change of T, Q, P or DT starts anew. A step that fails is subdivided.
subroutine nustep(n, dt, t, q, p, pot, tor, iuser, ruser, work, lwork, info)
   use, intrinsic :: iso_c_binding, only: c_double, c_funloc, c_funptr, c_int
   use nutate_f77_interfaces, only: f77_potential, f77_torque
   use nutate_kinds, only: wp
   implicit none
   !> (input) Number of steps, N >= 0.
   integer, intent(in) :: n
   !> (input) Step, s; negative to integrate backward.
   real(wp), intent(in) :: dt
   !> (input/output) Time, s.
   real(wp), intent(inout) :: t
   !> (input/output) Attitude, unit quaternion to 5D-10; dimension (4).
   real(wp), intent(inout) :: q(4)
   !> (input/output) Conjugate momentum, from NUSETP, kg m²/s; dimension (4).
   real(wp), intent(inout) :: p(4)
   !> (input) SUBROUTINE POT(GAMMA, U, DU, IUSER, RUSER): from GAMMA(3), the body components of DN, the potential U (J)
   !> and its derivatives DU(3) by GAMMA. NUNONE if there is none. It must not change the data that it depends on.
   procedure(f77_potential) :: pot
   !> (input) SUBROUTINE TOR(T, Q, OMEGA, TAU, IUSER, RUSER): from T (s), Q(4) and OMEGA(3) (absolute, body axes,
   !> rad/s) the torque TAU(3), body axes, N m. NUNONE if there is none. It must not change the data that it depends on.
   procedure(f77_torque) :: tor
   !> (input) User data, passed to POT and TOR; any dimension.
   integer, intent(in) :: iuser(*)
   !> (input) User data, passed to POT and TOR; any dimension.
   real(wp), intent(in) :: ruser(*)
   !> (input/output) From NUINIT; dimension (LWORK). A copy of it continues like the original.
   real(wp), intent(inout) :: work(*)
   !> (input) Length of WORK.
   integer, intent(in) :: lwork
   !> (output) 0; -i: argument i is wrong; > 0: see NUTEXT.
   integer, intent(out) :: info
   interface
      subroutine perform_steps(n, dt, t, q, p, pot, tor, iuser, ruser, work, lwork, info) &
         bind(C, name='nutate_f77_perform')
         import :: c_double, c_funptr, c_int
         integer(c_int), intent(in) :: n, iuser(*), lwork
         real(c_double), intent(in) :: dt, ruser(*)
         real(c_double), intent(inout) :: t, q(4), p(4), work(*)
         type(c_funptr), intent(in), value :: pot, tor
         integer(c_int), intent(out) :: info
      end subroutine perform_steps
   end interface
   call perform_steps(n, dt, t, q, p, c_funloc(pot), c_funloc(tor), iuser, ruser, work, lwork, info)
end subroutine nustep

!> NURUN performs N steps as NUSTEP does and stores a row after every K steps.
subroutine nurun(n, dt, t, q, p, pot, tor, iuser, ruser, k, rows, mrows, nrows, work, lwork, info)
   use nutate_f77_calls, only: perform_rows
   use nutate_f77_interfaces, only: f77_potential, f77_torque
   use nutate_f77_stepping, only: request_t
   use nutate_kinds, only: wp
   implicit none
   !> (input) Number of steps, N >= 0.
   integer, intent(in) :: n
   !> (input) Step, s; negative to integrate backward.
   real(wp), intent(in) :: dt
   !> (input/output) Time, s.
   real(wp), intent(inout) :: t
   !> (input/output) Attitude, unit quaternion to 5D-10; dimension (4).
   real(wp), intent(inout) :: q(4)
   !> (input/output) Conjugate momentum, from NUSETP, kg m²/s; dimension (4).
   real(wp), intent(inout) :: p(4)
   !> (input) As for NUSTEP.
   procedure(f77_potential) :: pot
   !> (input) As for NUSTEP.
   procedure(f77_torque) :: tor
   !> (input) User data, passed to POT and TOR; any dimension.
   integer, intent(in) :: iuser(*)
   !> (input) User data, passed to POT and TOR; any dimension.
   real(wp), intent(in) :: ruser(*)
   !> (input) Steps between two rows, K >= 1.
   integer, intent(in) :: k
   !> (output) Rows, each a column of ROWS: time, s; Q (4); angular velocity (3), body axes, rad/s; angular momentum
   !> (3), space axes, N m s; energy, J. The first is the state on entry, the last that on return; dimension (12,MROWS).
   real(wp), intent(inout), target :: rows(12, *)
   !> (input) How many rows ROWS can hold: at least 1 + N/K, and one more if K does not divide N.
   integer, intent(in) :: mrows
   !> (output) Rows written; after a failed step those before it.
   integer, intent(inout) :: nrows
   !> (input/output) From NUINIT; dimension (LWORK).
   real(wp), intent(inout) :: work(*)
   !> (input) Length of WORK.
   integer, intent(in) :: lwork
   !> (output) 0; -i: argument i is wrong; > 0: see NUTEXT. ROWS and NROWS then have the rows before the failure.
   integer, intent(out) :: info
   type(request_t) :: request
   request = request_t(n=n, every=k, dt=dt, t=t, q=q, p=p)
   request%store%rows => rows(:, 1:mrows)
   call perform_rows(request, pot, tor, iuser, ruser, work, lwork, info)
   if (info >= 0) nrows = request%store%n
   if (info /= 0) return
   t = request%t
   q = request%q
   p = request%p
end subroutine nurun

!> NUSTAT returns statistics of the steps since NUINIT.
subroutine nustat(istat, w, work, lwork, info)
   use nutate_f77_check, only: work_fault
   use nutate_f77_work, only: place_at, AT_ALL_STEPS, AT_ITERATIONS, AT_SUBDIVIDED, AT_WORK
   use nutate_kinds, only: wp
   implicit none
   !> (output) Steps; Newton iterations; steps that had to be subdivided; each at most HUGE(0); dimension (3).
   integer, intent(inout) :: istat(3)
   !> (output) Work of damping and TOR, J: equals the change of the energy.
   real(wp), intent(inout) :: w
   !> (input) From NUINIT; dimension (LWORK).
   real(wp), intent(in) :: work(*)
   !> (input) Length of WORK.
   integer, intent(in) :: lwork
   !> (output) 0; -i: argument i is wrong.
   integer, intent(out) :: info
   integer :: k
   info = work_fault(work, lwork, 3)
   if (info /= 0) return
   k = place_at(work)
   istat = int(min(work(k + [AT_ALL_STEPS, AT_ITERATIONS, AT_SUBDIVIDED]), real(huge(0), wp)))
   w = work(k + AT_WORK)
end subroutine nustat

!> NUNCER returns the number of steps since NUINIT that are not certified.
subroutine nuncer(num, work, lwork, info)
   use nutate_f77_check, only: work_fault
   use nutate_f77_work, only: place_at, AT_UNCERTIFIED
   use nutate_kinds, only: wp
   implicit none
   !> (output) Steps, at most HUGE(0).
   integer, intent(inout) :: num
   !> (input) From NUINIT; dimension (LWORK).
   real(wp), intent(in) :: work(*)
   !> (input) Length of WORK.
   integer, intent(in) :: lwork
   !> (output) 0; -i: argument i is wrong.
   integer, intent(out) :: info
   info = work_fault(work, lwork, 2)
   if (info == 0) num = int(min(work(place_at(work) + AT_UNCERTIFIED), real(huge(0), wp)))
end subroutine nuncer

!> NUBPOT sets bounds of POT: with them the root of a step can be certified to be that of the true motion (see NUNCER).
!>
!> The bounds must hold for all GAMMA up to |DN| long. They are not verified; the wider they are, the shorter the steps
!> that can be certified. They are stored in WORK; another call replaces them.
subroutine nubpot(bgrad, bhess, bthird, work, lwork, info)
   use nutate_f77_check, only: find_bad_bound, work_fault
   use nutate_f77_work, only: get_setup, put_setup, setup_t
   use nutate_kinds, only: wp
   implicit none
   !> (input) Bound of the length of DU; 0, or 1D-300 to 1D100.
   real(wp), intent(in) :: bgrad
   !> (input) Bound of the norm of the second derivatives of U by GAMMA: of the size of their eigenvalues.
   real(wp), intent(in) :: bhess
   !> (input) Bound of the third derivative of U along any unit vector.
   real(wp), intent(in) :: bthird
   !> (input/output) From NUINIT, with POT; dimension (LWORK).
   real(wp), intent(inout) :: work(*)
   !> (input) Length of WORK.
   integer, intent(in) :: lwork
   !> (output) 0; -i: argument i is wrong.
   integer, intent(out) :: info
   type(setup_t) :: setup
   info = -find_bad_bound([bgrad, bhess, bthird])
   if (info == 0) info = work_fault(work, lwork, 4)
   if (info /= 0) return
   call get_setup(work, setup)
   if (mod(setup%callbacks, 2) == 0) then
      info = -4
      return
   end if
   setup%potential_bounds = [bgrad, bhess, bthird, 0.0_wp]
   call put_setup(setup, work)
end subroutine nubpot

!> NUBTOR sets bounds of a TOR that does not depend on OMEGA, as NUBPOT does of POT. They must hold at all attitudes and
!> times.
subroutine nubtor(btor, bturn, bsec, brate, work, lwork, info)
   use nutate_f77_check, only: find_bad_bound, work_fault
   use nutate_f77_work, only: get_setup, put_setup, setup_t
   use nutate_kinds, only: wp
   implicit none
   !> (input) Bound of the length of TAU, N m; 0, or 1D-300 to 1D100, as the other bounds.
   real(wp), intent(in) :: btor
   !> (input) Bound of its derivative with respect to the angle, rad, as the body rotates about any axis, N m.
   real(wp), intent(in) :: bturn
   !> (input) Bound of its second derivative with respect to that angle, N m.
   real(wp), intent(in) :: bsec
   !> (input) Rate, 1/s: BRATE times each bound above bounds the time derivative of that quantity; 0 if TAU does not
   !> depend on time.
   real(wp), intent(in) :: brate
   !> (input/output) From NUINIT, with TOR; dimension (LWORK).
   real(wp), intent(inout) :: work(*)
   !> (input) Length of WORK.
   integer, intent(in) :: lwork
   !> (output) 0; -i: argument i is wrong.
   integer, intent(out) :: info
   type(setup_t) :: setup
   info = -find_bad_bound([btor, bturn, bsec, brate])
   if (info == 0) info = work_fault(work, lwork, 5)
   if (info /= 0) return
   call get_setup(work, setup)
   if (setup%callbacks < 2) then
      info = -5
      return
   end if
   setup%torque_bounds = [btor, bturn, bsec, brate]
   call put_setup(setup, work)
end subroutine nubtor

!> NUNONE does nothing: pass it in place of POT or TOR where there is none.
pure subroutine nunone()
   implicit none
end subroutine nunone
