"""Studies: requirements or hardware varied along axes, a row a point: front, trade, convergence, machines, atlas."""
