"""Compiled kernels: closed-form flows, the certain search for events, the event loop."""
