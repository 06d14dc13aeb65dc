#include "geometry_msgs/msg/common.hpp"
