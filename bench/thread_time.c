/* CPU time of the calling thread, s: what other programs do on the machine is not in it. */
#define _POSIX_C_SOURCE 200809L
#include <time.h>

double bench_thread_seconds(void)
{
    struct timespec now;
    if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now) != 0) return -1.0;
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}
