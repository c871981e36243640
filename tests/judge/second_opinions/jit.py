"""How the kernels of the judge are compiled: as those of the benchmarks, into a cache that their own sources name."""

from pathlib import Path

from lsvib.bench.jit import cached_apart
from lsvib.engine.kernels import jit

_HERE = Path(__file__).parent

allocating_kernel = cached_apart(jit.allocating_entry, "judge", _HERE)
kernel = cached_apart(jit.entry, "judge", _HERE)
inlined_kernel = cached_apart(jit.inlined_entry, "judge", _HERE)
