"""What walls the loop bears: discrete model, passivity, trials in time."""
