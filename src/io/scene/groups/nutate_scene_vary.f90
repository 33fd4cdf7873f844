!> `&vary`: numbers of the scene that differ from member to member of an ensemble, and how.
module nutate_scene_vary
   use nutate_admissible, only: NON_NEGATIVE, POSITIVE
   use nutate_ensemble_plan, only: ensemble_plan_t, varied_key_t, GRID, NORMAL, ROTATION, UNIFORM
   use nutate_keys, only: group_t, group_kind_t, key_t, name_length, KEY_INTEGER, KEY_TEXT
   use nutate_kinds, only: wp
   use nutate_printable, only: quoted
   use nutate_scene_error, only: scene_error_t, allow_one_of, demand_one_of
   use nutate_scene_target, only: add_targets
   use nutate_spelling, only: count_text, is_listed
   implicit none
   private

   public :: vary_keys, build_variation

   !> Maximum numbers of keys, and of numbers, that are drawn together.
   integer, parameter :: most_keys = 8, most_numbers = 24
   !> Keys of the parameters of distributions; those that belong to each distribution.
   character(len=name_length), parameter :: parameters(6) = [character(len=name_length) :: &
                                               'low', 'high', 'mean', 'sigma', 'covariance', 'points']
   character(len=24), parameter :: belongs_to(4) = [character(len=24) :: &
                                                    'low,high', 'mean,sigma,covariance', ' ', 'low,high,points']
   !> Tolerance of the symmetry and the positive semidefiniteness of a covariance, relative to its diagonal, for numbers
   !> typed with few digits.
   real(wp), parameter :: tolerance = 1e-9_wp

