!> Controllers of a system: controllers that act by its wheels distribute their torque over the motors.
module nutate_controller_mounting
   use nutate_kinds, only: wp
   use nutate_lapack, only: symmetric_eigen
   use nutate_controlled_motor, only: controlled_motor_t
   use nutate_control_law, only: BY_MAGNETORQUERS, BY_TORQUE, BY_WHEELS, DETUMBLING, POINTING
   use nutate_controller, only: controller_t
   use nutate_earth_field, only: earth_field_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_system, only: system_t
   implicit none
   private

   public :: add_controller

   !> Least eigenvalue of SSᵀ, over the largest, of a direction along which the wheels can act.
   real(wp), parameter :: nearly_flat = 1e-10_wp

contains

   !> Adds a controller to a system, after all wheels that it uses. A continuous controller of wheels becomes their
   !> motors.
   !>
   !> Errors, with the system unchanged: `NUTATE_BAD_ARGUMENT` for an invalid controller, or one whose `by` or `law` is
   !> unknown; for a controller of wheels in a system without wheels, or with a wheel that has a motor; for a controller
   !> that uses the field of the Earth, or the LVLH frame, in a system without them.
   subroutine add_controller(system, controller, status)
      type(system_t), intent(inout) :: system
      type(controller_t), intent(in) :: controller
      type(status_t), intent(out) :: status
      type(controller_t) :: mounted
      integer :: i
      mounted = controller
      if (controller%follows_earth) then
         if (.not. system%effects%in_earth_field) then
            status = fail(NUTATE_BAD_ARGUMENT, &
                          'the magnetorquers of a controller have no field (expected field in it, or '// &
                          '&earth_field)', 'law')
            return
         end if
         select type (effect => system%effects%earth_field)
         type is (earth_field_t)
            call mounted%follow(effect%field())
         end select
      end if
      if (controller%follows_orbit) then
         if (.not. system%effects%on_orbit) then
            status = fail(NUTATE_BAD_ARGUMENT, "target_from = 'lvlh' without an orbit "// &
                          '(expected &orbit)', 'target_from')
            return
         end if
         call mounted%follow_orbit(system%effects%orbit)
      end if
      if (all(controller%by /= [BY_TORQUE, BY_WHEELS, BY_MAGNETORQUERS]) .or. &
          all(controller%law /= [POINTING, DETUMBLING])) then
         status = fail(NUTATE_BAD_ARGUMENT, 'by or law of the controller is unknown (expected BY_TORQUE, '// &
                       'BY_WHEELS or BY_MAGNETORQUERS, and POINTING or DETUMBLING)', 'controller')
         return
      end if
      if (.not. mounted%is_valid() .or. (controller%law == DETUMBLING .and. controller%by /= BY_MAGNETORQUERS)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the controller is invalid (expected a unit quaternion as its target, '// &
                       'finite gains up to 1e100 in SI units, magnetorquers to detumble)', 'controller')
         return
      end if
      if (controller%by == BY_WHEELS) call check_wheels(system, controller, status)
      if (.not. status%ok()) return
      if (controller%by == BY_WHEELS) call share_torque(system, mounted, status)
      if (.not. status%ok()) return
      call system%effects%add(mounted)
      if (controller%by /= BY_WHEELS .or. controller%sample > 0.0_wp) return
      do i = 1, system%effects%n_reaction_wheels
         allocate (system%effects%wheels(i)%motor, &
                   source=controlled_motor_t(name='controller', label=controller%label, on=controller%on, &
                                            controller=mounted, wheel=i, &
                                            limit=system%effects%wheels(i)%torque_limit))
      end do
   end subroutine add_controller

   !> Checks the wheels of a system. Errors: `NUTATE_BAD_ARGUMENT` for wheels that a controller cannot act by.
   subroutine check_wheels(system, controller, status)
      type(system_t), intent(in) :: system
      type(controller_t), intent(in) :: controller
      type(status_t), intent(inout) :: status
      integer :: i
      if (system%effects%n_reaction_wheels == 0) then
         status = fail(NUTATE_BAD_ARGUMENT, "by = 'wheels' without wheels (expected &wheel)", 'by')
         return
      end if
      do i = 1, system%effects%n_reaction_wheels
         associate (wheel => system%effects%wheels(i))
            if (allocated(wheel%motor)) then
               status = fail(NUTATE_BAD_ARGUMENT, &
                             'a controller by wheels, and one has a motor of its own (expected '// &
                             'neither torque nor table in &wheel, nor another controller by wheels without '// &
                             'sample)', 'by')
            end if
         end associate
      end do
   end subroutine check_wheels

   !> Computes u = -S⁺τ, S the axes as columns, S⁺ = Sᵀ(SSᵀ)⁺: the part of τ along no axis is left out. Errors: those of
   !> LAPACK.
   subroutine share_torque(system, controller, status)
      type(system_t), intent(in) :: system
      type(controller_t), intent(inout) :: controller
      type(status_t), intent(inout) :: status
      real(wp) :: square(3, 3), values(3), vectors(3, 3)
      integer :: i, k
      square = 0.0_wp
      do i = 1, system%effects%n_reaction_wheels
         associate (axis => system%effects%wheels(i)%axis)
            do k = 1, 3
               square(:, k) = square(:, k) + axis(k)*axis
            end do
         end associate
      end do
      call symmetric_eigen(square, values, vectors, status)
      if (.not. status%ok()) return
      controller%share = 0.0_wp
      do i = 1, system%effects%n_reaction_wheels
         associate (axis => system%effects%wheels(i)%axis)
            do k = 1, 3
               if (values(k) > nearly_flat*values(3)) controller%share(:, i) = controller%share(:, i) &
                  - (dot_product(vectors(:, k), axis)/values(k))*vectors(:, k)
            end do
         end associate
      end do
   end subroutine share_torque

end module nutate_controller_mounting
