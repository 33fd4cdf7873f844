/* Functions for files that Fortran does not have: the reason of an error, locks, atomic renaming, terminals.
 *
 * Called through nutate_file_calls only. Functions that can fail return 0 or an errno value. No state is kept. */
#ifndef _DEFAULT_SOURCE
#define _DEFAULT_SOURCE
#endif

#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

/* Kinds of file that a name can stand for; nutate_files.f90 has the same numbers. */
enum { KIND_ABSENT = 0, KIND_REGULAR = 1, KIND_FOLDER = 2, KIND_OTHER = 3 };

/* Results that are no errno values: another process holds the lock; the file is too short. */
enum { LOCKED = -1, TOO_SHORT = -2 };

/* Longest wait for a reader after a request to stop, ms; bytes that a pipe that is ready accepts at once. */
enum { PATIENCE = 1000, PIPE_ROOM = 4096 };

/* Longest path that a link leads to, and links in a row before they are treated as a circle: the limits of Linux. */
enum { LONGEST_PATH = 4096, MOST_LINKS = 40 };

/* Stack that the program needs, bytes: scenes are checked and run with half of it. */
enum { LEAST_STACK = 512 << 10 };

int nutate_file_kind(const char *path);
int nutate_file_target(const char *path, char *target, int size, int *longest);
int nutate_file_same(const char *a, const char *b);
int nutate_file_readable(const char *path);
int nutate_file_replaceable(const char *path);
int nutate_file_open(const char *path, const volatile sig_atomic_t *stop, int *descriptor);
int nutate_file_open_locked(const char *path, long long keep, int *descriptor);
int nutate_file_open_beside(const char *path, long long size, int *descriptor);
int nutate_file_write(int descriptor, const char *bytes, long long count, const volatile sig_atomic_t *stop,
                      long long *written);
int nutate_file_write_at(int descriptor, const char *bytes, long long count, long long offset);
int nutate_file_replace(const char *path, const char *temporary, const char *bytes, long long count);
int nutate_file_remove(const char *path);
int nutate_file_sync(int descriptor);
int nutate_file_read_tail(const char *path, long long end, char *bytes, int size, int *count);
int nutate_file_truncate(int descriptor, long long size);
int nutate_file_settle(int descriptor);
int nutate_file_close(int descriptor);
int nutate_file_rename(const char *from, const char *to);
int nutate_file_is_terminal(int descriptor);
void nutate_file_error_text(int error, char *text, int size);
void nutate_file_prepare_process(void);

/* Returns the kind of file that a path stands for, links followed. */
int nutate_file_kind(const char *path)
{
    struct stat info;
    if (stat(path, &info) != 0) return KIND_ABSENT;
    if (S_ISREG(info.st_mode)) return KIND_REGULAR;
    if (S_ISDIR(info.st_mode)) return KIND_FOLDER;
    return KIND_OTHER;
}

/* Replaces the path of a link, which has room for `size` bytes, by the path that the link leads to. */
static int follow_link(char *path, int size)
{
    char text[LONGEST_PATH];
    ssize_t length = readlink(path, text, sizeof text);
    if (length < 0) return errno;
    const char *slash = strrchr(path, '/');
    int folder = length > 0 && text[0] != '/' && slash ? (int)(slash + 1 - path) : 0;
    if (length == (ssize_t)sizeof text || folder + length >= size) return ENAMETOOLONG;
    memcpy(path + folder, text, (size_t)length);
    path[folder + length] = '\0';
    return 0;
}

/* Returns the length of the longest name that a file can have in the folder of a path, bytes. */
static int longest_name(const char *path)
{
    char *copy = strdup(path);
    long longest = copy ? pathconf(dirname(copy), _PC_NAME_MAX) : -1;
    free(copy);
    return longest > 0 && longest < LONGEST_PATH ? (int)longest : NAME_MAX;
}

/* Finds the file that a path stands for: the end of its links, which need not exist yet. Its name must be no longer
 * than its folder admits. */
int nutate_file_target(const char *path, char *target, int size, int *longest)
{
    struct stat info;
    *longest = 0;
    if (snprintf(target, (size_t)size, "%s", path) >= size) return ENAMETOOLONG;
    for (int links = 0; lstat(target, &info) == 0 && S_ISLNK(info.st_mode); links++) {
        int error = links < MOST_LINKS ? follow_link(target, size) : ELOOP;
        if (error) return error;
    }
    *longest = longest_name(target);
    const char *slash = strrchr(target, '/');
    return strlen(slash ? slash + 1 : target) <= (size_t)*longest ? 0 : ENAMETOOLONG;
}

