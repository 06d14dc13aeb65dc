/* The hardware layer on a NUCLEO-G474RE; PORTING.md has its wires. */
#include "board.h"
#include "../delta_controller.h"
#include "../delta_device.h"
#include "../delta_hal.h"
#include "../drivers/wires.h"
#include "registers.h"
#include <string.h>

/* Readings of a flag that a working chip sets long before: of an oscillator or the watchdog, and of a byte by SPI, where
 * waiting in vain for all encoders must leave time for the tick. */
enum { PATIENCE = 1000000, BYTE_PATIENCE = 300 };
enum { CLOCK_HZ = 170000000, TICK_DIVIDER = 10, BAUD = 2000000 };
enum { ENABLE_PIN = 0, STOP_PIN = 5 };           /* of port B */
enum { FIRST_ENCODER_PIN = 6 };                  /* of port C: 6, 7, 8 */
enum { DAC_MIDDLE = 2048, DAC_MOST = 4095 };
enum { WATCHDOG_STEPS = 40 };                    /* of 32 kHz / 4: 5 ms */
enum { BANDWIDTH = 3 };                          /* BW of the encoders, which the walls are computed with */
enum { FIRST_READINGS = 3 };
enum { MODE_OUTPUT = 1, MODE_OTHER = 2, MODE_ANALOG = 3 };
#define DAC_VOLT 3.3
static const unsigned ready_pin[3] = { 1, 2, 10 }; /* of port B */
/* Turn of an encoder against its joint's, 1 or -1; the start-up finds a wrong one. */
static const int encoder_sign[3] = { 1, 1, 1 };

board_state board_now;

/* Waits for bits of a register to have a value; 0 if they did. */
static int wait_for(uint32_t address, uint32_t bits, uint32_t value, long readings)
{
    for (long k = 0; k < readings; k++) {
        if ((reg_get(address) & bits) == value) return 0;
    }
    return 1;
}

static void pin_mode(uint32_t port, unsigned pin, uint32_t mode)
{
    reg_field(port + GPIO_MODER, 2 * pin, 3, mode);
    if (mode == MODE_OTHER || mode == MODE_OUTPUT) reg_field(port + GPIO_OSPEEDR, 2 * pin, 3, 2);
}

static void pin_function(uint32_t port, unsigned pin, uint32_t function)
{
    reg_field(port + (pin < 8 ? GPIO_AFRL : GPIO_AFRH), 4 * (pin & 7u), 15, function);
    pin_mode(port, pin, MODE_OTHER);
}

static void pin_pull_up(uint32_t port, unsigned pin)
{
    reg_field(port + GPIO_PUPDR, 2 * pin, 3, 1);
    reg_field(port + GPIO_MODER, 2 * pin, 3, 0);
}

static void pin_set(uint32_t port, unsigned pin, int high)
{
    reg_put(port + GPIO_BSRR, 1u << (high ? pin : pin + 16));
}

static int pin_is_high(uint32_t port, unsigned pin) { return (reg_get(port + GPIO_IDR) >> pin & 1u) != 0; }

/* 170 MHz from the board's crystal of 24 MHz: / 6 x 85 / 2; boost range, four wait states, caches on. */
static int clock(void)
{
    reg_set(RCC_CR, 1u << 16);
    if (wait_for(RCC_CR, 1u << 17, 1u << 17, PATIENCE) != 0) return 1;
    reg_set(RCC_APB1ENR1, 1u << 28);
    reg_field(PWR_CR5, 8, 1, 0);
    reg_field(FLASH_ACR, 0, 15, 4);
    reg_set(FLASH_ACR, 1u << 8 | 1u << 9 | 1u << 10);
    if (wait_for(FLASH_ACR, 15u, 4u, PATIENCE) != 0) return 1;
    reg_put(RCC_PLLCFGR, 3u | 5u << 4 | 85u << 8 | 1u << 24);
    reg_set(RCC_CR, 1u << 24);
    if (wait_for(RCC_CR, 1u << 25, 1u << 25, PATIENCE) != 0) return 1;
    reg_field(RCC_CFGR, 4, 15, 8); /* half of it for the first microsecond */
    reg_field(RCC_CFGR, 0, 3, 3);
    if (wait_for(RCC_CFGR, 3u << 2, 3u << 2, PATIENCE) != 0) return 1;
    for (int k = 0; k < 100; k++) (void)reg_get(RCC_CFGR);
    reg_field(RCC_CFGR, 4, 15, 0);
    return 0;
}

