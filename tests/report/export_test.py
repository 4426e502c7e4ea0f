"""Every export of a run, read back by a reader that is not ours: assimp, check_urdf, csv, json, PIL. Debian has no reader
of MCAP; the one in here was written from its specification (mcap.dev/spec).

  python3 export_test.py COMMAND RUN     RUN: folder of a run with one stone placed
"""
import csv
import json
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

import jsonschema
import numpy as np
from PIL import Image

COMMAND, RUN = sys.argv[1], pathlib.Path(sys.argv[2])
RESULT = json.loads((RUN / "result.json").read_text())
PLACED = RESULT["placements"][-1]
TOLERANCE = 5e-5  # m: the report rounds poses to 1e-5, and a stone is 0.1 m across


def export(format, folder, run=RUN, code=0):
    done = subprocess.run([COMMAND, "export", str(run), "--to", format, "--out", str(folder)], capture_output=True,
                          text=True)
    assert done.returncode == code, f"{format}: {done.returncode}\n{done.stderr}"
    return [pathlib.Path(line) for line in done.stdout.splitlines()] if code == 0 else done.stderr


def vertices_by_assimp(path):
    """Vertices of a file in its own frame, as assimp sees them: all transforms applied."""
    with tempfile.TemporaryDirectory() as folder:
        target = pathlib.Path(folder) / "mesh.ply"
        subprocess.run(["assimp", "export", str(path), str(target), "-fply"], check=True, capture_output=True)
        text = target.read_text()
    count = int(re.search(r"element vertex (\d+)", text)[1])
    lines = text[text.index("end_header\n") + 11:].splitlines()[:count]
    return np.array([[float(x) for x in line.split()[:3]] for line in lines])


def rotation(q):
    x, y, z, w = (q[key] for key in ("qx", "qy", "qz", "qw"))
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def place(vertices, pose):
    return vertices @ rotation(pose).T + [pose["x"], pose["y"], pose["z"]]


def box(vertices):
    return np.array([vertices.min(axis=0), vertices.max(axis=0)])


def read_mcap(data):
    """Schemas, channels, messages and statistics of an MCAP file (mcap.dev/spec); messages are found by the index."""
    magic = b"\x89MCAP0\r\n"
    assert data.startswith(magic) and data.endswith(magic)

    def text(content, at):
        size, = struct.unpack_from("<I", content, at)
        return content[at + 4:at + 4 + size].decode(), at + 4 + size

    schemas, channels, messages, statistics, order = {}, {}, [], None, []
    chunks, found = {}, {}
    at, end = 8, len(data) - 8
    while at < end:
        kind, size = struct.unpack_from("<BQ", data, at)
        content = data[at + 9:at + 9 + size]
        assert len(content) == size
        order.append((kind, at))
        if kind == 3:
            number, = struct.unpack_from("<H", content)
            name, next_at = text(content, 2)
            encoding, next_at = text(content, next_at)
            schema, next_at = text(content, next_at)
            assert next_at == size and encoding == "jsonschema"
            schemas[number] = (name, json.loads(schema))
        elif kind == 4:
            number, schema = struct.unpack_from("<HH", content)
            topic, next_at = text(content, 4)
            encoding, next_at = text(content, next_at)
            assert encoding == "json" and struct.unpack_from("<I", content, next_at) == (0,) and next_at + 4 == size
            channels[number] = (topic, schema)
        elif kind == 6:
            first, last, whole, checksum = struct.unpack_from("<QQQI", content)
            compression, next_at = text(content, 28)
            stored, = struct.unpack_from("<Q", content, next_at)
            records = content[next_at + 8:]
            assert compression == "" and stored == whole == len(records)
            chunks[at] = (first, last, records)
        elif kind == 8:
            first, last, start, length, offsets = struct.unpack_from("<QQQQI", content)
            assert chunks[start][:2] == (first, last)
            assert struct.unpack_from("<BQ", data, start) == (6, length - 9)
            for k in range(0, offsets, 10):
                channel, index_at = struct.unpack_from("<HQ", content, 36 + k)
                kind_of_index, index_size = struct.unpack_from("<BQ", data, index_at)
                index = data[index_at + 9:index_at + 9 + index_size]
                assert kind_of_index == 7 and struct.unpack_from("<HI", index) == (channel, index_size - 6)
                for logged, offset in struct.iter_unpack("<QQ", index[6:]):
                    assert first <= logged <= last
                    found[(start, offset)] = (channel, logged)
        elif kind == 11:
            statistics = struct.unpack_from("<QHIIIIQQI", content)
        elif kind == 2:
            summary, = struct.unpack_from("<Q", content)
            assert summary in [position for _, position in order]
        at += 9 + size
    for (start, offset), expected in sorted(found.items()):
        records = chunks[start][2]
        kind, size = struct.unpack_from("<BQ", records, offset)
        content = records[offset + 9:offset + 9 + size]
        channel, sequence, logged, published = struct.unpack_from("<HIQQ", content)
        assert kind == 5 and channel in channels and (channel, logged) == expected
        messages.append((channel, sequence, logged, json.loads(content[22:])))
    assert len(chunks) == statistics[5] == 1
    assert at == end and order[0][0] == 1 and order[-1][0] == 2 and 15 in [kind for kind, _ in order]
    return schemas, channels, messages, statistics


