!> A lock for threads that read or write texts.
!>
!> gfortran keeps the length of a function's result in a static variable where it is not known beforehand, whatever its
!> flags: two threads that read scenes, settings or names of columns could take each other's lengths. What calls such
!> functions, and may be called by several threads, holds this lock; steps and runs need not.
module nutate_text_lock
   implicit none
   private

   public :: lock_texts, unlock_texts

   interface
      !> Waits until no other thread holds the lock; the one that holds it may take it again.
      subroutine lock_texts() bind(c, name='nutate_lock_texts')
      end subroutine lock_texts

      !> Gives it back, once for each time that it was taken.
      subroutine unlock_texts() bind(c, name='nutate_unlock_texts')
      end subroutine unlock_texts
   end interface

end module nutate_text_lock
