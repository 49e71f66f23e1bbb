"""What Python costs: the package beside C++ in the same library, and beside peers.

The C++ side (python/reference.cpp) is loaded into the same process and asked the same, on one thread. SciPy and OpenTURNS
are left out where they are not installed.
"""

import argparse
import ctypes
import json
import pathlib
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "build" / "release" / "python"))

import numpy as np  # noqa: E402

import samara  # noqa: E402

COIN = ROOT / "examples" / "coin"


def report(case, metric, value, unit, **more):
    print(json.dumps({"bench": "python", "case": case, "metric": metric, "value": value, "unit": unit, **more}), flush=True)


def least(run, repeats):
    """Seconds: the least of several, which other work disturbed least."""
    best = float("inf")
    for _ in range(repeats):
        begin = time.perf_counter()
        run()
        best = min(best, time.perf_counter() - begin)
    return best


def coin_book(folder):
    path = pathlib.Path(folder) / "coin.h5"
    samara.build(COIN / "plan.toml", progress=False).save(path)
    return path


def points_of(book, count, seed=0):
    lower, upper = (np.array([getattr(c, end) for c in book.coordinates]) for end in ("lower", "upper"))
    return np.random.default_rng(seed).uniform(lower, upper, (count, len(lower)))


class Reference:
    """C++ in this process."""

    def __init__(self, arguments, path):
        self.library = ctypes.CDLL(arguments.directory / "libpython_reference.so")
        self.path = ctypes.c_char_p(str(path).encode())
        self.rounds = 3 if arguments.quick else 20

    def beside(self, ours, name, points, count, *more):
        """Seconds of ours and of C++, each the least of rounds in which both take their turns."""
        function = getattr(self.library, f"samara_seconds_of_{name}")
        function.restype = ctypes.c_double
        numbers = np.ascontiguousarray(points)
        address = ctypes.c_void_p(numbers.ctypes.data)
        python, cpp = float("inf"), float("inf")
        for _ in range(self.rounds):
            python = min(python, least(ours, 3))
            cpp = min(cpp, function(self.path, address, ctypes.c_long(count), *more, ctypes.c_int(3)))
        return python, cpp


def point(arguments):
    with tempfile.TemporaryDirectory() as folder:
        path = coin_book(folder)
        book = samara.Codebook.open(path)
        x = points_of(book, 1)[0]
        count = 2000

        def run():
            for _ in range(count):
                book.at(x)

        ours, cpp = Reference(arguments, path).beside(run, "single_points", x, count)
        report("point", "time", ours / count, "s", baseline="cpp", ratio=cpp / ours)


def batch(arguments):
    with tempfile.TemporaryDirectory() as folder:
        path = coin_book(folder)
        book = samara.Codebook.open(path)
        points = points_of(book, 100_000)
        ours, cpp = Reference(arguments, path).beside(lambda: book.at(points, threads=1), "points", points, len(points))
        report("batch", "time", ours, "s", baseline="cpp", ratio=cpp / ours)


def trajectories(arguments):
    with tempfile.TemporaryDirectory() as folder:
        path = coin_book(folder)
        book = samara.Codebook.open(path)
        q = points_of(book, 1000)[:, 1:].copy()
        times = np.linspace(0, 0.5, 200)
        for metric, gradient in (("time", False), ("gradient_time", True)):
            frames = ctypes.c_void_p(times.ctypes.data), ctypes.c_long(len(times))
            ours, cpp = Reference(arguments, path).beside(lambda: book.query(q, times, gradient=gradient, threads=1),
                                                          "trajectories", q, len(q), *frames, ctypes.c_int(gradient))
            report("trajectories", metric, ours, "s", baseline="cpp", ratio=cpp / ours)


def borehole_function(x):
    rw, r, Tu, Hu, Tl, Hl, L, Kw = x.T
    log = np.log(r / rw)
    return 2 * np.pi * Tu * (Hu - Hl) / (log * (1 + 2 * L * Tu / (log * rw**2 * Kw) + Tu / Tl))


BOREHOLE = {"rw": (0.05, 0.15), "r": (100, 50000), "Tu": (63070, 115600), "Hu": (990, 1110), "Tl": (63.1, 116),
            "Hl": (700, 820), "L": (1120, 1680), "Kw": (9855, 12045)}


