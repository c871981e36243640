"""What every script begins with."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def logged(snakemake: Any) -> Iterator[None]:
    """Let a job say what is wrong in its log: an error of lsvib in one sentence, any other as Python does."""
    from lsvib.errors import LsvibError

    sys.stderr = open(snakemake.log[0], "w", buffering=1, encoding="utf-8")  # noqa: SIM115 (until the process ends)
    try:
        yield
    except LsvibError as error:
        sys.exit(f"{snakemake.wildcards.get('figure', snakemake.rule)}: {error}")
    except KeyboardInterrupt:
        sys.exit("interrupted")
