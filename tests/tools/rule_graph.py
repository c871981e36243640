"""Draw the rules of the workflow and what each waits for: python tests/tools/rule_graph.py docs/figures/rules.png"""

import re
import subprocess
import sys
from pathlib import Path

from lsvib.pictures import style


def rule_graph(folder: Path = Path()) -> dict[str, set[str]]:
    """Return by rule those that wait for it, of the target `all`, as ``snakemake --rulegraph`` has them."""
    command = [sys.executable, "-m", "snakemake", "--rulegraph"]
    text = subprocess.run(command, capture_output=True, text=True, check=True, cwd=folder).stdout
    names = dict(re.findall(r'(\d+)\[label = "(\w+)"', text))
    edges = [(names[a], names[b]) for a, b in re.findall(r"(\d+) -> (\d+)", text) if a != b]
    return {name: {b for a, b in edges if a == name} for name in names.values()}


@style.styled
def draw(graph: dict[str, set[str]]) -> style.Figure:
    """Draw the rules in columns, each to the right of all that it waits for; what follows from two arrows has none."""

    def column(name: str) -> int:
        return 1 + max((column(before) for before, others in graph.items() if name in others), default=0)

    def after(name: str) -> set[str]:
        return graph[name].union(*map(after, graph[name]))

    place: dict[str, tuple[float, float]] = {}
    for name in sorted(graph, reverse=True):
        x = column(name)  # every other column is lower by a half, so that no arrow goes through a rule
        place[name] = (x, -sum(other == x for other, _ in place.values()) - 0.5 * (x % 2))
    figure = style.new_figure(style.DOUBLE, 1.4)
    axes = figure.add_subplot()
    for name, others in graph.items():
        for other in others - set().union(*map(after, others)):
            arrow = {"arrowstyle": "-|>", "color": style.GREY, "shrinkA": 20, "shrinkB": 20, "linewidth": 0.8}
            axes.annotate("", place[other], place[name], arrowprops=arrow)
        axes.text(*place[name], name, ha="center", va="center", bbox={"boxstyle": "round", "facecolor": "white"})
    (left, *_, right), (low, *_, high) = (sorted(values) for values in zip(*place.values(), strict=True))
    axes.set(xlim=(left - 0.4, right + 0.4), ylim=(low - 0.5, high + 0.5))
    axes.axis("off")
    return figure


if __name__ == "__main__":
    style.save(draw(rule_graph()), sys.argv[1])
