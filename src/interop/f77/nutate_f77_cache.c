/* Keeps the address of the cache of each thread: the prepared bodies of its work arrays. See nutate_f77_prepared.f90.
 *
 * Threads share nothing here, so that no call waits for another one. The cache of a thread is freed when it ends. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif

#include <pthread.h>
#include <stddef.h>
#include <stdint.h>
#include <time.h>

void *nutate_f77_cache(void);
double nutate_f77_mark(void);
void nutate_f77_keep_cache(void *cache);

/* Frees a cache. Defined in nutate_f77_prepared.f90. */
void nutate_f77_free_cache(void *cache);

/* The cache of this thread, and the key by which a thread that ends finds it. */
static __thread void *own;
static pthread_once_t once = PTHREAD_ONCE_INIT;
static pthread_key_t key;
static int has_key;

static void make_key(void) { has_key = pthread_key_create(&key, nutate_f77_free_cache) == 0; }

/* Returns the cache of this thread; NULL if there is none yet. */
void *nutate_f77_cache(void) { return own; }

void nutate_f77_keep_cache(void *cache)
{
    own = cache;
    pthread_once(&once, make_key);
    if (has_key) pthread_setspecific(key, cache);
}

/* Returns an integer below 2^52 that no other body has, in any thread and process: time, thread and a count, mixed as in
 * Steele, Lea and Flood's SplitMix64. */
double nutate_f77_mark(void)
{
    static __thread uint64_t count;
    struct timespec now = {0, 0};
    uint64_t bits;
    clock_gettime(CLOCK_REALTIME, &now);
    bits = (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec + (uint64_t)(uintptr_t)&own;
    bits += ++count * 0x9E3779B97F4A7C15u;
    bits = (bits ^ (bits >> 30)) * 0xBF58476D1CE4E5B9u;
    bits = (bits ^ (bits >> 27)) * 0x94D049BB133111EBu;
    return (double)((bits ^ (bits >> 31)) >> 12);
}

/* Frees the cache of the first thread when the program ends or unloads the library. */
#if defined __GNUC__
static void __attribute__((destructor)) clear_up(void)
{
    void *cache = own;
    if (!cache) return;
    own = NULL;
    if (has_key) pthread_setspecific(key, NULL);
    nutate_f77_free_cache(cache);
}
#endif
