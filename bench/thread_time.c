/* CPU time of the calling thread, and of all, s: what other programs do on the machine is not in it. */
#define _POSIX_C_SOURCE 200809L
#include <time.h>

static double seconds(clockid_t clock)
{
    struct timespec now;
    if (clock_gettime(clock, &now) != 0) return -1.0;
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double bench_thread_seconds(void) { return seconds(CLOCK_THREAD_CPUTIME_ID); }

double bench_process_seconds(void) { return seconds(CLOCK_PROCESS_CPUTIME_ID); }
