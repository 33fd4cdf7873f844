!> Tangent columns of the free numbers of a scene: by the chain rule each is the change of start, body and effects that
!> a unit of the number makes.
!>
!> What the scene computes at its start (the inertia of a shape, the attitude of Euler angles) is differentiated there
!> by five-point differences, the motion never: its derivative is the exact one of the method.
module nutate_fit_columns
   use nutate_attitude, only: rotation_vector_from_quat
   use nutate_body, only: whole_body
   use nutate_column, only: column_t
   use nutate_hamiltonian, only: angular_velocity
   use nutate_kinds, only: wp, pi
   use nutate_quaternion, only: quat_conjugate, quat_product
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: add_scene, add_key, places, weights

   !> Five-point differences, which are exact for polynomials of degree 4: places in steps, and weights times the step.
   integer, parameter :: places(4) = [-2, -1, 1, 2]
   real(wp), parameter :: weights(4) = [1.0_wp, -8.0_wp, 8.0_wp, -1.0_wp]/12

contains

   !> Adds what a scene beside the present one contributes to the differences of start and body.
   subroutine add_scene(group, present_scene, scene, weight, column)
      !> Name of the group of the number; blank for the attitude.
      character(len=*), intent(in) :: group
      type(scene_t), intent(in) :: present_scene, scene
      real(wp), intent(in) :: weight
      type(column_t), intent(inout) :: column
      select case (group)
      case ('body')
         associate (body => whole_body(scene%system%body))
            column%inertia = column%inertia + weight*body%inertia
            column%mass_moment = column%mass_moment + weight*body%mass*body%center_of_mass
         end associate
      case ('rotor')
         column%rotor = column%rotor + weight*scene%system%effects%rotor_momentum
      case default
         if (group == 'rotating_frame') column%frame = column%frame + weight*scene%system%effects%frame_rate
         column%attitude = column%attitude + weight*rotation_vector_from_quat( &
                           quat_product(quat_conjugate(present_scene%initial%q), scene%initial%q))
         column%angular_velocity = column%angular_velocity + weight*angular_velocity(scene%system, scene%initial)
      end select
   end subroutine add_scene

   !> Adds a number of an effect. Errors: `NUTATE_BAD_ARGUMENT` where the effect has no derivative by it.
   subroutine add_key(scene, group, key, value, numbers, name, column, status)
      type(scene_t), intent(in) :: scene
      !> Place of the group among those of the scene.
      integer, intent(in) :: group
      character(len=*), intent(in) :: key
      !> Which number of how many.
      integer, intent(in) :: value, numbers
      !> Of the free number, for messages.
      character(len=*), intent(in) :: name
      type(column_t), intent(inout) :: column
      type(status_t), intent(out) :: status
      real(wp) :: change(numbers)
      change = 0.0_wp
      change(value) = 1.0_wp
      if (key == 'epoch_angle' .and. scene%groups(group)%flag('degrees', .false.)) change = change*pi/180
      associate (kind => scene%groups(group)%name)
         call column%add(scene%system%effects, trim(kind), count(scene%groups(:group)%name == kind), trim(key), &
            change, &
                         status)
      end associate
      if (.not. status%ok()) status = fail(NUTATE_BAD_ARGUMENT, 'the motion has no derivative by '//trim(name)// &
                                           ': '//trim(status%message))
   end subroutine add_key

end module nutate_fit_columns
