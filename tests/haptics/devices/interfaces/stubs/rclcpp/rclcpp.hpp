// Signatures of rclcpp that the node uses, written for the test: messages go nowhere but to `published`.
#ifndef RCLCPP_STUB_HPP
#define RCLCPP_STUB_HPP

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <thread>

namespace rclcpp {

struct Time
{
    int64_t nanoseconds = 0;
};

struct Logger
{
    std::string name;
};

inline Logger get_logger(const std::string& name) { return {name}; }

template <typename Message>
class Publisher
{
public:
    using SharedPtr = std::shared_ptr<Publisher<Message>>;
    void publish(const Message& message) { last = message; ++published; }
    Message last;
    long published = 0;
};

template <typename Message>
class Subscription
{
public:
    using SharedPtr = std::shared_ptr<Subscription<Message>>;
    std::function<void(std::shared_ptr<Message>)> callback;
};

template <typename Kind>
class Service
{
public:
    using SharedPtr = std::shared_ptr<Service<Kind>>;
};

class Node
{
public:
    explicit Node(const std::string& name) : name_(name) {}
    virtual ~Node() = default;

    // Parameters come from the environment, DELTA_<name>, where a test gives one.
    template <typename Value>
    Value declare_parameter(const std::string& name, const Value& value);

    template <typename Message>
    typename Publisher<Message>::SharedPtr create_publisher(const std::string&, int)
    {
        return std::make_shared<Publisher<Message>>();
    }

    template <typename Message, typename Callback>
    typename Subscription<Message>::SharedPtr create_subscription(const std::string&, int, Callback&& callback)
    {
        auto made = std::make_shared<Subscription<Message>>();
        made->callback = std::forward<Callback>(callback);
        auto message = std::make_shared<Message>();
        message->wrench.force.z = 0.5;  // somebody asks for a force once
        made->callback(message);
        return made;
    }

    template <typename Kind, typename Callback>
    typename Service<Kind>::SharedPtr create_service(const std::string&, Callback&& callback)
    {
        call = [callback]() {
            const auto response = std::make_shared<typename Kind::Response>();
            callback(std::make_shared<typename Kind::Request>(), response);
            std::printf("service %d\n", response->success);
        };
        return std::make_shared<Service<Kind>>();
    }

    std::function<void()> call; // of its service
    Logger get_logger() const { return {name_}; }
    Time now() const { return {}; }

private:
    std::string name_;
};

template <>
inline std::string Node::declare_parameter(const std::string&, const std::string& value)
{
    return value;
}

template <>
inline double Node::declare_parameter(const std::string&, const double& value)
{
    return value;
}

template <>
inline int64_t Node::declare_parameter(const std::string& name, const int64_t& value)
{
    const char* text = std::getenv(("DELTA_" + name).c_str());
    return text == nullptr ? value : std::stoll(text);
}

inline std::atomic<bool> down{false};
inline void init(int, char**) {}
inline void shutdown() { down = true; }

// Somebody calls the service after a while; ends some time later, or as it is shut down, or with DELTA_stays only then.
inline void spin(const std::shared_ptr<Node>& node)
{
    const bool stays = std::getenv("DELTA_stays") != nullptr;
    for (int n = 0; !down && (stays || n < 30); ++n) {
        if (n == 15)
            node->call();
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
}

} // namespace rclcpp

#define RCLCPP_ERROR(logger, ...) (static_cast<void>(logger), std::fprintf(stderr, __VA_ARGS__))
#define RCLCPP_WARN(logger, ...) (static_cast<void>(logger), std::fprintf(stderr, __VA_ARGS__))
#define RCLCPP_FATAL(logger, ...) (static_cast<void>(logger), std::fprintf(stderr, __VA_ARGS__))

#endif
