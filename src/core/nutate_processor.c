/* What the processor can do, for nutate_simd.f90. */
#include <stdlib.h>
#include <string.h>

int nutate_has_avx2(void);

/* 1 if the processor has AVX2 and NUTATE_SIMD is not sse2, else 0. The environment is read in the first call alone. */
int nutate_has_avx2(void)
{
   /* 0: not asked yet; else the answer plus 1. Threads that ask at the same time find the same. */
   static _Atomic int known = 0;
   if (known == 0) {
      int found = 0;
#if (defined __x86_64__ || defined __i386__) && defined __GNUC__
      const char *wanted = getenv("NUTATE_SIMD");
      __builtin_cpu_init();
      found = __builtin_cpu_supports("avx2") && (wanted == NULL || strcmp(wanted, "sse2") != 0);
#endif
      known = 1 + (found != 0);
   }
   return known - 1;
}
