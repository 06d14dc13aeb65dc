/* Replays a recording through the controller: replay.in -> replay.out, on a Cortex-M by semihosting, elsewhere by stdio.
 *
 * replay.in: u32 ticks, u32 laws, the table of laws, then for each tick a `reading`. replay.out: for each tick an
 * `answer`, then the whole memory. All in the byte order and with the reals of the machine that replays. */
#include "delta_controller.h"
#include <stdint.h>
#include <string.h>

enum { NOTHING, ENABLE, DISABLE, RESET, HEARD };
enum { BLOCK = 128, MOST_LAWS = 32 };

typedef struct {
    double now;
    delta_real theta[3];
    int32_t request;
    uint32_t signal;
    uint32_t fresh; /* bit i of joint i */
} reading;

typedef struct {
    long long bits;
    delta_real torque[3];
    uint32_t took; /* counts of the machine's clock, 0 where it has none */
} answer;

static struct {
    delta_memory memory;
    delta_made made;
    delta_real laws[MOST_LAWS][DELTA_LAW_COLUMNS];
    reading in[BLOCK];
    answer out[BLOCK];
} all;

#ifdef __arm__
#include "semihosting.h"
#define SYST_CSR (*(volatile uint32_t *)0xE000E010u)
#define SYST_RVR (*(volatile uint32_t *)0xE000E014u)
#define SYST_CVR (*(volatile uint32_t *)0xE000E018u)
static uint32_t clock_now(void) { return SYST_CVR; }
static uint32_t clock_between(uint32_t a, uint32_t b) { return (a - b) & 0xFFFFFFu; } /* it counts down */
static void clock_start(void)
{
    SYST_RVR = 0xFFFFFFu;
    SYST_CVR = 0;
    SYST_CSR = 5;
}
#define open_file(name, writing) semihosting_open(name, (writing) ? SEMIHOSTING_WRITE : SEMIHOSTING_READ)
#define read_file semihosting_read
#define write_file semihosting_write
#define close_file semihosting_close
typedef int file;
static int opened(file f) { return f >= 0; }
#else
#include <stdio.h>
static uint32_t clock_now(void) { return 0; }
static uint32_t clock_between(uint32_t a, uint32_t b) { return a - b; }
static void clock_start(void) {}
typedef FILE *file;
static int opened(file f) { return f != NULL; }
static file open_file(const char *name, int writing) { return fopen(name, writing ? "wb" : "rb"); }
static size_t read_file(file f, void *to, size_t bytes) { return fread(to, 1, bytes, f); }
static size_t write_file(file f, const void *from, size_t bytes) { return fwrite(from, 1, bytes, f); }
static void close_file(file f) { (void)fclose(f); }
#endif

static void request(const reading *r)
{
    switch (r->request) {
    case ENABLE: delta_enable(&all.memory); break;
    case DISABLE: delta_disable(&all.memory); break;
    case RESET: delta_reset(&all.memory); break;
    case HEARD: delta_heard(&all.memory, r->now); break;
    default: break;
    }
    delta_signal(&all.memory, (long long)r->signal);
}

int main(void)
{
    file from = open_file("replay.in", 0), to = open_file("replay.out", 1);
    uint32_t head[2];
    if (!opened(from) || !opened(to) || read_file(from, head, sizeof head) != sizeof head) return 2;
    uint32_t left = head[0], rows = head[1];
    if (rows > MOST_LAWS) return 2;
    if (read_file(from, all.laws, rows * sizeof all.laws[0]) != rows * sizeof all.laws[0]) return 2;
    delta_start(&all.memory);
    clock_start();
    while (left > 0) {
        uint32_t many = left < BLOCK ? left : BLOCK;
        if (read_file(from, all.in, many * sizeof(reading)) != many * sizeof(reading)) return 2;
        memset(all.out, 0, sizeof all.out);
        for (uint32_t k = 0; k < many; k++) {
            const reading *r = &all.in[k];
            answer *a = &all.out[k];
            delta_real theta[3], torque[3];
            int fresh[3];
            request(r);
            for (int j = 0; j < 3; j++) fresh[j] = (int)((r->fresh >> j) & 1u);
            uint32_t begun = clock_now();
            delta_drawn(&all.made, r->theta, theta);
            a->bits = delta_tick(&all.memory, all.laws[0], (long)rows, r->now, theta, r->theta, fresh, torque);
            delta_turned(&all.made, torque, a->torque);
            a->took = clock_between(begun, clock_now());
        }
        if (write_file(to, all.out, many * sizeof(answer)) != many * sizeof(answer)) return 2;
        left -= many;
    }
    size_t whole = write_file(to, &all.memory, sizeof all.memory);
    close_file(from);
    close_file(to);
    return whole == sizeof all.memory ? 0 : 2;
}
