!> Cases of the randomised stress test of levels and extremes: motions of several steps with torques that begin, end and
!> jump, a sum of columns, and the path of that sum at many positions of each step, found without the library's angles.
!>
!> The angles come from the planes of q0, q3 and of q1, q2, in which (φ + ψ)/2 and (φ - ψ)/2 are followed from one
!> position to the next.
module test_path_case
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_applied_torque, only: applied_torque_t
   use nutate_column_event, only: column_event_t
   use nutate_gravity, only: gravity_t
   use nutate_hamiltonian, only: make_state, system_t
   use nutate_kinds, only: wp, pi
   use nutate_methods, only: default_settings, integrator_settings_t, make_stepper, stepper_t
   use nutate_motion, only: find_motion, motion_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_tabulated_torque, only: make_tabulated_torque, tabulated_torque_t
   use test_attack_case, only: attack_case_t, draw_case, make_system, BODY_TORQUE, FEEDBACK, SPACE_TORQUE
   use test_support, only: random_unit
   implicit none
   private

   public :: path_case_t, draw_path, find_values, quantity_columns

   !> Steps of a case, and places of a step or of a part of one.
   integer, parameter, public :: steps = 5, places = 240, most_parts = steps + 6, most_places = places*most_parts
   !> The error of the steps, over the size of the state, with which a motion is assessed.
   real(wp), parameter :: error_of_steps = 1e-6_wp

   character(len=8), parameter :: quantity_columns(16) = [character(len=8) :: 'phi', 'psi', 'phi', 'psi', 'omega1', &
      'omega2', 'omega3', 'omega_x', 'omega_z', 'L1', 'L3', 'l_y', 'kinetic', 'theta', 'q1', 'q2']

   !> One case.
   type :: path_case_t
      type(system_t) :: system
      type(state_t) :: start
      type(integrator_settings_t) :: settings
      type(column_event_t) :: event
      !> The columns of the event, one by one.
      type(column_event_t) :: one_by_one(2)
      !> s.
      real(wp) :: dt = 0.0_wp
      !> Parts of the run, between the ends of steps and the times at which torques begin, end or jump; their times, s.
      integer :: parts = 0
      real(wp) :: bounds(0:most_parts) = 0.0_wp
      !> The quantity at the places; shape (0:places*parts).
      real(wp) :: g(0:most_places) = 0.0_wp
      !> (φ + ψ)/2 and (φ - ψ)/2 there, rad, followed from one place to the next; shape (2, 0:places*parts).
      real(wp) :: halves(2, 0:most_places) = 0.0_wp
      !> Offsets of φ and ψ from the sum and the difference of their halves, rad: both start between -π and π.
      real(wp) :: turns(2) = 0.0_wp
   end type path_case_t

