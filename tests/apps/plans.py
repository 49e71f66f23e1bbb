"""Plans of falling plates and cards, for tests and benchmarks of the command."""

PLATE_RANGES = {
    "C_T": (0.8, 1.4), "C_R": (2.0, 4.0), "A": (1.0, 1.8), "B": (0.9, 1.1), "mu1": (0.15, 0.25), "inertia_ratio": (1.0, 1.2), "beta": (0.06, 0.08),
}


def intervals(ranges):
    return "".join(f"{name} = [{lower}, {upper}]\n" for name, (lower, upper) in ranges.items())


def plate_plan(free, end):
    """A falling plate, over its first so many coefficients."""
    return f"""model = "falling_plate_nd"
[fixed]
"theta(0)" = 0.4
[box]
{intervals(dict(list(PLATE_RANGES.items())[:free]))}[time]
end = {end}
[tolerance]
relative = 1e-3
[builder]
kind = "pgd"
strategy = "slabs"
"""


def card_plan(fixed, box, end):
    """A card that turns in space, with what is fixed and free of it."""
    held = "".join(f"'{name}' = {value!r}\n" for name, value in fixed.items())
    return f"""model = 'immersed_body'
[fixed]
a = 0.035
b = 0.02
c = 1e-4
density = 1200.0
C_D0 = 0.05
C_w = 2.0
speed_floor = 1e-3
{held}[box]
{intervals(box)}[time]
end = {end}
[tolerance]
relative = 1e-3
absolute = {{ x = 0.1, y = 0.1, z = 0.1, qw = 1.0, qx = 1.0, qy = 1.0, qz = 1.0, ux = 0.1, uy = 0.1, uz = 0.1, wx = 5.0, wy = 5.0, wz = 5.0 }}
[builder]
kind = 'pgd'
strategy = 'slabs'
"""
