"""Checks of a placed machine: each returns records that say what holds, by how much and where; `registry` lists all.

Nothing here loads the CAD kernel on import.
"""
