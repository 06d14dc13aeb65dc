"""What holds parts together: screws, nuts, dowels, adhesives."""
