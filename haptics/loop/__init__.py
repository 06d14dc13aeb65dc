"""The sampled loop of plant, encoders, controller, delay and hand: in time, linearised, and the walls it renders."""
