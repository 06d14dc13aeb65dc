// A delta haptic device as a ROS 2 node: publishes where the handle is, takes the force that it shall give.
//
// Publishes ~/pose (geometry_msgs/PoseStamped), ~/twist (TwistStamped) and joint_states (sensor_msgs/JointState);
// subscribes ~/wrench (WrenchStamped), whose force acts until a newer one comes or it is `stale` seconds old. The service
// ~/reset (std_srvs/Trigger) lets force in again after the board's watchdog or an emergency stop; ~/enable
// (std_srvs/SetBool) switches the force off at once, the weight stays compensated, and on again over the ramp of the
// configuration. Parameters: address, port, frame, prefix (of the joint names, so that several devices share a robot
// model), stale (s), every (ticks between two messages). One thread drives the device at the board's rate and never
// waits for a subscriber; the executor's thread only leaves the newest wrench. A board that is lost ends the node with 1,
// for a launch file to start it again.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>

#include "delta_device.h"
#include "delta_machine.h"
#include "geometry_msgs/msg/pose_stamped.hpp"
#include "geometry_msgs/msg/twist_stamped.hpp"
#include "geometry_msgs/msg/wrench_stamped.hpp"
#include "rclcpp/rclcpp.hpp"
#include "sensor_msgs/msg/joint_state.hpp"
#include "std_srvs/srv/set_bool.hpp"
#include "std_srvs/srv/trigger.hpp"

class DeltaHapticNode : public rclcpp::Node
{
public:
    DeltaHapticNode() : rclcpp::Node("delta_haptic")
    {
        const auto address = declare_parameter<std::string>("address", "127.0.0.1");
        const auto port = declare_parameter<int64_t>("port", 0);
        frame_ = declare_parameter<std::string>("frame", "delta_base");
        prefix_ = declare_parameter<std::string>("prefix", "");
        stale_ = declare_parameter<double>("stale", 0.1);
        every_ = declare_parameter<int64_t>("every", 1);
        if (port < 1 || port > 65535 || every_ < 1 || !(stale_ > 0.0))
            throw std::invalid_argument("port must be 1 to 65535, every at least 1, stale positive");
        pose_ = create_publisher<geometry_msgs::msg::PoseStamped>("~/pose", 10);
        twist_ = create_publisher<geometry_msgs::msg::TwistStamped>("~/twist", 10);
        joints_ = create_publisher<sensor_msgs::msg::JointState>("joint_states", 10);
        wrench_ = create_subscription<geometry_msgs::msg::WrenchStamped>(
            "~/wrench", 1, [this](const geometry_msgs::msg::WrenchStamped::SharedPtr message) { take(*message); });
        reset_ = create_service<std_srvs::srv::Trigger>(
            "~/reset", [this](const std_srvs::srv::Trigger::Request::SharedPtr,
                              const std_srvs::srv::Trigger::Response::SharedPtr response) {
                again_ = true; // the thread that drives does it, with its next command
                response->success = true;
            });
        enable_ = create_service<std_srvs::srv::SetBool>(
            "~/enable", [this](const std_srvs::srv::SetBool::Request::SharedPtr request,
                               const std_srvs::srv::SetBool::Response::SharedPtr response) {
                const std::lock_guard<std::mutex> guard(lock_);
                if (request->data && !enabled_)
                    enabled_at_ = Clock::now();
                enabled_ = request->data;
                response->success = true;
            });
        const delta_config config = DELTA_MACHINE;
        ramp_ = config.ramp;
        int status = DELTA_OK;
        device_ = delta_open(&config, address.c_str(), static_cast<uint16_t>(port), &status);
        if (device_ == nullptr)
            throw std::runtime_error(std::string("no device: ") + delta_text(status));
        thread_ = std::thread([this]() { drive(); });
    }

    ~DeltaHapticNode() override
    {
        running_ = false;
        if (thread_.joinable())
            thread_.join();
        delta_close(device_);
    }

    bool lost() const { return lost_; }

    DeltaHapticNode(const DeltaHapticNode&) = delete;
    DeltaHapticNode& operator=(const DeltaHapticNode&) = delete;

private:
    using Clock = std::chrono::steady_clock;