static void pins(void)
{
    reg_set(RCC_AHB2ENR, 1u << 0 | 1u << 1 | 1u << 2 | 1u << 16 | 1u << 17);
    (void)reg_get(RCC_AHB2ENR);
    board_off();
    pin_mode(GPIOB, ENABLE_PIN, MODE_OUTPUT);
    pin_pull_up(GPIOB, STOP_PIN);
    for (int joint = 0; joint < 3; joint++) {
        unsigned select = FIRST_ENCODER_PIN + (unsigned)joint;
        pin_pull_up(GPIOB, ready_pin[joint]);
        pin_set(GPIOC, select, 1);
        pin_mode(GPIOC, select, MODE_OUTPUT);
        pin_mode(GPIOA, 4 + (unsigned)joint, MODE_ANALOG);
    }
    reg_put(DAC1 + DAC_MCR, 2u << 14); /* to the pins, buffered; the bus is faster than 160 MHz */
    reg_put(DAC2 + DAC_MCR, 2u << 14);
    reg_put(DAC1 + DAC_CR, 1u << 0 | 1u << 16);
    reg_put(DAC2 + DAC_CR, 1u << 0);
}

static void serial(void)
{
    reg_set(RCC_APB1ENR2, 1u << 0);
    pin_function(GPIOA, 2, 12);
    pin_function(GPIOA, 3, 12);
    reg_put(LPUART1_BRR, (uint32_t)((256ull * CLOCK_HZ + BAUD / 2) / BAUD));
    reg_put(LPUART1_CR1, 1u << 0 | 1u << 2 | 1u << 3 | 1u << 5);
    reg_put(NVIC_ISER2, 1u << (91 - 64));
}

static void encoders(void)
{
    reg_set(RCC_APB1ENR1, 1u << 15);
    for (unsigned pin = 10; pin < 13; pin++) pin_function(GPIOC, pin, 6);
    reg_put(SPI3_CR2, 7u << 8 | 1u << 12);                                              /* bytes */
    reg_put(SPI3_CR1, 1u << 0 | 1u << 1 | 1u << 2 | 3u << 3 | 1u << 8 | 1u << 9 | 1u << 6); /* mode 3, 10.6 MHz */
}

static void timers(void)
{
    reg_set(RCC_APB1ENR1, 1u << 0 | 1u << 4);
    reg_put(TIM2_ARR, 0xFFFFFFFFu);
    reg_put(TIM2_EGR, 1);
    reg_put(TIM2_CR1, 1);
    reg_put(TIM6_PSC, TICK_DIVIDER - 1);
    reg_put(TIM6_ARR, (uint32_t)(DELTA_PERIOD_S * (CLOCK_HZ / TICK_DIVIDER) + 0.5) - 1);
    reg_put(TIM6_EGR, 1);
    reg_put(TIM6_SR, 0);
    reg_put(TIM6_CR1, 1);
}

int hal_begin(void)
{
    memset(&board_now, 0, sizeof board_now);
    board_now.by_watchdog = (int)(reg_get(RCC_CSR) >> 29 & 1u);
    reg_set(RCC_CSR, 1u << 23); /* forgets the cause of this reset */
    pins();
    escon_begin(&board_now.drives);
    if (clock() != 0) return 1;
    serial();
    encoders();
    timers();
    reg_put(IWDG_KR, 0xCCCC);
    reg_put(IWDG_KR, 0x5555);
    reg_put(IWDG_PR, 0);
    reg_put(IWDG_RLR, WATCHDOG_STEPS);
    if (wait_for(IWDG_SR, 7u, 0, PATIENCE) != 0) return 1;
    hal_watchdog();
    if (board_now.by_watchdog) return 1; /* it does not start by itself again */
    for (int joint = 0; joint < 3; joint++) {
        mt6835 *chip = &board_now.encoder[joint];
        if (mt6835_begin(chip, joint, BANDWIDTH) != 0) return 1;
        int good = 0;
        for (int k = 0; k < FIRST_READINGS; k++) good = mt6835_read(chip, joint) == MT6835_FRESH; /* the first is old */
        if (!good) return 1;
    }
    return 0;
}

