!> Random scenes for the accuracy of runs: bodies of every shape and size, every effect, windows of torques, motions
!> that amplify what comes near them. Each number names a scene, the same everywhere.
module test_random_scenes
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: body_t, diagonal, make_body
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_gravity, only: gravity_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_kinds, only: wp
   use nutate_quaternion, only: quat_product, rotate_to_body, rotation_matrix
   use nutate_rotor, only: rotor_t
   use nutate_spring, only: spring_t
   use nutate_status, only: status_t
   use test_problems, only: make_state, problem_t
   use test_support, only: random_unit, random_unit_quaternion, random_vector
   implicit none
   private

   public :: random_scene_t, make_random_scene, make_random_body, power_of_ten

   type :: random_scene_t
      type(problem_t) :: problem
      !> End time, s.
      real(wp) :: end_time = 0.0_wp
      !> Short description of the scene.
      character(len=96) :: text = ''
   end type random_scene_t

contains

   !> The scene of a number.
   subroutine make_random_scene(number, scene)
      integer, intent(in) :: number
      type(random_scene_t), intent(inout) :: scene
      integer(int64) :: seed
      real(wp) :: rate, inertia, omega(3), q(4), turn
      integer :: i
      scene = random_scene_t()
      seed = 7919_int64*number + 104729_int64
      do i = 1, 20
         turn = random_unit(seed)
      end do
      inertia = power_of_ten(seed, -6.0_wp, 6.0_wp)
      rate = power_of_ten(seed, -1.0_wp, 1.5_wp)
      call make_random_body(seed, inertia, scene%problem%system%body, scene%text)
      turn = power_of_ten(seed, 0.7_wp, 2.2_wp)
      scene%end_time = turn/rate
      if (random_unit(seed) < 0.1_wp) scene%end_time = -scene%end_time
      if (random_unit(seed) > 0.15_wp) call add_effects(seed, inertia*rate**2, rate, scene)
      call choose_start(seed, scene%problem%system%body, rate, q, omega, scene%text)
      ! Draws are not in conditions with others: at some optimizations they would be made always.
      turn = 1.0_wp
      if (scene%problem%system%effects%n_potentials > 0) turn = random_unit(seed)
      if (turn < 0.3_wp) then
         call stand_up(scene, q)
         omega = (1e-3_wp*random_unit(seed))*omega
         scene%text = trim(scene%text)//', stands'
      end if
      scene%problem%start = make_state(scene%problem%system, q, omega)
   end subroutine make_random_scene

   !> Ten to a power that is uniform between two.
   real(wp) function power_of_ten(seed, least, most)
      integer(int64), intent(inout) :: seed
      real(wp), intent(in) :: least, most
      power_of_ten = 10.0_wp**(least + (most - least)*random_unit(seed))
   end function power_of_ten

   !> A body of a shape: general, plate, rod, symmetric, nearly so, sphere; in its principal axes or not.
   subroutine make_random_body(seed, inertia, body, text)
      integer(int64), intent(inout) :: seed
      !> kg m².
      real(wp), intent(in) :: inertia
      type(body_t), intent(out) :: body
      character(len=*), intent(inout) :: text
      character(len=9), parameter :: shapes(6) = [character(len=9) :: 'general', 'plate', 'rod', 'symmetric', &
                                                  'nearly', 'sphere']
      type(status_t) :: status
      real(wp) :: moments(3), tensor(3, 3), axes(3, 3), a, b
      integer :: shape
      shape = min(6, 1 + int(6.5_wp*random_unit(seed)))
      if (shape == 6) then
         if (random_unit(seed) < 0.5_wp) shape = 1
      end if
      a = 0.1_wp + 0.9_wp*random_unit(seed)
      b = 0.1_wp + 0.9_wp*random_unit(seed)
      select case (shape)
      case (1)
         moments = [a + b, a + 0.3_wp, b + 0.3_wp]
      case (2)
         moments = [a, b, a + b]
      case (3)
         moments = [power_of_ten(seed, -3.0_wp, -1.0_wp), 1.0_wp, 1.0_wp]
         if (random_unit(seed) < 0.5_wp) moments(2) = 1 - 0.1_wp*moments(1)
      case (4)
         moments = [1.0_wp, 1.0_wp, 0.2_wp + 1.7_wp*a]
      case (5)
         moments = [1.0_wp, 1.0_wp + power_of_ten(seed, -8.0_wp, -2.0_wp), 0.3_wp + a]
      case default
         moments = [1.0_wp, 1.0_wp, 1.0_wp]
      end select
      moments = inertia*cshift(moments, int(3*random_unit(seed)))
      tensor = diagonal(moments)
      text = trim(shapes(shape))
      if (random_unit(seed) < 0.25_wp) then
         axes = rotation_matrix(random_unit_quaternion(seed))
         tensor = matmul(axes, matmul(tensor, transpose(axes)))
         tensor = 0.5_wp*(tensor + transpose(tensor))
         text = trim(text)//' rotated'
      end if
      call make_body(tensor, body, status, mass=inertia, center_of_mass=0.5_wp*random_vector(seed), &
                     check_triangle=.false.)
      if (.not. status%ok()) error stop 'a random body is none'
   end subroutine make_random_body

   !> Effects of about the body's own energy, some of them weak or strong.
   subroutine add_effects(seed, energy, rate, scene)
      integer(int64), intent(inout) :: seed
      !> J, and rad/s.
      real(wp), intent(in) :: energy, rate
      type(random_scene_t), intent(inout) :: scene
      type(applied_torque_t) :: torque
      real(wp) :: force, window(2), moment
      integer :: i
      associate (effects => scene%problem%system%effects, body => scene%problem%system%body)
         force = energy*power_of_ten(seed, -1.5_wp, 0.5_wp)
         if (random_unit(seed) < 0.5_wp) then
            call effects%add(gravity_t(body, (force/body%mass)*random_vector(seed)))
            scene%text = trim(scene%text)//', gravity'
         end if
         if (random_unit(seed) < 0.15_wp) then
            call effects%add(dipole_t(force*random_vector(seed), random_vector(seed)))
            scene%text = trim(scene%text)//', dipole'
         end if
         if (random_unit(seed) < 0.15_wp) then
            call effects%add(gravity_gradient_t(body, random_vector(seed), power_of_ten(seed, -2.0_wp, 0.0_wp)*rate**2))
            scene%text = trim(scene%text)//', gradient'
         end if
         if (random_unit(seed) < 0.2_wp) then
            call effects%add(spring_t(random_vector(seed), 2*random_vector(seed), force, random_unit(seed)))
            scene%text = trim(scene%text)//', spring'
         end if
         if (random_unit(seed) < 0.2_wp) then
            moment = maxval(body%moments)*abs(1/scene%end_time)*power_of_ten(seed, -1.0_wp, 0.5_wp)
            call effects%add(damping_t(moment*abs(random_vector(seed))))
            scene%text = trim(scene%text)//', damping'
         end if
         if (random_unit(seed) < 0.15_wp) then
            call effects%add(rotor_t(name='rotor', momentum=maxval(body%moments)*rate*random_vector(seed)))
            scene%text = trim(scene%text)//', rotor'
         end if
         do i = 1, 2
            if (random_unit(seed) > 0.2_wp) cycle
            torque = applied_torque_t(name='torque', amplitude=0.3_wp*force*random_vector(seed), &
                                      in_space=random_unit(seed) < 0.5_wp, frequency=0.3_wp*rate*random_unit(seed), &
                                      phase=random_unit(seed))
            window = scene%end_time*[random_unit(seed), random_unit(seed)]
            if (random_unit(seed) < 0.5_wp) torque%start = minval(window)
            if (random_unit(seed) < 0.5_wp) torque%stop = maxval(window)
            call effects%add(torque)
            scene%text = trim(scene%text)//', torque'
         end do
      end associate
   end subroutine add_effects

   !> Any attitude; rotation about any axis, near a principal axis, the intermediate one among them, or exactly about
   !> one.
   subroutine choose_start(seed, body, rate, q, omega, text)
      integer(int64), intent(inout) :: seed
      type(body_t), intent(in) :: body
      real(wp), intent(in) :: rate
      real(wp), intent(out) :: q(4), omega(3)
      character(len=*), intent(inout) :: text
      real(wp) :: axis(3), chance
      q = random_unit_quaternion(seed)
      axis = random_vector(seed)
      chance = random_unit(seed)
      if (chance < 0.2_wp) then
         axis = body%axes(:, intermediate(body%moments)) + power_of_ten(seed, -8.0_wp, -1.0_wp)*axis
         text = trim(text)//', near the middle axis'
      else if (chance < 0.3_wp) then
         axis = body%axes(:, 1 + int(3*random_unit(seed))) + power_of_ten(seed, -8.0_wp, -1.0_wp)*axis
         text = trim(text)//', near an axis'
      else if (chance < 0.4_wp) then
         axis = body%axes(:, 1 + int(3*random_unit(seed)))
         text = trim(text)//', about an axis'
      end if
      omega = rate*axis/norm2(axis)
      if (random_unit(seed) < 0.04_wp) then
         omega = 0.0_wp
         text = trim(text)//', at rest'
      end if
   end subroutine choose_start

   !> The axis of the moment that is neither the largest nor the smallest.
   pure integer function intermediate(moments)
      real(wp), intent(in) :: moments(3)
      intermediate = 6 - maxloc(moments, 1) - minloc(moments, 1, back=.true.)
      if (maxloc(moments, 1) == minloc(moments, 1, back=.true.)) intermediate = 1
   end function intermediate

   !> Turns the body so that the first potential's torque all but vanishes and its energy is largest: the mass above the
   !> point of support, to a thousandth.
   subroutine stand_up(scene, q)
      type(random_scene_t), intent(in) :: scene
      real(wp), intent(inout) :: q(4)
      real(wp) :: gamma(3), up(3), turn(4), c(3)
      associate (first => scene%problem%system%effects%potentials(1)%item, body => scene%problem%system%body)
         c = body%center_of_mass
         if (.not. norm2(c)*norm2(first%direction) > 0.0_wp) return
         gamma = rotate_to_body(q, first%direction/norm2(first%direction))
         up = -c/norm2(c)
         ! The rotation that takes γ to -c: about γ×(-c).
         turn = [1 + dot_product(gamma, up), -(gamma(2)*up(3) - gamma(3)*up(2)), -(gamma(3)*up(1) - gamma(1)*up(3)), &
                 -(gamma(1)*up(2) - gamma(2)*up(1))]
         if (norm2(turn) < 1e-3_wp) return
         turn = turn/norm2(turn)
         q = quat_product(q, turn)
      end associate
   end subroutine stand_up

end module test_random_scenes
