#include "escon.h"
#include "wires.h"

static void none(void)
{
    for (int joint = 0; joint < 3; joint++) wire_set_value(joint, 0.0);
}

static int all_ready(const escon *drives)
{
    int most = ESCON_MOST_NOT_READY;
    return drives->not_ready[0] <= most && drives->not_ready[1] <= most && drives->not_ready[2] <= most;
}

void escon_begin(escon *drives)
{
    wire_enable(0);
    none();
    drives->enabled = 0;
    for (int joint = 0; joint < 3; joint++) drives->not_ready[joint] = 0;
}

void escon_enable(escon *drives, int on)
{
    escon_begin(drives);
    drives->enabled = on != 0;
    if (drives->enabled) wire_enable(1);
}

void escon_current(escon *drives, int joint, double ampere)
{
    double given = 0.0;
    if (drives->enabled && all_ready(drives)) {
        /* a current that is no number fails both comparisons */
        if (ampere >= -ESCON_LIMIT_A && ampere <= ESCON_LIMIT_A) given = ampere;
        if (ampere > ESCON_LIMIT_A) given = ESCON_LIMIT_A;
        if (ampere < -ESCON_LIMIT_A) given = -ESCON_LIMIT_A;
    }
    wire_set_value(joint, given * ESCON_VOLT_PER_A);
}

int escon_healthy(escon *drives)
{
    for (int joint = 0; joint < 3; joint++) {
        int *count = &drives->not_ready[joint];
        if (*count > ESCON_MOST_NOT_READY) continue; /* stays out */
        *count = wire_ready(joint) ? 0 : *count + 1;
    }
    if (all_ready(drives)) return 1;
    wire_enable(0);
    none();
    return 0;
}
