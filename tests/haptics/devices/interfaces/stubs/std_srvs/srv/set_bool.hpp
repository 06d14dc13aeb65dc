// Fields of the service that the node uses, written for the test.
#ifndef STD_SRVS_SET_BOOL_STUB_HPP
#define STD_SRVS_SET_BOOL_STUB_HPP

#include <memory>
#include <string>

namespace std_srvs::srv {
struct SetBool
{
    struct Request
    {
        using SharedPtr = std::shared_ptr<Request>;
        bool data = false;
    };
    struct Response
    {
        using SharedPtr = std::shared_ptr<Response>;
        bool success = false;
        std::string message;
    };
};
} // namespace std_srvs::srv

#endif