    void take(const geometry_msgs::msg::WrenchStamped& message)
    {
        const std::lock_guard<std::mutex> guard(lock_);
        force_ = {message.wrench.force.x, message.wrench.force.y, message.wrench.force.z};
        taken_ = Clock::now();
    }

    std::array<double, 3> wanted()
    {
        const std::lock_guard<std::mutex> guard(lock_);
        const auto at = Clock::now();
        const std::chrono::duration<double> age = at - taken_, since = at - enabled_at_;
        if (!enabled_ || !(age.count() < stale_))
            return {0.0, 0.0, 0.0};
        const double scale = std::min(1.0, since.count() / ramp_);
        return {scale * force_[0], scale * force_[1], scale * force_[2]};
    }

    void drive()
    {
        unsigned told = 0;
        for (int64_t tick = 0; running_; ++tick) {
            if (again_.exchange(false))
                delta_reset(device_);
            const int status = delta_set_force(device_, wanted().data());
            if (status == DELTA_LOST) {
                RCLCPP_ERROR(get_logger(), "%s", delta_text(status));
                lost_ = true;
                rclcpp::shutdown();
                break;
            }
            if (status == DELTA_BAD_ARGUMENT)  // a force that is no number: none is given
                delta_set_force(device_, std::array<double, 3>{0.0, 0.0, 0.0}.data());
            const unsigned flags = delta_flags(device_);
            if (flags != told)
                RCLCPP_WARN(get_logger(), "flags of the device: %u", flags);
            told = flags;
            if (tick % every_ == 0)
                tell();
        }
    }

    void tell()
    {
        double p[3], v[3], angles[3];
        if (delta_position(device_, p) != DELTA_OK || delta_velocity(device_, v) != DELTA_OK)
            return;
        delta_angles(device_, angles);
        const auto stamp = now();
        geometry_msgs::msg::PoseStamped pose;
        pose.header.stamp = stamp;
        pose.header.frame_id = frame_;
        pose.pose.position.x = p[0];
        pose.pose.position.y = p[1];
        pose.pose.position.z = p[2];
        pose.pose.orientation.w = 1.0;
        pose_->publish(pose);
        geometry_msgs::msg::TwistStamped twist;
        twist.header = pose.header;
        twist.twist.linear.x = v[0];
        twist.twist.linear.y = v[1];
        twist.twist.linear.z = v[2];
        twist_->publish(twist);
        sensor_msgs::msg::JointState joints;
        joints.header = pose.header;
        joints.name = {prefix_ + "shoulder_0", prefix_ + "shoulder_1", prefix_ + "shoulder_2"};
        joints.position = {angles[0], angles[1], angles[2]};
        joints_->publish(joints);
    }

    std::string frame_, prefix_;
    double stale_ = 0.1, ramp_ = 0.5;
    int64_t every_ = 1;
    delta_device* device_ = nullptr;
    std::thread thread_;
    std::atomic<bool> running_{true}, again_{false}, lost_{false};
    std::mutex lock_;
    std::array<double, 3> force_{0.0, 0.0, 0.0};
    Clock::time_point taken_{}, enabled_at_{};
    bool enabled_ = true;
    rclcpp::Publisher<geometry_msgs::msg::PoseStamped>::SharedPtr pose_;
    rclcpp::Publisher<geometry_msgs::msg::TwistStamped>::SharedPtr twist_;
    rclcpp::Publisher<sensor_msgs::msg::JointState>::SharedPtr joints_;
    rclcpp::Subscription<geometry_msgs::msg::WrenchStamped>::SharedPtr wrench_;
    rclcpp::Service<std_srvs::srv::Trigger>::SharedPtr reset_;
    rclcpp::Service<std_srvs::srv::SetBool>::SharedPtr enable_;
};

int main(int argc, char** argv)
{
    rclcpp::init(argc, argv);
    int code = 0;
    try {
        const auto node = std::make_shared<DeltaHapticNode>();
        rclcpp::spin(node);
        code = node->lost() ? 1 : 0;
    } catch (const std::exception& error) {
        RCLCPP_FATAL(rclcpp::get_logger("delta_haptic"), "%s", error.what());
        code = 1;
    }
    rclcpp::shutdown();
    return code;
}
