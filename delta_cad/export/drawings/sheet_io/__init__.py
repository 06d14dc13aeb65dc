"""Sheets, their lettering and their file formats."""
