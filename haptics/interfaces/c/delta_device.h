/* A delta haptic device at the end of a socket, for programs in C and C++: open, position, velocity, set force, close.
 *
 * The board speaks the protocol of haptics/devices/PROTOCOL.md. It is the clock: delta_set_force sends the torques for
 * the last reading and waits for the next one, so that a loop of delta_position and delta_set_force runs once a tick.
 * A program that stops calling loses its force to the board's watchdog, from its first delta_set_force on: what it
 * takes to get ready is its own. One thread per device; no globals.
 *
 *     int status;
 *     delta_config config = DELTA_MACHINE;              // delta_machine.h, written for one design
 *     delta_device *device = delta_open(&config, "127.0.0.1", 5005, &status);
 *     while (device != NULL && running) {
 *         double p[3], force[3];
 *         delta_position(device, p);
 *         ...
 *         if (delta_set_force(device, force) != DELTA_OK) break;
 *     }
 *     delta_close(device);
 *
 * Units: m, m/s, rad, N, N m. Base frame: origin in the middle of the shoulder axes' plane, chain 0 along x, z towards
 * the platform. C99 and POSIX sockets.
 */
#ifndef DELTA_DEVICE_H
#define DELTA_DEVICE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What every call but delta_open and delta_text returns. */
enum delta_status {
    DELTA_OK = 0,
    DELTA_BAD_ARGUMENT = 1, /* a null pointer, a number that is not finite, a config that contradicts itself */
    DELTA_NO_ADDRESS = 2,   /* the address is not numeric, or is of another machine and config.allow_remote is 0 */
    DELTA_NO_BOARD = 3,     /* nobody answers */
    DELTA_REFUSED = 4,      /* the board has a host already, speaks another version, or dislikes the watchdog */
    DELTA_UNFIT = 5,        /* the board's torque limit is below the config's: it would clip and turn the force */
    DELTA_LOST = 6,         /* the board went away; the device can only be closed */
    DELTA_UNKNOWN = 7       /* no position fits the angles; delta_position has left its argument alone */
};

/* Bits of delta_flags. With any of them no force reaches the hand; delta_reset ends those that are over. */
enum delta_flag {
    DELTA_WATCHDOG = 1,     /* the board's watchdog has cut the torque */
    DELTA_STOP = 2,         /* the emergency stop is pressed */
    DELTA_POSE_UNKNOWN = 4, /* a reading is not fresh or no number, or no position fits the angles */
    DELTA_LATCHED = 8       /* one of these was up and delta_reset has not been called since */
};

/* Numbers of one machine; delta_machine.h has them of a design. */
typedef struct delta_config {
    double radius_difference; /* R_0 - r, of chain 0, m */
    double side_difference;   /* R_1 - r, of chains 1 and 2, m */
    double side_cosine;       /* cosine of the azimuth of chain 1; chain 2 mirrors it */
    double side_sine;         /* its sine, positive */
    double upper_arm_length;  /* L_A, m */
    double forearm_length;    /* L_B, m */
    double hanging;           /* mass on the wrists, kg; 0 with the next two: the weight is not held */
    double moment;            /* first moment of an upper arm and the rods on its elbow, along the arm, kg m */
    double across;            /* along the elbow's motion, kg m */
    double gravity[3];        /* base frame, m/s^2 */
    double torque_limit;      /* of a joint, N m */
    double force_limit;       /* on the handle, N; what is asked beyond is scaled down in its direction */
    double corner;            /* of the low-pass on the velocity, Hz */
    double ramp;              /* time in which force comes in after opening and after a reset, s */
    double watchdog;          /* time without a command after which the board cuts the torque, s */
    double timeout;           /* time without a reading after which the board is lost, s */
    int allow_remote;         /* 0: loopback addresses alone; the protocol has no password */
} delta_config;

typedef struct delta_device delta_device;

/* Opens the device: says hello and waits for the first reading. NULL and *status (may be NULL) where that fails. */
delta_device *delta_open(const delta_config *config, const char *address, uint16_t port, int *status);

/* Position of the platform's centre at the last reading, m. */
int delta_position(const delta_device *device, double position[3]);

/* Its velocity, low-passed, m/s; 0 at the first reading. */
int delta_velocity(const delta_device *device, double velocity[3]);

/* Shoulder angles as read, rad. */
int delta_angles(const delta_device *device, double angles[3]);

/* Gives the hand a force beside the weight, which is held; waits for the next reading. */
int delta_set_force(delta_device *device, const double force[3]);

/* Torques that were last sent, N m. */
int delta_torques(const delta_device *device, double torques[3]);

/* Bits of delta_flag at the last reading; DELTA_LATCHED for NULL. */
unsigned delta_flags(const delta_device *device);

/* Lets force in again over config.ramp, if nothing is up; ends the board's watchdog with the next command. */
int delta_reset(delta_device *device);

/* Period of the board's tick, s; 0 for NULL. */
double delta_period(const delta_device *device);

/* The board's clock at the last reading, s; 0 for NULL. */
double delta_time(const delta_device *device);

/* Takes all force away, says goodbye, and frees the device; NULL is allowed. */
int delta_close(delta_device *device);

/* A status in words. */
const char *delta_text(int status);

#ifdef __cplusplus
}
#endif
#endif
