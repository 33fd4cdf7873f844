/* A lock for threads that read or write texts: see nutate_text_lock.f90. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif

#include <pthread.h>

#if defined PTHREAD_RECURSIVE_MUTEX_INITIALIZER_NP
static pthread_mutex_t text_lock = PTHREAD_RECURSIVE_MUTEX_INITIALIZER_NP;
#elif defined PTHREAD_RECURSIVE_MUTEX_INITIALIZER
static pthread_mutex_t text_lock = PTHREAD_RECURSIVE_MUTEX_INITIALIZER;
#else
static pthread_mutex_t text_lock = PTHREAD_MUTEX_INITIALIZER;
#endif

void nutate_lock_texts(void);
void nutate_unlock_texts(void);

void nutate_lock_texts(void) { pthread_mutex_lock(&text_lock); }

void nutate_unlock_texts(void) { pthread_mutex_unlock(&text_lock); }
