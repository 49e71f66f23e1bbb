"""Binary glTF 2.0 read by nothing but its specification: chunks, accessors, one animated node."""

import json
import math
import os
import pathlib
import shutil
import struct
import subprocess

import numpy as np

KINDS = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


def issues(path):
    """What the Khronos validator (npm: gltf-validator) counts: errors, warnings, infos and hints. None where
    SAMARA_NODE_MODULES does not lead to it."""
    modules = os.environ.get("SAMARA_NODE_MODULES", "")
    if shutil.which("node") is None or not os.path.isdir(os.path.join(modules, "gltf-validator")):
        return None
    script = ("require(process.argv[2] + '/gltf-validator').validateBytes(new Uint8Array(require('fs').readFileSync(process.argv[1])))"
              ".then((report) => console.log(JSON.stringify(report.issues)))")
    answer = subprocess.run(["node", "-e", script, path, modules], check=True, capture_output=True, text=True, timeout=600)
    counts = json.loads(answer.stdout)
    return [counts[f"num{kind}"] for kind in ["Errors", "Warnings", "Infos", "Hints"]]


def y_up(vectors):
    """From z up: x stays, z becomes y."""
    return vectors[..., [0, 2, 1]] * np.array([1.0, 1.0, -1.0])


class Glb:
    def __init__(self, path):
        data = pathlib.Path(path).read_bytes()
        magic, version, length = struct.unpack("<4sII", data[:12])
        assert (magic, version, length) == (b"glTF", 2, len(data)), (magic, version, length, len(data))
        chunks, at = [], 12
        while at < len(data):
            size, kind = struct.unpack("<I4s", data[at:at + 8])
            assert size % 4 == 0
            chunks.append((kind, data[at + 8:at + 8 + size]))
            at += 8 + size
        assert [kind for kind, _ in chunks] == [b"JSON", b"BIN\0"]
        self.json, self.bytes = json.loads(chunks[0][1]), chunks[1][1]
        assert self.json["asset"]["version"] == "2.0"
        assert self.json["buffers"][0]["byteLength"] <= len(self.bytes)

    def accessor(self, number):
        """Rows of numbers; ends that the accessor states are those of its numbers."""
        accessor = self.json["accessors"][number]
        view, kind, width = self.json["bufferViews"][accessor["bufferView"]], KINDS[accessor["componentType"]], WIDTHS[accessor["type"]]
        begin = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        size = np.dtype(kind).itemsize * width * accessor["count"]
        assert begin % 4 == 0 and accessor.get("byteOffset", 0) + size <= view["byteLength"]
        rows = np.frombuffer(self.bytes[begin:begin + size], np.dtype(kind).newbyteorder("<")).reshape(-1, width)
        for name, end in [("min", rows.min(0)), ("max", rows.max(0))]:
            assert name not in accessor or np.array_equal(np.array(accessor[name], rows.dtype), end), name
        return rows

    def mesh(self, node=0):
        primitive = self.json["meshes"][self.json["nodes"][node]["mesh"]]["primitives"][0]
        assert "min" in self.json["accessors"][primitive["attributes"]["POSITION"]]
        return self.accessor(primitive["attributes"]["POSITION"]), self.accessor(primitive["indices"]).reshape(-1, 3)

    def channel(self, path, node=0):
        animation = self.json["animations"][0]
        channel, = [c for c in animation["channels"] if c["target"] == {"node": node, "path": path}]
        sampler = animation["samplers"][channel["sampler"]]
        assert sampler.get("interpolation", "LINEAR") == "LINEAR"
        times, rows = self.accessor(sampler["input"])[:, 0].astype(float), self.accessor(sampler["output"]).astype(float)
        assert np.all(np.diff(times) > 0) and len(times) == len(rows)
        return times, rows

    def pose(self, time, node=0):
        """Position and quaternion (x, y, z, w) at a time, as players do it: linear, and slerp."""
        times, places = self.channel("translation", node)
        turn_times, turns = self.channel("rotation", node)
        place = np.array([np.interp(time, times, places[:, k]) for k in range(3)])
        k = min(max(np.searchsorted(turn_times, time, side="right") - 1, 0), len(turn_times) - 2)
        a, b = turns[k] / np.linalg.norm(turns[k]), turns[k + 1] / np.linalg.norm(turns[k + 1])
        share = (time - turn_times[k]) / (turn_times[k + 1] - turn_times[k])
        cosine = float(a @ b)
        assert cosine >= 0, "keys take the long way"
        half = math.acos(min(1.0, cosine))
        if half < 1e-9:
            return place, a
        return place, (math.sin((1 - share) * half) * a + math.sin(share * half) * b) / math.sin(half)

    def worst(self, times, places, quaternions, node=0):
        """The largest distance and the largest angle [deg] from poses in a world with z up, quaternions (w, x, y, z)."""
        distance = angle = 0.0
        for time, place, q in zip(times - times[0], places, quaternions):
            found, turn = self.pose(time, node)
            expected = np.append(y_up(q[1:]), q[0]) / np.linalg.norm(q)
            distance = max(distance, float(np.linalg.norm(found - y_up(place))))
            angle = max(angle, math.degrees(2 * math.acos(min(1.0, abs(float(turn @ expected))))))
        return distance, angle

    def check_against(self, case, times, places, quaternions, size):
        distance, angle = self.worst(np.asarray(times), places, quaternions)
        case.assertLess(angle, 0.5)
        case.assertLess(distance, 1e-3 * size)
        for _, rows in [self.channel("rotation")]:
            case.assertLess(np.max(np.abs(np.linalg.norm(rows, axis=1) - 1.0)), 1e-6)
