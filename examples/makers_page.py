"""An engineer's question: which trapezoidal screw lifts 50 kg with a NEMA 23 stepper?

`python examples/makers_page.py` writes makers_page.png. Each `# %%` begins a cell, as in a notebook.
"""

# %%
# Data of the makers, in their own units. What they do not state gets a range.
from matplotlib import pyplot as plt

import lsvib

sheet = {
    "name": "hoist",
    "thread": {"size": "TR12x3"},
    "screw": {"length": "600 mm", "material": "steel"},
    "nut": {"length": "24 mm", "material": "bronze"},
    "coupling": {"stiffness": {"median": "30 N*m/rad", "factor": 1.5}},
    "motor": {"inertia": "300 g*cm^2", "holding_torque": "1.26 Nm", "steps_per_turn": 200},
    "load": {"mass": "50 kg", "orientation": "vertical"},
    "operation": {"speed": ["2 mm/s", "15 mm/s"], "direction": "both"},
    "friction": {"pairing": "steel_on_bronze_lubricated"},
    "damping": {"rotational": {"median": "2e-4 N*m*s/rad", "factor": 2}},
}
print(*lsvib.assess(sheet)["brief"], sep="\n")

# %%
# It vibrates. Which other screws of this maker run steadily, and hold the load without current?
masses = {}
for size in ("TR12x3", "TR12x6 P3", "TR16x4", "TR20x4"):
    found = lsvib.assess(sheet | {"thread": {"size": size}}, samples=256)
    masses[size] = found["any_mechanism"]["margin"]["mass"]["value"] or float("inf")  # none: with any mass
    torque, load = found["statics"]["motor_torque"]["worst"], "held" if found["self_locking"] else "dropped"
    print(f"{size}: {found['verdict']}, {torque:.2f} of 1.26 N m, load {load}, up to {masses[size]:.5g} kg")

# %%
# TR16x4 runs steadily with a quarter to spare, holds the load, and the motor has enough torque for it.
figure, axes = plt.subplots(figsize=(7.2, 3), layout="constrained")
axes.barh([*masses], [min(mass, 150) for mass in masses.values()])
axes.set(xlabel="mass up to which it runs steadily [kg]; the load has 50 kg", xlim=(0, 150))
figure.savefig("makers_page.png", dpi=150)
