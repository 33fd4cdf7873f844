!> The scene group `&controller`.
module nutate_controller_group
   use nutate_admissible, only: ANY_DIRECTION, NON_NEGATIVE, POSITIVE
   use nutate_body, only: body_t, diagonal, make_body, symmetric
   use nutate_effect, only: effect_t
   use nutate_keys, only: group_t, key_t, KEY_TEXT
   use nutate_kinds, only: wp
   use nutate_limits, only: attitude_tolerance, is_unit
   use nutate_quaternion, only: quat_normalized
   use nutate_control_law, only: BY_MAGNETORQUERS, BY_TORQUE, BY_WHEELS, DETUMBLING
   use nutate_controller, only: controller_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: controller_keys, build_controller, gain_changes

   !> Keys of the scene group `&controller`.
   type(key_t), parameter :: controller_keys(16) = [ &
      key_t(name='law', kind=KEY_TEXT, choices='quaternion,bdot', required=.true.), &
      key_t(name='by', kind=KEY_TEXT, choices='torque,wheels,magnetorquers'), &
      key_t(name='target', least=4, most=4), &
      key_t(name='target_from', kind=KEY_TEXT, choices='space,lvlh'), &
      key_t(name='attitude_gain', range=NON_NEGATIVE, instead_of='attitude_gain_matrix'), &
      key_t(name='rate_gain', range=NON_NEGATIVE, instead_of='rate_gain_matrix'), &
      key_t(name='gains', kind=KEY_TEXT, choices='inertia,scalar'), &
      key_t(name='inertia', least=3, most=6), &
      key_t(name='attitude_gain_matrix', least=3, most=9, instead_of='attitude_gain'), &
      key_t(name='rate_gain_matrix', least=3, most=9, instead_of='rate_gain'), &
      key_t(name='gain', range=NON_NEGATIVE), &
      key_t(name='field', least=3, most=3, range=ANY_DIRECTION), &
      key_t(name='sample', range=POSITIVE), &
      key_t(name='limit', range=POSITIVE), &
      key_t(name='start'), &
      key_t(name='stop')]

