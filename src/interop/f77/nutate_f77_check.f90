!> Tests of the arguments of the FORTRAN 77 routines: each finds the first that is wrong.
module nutate_f77_check
   use nutate_f77_prepared, only: f77_body_t
   use nutate_f77_work, only: setup_t
   use nutate_kinds, only: wp
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: is_attitude, is_rotation, is_motion, check_setup, find_bad_bound, find_bad_form, find_bad_step, work_fault

   interface

      !> Returns true for a quaternion of unit length, |qᵀq - 1| within the tolerance of a state; none is normalised
      !> here.
      pure logical module function is_attitude(q)
         !> Quaternion; shape (4).
         real(wp), intent(in) :: q(4)
      end function is_attitude

      !> Returns true for an orthogonal matrix of determinant 1.
      pure logical module function is_rotation(r)
         !> Matrix; shape (3,3).
         real(wp), intent(in) :: r(3, 3)
      end function is_rotation

      !> Returns true for a state that `check_motion` accepts.
      logical module function is_motion(system, state)
         type(system_t), intent(in) :: system
         type(state_t), intent(in) :: state
      end function is_motion

      !> Returns INFO for the argument WORK: 0 if NUINIT has filled it and it is long enough, -number if NUINIT has not
      !> filled it, -(number + 1), the argument LWORK, if it is too short.
      pure integer module function work_fault(work, lwork, number) result(info)
         real(wp), intent(in) :: work(*)
         integer, intent(in) :: lwork
         !> Number of the argument WORK; LWORK is the next.
         integer, intent(in) :: number
      end function work_fault

      !> Finds the number of the argument of NUINIT that is wrong, 0 if none is; sets body and 1/J0.
      pure module subroutine check_setup(setup, tensor, j0, bad)
         type(setup_t), intent(inout) :: setup
         !> Inertia tensor, body axes, kg m²; J0, kg m².
         real(wp), intent(in) :: tensor(3, 3), j0
         integer, intent(out) :: bad
      end subroutine check_setup

      !> Returns the number of the first of IFORM, IORDER and ICALL that is wrong, 0 if none is.
      pure integer module function find_bad_form(setup) result(bad)
         type(setup_t), intent(in) :: setup
      end function find_bad_form

      !> Returns the number of the first bound that is wrong, 0 if none is.
      pure integer module function find_bad_bound(bounds) result(bad)
         !> Bounds; shape (any).
         real(wp), intent(in) :: bounds(:)
      end function find_bad_bound

      !> Returns the number of the first of N, DT, T, Q, P that is wrong, 0 if none is. The results of the last call are
      !> not tested.
      integer module function find_bad_step(n, dt, t, q, p, body, work) result(bad)
         integer, intent(in) :: n
         real(wp), intent(in) :: dt, t, q(4), p(4)
         !> Body of `work`.
         type(f77_body_t), intent(in) :: body
         !> Work array from NUINIT.
         real(wp), intent(in) :: work(*)
      end function find_bad_step

   end interface

end module nutate_f77_check
