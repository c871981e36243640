"""The contact force: existence, uniqueness, and its motion while the threads are stiff."""
