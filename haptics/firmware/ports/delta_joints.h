/* Joints between controller and hardware layer: readings in rad, torques in N m. */
#ifndef DELTA_JOINTS_H
#define DELTA_JOINTS_H

#include "delta_controller.h"

/* Reads all encoders and which readings are fresh; see hal_encoders. Returns the time of the reading, s. */
double delta_joints_read(delta_real theta[3], int fresh[3]);
/* Sets the currents of torques at the joints, and what the drives damp: more while a wall is touched. */
void delta_joints_write(const delta_real torque[3], int touched);
/* What the hardware holds up for the supervisor: bits of delta_signal. */
long long delta_joints_signals(void);

#endif
