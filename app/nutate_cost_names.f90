!> How a work-precision study speaks of methods.
module nutate_cost_names
   use nutate_console, only: count_text
   use nutate_kinds, only: wp, long
   use nutate_methods, only: family_of, methods
   implicit none
   private

   public :: method_label, short_label, hopeless

   !> Attitude errors above this say nothing but that the step is too long, rad.
   real(wp), parameter :: hopeless = 1.0_wp

contains

   !> A row of the table of methods in a few words: `nielsen_krenk order 6 (reduced)`, `dop853+conserve`.
   pure function method_label(method) result(label)
      !> Row of `methods`.
      integer, intent(in) :: method
      character(len=:), allocatable :: label
      label = trim(family_of(methods(method)))
      if (has_relatives(method)) label = label//' order '//count_text(int(methods(method)%order, long))
      if (methods(method)%linear_solver /= '') label = label//' ('//trim(methods(method)%linear_solver)//')'
   end function method_label

   !> The same without the name, where the order says enough: `order 6 (reduced)`, `dop853`.
   pure function short_label(method) result(label)
      !> Row of `methods`.
      integer, intent(in) :: method
      character(len=:), allocatable :: label
      label = method_label(method)
      if (has_relatives(method)) label = label(len_trim(family_of(methods(method))) + 2:)
   end function short_label

   !> There are rows that differ from this one in order or solver only.
   pure logical function has_relatives(method)
      !> Row of `methods`.
      integer, intent(in) :: method
      has_relatives = count(family_of(methods) == family_of(methods(method))) > 1
   end function has_relatives

end module nutate_cost_names
