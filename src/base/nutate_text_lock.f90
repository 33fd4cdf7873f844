!> A lock for threads that read or write texts.
!>
!> gfortran keeps the length of a function's result in a static variable where it is not known beforehand, whatever its
!> flags: two threads that read scenes, settings or names of columns could use each other's lengths. Procedures that
!> call such functions, and may be called by several threads, hold this lock; steps and runs do not need it.
module nutate_text_lock
   implicit none
   private

   public :: lock_texts, unlock_texts

   interface
      !> Waits until no other thread holds the lock; the thread that holds it may lock it again.
      subroutine lock_texts() bind(c, name='nutate_lock_texts')
      end subroutine lock_texts

      !> Releases the lock, once for each call of `lock_texts`.
      subroutine unlock_texts() bind(c, name='nutate_unlock_texts')
      end subroutine unlock_texts
   end interface

end module nutate_text_lock
