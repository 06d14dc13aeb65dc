"""Sources that connect a device to programs in C and C++, CHAI3D and ROS 2."""
