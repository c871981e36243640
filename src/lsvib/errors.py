"""Errors that lsvib raises on purpose; each carries one clear sentence for the user."""


class LsvibError(Exception):
    """Base of all deliberate errors; the command line prints the sentence and exits with code 2."""


class InputError(LsvibError, ValueError):
    """A parameter, option or file is not acceptable; the sentence names it and the allowed range.

    >>> lsvib.Drive(mass=-1)
    Traceback (most recent call last):
    lsvib.errors.InputError: mass = -1.0 is outside the allowed range 1e-18 <= mass <= 1e+09 kg.
    """


class NoThreshold(InputError):
    """The drive does not have this threshold; the sentence says why (:meth:`lsvib.Drive.threshold`)."""


class NotInstalledError(LsvibError, AttributeError):
    """A package of an extra is missing; the sentence says how to install it."""


class EngineError(LsvibError, RuntimeError):
    """The engine has no answer; the sentence says why, and what may help."""

    motion: object = None  # as far as it went, where following it raised this


class WorkSpentError(EngineError):
    """A run needs more work than its caller allows."""


class UndecidedError(EngineError):
    """The search for the next event does not end."""


class AccumulationError(EngineError):
    """Infinitely many events accumulate, and the model does not say what follows."""


class DivergenceError(EngineError):
    """The motion grows without bound."""
