// See CDeltaHapticDevice.h.
#include "CDeltaHapticDevice.h"

#include "delta_machine.h"

namespace chai3d {

cDeltaHapticDevice::cDeltaHapticDevice(const std::string& a_address, unsigned short a_port, unsigned int a_deviceNumber)
    : cGenericHapticDevice(a_deviceNumber), m_address(a_address), m_port(a_port), m_device(nullptr)
{
    m_deviceAvailable = true;
    m_deviceReady = false;
    m_specifications.m_model = C_HAPTIC_DEVICE_CUSTOM;
    m_specifications.m_manufacturerName = "delta-haptics";
    m_specifications.m_modelName = DELTA_NAME;
    m_specifications.m_maxLinearForce = DELTA_FORCE;
    m_specifications.m_maxLinearStiffness = DELTA_STIFFNESS;
    m_specifications.m_maxLinearDamping = DELTA_DAMPING;
    m_specifications.m_workspaceRadius = DELTA_HALF_SIDE;
    m_specifications.m_maxAngularTorque = 0.0;
    m_specifications.m_maxGripperForce = 0.0;
    m_specifications.m_maxAngularStiffness = 0.0;
    m_specifications.m_maxGripperLinearStiffness = 0.0;
    m_specifications.m_maxAngularDamping = 0.0;
    m_specifications.m_maxGripperAngularDamping = 0.0;
    m_specifications.m_gripperMaxAngleRad = 0.0;
    m_specifications.m_sensedPosition = true;
    m_specifications.m_actuatedPosition = true;
    m_specifications.m_sensedRotation = false;
    m_specifications.m_actuatedRotation = false;
    m_specifications.m_sensedGripper = false;
    m_specifications.m_actuatedGripper = false;
    m_specifications.m_leftHand = true;
    m_specifications.m_rightHand = true;
}

cDeltaHapticDevice::~cDeltaHapticDevice()
{
    delta_close(m_device);
}

bool cDeltaHapticDevice::open()
{
    if (m_device != nullptr && !m_deviceReady) // lost, by which it can only be closed
        close();
    if (m_device == nullptr) {
        const delta_config config = DELTA_MACHINE;
        m_device = delta_open(&config, m_address.c_str(), m_port, nullptr);
    }
    m_deviceReady = m_device != nullptr;
    return m_deviceReady;
}

bool cDeltaHapticDevice::close()
{
    const bool was = m_device != nullptr;
    delta_close(m_device);
    m_device = nullptr;
    m_deviceReady = false;
    return was;
}

bool cDeltaHapticDevice::calibrate(bool a_forceCalibration)
{
    if (a_forceCalibration)
        delta_reset(m_device);
    return m_deviceReady;
}

bool cDeltaHapticDevice::getPosition(cVector3d& a_position)
{
    double p[3];
    if (delta_position(m_device, p) != DELTA_OK)
        return C_ERROR;
    a_position.set(p[0] - DELTA_CENTRE_X, p[1], p[2] - DELTA_CENTRE_Z);
    return C_SUCCESS;
}

bool cDeltaHapticDevice::getLinearVelocity(cVector3d& a_linearVelocity)
{
    double v[3];
    if (delta_velocity(m_device, v) != DELTA_OK)
        return C_ERROR;
    m_linearVelocity.set(v[0], v[1], v[2]);
    a_linearVelocity = m_linearVelocity;
    return C_SUCCESS;
}

bool cDeltaHapticDevice::getRotation(cMatrix3d& a_rotation)
{
    a_rotation.identity();
    return m_deviceReady;
}

bool cDeltaHapticDevice::getJointAnglesRad(double a_jointAnglesRad[C_MAX_DOF])
{
    return delta_angles(m_device, a_jointAnglesRad) == DELTA_OK;
}

bool cDeltaHapticDevice::getUserSwitches(unsigned int& a_userSwitches)
{
    a_userSwitches = 0;
    return m_deviceReady;
}

bool cDeltaHapticDevice::setForceAndTorqueAndGripperForce(const cVector3d& a_force, const cVector3d& a_torque,
                                                          const double a_gripperForce)
{
    const double force[3] = {a_force.x(), a_force.y(), a_force.z()};
    m_prevForce = a_force;
    m_prevTorque = a_torque;
    m_prevGripperForce = a_gripperForce;
    const int status = delta_set_force(m_device, force);
    if (status == DELTA_LOST)
        m_deviceReady = false;
    return status == DELTA_OK;
}

} // namespace chai3d
