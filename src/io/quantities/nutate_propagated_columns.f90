!> The columns of a history for the quantities that a run propagates. For the parameters in `&free`: the derivatives of
!> attitude, angular velocity and momenta of wheels and inner spheres with respect to each, and the standard deviations
!> that follow. For `&chaos`: the indicators of chaos.
!>
!> With J the derivatives of rotation vector and angular velocity and Σ the diagonal matrix of the squared standard
!> deviations, JΣJᵀ is the covariance of attitude and angular velocity, to first order.
module nutate_propagated_columns
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
   use nutate_chaos, only: chaos_t
   use nutate_kinds, only: wp
   use nutate_propagated, only: propagated_t
   use nutate_quantity, only: quantity_t, is_propagated, NAVY, OF_RUN
   use nutate_spelling, only: count_text, joined
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: propagated_headers, propagated_values, propagated_width, is_by_free, lyapunov_names
   public :: SENSITIVITIES

   !> Kind of all these quantities.
   integer, parameter, public :: Q_PROPAGATED = OF_RUN

   !> Sets of columns: first those of the parameters, then those of chaos.
   integer, parameter :: SENSITIVITIES = 1, DEVIATIONS = 2, COVARIANCE = 3, LYAPUNOV = 4, MEGNO = 5, FLI = 6
   !> Quantities that a run propagates.
   type(quantity_t), parameter, public :: propagated_quantities(*) = [ &
      quantity_t('sensitivities', 'd_COMPONENT/d_KEY', Q_PROPAGATED, 'rad per unit', 'rotation by *', 41, '', '', &
                 is_propagated, is_propagated, propagated=SENSITIVITIES, pattern='d_rotation#/d_*'), &
      quantity_t('sensitivities', '', Q_PROPAGATED, 'rad/s per unit', 'Ω by *', 42, propagated=SENSITIVITIES, &
                 pattern='d_omega#/d_*'), &
      quantity_t('sensitivities', '', Q_PROPAGATED, 'N m s per unit', 'wheel momentum by *', 43, &
                 propagated=SENSITIVITIES, pattern='d_wheel#_momentum/d_*'), &
      quantity_t('sensitivities', '', Q_PROPAGATED, 'N m s per unit', 'sphere momentum by *', 43, &
                 propagated=SENSITIVITIES, pattern='d_sphere#_momentum#/d_*'), &
      quantity_t('standard_deviations', 'sigma_COMPONENT', Q_PROPAGATED, 'rad', 'σ of the rotation', 44, '', '', &
                 is_propagated, is_propagated, propagated=DEVIATIONS, pattern='sigma_rotation#'), &
      quantity_t('standard_deviations', '', Q_PROPAGATED, 'rad/s', 'σ of Ω', 45, propagated=DEVIATIONS, &
                 pattern='sigma_omega#'), &
      quantity_t('covariance', 'covariance_COMPONENT_COMPONENT', Q_PROPAGATED, '', 'covariances', 46, '', '', &
                 is_propagated, is_propagated, propagated=COVARIANCE, pattern='covariance_*'), &
      quantity_t('lyapunov', 'lyapunovN', Q_PROPAGATED, '1/s', 'Lyapunov exponent', 47, NAVY, '', is_propagated, &
                 is_propagated, propagated=LYAPUNOV, pattern='lyapunov', symbols='λ_1'), &
      quantity_t('lyapunov', '', Q_PROPAGATED, '1/s', 'Lyapunov exponents', 48, propagated=LYAPUNOV, &
                 pattern='lyapunov#'), &
      quantity_t('megno', 'megno', Q_PROPAGATED, '', 'mean MEGNO', 49, NAVY, '', is_propagated, is_propagated, &
                 propagated=MEGNO), &
      quantity_t('fli', 'fli', Q_PROPAGATED, '', 'FLI', 50, NAVY, '', is_propagated, is_propagated, propagated=FLI)]

   !> Components of attitude, a rotation vector, and of angular velocity, in body axes.
   integer, parameter :: components = 6
   !> Largest change, derivative times standard deviation, whose square is treated as finite.
   real(wp), parameter :: greatest_change = 1e150_wp
   character(len=*), parameter :: component_names(components) = [character(len=9) :: &
      'rotation1', 'rotation2', 'rotation3', 'omega1', 'omega2', 'omega3']

