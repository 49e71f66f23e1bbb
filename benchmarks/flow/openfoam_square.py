#!/usr/bin/env python3
"""The square cylinder of `flow --case square_22000` by OpenFOAM's own k-epsilon solver, as a peer.

Needs `blockMesh`, `setFields` and `pimpleFoam` on the path (Debian: apt install openfoam). Same domain, inflow and cells
as ours: uniform squares, 10 lengths before the centre, 15 behind, 8 to each side; standard k-epsilon, its wall functions.

    python3 benchmarks/flow/openfoam_square.py --cells 8
"""

import argparse
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

import numpy

BEFORE, BEHIND, SIDE = 10, 15, 8
REYNOLDS, INTENSITY, SCALE, C_MU = 22000, 0.02, 0.07, 0.09
K = 1.5 * INTENSITY**2
EPSILON = C_MU**0.75 * K**1.5 / SCALE


def header(kind, name):
    return f"FoamFile {{ version 2.0; format ascii; class {kind}; object {name}; }}\n"


def block_mesh(cells):
    """Eight blocks about the square, every cell a square of 1/cells."""
    xs, ys = [-BEFORE, -0.5, 0.5, BEHIND], [-SIDE, -0.5, 0.5, SIDE]
    at = lambda i, j, k: k * 16 + j * 4 + i
    vertices = [f"({x} {y} {z})" for z in (0, 1 / cells) for y in ys for x in xs]
    count = lambda edges, i: round((edges[i + 1] - edges[i]) * cells)
    blocks, faces = [], {"inlet": [], "outlet": [], "sides": [], "body": [], "planes": []}
    for j in range(3):
        for i in range(3):
            if (i, j) == (1, 1):
                continue
            corners = [at(i, j, 0), at(i + 1, j, 0), at(i + 1, j + 1, 0), at(i, j + 1, 0)]
            corners += [corner + 16 for corner in corners]
            blocks.append(f"hex ({' '.join(map(str, corners))}) ({count(xs, i)} {count(ys, j)} 1) simpleGrading (1 1 1)")
            left, right = (0, 4, 7, 3), (1, 2, 6, 5)
            below, above = (0, 1, 5, 4), (3, 7, 6, 2)
            for side, patch in [(left, "inlet" if i == 0 else "body" if (i, j) == (2, 1) else None),
                                (right, "outlet" if i == 2 else "body" if (i, j) == (0, 1) else None),
                                (below, "sides" if j == 0 else "body" if (i, j) == (1, 2) else None),
                                (above, "sides" if j == 2 else "body" if (i, j) == (1, 0) else None),
                                ((0, 3, 2, 1), "planes"), ((4, 5, 6, 7), "planes")]:
                if patch:
                    faces[patch].append(f"({' '.join(str(corners[c]) for c in side)})")
    kinds = {"inlet": "patch", "outlet": "patch", "sides": "patch", "body": "wall", "planes": "empty"}
    boundary = "".join(f"{name} {{ type {kinds[name]}; faces ({' '.join(of)}); }}\n" for name, of in faces.items())
    return (header("dictionary", "blockMeshDict") + f"scale 1;\nvertices ({' '.join(vertices)});\n"
            f"blocks ({' '.join(blocks)});\nedges ();\nboundary (\n{boundary});\nmergePatchPairs ();\n")


def field(name, dimensions, value, inlet, outlet, body):
    kind = "volVectorField" if name == "U" else "volScalarField"
    return (header(kind, name) + f"dimensions {dimensions};\ninternalField uniform {value};\nboundaryField {{\n"
            f"inlet {{ {inlet} }}\noutlet {{ {outlet} }}\nsides {{ type slip; }}\nbody {{ {body} }}\n"
            "planes { type empty; }\n}\n")


