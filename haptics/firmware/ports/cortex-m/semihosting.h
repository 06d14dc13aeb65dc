/* Files of the host and the end of the program by Arm's semihosting: for QEMU and for a debugger, not for a device. */
#ifndef SEMIHOSTING_H
#define SEMIHOSTING_H

#include <stddef.h>

enum { SEMIHOSTING_READ = 1, SEMIHOSTING_WRITE = 5 }; /* "rb", "wb" */

/* Handle of a file, or a negative number. */
int semihosting_open(const char *name, int mode);
/* Number of bytes that were read or written. */
size_t semihosting_read(int file, void *to, size_t bytes);
size_t semihosting_write(int file, const void *from, size_t bytes);
void semihosting_close(int file);
/* Ends the program with an exit code. */
void semihosting_exit(int code);

#endif
