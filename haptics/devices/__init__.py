"""Devices behind the interface of `haptics.device`; this package imports nothing."""
