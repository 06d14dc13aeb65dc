"""The order in which a machine is put together: every part has a way in, every screw a key."""
