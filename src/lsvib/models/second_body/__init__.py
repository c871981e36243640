"""Drives with a second body: axial support and rotating nut."""