def write_case(folder, cells, end):
    files = {"system/blockMeshDict": block_mesh(cells)}
    fixed = lambda value: f"type fixedValue; value uniform {value};"
    leaves = lambda value: f"type inletOutlet; inletValue uniform {value}; value uniform {value};"
    files["0/U"] = field("U", "[0 1 -1 0 0 0 0]", "(1 0 0)", fixed("(1 0 0)"), leaves("(0 0 0)").replace(
        "value uniform (0 0 0);", "value uniform (1 0 0);"), "type noSlip;")
    files["0/p"] = field("p", "[0 2 -2 0 0 0 0]", 0, "type zeroGradient;", fixed(0), "type zeroGradient;")
    files["0/k"] = field("k", "[0 2 -2 0 0 0 0]", K, fixed(K), leaves(K), f"type kqRWallFunction; value uniform {K};")
    files["0/epsilon"] = field("epsilon", "[0 2 -3 0 0 0 0]", EPSILON, fixed(EPSILON), leaves(EPSILON),
                               f"type epsilonWallFunction; value uniform {EPSILON};")
    files["0/nut"] = field("nut", "[0 2 -1 0 0 0 0]", 0, "type calculated; value uniform 0;",
                           "type calculated; value uniform 0;", "type nutkWallFunction; value uniform 0;")
    files["constant/transportProperties"] = (header("dictionary", "transportProperties") +
                                             f"transportModel Newtonian;\nnu {1 / REYNOLDS};\n")
    files["constant/turbulenceProperties"] = (header("dictionary", "turbulenceProperties") +
                                              "simulationType RAS;\nRAS { RASModel kEpsilon; turbulence on; printCoeffs off; }\n")
    # What sets off the shedding: a kick across the stream behind the body, as ours has.
    files["system/setFieldsDict"] = (header("dictionary", "setFieldsDict") +
                                     "defaultFieldValues ();\nregions ( boxToCell { box (0.75 -0.75 -1) (2.25 0.75 1); "
                                     "fieldValues ( volVectorFieldValue U (1 0.2 0) ); } );\n")
    files["system/controlDict"] = (header("dictionary", "controlDict") + f"""application pimpleFoam;
startFrom startTime; startTime 0; stopAt endTime; endTime {end}; deltaT {0.1 / cells};
writeControl runTime; writeInterval {end}; purgeWrite 1; writeFormat binary; runTimeModifiable false;
adjustTimeStep yes; maxCo 0.8; maxDeltaT 1;
functions {{ loads {{ type forceCoeffs; libs ("libforces.so"); patches (body); rho rhoInf; rhoInf 1; magUInf 1; lRef 1;
Aref {1 / cells}; CofR (0 0 0); dragDir (1 0 0); liftDir (0 1 0); pitchAxis (0 0 1); log false; writeControl timeStep; }} }}
""")
    files["system/fvSchemes"] = header("dictionary", "fvSchemes") + """ddtSchemes { default backward; }
gradSchemes { default Gauss linear; }
divSchemes { default none; div(phi,U) Gauss vanLeerV; div(phi,k) Gauss vanLeer; div(phi,epsilon) Gauss vanLeer;
div((nuEff*dev2(T(grad(U))))) Gauss linear; }
laplacianSchemes { default Gauss linear corrected; }
interpolationSchemes { default linear; }
snGradSchemes { default corrected; }
wallDist { method meshWave; }
"""
    files["system/fvSolution"] = header("dictionary", "fvSolution") + """solvers {
p { solver GAMG; smoother GaussSeidel; tolerance 1e-6; relTol 0.01; } pFinal { $p; relTol 0; }
"(U|k|epsilon).*" { solver smoothSolver; smoother symGaussSeidel; tolerance 1e-8; relTol 0; } }
PIMPLE { nOuterCorrectors 1; nCorrectors 2; nNonOrthogonalCorrectors 0; }
"""
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)


def run(folder, program):
    with open(folder / f"{program}.log", "w") as log:
        if subprocess.run([program, "-case", str(folder)], stdout=log, stderr=subprocess.STDOUT).returncode != 0:
            sys.exit(f"{program} failed: {folder}/{program}.log")


def means(folder):
    """Of the drag over the whole periods of the last half of the run: C_D, its half width, St, rms of C_L, periods."""
    path = next(folder.glob("postProcessing/loads/*/coefficient.dat"))
    names = [line for line in path.read_text().splitlines() if line.startswith("# Time")][-1][1:].split()
    data = numpy.loadtxt(path)
    t, drag, lift = (data[:, names.index(name)] for name in ("Time", "Cd", "Cl"))
    late = t > 0.5 * t[-1]
    t, drag, lift = t[late], drag[late], lift[late]
    swing = lift - lift.mean()
    up = [i for i in range(1, len(t)) if swing[i - 1] < 0 <= swing[i]]
    crossings = [t[i] - swing[i] * (t[i] - t[i - 1]) / (swing[i] - swing[i - 1]) for i in up]
    if len(up) < 4:
        sys.exit(f"only {len(up)} periods of the lift: a longer --time was expected")
    over = lambda values, a, b: numpy.trapz(values[a:b + 1], t[a:b + 1]) / (t[b] - t[a])
    by_period = numpy.array([over(drag, a, b) for a, b in zip(up, up[1:])])
    width = 1.96 * by_period.std(ddof=1) / math.sqrt(len(by_period))
    rms = math.sqrt(over(swing**2, up[0], up[-1]))
    return by_period.mean(), width, (len(up) - 1) / (crossings[-1] - crossings[0]), rms, len(by_period)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cells", type=int, default=8, help="per length, even (default: 8)")
    parser.add_argument("--time", type=float, default=150, help="l/U, of which the second half is averaged (default: 150)")
    parser.add_argument("--keep", metavar="FOLDER", help="leave the case there")
    options = parser.parse_args()
    if options.cells < 4 or options.cells % 2 or not options.time > 0:
        parser.error("--cells is even and at least 4, --time is positive")
    if missing := [name for name in ("blockMesh", "setFields", "pimpleFoam") if not shutil.which(name)]:
        sys.exit(f"OpenFOAM is not there: no {', '.join(missing)} on the path (Debian: apt install openfoam)")
    folder = pathlib.Path(options.keep or tempfile.mkdtemp(prefix="openfoam_"))
    write_case(folder, options.cells, options.time)
    begin = time.time()
    for program in ("blockMesh", "setFields", "pimpleFoam"):
        run(folder, program)
    seconds = time.time() - begin
    drag, width, strouhal, lift, periods = means(folder)
    for metric, value in [(f"C_D_{options.cells}", drag), ("C_D_half_width", width), ("St", strouhal), ("C_L_rms", lift),
                          ("periods", periods), ("time", seconds)]:
        line = {"bench": "flow", "case": "square_22000_openfoam", "metric": metric, "value": float(f"{value:.6g}")}
        print(json.dumps(line | ({"unit": "s"} if metric == "time" else {})))
    if not options.keep:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
