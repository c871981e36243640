"""``lsvib explore``: a page in the browser on which drives can be explored."""

from importlib.util import find_spec
from typing import Annotated

from cyclopts import Parameter

from lsvib import numbers
from lsvib.cli.app import app
from lsvib.errors import InputError


@app.command
def explore(
    *,
    port: Annotated[str, Parameter(help="Port of this machine to serve the page at; 0 takes a free one.")] = "5006",
    show: Annotated[bool, Parameter(negative="--no-show", help="Open the page in a browser.")] = True,
) -> None:
    """Explore drives in a browser: phase plane, region of attraction, amplitudes and contact, at the touch of a slider.

    Examples of use:

        lsvib explore

        lsvib explore --port 5010 --no-show
    """
    number = numbers.whole_between("port", port, 0, 65535)
    if find_spec("bokeh") is None:
        raise InputError("lsvib explore needs bokeh, which is not installed: pip install 'lsvib[explore]'.")
    from lsvib.explore.server import serve

    serve(number, show)