/* Returns 1 if two paths lead to the same name in the same folder; the file need not exist yet. */
static int same_place(const char *a, const char *b)
{
    char first[LONGEST_PATH], second[LONGEST_PATH];
    struct stat one, other;
    int longest;
    if (nutate_file_target(a, first, sizeof first, &longest) || nutate_file_target(b, second, sizeof second, &longest)) return 0;
    const char *first_slash = strrchr(first, '/'), *second_slash = strrchr(second, '/');
    if (strcmp(first_slash ? first_slash + 1 : first, second_slash ? second_slash + 1 : second) != 0) return 0;
    if (stat(dirname(first), &one) != 0 || stat(dirname(second), &other) != 0) return 0;
    return one.st_dev == other.st_dev && one.st_ino == other.st_ino;
}

/* Returns 1 if two paths stand for the same file, existing or still to be written. */
int nutate_file_same(const char *a, const char *b)
{
    struct stat first, second;
    int there = (stat(a, &first) == 0) + (stat(b, &second) == 0);
    if (there == 0) return same_place(a, b);
    return there == 2 && first.st_dev == second.st_dev && first.st_ino == second.st_ino;
}

/* Returns 0 if a file exists, may be read and is no folder. Call it before every OPEN: compiled by flang 22, an OPEN that fails
 * removes the file. */
int nutate_file_readable(const char *path)
{
    if (access(path, R_OK) != 0) return errno;
    return nutate_file_kind(path) == KIND_FOLDER ? EISDIR : 0;
}

/* Returns 0 if a file may be replaced: one marked read-only may not, though rename() would do it. */
int nutate_file_replaceable(const char *path)
{
    return access(path, W_OK) == 0 ? 0 : errno;
}

/* Opens a pipe or device for writing; waits for a reader until the value at `stop`, if given, is nonzero. */
int nutate_file_open(const char *path, const volatile sig_atomic_t *stop, int *descriptor)
{
    do {
        *descriptor = open(path, O_WRONLY | O_NOCTTY | O_CLOEXEC);
    } while (*descriptor < 0 && errno == EINTR && !(stop && *stop));
    return *descriptor < 0 ? errno : 0;
}

/* Opens a file that no other process may write until it is closed; LOCKED if one does. Without bytes to keep, the file
 * is created, or emptied: after it is locked, and only if the name still stands for the locked file. With bytes to
 * keep, the file must exist, TOO_SHORT if it has fewer, and is left as it is. */
int nutate_file_open_locked(const char *path, long long keep, int *descriptor)
{
    struct stat held, named;
    int error = LOCKED, flags = O_WRONLY | O_NOCTTY | O_CLOEXEC | (keep > 0 ? 0 : O_CREAT);
    for (int attempt = 0; attempt < 100; attempt++) {
        *descriptor = open(path, flags, 0666);
        if (*descriptor < 0) return errno;
        error = flock(*descriptor, LOCK_EX | LOCK_NB) == 0 ? 0 : errno;
        if (error == EWOULDBLOCK) {
            error = LOCKED;
            break;
        }
        /* Any other error means a file system without locks: the file is written without one. */
        error = fstat(*descriptor, &held) == 0 ? 0 : errno;
        if (error) break;
        if (stat(path, &named) == 0 && held.st_dev == named.st_dev && held.st_ino == named.st_ino) {
            if (!S_ISREG(held.st_mode)) error = EEXIST;
            else if (keep > 0) error = held.st_size < keep ? TOO_SHORT : 0;
            else error = ftruncate(*descriptor, 0) == 0 ? 0 : errno;
            if (!error) return 0;
            break;
        }
        close(*descriptor);
        error = LOCKED;
        *descriptor = -1;
    }
    if (*descriptor >= 0) close(*descriptor);
    *descriptor = -1;
    return error;
}

/* Opens a file that another process holds locked, to write to agreed parts of it. A file shorter than `size` is not the
 * one that the other process has open: ESTALE. */
int nutate_file_open_beside(const char *path, long long size, int *descriptor)
{
    struct stat info;
    *descriptor = open(path, O_WRONLY | O_NOCTTY | O_CLOEXEC);
    if (*descriptor < 0) return errno;
    int error = fstat(*descriptor, &info) == 0 ? 0 : errno;
    if (!error && !S_ISREG(info.st_mode)) error = EEXIST;
    if (!error && info.st_size < size) error = ESTALE;
    if (!error) return 0;
    close(*descriptor);
    *descriptor = -1;
    return error;
}

/* Returns 1 if a descriptor accepts more bytes within PATIENCE; files on a disk always do. */
static int takes_more(int descriptor)
{
    struct pollfd wanted = {descriptor, POLLOUT, 0};
    return poll(&wanted, 1, PATIENCE) != 0;
}

/* Writes all bytes; on failure `written` is the number of bytes written. If the value at `stop` is nonzero, the call
 * does not wait for a reader that accepts nothing: EINTR. */
int nutate_file_write(int descriptor, const char *bytes, long long count, const volatile sig_atomic_t *stop,
                      long long *written)
{
    *written = 0;
    while (*written < count) {
        long long portion = count - *written;
        if (stop && *stop) {
            if (!takes_more(descriptor)) return EINTR;
            if (portion > PIPE_ROOM) portion = PIPE_ROOM;
        }
        ssize_t n = write(descriptor, bytes + *written, (size_t)portion);
        if (n > 0) *written += n;
        else if (n == 0) return EIO;
        else if (errno != EINTR) return errno;
    }
    return 0;
}

