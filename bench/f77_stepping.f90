!> N steps by the library, or by NUSTEP in calls of M steps: what `f77_cost.sh` compares.
!>    f77_stepping N M box|top|damped full|reduced|METHOD ORDER
!> M = 0: the library's `integrate`; -1: its bare steps
program f77_stepping
   use nutate, only: damping_t, gravity_t, integrate, integrator_settings_t, long, make_body, make_state, &
      make_stepper, run_plan_t, state_t, status_t, stepper_t, system_t, wp
   use nutate_body, only: diagonal
   implicit none

   interface
      subroutine nunone()
      end subroutine nunone
      subroutine nuinit(aj, aj0, h, cm, g, d, dn, iform, iorder, icall, work, lwork, info)
         import :: wp
         implicit none
         integer, intent(in) :: iform, iorder, icall, lwork
         real(wp), intent(in) :: aj(3, 3), aj0, h(3), cm(3), g(3), d(3), dn(3)
         real(wp), intent(inout) :: work(lwork)
         integer, intent(out) :: info
      end subroutine nuinit
      subroutine nustep(n, dt, t, q, p, pot, tor, iuser, ruser, work, lwork, info)
         import :: wp, nunone
         implicit none
         integer, intent(in) :: n, lwork, iuser(1)
         real(wp), intent(in) :: dt, ruser(1)
         real(wp), intent(inout) :: t, q(4), p(4), work(lwork)
         procedure(nunone) :: pot, tor
         integer, intent(out) :: info
      end subroutine nustep
   end interface

   integer, parameter :: lwork = 2000
   real(wp), parameter :: dt = 0.01_wp, zero(3) = 0.0_wp
   type(system_t) :: system
   type(state_t) :: state
   type(integrator_settings_t) :: settings
   class(stepper_t), allocatable :: stepper
   type(status_t) :: status
   character(len=24) :: scene
   real(wp) :: work(lwork), g(3), d(3)
   integer :: n, m, i, info

   n = whole(1)
   m = whole(2)
   call get_command_argument(3, scene)
   call get_command_argument(4, settings%formulation)
   settings%order = whole(5)
   if (all(settings%formulation /= ['full   ', 'reduced'])) then
      settings%method = settings%formulation
      settings%formulation = ''
      settings%order = 0
      settings%conserve = settings%method == 'rk8' .or. settings%method == 'taylor'
   end if
   g = 0.0_wp
   d = 0.0_wp
   if (scene == 'top') g(3) = -9.81_wp
   if (scene == 'damped') d = 0.01_wp
   call make_body(diagonal([5.0_wp, 20.0_wp, 17.0_wp]), system%body, status, mass=1.0_wp, &
                  center_of_mass=[0.0_wp, 0.0_wp, 0.5_wp])
   if (scene == 'top') call system%effects%add(gravity_t(system%body, g))
   if (scene == 'damped') call system%effects%add(damping_t(d))
   state = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.1_wp, 0.0_wp, 10.0_wp])
   if (m <= 0) then
      call make_stepper(system, settings, stepper, status)
      if (m == 0) then
         call integrate(system, stepper, state, run_plan_t(time_step=dt, end_time=n*dt, every=int(n, long)), status)
      else
         do i = 1, n
            call stepper%step(system, state, dt, status)
         end do
      end if
   else
      call nuinit(system%body%inertia, 0.0_wp, zero, [0.0_wp, 0.0_wp, 0.5_wp], g, d, zero, &
                  merge(1, 2, settings%formulation == 'reduced'), settings%order, 0, work, lwork, info)
      do i = 1, n/m
         call nustep(m, dt, state%t, state%q, state%p, nunone, nunone, [0], [0.0_wp], work, lwork, info)
      end do
   end if
   write (*, '(2es24.16)') state%q(1), state%p(2)

contains

   !> Returns an integer of the command line.
   integer function whole(position)
      integer, intent(in) :: position
      character(len=24) :: text
      call get_command_argument(position, text)
      read (text, *) whole
   end function whole

end program f77_stepping
