/* A lock for threads that read or write texts: see nutate_text_lock.f90. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif

#include <pthread.h>
#include <time.h>

#if defined PTHREAD_RECURSIVE_MUTEX_INITIALIZER_NP
#define FREE_LOCK PTHREAD_RECURSIVE_MUTEX_INITIALIZER_NP
#elif defined PTHREAD_RECURSIVE_MUTEX_INITIALIZER
#define FREE_LOCK PTHREAD_RECURSIVE_MUTEX_INITIALIZER
#else
#define FREE_LOCK PTHREAD_MUTEX_INITIALIZER
#endif

static pthread_mutex_t text_lock = FREE_LOCK;
static pthread_once_t once = PTHREAD_ONCE_INIT;

void nutate_lock_texts(void);
void nutate_unlock_texts(void);

/* The lock is held by this thread for a fork. */
static _Thread_local int held;

/* A fork waits for the thread that holds the lock, whose texts would be unfinished in the new process: up to a second,
 * for that thread may wait for a file. */
static void wait_for_texts(void)
{
   const struct timespec pause = {0, 1000000};
   int tries = 0;
   held = pthread_mutex_trylock(&text_lock) == 0;
   for (; !held && tries < 1000; tries++) {
      nanosleep(&pause, NULL);
      held = pthread_mutex_trylock(&text_lock) == 0;
   }
}

static void release_texts(void)
{
   if (held) pthread_mutex_unlock(&text_lock);
   held = 0;
}

/* A forked process has no other threads, which would never release the lock. */
static void free_lock(void)
{
   static const pthread_mutex_t free_one = FREE_LOCK;
   text_lock = free_one;
   held = 0;
}

static void watch_forks(void) { pthread_atfork(wait_for_texts, release_texts, free_lock); }

void nutate_lock_texts(void)
{
   pthread_once(&once, watch_forks);
   pthread_mutex_lock(&text_lock);
}

void nutate_unlock_texts(void) { pthread_mutex_unlock(&text_lock); }
