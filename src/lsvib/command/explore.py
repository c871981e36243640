"""``lsvib explore``: a page in the browser on which drives can be explored."""

from importlib.util import find_spec
from typing import Annotated

from cyclopts import Parameter

from lsvib import numbers
from lsvib.command.app import app
from lsvib.errors import InputError

_PORTS = "0 <= port <= 65535"  # 0: any that is free


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
    number = _port(port)
    if find_spec("bokeh") is None:
        raise InputError("lsvib explore needs bokeh, which is not installed: pip install 'lsvib[explore]'.")
    from lsvib.explore.server import serve

    serve(number, show)


def _port(given: str) -> int:
    try:
        port = numbers.whole(given)
    except numbers.NotNumber as error:
        raise InputError(f"port = {numbers.shown(given)} {error}; the allowed range is {_PORTS}.") from None
    if not 0 <= port <= 65535:
        raise InputError(f"port = {port} is outside the allowed range {_PORTS}.")
    return port
