"""How the kernels of the benchmarks are compiled: with the engine's options, into the cache that it has chosen.

numba compiles a kernel anew when its own file was edited, so those that call each other stand in one file.
"""

import numba

from lsvib.engine.kernels import jit

kernel = numba.njit(**jit.OPTIONS)
