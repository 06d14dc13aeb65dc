/* Start of the STM32G474: vectors, memory, main. A fault of the core switches the outputs off and stands still; the
 * watchdog then resets, and hal_begin refuses to go on by itself. */
#include "board.h"
#include <stdint.h>

extern uint32_t data_begin[], data_end[], data_source[], bss_begin[], bss_end[], stack_top[];
int main(void);
void reset(void);
void fault(void);

typedef void (*handler)(void);

enum { CORE = 15, LPUART1 = 91 };

__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack;
    handler core[CORE];
    handler chip[LPUART1 + 1];
} vectors = { stack_top,
              { reset, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault, fault },
              { [0] = fault, [LPUART1] = board_serial } };

void reset(void)
{
    /* access to the FPU before anything that may use it; CPACR */
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20;
    __asm volatile("dsb\n\tisb" ::: "memory");
    for (uint32_t *to = data_begin, *from = data_source; to < data_end;) *to++ = *from++;
    for (uint32_t *to = bss_begin; to < bss_end;) *to++ = 0;
    (void)main();
    board_stay_off();
}

void fault(void)
{
    board_off();
    for (;;) {}
}
