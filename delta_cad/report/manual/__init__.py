"""The assembly manual of a build, made from the order that its checks hold."""
