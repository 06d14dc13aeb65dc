"""What the machine bears: stiffness and first mode at the handle, loads of its parts, their life; no solids needed.

Units: mm, N, N mm, rad, kg, Hz. `table.py` alone knows the dimensions; everything else takes its record.
"""
