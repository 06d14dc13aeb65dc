// A delta haptic device for CHAI3D 3.2: put this file and its .cpp beside delta_device.[ch] and delta_machine.h into the
// application, and make a cDeltaHapticDevice in place of asking a cHapticDeviceHandler, which knows its own makes alone.
#ifndef CDeltaHapticDeviceH
#define CDeltaHapticDeviceH

#include <memory>
#include <string>

#include "delta_device.h"
#include "devices/CGenericHapticDevice.h"

namespace chai3d {

class cDeltaHapticDevice;
typedef std::shared_ptr<cDeltaHapticDevice> cDeltaHapticDevicePtr;

// Position and force are in the base frame moved to the middle of the cube: z from the base to the platform. How that
// lies to the person is for the tool's own rotation to say, cToolCursor::setLocalRot.
class cDeltaHapticDevice : public cGenericHapticDevice
{
public:
    cDeltaHapticDevice(const std::string& a_address, unsigned short a_port, unsigned int a_deviceNumber = 0);
    virtual ~cDeltaHapticDevice();
    cDeltaHapticDevice(const cDeltaHapticDevice&) = delete;
    cDeltaHapticDevice& operator=(const cDeltaHapticDevice&) = delete;

    static cDeltaHapticDevicePtr create(const std::string& a_address, unsigned short a_port)
    {
        return std::make_shared<cDeltaHapticDevice>(a_address, a_port);
    }

    // Again after the board was lost.
    virtual bool open();
    virtual bool close();

    // Absolute encoders: nothing is moved. Forced, it clears what has been latched and lets force in again.
    virtual bool calibrate(bool a_forceCalibration = false);

    virtual bool getPosition(cVector3d& a_position);
    virtual bool getLinearVelocity(cVector3d& a_linearVelocity);
    virtual bool getRotation(cMatrix3d& a_rotation);
    virtual bool getJointAnglesRad(double a_jointAnglesRad[C_MAX_DOF]);
    virtual bool getUserSwitches(unsigned int& a_userSwitches);

    // Waits for the device's next tick, so that a haptic thread runs at the board's rate. Torques are no matter here.
    virtual bool setForceAndTorqueAndGripperForce(const cVector3d& a_force, const cVector3d& a_torque,
                                                  const double a_gripperForce);

protected:
    std::string m_address;
    unsigned short m_port;
    delta_device* m_device;
};

} // namespace chai3d

#endif
