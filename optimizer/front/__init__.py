"""The front of cube size against conditioning, torque and outline, and what it shows."""