void hal_wait(void)
{
    while ((reg_get(TIM6_SR) & 1u) == 0) {} /* the watchdog ends it if the timer stands */
    reg_put(TIM6_SR, 0);
}

double hal_now(void)
{
    static uint32_t last;
    static uint64_t turns; /* of 2^32 counts, 25 s each */
    uint32_t count = reg_get(TIM2_CNT);
    if (count < last) turns++;
    last = count;
    return (double)(turns << 32 | count) / CLOCK_HZ;
}

int hal_encoders(double angle[3], int fresh[3])
{
    int answered = 0;
    for (int joint = 0; joint < 3; joint++) {
        mt6835 *chip = &board_now.encoder[joint];
        mt6835_finding found = mt6835_read(chip, joint);
        answered = answered || (found != MT6835_NO_TRANSFER && found != MT6835_DEAD_LINE);
        fresh[joint] = found == MT6835_FRESH;
        angle[joint] = encoder_sign[joint] * mt6835_rad(chip->count);
    }
    return answered ? 0 : 1;
}

#if DELTA_DRIVES_DAMP
#error "the ESCON adds no damping, and the walls of this design count on it: leave loop.drive_damping out of its file"
#endif
void hal_damping(int joint, double share)
{
    (void)joint;
    (void)share;
}

void hal_current(int joint, double ampere) { escon_current(&board_now.drives, joint, ampere); }
void hal_enable(int on) { escon_enable(&board_now.drives, on); }
int hal_healthy(void) { return escon_healthy(&board_now.drives); }
/* A contact that opens, and a wire that breaks: both read high. */
int hal_stop_pressed(void) { return pin_is_high(GPIOB, STOP_PIN); }
void hal_watchdog(void) { reg_put(IWDG_KR, 0xAAAA); }

void board_off(void)
{
    pin_set(GPIOB, ENABLE_PIN, 0);
    reg_put(DAC1 + DAC_DHR12R1, DAC_MIDDLE);
    reg_put(DAC1 + DAC_DHR12R2, DAC_MIDDLE);
    reg_put(DAC2 + DAC_DHR12R1, DAC_MIDDLE);
}

void board_stay_off(void)
{
    escon_begin(&board_now.drives);
    for (;;) {
        board_off();
        hal_watchdog();
    }
}

int wire_encoder(int joint, const unsigned char *out, unsigned char *in, size_t bytes)
{
    unsigned select = FIRST_ENCODER_PIN + (unsigned)joint;
    int failed = 0;
    for (int k = 0; k < 4 && (reg_get(SPI3_SR) & 1u << 0); k++) (void)reg_get(SPI3_DR); /* left by one that failed */
    pin_set(GPIOC, select, 0);
    for (int k = 0; k < 8; k++) (void)reg_get(SPI3_SR); /* 100 ns and more before the first clock */
    for (size_t k = 0; k < bytes && !failed; k++) {
        failed = wait_for(SPI3_SR, 1u << 1, 1u << 1, BYTE_PATIENCE);
        reg_put_byte(SPI3_DR, out[k]);
        failed = failed || wait_for(SPI3_SR, 1u << 0, 1u << 0, BYTE_PATIENCE);
        in[k] = (unsigned char)reg_get(SPI3_DR);
    }
    pin_set(GPIOC, select, 1);
    return failed;
}

void wire_set_value(int joint, double volt)
{
    double code = DAC_MIDDLE + volt * (DAC_MOST + 1) / DAC_VOLT + 0.5;
    uint32_t given = !(code > 0.0) ? 0u : code > DAC_MOST ? (uint32_t)DAC_MOST : (uint32_t)code;
    uint32_t place = joint == 0 ? DAC1 + DAC_DHR12R1 : joint == 1 ? DAC1 + DAC_DHR12R2 : DAC2 + DAC_DHR12R1;
    reg_put(place, given);
}

void wire_enable(int on) { pin_set(GPIOB, ENABLE_PIN, on); }
int wire_ready(int joint) { return !pin_is_high(GPIOB, ready_pin[joint]); }
