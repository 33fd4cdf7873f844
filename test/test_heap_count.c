/* Counts the allocations of the calling thread: the program's own malloc and its like stand before those of glibc.
   Elsewhere, and under sanitizers and valgrind, which bring their own, nothing is counted. */
#include <stddef.h>
#include <stdlib.h>
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
#include <malloc.h>
#endif

static __thread long long allocations;

long long test_count_allocations(void)
{
   return allocations;
}

/* Bytes of the heap in use; always 0 where they cannot be counted. */
long long test_heap_in_use(void)
{
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
#if __GLIBC_PREREQ(2, 33)
   struct mallinfo2 heap = mallinfo2();
   return (long long)(heap.uordblks + heap.hblkhd);
#endif
#endif
   return 0;
}

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t number, size_t size);
void *__libc_realloc(void *old, size_t size);
void *__libc_memalign(size_t alignment, size_t size);

void *malloc(size_t size)
{
   ++allocations;
   return __libc_malloc(size);
}

void *calloc(size_t number, size_t size)
{
   ++allocations;
   return __libc_calloc(number, size);
}

void *realloc(void *old, size_t size)
{
   ++allocations;
   return __libc_realloc(old, size);
}

void *aligned_alloc(size_t alignment, size_t size)
{
   ++allocations;
   return __libc_memalign(alignment, size);
}
#endif
