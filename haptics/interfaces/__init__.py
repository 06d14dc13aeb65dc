"""Sources that bring a device into programs in C and C++, CHAI3D and ROS 2."""
