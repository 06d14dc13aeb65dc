// Signatures of CHAI3D 3.2 that the device uses, written for the test: nothing here does anything.
#ifndef CGenericHapticDeviceH
#define CGenericHapticDeviceH

#include <memory>
#include <string>

namespace chai3d {

const bool C_ERROR = false;
const bool C_SUCCESS = true;
const int C_MAX_DOF = 16;

struct cVector3d
{
    cVector3d(const double a_x = 0.0, const double a_y = 0.0, const double a_z = 0.0) : m_v{a_x, a_y, a_z} {}
    double x() const { return m_v[0]; }
    double y() const { return m_v[1]; }
    double z() const { return m_v[2]; }
    void set(const double& a_x, const double& a_y, const double& a_z) { *this = cVector3d(a_x, a_y, a_z); }
    double m_v[3];
};

struct cMatrix3d
{
    void identity() {}
};

enum cHapticDeviceModel { C_HAPTIC_DEVICE_VIRTUAL, C_HAPTIC_DEVICE_CUSTOM };

struct cHapticDeviceInfo
{
    cHapticDeviceModel m_model;
    std::string m_modelName, m_manufacturerName;
    double m_maxLinearForce, m_maxAngularTorque, m_maxGripperForce, m_maxLinearStiffness, m_maxAngularStiffness,
        m_maxGripperLinearStiffness, m_maxLinearDamping, m_maxAngularDamping, m_maxGripperAngularDamping,
        m_workspaceRadius, m_gripperMaxAngleRad;
    bool m_sensedPosition, m_sensedRotation, m_sensedGripper, m_actuatedPosition, m_actuatedRotation,
        m_actuatedGripper, m_leftHand, m_rightHand;
};

class cGenericDevice
{
public:
    explicit cGenericDevice(unsigned int a_deviceNumber = 0) : m_deviceNumber(static_cast<int>(a_deviceNumber)) {}
    virtual ~cGenericDevice() {}
    virtual bool open() { return C_ERROR; }
    virtual bool close() { return C_ERROR; }

protected:
    bool m_deviceAvailable = false;
    bool m_deviceReady = false;
    int m_deviceNumber;
};

class cGenericHapticDevice : public cGenericDevice
{
public:
    explicit cGenericHapticDevice(unsigned int a_deviceNumber = 0) : cGenericDevice(a_deviceNumber) {}
    virtual bool calibrate(bool a_forceCalibration = false) = 0;
    virtual bool getPosition(cVector3d& a_position) = 0;
    virtual bool getLinearVelocity(cVector3d& a_linearVelocity) = 0;
    virtual bool getRotation(cMatrix3d& a_rotation) = 0;
    virtual bool getJointAnglesRad(double a_jointAnglesRad[C_MAX_DOF]) = 0;
    virtual bool getUserSwitches(unsigned int& a_userSwitches) = 0;
    virtual bool setForceAndTorqueAndGripperForce(const cVector3d& a_force, const cVector3d& a_torque,
                                                  const double a_gripperForce) = 0;
    cHapticDeviceInfo getSpecifications() { return m_specifications; }
    bool setForce(const cVector3d& a_force) { return setForceAndTorqueAndGripperForce(a_force, cVector3d(), 0.0); }

protected:
    cHapticDeviceInfo m_specifications{};
    cVector3d m_linearVelocity, m_prevForce, m_prevTorque;
    double m_prevGripperForce = 0.0;
};

} // namespace chai3d

#endif
