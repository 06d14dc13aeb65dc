"""What the machine bears: stiffness and first mode at the handle, loads of its parts, their life; no solids needed.

Units: mm, N, N mm, rad, kg, Hz. `beam_model.py` (what gives) and `strength.py` (what may be borne) alone read
dimensions; everything else takes their records.
"""
