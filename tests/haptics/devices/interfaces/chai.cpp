// A haptic thread on the CHAI3D device, with stubs in CHAI3D's place.
#include <cstdio>
#include <cstdlib>

#include "CDeltaHapticDevice.h"

int main(int, char** argv)
{
    const auto port = static_cast<unsigned short>(std::atoi(argv[1]));
    auto device = chai3d::cDeltaHapticDevice::create("127.0.0.1", port);
    chai3d::cVector3d p, v;
    chai3d::cMatrix3d turn;
    double angles[chai3d::C_MAX_DOF];
    unsigned int switches = 1;
    const bool before = device->getPosition(p) || device->setForce(p);
    bool opened = false, kept = false;
    for (int session = 0; !kept && session < 2; ++session) { // a second one if the first is lost
        opened = device->open();
        kept = opened && device->calibrate() && device->getRotation(turn) && device->getUserSwitches(switches);
        for (int n = 0; kept && n < 200; ++n)
            kept = device->getPosition(p) && device->getLinearVelocity(v) && device->getJointAnglesRad(angles)
                   && device->setForce(chai3d::cVector3d(-100.0 * p.x(), -100.0 * p.y(), -100.0 * p.z()));
    }
    std::printf("%d %d %d %u %.9g %.9g %.9g %.9g\n", before, opened, kept, switches, p.x(), p.y(), p.z(),
                device->getSpecifications().m_maxLinearForce);
    return device->close() && !device->close() ? 0 : 1;
}