/* Writes all bytes at a position; the position of other writes does not change. */
int nutate_file_write_at(int descriptor, const char *bytes, long long count, long long offset)
{
    for (long long written = 0; written < count;) {
        ssize_t n = pwrite(descriptor, bytes + written, (size_t)(count - written), (off_t)(offset + written));
        if (n > 0) written += n;
        else if (n == 0) return EIO;
        else if (errno != EINTR) return errno;
    }
    return 0;
}

/* Truncates a file; writing continues at its new end. */
int nutate_file_truncate(int descriptor, long long size)
{
    if (ftruncate(descriptor, (off_t)size) != 0) return errno;
    return lseek(descriptor, (off_t)size, SEEK_SET) < 0 ? errno : 0;
}

/* Syncs a file to the disk. */
int nutate_file_sync(int descriptor)
{
    return fsync(descriptor) == 0 ? 0 : errno;
}

/* Reads the last `count` <= `size` bytes before `end`. */
int nutate_file_read_tail(const char *path, long long end, char *bytes, int size, int *count)
{
    int error = 0, descriptor = open(path, O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) return errno;
    *count = end < size ? (int)end : size;
    for (int done = 0; done < *count && !error;) {
        ssize_t n = pread(descriptor, bytes + done, (size_t)(*count - done), (off_t)(end - *count + done));
        if (n > 0) done += (int)n;
        else if (n == 0) error = EIO;
        else if (errno != EINTR) error = errno;
    }
    close(descriptor);
    return error;
}

/* Syncs the folder of a path, with a new name in it, to the disk. */
static int sync_folder(const char *path)
{
    char *copy = strdup(path);
    if (!copy) return ENOMEM;
    int descriptor = open(dirname(copy), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    free(copy);
    if (descriptor < 0) return errno;
    /* EINVAL means a file system that cannot sync folders, which is no error. */
    int error = fsync(descriptor) == 0 || errno == EINVAL ? 0 : errno;
    close(descriptor);
    return error;
}

/* Gives a file new content: at every moment, and after a crash too, the name stands for the old or for the new one. */
int nutate_file_replace(const char *path, const char *temporary, const char *bytes, long long count)
{
    long long written;
    int descriptor = open(temporary, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (descriptor < 0) return errno;
    int error = nutate_file_write(descriptor, bytes, count, NULL, &written);
    if (!error && fsync(descriptor) != 0) error = errno;
    if (close(descriptor) != 0 && !error && errno != EINTR) error = errno;
    if (!error && rename(temporary, path) != 0) error = errno;
    if (error) {
        unlink(temporary);
        return error;
    }
    return sync_folder(path);
}

int nutate_file_remove(const char *path)
{
    return unlink(path) == 0 ? 0 : errno;
}

/* Returns the errors that closing the file would report, without giving up its lock. */
int nutate_file_settle(int descriptor)
{
    int copy = dup(descriptor);
    if (copy < 0) return errno;
    return close(copy) == 0 || errno == EINTR ? 0 : errno;
}

int nutate_file_close(int descriptor)
{
    return close(descriptor) == 0 || errno == EINTR ? 0 : errno;
}

int nutate_file_rename(const char *from, const char *to)
{
    return rename(from, to) == 0 ? 0 : errno;
}

/* For a program, not a library. A limit on the size of files is to be an error of write(); a signal that ends the
 * program is to end it without the backtrace that Fortran runtimes print; no file that is opened later is to take the
 * number of a standard stream that the caller has closed, for messages would end up in it; a stack that is too small is to
 * end the program with a message. */
void nutate_file_prepare_process(void)
{
    struct rlimit stack;
    if (getrlimit(RLIMIT_STACK, &stack) == 0 && stack.rlim_cur < LEAST_STACK) {
        static const char message[] = "nutate: the limit of the stack is too small (expected ulimit -s 512, or more)\n";
        _exit(write(2, message, sizeof message - 1) < 0 ? 4 : 3);
    }
    signal(SIGXFSZ, SIG_IGN);
    signal(SIGXCPU, SIG_DFL);
    signal(SIGQUIT, SIG_DFL);
    for (int descriptor = 0; descriptor <= 2; descriptor++) {
        /* Read-only, so that writing to a closed stream stays an error. */
        if (fcntl(descriptor, F_GETFD) < 0 && open("/dev/null", O_RDONLY) < 0) return;
    }
}

int nutate_file_is_terminal(int descriptor)
{
    return isatty(descriptor);
}

/* Writes the system's message for an error, cut to `size` with the terminating null. */
void nutate_file_error_text(int error, char *text, int size)
{
    snprintf(text, (size_t)size, "%s", strerror(error));
}
