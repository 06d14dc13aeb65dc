"""The device: its masses, motors, equations of motion, and the hands that hold it."""
