"""examples/python/serve_depth.py as the camera of a cell that `stonestack record` reads."""
import json
import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import textwrap
import threading
import time
import unittest

import numpy as np
from PIL import Image

SERVER = pathlib.Path(__file__).parents[2] / "examples/python/serve_depth.py"
ROS = {  # the part of ROS 2 that the example uses, with a camera that never rests
    "rclpy/__init__.py": """
        import threading, time
        from sensor_msgs.msg import CameraInfo, Image
        def init(): pass
        class Node:
            def __init__(self): self.takers = {}
            def create_subscription(self, kind, topic, taker, qos): self.takers[kind, topic] = taker
        def create_node(name): return Node()
        def spin(node):
            for k in range(10000):
                time.sleep(0.02)
                node.takers[CameraInfo, '/cam/depth/camera_info'](CameraInfo())
                node.takers[Image, '/cam/depth/image_raw'](Image(k))
        """,
    "rclpy/qos.py": "qos_profile_sensor_data = None",
    "sensor_msgs/__init__.py": "",
    "sensor_msgs/msg.py": """
        import types
        import numpy as np
        class CameraInfo:
            k = [500.0, 0, 31.5, 0, 510.0, 23.5, 0, 0, 1]
            d = [0.1, 0.02, 0.001, 0.002, 0.003]
        class Image:
            encoding, is_bigendian, width, height, step = '32FC1', 0, 64, 48, 264
            def __init__(self, k):
                z = np.full((48, 66), 0.5, np.float32)
                z[:, 64:] = 9.0  # padding
                z[0, :3] = np.nan, 0.7, 1e9
                z[1, 1] += 0.001 * (k % 50)
                self.data = z.tobytes()
                self.header = types.SimpleNamespace(stamp=types.SimpleNamespace(sec=100 + k, nanosec=5))
        """,
}


class ServeDepth(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def serve(self, *arguments, **environment):
        self.errors = self.folder / "errors"
        with self.errors.open("w") as errors:
            server = subprocess.Popen([sys.executable, "-B", str(SERVER), *arguments], stdout=subprocess.PIPE,
                                      stderr=errors, text=True, env={**os.environ, **environment})
        self.addCleanup(server.stdout.close)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        return server.stdout.readline().rsplit(":", 1)[1].strip()

    def record(self, port):
        """Depths in metres of each recorded image, and the first image's camera matrix."""
        (self.folder / "cell.yaml").write_text(
            f"camera: {{driver: stream, stream: {{address: 127.0.0.1, port: {port}}}}}\n")
        out = self.folder / "recording"
        done = subprocess.run([os.environ["STONESTACK"], "record", "--cell", str(self.folder / "cell.yaml"), "--set",
                               "arm.address=", "--frames", "3", "--out", str(out)], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        cameras = json.loads(next(out.rglob("scene_camera.json")).read_text())
        images = sorted(out.rglob("depth/*.png"))
        self.assertEqual(len(images), 3)
        return [np.asarray(Image.open(f)) * cameras[str(int(f.stem))]["depth_scale"] / 1000 for f in images], cameras["0"]

    def test_a_folder_into_which_files_are_written(self):
        frames = self.folder / "frames"
        frames.mkdir()
        Image.fromarray(np.full((48, 64), 999, np.uint16)).save(frames / "old.png")
        os.utime(frames / "old.png", (1e9, 1e9))
        (frames / "note.txt").write_text("no image")
        stop = threading.Event()

        def write():
            for k in range(1000):
                z = np.full((48, 64), 2000, np.uint16)
                z[0, 0], z[1, 1] = 0, 2000 + k
                part = self.folder / "part.png"
                Image.fromarray(z).save(part)
                part.rename(frames / f"{k:04}.png")
                if stop.wait(0.05):
                    return

        writer = threading.Thread(target=write)
        self.addCleanup(writer.join)
        self.addCleanup(stop.set)
        port = self.serve("--folder", str(frames), "--camera", "500,510,31.5,23.5", "--depth-unit", "0.00025")
        writer.start()
        images, camera = self.record(port)
        for z in images:
            self.assertEqual(z[0, 0], 0)
            self.assertAlmostEqual(z[5, 5], 0.5, places=5)
        self.assertLess(images[0][1, 1], images[1][1, 1], "each is newer than the one before")
        self.assertEqual([camera["cam_K"][i] for i in (0, 4, 2, 5)], [500, 510, 31.5, 23.5])

    def test_a_ros_2_topic(self):
        for name, text in ROS.items():
            file = self.folder / "ros" / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(textwrap.dedent(text))
        port = self.serve("--topic", "/cam/depth/image_raw", PYTHONPATH=str(self.folder / "ros"))
        images, camera = self.record(port)
        z = images[0]
        self.assertEqual(z.shape, (48, 64))
        self.assertEqual([round(v, 4) for v in z[0, :4]], [0, 0.7, 0, 0.5])
        self.assertAlmostEqual(z.max(), 0.7, places=4, msg="padding is no image")
        self.assertEqual([camera["cam_K"][i] for i in (0, 4, 2, 5)], [500, 510, 31.5, 23.5])

    def test_a_lens_or_a_folder_that_is_not_there(self):
        lens = ["--camera", "500,510,31.5,23.5", "--depth-unit", "0.001"]
        for more, problem in (([], "--camera fx,fy,cx,cy and --depth-unit"), (lens, "frames: no such folder")):
            done = subprocess.run([sys.executable, "-B", str(SERVER), "--folder", "frames", *more], capture_output=True,
                                  text=True, cwd=self.folder)
            self.assertEqual(done.returncode, 2)
            self.assertIn(problem, done.stderr)

    def test_what_is_no_depth_image_is_named(self):
        frames = self.folder / "frames"
        frames.mkdir()
        colour, grey = np.zeros((48, 64, 3), np.uint8), np.zeros((48, 64), np.uint8)
        port = self.serve("--folder", str(frames), "--camera", "500,510,31.5,23.5", "--depth-unit", "0.001")
        for name, image in (("colour.png", colour), ("grey.png", grey)):
            with socket.create_connection(("127.0.0.1", int(port)), timeout=5) as client:
                client.sendall(b"capture\n")
                time.sleep(0.1)
                Image.fromarray(image).save(frames / name)
                self.assertEqual(client.recv(1), b"", "no frame")
            self.assertIn(f"{name}: no 16-bit depth image", self.errors.read_text())
            (frames / name).unlink()
        with socket.create_connection(("127.0.0.1", int(port)), timeout=5) as client:
            client.sendall(b"GET / HTTP/1.1\n")
            self.assertEqual(client.recv(1), b"")
        self.assertIn("a client asked for b'GET", self.errors.read_text())

    def test_nothing_that_is_new_is_no_frame(self):
        Image.fromarray(np.full((48, 64), 999, np.uint16)).save(self.folder / "old.png")
        os.utime(self.folder / "old.png", (time.time() - 60, time.time() - 60))
        port = self.serve("--folder", str(self.folder), "--camera", "500,510,31.5,23.5", "--depth-unit", "0.001")
        (self.folder / "cell.yaml").write_text(
            f"camera: {{driver: stream, stream: {{address: 127.0.0.1, port: {port}, frame_timeout: 0.5}}}}\n")
        done = subprocess.run([os.environ["STONESTACK"], "record", "--cell", str(self.folder / "cell.yaml"), "--set",
                               "arm.address=", "--out", str(self.folder / "none")], capture_output=True, text=True)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("no frame within 0.5 s", done.stderr)


if __name__ == "__main__":
    unittest.main()
