/* Signals that ask the program to stop: the first one is noted, to be seen between two steps; another one kills.
 *
 * Called by the module nutate_run_watcher only. */
#ifndef _DEFAULT_SOURCE
#define _DEFAULT_SOURCE
#endif

#include <signal.h>
#include <stddef.h>
#include <time.h>

/* A signal that comes again within this time, ns, is the same request: timeout(1) sends its signal twice. */
enum { SAME_REQUEST = 200000000 };

static const int requests[] = {SIGINT, SIGTERM, SIGHUP};
enum { N_REQUESTS = sizeof requests / sizeof requests[0] };

/* The signal that came; 0 for none. A handler has no other place than a global variable. */
static volatile sig_atomic_t caught = 0;
static struct timespec when;

void nutate_signals_watch(void);
int nutate_signals_caught(void);
const volatile sig_atomic_t *nutate_signals_flag(void);
void nutate_signals_end_by(int number);

static void note(int number)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    if (!caught) {
        when = now;
        caught = number;
    } else if ((now.tv_sec - when.tv_sec) * 1000000000LL + (now.tv_nsec - when.tv_nsec) > SAME_REQUEST) {
        signal(number, SIG_DFL);
        raise(number);
    }
}

/* Notes requests to stop from now on; those that the caller has set to be ignored (nohup) stay ignored. Calls of the
 * system that wait are broken off. */
void nutate_signals_watch(void)
{
    struct sigaction action = {0}, before;
    action.sa_handler = note;
    sigemptyset(&action.sa_mask);
    for (int i = 0; i < N_REQUESTS; i++) sigaddset(&action.sa_mask, requests[i]);
    for (int i = 0; i < N_REQUESTS; i++) {
        if (sigaction(requests[i], NULL, &before) == 0 && before.sa_handler != SIG_IGN)
            sigaction(requests[i], &action, NULL);
    }
}

int nutate_signals_caught(void)
{
    return caught;
}

const volatile sig_atomic_t *nutate_signals_flag(void)
{
    return &caught;
}

/* Ends the program by a signal, so that a shell sees what ended it. */
void nutate_signals_end_by(int number)
{
    sigset_t set;
    signal(number, SIG_DFL);
    sigemptyset(&set);
    sigaddset(&set, number);
    sigprocmask(SIG_UNBLOCK, &set, NULL);
    raise(number);
}
