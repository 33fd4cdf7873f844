/* Names of the files in a folder, which Fortran cannot read.
 *
 * Called by the module nutate_folder only. No state is kept. */
#ifndef _DEFAULT_SOURCE
#define _DEFAULT_SOURCE
#endif

#include <dirent.h>
#include <errno.h>
#include <string.h>

int nutate_folder_names(const char *folder, const char *prefix, const char *suffix, char *names, int size, int *used);

/* Puts the names with this prefix and suffix, each followed by a slash, into `names` as far as there is room; `used` is
 * the number of bytes that all of them need. Returns 0 or an errno value. */
int nutate_folder_names(const char *folder, const char *prefix, const char *suffix, char *names, int size, int *used)
{
    size_t head = strlen(prefix), tail = strlen(suffix);
    DIR *stream = opendir(folder);
    *used = 0;
    if (!stream) return errno;
    errno = 0;
    for (struct dirent *entry = readdir(stream); entry; entry = readdir(stream)) {
        size_t length = strlen(entry->d_name);
        if (length < head + tail || strncmp(entry->d_name, prefix, head) != 0 ||
            strcmp(entry->d_name + length - tail, suffix) != 0)
            continue;
        if (*used + (int)length < size) {
            memcpy(names + *used, entry->d_name, length);
            names[*used + (int)length] = '/';
        }
        *used += (int)length + 1;
    }
    int error = errno;
    closedir(stream);
    return error;
}
