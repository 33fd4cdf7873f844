! Many bodies for FORTRAN 77: external subroutines, see nutate_f77_steps.f90 for what they have in common.

!> NUBSET makes WORK ready for bodies of one or several classes, which NUBODY, NUBKIK and NUBDRF move.
subroutine nubset(nc, aj, iframe, work, lwork, info)
   use nutate_f77_classes, only: classes_length, fill_classes
   use nutate_kinds, only: wp
   implicit none
   !> (input) Number of classes, NC >= 1.
   integer, intent(in) :: nc
   !> (input) Inertia tensors about the reference point, body axes, kg m²; dimension (3,3,NC).
   real(wp), intent(in) :: aj(3, 3, *)
   !> (input) What AL is. 0: angular momentum in space axes, torques in space axes; 1: angular momentum in body axes,
   !> torques in body axes; 2: angular velocity in body axes, torques in body axes.
   integer, intent(in) :: iframe
   !> (output) Dimension (LWORK).
   real(wp), intent(inout) :: work(*)
   !> (input) Length of WORK, at least 4 + 23*NC.
   integer, intent(in) :: lwork
   !> (output) 0, or -i: argument i is wrong, for LWORK: WORK is too short.
   integer, intent(out) :: info
   info = 0
   if (nc < 1 .or. nc > 50000000) then
      info = -1
   else if (lwork < classes_length(nc)) then
      info = -5
   end if
   if (info /= 0) return
   call fill_classes(aj(:, :, 1:nc), iframe, work(1:classes_length(nc)), info)
   info = -info
end subroutine nubset

!> NUBTHR sets how many threads share the bodies of a call of NUBODY, NUBKIK or NUBDRF. Results are bitwise identical
!> for any number of threads.
subroutine nubthr(nt, work, lwork, info)
   use nutate_f77_classes, only: find_bad_work, most_threads, set_threads
   use nutate_kinds, only: wp
   implicit none
   !> (input) Number of threads, 0 <= NT <= 4096. 0: as many as OpenMP gives (OMP_NUM_THREADS). NUBSET sets 1; a library
   !> without OpenMP has 1.
   integer, intent(in) :: nt
   !> (input/output) From NUBSET; dimension (LWORK).
   real(wp), intent(inout) :: work(*)
   !> (input) Length of WORK.
   integer, intent(in) :: lwork
   !> (output) 0, or -i: argument i is wrong.
   integer, intent(out) :: info
   info = -find_bad_work(work, lwork)
   if (info /= 0) info = info - 1
   if (nt < 0 .or. nt > most_threads) info = -1
   if (info == 0) call set_threads(nt, work)
end subroutine nubthr

!> NUBODY moves bodies by a step: AL by DT*TOR, then Q without torque.
!>
!> AL is half a step behind Q: before the first step call NUBKIK with -DT/2, after the last one with DT/2. A body fails
!> if a number is not finite or beyond 1D100, |Q| is not 1 to 5D-10, it has no class, or it rotates by over 1D8 rad.
subroutine nubody(n, dt, ic, q, al, tor, mbad, ibad, nbad, work, lwork, info)
   use nutate_bodies, only: movement_t
   use nutate_f77_classes, only: find_bad_move, move_by_work
   use nutate_kinds, only: wp
   implicit none
   !> (input) Number of bodies, N >= 0.
   integer, intent(in) :: n
   !> (input) Step, s, of either sign, not zero.
   real(wp), intent(in) :: dt
   !> (input) Class of each body, 1 to NC; dimension (N). IC(1) = 0: all are of class 1, and the rest is not read.
   integer, intent(in) :: ic(*)
   !> (input/output) Attitudes, unit quaternions, body to space; dimension (4,N).
   real(wp), intent(inout) :: q(4, *)
   !> (input/output) Angular momenta, kg m²/s, or angular velocities, rad/s, half a step behind Q; dimension (3,N).
   real(wp), intent(inout) :: al(3, *)
   !> (input) Torques at Q, N m, in the axes of AL; dimension (3,N).
   real(wp), intent(in) :: tor(3, *)
   !> (input) How many bodies IBAD can list, MBAD >= 0.
   integer, intent(in) :: mbad
   !> (output) Bodies that failed and kept their state, ascending, the first MBAD of them; dimension (MBAD).
   integer, intent(inout) :: ibad(*)
   !> (output) Number of all bodies that failed.
   integer, intent(inout) :: nbad
   !> (input) From NUBSET; dimension (LWORK).
   real(wp), intent(in) :: work(*)
   !> (input) Length of WORK.
   integer, intent(in) :: lwork
   !> (output) 0; -i: argument i is wrong, nothing has changed; 4: NBAD bodies failed, all others have moved.
   integer, intent(out) :: info
   info = -find_bad_move(n, dt, mbad, work, lwork)
   if (info /= 0) return
   call move_by_work(movement_t(dt, .true., .true.), n, ic(1:n), q(:, 1:n), al(:, 1:n), tor(:, 1:n), &
                     ibad(1:mbad), nbad, work(1:int(work(1))), info)
