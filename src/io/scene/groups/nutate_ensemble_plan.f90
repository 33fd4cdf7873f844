!> Plan of an ensemble: its number of members, the differences between them, and the data kept of each.
module nutate_ensemble_plan
   use nutate_keys, only: group_t, key_t
   use nutate_kinds, only: wp, long
   implicit none
   private

   public :: ensemble_plan_t, target_t, varied_key_t
   public :: UNIFORM, NORMAL, ROTATION, GRID, CASES

   !> Distributions of values: between two bounds; by mean and covariance; a quaternion, uniform over all rotations;
   !> evenly spaced, every combination; from a table.
   integer, parameter :: UNIFORM = 1, NORMAL = 2, ROTATION = 3, GRID = 4, CASES = 5

   !> One number of a scene that differs from member to member.
   type :: target_t
      !> `GROUP[.N].KEY[.I]`; of a key with several numbers always with its I.
      character(len=80) :: name = ''
      !> Position of the number: index of its group in the plan, of its key in the group, of the number in the key.
      integer :: group = 0, setting = 0, value = 0
      !> Key of the number, with the values that it admits.
      type(key_t) :: key = key_t()
   end type target_t

   !> Numbers that are drawn together.
   type :: varied_key_t
      !> `UNIFORM`, ...
      integer :: distribution = UNIFORM
      !> Index of the first target, and number of targets.
      integer :: first = 1, n = 0
      !> Bounds; the mean stands in `low`. Shape (n).
      real(wp), allocatable :: low(:), high(:)
      !> Lower triangle whose product with its transpose is the covariance; shape (n, n).
      real(wp), allocatable :: factor(:, :)
      !> Numbers of points of a grid; shape (n).
      integer, allocatable :: points(:)
      !> A line for each member; shape (n, lines).
      real(wp), allocatable :: cases(:, :)
   end type varied_key_t

   !> An ensemble.
   type :: ensemble_plan_t
      !> Number of members; 0: the scene has no ensemble.
      integer(long) :: members = 0
      !> Key of the random numbers.
      integer(long) :: seed = 0
      !> Random numbers are stratified: of each, one member in each of as many equal parts as there are members.
      logical :: latin = .false.
      !> A row is kept of every member; else only mean and counts.
      logical :: keeps_rows = .true.
      !> File of the rows, relative to the working directory.
      character(len=:), allocatable :: file
      !> Members whose history is written.
      integer, allocatable :: histories(:)
      !> Members that are run and written together; 0: as many as suits.
      integer :: chunk = 0
      type(target_t), allocatable :: targets(:)
      type(varied_key_t), allocatable :: variations(:)
      !> The groups of the scene, with a place for each target.
      type(group_t), allocatable :: groups(:)
   contains
      !> Returns true if the scene has an ensemble.
      procedure :: active
   end type ensemble_plan_t

contains

   elemental logical function active(self)
      class(ensemble_plan_t), intent(in) :: self
      active = self%members > 0
   end function active

end module nutate_ensemble_plan
