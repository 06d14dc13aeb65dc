"""The device: its masses, motors, equations of motion, and who holds it."""
