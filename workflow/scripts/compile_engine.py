"""Compile the engine into numba's cache and note the digest of its source; rule compile_engine."""

import hashlib
import sys
from pathlib import Path

from lsvib.basins.cells import QUANTITIES
from lsvib.basins.grid import Grid
from lsvib.basins.mapper import mapper
from lsvib.drives.parameters import RigidParameters
from lsvib.engine.kernels.compile_ahead import compile_engine
from lsvib.files import write_text

sys.stderr = open(snakemake.log[0], "w", buffering=1)

digest = hashlib.sha256(b"".join(Path(file).read_bytes() for file in snakemake.input))
compile_engine()
mapper(RigidParameters()).cells(Grid.parse(["u=-1:1:1", "w=-1:1:1"]), quantities=QUANTITIES)
write_text(f"{digest.hexdigest()}\n", snakemake.output[0])
