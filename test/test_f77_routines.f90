!> Interfaces of the FORTRAN 77 routines, and callbacks as a program has them. Programs of 1985 have no interfaces:
!> those of link/ call without.
module test_f77_routines
   use nutate_kinds, only: wp
   implicit none
   private

   public :: nuinit, nufram, nubpot, nubtor, nustep, nurun, nustat, nuncer, nusetp, nuomeg, nuinv, nuq2m, num2q, &
      nuq2e, nue2q, nufree, nutext, nuwhy, potential, torque, potspr, tormot, tornan, potnan

   abstract interface
      pure subroutine potential(gamma, u, du, iuser, ruser)
         import :: wp
         implicit none
         real(wp), intent(in) :: gamma(3)
         real(wp), intent(out) :: u, du(3)
         integer, intent(in) :: iuser(*)
         real(wp), intent(in) :: ruser(*)
      end subroutine potential

      pure subroutine torque(t, q, omega, tau, iuser, ruser)
         import :: wp
         implicit none
         real(wp), intent(in) :: t, q(4), omega(3)
         real(wp), intent(out) :: tau(3)
         integer, intent(in) :: iuser(*)
         real(wp), intent(in) :: ruser(*)
      end subroutine torque
   end interface

   interface
      subroutine nuinit(aj, aj0, h, cm, g, d, dn, iform, iorder, icall, work, lwork, info)
         import :: wp
         implicit none
         real(wp), intent(in) :: aj(3, 3)
         real(wp), intent(in) :: aj0
         real(wp), intent(in) :: h(3)
         real(wp), intent(in) :: cm(3)
         real(wp), intent(in) :: g(3)
         real(wp), intent(in) :: d(3)
         real(wp), intent(in) :: dn(3)
         integer, intent(in) :: iform
         integer, intent(in) :: iorder
         integer, intent(in) :: icall
         real(wp), intent(inout) :: work(*)
         integer, intent(in) :: lwork
         integer, intent(out) :: info
      end subroutine nuinit

      subroutine nustep(n, dt, t, q, p, pot, tor, iuser, ruser, work, lwork, info)
         import :: potential, torque, wp
         implicit none
         integer, intent(in) :: n
         real(wp), intent(in) :: dt
         real(wp), intent(inout) :: t
         real(wp), intent(inout) :: q(4)
         real(wp), intent(inout) :: p(4)
         procedure(potential) :: pot
         procedure(torque) :: tor
         integer, intent(in) :: iuser(*)
         real(wp), intent(in) :: ruser(*)
         real(wp), intent(inout) :: work(*)
         integer, intent(in) :: lwork
         integer, intent(out) :: info
      end subroutine nustep

      subroutine nurun(n, dt, t, q, p, pot, tor, iuser, ruser, k, rows, mrows, nrows, work, lwork, info)
         import :: potential, torque, wp
         implicit none
         integer, intent(in) :: n
         real(wp), intent(in) :: dt
         real(wp), intent(inout) :: t
         real(wp), intent(inout) :: q(4)
         real(wp), intent(inout) :: p(4)
         procedure(potential) :: pot
         procedure(torque) :: tor
         integer, intent(in) :: iuser(*)
         real(wp), intent(in) :: ruser(*)
         integer, intent(in) :: k
         real(wp), intent(inout) :: rows(12, *)
         integer, intent(in) :: mrows
         integer, intent(inout) :: nrows
         real(wp), intent(inout) :: work(*)
         integer, intent(in) :: lwork
         integer, intent(out) :: info
      end subroutine nurun

      subroutine nustat(istat, w, work, lwork, info)
         import :: wp
         implicit none
         integer, intent(inout) :: istat(3)
         real(wp), intent(inout) :: w
         real(wp), intent(in) :: work(*)
         integer, intent(in) :: lwork
         integer, intent(out) :: info
      end subroutine nustat

      subroutine nuncer(num, work, lwork, info)
         import :: wp
         implicit none
         integer, intent(inout) :: num
         real(wp), intent(in) :: work(*)
         integer, intent(in) :: lwork
         integer, intent(out) :: info
      end subroutine nuncer

      subroutine nubpot(bgrad, bhess, bthird, work, lwork, info)
         import :: wp
         implicit none
         real(wp), intent(in) :: bgrad, bhess, bthird
         real(wp), intent(inout) :: work(*)
         integer, intent(in) :: lwork
         integer, intent(out) :: info
      end subroutine nubpot

      subroutine nufram(w, work, lwork, info)
         import :: wp
         implicit none
         real(wp), intent(in) :: w(3)
         real(wp), intent(inout) :: work(*)
         integer, intent(in) :: lwork
         integer, intent(out) :: info
      end subroutine nufram

      subroutine nubtor(btor, bturn, bsec, brate, work, lwork, info)
         import :: wp
         implicit none
         real(wp), intent(in) :: btor, bturn, bsec, brate
         real(wp), intent(inout) :: work(*)
         integer, intent(in) :: lwork
         integer, intent(out) :: info
      end subroutine nubtor

      subroutine nusetp(q, omega, p, work, lwork, info)
         import :: wp
         implicit none
         real(wp), intent(in) :: q(4)
         real(wp), intent(in) :: omega(3)
         real(wp), intent(inout) :: p(4)
         real(wp), intent(in) :: work(*)
         integer, intent(in) :: lwork
         integer, intent(out) :: info
      end subroutine nusetp

      subroutine nuomeg(q, p, omega, work, lwork, info)
         import :: wp
         implicit none
         real(wp), intent(in) :: q(4)
         real(wp), intent(in) :: p(4)
         real(wp), intent(inout) :: omega(3)
         real(wp), intent(in) :: work(*)
         integer, intent(in) :: lwork
         integer, intent(out) :: info
      end subroutine nuomeg

      subroutine nuinv(q, p, pot, iuser, ruser, e, al, c, work, lwork, info)
         import :: potential, wp
         implicit none
         real(wp), intent(in) :: q(4)
         real(wp), intent(in) :: p(4)
         procedure(potential) :: pot
         integer, intent(in) :: iuser(*)
         real(wp), intent(in) :: ruser(*)
         real(wp), intent(inout) :: e(3)
         real(wp), intent(inout) :: al(3, 2)
         real(wp), intent(inout) :: c(2)
         real(wp), intent(in) :: work(*)
         integer, intent(in) :: lwork
         integer, intent(out) :: info
      end subroutine nuinv

      subroutine nuq2m(q, r, info)
         import :: wp
         implicit none
         real(wp), intent(in) :: q(4)
         real(wp), intent(inout) :: r(3, 3)
         integer, intent(out) :: info
      end subroutine nuq2m

      subroutine num2q(r, q, info)
         import :: wp
         implicit none
         real(wp), intent(in) :: r(3, 3)
         real(wp), intent(inout) :: q(4)
         integer, intent(out) :: info
      end subroutine num2q

      subroutine nuq2e(q, phi, theta, psi, info)
         import :: wp
         implicit none
         real(wp), intent(in) :: q(4)
         real(wp), intent(inout) :: phi
         real(wp), intent(inout) :: theta
         real(wp), intent(inout) :: psi
         integer, intent(out) :: info
      end subroutine nuq2e

      subroutine nue2q(phi, theta, psi, q, info)
         import :: wp
         implicit none
         real(wp), intent(in) :: phi
         real(wp), intent(in) :: theta
         real(wp), intent(in) :: psi
         real(wp), intent(inout) :: q(4)
         integer, intent(out) :: info
      end subroutine nue2q

      subroutine nufree(aj, q0, omega0, n, t, q, omega, info)
         import :: wp
         implicit none
         real(wp), intent(in) :: aj(3, 3)
         real(wp), intent(in) :: q0(4)
         real(wp), intent(in) :: omega0(3)
         integer, intent(in) :: n
         real(wp), intent(in) :: t(*)
         real(wp), intent(inout) :: q(4, *)
         real(wp), intent(inout) :: omega(3, *)
         integer, intent(out) :: info
      end subroutine nufree

      subroutine nutext(info, text)
         implicit none
         integer, intent(in) :: info
         character(len=*), intent(inout) :: text
      end subroutine nutext

      subroutine nuwhy(name, info, text)
         implicit none
         character(len=*), intent(in) :: name
         integer, intent(in) :: info
         character(len=*), intent(inout) :: text
      end subroutine nuwhy
   end interface

