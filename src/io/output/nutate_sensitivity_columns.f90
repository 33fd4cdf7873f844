!> The columns of a history by the free numbers of a scene: the derivatives of attitude, angular velocity and momenta of
!> wheels by each of them, and what their standard deviations come to.
!>
!> With J the derivatives of rotation vector and angular velocity and Σ the diagonal matrix of the squared standard
!> deviations, JΣJᵀ is the covariance of attitude and angular velocity, to first order.
module nutate_sensitivity_columns
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
   use nutate_kinds, only: wp
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: free_list_t, sensitivity_headers, sensitivity_values, sensitivity_width
   public :: SENSITIVITIES, DEVIATIONS, COVARIANCE

   !> The sets.
   integer, parameter :: SENSITIVITIES = 1, DEVIATIONS = 2, COVARIANCE = 3
   !> Components of attitude, a rotation vector, and of angular velocity, in body axes.
   integer, parameter :: components = 6
   !> Derivatives whose changes are beyond this have squares that are not finite.
   real(wp), parameter :: greatest_change = 1e150_wp
   character(len=*), parameter :: component_names(components) = [character(len=9) :: &
      'rotation1', 'rotation2', 'rotation3', 'omega1', 'omega2', 'omega3']

   !> The free numbers of a scene.
   type :: free_list_t
      !> `GROUP[.N].KEY[.I]`; shape (free numbers).
      character(len=80), allocatable :: names(:)
      !> Standard deviation of each, in its unit; 0: it is known. Shape (free numbers).
      real(wp), allocatable :: sigma(:)
   end type free_list_t

contains

   !> Returns the number of columns of a set.
   pure integer function sensitivity_width(set, free, n_wheels) result(width)
      !> `SENSITIVITIES`, ...
      integer, intent(in) :: set
      type(free_list_t), intent(in) :: free
      integer, intent(in) :: n_wheels
      select case (set)
      case (SENSITIVITIES)
         width = size(free%names)*(components + n_wheels)
      case (DEVIATIONS)
         width = components
      case default
         width = components*(components + 1)/2
      end select
   end function sensitivity_width

   !> Returns the names of the columns of a set, comma separated.
   pure function sensitivity_headers(set, free, n_wheels, degrees) result(names)
      !> `SENSITIVITIES`, ...
      integer, intent(in) :: set
      type(free_list_t), intent(in) :: free
      integer, intent(in) :: n_wheels
      !> Angles are in degrees.
      logical, intent(in) :: degrees
      character(len=:), allocatable :: names
      character(len=4) :: unit
      character(len=8) :: wheel
      integer :: i, k
      unit = ''
      if (degrees) unit = '_deg'
      names = ''
      select case (set)
      case (SENSITIVITIES)
         do k = 1, size(free%names)
            do i = 1, components
               names = names//',d_'//trim(component_names(i))//trim(unit)//'/d_'//trim(free%names(k))
            end do
            do i = 1, n_wheels
               write (wheel, '(i0)') i
               names = names//',d_wheel'//trim(wheel)//'_momentum/d_'//trim(free%names(k))
            end do
         end do
      case (DEVIATIONS)
         do i = 1, components
            names = names//',sigma_'//trim(component_names(i))//trim(unit)
         end do
      case default
         do i = 1, components
            do k = i, components
               names = names//',covariance_'//trim(component_names(i))//trim(unit)//'_'// &
                       trim(component_names(k))//trim(unit)
            end do
         end do
      end select
      names = names(2:)
   end function sensitivity_headers

   !> Computes the values of a set: of each free number the derivatives of the rotation vector, rad, of Ω, rad/s, both
   !> in body axes, and of the momentum of each wheel, N m s; or standard deviations of rotation vector and Ω; or the
   !> upper triangle of their covariance, by rows. They are infinite where squares would overflow.
   pure subroutine sensitivity_values(set, free, system, state, tangent, unit, values)
      !> `SENSITIVITIES`, ...
      integer, intent(in) :: set
      type(free_list_t), intent(in) :: free
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> A column for each free number.
      type(tangent_t), intent(in) :: tangent
      !> A radian in the unit of the angles.
      real(wp), intent(in) :: unit
      !> Shape (width of the set).
      real(wp), intent(out) :: values(:)
      real(wp) :: derivatives(tangent%n, components), changes(tangent%n, components)
      integer :: i, k, n, width
      derivatives(:, 1:3) = unit*tangent%theta
      derivatives(:, 4:6) = unit*tangent%rates(system, state)
      if (set == SENSITIVITIES) then
         width = components + size(tangent%wheels, 2)
         do k = 1, tangent%n
            values((k - 1)*width + 1:k*width) = [derivatives(k, :), tangent%wheels(k, :)]
         end do
         return
      end if
      values = ieee_value(1.0_wp, ieee_positive_inf)
      if (maxval(abs(derivatives)) > greatest_change/max(maxval(free%sigma), 1.0_wp)) return
      do i = 1, components
         changes(:, i) = free%sigma*derivatives(:, i)
      end do
      n = 0
      do i = 1, components
         if (set == DEVIATIONS) then
            values(i) = norm2(changes(:, i))
            cycle
         end if
         do k = i, components
            n = n + 1
            values(n) = dot_product(changes(:, i), changes(:, k))
         end do
      end do
   end subroutine sensitivity_values

end module nutate_sensitivity_columns
