/* UDP on loopback as the board's link. */
#ifndef LINK_H
#define LINK_H

/* Listens on a port, on any that is free if 0; its number, -1 if it cannot. */
int link_listen(int port);
/* Waits for a datagram; whether there is one. */
int link_ready(int milliseconds);

#endif
