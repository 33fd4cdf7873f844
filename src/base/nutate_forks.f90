!> Threads in processes that were forked. OpenMP keeps its threads between parallel regions; a forked process does not
!> have those of its parent, and its first parallel region with more than one thread would wait for them for ever.
module nutate_forks
   use, intrinsic :: iso_c_binding, only: c_int
   implicit none
   private

   public :: has_threads, may_start_threads

   interface
      integer(c_int) function nutate_may_start_threads() bind(C)
         import :: c_int
      end function nutate_may_start_threads
   end interface

contains

   !> Returns true if the library was built with threads.
   pure logical function has_threads()
      has_threads = .false.
      !$ has_threads = .true.
   end function has_threads

   !> Returns true unless this process was forked from one that had called this function. A procedure calls it before
   !> a parallel region with more than one thread, and uses one thread if the result is false.
   logical function may_start_threads()
      may_start_threads = nutate_may_start_threads() /= 0
   end function may_start_threads

end module nutate_forks
