"""Infeasible hardware in closed form: all reasons at once, and suggestions."""
