!> One key of a scene with given numbers, as arguments of the FORTRAN 77 routines: are they taken?
module test_limit_f77
   use nutate_kinds, only: wp
   use test_f77_routines, only: nue2q, nuinit, nuinv, nurun, nusetp, nustep, potnan, potspr, tormot
   use test_limit_text, only: origin, setting_t, top, up
   implicit none
   private

   public :: f77_takes, f77_takes_direction, f77_takes_energy, f77_takes_every

   real(wp), parameter :: plain(7) = 0.0_wp
   real(wp), parameter :: unit_tensor(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
                                                       1.0_wp], [3, 3])
   integer, parameter :: work_size = 2000, iuser(2) = [3, 0]

contains

   !> True if the FORTRAN 77 routine with the argument takes it; `known` if there is one.
   logical function f77_takes(setting, known)
      type(setting_t), intent(in) :: setting
      logical, intent(out) :: known
      real(wp) :: aj(3, 3), aj0, h(3), cm(3), g(3), d(3), work(work_size), t, q(4), p(4), dt, omega(3)
      integer :: info, k
      known = .true.
      aj = 0.0_wp
      do k = 1, 3
         aj(k, k) = setting%inertia
      end do
      aj0 = 0.0_wp
      h = 0.0_wp
      d = 0.0_wp
      cm = setting%mass*top
      g = 0.0_wp
      dt = setting%time_step
      q = setting%q
      omega = setting%omega
      info = 0
      select case (trim(setting%group)//'.'//trim(setting%key))
      case ('body.inertia')
         do k = 1, 3
            aj(k, k) = setting%values(k)
         end do
      case ('body.inertia_tensor')
         associate (j => setting%values)
            aj = reshape([j(1), j(4), j(5), j(4), j(2), j(6), j(5), j(6), j(3)], [3, 3])
         end associate
      case ('integrator.auxiliary_inertia'); aj0 = setting%values(1)
      case ('rotor.momentum'); h = setting%values(1:3)
      case ('gravity.acceleration'); g = setting%values(1:3)
      case ('damping.coefficient'); d = setting%values(1:3)
      case ('initial.angular_velocity'); omega = setting%values(1:3)
      case ('initial.euler'); call nue2q(setting%values(1), setting%values(2), setting%values(3), q, info)
      case ('integrator.time_step'); dt = setting%values(1)
      case default; known = .false.
      end select
      if (info == 0) call nuinit(aj, aj0, h, cm, g, d, up, 2, 2, 0, work, work_size, info)
      if (info == 0) call nusetp(q, omega, p, work, work_size, info)
      t = 0.0_wp
      if (info == 0) call nustep(1, dt, t, q, p, potspr, tormot, iuser, plain, work, work_size, info)
      ! INFO > 0 is too late: the argument has been taken.
      f77_takes = info >= 0
   end function f77_takes

   !> True if NUINIT takes the direction of POT.
   logical function f77_takes_direction(direction)
      real(wp), intent(in) :: direction(3)
      real(wp) :: work(work_size)
      integer :: info
      call nuinit(unit_tensor, 0.0_wp, origin, origin, origin, origin, direction, 1, 2, 1, work, work_size, info)
      f77_takes_direction = info == 0
   end function f77_takes_direction

   !> True if NUINV takes the energy of POT.
   logical function f77_takes_energy(energy)
      real(wp), intent(in) :: energy
      real(wp) :: work(work_size), e(3), al(3, 2), c(2)
      integer :: info
      call nuinit(unit_tensor, 0.0_wp, origin, origin, origin, origin, up, 1, 2, 1, work, work_size, info)
      call nuinv([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], potnan, iuser, &
                 [plain(1:6), energy], e, al, c, work, work_size, info)
      f77_takes_energy = info == 0
   end function f77_takes_energy

   !> True if NURUN takes so many steps between rows.
   logical function f77_takes_every(every)
      integer, intent(in) :: every
      real(wp) :: work(work_size), t, q(4), p(4), rows(12, 20)
      integer :: info, n
      call nuinit(unit_tensor, 0.0_wp, origin, origin, origin, origin, up, 1, 2, 0, work, work_size, info)
      t = 0.0_wp
      q = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      p = 0.0_wp
      call nurun(10, 0.1_wp, t, q, p, potspr, tormot, iuser, plain, every, rows, 20, n, work, work_size, info)
      f77_takes_every = info == 0
   end function f77_takes_every

end module test_limit_f77
