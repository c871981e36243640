"""The columns of a row that describes an oscillator  u″ + a₁ u′ + a₀ u = b.

Such rows are the flow table of modes with two states and, without b, the pairs of modes with more states. This module
loads no numba: the tables are made without it.
"""

A0, A1, B = 0, 1, 2  # coefficients a₀ [1/s²], a₁ [1/s] and b
ALPHA, BETA, DELTA = 3, 4, 5  # rates −α ± iβ, or −α ± δ [1/s]; of β and δ one is zero
R1, R2 = 6, 7  # the real rates r₁ ≥ r₂ [1/s]; zero where the rates are complex
EQUILIBRIUM = 8  # b / a₀; zero where a₀ is
TIME_SCALE = 9  # 1 / √|a₀| [s]; zero where a₀ is
COUNT = 10  # of all columns
