"""Certificates of one design and their independent replay."""
