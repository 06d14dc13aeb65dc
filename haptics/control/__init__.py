"""One tick of the controller and its parts."""
