"""A reader's question: what does Fig. 8.9 look like with other numbers, here of friction and mass?

`python examples/chapter_figure.py` writes chapter_figure.png. Each `# %%` begins a cell, as in a notebook.
"""

# %%
# The settings of the figure come from `config/config.yaml`; what is not changed here stays as in the chapter.
import lsvib
from lsvib.chapter.build import dataset_of, drawn
from lsvib.chapter.configuration import standard_settings

settings = standard_settings("fig8_09") | {
    "drive": {"friction_coefficient": 0.25, "axial_force": 100},
    "cases": [{"mass": 5}, {"mass": 9}],  # two, one a panel: below and above the critical mass
    "starts": [{"u": 0.01, "w": 0}, {"u": -0.1, "w": 30}],  # rad, rad/s
}
found = dataset_of("fig8_09", settings)
print(f"critical mass {found.critical_mass.item():.12g} kg")
figure = drawn("fig8_09", found)
figure.savefig("chapter_figure.png", dpi=150)
figure  # noqa: B018 – a notebook shows it

# %%
# The drive in the right-hand panel as an object, which answers every other question.
heavy = lsvib.Drive(mass=9, friction_coefficient=0.25, axial_force=100)
end = heavy.steady_state({"u": 0.01, "w": 0})
print(f"{end.label.name}: amplitude {end.amplitude:.6f} rad, {1 / end.period:.2f} Hz")
