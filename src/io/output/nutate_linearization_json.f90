!> A linearised motion, and equilibria, as JSON: matrices by rows, with the names and units of states and inputs.
module nutate_linearization_json
   use nutate_decimal, only: exact_text
   use nutate_equilibria, only: equilibria_t
   use nutate_kinds, only: wp
   use nutate_linearization, only: linearization_t
   implicit none
   private

   public :: json_of, json_of_equilibria

contains

   !> Returns a linearised motion as one object.
   function json_of(linear) result(text)
      type(linearization_t), intent(in) :: linear
      character(len=:), allocatable :: text
      character(len=1), parameter :: line = new_line('a')
      integer :: i
      text = '{"nutate": "linearization",'//line// &
             '"period": '//exact_text(linear%period)//','//line// &
             '"closes": '//trim(merge('true ', 'false', linear%closes))//','//line// &
             '"residual": '//exact_text(linear%residual)//','//line// &
             '"attitude": '//numbers(linear%q)//','//line// &
             '"angular_velocity": '//numbers(linear%omega)//','//line// &
             '"wheel_speeds": '//numbers(linear%speeds)//','//line// &
             '"states": '//texts(linear%states)//','//line// &
             '"state_units": '//texts(linear%state_units)//','//line// &
             '"rates": "'//trim(merge('absolute', 'relative', linear%absolute))//'",'//line// &
             '"inputs": '//texts(linear%inputs)//','//line// &
             '"input_units": '//texts(linear%input_units)//','//line// &
             '"A": '//rows(linear%a)//','//line//'"B": '//rows(linear%b)//','//line//'"eigenvalues": ['
      do i = 1, size(linear%eigenvalues)
         if (i > 1) text = text//', '
         text = text//numbers([real(linear%eigenvalues(i), wp), aimag(linear%eigenvalues(i))])
      end do
      text = text//']}'
   end function json_of

   !> Returns equilibria as one object.
   function json_of_equilibria(found) result(text)
      type(equilibria_t), intent(in) :: found
      character(len=:), allocatable :: text
      character(len=1), parameter :: line = new_line('a')
      character(len=1) :: index
      integer :: i
      text = '{"nutate": "equilibria",'//line// &
             '"balanced": '//trim(merge('true ', 'false', found%balanced))//','//line//'"equilibria": ['
      do i = 1, size(found%items)
         associate (item => found%items(i))
            write (index, '(i1)') item%index
            text = text//line//'{"attitude": '//numbers(item%q)//', "energy": '//exact_text(item%energy)// &
                   ', "index": '//index//', "growth": '//exact_text(item%growth)//'}'
         end associate
         if (i < size(found%items)) text = text//','
      end do
      text = text//']}'
   end function json_of_equilibria

   pure function rows(matrix) result(text)
      real(wp), intent(in) :: matrix(:, :)
      character(len=:), allocatable :: text
      integer :: i
      text = '['
      do i = 1, size(matrix, 1)
         if (i > 1) text = text//','//new_line('a')//'  '
         text = text//numbers(matrix(i, :))
      end do
      text = text//']'
   end function rows

   pure function numbers(values) result(text)
      real(wp), intent(in) :: values(:)
      character(len=:), allocatable :: text
      integer :: i
      text = '['
      do i = 1, size(values)
         if (i > 1) text = text//', '
         text = text//exact_text(values(i))
      end do
      text = text//']'
   end function numbers

   pure function texts(values) result(text)
      character(len=*), intent(in) :: values(:)
      character(len=:), allocatable :: text
      integer :: i
      text = '['
      do i = 1, size(values)
         if (i > 1) text = text//', '
         text = text//'"'//trim(values(i))//'"'
      end do
      text = text//']'
   end function texts

end module nutate_linearization_json
