/* Threads for Fortran, which has none of its own. */
#include <pthread.h>

enum { MOST_THREADS = 64 };

typedef void work_t(void *context, int thread, int threads);

struct job {
   work_t *work;
   void *context;
   int thread, threads;
};

static void *run_job(void *argument)
{
   struct job *job = argument;
   job->work(job->context, job->thread, job->threads);
   return NULL;
}

/* Calls `work` from `threads` threads at once; the number of those that could not be started. */
int test_run_threads(work_t *work, void *context, int threads)
{
   struct job jobs[MOST_THREADS];
   pthread_t handles[MOST_THREADS];
   int i, started;
   if (threads > MOST_THREADS)
      return threads;
   for (started = 0; started < threads; ++started) {
      jobs[started] = (struct job){work, context, started, threads};
      if (pthread_create(&handles[started], NULL, run_job, &jobs[started]) != 0)
         break;
   }
   for (i = 0; i < started; ++i)
      pthread_join(handles[i], NULL);
   return threads - started;
}