end subroutine nubody

!> NUBKIK changes the momenta alone, by DT*TOR.
subroutine nubkik(n, dt, ic, q, al, tor, mbad, ibad, nbad, work, lwork, info)
   use nutate_bodies, only: movement_t
   use nutate_f77_classes, only: find_bad_move, move_by_work
   use nutate_kinds, only: wp
   implicit none
   !> (input) Number of bodies, N >= 0.
   integer, intent(in) :: n
   !> (input) Step, s, of either sign, not zero.
   real(wp), intent(in) :: dt
   !> (input) Class of each body, 1 to NC; dimension (N). IC(1) = 0: all are of class 1, and the rest is not read.
   integer, intent(in) :: ic(*)
   !> (input) Attitudes, which are only tested; dimension (4,N).
   real(wp), intent(inout) :: q(4, *)
   !> (input/output) Angular momenta, kg m²/s, or angular velocities, rad/s; dimension (3,N).
   real(wp), intent(inout) :: al(3, *)
   !> (input) Torques at Q, N m, in the axes of AL; dimension (3,N).
   real(wp), intent(in) :: tor(3, *)
   !> (input) How many bodies IBAD can list, MBAD >= 0.
   integer, intent(in) :: mbad
   !> (output) Bodies that failed and kept their state, ascending, the first MBAD of them; dimension (MBAD).
   integer, intent(inout) :: ibad(*)
   !> (output) Number of all bodies that failed.
   integer, intent(inout) :: nbad
   !> (input) From NUBSET; dimension (LWORK).
   real(wp), intent(in) :: work(*)
   !> (input) Length of WORK.
   integer, intent(in) :: lwork
   !> (output) 0; -i: argument i is wrong, nothing has changed; 4: NBAD bodies failed, all others have moved.
   integer, intent(out) :: info
   info = -find_bad_move(n, dt, mbad, work, lwork)
   if (info /= 0) return
   call move_by_work(movement_t(dt, .true., .false.), n, ic(1:n), q(:, 1:n), al(:, 1:n), tor(:, 1:n), &
                     ibad(1:mbad), nbad, work(1:int(work(1))), info)
end subroutine nubkik

!> NUBDRF moves bodies without torques.
subroutine nubdrf(n, dt, ic, q, al, mbad, ibad, nbad, work, lwork, info)
   use nutate_bodies, only: movement_t
   use nutate_f77_classes, only: find_bad_move, move_by_work
   use nutate_kinds, only: wp
   implicit none
   !> (input) Number of bodies, N >= 0.
   integer, intent(in) :: n
   !> (input) Step, s, of either sign, not zero.
   real(wp), intent(in) :: dt
   !> (input) Class of each body, 1 to NC; dimension (N). IC(1) = 0: all are of class 1, and the rest is not read.
   integer, intent(in) :: ic(*)
   !> (input/output) Attitudes, unit quaternions, body to space; dimension (4,N).
   real(wp), intent(inout) :: q(4, *)
   !> (input/output) Angular momenta, kg m²/s, unchanged in space axes, or angular velocities, rad/s; dimension (3,N).
   real(wp), intent(inout) :: al(3, *)
   !> (input) How many bodies IBAD can list, MBAD >= 0.
   integer, intent(in) :: mbad
   !> (output) Bodies that failed and kept their state, ascending, the first MBAD of them; dimension (MBAD).
   integer, intent(inout) :: ibad(*)
   !> (output) Number of all bodies that failed.
   integer, intent(inout) :: nbad
   !> (input) From NUBSET; dimension (LWORK).
   real(wp), intent(in) :: work(*)
   !> (input) Length of WORK.
   integer, intent(in) :: lwork
   !> (output) 0; -i: argument i is wrong, nothing has changed; 4: NBAD bodies failed, all others have moved.
   integer, intent(out) :: info
   ! NUBDRF has no TOR: its arguments after AL have numbers one less than those of NUBODY.
   info = find_bad_move(n, dt, mbad, work, lwork)
   if (info > 5) info = info - 1
   info = -info
   if (info /= 0) return
   call move_by_work(movement_t(dt, .false., .true.), n, ic(1:n), q(:, 1:n), al(:, 1:n), &
                     reshape([real(wp) ::], [3, 0]), ibad(1:mbad), nbad, work(1:int(work(1))), info)
end subroutine nubdrf
