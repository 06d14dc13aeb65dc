/* What a POSIX process sets of its hardware layer. */
#ifndef HAL_POSIX_H
#define HAL_POSIX_H

typedef struct {
    int motor[3], encoder[3]; /* 1 or -1: signs of the wires */
    int paced;                /* whether a period takes its time */
    volatile int *stopped;    /* the emergency stop; NULL for none */
} hal_wiring;

extern hal_wiring hal_wired;

/* Listens on loopback, on any port if 0; its number, -1 if it cannot. */
int hal_posix_listen(int port);
/* Waits for a datagram. */
int hal_posix_ready(int milliseconds);

#endif
