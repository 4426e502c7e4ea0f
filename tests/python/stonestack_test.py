"""The Python module against the command: the same numbers, bit for bit.

  PYTHONPATH=MODULE STONESTACK=COMMAND python3 stonestack_test.py [CLASS]
"""
import ast
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np
import PIL.Image
import stonestack as ss

COMMAND = os.environ["STONESTACK"]


def command(*arguments, codes=(0,)):
    done = subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode in codes, f"{arguments}: {done.returncode}\n{done.stderr}"
    return done.stdout


def matrix(pose):
    """4 x 4 of {x, y, z, qx, qy, qz, qw}, by the textbook formula."""
    x, y, z, w = (pose[key] for key in ("qx", "qy", "qz", "qw"))
    T = np.eye(4)
    T[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                 [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                 [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    T[:3, 3] = pose["x"], pose["y"], pose["z"]
    return T


class Case(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.folder.name)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def same_pose(self, array, pose):
        self.assertEqual(array.shape, (4, 4))
        self.assertEqual(list(array[:3, 3]), [pose["x"], pose["y"], pose["z"]])  # bit for bit
        np.testing.assert_allclose(array, matrix(pose), atol=1e-14)

    def same_run(self, run, text):
        mine, theirs = json.loads(run.json()), json.loads(text)
        for host in ("detection", "search", "planning", "beside_motion"):  # host seconds differ from run to run
            mine["seconds"].pop(host), theirs["seconds"].pop(host)
        mine.pop("version"), theirs.pop("version")  # they may have been built from different commits
        self.assertEqual(mine, theirs)
        return theirs


class Stones(Case):
    def test_catalogue_is_that_of_the_files(self):
        catalogue = ss.read_catalogue()
        folders = sorted(p.name for p in pathlib.Path(catalogue.path).iterdir() if (p / "stone.yaml").exists())
        self.assertEqual(catalogue.names, folders)
        self.assertEqual(len(catalogue), len(folders))
        self.assertEqual(catalogue[-1].name, folders[-1])
        stone = catalogue[folders[0]]
        self.assertEqual(stone.mesh.vertices.shape[1], 3)
        corners = stone.scan.vertices[stone.scan.faces]
        volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
        self.assertAlmostEqual(volume * stone.density, stone.mass, delta=1e-3 * stone.mass)
        self.assertEqual(stone.I_M.shape, (3, 3))
        with self.assertRaises(IndexError):
            catalogue[len(catalogue)]

    def test_errors_have_classes(self):
        with self.assertRaises(ss.FileError) as caught:
            ss.read_catalogue("/nowhere")
        self.assertIsInstance(caught.exception, OSError)
        self.assertEqual(caught.exception.exit_code, 3)
        self.assertIn("/nowhere", str(caught.exception))
        with self.assertRaises(ss.InvalidArgument) as caught:
            ss.read_catalogue()["limestone_01"]
        self.assertIsInstance(caught.exception, ValueError)
        with self.assertRaises(ss.InvalidArgument):
            ss.search(stones="limestone_1", options={"search.frictoin": 0.3})
        with self.assertRaises(ss.InvalidArgument):
            ss.check("tower.yaml", friction=-1)
        with self.assertRaises(ss.Error):
            ss.plan("scene.yaml", stone="limestone_1", target=2 * np.eye(4))


class Hints(Case):
    def test_hints_name_what_the_module_has_and_no_more(self):
        tree = ast.parse(pathlib.Path(ss.__file__).with_name("stonestack-stubs").joinpath("__init__.pyi").read_text())
        classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
        functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
        public = {name for name in dir(ss) if not name.startswith("_")}
        self.assertEqual(public, set(classes) | functions)
        for name, node in classes.items():
            if issubclass(getattr(ss, name), Exception):
                continue
            hinted = {member.name for member in node.body if isinstance(member, ast.FunctionDef)} - {"__init__"}
            there = {m for m in vars(getattr(ss, name)) if not m.startswith("_") or m in ("__len__", "__getitem__")}
            self.assertEqual(hinted, there, name)


class Detect(Case):
    def test_same_as_the_command(self):
        scene = ss.render(str(self.path / "scene"), seed=3, stones=["limestone_1", "limestone_2"])
        file = self.path / "scene" / "scene.yaml"
        command("render", "--out", self.path / "other", "--seed", 3, "--stones", "limestone_1,limestone_2", "-q")
        self.assertEqual((self.path / "other" / "depth.png").read_bytes(), (file.parent / "depth.png").read_bytes())
        text = command("detect", file, "--json", "-q")
        found = ss.detect(str(file))
        self.assertEqual(found.json(), text)
        listed = json.loads(text)["detections"]
        self.assertEqual(len(found), len(listed))
        for detection, entry in zip(found.detections, listed):
            self.assertEqual(detection.stone, entry["stone"])
            self.assertEqual(detection.score, entry["score"])
            self.assertEqual(detection.inlier_ratio, entry["inlier_ratio"])
            self.assertEqual(detection.covariance_C.tolist(), entry["covariance_C"])
            self.same_pose(detection.T_C_O, entry["T_C_O"])
            truth = dict(scene.stones)[detection.stone]
            np.testing.assert_allclose(detection.T_W_O[:3, 3], truth[:3, 3], atol=0.005)
        # The same image as an array
        image, T_W_C = ss.read_depth(str(file))
        self.assertEqual(image.z.dtype, np.float32)
        again = ss.DepthImage(image.z, image.fx, image.fy, image.cx, image.cy)
        self.assertEqual(ss.detect(again, camera_pose=T_W_C).detections[0].score, listed[0]["score"])
        self.assertEqual(image.cloud().shape, (*image.z.shape, 3))
        cloud = ss.read_cloud(str(file.parent / "cloud.ply")).reshape(-1, 3)
        seen = np.isfinite(cloud[:, 2])
        np.testing.assert_allclose(cloud[seen], image.cloud().reshape(-1, 3)[seen], atol=1e-6)


class Segment(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        stones = ["limestone_1", "limestone_2", "limestone_3"]
        cls.files = []
        for tilt in (0.1, 0.4):
            ss.render(str(cls.path / str(tilt)), seed=3, stones=stones, options={"scene.tilt": tilt})
            cls.files.append(str(cls.path / str(tilt) / "scene.yaml"))

    def compare(self, result, text):
        self.assertEqual(result.json(), text)
        listed = json.loads(text)
        self.assertEqual(len(result), len(listed["objects"]))
        self.assertEqual(result.note, listed["note"])
        table = listed["table_C"]
        self.assertEqual(result.table_C.normal.tolist(), [table["normal"][k] for k in "xyz"])
        self.assertEqual(result.table_C.offset, table["offset_m"])
        for found, entry in zip(result.objects, listed["objects"]):
            self.assertEqual(found.size.tolist(), [entry[k] for k in ("length_m", "width_m", "height_m")])
            self.assertEqual(found.p_C_middle.tolist(), [entry["p_C_middle"][k] for k in "xyz"])
            self.assertEqual(found.p_W_middle.tolist(), [entry["p_W_middle"][k] for k in "xyz"])
            self.assertEqual((found.pixels, found.views, found.confidence, found.cut_off),
                             (entry["pixels"], entry["views"], entry["confidence"], entry["cut_off"]))
        return listed["objects"]

    def test_same_as_the_command(self):
        out, picture = self.path / "out", self.path / "objects.png"
        text = command("segment", self.files[0], "--json", "-q", "--out", out, "--picture", picture)
        result = ss.segment(self.files[0])
        self.assertEqual(len(self.compare(result, text)), 3)
        self.assertEqual(len(result.labels), 1)
        labels = result.labels[0]
        self.assertTrue(np.issubdtype(labels.dtype, np.integer))
        np.testing.assert_array_equal(labels, np.array(PIL.Image.open(out / "labels_1.png")))
        for number, found in enumerate(result.objects, 1):
            self.assertEqual((labels == number).sum(), found.pixels)
            np.testing.assert_array_equal(found.cloud_C, ss.read_cloud(str(out / f"object_{number}.ply")))
            self.assertEqual(found.normals_C.shape, found.cloud_C.shape)
            np.testing.assert_allclose(np.linalg.norm(found.normals_C, axis=1), 1, atol=1e-5)
            self.assertTrue(((found.normals_C * found.cloud_C).sum(axis=1) < 0).all())  # towards the camera
        result.write(str(self.path / "mine"))
        result.draw(str(self.path / "mine.png"))
        for file in out.iterdir():
            self.assertEqual((self.path / "mine" / file.name).read_bytes(), file.read_bytes(), file.name)
        self.assertEqual((self.path / "mine.png").read_bytes(), picture.read_bytes())
        self.assertEqual(result.warnings, [])

    def test_several_views_and_depth_images_same_as_the_command(self):
        text = command("segment", *self.files, "--json", "-q")
        result = ss.segment(self.files)
        self.assertIn(2, [entry["views"] for entry in self.compare(result, text)])
        views = [ss.read_depth(file) for file in self.files]
        images = ss.segment([image for image, _ in views], camera_pose=[T_W_C for _, T_W_C in views])
        for mine, theirs, (image, _) in zip(images.labels, result.labels, views):
            self.assertEqual(mine.shape, image.z.shape)
            np.testing.assert_array_equal(mine, theirs)
        self.assertEqual(len(images.labels), 2)
        self.assertIsNone(ss.segment(views[0][0]).objects[0].p_W_middle)
        with self.assertRaises(ss.InvalidArgument):
            ss.segment([image for image, _ in views])

    def test_arguments_are_those_of_the_command(self):
        cloud = self.path / "0.1" / "cloud.ply"
        text = command("segment", cloud, "--min-width", 0.06, "--usual-size", 0.1, "--farthest", 1.5, "--json", "-q",
                       codes=(0, 4))
        result = ss.segment(cloud, min_width=0.06, usual_size=0.1, farthest=1.5)
        self.assertEqual(result.json(), text)
        self.assertNotEqual(ss.segment(cloud).json(), text)
        self.assertGreater(len(result.warnings), 0)  # larger than usual
        for wrong in ({"min_width": 0}, {"usual_size": 9}, {"farthest": 0.1}, {"min_width": float("nan")}):
            with self.assertRaises(ss.InvalidArgument):
                ss.segment(cloud, **wrong)
        with self.assertRaises(ss.FileError):
            ss.segment("/nowhere.ply")
        with self.assertRaises(ss.InvalidArgument):
            ss.segment([])

    def test_nothing_on_a_table_has_a_note(self):
        flat = ss.segment(ss.DepthImage(np.full((240, 320), 0.7, np.float32), 300, 300, 160, 120))
        self.assertEqual(len(flat), 0)
        self.assertIn("nothing stands on the table", flat.note)
        np.testing.assert_allclose(flat.table_C.normal, [0, 0, -1], atol=1e-3)
        empty = ss.segment(ss.DepthImage(np.zeros((240, 320), np.float32), 300, 300, 160, 120))
        self.assertEqual((len(empty), empty.table_C, empty.T_W_C), (0, None, None))
        self.assertNotEqual(empty.note, "")


class Search(Case):
    names = ["limestone_1", "limestone_2"]

    def test_search_and_check_same_as_the_command(self):
        text = command("search", "--stones", ",".join(self.names), "--levels", 2, "--json", "-q", "--seed", 2,
                       "--set", "search.friction=0.4")
        found = ss.search(stones=self.names, levels=2, seed=2, options={"search.friction": 0.4})
        self.assertEqual(found.json(), text)
        listed = json.loads(text)["placements"]
        self.assertEqual(len(found.placements), len(listed))
        self.assertGreater(len(listed), 0)
        for placement, entry in zip(found.placements, listed):
            self.assertEqual((placement.stone, placement.cost, placement.terms),
                             (entry["stone"], entry["cost"], entry["terms"]))
            self.same_pose(placement.T_W_O, entry["T_W_O"])
        tower = str(self.path / "tower.yaml")
        found.write_scene(tower)
        checked = ss.check(tower, friction=0.4, seconds=2)
        text = command("check", tower, "--friction", 0.4, "--seconds", 2, "--json", "-q", codes=(0, 5))
        self.assertEqual(checked.json(), text)
        entry = json.loads(text)
        self.assertEqual(checked.stands, entry["stands"])
        self.assertEqual(checked.margin, entry["margin_g"])
        self.assertEqual(checked.T_W_O.shape, (len(listed), 4, 4))
        self.assertEqual(checked.contacts_W.shape[1], 3)


class Wall(Case):
    def compare(self, metrics, entry):
        for name, unit in (("placed", ""), ("asked", ""), ("length", "_m"), ("height", "_m"), ("width", "_m"),
                           ("fill", ""), ("face", ""), ("joints", ""), ("open_joints", ""), ("flatness", "_m"),
                           ("margin", "_g")):
            self.assertEqual(getattr(metrics, name), entry[name + unit], name)

    def planned_as_by_the_command(self, wall, **arguments):
        options = [f"--set={name}={value}" for name, value in arguments.get("options", {}).items()]
        text = command("search", "--stones", "all", "--wall", wall, "--json", "-q", "--seed", 2, *options)
        found = ss.search(stones="all", wall=wall, seed=2, **arguments)
        mine, theirs = json.loads(found.json()), json.loads(text)
        mine["wall"].pop("seconds"), theirs["wall"].pop("seconds")  # of the host
        self.assertEqual(mine, theirs)
        self.compare(found.wall, theirs["wall"])
        self.assertEqual(len(found.placements), found.wall.placed)
        for placement, entry, place in zip(found.placements, theirs["placements"], theirs["wall"]["stones"]):
            self.assertEqual((placement.stone, placement.cost), (entry["stone"], entry["cost"]))
            self.assertEqual((placement.course, placement.supports), (place["course"], place["supports"]))
            self.same_pose(placement.T_W_O, entry["T_W_O"])
        return found

    def test_search_and_check_same_as_the_command(self):
        found = self.planned_as_by_the_command("2+1", options={"search.friction": 0.4})
        self.assertEqual([p.course for p in found.placements], [0, 0, 1])
        self.assertEqual(found.placements[0].supports, [])
        self.assertEqual(sorted(found.placements[2].supports), [0, 1])
        wall = str(self.path / "wall.yaml")
        found.write_scene(wall)
        text = command("check", wall, "--friction", 0.4, "--seconds", 2, "--json", "-q", codes=(0, 5))
        self.assertEqual(ss.check(wall, friction=0.4, seconds=2).json(), text)
        self.assertTrue(json.loads(text)["wall"])
        tower = ss.search(stones="limestone_1")
        self.assertIsNone(tower.wall)
        self.assertIsNone(tower.T_W_V)
        self.assertEqual((tower.placements[0].course, tower.placements[0].supports), (None, []))

    def test_target_files_say_where_it_stands(self):
        target = self.path / "target.yaml"
        target.write_text("schema: stonestack.target/1\nwall: {courses: [2]}\ncentre: {x: 0.6, y: 0.2}\nyaw_deg: 90\n")
        found = self.planned_as_by_the_command(target)
        self.assertEqual(found.T_W_V.shape, (4, 4))
        np.testing.assert_allclose(found.T_W_V[:3, :3], [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-12)
        np.testing.assert_allclose(found.T_W_V[[0, 2], 3], [0.6, 0.0], atol=1e-12)

    def test_walls_that_cannot_be_are_refused(self):
        for wrong in ({"wall": "3+x"}, {"wall": "2+1", "levels": 2},
                      {"wall": "2+1", "options": {"search.method": "paper"}}):
            with self.assertRaises(ss.InvalidArgument):
                ss.search(stones="all", **wrong)
        with self.assertRaises(ss.FileError):
            ss.search(stones="all", wall="/nowhere.yaml")
        with self.assertRaises(ss.InvalidArgument):
            ss.run(wall="3+x", out=str(self.path / "refused"))
        self.assertFalse((self.path / "refused").exists())

    def test_ctrl_c_ends_a_plan_and_the_next_is_whole(self):
        before = ss.search(stones="all", wall="2+1").placements
        threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            ss.search(stones="all", wall="3+2+1", options={"search.friction": 0.05})
        after = ss.search(stones="all", wall="2+1").placements
        self.assertEqual([(p.stone, p.T_W_O.tolist()) for p in after], [(p.stone, p.T_W_O.tolist()) for p in before])

    def test_run_same_as_the_command(self):
        text = command("run", "--per-run", 3, "--wall", "2+1", "--seed", 1, "--out", self.path / "command", "--json",
                       "-q", codes=(0, 5))
        run = ss.run(seed=1, per_run=3, wall="2+1", out=str(self.path / "module"))
        self.same_run(run, text)
        self.compare(run.wall, json.loads(text)["wall"])
        self.assertEqual(run.wall.placed, run.height)
        self.assertGreater(run.height, 0)


class Plan(Case):
    def test_same_as_the_command(self):
        scene = ss.render(str(self.path / "scene"), seed=3, stones="limestone_1")
        file = str(self.path / "scene" / "scene.yaml")
        target = scene.stones[0][1]
        target[:2, 3] = 0.7, 0.28
        target[2, 3] += 0.001
        target_text = self.path / "target.json"
        quaternion = json.loads(command("render", "--out", self.path / "x", "--seed", 3, "--stones", "limestone_1",
                                        "--json", "-q"))["stones"][0]["T_W_O"]
        pose = {**quaternion, "x": 0.7, "y": 0.28, "z": target[2, 3]}
        target_text.write_text(json.dumps({"placements": [{"stone": "limestone_1", "T_W_O": pose}]}))
        text = command("plan", file, "--search", target_text, "--json", "-q")
        planned = ss.plan(file, search=str(target_text))
        self.assertTrue(planned.planned, planned.reason)
        self.assertEqual(planned.json(), text)
        entry = json.loads(text)
        for step, listed in zip(planned.steps, entry["steps"]):
            self.assertEqual(step.time.tolist(), [point["t"] for point in listed["trajectory"]])
            if listed["trajectory"]:
                self.assertEqual(step.q.tolist(), [point["q"] for point in listed["trajectory"]])
        self.assertEqual(planned.seconds, entry["seconds"])
        gripper = {"gripper.hand": "robotiq-2f-140"}
        text = command("plan", file, "--search", target_text, "--json", "-q", "--set",
                       "gripper.hand=robotiq-2f-140", codes=(0, 6))
        self.assertEqual(ss.plan(file, search=str(target_text), options=gripper).json(), text)
        self.assertNotEqual(planned.json(), text)
        away = target.copy()
        away[0, 3] = 9.0
        refused = ss.plan(file, stone="limestone_1", target=away)
        self.assertFalse(refused.planned)
        self.assertNotEqual(refused.reason, "")


class Run(Case):
    def test_same_as_the_command(self):
        text = command("run", "--per-run", 1, "--seed", 1, "--out", self.path / "command", "--json", "-q")
        run = ss.run(seed=1, per_run=1, out=str(self.path / "module"))
        theirs = self.same_run(run, text)
        self.assertEqual(run.height, 1)
        self.assertIsNone(run.wall)
        self.same_pose(run.placements[0].T_W_O_measured, theirs["placements"][0]["T_W_O_measured"])
        self.assertEqual(run.q.shape, (len(run.time), 6))
        self.assertTrue((np.diff(run.time) >= 0).all())
        self.assertTrue((pathlib.Path(run.folder) / "report.html").exists())
        with self.assertRaises(ss.InvalidArgument):
            ss.run(seed=1, per_run=1, out=run.folder)

    def test_ctrl_c_ends_it_and_the_next_call_works(self):
        journal = self.path / "stopped" / "journal.jsonl"

        def press_once_it_moves():
            while not journal.exists() or '"step"' not in journal.read_text():
                time.sleep(0.02)
            os.kill(os.getpid(), signal.SIGINT)

        threading.Thread(target=press_once_it_moves, daemon=True).start()
        with self.assertRaises(KeyboardInterrupt):
            ss.run(seed=2, per_run=4, out=str(journal.parent))
        self.assertIn('"interrupted"', journal.read_text())
        self.assertEqual(len(ss.read_catalogue()), 6)
        self.assertEqual(len(ss.search(stones="limestone_1").placements), 1)

    def test_other_threads_go_on_during_a_call(self):
        turns = []
        done = threading.Event()

        def count():
            while not done.is_set():
                turns.append(time.monotonic())
                time.sleep(0.001)

        thread = threading.Thread(target=count)
        thread.start()
        before = len(turns)
        ss.search(stones=["limestone_1", "limestone_2"])
        after = len(turns)
        done.set()
        thread.join()
        self.assertGreater(after - before, 20)  # with Python's lock held it would be none


class Arch(Case):
    def test_example_writes_an_arch_that_stands_and_slides(self):
        script = pathlib.Path(__file__).parents[2] / "examples" / "python" / "make_arch.py"
        arch = self.path / "arch.json"
        subprocess.run([sys.executable, "-B", script, arch], check=True, capture_output=True)
        stands = json.loads(command("check", arch, "--friction", 0.6, "--json", "-q"))
        self.assertEqual(len(stands["blocks"]), 15)
        self.assertEqual([b["name"] for b in stands["blocks"] if b["support"]], ["0", "14"])
        wedge = 0.5 * (1.25**2 - 1.0) * np.sin(np.pi / 15) * 0.5
        for block in stands["blocks"]:
            self.assertAlmostEqual(block["volume"], wedge, places=9)
        self.assertTrue(stands["stands"])
        command("check", arch, "--friction", 0.15, "--json", "-q", codes=(5,))


if __name__ == "__main__":
    unittest.main()
