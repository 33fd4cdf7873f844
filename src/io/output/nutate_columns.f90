!> The columns of a history: sets of the table of quantities, and their values.
module nutate_columns
   use nutate_archive, only: archive_t
   use nutate_chaos, only: chaos_t
   use nutate_effect_list, only: effect_list_t
   use nutate_followed_angles, only: followed_angles_t
   use nutate_kinds, only: wp, pi
   use nutate_observer, only: run_record_t
   use nutate_propagated, only: propagated_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: columns_t, need_attitude

   !> One radian in degrees.
   real(wp), parameter :: degree = 180.0_wp/pi

   !> Values that several sets share, and values kept from earlier states.
   type, private :: shared_t
      !> Ω, body axes, rad/s; shape (3). Set only if a set of columns needs it.
      real(wp) :: omega(3) = 0.0_wp
      !> H of the first state, J; the Jacobi integral if the space axes rotate. Set only if a set of columns needs it.
      real(wp) :: first_energy = 0.0_wp
      !> 1/J0, kg⁻¹ m⁻².
      real(wp) :: inverse_j0 = 0.0_wp
   end type shared_t

   !> The sets of columns of a history. Values that no set needs are never evaluated.
   type :: columns_t
      !> Position in the table of the first quantity of each requested set.
      integer, allocatable, private :: chosen(:)
      !> Number of all columns, including t, and of the columns of each chosen set; shape (that of `chosen`).
      integer :: width = 1
      integer, allocatable, private :: widths(:)
      !> Names of the columns for each effect, comma separated.
      character(len=:), allocatable, private :: energies, works
      !> True if records must have `works`.
      logical :: needs_works = .false.
      !> True if columns show values of the step that ends at a row: commands of controllers.
      logical :: shows_commands = .false.
      !> True if `follow` must be called with the state after every step.
      logical :: follows_steps = .false.
      !> True if columns show quantities that a run propagates: `evaluate` needs its sensitivities.
      logical :: differentiates = .false.
      !> Number of the chosen sets without propagated quantities, which come first, and of their columns, including t.
      integer, private :: n_plain = 0
      integer :: plain_width = 1
      type(propagated_t), allocatable, private :: propagated
      integer, private :: n_wheels = 0, n_spheres = 0
      !> True for angles in degrees, rates in degrees per second.
      logical, private :: degrees = .false.
      logical, private :: needs_rate = .false.
      type(shared_t), private :: shared
      !> Euler angles of each chosen set that has some; shape (that of `chosen`) if there is one.
      type(followed_angles_t), allocatable, private :: followed(:)
      !> Numbers of the chosen sets that follow angles.
      integer, allocatable, private :: angle_sets(:)
   contains
      !> Selects the sets by name.
      procedure :: choose
      !> Returns the header row.
      procedure :: header
      !> Returns an error for a row with a value that is not finite, with the name of its column.
      procedure :: check_row
      !> Stores the first state.
      procedure :: start
      !> Follows angles that must not lose revolutions between rows.
      procedure :: follow
      !> Evaluates one row.
      procedure :: evaluate
      !> Writes or reads the values kept from earlier states in checkpoint data.
      procedure :: transfer => transfer_columns
   end type columns_t

   interface

      !> Returns true if one of the named sets depends on the attitude.
      pure logical module function need_attitude(names)
         character(len=*), intent(in) :: names(:)
      end function need_attitude

      !> Selects sets by name, in any order. Errors: `NUTATE_BAD_ARGUMENT` for a name that is not in the table, for
      !> a wheel, an orbit or a sun that does not exist, for two sets with the same columns, and for sets of quantities
      !> that the run does not propagate.
      module subroutine choose(self, names, status, degrees, effects, propagated)
         class(columns_t), intent(inout) :: self
         character(len=*), intent(in) :: names(:)
         type(status_t), intent(out) :: status
         !> Angles in degrees, rates in degrees per second, which the names of their columns say; default `.false.`.
         logical, intent(in), optional :: degrees
         !> Effects of the system; default: everything that columns need exists, and no effect has separate columns.
         type(effect_list_t), intent(in), optional :: effects
         !> Quantities that the run propagates; default: none.
         type(propagated_t), intent(in), optional :: propagated
      end subroutine choose

      !> Returns the header row: the names of all columns, comma separated.
      pure module function header(self, plain) result(line)
         class(columns_t), intent(in) :: self
         !> True to leave out the columns of derivatives; default false.
         logical, intent(in), optional :: plain
         character(len=:), allocatable :: line
      end function header

      !> Checks a row. Errors: `NUTATE_NOT_FINITE` for a value that is not finite, with the name of its column.
      module subroutine check_row(self, values, status)
         class(columns_t), intent(in) :: self
         !> A row, t first.
         real(wp), intent(in) :: values(:)
         type(status_t), intent(inout) :: status
      end subroutine check_row

      !> Stores the first state.
      pure module subroutine start(self, system, state, inverse_j0, backward)
         class(columns_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(in) :: state
         !> 1/J0, kg⁻¹ m⁻².
         real(wp), intent(in) :: inverse_j0
         !> True if the run goes backward in time; default false.
         logical, intent(in), optional :: backward
      end subroutine start

      !> Follows angles that must not lose revolutions between rows. Call it after every step if `follows_steps`.
      pure module subroutine follow(self, state)
         class(columns_t), intent(inout) :: self
         type(state_t), intent(in) :: state
      end subroutine follow

      !> Evaluates one row: t, then the values of the sets.
      pure module subroutine evaluate(self, system, state, record, values, tangent, chaos)
         class(columns_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         type(state_t), intent(in) :: state
         type(run_record_t), intent(in) :: record
         !> Values of the row; shape (width), or shape (plain_width) without sensitivities.
         real(wp), intent(out) :: values(:)
         !> Sensitivities: one for each parameter, then others; needed only if `differentiates`.
         type(tangent_t), intent(in), optional :: tangent
         !> Indicators of chaos; needed only by their columns.
         type(chaos_t), intent(in), optional :: chaos
      end subroutine evaluate

      !> Writes or reads the values kept from earlier states in checkpoint data.
      module subroutine transfer_columns(self, archive)
         class(columns_t), intent(inout) :: self
         class(archive_t), intent(inout) :: archive
      end subroutine transfer_columns

   end interface

end module nutate_columns
