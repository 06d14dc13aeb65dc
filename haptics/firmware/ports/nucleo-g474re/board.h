/* NUCLEO-G474RE (STM32G474RE, Cortex-M4F at 170 MHz) with three MT6835 and three ESCON Module 50/5. */
#ifndef DELTA_NUCLEO_H
#define DELTA_NUCLEO_H

#include "../drivers/escon.h"
#include "../drivers/mt6835.h"
#include <stddef.h>
#include <stdint.h>

typedef struct {
    mt6835 encoder[3];
    escon drives;
    int by_watchdog;    /* 1 if the watchdog has reset the core */
    uint32_t overruns;  /* bytes and datagrams of the serial line that were lost */
} board_state;

extern board_state board_now;

/* All outputs as a fault leaves them: enable low, set values 0. Needs no memory but the registers: for fault handlers. */
void board_off(void);
/* Interrupt of the serial line. */
void board_serial(void);
/* A datagram or a record to the host, framed. */
void board_send(const void *data, size_t bytes);
/* Feeds the watchdog with all outputs off, until the supply goes: the end of a program. */
void board_stay_off(void);

#endif
