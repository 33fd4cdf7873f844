!> Plan of a fit: free parameters of a scene, measurements, and initial guesses of the iteration.
module nutate_fit_plan
   use nutate_ensemble_plan, only: ensemble_plan_t
   use nutate_kinds, only: wp, long
   use nutate_robust_loss, only: LINEAR
   implicit none
   private

   public :: fit_plan_t, free_number_t, is_drawn, measurement_t
   public :: ATTITUDES, DIRECTIONS, VALUES

   !> Kinds of measurements: columns of a history; attitudes, as quaternions; body components of a direction in space.
   integer, parameter :: VALUES = 1, ATTITUDES = 2, DIRECTIONS = 3

   !> Free parameter of a scene.
   type :: free_number_t
      !> Name `initial.attitude.I` or `GROUP[.N].KEY[.I]`.
      character(len=80) :: name = ''
      !> Index among the targets; 0 for a component of the rotation vector of the attitude.
      integer :: target = 0
      !> Component of the rotation vector, 1 to 3; 0: the number is not one.
      integer :: component = 0
      !> Line of its key in the scene.
      integer :: line = 0
      !> Standard deviation of the value of the scene, in its unit; 0: the scene's value is only the initial guess.
      real(wp) :: sigma = 0.0_wp
      !> Bounds, in the unit of the number.
      real(wp) :: low = -huge(1.0_wp), high = huge(1.0_wp)
   end type free_number_t

   !> Rows of a file of measurements.
   type :: measurement_t
      !> Path of the file.
      character(len=:), allocatable :: file
      !> Kind of measurement: `VALUES`, ...
      integer :: kind = VALUES
      !> Names of the columns that were measured; shape (columns).
      character(len=48), allocatable :: columns(:)
      !> Sets of a history that contain the columns, each set once; index of each column in a row of these sets. Shape
      !> (sets) and (columns).
      character(len=24), allocatable :: sets(:)
      integer, allocatable :: places(:)
      !> Angles and their rates are in degrees.
      logical :: degrees = .false.
      !> One revolution for angles known modulo 2π, in their unit; otherwise 0. Shape (columns).
      real(wp), allocatable :: turns(:)
      !> Unit vector in space axes, for `DIRECTIONS`.
      real(wp) :: direction(3) = 0.0_wp
      !> Standard deviation of each residual of a row; 1 if it is not known. Shape (residuals of a row).
      real(wp), allocatable :: sigma(:)
      logical :: sigma_is_known = .false.
      !> Each column has a constant bias, which is fitted too.
      logical :: has_bias = .false.
      !> Loss function: `LINEAR`, ... of `nutate_robust_loss`.
      integer :: loss = LINEAR
      !> Times, s, in the order of the run; shape (rows).
      real(wp), allocatable :: times(:)
      !> Measured values; shape (columns, rows).
      real(wp), allocatable :: rows(:, :)
   contains
      !> Returns the number of residuals of a row: 3 for an attitude, otherwise the number of columns.
      procedure :: width
   end type measurement_t

   !> A fit.
   type :: fit_plan_t
      !> Free parameters; shape (free parameters), empty if the scene has no group `&free`.
      type(free_number_t), allocatable :: free(:)
      type(measurement_t), allocatable :: measurements(:)
      !> Groups of the scene with a position for each free parameter; a free attitude is given as `quaternion`.
      type(ensemble_plan_t) :: numbers
      !> The attitude is free; its quaternion as the scene gives it, in the axes of `attitude_from`.
      logical :: has_attitude = .false.
      real(wp) :: attitude(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> Unit of the rotation vector of the attitude, rad.
      real(wp) :: angle_unit = 1.0_wp
      !> Number of random initial guesses beside those of the scene and of the data; their seed.
      integer :: starts = 0
      integer(long) :: seed = 0
      !> The fit begins with a short arc of the data, which grows.
      logical :: grows = .true.
      !> An initial guess is also estimated from the data.
      logical :: starts_from_data = .true.
   contains
      !> Returns true if there is something to fit.
      procedure :: active
   end type fit_plan_t

contains

   !> Returns true for a number that random starts draw: a moment, or one with bounds or a standard deviation.
   elemental logical function is_drawn(free)
      type(free_number_t), intent(in) :: free
      is_drawn = free%component == 0 .and. (index(free%name, 'body.inertia.') == 1 .or. free%sigma > 0.0_wp .or. &
                                            max(abs(free%low), abs(free%high)) < huge(1.0_wp))
   end function is_drawn

   pure integer function width(self)
      class(measurement_t), intent(in) :: self
      width = size(self%columns)
      if (self%kind == ATTITUDES) width = 3
   end function width

   pure logical function active(self)
      class(fit_plan_t), intent(in) :: self
      active = .false.
      if (allocated(self%free) .and. allocated(self%measurements)) &
         active = size(self%free) > 0 .and. size(self%measurements) > 0
   end function active

end module nutate_fit_plan
