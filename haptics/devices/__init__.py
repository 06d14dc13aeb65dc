"""Devices behind the interface of `haptics.devices.device`; this package imports nothing."""
