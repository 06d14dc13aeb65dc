"""What a machine is installed with: the panel over it, the leads behind its motors."""
