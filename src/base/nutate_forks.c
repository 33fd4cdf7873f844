/* Test for threads that a fork has lost, for nutate_forks.f90. */
#include <unistd.h>

int nutate_may_start_threads(void);

/* Returns 0 if this process was forked from one that had called this function, else 1. */
int nutate_may_start_threads(void)
{
   /* The process of the first call; 0 before it. Concurrent first calls store the same number. */
   static _Atomic long owner = 0;
   if (owner == 0) owner = getpid();
   return owner == getpid();
}
