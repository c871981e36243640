"""Compile the engine into numba's cache and note the digest of its source; rule compile_engine."""

import hashlib
import sys
from pathlib import Path

from lsvib.core.warm import compile_engine
from lsvib.files import write_text

sys.stderr = open(snakemake.log[0], "w", buffering=1)

digest = hashlib.sha256(b"".join(Path(file).read_bytes() for file in snakemake.input))
compile_engine()
write_text(f"{digest.hexdigest()}\n", snakemake.output[0])
