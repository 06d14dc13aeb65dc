"""The same task with other limits: the front of machines, and the nearest task that has one."""