contains

   !> A spring that knows only the height of its point: k/2 γ₃² + m γ₃, k and m from ruser(1:2).
   pure subroutine potspr(gamma, u, du, iuser, ruser)
      real(wp), intent(in) :: gamma(3)
      real(wp), intent(out) :: u, du(3)
      integer, intent(in) :: iuser(*)
      real(wp), intent(in) :: ruser(*)
      u = 0.5_wp*ruser(1)*gamma(3)*gamma(3) + ruser(2)*gamma(3)
      du = [0.0_wp, 0.0_wp, ruser(1)*gamma(3) + ruser(2)]
   end subroutine potspr

   !> A motor about the axis iuser(1), that swings in time and has friction, ruser(3:5).
   pure subroutine tormot(t, q, omega, tau, iuser, ruser)
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp), intent(out) :: tau(3)
      integer, intent(in) :: iuser(*)
      real(wp), intent(in) :: ruser(*)
      tau = 0.0_wp
      tau(iuser(1)) = ruser(3)*cos(ruser(4)*t) - ruser(5)*omega(iuser(1))
   end subroutine tormot

   !> Computes a torque with one component ruser(7) from ruser(6) seconds on.
   pure subroutine tornan(t, q, omega, tau, iuser, ruser)
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp), intent(out) :: tau(3)
      integer, intent(in) :: iuser(*)
      real(wp), intent(in) :: ruser(*)
      call tormot(t, q, omega, tau, iuser, ruser)
      if (t > ruser(6)) tau(2) = ruser(7)
   end subroutine tornan

   !> The energy, or a component of the gradient where iuser(2) is 1, is ruser(7).
   pure subroutine potnan(gamma, u, du, iuser, ruser)
      real(wp), intent(in) :: gamma(3)
      real(wp), intent(out) :: u, du(3)
      integer, intent(in) :: iuser(*)
      real(wp), intent(in) :: ruser(*)
      call potspr(gamma, u, du, iuser, ruser)
      if (iuser(2) == 1) then
         du(1) = ruser(7)
      else
         u = ruser(7)
      end if
   end subroutine potnan

end module test_f77_routines
