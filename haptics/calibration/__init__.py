"""Calibration of a made device: its lengths, zeros and encoders from poses at known positions."""