class Exports(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        stones = pathlib.Path(__file__).parents[2] / "data" / "stones"
        mesh = vertices_by_assimp(stones / PLACED["stone"] / "mesh.ply")
        self.expected = box(place(mesh, PLACED["T_W_O_measured"]))

    def test_the_run_is_one_to_test_with(self):
        self.assertEqual((RESULT["height"], PLACED["outcome"]), (1, "placed"))

    def test_ply_is_the_tower(self):
        path, = export("ply", self.folder)
        np.testing.assert_allclose(box(vertices_by_assimp(path)), self.expected, atol=TOLERANCE)

    def test_glb_has_stones_and_animation(self):
        path, = export("glb", self.folder)
        info = subprocess.run(["assimp", "info", str(path)], check=True, capture_output=True, text=True).stdout
        self.assertRegex(info, r"Animations:\s+1")
        self.assertRegex(info, rf"Meshes:\s+{len(RESULT['stones'])}\n")
        x, y, z = vertices_by_assimp(path).T  # y is up in glTF
        np.testing.assert_allclose(box(np.array([x, -z, y]).T), self.expected, atol=TOLERANCE)
        # The keys of the animation, by the specification
        data = path.read_bytes()
        magic, version, length, size, kind = struct.unpack_from("<4sIII4s", data)
        self.assertEqual((magic, version, length, kind), (b"glTF", 2, len(data), b"JSON"))
        gltf, start = json.loads(data[20:20 + size]), 20 + size + 8
        channel = gltf["animations"][0]["channels"][0]
        sampler = gltf["animations"][0]["samplers"][channel["sampler"]]

        def numbers(accessor, width):
            entry = gltf["accessors"][accessor]
            at = start + gltf["bufferViews"][entry["bufferView"]]["byteOffset"]
            return np.frombuffer(data, "<f4", entry["count"] * width, at).reshape(-1, width)

        times, positions = numbers(sampler["input"], 1), numbers(sampler["output"], 3)
        self.assertEqual(channel["target"]["path"], "translation")
        self.assertTrue((np.diff(times[:, 0]) > 0).all())
        measured = [PLACED["T_W_O_measured"][axis] for axis in "xyz"]
        np.testing.assert_allclose(positions[-1], measured, atol=TOLERANCE)
        self.assertGreater(positions[:, 2].max(), measured[2] + 0.05)  # it was lifted
        self.assertGreater(np.linalg.norm(positions[0] - positions[-1]), 0.1)  # from where it lay

    def test_glb_turns_are_unit_quaternions_from_where_a_stone_lay_to_where_it_stands(self):
        path, = export("glb", self.folder)
        data = path.read_bytes()
        size, = struct.unpack_from("<I", data, 12)
        gltf, start = json.loads(data[20:20 + size]), 20 + size + 8
        animation = gltf["animations"][0]
        turns = [channel for channel in animation["channels"] if channel["target"]["path"] == "rotation"]
        self.assertGreater(len(turns), 0)
        for channel in turns:
            entry = gltf["accessors"][animation["samplers"][channel["sampler"]]["output"]]
            at = start + gltf["bufferViews"][entry["bufferView"]]["byteOffset"]
            q = np.frombuffer(data, "<f4", entry["count"] * 4, at).reshape(-1, 4)
            np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1.0, atol=1e-5)
        measured = [PLACED["T_W_O_measured"][part] for part in ("qx", "qy", "qz", "qw")]
        name = PLACED["stone"]
        last = [q for channel in turns if gltf["nodes"][channel["target"]["node"]]["name"] == name
                for entry in [gltf["accessors"][animation["samplers"][channel["sampler"]]["output"]]]
                for q in [np.frombuffer(data, "<f4", entry["count"] * 4,
                                        start + gltf["bufferViews"][entry["bufferView"]]["byteOffset"]).reshape(-1, 4)[-1]]]
        self.assertEqual(len(last), 1)
        self.assertAlmostEqual(abs(float(np.dot(last[0], measured))), 1.0, delta=1e-5)

    def test_urdf_is_read_by_urdfdom(self):
        path, *meshes = export("urdf", self.folder)
        tree = subprocess.run(["check_urdf", str(path)], check=True, capture_output=True, text=True).stdout
        self.assertIn(f"child(1):  {PLACED['stone']}", tree)
        self.assertEqual(len(meshes), len(RESULT["stones"]))
        robot = ElementTree.parse(path).getroot()
        link, = [l for l in robot.findall("link") if l.get("name") == PLACED["stone"]]
        mesh = vertices_by_assimp(path.parent / link.find("collision/geometry/mesh").get("filename"))
        origin = robot.find("joint/origin")
        roll, pitch, yaw = map(float, origin.get("rpy").split())

        def about(axis, angle):
            c, s = np.cos(angle), np.sin(angle)
            return np.roll(np.array([[1, 0, 0], [0, c, -s], [0, s, c]]), (axis, axis), (0, 1))

        turned = mesh @ (about(2, yaw) @ about(1, pitch) @ about(0, roll)).T
        np.testing.assert_allclose(box(turned + list(map(float, origin.get("xyz").split()))), self.expected,
                                   atol=TOLERANCE)

    def test_csv_has_placements_and_trajectory(self):
        placements, trajectory = export("csv", self.folder)
        with open(placements, newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), len(RESULT["placements"]))
        self.assertEqual((rows[-1]["stone"], rows[-1]["outcome"]), (PLACED["stone"], "placed"))
        for axis in ("x", "y", "z"):
            self.assertAlmostEqual(float(rows[-1]["measured_" + axis]), PLACED["T_W_O_measured"][axis], delta=1e-11)
        with open(trajectory, newline="") as file:
            samples = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
        times = np.array([sample["t"] for sample in samples])
        self.assertTrue((np.diff(times) >= 0).all())
        self.assertAlmostEqual(times[-1], RESULT["seconds"]["motion"], delta=0.2 * times[-1])
        self.assertEqual({sample["holds"] for sample in samples}, {0.0, 1.0})

    def test_mcap_messages_keep_their_schemas(self):
        path, = export("mcap", self.folder)
        schemas, channels, messages, statistics = read_mcap(path.read_bytes())
        self.assertEqual({topic for topic, _ in channels.values()},
                         {"/joints", "/gripper", "/stones", "/placements", "/log"})
        for channel, _, _, data in messages:
            jsonschema.validate(data, schemas[channels[channel][1]][1])
        times = [logged for _, _, logged, _ in messages]
        self.assertEqual(times, sorted(times))
        self.assertEqual(statistics[0], len(messages))
        self.assertEqual(statistics[6:8], (times[0], times[-1]))
        of = {topic: [data for channel, _, _, data in messages if channels[channel][0] == topic]
              for topic, _ in channels.values()}
        self.assertEqual({len(data["q"]) for data in of["/joints"]}, {6})
        last = [data["T_W_O"] for data in of["/stones"] if data["stone"] == PLACED["stone"]][-1]
        for axis in ("x", "y", "z"):
            self.assertAlmostEqual(last[axis], PLACED["T_W_O_measured"][axis], delta=TOLERANCE)
        self.assertEqual([data["outcome"] for data in of["/placements"]],
                         [entry["outcome"] for entry in RESULT["placements"]])

    def test_png_shows_something(self):
        path, = export("png", self.folder)
        with Image.open(path) as picture:
            picture.load()
            self.assertEqual((picture.format, picture.mode), ("PNG", "RGB"))
            self.assertGreater(min(picture.size), 500)
            self.assertGreater(len(picture.getcolors(picture.width * picture.height)), 100)

    def test_compas_assembly_has_blocks_sequence_and_trajectories(self):
        path, = export("compas", self.folder)
        assembly = json.loads(path.read_text())
        self.assertEqual(assembly["dtype"], "compas_assembly.datastructures/Assembly")
        attributes, graph = assembly["data"]["attributes"], assembly["data"]["graph"]["data"]
        self.assertEqual(attributes["sequence"], [1])
        self.assertEqual([node["is_support"] for node in graph["node"].values()], [True, False])
        for node in graph["node"].values():  # closed and facing outwards
            block = node["block"]["data"]
            corners = {key: np.array([v["x"], v["y"], v["z"]]) for key, v in block["vertex"].items()}
            volume = sum(np.dot(corners[str(a)], np.cross(corners[str(b)], corners[str(c)])) / 6
                         for a, b, c in block["face"].values())
            self.assertGreater(volume, 0)
        np.testing.assert_allclose(box(np.array(list(corners.values()))), self.expected, atol=TOLERANCE)
        carried = attributes["trajectories"][-1]
        self.assertEqual(carried["stone"], PLACED["stone"])
        self.assertEqual(len(carried["joint_names"]), len(carried["points"][0]["joint_values"]))
        times = [point["time_from_start"]["secs"] + 1e-9 * point["time_from_start"]["nsecs"]
                 for point in carried["points"]]
        self.assertEqual(times[0], 0)
        self.assertTrue((np.diff(times) >= 0).all())

    def test_compas_assembly_has_what_files_have_that_compas_wrote(self):
        sample = pathlib.Path(__file__).parents[3] / "shared" / "assemblies" / "wall_assembly.json"
        if not sample.exists():
            self.skipTest(f"{sample} is not there")

        def keys(node, found):
            """Keys of each data type, joined over all of its objects."""
            if isinstance(node, dict):
                if "dtype" in node:
                    found.setdefault(node["dtype"], set()).update(node["data"])
                node = list(node.values())
            if isinstance(node, list):
                for part in node:
                    keys(part, found)
            return found

        path, = export("compas", self.folder)
        ours, theirs = keys(json.loads(path.read_text()), {}), keys(json.loads(sample.read_text()), {})
        self.assertEqual(set(ours) - set(theirs), set(), "types that COMPAS does not have")
        for dtype, names in ours.items():
            self.assertEqual(names, theirs[dtype], dtype)

    def test_a_folder_without_its_record_is_refused_with_the_reason(self):
        self.assertIn("no folder", export("glb", self.folder, self.folder / "nowhere", 3))
        killed = self.folder / "killed"
        killed.mkdir()
        shutil.copy(RUN / "journal.jsonl", killed)
        self.assertIn("the run was killed", export("glb", self.folder, killed, 3))
        shutil.copy(RUN / "result.json", killed)
        report = (RUN / "report.html").read_text()
        for damaged in ("", report[:len(report) // 2], report.replace('"samples":"', '"samples":"!'),
                        report.replace('"carries":', '"worries":'), report.replace('"T_T_O":[', '"T_T_O":[1,')):
            (killed / "report.html").write_text(damaged)
            self.assertIn("report.html: is no record of a run", export("glb", self.folder, killed, 3))
        self.assertIn("--to", export("obj", self.folder, RUN, 2))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
