"""One module for each method or package, loaded when it is used; figures that ask the methods name them as needed."""

MODULES = tuple(
    f"{__name__}.{name}" for name in ("this_engine", "scipy_events", "cvode", "heyoka_events", "smoothed", "fixed_step")
)
