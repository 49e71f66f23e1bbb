"""Speed at which a sphere settles in water: weight against the drag of Schiller and Naumann (1935), Re < 800.

A line in: diameter [m], density [kg/m^3], viscosity [Pa s]. A line out: speed [m/s], Reynolds number.
"""

import sys

WATER, GRAVITY = 998.2, 9.81

for line in sys.stdin:
    diameter, density, viscosity = map(float, line.split())
    stokes = (density - WATER) * GRAVITY * diameter**2 / (18.0 * viscosity)
    low, high = 0.0, stokes
    for _ in range(60):  # the drag grows with the speed: halving finds where it balances the weight
        speed = 0.5 * (low + high)
        reynolds = WATER * speed * diameter / viscosity
        if speed * (1.0 + 0.15 * reynolds**0.687) < stokes:
            low = speed
        else:
            high = speed
    print(repr(speed), repr(reynolds))
