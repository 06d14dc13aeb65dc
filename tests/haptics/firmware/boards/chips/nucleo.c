/* The registers of an STM32G474 with what hangs on its pins: three simulated MT6835, drives, the simulated device, the
 * serial line on stdin and stdout. nucleo MODE SECONDS [FAULT JOINT AT]: `alone` as fast as it goes, `linked` a tick for
 * each packet of the host. At the end, on stderr: ticks, feeds of the watchdog, and how long after the fault the enable
 * pin and all currents were off for good, ms. */
#include "../delta_device.h"
#include "../delta_controller.h"
#include "../nucleo-g474re/board.h"
#include "../nucleo-g474re/registers.h"
#include "../simulated/device.h"
#include "chip.h"
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int port_main(void);

enum { PLACES = 64, RECEIVED = 4096 };
static struct {
    uint32_t address, value;
} stored[PLACES];
static int used;

static const char *fault = "none";
static int linked, fault_joint, selected = -1;
static double seconds = 9.0, fault_at = 1e9, on_until = -1.0;
static long ticks, feeds;
static uint32_t noise = 1;
static uint32_t pins_b;
static chip chips[3];
static unsigned char frame_in, line_in[RECEIVED];
static int has_frame, has_byte, line_at, line_length;
static double code[3] = { 2048.0, 2048.0, 2048.0 };

static double now(void) { return (double)ticks * DELTA_PERIOD_S; }
static int faulty(const char *name) { return now() >= fault_at && strcmp(fault, name) == 0; }

static uint32_t *place(uint32_t address)
{
    for (int k = 0; k < used; k++) {
        if (stored[k].address == address) return &stored[k].value;
    }
    if (used == PLACES) abort();
    stored[used].address = address;
    return &stored[used++].value;
}

static int enabled(void) { return (pins_b & 1u) != 0; }

static double ampere(int joint)
{
    double volt = (code[joint] - 2048.0) * 3.3 / 4096.0;
    return enabled() && !(faulty("ready") && joint == fault_joint) ? volt / ESCON_VOLT_PER_A : 0.0;
}

static void end(int ended)
{
    fprintf(stderr, "ended %d, %ld ticks, %ld feeds, enable %d, off after %.3f ms\n", ended, ticks, feeds, enabled(),
            1e3 * (on_until - fault_at));
    exit(0);
}

static void talk(void)
{
    while (*place(LPUART1_CR1) & 1u << 7) board_serial();
    fflush(stdout);
    struct pollfd one = { 0, POLLIN, 0 };
    if (!linked || poll(&one, 1, 50) <= 0) return;
    ssize_t got = read(0, line_in, sizeof line_in);
    if (got <= 0) end(0);
    line_at = 0;
    line_length = (int)got;
    while (line_at < line_length) {
        has_byte = 1;
        board_serial();
    }
}

static void tick(void)
{
    double torque[3], angle[3];
    talk();
    for (int j = 0; j < 3; j++) torque[j] = ampere(j) / DELTA_AMPERE_PER_N_M;
    device_step(torque, 0, DELTA_PERIOD_S);
    ticks++;
    device_angles(angle);
    for (int j = 0; j < 3; j++) {
        noise = noise * 1664525u + 1013904223u;
        int32_t counts = (int32_t)nearbyint(angle[j] / DELTA_COUNT_RAD) + (int32_t)(noise >> 28) - 7;
        int hit = j == fault_joint;
        if (!(faulty("stuck") && hit)) chips[j].angle = (uint32_t)counts & 0x1FFFFFu;
        chips[j].flips = faulty("crc") && hit ? 0x40u : 0u;
        chips[j].status = faulty("weak") && hit ? 2u : 0u;
        chips[j].line = hit && faulty("zeros") ? 0 : hit && faulty("ones") ? 1 : -1;
        if (now() > fault_at && (enabled() || fabs(ampere(j)) > 0.01)) on_until = now();
    }
    if (now() > seconds) end(0);
}

uint32_t reg_get(uint32_t address)
{
    uint32_t value = *place(address);
    switch (address) {
    case RCC_CR: return value | ((value & 1u << 16) && strcmp(fault, "crystal") != 0 ? 1u << 17 : 0u) |
                        (value & 1u << 24 ? 1u << 25 : 0u);
    case RCC_CFGR: return value | (value & 3u) << 2;
    case RCC_CSR: return value | (strcmp(fault, "watchdog") == 0 ? 1u << 29 : 0u);
    case TIM6_SR: tick(); return 1;
    case TIM2_CNT: return (uint32_t)(uint64_t)(now() * 170e6 + 0.5);
    case SPI3_SR: return 2u | (has_frame && !(selected == fault_joint && faulty("bus")) ? 1u : 0u);
    case SPI3_DR: has_frame = 0; return frame_in;
    case LPUART1_ISR: return 1u << 7 | (has_byte ? 1u << 5 : 0u);
    case LPUART1_RDR:
        has_byte = 0;
        return line_in[line_at++];
    case GPIOB + GPIO_IDR: {
        static const unsigned ready[3] = { 1, 2, 10 };
        uint32_t levels = pins_b & 1u;
        if (faulty("stop")) levels |= 1u << 5;
        if (faulty("ready")) levels |= 1u << ready[fault_joint];
        return levels;
    }
    default: return value;
    }
}

void reg_put(uint32_t address, uint32_t value)
{
    *place(address) = value;
    switch (address) {
    case GPIOB + GPIO_BSRR: pins_b = (pins_b | (value & 0xFFFFu)) & ~(value >> 16); break;
    case GPIOC + GPIO_BSRR:
        for (int j = 0; j < 3; j++) {
            if (value >> (6 + j + 16) & 1u) chip_select(&chips[selected = j], 1);
        }
        break;
    case DAC1 + DAC_DHR12R1: code[0] = value; break;
    case DAC1 + DAC_DHR12R2: code[1] = value; break;
    case DAC2 + DAC_DHR12R1: code[2] = value; break;
    case IWDG_KR: feeds += value == 0xAAAA; break;
    case LPUART1_TDR: putchar((int)value); break;
    default: break;
    }
}

void reg_put_byte(uint32_t address, uint32_t value)
{
    if (address != SPI3_DR || selected < 0) abort();
    frame_in = chip_exchange(&chips[selected], (unsigned char)value);
    has_frame = 1;
}

int main(int many, char **words)
{
    linked = many > 1 && strcmp(words[1], "linked") == 0;
    if (many > 2) seconds = atof(words[2]);
    if (many > 5) {
        fault = words[3];
        fault_joint = atoi(words[4]);
        fault_at = atof(words[5]);
    }
    for (int j = 0; j < 3; j++) {
        chip_reset(&chips[j]);
        chips[j].angle = 7u;
    }
    device_begin(!linked);
    int ended = port_main();
    talk();
    end(ended);
    return 0;
}
