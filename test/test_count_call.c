/* Counts the calls of Fortran procedures that must be pure, and so cannot count themselves. */
static long long counters[7];

void test_count_call(int which, double *zero)
{
   ++counters[which - 1];
   *zero = 0.0;
}

void test_reset_counts(void)
{
   int i;
   for (i = 0; i < 7; ++i)
      counters[i] = 0;
}

void test_read_counts(long long *counts)
{
   int i;
   for (i = 0; i < 7; ++i)
      counts[i] = counters[i];
}
