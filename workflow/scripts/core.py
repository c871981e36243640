"""Compile one part of the engine by running what figures run of it; lsvib keeps the compiled code."""

from job import logged

THREADS = {"contact_stiffness": 1e8, "contact_damping": 1e8}
LAW = {"stribeck_rise": 0.02, "stribeck_speed": 0.01}

with logged(snakemake):
    from lsvib import Drive
    from lsvib.dynamics.impulses import work
    from lsvib.files import write_text

    part = snakemake.wildcards.part
    drive = Drive(mass=11, **{"modal": THREADS, "taylor": LAW}.get(part, {}))
    cycle = drive.steady_state({"u": 0.1, "w": 0.0})
    _ = cycle.amplitude, work(drive, cycle.orbit), cycle.orbit.at([0.0])  # what figures ask of a cycle
    if part == "planar":
        one = {"start": -1.0, "stop": 1.0, "count": 1}
        drive.sweep(axial_force=[50.0])
        drive.attraction({"u": one, "w": one})
    write_text(f"{part}\n", snakemake.output[0])
