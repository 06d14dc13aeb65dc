// Signatures of rclcpp that the node uses, written for the test: messages go nowhere but for their names.
#ifndef RCLCPP_STUB_HPP
#define RCLCPP_STUB_HPP

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
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

// The newest names of a message that has some, a joint state's.
inline std::string names;
template <typename Message>
auto keep_names(const Message& message, int) -> decltype(message.name.begin(), void())
{
    names.clear();
    for (const auto& name : message.name)
        names += name + " ";
}
template <typename Message>
void keep_names(const Message&, long)
{
}

template <typename Message>
class Publisher
{
public:
    using SharedPtr = std::shared_ptr<Publisher<Message>>;
    void publish(const Message& message) { keep_names(message, 0); }
};

// Gives a request that has data its value.
template <typename Request>
auto fill(Request& request, bool data, int) -> decltype(request.data, void())
{
    request.data = data;
}
template <typename Request>
void fill(Request&, bool, long)
{
}

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
    typename Service<Kind>::SharedPtr create_service(const std::string& name, Callback&& callback)
    {
        services[name] = [callback](bool data) {
            const auto request = std::make_shared<typename Kind::Request>();
            const auto response = std::make_shared<typename Kind::Response>();
            fill(*request, data, 0);
            callback(request, response);
            std::printf("service %d\n", response->success);
        };
        return std::make_shared<Service<Kind>>();
    }

    std::map<std::string, std::function<void(bool)>> services;
    Logger get_logger() const { return {name_}; }
    Time now() const { return {}; }

private:
    std::string name_;
};

template <>
inline std::string Node::declare_parameter(const std::string& name, const std::string& value)
{
    const char* text = std::getenv(("DELTA_" + name).c_str());
    return text == nullptr ? value : text;
}

template <>
inline double Node::declare_parameter(const std::string& name, const double& value)
{
    const char* text = std::getenv(("DELTA_" + name).c_str());
    return text == nullptr ? value : std::stod(text);
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

// Calls ~/reset after 0.15 s, or with DELTA_switched ~/enable, off after 0.1 s and on after 0.2 s, and prints the joints'
// names; ends after 0.3 s, or as it is shut down, or with DELTA_stays only then.
inline void spin(const std::shared_ptr<Node>& node)
{
    const bool stays = std::getenv("DELTA_stays") != nullptr, switched = std::getenv("DELTA_switched") != nullptr;
    for (int n = 0; !down && (stays || n < 30); ++n) {
        if (switched ? n == 10 || n == 20 : n == 15)
            node->services.at(switched ? "~/enable" : "~/reset")(n == 20);
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    if (switched)
        std::printf("%s\n", names.c_str());
}

} // namespace rclcpp

#define RCLCPP_ERROR(logger, ...) (static_cast<void>(logger), std::fprintf(stderr, __VA_ARGS__))
#define RCLCPP_WARN(logger, ...) (static_cast<void>(logger), std::fprintf(stderr, __VA_ARGS__))
#define RCLCPP_FATAL(logger, ...) (static_cast<void>(logger), std::fprintf(stderr, __VA_ARGS__))

#endif
