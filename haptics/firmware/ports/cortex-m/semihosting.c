#include "semihosting.h"
#include <stdint.h>
#include <string.h>

enum { OPEN = 0x01, CLOSE = 0x02, WRITE = 0x05, READ = 0x06, EXIT_EXTENDED = 0x20 };
#define APPLICATION_EXIT 0x20026u

static uint32_t call(uint32_t operation, const uint32_t *block)
{
    register uint32_t r0 __asm("r0") = operation;
    register const uint32_t *r1 __asm("r1") = block;
    __asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

int semihosting_open(const char *name, int mode)
{
    uint32_t block[3] = { (uint32_t)(uintptr_t)name, (uint32_t)mode, (uint32_t)strlen(name) };
    return (int)call(OPEN, block);
}

size_t semihosting_read(int file, void *to, size_t bytes)
{
    uint32_t block[3] = { (uint32_t)file, (uint32_t)(uintptr_t)to, (uint32_t)bytes };
    return bytes - call(READ, block); /* it returns what is left */
}

size_t semihosting_write(int file, const void *from, size_t bytes)
{
    uint32_t block[3] = { (uint32_t)file, (uint32_t)(uintptr_t)from, (uint32_t)bytes };
    return bytes - call(WRITE, block);
}

void semihosting_close(int file)
{
    uint32_t block[1] = { (uint32_t)file };
    (void)call(CLOSE, block);
}

void semihosting_exit(int code)
{
    uint32_t block[2] = { APPLICATION_EXIT, (uint32_t)code };
    for (;;) (void)call(EXIT_EXTENDED, block);
}
