// Fields of the message that the node uses, written for the test.
#ifndef SENSOR_MSGS_STUB_HPP
#define SENSOR_MSGS_STUB_HPP

#include <string>
#include <vector>

#include "geometry_msgs/msg/common.hpp"

namespace sensor_msgs::msg {
struct JointState
{
    std_msgs::msg::Header header;
    std::vector<std::string> name;
    std::vector<double> position, velocity, effort;
};
} // namespace sensor_msgs::msg

#endif
