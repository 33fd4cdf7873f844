!> How a cost study speaks of methods.
module nutate_cost_names
   use nutate_console, only: count_text
   use nutate_kinds, only: long
   use nutate_methods, only: methods
   implicit none
   private

   public :: method_label, short_label

contains

   !> A row of the table of methods in a few words: `nielsen_krenk order 6 (reduced)`, `dop853`.
   pure function method_label(method) result(label)
      !> Row of `methods`.
      integer, intent(in) :: method
      character(len=:), allocatable :: label
      label = trim(methods(method)%name)
      if (count(methods%name == methods(method)%name) > 1) &
         label = label//' order '//count_text(int(methods(method)%order, long))
      if (methods(method)%linear_solver /= '') label = label//' ('//trim(methods(method)%linear_solver)//')'
   end function method_label

   !> The same without the name, where the order says enough: `order 6 (reduced)`, `dop853`.
   pure function short_label(method) result(label)
      !> Row of `methods`.
      integer, intent(in) :: method
      character(len=:), allocatable :: label
      label = method_label(method)
      if (count(methods%name == methods(method)%name) > 1) label = label(len_trim(methods(method)%name) + 2:)
   end function short_label

end module nutate_cost_names
