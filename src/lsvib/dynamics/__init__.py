"""What drives do: works, impulses, cycles, sweeps of many drives, and the basin of steady sliding."""
