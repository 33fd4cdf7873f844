/* Test for AVX2, for nutate_simd.f90. */
#include <stdlib.h>
#include <string.h>

int nutate_has_avx2(void);

/* Returns 1 if the processor has AVX2 and NUTATE_SIMD is not sse2, else 0. The first call reads the environment. */
int nutate_has_avx2(void)
{
   /* Result plus 1; 0 before the first call. Concurrent first calls find the same result. */
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
