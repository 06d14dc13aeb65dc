/* Start of a bare Cortex-M with an FPU: vectors, memory, main. No C library's start-up is needed. */
#include "semihosting.h"
#include <stdint.h>

extern uint32_t data_begin[], data_end[], data_source[], bss_begin[], bss_end[], stack_top[];
int main(void);
void reset(void);
void fault(void);

typedef void (*handler)(void);

/* Every exception that this image does not use ends it with code 3: HardFault and the like are faults of the code. */
__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack;
    handler handlers[15];
} vectors = { stack_top,
              { reset, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault } };

void reset(void)
{
    /* access to the FPU before anything that may use it; CPACR */
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20;
    __asm volatile("dsb\n\tisb" ::: "memory");
    for (uint32_t *to = data_begin, *from = data_source; to < data_end;) *to++ = *from++;
    for (uint32_t *to = bss_begin; to < bss_end;) *to++ = 0;
    semihosting_exit(main());
}

void fault(void) { semihosting_exit(3); }
