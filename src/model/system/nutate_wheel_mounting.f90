!> Wheels as a part of the body that they are mounted in: the rest of the body has less inertia about their axes.
module nutate_wheel_mounting
   use nutate_body, only: body_t, without
   use nutate_inner_sphere, only: inner_sphere_t
   use nutate_kinds, only: wp
   use nutate_limits, only: most_inner, most_spheres, most_wheels
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_system, only: system_t
   use nutate_wheel, only: wheel_t
   implicit none
   private

   public :: add_wheel, add_inner_sphere, mount_wheels, are_mounted

contains

   !> Adds a wheel to a system whose body was given with the wheel locked; from then on `system%body` is the body
   !> without the inertia of the wheel about its axis. Effects that depend on the body use the whole one (`whole_body`).
   !>
   !> Errors, with the system unchanged: `NUTATE_BAD_ARGUMENT` for too many wheels, or an invalid one; `NUTATE_BAD_BODY`
   !> if the wheels have more inertia than the body with them.
   subroutine add_wheel(system, wheel, status)
      type(system_t), intent(inout) :: system
      type(wheel_t), intent(in) :: wheel
      type(status_t), intent(out) :: status
      type(system_t) :: grown
      if (.not. wheel%is_valid()) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the wheel is invalid (expected a unit vector as its axis, a positive '// &
                       'inertia and friction >= 0, all up to 1e100 in SI units)', 'wheel')
      else
         grown = system
         call grown%effects%add(wheel)
         call mount_wheels(grown, status)
         if (status%ok()) system = grown
      end if
   end subroutine add_wheel

   !> Adds an inner sphere to a system; the body is the one without the sphere.
   !>
   !> Errors, with the system unchanged: `NUTATE_BAD_ARGUMENT` for too many spheres, or an invalid one.
   subroutine add_inner_sphere(system, sphere, status)
      type(system_t), intent(inout) :: system
      type(inner_sphere_t), intent(in) :: sphere
      type(status_t), intent(out) :: status
      type(system_t) :: grown
      if (.not. sphere%is_valid()) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the inner sphere is invalid (expected a positive inertia and damping, '// &
                       'all up to 1e100 in SI units)', 'inner_sphere')
      else
         grown = system
         call grown%effects%add(sphere)
         call check_numbers(grown, status)
         if (status%ok()) system = grown
      end if
   end subroutine add_inner_sphere

   !> Rejects a body with more wheels and inner spheres than a state has room for.
   pure subroutine check_numbers(system, status)
      type(system_t), intent(in) :: system
      type(status_t), intent(out) :: status
      character(len=4) :: most
      if (system%effects%n_spheres > most_spheres) then
         write (most, '(i0)') most_spheres
         status = fail(NUTATE_BAD_ARGUMENT, 'there are too many inner spheres (expected up to '//trim(most)//')', &
                       'inner_sphere')
      else if (system%effects%n_reaction_wheels > most_wheels) then
         write (most, '(i0)') most_wheels
         status = fail(NUTATE_BAD_ARGUMENT, 'there are too many wheels (expected up to '//trim(most)//')', 'wheel')
      else if (system%effects%n_wheels > most_inner) then
         write (most, '(i0)') most_inner
         status = fail(NUTATE_BAD_ARGUMENT, 'there are too many wheels and inner spheres (expected up to '// &
                       trim(most)//', a sphere as three)', 'inner_sphere')
      end if
   end subroutine check_numbers

   !> Subtracts the inertia of all wheels of a system from that of its body. Errors, with the system unchanged: as for
   !> `add_wheel`, and for too many inner spheres.
   subroutine mount_wheels(system, status)
      type(system_t), intent(inout) :: system
      type(status_t), intent(out) :: status
      type(body_t) :: rest
      call check_numbers(system, status)
      if (.not. status%ok() .or. system%effects%n_reaction_wheels == 0) return
      call without(system%body, spinning_inertia(system), rest, status)
      if (status%ok()) system%body = rest
   end subroutine mount_wheels

   !> Returns Σ Jw ssᵀ of the reaction wheels, body axes, kg m²; shape (3,3).
   pure function spinning_inertia(system) result(inertia)
      type(system_t), intent(in) :: system
      real(wp) :: inertia(3, 3)
      integer :: i, k
      inertia = 0.0_wp
      do i = 1, system%effects%n_reaction_wheels
         associate (wheel => system%effects%wheels(i))
            do k = 1, 3
               inertia(:, k) = inertia(:, k) + wheel%inertia*(wheel%axis*wheel%axis(k))
            end do
         end associate
      end do
   end function spinning_inertia

   !> Returns true if the inertia of all wheels of a system has been subtracted from its body, as every method requires.
   pure logical function are_mounted(system)
      type(system_t), intent(in) :: system
      type(body_t) :: rest
      type(status_t) :: status
      call check_numbers(system, status)
      are_mounted = status%ok()
      if (.not. are_mounted .or. system%effects%n_reaction_wheels == 0) return
      call without(system%body, spinning_inertia(system), rest, status)
      are_mounted = status%ok()
      if (are_mounted) are_mounted = .not. any(abs(rest%inertia - system%body%inertia) > 0.0_wp)
   end function are_mounted

end module nutate_wheel_mounting