contains

   !> Draws a case; it is fit if its steps follow the motion, and its places the quantity.
   subroutine draw_path(seed, number, item, is_fit)
      integer, intent(in) :: seed, number
      type(path_case_t), intent(inout) :: item
      logical, intent(out) :: is_fit
      integer(int64) :: state
      real(wp) :: values(1)
      integer :: i
      state = 15485863_int64*number + 32452843_int64*seed + 86028157_int64
      do i = 1, 10
         values(1) = random_unit(state)
      end do
      call draw_motion(seed, number, state, item, is_fit)
      if (.not. is_fit) return
      call draw_breaks(state, item)
      call draw_columns(state, item)
      call draw_method(state, item, is_fit)
      if (is_fit) call walk(item, is_fit)
      if (is_fit) is_fit = steps_are_good(item)
   end subroutine draw_path

   !> A body of any kind; or one that spins about its axis of symmetry, by many turns in a step.
   subroutine draw_motion(seed, number, state, item, is_fit)
      integer, intent(in) :: seed, number
      integer(int64), intent(inout) :: state
      type(path_case_t), intent(inout) :: item
      logical, intent(out) :: is_fit
      type(attack_case_t) :: drawn
      type(status_t) :: status
      real(wp) :: spin
      integer :: i
      call draw_case(seed, number, drawn)
      item%dt = drawn%dt*0.05_wp**random_unit(state)
      spin = random_unit(state)
      if (spin < 0.4_wp) then
         drawn%moments(2) = drawn%moments(1)
         drawn%axes = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
         drawn%check_triangle = .false.
         drawn%n_effects = 0
         drawn%rotor = 0.0_wp
         drawn%omega(3) = drawn%omega(3)*30.0_wp**random_unit(state)
      end if
      ! Torques that act in windows are added by themselves.
      do i = 1, drawn%n_effects
         if (any(drawn%effects(i)%kind == [BODY_TORQUE, SPACE_TORQUE, FEEDBACK])) then
            drawn%effects(i)%start = -huge(1.0_wp)
            drawn%effects(i)%stop = huge(1.0_wp)
         end if
      end do
      call make_system(drawn, item%system, status)
      is_fit = status%ok()
      if (.not. is_fit) return
      if (spin < 0.2_wp) then
         item%system%body%center_of_mass = [0.0_wp, 0.0_wp, drawn%moments(1)*sum(drawn%omega**2)*random_unit(state)/10]
         call item%system%effects%add(gravity_t(item%system%body, [0.0_wp, 0.0_wp, -9.81_wp]))
      end if
      item%start = make_state(item%system, drawn%q, drawn%omega)
      item%start%t = drawn%t
   end subroutine draw_motion

   !> Torques that begin and end, and one by a table, with a jump in it.
   subroutine draw_breaks(state, item)
      integer(int64), intent(inout) :: state
      type(path_case_t), intent(inout) :: item
      type(tabulated_torque_t) :: table
      type(status_t) :: status
      real(wp) :: times(4), values(3, 4), amplitude(3), size
      integer :: i, k, at
      item%parts = steps
      item%bounds(0:steps) = [(item%start%t + i*item%dt, i=0, steps)]
      size = 0.5_wp*norm2(item%start%p)/abs(item%dt*steps)
      k = int(4*random_unit(state))
      do i = 1, 4
         times(i) = item%start%t + item%dt*steps*(0.2_wp*i + 0.15_wp*random_unit(state) - 0.1_wp)
         values(:, i) = size*[random_unit(state) - 0.5_wp, random_unit(state) - 0.5_wp, random_unit(state) - 0.5_wp]
      end do
      if (item%dt < 0.0_wp) times = times([4, 3, 2, 1])
      amplitude = values(:, 1)
      if (k == 1) then
         call item%system%effects%add(applied_torque_t(amplitude=amplitude, start=times(1), stop=times(2)))
         call item%system%effects%add(applied_torque_t(amplitude=-2*amplitude, start=times(2), stop=times(3)))
         call add_bounds(item, times(1:3))
      else if (k == 2) then
         ! A jump in the middle.
         times(3) = times(2)
         call make_tabulated_torque(times, values, table, status, at)
         call item%system%effects%add(table)
         call add_bounds(item, times([1, 2, 4]))
      end if
   end subroutine draw_breaks

   !> Adds times at which steps end, in their order.
   subroutine add_bounds(item, times)
      type(path_case_t), intent(inout) :: item
      real(wp), intent(in) :: times(:)
      integer :: i, k
      do i = 1, size(times)
         do k = item%parts, 0, -1
            if ((item%bounds(k) - times(i))*item%dt < 0.0_wp) exit
            item%bounds(k + 1) = item%bounds(k)
         end do
         item%bounds(k + 1) = times(i)
         item%parts = item%parts + 1
      end do
   end subroutine add_bounds

   !> One column, or the sum of two.
   subroutine draw_columns(state, item)
      integer(int64), intent(inout) :: state
      type(path_case_t), intent(inout) :: item
      integer :: i
      i = 1 + int(size(quantity_columns)*random_unit(state))
      item%event%columns(1) = quantity_columns(i)
      if (random_unit(state) < 0.3_wp) then
         item%event%weights(1) = 2*random_unit(state) - 1
         if (i <= 4) then
            item%event%columns(2) = quantity_columns(3 - (i - 2*((i - 1)/2)))
            item%event%weights(2) = 2*random_unit(state) - 1
         end if
      end if
      call item%event%place()
      do i = 1, 2
         item%one_by_one(i)%columns(1) = item%event%columns(i)
         call item%one_by_one(i)%place()
      end do
   end subroutine draw_columns

   subroutine draw_method(state, item, is_fit)
      integer(int64), intent(inout) :: state
      type(path_case_t), intent(inout) :: item
      logical, intent(out) :: is_fit
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      integer :: i
      i = int(10*random_unit(state))
      select case (i)
      case (0, 1, 2)
         item%settings = default_settings('taylor')
      case (3)
         item%settings = default_settings('rk4')
      case (4)
         item%settings = default_settings('dop853')
      case (5, 6)
         item%settings = default_settings('rk8')
      case (7)
         item%settings = default_settings('exact')
         if (item%system%effects%n_potentials + item%system%effects%n_torques > 0) &
            item%settings = default_settings('taylor')
      case default
         item%settings = integrator_settings_t(order=8 - 2*(i - 8))
      end select
      call make_stepper(item%system, item%settings, stepper, status)
      is_fit = status%ok()
   end subroutine draw_method

   !> Walks along the case by steps of its method: the quantity at all places. It is fit if all steps can be taken, and
   !> the angles do not turn much from place to place.
   subroutine walk(item, is_fit)
      type(path_case_t), intent(inout) :: item
      logical, intent(out) :: is_fit
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state, inside
      type(status_t) :: status
      real(wp) :: halves(2), t, work
      integer :: i, k
      call make_stepper(item%system, item%settings, stepper, status)
      is_fit = status%ok()
      if (.not. is_fit) return
      call stepper%keep_steps()
      state = item%start
      halves = half_angles(state)
      item%turns = -2*pi*anint([halves(1) + halves(2), halves(1) - halves(2)]/(2*pi))
      item%halves(:, 0) = halves
      item%g(0) = quantity(item, state, halves)
      do k = 0, item%parts - 1
         associate (first => item%bounds(k), last => item%bounds(k + 1))
            call stepper%step(item%system, state, last - first, status)
            is_fit = status%ok() .and. abs(last - first) > 1e-6_wp*abs(item%dt)
            if (.not. is_fit) return
            state%t = last
            do i = 1, places
               t = first + (last - first)*(real(i, wp)/places)
               inside = state
               if (i < places) call stepper%state_at(item%system, t, inside, work, status)
               call turn_on(halves, inside, is_fit)
               is_fit = is_fit .and. status%ok()
               if (.not. is_fit) return
               item%halves(:, k*places + i) = halves
               item%g(k*places + i) = quantity(item, inside, halves)
            end do
         end associate
      end do
   end subroutine walk

   !> Finds the quantity at other times than those of the places, by the same steps; fit as in `walk`.
   subroutine find_values(item, times, values, is_fit)
      !> A case that has been walked along.
      type(path_case_t), intent(in) :: item
      !> Times, s, in the order of the run; shape (any).
      real(wp), intent(in) :: times(:)
      !> Values of the quantity at these times; same shape.
      real(wp), intent(out) :: values(:)
      logical, intent(out) :: is_fit
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state, inside
      type(status_t) :: status
      real(wp) :: halves(2), work
      integer :: i, k, n
      values = 0.0_wp
      call make_stepper(item%system, item%settings, stepper, status)
      call stepper%keep_steps()
      state = item%start
      is_fit = .true.
      n = 1
      do k = 0, item%parts - 1
         associate (first => item%bounds(k), last => item%bounds(k + 1))
            call stepper%step(item%system, state, last - first, status)
            state%t = last
            do while (n <= size(times))
               if ((times(n) - last)*item%dt > 0.0_wp) exit
               call stepper%state_at(item%system, times(n), inside, work, status)
               i = max(0, min(places - 1, int(places*(times(n) - first)/(last - first))))
               halves = item%halves(:, k*places + i)
               call turn_on(halves, inside, is_fit)
               is_fit = is_fit .and. status%ok()
               if (.not. is_fit) return
               values(n) = quantity(item, inside, halves)
               n = n + 1
            end do
         end associate
      end do
   end subroutine find_values

   !> (φ + ψ)/2 and (φ - ψ)/2, rad; shape (2).
   pure function half_angles(state) result(halves)
      type(state_t), intent(in) :: state
      real(wp) :: halves(2)
      halves = [atan2(state%q(4), state%q(1)), atan2(state%q(3), state%q(2))]
   end function half_angles

   !> Follows both from one place to the next; not fit where they turn by so much that it is not sure how.
   subroutine turn_on(halves, state, is_fit)
      real(wp), intent(inout) :: halves(2)
      type(state_t), intent(in) :: state
      logical, intent(out) :: is_fit
      real(wp) :: change(2)
      change = half_angles(state) - halves
      ! q and -q are one attitude: half a turn of both.
      if (abs(change(1) - 2*pi*anint(change(1)/(2*pi))) > 0.5_wp*pi) change = change + pi
      change = change - 2*pi*anint(change/(2*pi))
      is_fit = all(abs(change) < 0.3_wp)
      halves = halves + change
   end subroutine turn_on

   !> The sum of columns.
   real(wp) function quantity(item, state, halves) result(g)
      type(path_case_t), intent(in) :: item
      type(state_t), intent(in) :: state
      real(wp), intent(in) :: halves(2)
      type(motion_t) :: motion
      real(wp) :: x
      integer :: i
      g = 0.0_wp
      do i = 1, 2
         select case (item%event%columns(i))
         case ('')
            return
         case ('phi')
            x = halves(1) + halves(2) + item%turns(1)
         case ('psi')
            x = halves(1) - halves(2) + item%turns(2)
         case default
            call find_motion(item%system, state, motion)
            x = item%one_by_one(i)%value(item%system, motion)
         end select
         g = g + item%event%weights(i)*x
      end do
   end function quantity

   !> True if steps of half the length come to the same end.
   logical function steps_are_good(item) result(are_good)
      type(path_case_t), intent(in) :: item
      class(stepper_t), allocatable :: stepper
      type(state_t) :: whole, halved
      type(status_t) :: status(2)
      integer :: k
      call make_stepper(item%system, item%settings, stepper, status(1))
      whole = item%start
      halved = item%start
      are_good = .true.
      do k = 0, item%parts - 1
         associate (length => item%bounds(k + 1) - item%bounds(k))
            call stepper%step(item%system, whole, length, status(1))
            call stepper%step(item%system, halved, 0.5_wp*length, status(1))
            if (status(1)%ok()) call stepper%step(item%system, halved, 0.5_wp*length, status(2))
            are_good = are_good .and. status(1)%ok() .and. status(2)%ok()
         end associate
         if (.not. are_good) return
      end do
      are_good = max(norm2(whole%q - halved%q), norm2(whole%p - halved%p)/norm2(item%start%p)) <= error_of_steps
   end function steps_are_good

end module test_path_case
