"""Structural model without solids: stiffness and first mode at the handle, loads and life of the parts.

Units: mm, N, N mm, rad, kg, Hz. `beam_model.py` (what gives) and `strength.py` (what may be borne) alone read
dimensions; everything else takes their records.
"""
