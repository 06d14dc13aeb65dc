/* The drivers' wires for their own tests: three simulated encoders, and drives of which the lines are kept. */
#include "wires.h"
#include "chip.h"

chip chips[3];
int breaks_off_at[3] = { -1, -1, -1 }; /* number of bytes after which the bus fails; -1: never */
double set_value[3] = { 9.0, 9.0, 9.0 };
int enabled = -1, ready[3] = { 1, 1, 1 };

int wire_encoder(int joint, const unsigned char *out, unsigned char *in, size_t bytes)
{
    int failed = 0;
    chip_select(&chips[joint], 1);
    for (size_t k = 0; k < bytes && !failed; k++) {
        failed = (int)k == breaks_off_at[joint];
        if (!failed) in[k] = chip_exchange(&chips[joint], out[k]);
    }
    chip_select(&chips[joint], 0);
    return failed;
}

void wire_set_value(int joint, double volt) { set_value[joint] = volt; }
void wire_enable(int on) { enabled = on; }
int wire_ready(int joint) { return ready[joint]; }
