"""How the kernels of the benchmarks are compiled: with the engine's options, into the cache that it has chosen.

numba compiles a kernel anew when its own file was edited, so those that call each other stand in one file.
"""

import numba

from lsvib.engine.kernels import jit

# As in the engine, a kernel that makes no array does not count references; rivals are not to be slowed down by that.
kernel = numba.njit(**{**jit.OPTIONS, "_nrt": False})
allocating_kernel = numba.njit(**{**jit.OPTIONS, "_nrt": True})
