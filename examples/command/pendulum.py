"""A damped pendulum let go at rest, by steps of Runge and Kutta.

A line in: length [m], angle at the start [rad], damping [1/s], then the times [s].
A line out: angle [rad] and rate [rad/s] at the first time, at the second, ..
"""

import math
import sys


def slope(angle, rate, length, damping):
    return rate, -9.81 / length * math.sin(angle) - damping * rate


def step(angle, rate, h, *constants):
    a1, r1 = slope(angle, rate, *constants)
    a2, r2 = slope(angle + h / 2 * a1, rate + h / 2 * r1, *constants)
    a3, r3 = slope(angle + h / 2 * a2, rate + h / 2 * r2, *constants)
    a4, r4 = slope(angle + h * a3, rate + h * r3, *constants)
    return angle + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4), rate + h / 6 * (r1 + 2 * r2 + 2 * r3 + r4)


for line in sys.stdin:
    length, angle, damping, *times = map(float, line.split())
    rate, t, answer = 0.0, 0.0, []
    for wanted in times:  # ascending
        steps = math.ceil((wanted - t) / 0.05)
        for _ in range(steps):
            angle, rate = step(angle, rate, (wanted - t) / steps, length, damping)
        t = wanted
        answer += [angle, rate]
    print(*map(repr, answer))
