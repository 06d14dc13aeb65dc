/* The simulated device: the plant of haptics.model.plant, translated, with cable, structure, friction and stops. */
#ifndef DEVICE_H
#define DEVICE_H

/* Lying on its lower stops, or with its handle in the cube's centre; at rest. */
void device_begin(int lying);
/* Holds torques (N m at the joints) for a time, s; the drives damp more while a wall is touched. */
void device_step(const double torque[3], int touched, double seconds);
/* Angles of the joints, rad. */
void device_angles(double angle[3]);

#endif
