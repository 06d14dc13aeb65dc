"""Checks of a placed machine: each returns records with result, margin and place; `registry` lists all.

Nothing here loads the CAD kernel on import.
"""
