!> Names of methods in a work-precision study.
module nutate_cost_names
   use nutate_console, only: count_text
   use nutate_kinds, only: wp, long
   use nutate_methods, only: family_of, methods
   implicit none
   private

   public :: method_label, full_label, hopeless

   !> Attitude errors above this only show that the step is too long, rad.
   real(wp), parameter :: hopeless = 1.0_wp

   !> Name and full name of a method; methods that are not listed are shown by their name.
   type :: name_t
      character(len=24) :: name, words
   end type name_t

   type(name_t), parameter :: names(6) = [ &
      name_t('nielsen_krenk', 'Nielsen-Krenk'), name_t('rk4', 'Runge-Kutta rk4'), name_t('rk8', 'Runge-Kutta rk8'), &
      name_t('dop853', 'Dormand-Prince dop853'), name_t('taylor', 'Taylor series'), name_t('exact', 'closed solution')]

contains

   !> Returns a row of `methods` in a few words: `nielsen_krenk order 6 (reduced)`, `dop853+conserve`.
   pure function method_label(method) result(label)
      !> Row of `methods`.
      integer, intent(in) :: method
      character(len=:), allocatable :: label
      label = trim(family_of(methods(method)))
      if (has_relatives(method)) label = label//' order '//count_text(int(methods(method)%order, long))
      if (methods(method)%formulation /= '') label = label//' ('//trim(methods(method)%formulation)//')'
   end function method_label

   !> Returns the full name of a row of `methods`, for pictures: `Nielsen-Krenk, order 8, reduced`.
   pure function full_label(method) result(label)
      !> Row of `methods`.
      integer, intent(in) :: method
      character(len=:), allocatable :: label
      integer :: i
      associate (row => methods(method))
         label = trim(row%name)
         do i = 1, size(names)
            if (names(i)%name == row%name) label = trim(names(i)%words)
         end do
         if (has_relatives(method)) label = label//', order '//count_text(int(row%order, long))
         if (row%formulation /= '') label = label//', '//trim(row%formulation)
         if (row%projected) label = label//', projected'
      end associate
   end function full_label

   !> Returns true if other rows of `methods` differ from this one in order or solver only.
   pure logical function has_relatives(method)
      !> Row of `methods`.
      integer, intent(in) :: method
      has_relatives = count(family_of(methods) == family_of(methods(method))) > 1
   end function has_relatives

end module nutate_cost_names
