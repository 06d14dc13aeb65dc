// Fields of the messages that the node uses, written for the test.
#ifndef GEOMETRY_MSGS_STUB_HPP
#define GEOMETRY_MSGS_STUB_HPP

#include <memory>
#include <string>

#include "rclcpp/rclcpp.hpp"

namespace std_msgs::msg {
struct Header
{
    rclcpp::Time stamp;
    std::string frame_id;
};
} // namespace std_msgs::msg

namespace geometry_msgs::msg {

struct Vector3
{
    double x = 0.0, y = 0.0, z = 0.0;
};

struct Quaternion
{
    double x = 0.0, y = 0.0, z = 0.0, w = 1.0;
};

struct Pose
{
    Vector3 position;
    Quaternion orientation;
};

struct Twist
{
    Vector3 linear, angular;
};

struct Wrench
{
    Vector3 force, torque;
};

struct PoseStamped
{
    std_msgs::msg::Header header;
    Pose pose;
};

struct TwistStamped
{
    std_msgs::msg::Header header;
    Twist twist;
};

struct WrenchStamped
{
    using SharedPtr = std::shared_ptr<WrenchStamped>;
    std_msgs::msg::Header header;
    Wrench wrench;
};

} // namespace geometry_msgs::msg

#endif