contains

   !> Builds a controller from its scene group. Magnetorquers without a field follow the field of the Earth, which
   !> `add_controller` sets.
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT` for a key that the law does not have, or misses; a target that is no unit
   !> quaternion; an empty window. `NUTATE_BAD_BODY` for an inertia that no body has.
   subroutine build_controller(group, body, effect, status)
      type(group_t), intent(in) :: group
      !> Body with its wheels locked; in an ensemble the body of the scene before variation, for which the controller is
      !> designed.
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      type(controller_t) :: controller
      call check_keys(group, status)
      if (.not. status%ok()) return
      controller%name = 'controller'
      controller%field = group%vector('field', controller%field)
      controller%follows_earth = .not. group%has('field') .and. &
                                (group%text('law', '') == 'bdot' .or. group%text('by', '') == 'magnetorquers')
      controller%sample = group%number('sample', controller%sample)
      controller%limit = group%number('limit', controller%limit)
      controller%start = group%number('start', controller%start)
      controller%stop = group%number('stop', controller%stop)
      if (.not. controller%stop > controller%start) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the controller stops before it starts (expected stop > start)', 'stop')
      else if (group%text('law', '') == 'bdot') then
         controller%law = DETUMBLING
         controller%by = BY_MAGNETORQUERS
         controller%gain = group%number('gain', 0.0_wp)
      else
         call set_pointing(group, body, controller, status)
      end if
      if (status%ok()) allocate (effect, source=controller)
   end subroutine build_controller

   !> Sets target, gains and actuators. Errors: `NUTATE_BAD_ARGUMENT` for a target that is no unit quaternion.
   subroutine set_pointing(group, body, controller, status)
      type(group_t), intent(in) :: group
      type(body_t), intent(in) :: body
      type(controller_t), intent(inout) :: controller
      type(status_t), intent(inout) :: status
      select case (group%text('by', 'torque'))
      case ('wheels')
         controller%by = BY_WHEELS
      case ('magnetorquers')
         controller%by = BY_MAGNETORQUERS
      case default
         controller%by = BY_TORQUE
      end select
      controller%target = group%vector('target', controller%target)
      if (.not. is_unit(controller%target, attitude_tolerance)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the target is not a unit quaternion '// &
                       '(expected a norm of 1 to within 1e-6)', 'target')
         return
      end if
      controller%target = quat_normalized(controller%target)
      controller%follows_orbit = group%text('target_from', 'space') == 'lvlh'
      call set_gains(group, body%inertia, controller, status)
   end subroutine set_pointing

   !> Sets K and D: matrices as given, or gains times the inertia or the unit matrix. Errors: `NUTATE_BAD_BODY` for a
   !> given inertia that no body has.
   subroutine set_gains(group, inertia, controller, status)
      type(group_t), intent(in) :: group
      !> Inertia used if the group gives none, kg m²; shape (3,3).
      real(wp), intent(in) :: inertia(3, 3)
      type(controller_t), intent(inout) :: controller
      type(status_t), intent(inout) :: status
      type(body_t) :: nominal
      real(wp) :: unit(3, 3)
      if (group%has('inertia')) then
         ! Only moments and tensor are checked: idealised bodies break the triangle rule.
         call make_body(matrix_of(group, 'inertia'), nominal, status, check_triangle=.false.)
         if (.not. status%ok()) return
      end if
      unit = unit_of(group, inertia)
      controller%attitude_gain = group%number('attitude_gain', 0.0_wp)*unit
      if (group%has('attitude_gain_matrix')) controller%attitude_gain = matrix_of(group, 'attitude_gain_matrix')
      controller%rate_gain = group%number('rate_gain', 0.0_wp)*unit
      if (group%has('rate_gain_matrix')) controller%rate_gain = matrix_of(group, 'rate_gain_matrix')
   end subroutine set_gains

   !> Returns the matrix by which gains are multiplied, the inertia or the unit matrix; shape (3,3).
   pure function unit_of(group, inertia) result(unit)
      type(group_t), intent(in) :: group
      real(wp), intent(in) :: inertia(3, 3)
      real(wp) :: unit(3, 3)
      unit = inertia
      if (group%has('inertia')) unit = matrix_of(group, 'inertia')
      if (group%text('gains', 'inertia') == 'scalar') unit = diagonal([1.0_wp, 1.0_wp, 1.0_wp])
   end function unit_of

   !> Returns the change of K and D, column by column, by a change of a key; zero for a key on which they do not depend.
   pure subroutine gain_changes(group, inertia, key, change, of_attitude, of_rate)
      type(group_t), intent(in) :: group
      !> Inertia as in `set_gains`, kg m²; shape (3,3).
      real(wp), intent(in) :: inertia(3, 3)
      character(len=*), intent(in) :: key
      !> Change of the numbers of the key.
      real(wp), intent(in) :: change(:)
      real(wp), intent(out) :: of_attitude(9), of_rate(9)
      of_attitude = 0.0_wp
      of_rate = 0.0_wp
      select case (key)
      case ('attitude_gain')
         of_attitude = change(1)*reshape(unit_of(group, inertia), [9])
      case ('rate_gain')
         of_rate = change(1)*reshape(unit_of(group, inertia), [9])
      case ('attitude_gain_matrix')
         of_attitude = reshape(matrix_from(change), [9])
      case ('rate_gain_matrix')
         of_rate = reshape(matrix_from(change), [9])
      case ('inertia')
         of_attitude = group%number('attitude_gain', 0.0_wp)*reshape(matrix_from(change), [9])
         of_rate = group%number('rate_gain', 0.0_wp)*reshape(matrix_from(change), [9])
      case default
         continue
      end select
   end subroutine gain_changes

   !> Returns the matrix of three numbers (its diagonal), six (a symmetric one: 11, 22, 33, 12, 13, 23) or nine (row by
   !> row).
   pure function matrix_of(group, key) result(matrix)
      type(group_t), intent(in) :: group
      !> Key that is present, with three, six or nine numbers.
      character(len=*), intent(in) :: key
      real(wp) :: matrix(3, 3), numbers(9)
      integer :: n
      n = group%count_of(key)
      numbers = 0.0_wp
      numbers(1:n) = group%vector(key, numbers(1:n))
      matrix = matrix_from(numbers(1:n))
   end function matrix_of

   pure function matrix_from(numbers) result(matrix)
      !> Three, six or nine numbers; shape (3), (6) or (9).
      real(wp), intent(in) :: numbers(:)
      real(wp) :: matrix(3, 3)
      select case (size(numbers))
      case (3)
         matrix = diagonal(numbers(1:3))
      case (6)
         matrix = symmetric(numbers(1:6))
      case default
         matrix = transpose(reshape(numbers(1:9), [3, 3]))
      end select
   end function matrix_from

   !> Checks the keys of a group. Errors: `NUTATE_BAD_ARGUMENT` for a key that the law does not have, or misses.
   subroutine check_keys(group, status)
      type(group_t), intent(in) :: group
      type(status_t), intent(out) :: status
      character(len=20), parameter :: of_pointing(9) = [character(len=20) :: &
                                                        'by', 'target', 'target_from', 'attitude_gain', 'rate_gain', &
                                                        'gains', 'inertia', 'attitude_gain_matrix', 'rate_gain_matrix']
      integer :: i
      if (group%text('law', '') == 'bdot') then
         do i = 1, size(of_pointing)
            if (group%has(trim(of_pointing(i)))) &
               call refuse(of_pointing(i), " with the law 'bdot' (expected gain and field; it acts by magnetorquers)")
         end do
         if (status%ok() .and. .not. group%has('gain')) &
            status = fail(NUTATE_BAD_ARGUMENT, 'the controller needs gain')
      else
         if (group%has('gain')) call refuse('gain', " with the law 'quaternion' (expected attitude_gain and rate_gain)")
         call check_gains(group, status)
         if (group%text('by', 'torque') /= 'magnetorquers' .and. group%has('field')) &
            call refuse('field', " without magnetorquers (expected by = 'magnetorquers' with it)")
      end if
      if (group%has('limit') .and. group%text('by', '') == 'wheels') &
         call refuse('limit', ' with wheels (expected torque_limit in &wheel)')

   contains

      subroutine refuse(key, words)
         character(len=*), intent(in) :: key, words
         if (status%ok()) status = fail(NUTATE_BAD_ARGUMENT, trim(key)//words, key)
      end subroutine refuse

   end subroutine check_keys

   !> Checks the gains of a group. Errors: `NUTATE_BAD_ARGUMENT` for gains that are missing, or given twice; for
   !> matrices of other counts; for keys that these gains do not use.
   subroutine check_gains(group, status)
      type(group_t), intent(in) :: group
      type(status_t), intent(inout) :: status
      logical :: matrices
      matrices = .not. (group%has('attitude_gain') .or. group%has('rate_gain'))
      call check_gain('attitude_gain', 'attitude_gain_matrix')
      call check_gain('rate_gain', 'rate_gain_matrix')
      if (all(group%count_of('inertia') /= [0, 3, 6])) &
         call refuse('inertia has the wrong number of values (expected 3 or 6 numbers)', 'inertia')
      if (group%has('gains') .and. matrices) &
         call refuse('gains has no effect on gain matrices (expected attitude_gain or rate_gain)', 'gains')
      if (group%has('inertia') .and. (matrices .or. group%text('gains', 'inertia') == 'scalar')) &
         call refuse('inertia has no effect on these gains '// &
                     "(expected attitude_gain or rate_gain, and gains = 'inertia')", 'inertia')

   contains

      subroutine check_gain(key, matrix)
         character(len=*), intent(in) :: key, matrix
         if (.not. (group%has(key) .or. group%has(matrix))) &
            call refuse('the controller needs '//key, '')
         if (group%has(key) .and. group%has(matrix)) &
            call refuse(matrix//' and '//key//' exclude each other (expected one of them)', matrix)
         if (all(group%count_of(matrix) /= [0, 3, 6, 9])) &
            call refuse(matrix//' has the wrong number of values (expected 3, 6 or 9 numbers)', matrix)
      end subroutine check_gain

      subroutine refuse(words, key)
         character(len=*), intent(in) :: words, key
         if (status%ok()) status = fail(NUTATE_BAD_ARGUMENT, words, key)
      end subroutine refuse

   end subroutine check_gains

end module nutate_controller_group
