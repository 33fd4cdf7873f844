/* A lock for threads that read or write texts: see nutate_text_lock.f90. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif

#include <pthread.h>

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

/* A forked process has no other threads, which would never release the lock. */
static void free_lock(void)
{
   static const pthread_mutex_t free_one = FREE_LOCK;
   text_lock = free_one;
}

/* A fork waits for the thread that holds the lock, whose texts would be unfinished in the new process. */
static void watch_forks(void) { pthread_atfork(nutate_lock_texts, nutate_unlock_texts, free_lock); }

void nutate_lock_texts(void)
{
   pthread_once(&once, watch_forks);
   pthread_mutex_lock(&text_lock);
}

void nutate_unlock_texts(void) { pthread_mutex_unlock(&text_lock); }
