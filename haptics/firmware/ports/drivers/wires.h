/* What the drivers need of a board: wires to the chips. A port for a board defines them. */
#ifndef DELTA_WIRES_H
#define DELTA_WIRES_H

#include <stddef.h>

/* Selects the encoder of a joint, exchanges bytes by SPI mode 3, most significant bit first, and lets go of it.
 * 0 once all bytes were exchanged. At least 100 ns lie between selection and the first clock. */
int wire_encoder(int joint, const unsigned char *out, unsigned char *in, size_t bytes);
/* Set value of a joint's drive, V; the output stays within what it can give. */
void wire_set_value(int joint, double volt);
/* Enable input of all drives. */
void wire_enable(int on);
/* Whether a drive reports that it is ready. */
int wire_ready(int joint);

#endif