def borehole(arguments):
    """Beside it what peers make of the same function."""
    lower, upper = np.array(list(BOREHOLE.values())).T
    x = np.random.default_rng(7).uniform(lower, upper, (20_000, 8))
    exact = borehole_function(x)
    begin = time.perf_counter()
    book = samara.separate(borehole_function, BOREHOLE, {"flow": "m^3/s"}, tolerance=1e-6)
    report("borehole", "build_time", time.perf_counter() - begin, "s")
    report("borehole", "error", np.abs(book.at(x)[:, 0] - exact).max() / np.ptp(exact), "1")
    report("borehole", "calls", book.build.evaluations, "1")
    report("borehole", "certificate_points", book.certificate.points, "1")
    report("borehole", "time_per_point", least(lambda: book.at(x, threads=1), 5) / len(x), "s")
    for peer in (tables, radial_functions, polynomial_chaos):
        try:
            for case, calls, answer in peer(lower, upper, int(book.build.evaluations), arguments.quick):
                report(case, "error", np.abs(answer(x) - exact).max() / np.ptp(exact), "1")
                report(case, "calls", calls, "1")
                report(case, "time_per_point", least(lambda: answer(x), 2) / len(x), "s")
        except ImportError as error:
            print(f"{error}: a peer is left out", file=sys.stderr)


def tables(lower, upper, calls, quick):
    """SciPy's linear interpolation of a table."""
    from scipy.interpolate import RegularGridInterpolator

    for nodes in (2, 3) if quick else (2, 3, 4, 5):
        axes = [np.linspace(a, b, nodes) for a, b in zip(lower, upper)]
        grid = np.stack(np.meshgrid(*axes, indexing="ij"), -1)
        table = RegularGridInterpolator(axes, borehole_function(grid.reshape(-1, 8)).reshape(grid.shape[:-1]))
        yield f"borehole, scipy table of {nodes}^8", nodes**8, table


def radial_functions(lower, upper, calls, quick):
    """SciPy's radial basis functions on as many Sobol' points as we call."""
    from scipy.interpolate import RBFInterpolator
    from scipy.stats import qmc

    unit = qmc.Sobol(8, seed=1).random_base2(int(np.ceil(np.log2(calls))))[:calls]
    values = borehole_function(lower + unit * (upper - lower))
    kernel = RBFInterpolator(unit, values, kernel="quintic")
    yield "borehole, scipy radial functions", calls, lambda x: kernel((x - lower) / (upper - lower))


def polynomial_chaos(lower, upper, calls, quick):
    """OpenTURNS' polynomials by least squares, on as many Sobol' points as we call."""
    import openturns as ot

    box = ot.ComposedDistribution([ot.Uniform(a, b) for a, b in zip(lower, upper)])
    points = ot.LowDiscrepancyExperiment(ot.SobolSequence(), box, calls).generate()
    values = ot.Sample(borehole_function(np.array(points))[:, None])
    enumeration = ot.LinearEnumerateFunction(8)
    basis = ot.OrthogonalProductPolynomialFactory([ot.LegendreFactory()] * 8, enumeration)
    for degree in (3,) if quick else (3, 4, 5):
        terms = ot.FixedStrategy(basis, enumeration.getStrataCumulatedCardinal(degree))
        algorithm = ot.FunctionalChaosAlgorithm(points, values, box, terms, ot.LeastSquaresStrategy())
        algorithm.run()
        chaos = algorithm.getResult().getMetaModel()
        yield f"borehole, openturns chaos of degree {degree}", calls, lambda x: np.array(chaos(ot.Sample(x)))[:, 0]


def imported(arguments):
    code = "import time; t = time.perf_counter(); import samara; print(time.perf_counter() - t)"
    environment = {"PYTHONPATH": str(ROOT / "build" / "release" / "python")}
    times = [float(subprocess.run([sys.executable, "-c", code], env=environment, check=True, capture_output=True, text=True).stdout)
             for _ in range(10)]
    report("import", "time", min(times), "s")
    code = code.replace("import samara", "import numpy")
    times = [float(subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout) for _ in range(10)]
    report("import", "numpy_time", min(times), "s")


def least_squares(arguments):
    try:
        from scipy.optimize import least_squares as minimise
    except ImportError:
        print("SciPy is not installed: case least_squares left out", file=sys.stderr)
        return
    with tempfile.TemporaryDirectory() as folder:
        result = samara.fit(samara.Codebook.open(coin_book(folder)), COIN / "coin.toml", COIN / "fit.toml")
    found = minimise(result.residuals, result.middle, result.jacobian, result.bounds, x_scale="jac", xtol=1e-12, ftol=1e-12, gtol=1e-12)
    C = result["C_D"]
    report("least_squares", "CD_difference", abs(found.x[0] - C.value) / C.standard_error, "1")
    report("least_squares", "evaluations", found.nfev, "1")


CASES = {"point": point, "batch": batch, "trajectories": trajectories, "borehole": borehole, "import": imported,
         "least_squares": least_squares}


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("case", nargs="?")
    options.add_argument("--quick", action="store_true")
    options.add_argument("--pictures", type=pathlib.Path)  # beside the benchmark programs; there are none of these
    arguments = options.parse_args()
    arguments.directory = arguments.pictures.parent if arguments.pictures else ROOT / "build" / "release" / "benchmarks"
    for name, case in CASES.items():
        if arguments.case in (None, name):
            case(arguments)


main()
