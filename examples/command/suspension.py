"""How fast a suspension of grains settles: one NumPy program for a whole build, persistent = true.

A batch in: a line with its number of rows, then a row per point: median diameter [m], spread (the standard deviation of
the logarithm of the diameter), density [kg/m^3]. A row out for each: the mean speed of the grains [m/s], the speed at
which their mass settles [m/s]. The end of the input is the end.

Speed of a grain: R. I. Ferguson and M. Church, A simple universal equation for grain settling velocity, J. Sedimentary
Research 74 (2004), for spheres in water of 20 C.
"""

import sys

import numpy

WATER, GRAVITY, VISCOSITY = 998.2, 9.81, 1.004e-6  # kg/m^3, m/s^2, m^2/s
NODES, WEIGHTS = numpy.polynomial.hermite_e.hermegauss(40)
WEIGHTS = WEIGHTS / WEIGHTS.sum()


def answers(rows):
    """Rows of inputs to rows of outputs, all at once."""
    median, spread, density = rows.T[:, :, None]
    diameter = median * numpy.exp(spread * NODES)
    weight = (density / WATER - 1.0) * GRAVITY
    speed = weight * diameter**2 / (18.0 * VISCOSITY + numpy.sqrt(0.3 * weight * diameter**3))
    mass = WEIGHTS * diameter**3
    return numpy.stack([speed @ WEIGHTS, (mass * speed).sum(axis=1) / mass.sum(axis=1)], axis=1)


def main():
    for head in sys.stdin:
        rows = numpy.array([sys.stdin.readline().split() for _ in range(int(head))], dtype=float)
        for answer in answers(rows).tolist():
            print(*answer)
        sys.stdout.flush()


if __name__ == "__main__":
    main()
