"""Contacts of parts: fits, screws, running gaps, and that no part floats."""
