"""Bought parts as their makers draw them from outside, one part a file."""