contains

   !> Returns true if a set of columns belongs to the parameters.
   elemental logical function is_by_free(set)
      !> Set of columns, `SENSITIVITIES`, ...; 0: another set.
      integer, intent(in) :: set
      is_by_free = set >= SENSITIVITIES .and. set <= COVARIANCE
   end function is_by_free

   !> Returns the names of Lyapunov exponents, `lyapunov`, or `lyapunov1` to `lyapunov6`; shape (n).
   pure function lyapunov_names(n) result(names)
      integer, intent(in) :: n
      character(len=9) :: names(n)
      integer :: i
      do i = 1, n
         write (names(i), '("lyapunov",i0)') i
      end do
      if (n == 1) names = 'lyapunov'
   end function lyapunov_names

   !> Returns the number of columns of a set.
   pure integer function propagated_width(set, propagated, n_inner) result(width)
      !> Set of columns, `SENSITIVITIES`, ...
      integer, intent(in) :: set
      type(propagated_t), intent(in) :: propagated
      !> Number of momenta of wheels and inner spheres.
      integer, intent(in) :: n_inner
      select case (set)
      case (SENSITIVITIES)
         width = size(propagated%names)*(components + n_inner)
      case (DEVIATIONS)
         width = components
      case (COVARIANCE)
         width = components*(components + 1)/2
      case (LYAPUNOV)
         width = propagated%exponents
      case default
         width = 1
      end select
   end function propagated_width

   !> Returns the names of the columns of a set, comma separated.
   pure function propagated_headers(set, propagated, n_wheels, n_spheres, degrees) result(names)
      !> Set of columns, `SENSITIVITIES`, ...
      integer, intent(in) :: set
      type(propagated_t), intent(in) :: propagated
      integer, intent(in) :: n_wheels, n_spheres
      !> True if angles are in degrees.
      logical, intent(in) :: degrees
      character(len=:), allocatable :: names
      character(len=4) :: unit
      integer :: i, k
      unit = ''
      if (degrees) unit = '_deg'
      names = ''
      select case (set)
      case (SENSITIVITIES)
         do k = 1, size(propagated%names)
            do i = 1, components
               names = names//',d_'//trim(component_names(i))//trim(unit)//'/d_'//trim(propagated%names(k))
            end do
            do i = 1, n_wheels
               names = names//',d_wheel'//count_text(i)//'_momentum/d_'//trim(propagated%names(k))
            end do
            do i = 1, 3*n_spheres
               names = names//',d_sphere'//count_text((i + 2)/3)//'_momentum'//count_text(modulo(i - 1, 3) + 1)// &
                       '/d_'//trim(propagated%names(k))
            end do
         end do
      case (DEVIATIONS)
         do i = 1, components
            names = names//',sigma_'//trim(component_names(i))//trim(unit)
         end do
      case (COVARIANCE)
         do i = 1, components
            do k = i, components
               names = names//',covariance_'//trim(component_names(i))//trim(unit)//'_'// &
                       trim(component_names(k))//trim(unit)
            end do
         end do
      case (LYAPUNOV)
         names = ','//joined(lyapunov_names(propagated%exponents))
      case (MEGNO)
         names = ',megno'
      case default
         names = ',fli'
      end select
      names = names(2:)
   end function propagated_headers

   !> Computes the values of a set: for each parameter the derivatives of the rotation vector, rad, of Ω, rad/s, both in
   !> body axes, of the momentum of each wheel, N m s, and of that of each inner sphere, body axes, N m s; or standard
   !> deviations of rotation vector and Ω, or the upper triangle of their covariance, by rows, which are infinite if
   !> squares would overflow; or Lyapunov exponents, 1/s, MEGNO, FLI.
   pure subroutine propagated_values(set, propagated, system, state, tangent, chaos, unit, values)
      !> Set of columns, `SENSITIVITIES`, ...
      integer, intent(in) :: set
      type(propagated_t), intent(in) :: propagated
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Sensitivities: one for each parameter, then others.
      type(tangent_t), intent(in) :: tangent
      !> Indicators of chaos; needed only by their sets.
      type(chaos_t), intent(in), optional :: chaos
      !> One radian in the unit of the angles.
      real(wp), intent(in) :: unit
      !> Values of the set; shape (width of the set).
      real(wp), intent(out) :: values(:)
      real(wp) :: derivatives(tangent%n, components), changes(size(propagated%names), components)
      integer :: i, k, n, n_free, width
      if (.not. is_by_free(set)) then
         if (set == LYAPUNOV) values = chaos%lyapunov()
         if (set == MEGNO) values = chaos%megno()
         if (set == FLI) values = chaos%fli()
         return
      end if
      n_free = size(propagated%names)
      derivatives(:, 1:3) = unit*tangent%theta
      derivatives(:, 4:6) = unit*tangent%rates(system, state)
      if (set == SENSITIVITIES) then
         width = components + size(tangent%wheels, 2)
         do k = 1, n_free
            values((k - 1)*width + 1:k*width) = [derivatives(k, :), tangent%wheels(k, :)]
         end do
         return
      end if
      values = ieee_value(1.0_wp, ieee_positive_inf)
      if (maxval(abs(derivatives(:n_free, :))) > greatest_change/max(maxval(propagated%sigma), 1.0_wp)) return
      do i = 1, components
         changes(:, i) = propagated%sigma*derivatives(:n_free, i)
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
   end subroutine propagated_values

end module nutate_propagated_columns
