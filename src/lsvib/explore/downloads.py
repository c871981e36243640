"""What a view is exported as: the scene, a picture, the motion; each made from the link of the view alone."""

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from lsvib.basins.mapper import mapper
from lsvib.datasets.io import write_dataset
from lsvib.datasets.map import attraction_map
from lsvib.datasets.motion import attractor_of, motion_file, run
from lsvib.explore import answers
from lsvib.explore.view import View
from lsvib.figures import attraction, style


def scene(view: View, path: Path) -> None:
    """Write the scene of a view as YAML."""
    path.write_text(view.yaml(), encoding="utf-8")


def motion(view: View, path: Path) -> None:
    """Write the motion of a view as netCDF, as ``lsvib simulate`` writes it."""
    checked = view.scene()
    followed = run(checked)
    write_dataset(motion_file(checked, followed, attractor_of(followed)), path, "lsvib.explore")


def drawing(view: View, path: Path) -> None:
    """Draw the map of the window of a view and its motion on it as PNG, in the look of the figures."""
    shown = answers.followed(view)
    window = view.window or answers.window_around(view.drive, shown)
    grid = answers.grid_of(window, answers.SETTLED if answers.at_once(view.drive) else answers.COARSE)
    mapped = mapper(view.drive, view.drive.model)
    figure = attraction.draw(attraction_map(mapped, grid, mapped.cells(grid, quantities=("label",))))
    figure.axes[0].plot(shown.u, shown.w, color=style.BLUE, linewidth=1.0)
    style.save(figure, path)


EXPORTS: dict[str, tuple[Callable[[View, Path], None], str]] = {
    "scene.yaml": (scene, "application/yaml"),
    "motion.nc": (motion, "application/x-netcdf"),
    "attraction.png": (drawing, "image/png"),
}


def export(name: str, view: View) -> bytes:
    """Return an export of a view by its name, one of :data:`EXPORTS`; raises ``LsvibError``."""
    write, _ = EXPORTS[name]
    with TemporaryDirectory() as folder:
        path = Path(folder) / name
        write(view, path)
        return path.read_bytes()