contains

   !> Keys of the scene group `&vary`.
   pure function vary_keys() result(keys)
      type(key_t) :: keys(8)
      keys = [key_t(name='key', kind=KEY_TEXT, most=most_keys, required=.true.), &
              key_t(name='distribution', kind=KEY_TEXT, required=.true., choices='uniform,normal,rotation,grid'), &
              key_t(name='low', most=most_numbers), &
              key_t(name='high', most=most_numbers), &
              key_t(name='mean', most=most_numbers), &
              key_t(name='sigma', most=most_numbers, range=NON_NEGATIVE), &
              key_t(name='covariance', most=most_numbers**2), &
              key_t(name='points', kind=KEY_INTEGER, most=most_numbers, range=POSITIVE)]
   end function vary_keys

   !> Adds the variation of a group to a plan.
   subroutine build_variation(group, groups, kinds, plan, error)
      type(group_t), intent(in) :: group
      !> Groups of the scene.
      type(group_t), intent(in) :: groups(:)
      type(group_kind_t), intent(in) :: kinds(:)
      type(ensemble_plan_t), intent(inout) :: plan
      type(scene_error_t), intent(inout) :: error
      type(varied_key_t) :: variation
      integer :: i, n

      variation%first = size(plan%targets) + 1
      do i = 1, group%count_of('key')
         call add_targets(group%text_at('key', i), group%line_of('key'), 'varied', kinds, plan, n, error)
         if (error%raised) return
         variation%n = variation%n + n
      end do
      select case (group%text('distribution', 'uniform'))
      case ('normal')
         variation%distribution = NORMAL
      case ('rotation')
         variation%distribution = ROTATION
      case ('grid')
         variation%distribution = GRID
      case default
         variation%distribution = UNIFORM
      end select
      call check_parameters()
      if (error%raised) return
      select case (variation%distribution)
      case (NORMAL)
         call read_normal()
      case (ROTATION)
         if (variation%n /= 4) call error%raise(group%line_of('key'), 'a rotation is a quaternion', &
                                                expected='a key of 4 numbers')
      case default
         call read_bounds()
      end select
      if (.not. error%raised) plan%variations = [plan%variations, variation]

   contains

      !> Raises an error for parameters that do not belong to the distribution, or have the wrong number of values.
      subroutine check_parameters()
         character(len=:), allocatable :: name
         integer :: i, expected
         logical :: fits
         do i = 1, size(parameters)
            name = trim(parameters(i))
            if (.not. group%has(name)) cycle
            if (.not. is_listed(name, trim(belongs_to(variation%distribution)))) then
               call error%raise(group%line_of(name), name//" with the distribution '"// &
                                trim(group%text('distribution', ''))//"'", expected='keys of this distribution')
               return
            end if
            expected = variation%n
            if (name == 'covariance') expected = expected**2
            fits = group%count_of(name) == expected .or. (name == 'points' .and. group%count_of(name) == 1)
            if (.not. fits) then
               call error%raise(group%line_of(name), name//' has the wrong number of values', &
                                expected=count_text(expected))
               return
            end if
         end do
      end subroutine check_parameters

      !> Reads the bounds of a uniform distribution or of a grid.
      subroutine read_bounds()
         real(wp) :: points(variation%n)
         call demand_one_of(group, [character(len=name_length) :: 'low'], error)
         call demand_one_of(group, [character(len=name_length) :: 'high'], error)
         if (variation%distribution == GRID) call demand_one_of(group, [character(len=name_length) :: 'points'], error)
         if (error%raised) return
         points = 0.0_wp
         variation%low = group%vector('low', points)
         variation%high = group%vector('high', points)
         if (any(variation%low > variation%high)) &
            call error%raise(group%line_of('high'), 'high is below low', expected='bounds in their order')
         if (variation%distribution /= GRID) return
         if (group%count_of('points') == 1) then
            points = group%whole('points', 1)
         else
            points = group%vector('points', points)
         end if
         variation%points = nint(points)
      end subroutine read_bounds

      !> Reads mean and covariance. The mean is the value of the scene if the group gives none.
      subroutine read_normal()
         real(wp) :: covariance(variation%n, variation%n), numbers(variation%n)
         integer :: i

         call allow_one_of(group, [character(len=name_length) :: 'sigma', 'covariance'], error)
         call demand_one_of(group, [character(len=name_length) :: 'sigma', 'covariance'], error)
         if (error%raised) return
         do i = 1, variation%n
            associate (target => plan%targets(variation%first + i - 1))
               if (.not. (group%has('mean') .or. groups(target%group)%has(trim(target%key%name)))) &
                  call error%raise(group%line_of('key'), 'the scene has no '//quoted(trim(target%name))// &
                                   ' that could be the mean', expected='mean, or the key in its group')
               numbers(i) = plan%groups(target%group)%settings(target%setting)%values(target%value)%number
            end associate
         end do
         variation%low = group%vector('mean', numbers)
         allocate (variation%factor(variation%n, variation%n), source=0.0_wp)
         if (group%has('sigma')) then
            numbers = group%vector('sigma', numbers)
            do i = 1, variation%n
               variation%factor(i, i) = numbers(i)
            end do
         else
            covariance = reshape(group%vector('covariance', spread(0.0_wp, 1, variation%n**2)), shape(covariance))
            call find_factor(covariance, variation%factor, i)
            if (i > 0) call error%raise(group%line_of('covariance'), 'covariance is invalid', &
                                        expected='a symmetric matrix, row by row, positive semidefinite')
         end if
      end subroutine read_normal

   end subroutine build_variation

   !> Computes the lower triangle L of a covariance L Lᵀ, by Cholesky; columns without variance of their own are zero.
   pure subroutine find_factor(covariance, factor, fault)
      !> Shape (n, n).
      real(wp), intent(in) :: covariance(:, :)
      real(wp), intent(inout) :: factor(:, :)
      !> Row at fault; 0: none.
      integer, intent(out) :: fault
      real(wp) :: rest, scale
      integer :: i, j
      fault = 0
      do j = 1, size(covariance, 1)
         rest = covariance(j, j) - sum(factor(j, :j - 1)**2)
         if (rest < -tolerance*abs(covariance(j, j)) .or. covariance(j, j) < 0.0_wp) fault = j
         if (rest > tolerance*covariance(j, j)) factor(j, j) = sqrt(rest)
         do i = j + 1, size(covariance, 1)
            scale = sqrt(abs(covariance(i, i)))*sqrt(abs(covariance(j, j)))
            if (abs(covariance(i, j) - covariance(j, i)) > tolerance*scale) fault = i
            rest = covariance(i, j) - sum(factor(i, :j - 1)*factor(j, :j - 1))
            if (factor(j, j) > 0.0_wp) then
               factor(i, j) = rest/factor(j, j)
            else if (abs(rest) > sqrt(tolerance)*scale) then
               fault = i
            end if
         end do
         if (fault > 0) return
      end do
   end subroutine find_factor

end module nutate_scene_vary
