"""What it costs: measured on demand by `make bench`, never asserted. Figures are ratios inside one run or medians."""
