!> Volume and inertia of homogeneous shapes about their centre of mass.
module nutate_shapes
   use nutate_kinds, only: wp, pi
   use nutate_spelling, only: comma_list
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: shape_kind_t, shape_kinds, measure_shape

   !> One shape: its name and the lengths that describe it.
   type :: shape_kind_t
      character(len=12) :: name
      !> Number of lengths that describe the shape.
      integer :: sizes
      !> Names of the lengths, for messages.
      character(len=40) :: lengths
   end type shape_kind_t

   !> All shapes. Axis 3 is the axis of cylinder and cone; the cone's apex points towards -3.
   type(shape_kind_t), parameter :: shape_kinds(5) = [ &
      shape_kind_t('box', 3, 'full edges a, b, c'), &
      shape_kind_t('cylinder', 2, 'radius, height'), &
      shape_kind_t('cone', 2, 'base radius, height'), &
      shape_kind_t('sphere', 1, 'radius'), &
      shape_kind_t('ellipsoid', 3, 'semi-axes a, b, c')]

contains

   !> Computes volume and moments of inertia per unit mass of a homogeneous shape.
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT` for an unknown shape, or a wrong number of lengths.
   pure subroutine measure_shape(name, lengths, volume, gyration, status)
      !> Name of the shape.
      character(len=*), intent(in) :: name
      !> Lengths of the shape, m; shape (sizes of the shape).
      real(wp), intent(in) :: lengths(:)
      !> Volume, m³.
      real(wp), intent(out) :: volume
      !> Moments about the centre of mass over the mass, body axes, m²; shape (3).
      real(wp), intent(out) :: gyration(3)
      type(status_t), intent(out) :: status
      real(wp) :: a(3)
      integer :: i

      volume = 0.0_wp
      gyration = 0.0_wp
      i = findloc(shape_kinds%name == name, .true., dim=1)
      if (i == 0) then
         status = fail(NUTATE_BAD_ARGUMENT, "unknown shape '"//name//"' (expected "// &
                       comma_list(shape_kinds%name)//")", 'shape')
      else if (size(lengths) /= shape_kinds(i)%sizes) then
         status = fail(NUTATE_BAD_ARGUMENT, "wrong number of lengths for shape '"//name//"' (expected "// &
                       trim(shape_kinds(i)%lengths)//")", 'size')
      end if
      if (.not. status%ok()) return
      a = lengths(1)
      a(1:size(lengths)) = lengths
      select case (name)
      case ('box')
         volume = a(1)*a(2)*a(3)
         gyration = ellipsoidal(a)/12
      case ('cylinder')
         volume = pi*a(1)**2*a(2)
         gyration = [(3*a(1)**2 + a(2)**2)/12, (3*a(1)**2 + a(2)**2)/12, a(1)**2/2]
      case ('cone')
         volume = pi*a(1)**2*a(2)/3
         gyration = 3*[(4*a(1)**2 + a(2)**2)/80, (4*a(1)**2 + a(2)**2)/80, a(1)**2/10]
      case default ! sphere and ellipsoid
         volume = 4*pi/3*a(1)*a(2)*a(3)
         gyration = ellipsoidal(a)/5
      end select
   end subroutine measure_shape

   !> Returns (b² + c², c² + a², a² + b²).
   pure function ellipsoidal(a) result(sums)
      real(wp), intent(in) :: a(3)
      real(wp) :: sums(3)
      sums = [a(2)**2 + a(3)**2, a(3)**2 + a(1)**2, a(1)**2 + a(2)**2]
   end function ellipsoidal

end module nutate_shapes
