"""Sheets and what they are lettered and written with."""
